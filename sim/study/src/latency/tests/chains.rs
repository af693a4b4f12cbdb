//! Chains of every kind, for tests that look at all of them.

use foveasim_models::{Durations, Emission, ScanDirection};
use foveasim_pipeline::{FrameStart, Missed};

use super::*;
use crate::{Chain, HeadSampling};

const MS: i64 = 1_000_000;

/// 100 Hz, one millisecond of blanking after the picture; 250 Hz tracker; frames of 6 ms.
pub(super) fn chain(sync: SyncMode, change: impl FnOnce(&mut Chain)) -> Chain {
    let mut display = presets::display("lg-w2363d").unwrap();
    display.scan.rate = Rate::from_hz("f", 100.0).unwrap();
    (display.scan.active_lines, display.scan.total_lines) = (9, 10);
    (display.scan.lines_to_end, display.scan.rows) = (9, 90);
    let mut tracker = presets::tracker("tx300").unwrap();
    tracker.rate = Rate::from_hz("f", 250.0).unwrap();
    let mut chain = Chain::new(display, tracker, sync);
    chain.host_rate = Rate::from_hz("f", 97.0).unwrap();
    chain.render = "6".parse().unwrap();
    change(&mut chain);
    chain
}

fn lead(ms: f64) -> impl Fn(&mut Chain) {
    move |c| c.runtime.lead = Nanos::from_ms(ms)
}

fn law(text: &'static str) -> impl Fn(&mut Chain) {
    move |c| c.render = text.parse().unwrap()
}

