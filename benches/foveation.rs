//! What foveation pays in time: the study scene at 1920×1080 by full resolution and by three and four
//! layers, with 4× MSAA, jitter and reprojection, layers in every frame and in turns. Prints one row for
//! each: samples, whole frame, fixed part, what a sample costs, and speedup over sample ratio with and
//! without the fixed part. Guenter et al. 2012 got 0.43 (quality A) and 0.49 (B) of their pixel ratio
//! as whole-frame speedup (Table 1 and §6).
//!
//! `cargo bench --bench foveation -- --moments 8 [--size 1920x1080] [--cpu-time] [--raw FILE]`

#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a bench says what it measured"
)]

mod common;

use common::Args;

use foveasim::study::Guenter2012;
use glam::UVec2;

fn main() {
    let args = Args::new();
    // `cargo test --benches` runs this with other arguments: something small will do.
    let quick = Guenter2012::quick();
    let study = match args.value("--moments") {
        Some(moments) => Guenter2012 {
            moments,
            size: args.size().unwrap_or(UVec2::new(1920, 1080)),
            ..quick
        },
        None => quick,
    };
    let clock = args.clock();
    let payoff = study
        .payoff(&mut || clock.now(), &|_, _| ())
        .expect("a size and moments that can be drawn");
    print!("{}", payoff.table().csv());
    if let Some(file) = args.text("--raw") {
        std::fs::write(file, payoff.raw_table().csv()).expect("a writable file");
    }
    let threads = rayon::current_num_threads();
    eprintln!(
        "{} x {} pixels, {} moments, {threads} threads, {:.0} s",
        study.size.x,
        study.size.y,
        study.moments,
        clock.passed().as_secs_f64()
    );
}
