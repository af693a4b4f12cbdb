//! What perceptual rasterization pays: the study scene by common rasterization, and magnified, rolling, through a lens and all
//! of it, at equal sample counts; and what each bound tests, misses and takes. Prints one row for each way, times
//! and their ratios to `full` as medians of paired rounds.
//!
//! `cargo bench --bench perceptual -- --rounds 9 [--size 1920x1080] [--frame 500] [--cpu-time] [--picture FILE.pgm]
//! [--only rolling,all]`
//!
//! With `--only`, `full` and these ways, and no table of bounds.
//!
//! `--cpu-time` (Linux) takes the processor time of all threads instead of the time that passes. With `--picture`, also the
//! sample test efficiency of each sample under the conservative bound (Friston 2019, Fig. 15) as a picture: black 0, white 1.

#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a bench says what it measured"
)]

mod common;

use common::{Args, Clock, median};
use foveasim::assets::{STUDY_FRAMES, Scene, study_camera, study_scene};
use foveasim::models::foveation::{Method, Request};
use foveasim::models::{LensSpec, Pose, SamplePlan, ScanSkew, View, Viewport, presets};
use foveasim::render::{
    Bound, BoundCounts, FrameMemory, RenderOptions, bound_counts, render, render_into,
};
use glam::{DQuat, DVec2, DVec3, UVec2};

/// How fast the head turns \[deg/s\], and how long a scan takes \[s\].
const TURN: (f64, f64) = (100.0, 1.0 / 120.0);

/// A way to draw a frame.
struct Way {
    name: &'static str,
    method: &'static str,
    rolling: bool,
    lens: bool,
    bound: Option<Bound>,
}

const WAYS: [Way; 12] = [
    Way::new("full", "full"),
    Way::new("full again", "full"),
    Way::new("not magnified", "radial:1"),
    Way::new("magnified", "radial:2:boundary"),
    Way::new("rolling", "full").rolling(),
    Way::new("lens", "full").lens(),
    Way::new("magnified, rolling", "radial:2:boundary").rolling(),
    Way::new("magnified, lens", "radial:2:boundary").lens(),
    Way::new("rolling, lens", "full").rolling().lens(),
    Way::new("all", "radial:2:boundary").rolling().lens(),
    Way::new("still by moving triangles", "full").bound(Bound::Conservative),
    Way::new("magnified by moving triangles", "radial:2:boundary").bound(Bound::Conservative),
];

impl Way {
    const fn new(name: &'static str, method: &'static str) -> Self {
        Self {
            name,
            method,
            rolling: false,
            lens: false,
            bound: None,
        }
    }

    const fn rolling(self) -> Self {
        Self {
            rolling: true,
            ..self
        }
    }

    const fn lens(self) -> Self {
        Self { lens: true, ..self }
    }

    const fn bound(self, bound: Bound) -> Self {
        Self {
            bound: Some(bound),
            ..self
        }
    }
}

/// What is drawn.
struct Stage {
    scene: Scene,
    request: Request,
    frame: u32,
}

impl Stage {
    fn view(&self, way: &Way) -> View {
        let pose = study_camera(f64::from(self.frame) / f64::from(STUDY_FRAMES), 1);
        let still = View::still(self.request.eye, self.request.viewport, pose);
        let size = self.request.viewport.size;
        let spec = LensSpec {
            coefficients: [0.22, 0.12],
            centre: [0.5; 2],
            radius: 1.0,
            chromatic: [1.0; 3],
        };
        let lens = way
            .lens
            .then(|| spec.over(size).expect("a lens that grows"));
        if !way.rolling {
            return still.seen_through(lens);
        }
        let turn = DQuat::from_axis_angle(DVec3::Y, (TURN.0 * TURN.1).to_radians());
        let end = Pose::new(pose.position, (turn * pose.orientation).normalize());
        let scan = ScanSkew::new(DVec2::Y).expect("a scan");
        View::rolling(still.eye, still.optics, [pose, end], scan).seen_through(lens)
    }

    fn plan(&self, way: &Way) -> SamplePlan {
        way.method
            .parse::<Method>()
            .and_then(|method| method.plan(&self.request))
            .expect("a method of this display")
    }

    /// A frame, as a program that shows frame after frame draws it: in the memory of those before.
    fn draw(&self, way: &Way, options: &RenderOptions, memory: &mut FrameMemory) {
        let options = RenderOptions {
            bound: way.bound,
            ..*options
        };
        let (view, plan) = (self.view(way), self.plan(way));
        let frame = render_into(&self.scene, &view, &plan, &options, memory);
        memory.give(std::hint::black_box(frame.expect("a drawable plan")).image);
    }
}