/// Every loop and every stage, at least once.
pub(super) fn chains() -> Vec<(&'static str, Chain)> {
    use SyncMode::{Tearing, Vsync, VsyncFree};
    let warp = |missed: Missed| {
        move |c: &mut Chain| {
            (c.runtime.lead, c.runtime.warp) = (Nanos(3 * MS), Some(Nanos(2 * MS)));
            c.runtime.missed = missed;
        }
    };
    let in_flight = |n: u32, render: &'static str| {
        move |c: &mut Chain| {
            c.runtime.in_flight = n;
            c.render = render.parse().unwrap();
        }
    };
    let locked = |render: &'static str, after: f64| {
        move |c: &mut Chain| {
            c.host_rate = c.display.scan.rate;
            c.runtime.host_lock = Some(Nanos::from_ms(after));
            c.render = render.parse().unwrap();
        }
    };
    let at = |render: &'static str, after: f64, hz: f64| {
        move |c: &mut Chain| {
            locked(render, after)(c);
            c.host_rate = Rate::from_hz("f", hz).unwrap();
        }
    };
    let overlapped = |render: &'static str| {
        move |c: &mut Chain| {
            c.render = render.parse().unwrap();
            c.runtime.overlapped = true;
        }
    };
    let just_in_time = |render: &'static str, reserve: f64| {
        move |c: &mut Chain| {
            c.render = render.parse().unwrap();
            c.runtime.lead = Nanos(MS);
            let reserve = Nanos::from_ms(reserve);
            c.runtime.start = FrameStart::JustInTime { reserve };
        }
    };
    vec![
        ("tearing", chain(Tearing, |_| ())),
        ("tearing, long frames", chain(Tearing, law("13.7"))),
        (
            "tearing, uneven frames",
            chain(Tearing, law("uniform:4..12.3")),
        ),
        ("tearing, 2 in flight", chain(Tearing, in_flight(2, "13.7"))),
        ("tearing, 3 in flight", chain(Tearing, in_flight(3, "6"))),
        (
            "tearing, late latch",
            chain(Tearing, |c| c.runtime.gaze_latch = Nanos(5 * MS)),
        ),
        (
            "tearing, upwards",
            chain(Tearing, |c| c.display.scan.direction = ScanDirection::Up),
        ),
        ("free, lead", chain(VsyncFree, lead(2.5))),
        ("free, uneven", chain(VsyncFree, law("uniform:4..12.3"))),
        ("free, 3 in flight", chain(VsyncFree, in_flight(3, "13.7"))),
        ("free, warp", chain(VsyncFree, warp(Missed::Repeat))),
        ("blocked", chain(Vsync, |_| ())),
        ("blocked, lead makes it miss", chain(Vsync, lead(4.5))),
        ("blocked, uneven", chain(Vsync, law("uniform:4..12.3"))),
        ("blocked, 3 refreshes", chain(Vsync, law("21.2"))),
        (
            "blocked, half rate",
            chain(Vsync, |c| {
                c.runtime.missed = Missed::HalfRate;
                c.render = "21.2".parse().unwrap();
            }),
        ),
        ("blocked, 2 in flight", chain(Vsync, in_flight(2, "6"))),
        (
            "blocked, 3 in flight, uneven",
            chain(Vsync, in_flight(3, "uniform:4..9.5")),
        ),
        ("blocked, warp", chain(Vsync, warp(Missed::Repeat))),
        (
            "blocked, reprojected",
            chain(Vsync, |c| {
                warp(Missed::Reproject)(c);
                c.render = "18".parse().unwrap();
            }),
        ),
        // Frames in flight that are late: the renderer never rests, and blanks meet it in turns.
        (
            "blocked, 2 in flight, late",
            chain(Vsync, in_flight(2, "14")),
        ),
        (
            "blocked, 3 in flight, late",
            chain(Vsync, in_flight(3, "12.5")),
        ),
        (
            "blocked, 3 in flight, very late",
            chain(Vsync, in_flight(3, "26")),
        ),
        (
            "blocked, 2 in flight, too long for the lead",
            chain(Vsync, |c| {
                in_flight(2, "8")(c);
                c.runtime.lead = Nanos(13 * MS / 2);
            }),
        ),
        (
            "blocked, 2 in flight, late and uneven",
            chain(Vsync, in_flight(2, "uniform:11..16")),
        ),
        (
            "blocked, 2 in flight, now and then late",
            chain(Vsync, in_flight(2, "uniform:7..16")),
        ),
        (
            "blocked, 3 in flight, uneven, with a lead",
            chain(Vsync, |c| {
                in_flight(3, "uniform:6..14")(c);
                c.runtime.lead = Nanos(2 * MS);
            }),
        ),
        (
            "free, locked, uneven",
            chain(VsyncFree, locked("uniform:4..9.5", 3.0)),
        ),
        (
            "free, locked, never in time",
            chain(VsyncFree, locked("uniform:7.5..9.5", 3.0)),
        ),
        ("tearing, locked", chain(Tearing, locked("6", 3.0))),
        (
            "tearing, locked, uneven",
            chain(Tearing, locked("uniform:4..9.5", 3.0)),
        ),
        (
            "tearing, locked, within the rows",
            chain(Tearing, locked("uniform:2..3", 0.5)),
        ),
        // Hosts with the display's clock that overrun it, or divide it.
        ("tearing, locked, late", chain(Tearing, locked("12.5", 3.0))),
        ("free, locked, late", chain(VsyncFree, locked("13", 3.0))),
        (
            "free, locked, late, with a lead and a warp",
            chain(VsyncFree, |c| {
                warp(Missed::Repeat)(c);
                locked("12.5", 3.0)(c);
            }),
        ),
        (
            "tearing, locked, 2 in flight, late",
            chain(Tearing, |c| {
                locked("12.5", 3.0)(c);
                c.runtime.in_flight = 2;
            }),
        ),
        (
            "tearing, locked, uneven and late",
            chain(Tearing, locked("uniform:4..14", 3.0)),
        ),
        (
            "free, locked, uneven and late",
            chain(VsyncFree, locked("uniform:4..14", 3.0)),
        ),
        (
            "tearing, locked at 80 Hz",
            chain(Tearing, at("uniform:2..7", 3.0, 80.0)),
        ),
        (
            "tearing, locked at 30 Hz, more than a refresh",
            chain(Tearing, at("uniform:4..23", 1.0, 30.0)),
        ),
        (
            "free, locked at 125 Hz",
            chain(VsyncFree, at("uniform:2..7", 3.0, 125.0)),
        ),
        (
            "free, locked at 80 Hz, with a lead and a warp",
            chain(VsyncFree, |c| {
                warp(Missed::Repeat)(c);
                at("5", 3.0, 80.0)(c);
            }),
        ),
        (
            "free, locked at 80 Hz, late",
            chain(VsyncFree, at("15", 3.0, 80.0)),
        ),
        (
            "tearing, locked, global",
            chain(Tearing, |c| {
                locked("uniform:4..9.5", 3.0)(c);
                c.display.response.emission = Emission::Global;
            }),
        ),
        (
            "tearing, locked, global, late",
            chain(Tearing, |c| {
                locked("12.5", 3.3)(c);
                c.display.response.emission = Emission::Global;
            }),
        ),
        (
            "blocked, 2 in flight, a refresh each",
            chain(Vsync, in_flight(2, "10")),
        ),
        (
            "blocked, 3 in flight, a refresh each, with a lead",
            chain(Vsync, |c| {
                in_flight(3, "10")(c);
                c.runtime.lead = Nanos(2 * MS);
            }),
        ),
        (
            "tearing, overlapped",
            chain(Tearing, overlapped("uniform:4..23")),
        ),
        (
            "free, overlapped",
            chain(VsyncFree, overlapped("uniform:8..13")),
        ),
        ("blocked, overlapped", chain(Vsync, overlapped("14"))),
        (
            "blocked, overlapped, uneven",
            chain(Vsync, overlapped("uniform:4..23")),
        ),
        (
            "blocked, half rate, uneven",
            chain(Vsync, |c| {
                c.runtime.missed = Missed::HalfRate;
                c.render = "uniform:8..12".parse().unwrap();
            }),
        ),
        (
            "blocked, half rate, very uneven",
            chain(Vsync, |c| {
                c.runtime.missed = Missed::HalfRate;
                c.render = "uniform:12..23".parse().unwrap();
            }),
        ),
        ("just in time", chain(Vsync, just_in_time("6", 6.0))),
        (
            "just in time, margin",
            chain(Vsync, just_in_time("uniform:4..6", 7.5)),
        ),
        (
            "just in time, too long",
            chain(Vsync, just_in_time("13", 14.0)),
        ),
        (
            "just in time, missed",
            chain(Vsync, just_in_time("8.5", 7.0)),
        ),
        (
            "late pose latch",
            chain(Vsync, |c| {
                c.runtime.pose_latch = Nanos(4 * MS);
                c.head = HeadSampling {
                    rate: Some(Rate::from_hz("f", 800.0).unwrap()),
                    delay: Nanos(MS),
                };
            }),
        ),
        (
            "buffered, global, strobed",
            chain(Vsync, |c| {
                c.display.scan.buffered_frames = 3;
                c.display.response.emission = Emission::Global;
                c.display.response.strobe_delay = Nanos(MS / 2);
                c.display.response.to_counted_light = Nanos(MS);
            }),
        ),
        (
            "transport and losses",
            chain(Vsync, |c| {
                c.tracker.transport = Durations::uniform("t", [0.5, 1.5]).unwrap();
                c.tracker.processing = Durations::uniform("p", [1.0, 2.0]).unwrap();
            }),
        ),
        (
            "a display whose period is no whole number",
            chain(Vsync, |c| {
                c.display.scan.rate = Rate::from_hz("f", 119.88).unwrap();
                c.runtime.lead = Nanos(MS);
            }),
        ),
    ]
}

