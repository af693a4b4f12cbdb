//! What masks take: building one of 2048² with about 120,000 rays, writing, loading, placing it and putting an image together
//! from it. Prints one row for each.
//!
//! `cargo bench --bench mask -- --size 1024 --fraction 0.1144 [--density mar|gaussian] [--rounds 5] [--cpu-time]`
//!
//! With `--volume jet:256 [--cameras 3] [--gazes 2] [--frames 3]`, also foveated rendering of that volume through the mask
//! against full: the rows of `foveasim reproduce bruder2019`.
//!
//! `--cpu-time` (Linux) takes the processor time of all threads instead of the time that passes: on a machine that
//! does other things, too, it is far less noisy. With one thread (`RAYON_NUM_THREADS=1`) the two mean the same.

#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a bench says what it measured"
)]

use std::time::Duration;

mod common;

use common::Args;

use foveasim::assets::{TransferFunction, volume_named};
use foveasim::mask::{Interpolation, Mask, MaskSpec, PlacedMask};
use foveasim::models::{Acuity, RayDensity};
use foveasim::study::{Bruder2019, BruderMasks, BruderVolume};
use glam::{DVec2, UVec2};

fn main() {
    let args = Args::new();
    let number = |flag: &str| args.value::<u32>(flag);
    // `cargo test --benches` runs this with other arguments: something small will do.
    let size = UVec2::splat(number("--size").unwrap_or(64));
    let fraction = args.value("--fraction");
    let fraction = fraction.unwrap_or(0.1144);
    let gaussian = RayDensity::gaussian_of_fraction(fraction, size.as_dvec2()).expect("a fraction");
    let density = match args.text("--density") {
        Some("mar") => {
            let viewport = Bruder2019::viewport(size).expect("a size");
            let found = RayDensity::mar_of_fraction(fraction, Acuity::default(), &viewport);
            found.expect("a fraction").0
        }
        _ => gaussian,
    };
    let clock = args.clock();
    let spec = MaskSpec::new(size, density, 1);
    let mask = parts(&spec, number("--rounds").unwrap_or(1), &mut || clock.now());
    if let Some(name) = args.text("--volume") {
        let asked = Bruder2019 {
            cameras: number("--cameras").unwrap_or(3),
            gazes: number("--gazes").unwrap_or(2),
            frames: number("--frames").unwrap_or(3),
            ..Bruder2019::default()
        };
        against_full(&asked, name, mask, gaussian, &mut || clock.now());
    }
    let threads = rayon::current_num_threads();
    eprintln!("{} x {} pixels, {threads} threads", size.x, size.y);
}

/// Times each part; gives the mask.
fn parts(spec: &MaskSpec, rounds: u32, clock: &mut dyn FnMut() -> Duration) -> Mask {
    let folder = tempfile::tempdir().expect("a folder for the mask");
    let file = folder.path().join("mask.bin");
    println!("round,part,ms");
    let mut built = None;
    for round in 0..rounds.max(1) {
        let row = |what: &str, from: Duration, to: Duration| {
            println!("{round},{what},{:.3}", (to - from).as_secs_f64() * 1e3);
        };
        let began = clock();
        let mask = Mask::build(spec, &|_| {}).expect("a mask");
        let end = clock();
        row("build", began, end);
        mask.save(&file).expect("a file");
        let saved = clock();
        row("save", end, saved);
        let loaded = Mask::load(&file, spec).expect("what was just written");
        let end = clock();
        row("load", saved, end);
        assert!(loaded == mask, "what is loaded is what was saved");
        let began = clock();
        let placed = PlacedMask::new(&mask, spec.display_px.as_dvec2() / 2.0);
        let end = clock();
        row("place", began, end);
        let value = |k: usize| {
            let DVec2 { x, y } = placed.position(k);
            [x as f32, y as f32, 0.5, 1.0]
        };
        let values: Vec<[f32; 4]> = (0..placed.rays()).map(value).collect();
        let mut pixels = vec![[0.0; 4]; spec.display_px.element_product() as usize];
        for _ in 0..3 {
            let began = clock();
            placed
                .reconstruct(&values, &mut pixels)
                .expect("a value for each ray");
            let end = clock();
            row("reconstruct", began, end);
        }
        eprintln!(
            "{} rays, {} weights in {:.1} MiB",
            mask.sites().len(),
            mask.weights().entries(),
            mask.weights().bytes() as f64 / f64::from(1 << 20)
        );
        built = Some(mask);
    }
    built.expect("at least one round")
}

fn against_full(
    asked: &Bruder2019,
    name: &str,
    natural: Mask,
    gaussian: RayDensity,
    clock: &mut dyn FnMut() -> Duration,
) {
    let spec = *natural.spec();
    let build = |density, interpolation| {
        let spec = MaskSpec {
            density,
            interpolation,
            ..spec
        };
        Mask::build(&spec, &|_| {}).expect("a mask")
    };
    let volume = volume_named(name, 1).expect("a generated volume");
    let transfer = TransferFunction::of_volume(&volume);
    let volume = BruderVolume {
        name: name.to_owned(),
        volume,
        transfer,
    };
    let masks = BruderMasks {
        masks: [
            build(spec.density, Interpolation::Nearest),
            build(spec.density, Interpolation::Barycentric),
            natural,
        ],
        gaussian: build(gaussian, Interpolation::Natural),
    };
    let found = asked.run(&[volume], &masks, clock, &|_, _| ());
    let found = found.expect("counts that can be measured");
    print!("{}{}", found.table_1().csv(), found.errors().csv());
}
