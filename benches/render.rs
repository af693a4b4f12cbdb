//! The study scene at 1920×1080: every method, and each thing that a frame can do without, with and
//! without it.
//!
//! `cargo bench --bench render`; one group alone: `cargo bench --bench render -- skip`

use std::hint::black_box;
use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, criterion_group, criterion_main};
use foveasim::assets::{LodRule, STUDY_FRAMES, Scene, study_camera, study_scene};
use foveasim::models::foveation::{Method, Request};
use foveasim::models::{Msaa, SamplePlan, View, presets};
use foveasim::render::{
    FrameMemory, RenderOptions, Sequence, Simd, Skip, TemporalOptions, render_into,
};

/// Frame of the fly-through: objects near and far in view.
const FRAME: u32 = 500;

struct Stage {
    scene: Scene,
    request: Request,
}

impl Stage {
    fn new() -> Self {
        let display = presets::display("lg-w2363d").expect("a preset");
        Self {
            scene: study_scene(1),
            request: Request::ahead(display.primary()),
        }
    }

    fn view(&self, frame: u32) -> View {
        let along = f64::from(frame) / f64::from(STUDY_FRAMES);
        View::still(
            self.request.eye,
            self.request.viewport,
            study_camera(along, 1),
        )
    }

    fn plan(&self, method: &str) -> SamplePlan {
        method
            .parse::<Method>()
            .and_then(|m| m.plan(&self.request))
            .expect("a method of this display")
    }

    /// One frame by itself, again and again.
    fn still(
        &self,
        group: &mut BenchmarkGroup<'_, WallTime>,
        name: String,
        plan: &SamplePlan,
        options: &RenderOptions,
    ) {
        let view = self.view(FRAME);
        group.bench_function(name, |b| {
            let mut memory = FrameMemory::default();
            b.iter(|| {
                let view = black_box(&view);
                let frame = render_into(&self.scene, view, plan, options, &mut memory);
                memory.give(frame.expect("a drawable plan").image);
            });
        });
    }

    /// Frame after frame of the fly-through.
    fn moving(
        &self,
        group: &mut BenchmarkGroup<'_, WallTime>,
        name: &str,
        plan: &SamplePlan,
        temporal: TemporalOptions,
    ) {
        let options = RenderOptions::default();
        group.bench_function(name, |b| {
            let mut sequence = Sequence::new(temporal);
            let mut frame = FRAME;
            b.iter(|| {
                let view = self.view(frame % STUDY_FRAMES);
                let drawn = sequence.draw(&self.scene, &view, plan, frame.into(), &options);
                frame += 1;
                drawn.expect("a drawable plan")
            });
        });
    }
}

fn group<'a>(c: &'a mut Criterion, name: &str) -> BenchmarkGroup<'a, WallTime> {
    let mut group = c.benchmark_group(name);
    group
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(2));
    group
}

fn methods(c: &mut Criterion) {
    let stage = Stage::new();
    let mut group = group(c, "method");
    for method in [
        "full", "layers:3", "layers:4", "vrs", "fdm", "rates", "quad",
    ] {
        let plan = stage.plan(method);
        for (positions, msaa) in [(1, Msaa::One), (4, Msaa::Four)] {
            let (plan, options) = (plan.clone().with_msaa(msaa), RenderOptions::default());
            stage.still(
                &mut group,
                format!("{method} msaa {positions}"),
                &plan,
                &options,
            );
        }
    }
    let scalar = RenderOptions {
        simd: Simd::Scalar,
        ..RenderOptions::default()
    };
    for method in ["full", "layers:3"] {
        stage.still(
            &mut group,
            format!("{method} scalar"),
            &stage.plan(method),
            &scalar,
        );
    }
}

/// All parts left out, all done, and each done alone.
fn skips(c: &mut Criterion) {
    let stage = Stage::new();
    let mut group = group(c, "skip");
    for method in ["full", "layers:3"] {
        let plan = stage.plan(method);
        let mut row = |name: &str, skip| {
            let options = RenderOptions {
                skip,
                ..RenderOptions::default()
            };
            stage.still(&mut group, format!("{method} {name}"), &plan, &options);
        };
        row("all", Skip::ALL);
        row("none", Skip::NONE);
        // What two eyes share is nothing that one has.
        for left in Skip::NAMES
            .into_iter()
            .filter(|name| *name != "repeated-for-eyes")
        {
            let others = Skip::NAMES.into_iter().filter(|name| *name != left);
            let list = others.collect::<Vec<_>>().join(",");
            let skip = list.parse().expect("names of parts");
            row(&format!("all but {left}"), skip);
        }
        // There is something to resolve only where samples have several positions.
        let plan = plan.with_msaa(Msaa::Four);
        for (name, whole_samples) in [("all", true), ("all but whole-samples", false)] {
            let options = RenderOptions {
                skip: Skip {
                    whole_samples,
                    ..Skip::ALL
                },
                ..RenderOptions::default()
            };
            stage.still(&mut group, format!("{method} msaa {name}"), &plan, &options);
        }
    }
}

fn levels_of_detail(c: &mut Criterion) {
    let stage = Stage::new();
    let mut group = group(c, "lod");
    for method in ["full", "layers:3"] {
        let plan = stage.plan(method);
        for lod in [LodRule::Finest, LodRule::Distance, LodRule::Footprint] {
            let options = RenderOptions {
                lod,
                ..RenderOptions::default()
            };
            stage.still(&mut group, format!("{method} {lod:?}"), &plan, &options);
        }
    }
}

/// Motion vectors and blending alone, with jitter, and layers in turns.
fn temporal(c: &mut Criterion) {
    let stage = Stage::new();
    let mut group = group(c, "temporal");
    let off = TemporalOptions::OFF;
    let all = TemporalOptions::default();
    for method in ["full", "layers:3"] {
        let plan = stage.plan(method).with_msaa(Msaa::Four);
        for (name, temporal) in [
            ("no history", off),
            (
                "jitter alone",
                TemporalOptions {
                    jitter: true,
                    ..off
                },
            ),
            (
                "reprojection alone",
                TemporalOptions {
                    jitter: false,
                    ..all
                },
            ),
            ("jitter and reprojection", all),
            (
                "all, in turns",
                TemporalOptions {
                    staggered: true,
                    ..all
                },
            ),
        ] {
            stage.moving(&mut group, &format!("{method} {name}"), &plan, temporal);
        }
    }
}

criterion_group!(benches, methods, skips, levels_of_detail, temporal);
criterion_main!(benches);