fn main() {
    let args = Args::new();
    let number = |flag: &str| args.value::<u32>(flag);
    // `cargo test --benches` runs this with other arguments: something small will do.
    let (rounds, size) = match number("--rounds") {
        Some(rounds) => (rounds.max(1), args.size().unwrap_or(UVec2::new(1920, 1080))),
        None => (1, UVec2::new(160, 90)),
    };
    let display = presets::display("lg-w2363d").expect("a preset");
    let request = Request::ahead(display.primary());
    let stage = Stage {
        scene: study_scene(1),
        request: Request {
            viewport: Viewport::new(size, request.viewport.tan).expect("a size that can be drawn"),
            ..request
        },
        frame: number("--frame").unwrap_or(500),
    };
    let clock = args.clock();
    let only: Option<Vec<&str>> = args.text("--only").map(|names| names.split(',').collect());
    let wanted = |way: &&Way| {
        way.name == "full" || only.as_ref().is_none_or(|names| names.contains(&way.name))
    };
    let ways: Vec<&Way> = WAYS.iter().filter(wanted).collect();
    frames(&stage, &ways, rounds, &clock);
    if only.is_none() {
        bounds(&stage, rounds, &clock, args.text("--picture"));
    }
    eprintln!(
        "{} x {} pixels, {rounds} rounds, {} threads, {:.0} s",
        size.x,
        size.y,
        rayon::current_num_threads(),
        clock.passed().as_secs_f64()
    );
}

/// Whole frames of every way.
fn frames(stage: &Stage, ways: &[&Way], rounds: u32, clock: &Clock) {
    let options = RenderOptions::default();
    let mut times = vec![Vec::new(); ways.len()];
    // The first frames touch memory for the first time.
    let mut memory: Vec<FrameMemory> = ways.iter().map(|_| FrameMemory::default()).collect();
    for (way, memory) in ways.iter().zip(&mut memory) {
        stage.draw(way, &options, memory);
    }
    for _ in 0..rounds {
        for ((way, times), memory) in ways.iter().zip(&mut times).zip(&mut memory) {
            let start = clock.now();
            stage.draw(way, &options, memory);
            times.push((clock.now() - start).as_secs_f64());
        }
    }
    println!("way,samples,frame_ms,over_full,efficiency");
    for (k, way) in ways.iter().enumerate() {
        let ratios = times[k].iter().zip(&times[0]).map(|(a, b)| a / b).collect();
        let options = RenderOptions {
            bound: way.bound,
            ..options
        };
        let plan = stage.plan(way);
        let frame = render(&stage.scene, &stage.view(way), &plan, &options).expect("drawable");
        println!(
            "\"{}\",{},{:.2},{:.3},{:.3}",
            way.name,
            plan.count().samples(),
            1e3 * median(times[k].clone()),
            median(ratios),
            frame.work.samples_covered as f64 / frame.work.samples_tested.max(1) as f64,
        );
    }
}

/// What each bound tests and misses, nothing hidden left out, and what a frame takes with it.
fn bounds(stage: &Stage, rounds: u32, clock: &Clock, picture: Option<&str>) {
    println!("way,bound,tested,covered,efficiency,missed,frame_ms");
    for base in [
        Way::new("magnified", "radial:2:boundary"),
        Way::new("rolling", "full").rolling(),
        Way::new("magnified, rolling", "radial:2:boundary").rolling(),
        Way::new("all", "radial:2:boundary").rolling().lens(),
    ] {
        let (view, plan) = (stage.view(&base), stage.plan(&base));
        let options = RenderOptions::default();
        let counts =
            |bound| bound_counts(&stage.scene, &view, &plan, 0, bound, &options).expect("drawable");
        let ours = counts(Bound::Conservative);
        if let Some(file) = picture.filter(|_| base.lens) {
            std::fs::write(file, efficiencies(&ours)).expect("a writable file");
        }
        for bound in [
            Bound::Box,
            Bound::Simple,
            Bound::Adaptive,
            Bound::Conservative,
        ] {
            let found = counts(bound);
            let way = Way {
                bound: Some(bound),
                ..base
            };
            // The published ones take seconds.
            let rounds = if bound == Bound::Conservative {
                rounds
            } else {
                1
            };
            let mut memory = FrameMemory::default();
            let times = (0..rounds).map(|_| {
                let start = clock.now();
                stage.draw(&way, &options, &mut memory);
                (clock.now() - start).as_secs_f64()
            });
            println!(
                "\"{}\",{},{},{},{:.3},{},{:.1}",
                base.name,
                bound.name(),
                found.work.samples_tested,
                found.work.samples_covered,
                found.efficiency(),
                ours.work.samples_covered - found.work.samples_covered,
                1e3 * median(times.collect()),
            );
        }
    }
}

/// Covered over tested of each sample, as a portable greymap.
fn efficiencies(counts: &BoundCounts) -> Vec<u8> {
    let mut file = format!("P5\n{} {}\n255\n", counts.lattice.x, counts.lattice.y).into_bytes();
    let samples = counts.tested.iter().zip(&counts.covered);
    file.extend(samples.map(|(tested, covered)| (255 * covered / (*tested).max(1)) as u8));
    file
}
