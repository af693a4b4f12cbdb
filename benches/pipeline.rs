//! Speed of the discrete-event engine: events a second on one thread, for a queue that any simulator
//! can run (M/M/1), for the gaze-to-photon chain, and for the Monte Carlo latency study.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use foveasim::models::{FixedCost, GazeDirection, Nanos, Role, Stream, math, presets};
use foveasim::pipeline::{
    Calendar, Displayed, GazeInput, Missed, Pipeline, Recorder, Runtime, Setup, Sink, SyncMode,
};
use foveasim::study::LatencyStudy;

/// Customers arrive at random, wait for the one server and are served for a random time; `n` events.
/// Returns the time simulated and how many are left waiting.
fn mm1(n: u64) -> (Nanos, u64) {
    #[derive(Clone, Copy)]
    enum Event {
        Arrival,
        Departure,
    }
    let mut stream = Stream::new(1, Role::Phase, 0);
    let mut after = |mean_ns: f64| Nanos((-math::log(1.0 - stream.uniform()) * mean_ns) as i64);
    let (arrive, serve) = (1e6, 0.8e6);
    let mut calendar = Calendar::new(Nanos::ZERO);
    let mut waiting = 0u64;
    calendar.schedule(after(arrive), 0, Event::Arrival);
    while calendar.happened() < n {
        let Some(event) = calendar.next() else { break };
        let now = calendar.now();
        match event {
            Event::Arrival => {
                waiting += 1;
                calendar.schedule(now + after(arrive), 0, Event::Arrival);
                if waiting == 1 {
                    calendar.schedule(now + after(serve), 1, Event::Departure);
                }
            }
            Event::Departure => {
                waiting -= 1;
                if waiting > 0 {
                    calendar.schedule(now + after(serve), 1, Event::Departure);
                }
            }
        }
    }
    (calendar.now(), waiting)
}

/// Looks at every scan, and keeps nothing.
#[derive(Default)]
struct Count(u64);

impl Sink for Count {
    fn displayed(&mut self, scan: &Displayed) -> std::ops::ControlFlow<()> {
        self.0 += scan.segments.len() as u64;
        std::ops::ControlFlow::Continue(())
    }
}

fn benches(c: &mut Criterion) {
    let mut group = c.benchmark_group("pipeline");
    group.sample_size(20);

    group.throughput(Throughput::Elements(1_000_000));
    group.bench_function("mm1_events", |b| b.iter(|| mm1(black_box(1_000_000))));

    let display = presets::display("lg-w2363d").expect("a preset");
    let tracker = presets::tracker("tx300").expect("a preset");
    for sync in SyncMode::ALL {
        let cost = FixedCost(Nanos::from_ms(8.0));
        let mut setup = Setup::new(display.scan, display.response, &tracker, sync, &cost);
        setup.gaze = GazeInput::Constant(GazeDirection::AHEAD);
        let mut pipeline = Pipeline::new();
        let mut run = || {
            let end = Nanos(100_000_000_000);
            pipeline.run(black_box(&setup), Nanos::ZERO, end, &mut Count::default())
        };
        group.throughput(Throughput::Elements(run().events));
        group.bench_function(format!("chain_events_{sync}"), |b| b.iter(&mut run));
    }

    // All that happens is kept, with a compositor, late latches and a warp for every refresh.
    let cost = FixedCost(Nanos::from_ms(7.0));
    let mut setup = Setup::new(
        display.scan,
        display.response,
        &tracker,
        SyncMode::Vsync,
        &cost,
    );
    setup.gaze = GazeInput::Constant(GazeDirection::AHEAD);
    setup.runtime = Runtime {
        lead: Nanos::from_ms(1.2),
        warp: Some(Nanos::from_ms(1.0)),
        missed: Missed::Reproject,
        gaze_latch: Nanos::from_ms(2.0),
        pose_latch: Nanos::from_ms(4.0),
        ..Runtime::default()
    };
    for (name, runtime) in [("vsync", Runtime::default()), ("xr", setup.runtime)] {
        let setup = Setup { runtime, ..setup };
        let mut pipeline = Pipeline::new();
        let mut run = || {
            let (end, mut recorder) = (Nanos(100_000_000_000), Recorder::default());
            let counts = pipeline.run(black_box(&setup), Nanos::ZERO, end, &mut recorder);
            (counts.events, recorder)
        };
        group.throughput(Throughput::Elements(run().0));
        group.bench_function(format!("recorded_events_{name}"), |b| b.iter(&mut run));
    }

    let study = LatencyStudy::new(display, tracker, SyncMode::Tearing, None, None)
        .expect("the study's set-up is valid");
    let mut pipeline = Pipeline::new();
    let mut runs = || {
        let run = |i| study.simulate(&mut pipeline, 1, i, study.draw(1, i)).1;
        (0..10_000).map(run).sum::<u64>()
    };
    group.throughput(Throughput::Elements(runs()));
    group.bench_function("latency_events", |b| b.iter(&mut runs));
    group.finish();
}

criterion_group!(all, benches);
criterion_main!(all);
