//! What kernel foveated rendering and eye dominance pay in time (Meng 2020): the study scene for two eyes,
//! 1280×1440 each, by full resolution and by kernels in both forms. Prints one row for each way: samples, whole
//! frame, shading, the rest, and speedups over full resolution (sums over moments of medians over rounds), with the
//! noise floor beside them.
//!
//! `cargo bench --bench kernel -- --moments 4 --rounds 7 [--size 1280x1440] [--cpu-time] [--errors FILE]`
//!
//! `--cpu-time` (Linux) takes the processor time of all threads instead of the time that passes: on a machine that
//! does other things, too, it is far less noisy. With one thread (`RAYON_NUM_THREADS=1`) the two mean the same.
//!
//! With `--errors`, also the error against 8 × 8 samples to the pixel by ring of eccentricity, as CSV, and
//! a plot beside it (`.svg`).

#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a bench says what it measured"
)]

use std::path::Path;

mod common;

use common::Args;

use foveasim::study::{KernelErrors, KernelTimes};
use glam::UVec2;

fn main() {
    let args = Args::new();
    let number = |flag: &str| args.value::<u32>(flag);
    // `cargo test --benches` runs this with other arguments: something small will do.
    let quick = KernelTimes::quick();
    let full_size = UVec2::new(1280, 1440);
    let study = match number("--moments") {
        Some(moments) => KernelTimes {
            moments,
            rounds: number("--rounds").unwrap_or(5),
            size: args.size().unwrap_or(full_size),
            ..quick
        },
        None => quick,
    };
    let clock = args.clock();
    let timings = study
        .run(&mut || clock.now(), &|_, _| ())
        .expect("a size and moments that can be drawn");
    print!("{}", timings.table().csv());
    for form in ["", ":published"] {
        let row = |method: &str| timings.row(&format!("{method}{form}"));
        if let (Some(kernel), Some(both)) = (row("kfr:2:4"), row("efr:2:3")) {
            println!(
                "efr:2:3 over kfr:2:4{form}: shading {:.4}, frame {:.4}; Eq. 9 has 1.3846",
                both.shading_speedup / kernel.shading_speedup,
                both.speedup / kernel.speedup
            );
        }
    }
    if let Some(file) = args.text("--errors") {
        let errors = KernelErrors {
            size: study.size,
            moments: study.moments,
            reference_samples: 8,
            seed: study.seed,
        };
        let rows = errors.run(&|_, _| ()).expect("images that can be drawn");
        let chart = KernelErrors::chart(&rows).svg();
        std::fs::write(file, KernelErrors::table(&rows).csv()).expect("a writable file");
        std::fs::write(Path::new(file).with_extension("svg"), chart).expect("a writable file");
    }
    let threads = rayon::current_num_threads();
    eprintln!(
        "{} x {} pixels for each eye, {} moments, {} rounds, {threads} threads, {:.0} s",
        study.size.x,
        study.size.y,
        study.moments,
        study.rounds,
        clock.passed().as_secs_f64()
    );
}
