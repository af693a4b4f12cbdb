//! What foveation pays in time: the study scene at 1920×1080 by full resolution and by three and four
//! layers, with 4× MSAA, jitter and reprojection, layers in every frame and in turns. Prints one row for
//! each: samples, whole frame, fixed part, what a sample costs, and speedup over sample ratio with and
//! without the fixed part. Guenter et al. 2012 got 0.43 (quality A) and 0.49 (B) of their pixel ratio
//! as whole-frame speedup (Table 1 and §6).
//!
//! `cargo bench --bench foveation -- --moments 8 [--size 1920x1080] [--raw FILE]`

#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a bench says what it measured"
)]

use std::time::Instant;

use foveasim::study::Guenter2012;
use glam::UVec2;

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let value = |flag: &str| {
        args.iter()
            .position(|a| a == flag)
            .and_then(|i| args.get(i + 1))
    };
    let size = value("--size").and_then(|text| {
        let (width, height) = text.split_once('x')?;
        Some(UVec2::new(width.parse().ok()?, height.parse().ok()?))
    });
    // `cargo test --benches` runs this with other arguments: something small will do.
    let quick = Guenter2012::quick();
    let study = match value("--moments").and_then(|n| n.parse().ok()) {
        Some(moments) => Guenter2012 {
            moments,
            size: size.unwrap_or(UVec2::new(1920, 1080)),
            ..quick
        },
        None => quick,
    };
    let began = Instant::now();
    let payoff = study
        .payoff(&mut || began.elapsed(), &|_, _| ())
        .expect("a size and moments that can be drawn");
    print!("{}", payoff.table().csv());
    if let Some(file) = value("--raw") {
        std::fs::write(file, payoff.raw_table().csv()).expect("a writable file");
    }
    let threads = rayon::current_num_threads();
    eprintln!(
        "{} x {} pixels, {} moments, {threads} threads, {:.0} s",
        study.size.x,
        study.size.y,
        study.moments,
        began.elapsed().as_secs_f64()
    );
}