/// Hosts with the display's clock and frames in flight, some of them late and some not: they start at ticks, or
/// when those before them end.
pub(super) fn crowded() -> Vec<(&'static str, Chain)> {
    use SyncMode::{Tearing, VsyncFree};
    let crowded = |n: u32, render: &'static str, after: f64, hz: f64| {
        move |c: &mut Chain| {
            c.host_rate = Rate::from_hz("f", hz).unwrap();
            c.runtime.host_lock = Some(Nanos::from_ms(after));
            c.runtime.in_flight = n;
            c.render = render.parse().unwrap();
        }
    };
    let warped = |c: &mut Chain, missed: Missed| {
        (c.runtime.lead, c.runtime.warp) = (Nanos(3 * MS), Some(Nanos(2 * MS)));
        c.runtime.missed = missed;
    };
    vec![
        (
            "free, locked, 2 in flight, uneven and late",
            chain(VsyncFree, crowded(2, "uniform:8..14", 3.0, 100.0)),
        ),
        (
            "free, locked, 3 in flight, uneven and late",
            chain(VsyncFree, crowded(3, "uniform:7..13", 3.0, 100.0)),
        ),
        (
            "free, locked at 80 Hz, 2 in flight, uneven and late, with a lead and a warp",
            chain(VsyncFree, |c| {
                warped(c, Missed::Repeat);
                crowded(2, "uniform:9..17", 3.0, 80.0)(c);
            }),
        ),
        (
            "free, locked at 125 Hz, 3 in flight, uneven and late, reprojected",
            chain(VsyncFree, |c| {
                warped(c, Missed::Reproject);
                crowded(3, "uniform:6..11", 1.0, 125.0)(c);
            }),
        ),
        (
            "free, locked, 2 in flight, uneven and late, with late latches",
            chain(VsyncFree, |c| {
                crowded(2, "uniform:8..14", 3.0, 100.0)(c);
                (c.runtime.gaze_latch, c.runtime.pose_latch) = (Nanos(5 * MS), Nanos(7 * MS));
            }),
        ),
        (
            "tearing, locked, 2 in flight, uneven and late",
            chain(Tearing, crowded(2, "uniform:8..14", 3.0, 100.0)),
        ),
        (
            "tearing, locked, 3 in flight, uneven and late",
            chain(Tearing, crowded(3, "uniform:8..13", 3.0, 100.0)),
        ),
        (
            "tearing, locked, 2 in flight, rarely late",
            chain(Tearing, crowded(2, "uniform:9..10.5", 3.0, 100.0)),
        ),
        (
            "tearing, locked at 80 Hz, 2 in flight, uneven and late",
            chain(Tearing, crowded(2, "uniform:9..17", 3.0, 80.0)),
        ),
        (
            "tearing, locked, 2 in flight, uneven and late, global",
            chain(Tearing, |c| {
                crowded(2, "uniform:8..14", 3.3, 100.0)(c);
                c.display.response.emission = Emission::Global;
            }),
        ),
    ]
}
