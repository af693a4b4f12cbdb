use foveasim_models::{Display, Nanos};
use foveasim_pipeline::Stage;
use foveasim_reports::{Cell, TraceEvents, Track};

use super::{Replay, ReplayFrame};

/// The most displayed frames of a timeline: viewers slow down beyond some hundred thousand events.
const MOST_FRAMES: usize = 10_000;

/// What takes longer than a frame overlaps with the next one's: such stages take turns on this many
/// rows.
const LANES: usize = 4;

impl Replay {
    /// The recording's frames as a timeline: a track per stage, and an arrow from each gaze sample that
    /// was used to its light. Recordings longer than ten thousand displayed frames are cut off there.
    pub fn timeline(&self, display: &Display) -> TraceEvents {
        let mut events = TraceEvents::new();
        let tracker = events.process("eye tracker");
        let exposure = lanes(&mut events, tracker, "exposure");
        let processing = lanes(&mut events, tracker, "processing");
        // Stages that are off have no rows.
        let takes = |stage: Stage| {
            let longest = self
                .frames
                .iter()
                .filter_map(|f| Some(f.stages?.get(stage)));
            longest.fold(Nanos::ZERO, Nanos::max) > Nanos::ZERO
        };
        let transport =
            takes(Stage::TrackerTransport).then(|| lanes(&mut events, tracker, "transport"));
        let host = events.process("host");
        let queue = takes(Stage::FrameQueue).then(|| lanes(&mut events, host, "queue"));
        let compose = takes(Stage::Compose).then(|| lanes(&mut events, host, "compositor"));
        let render = events.track(host, "render");
        let panel = events.process("display");
        let held = takes(Stage::DisplayBuffer)
            .then(|| lanes(&mut events, panel, "frames held by the display"));
        let scan = events.track(panel, "scan-out");
        let light = lanes(&mut events, panel, "gaze row switches");
        let active = display.scan.active();
        let mut before: Option<&ReplayFrame> = None;
        for (k, shown) in self.frames.iter().take(MOST_FRAMES).enumerate() {
            let frame = &shown.frame;
            let since = |t| t - self.start;
            let light = light[k % LANES];
            let lane = frame.id as usize % LANES;
            let new_frame = before.is_none_or(|b| b.frame.id != frame.id);
            let exposed = |f: &ReplayFrame| f.frame.gaze.map(|g| g.exposure_start);
            let sample = frame
                .gaze
                .filter(|_| before.is_none_or(|b| exposed(b) != exposed(shown)));
            if let Some(gaze) = sample {
                let value = [
                    ("azimuth_deg", Cell::from(gaze.value.azimuth_deg)),
                    ("elevation_deg", Cell::from(gaze.value.elevation_deg)),
                ];
                let (start, end) = (gaze.exposure_start, gaze.exposure_end);
                let (lasts, works) = (visible(end - start), visible(gaze.processed - end));
                events.complete(exposure[lane], "exposure", since(start), lasts, &value);
                events.complete(processing[lane], "processing", since(end), works, &[]);
                if let Some(transport) = &transport {
                    let (from, lasts) = (gaze.processed, visible(gaze.delivered - gaze.processed));
                    events.complete(transport[lane], "transport", since(from), lasts, &[]);
                }
            }
            if new_frame {
                let name = format!("frame {}", frame.id);
                let lasts = visible(frame.end - frame.begun);
                events.complete(render, &name, since(frame.begun), lasts, &[]);
                if let Some(queue) = &queue {
                    let lasts = visible(frame.begun - frame.start);
                    events.complete(queue[lane], &name, since(frame.start), lasts, &[]);
                }
                if let Some(compose) = &compose {
                    let name = if shown.warped { "late warp" } else { "compose" };
                    let lasts = visible(shown.flipped - shown.composed);
                    events.complete(compose[lane], name, since(shown.composed), lasts, &[]);
                }
            }
            let buffered = shown
                .stages
                .map_or(Nanos::ZERO, |s| s.get(Stage::DisplayBuffer));
            if let Some(held) = &held {
                let name = format!("scan {}", shown.scan);
                let lane = held[shown.scan as usize % LANES];
                events.complete(lane, &name, since(shown.vblank), visible(buffered), &[]);
            }
            let name = format!("scan {}", shown.scan);
            let args = [
                ("frame", Cell::from(frame.id)),
                ("gaze_state", shown.state.name().into()),
            ];
            events.complete(scan, &name, since(shown.vblank + buffered), active, &args);
            let lasts = visible(shown.lit - shown.scanned);
            events.complete(light, "pixels switch", since(shown.scanned), lasts, &[]);
            if let Some(gaze) = sample {
                let mut steps = vec![
                    (exposure[lane], since(gaze.exposure_start)),
                    (processing[lane], since(gaze.exposure_end)),
                ];
                let way = [
                    transport.as_ref().map(|t| (t[lane], gaze.processed)),
                    Some((render, frame.gaze_latched.max(frame.begun))),
                    compose.as_ref().map(|c| (c[lane], shown.composed)),
                    held.as_ref()
                        .map(|h| (h[shown.scan as usize % LANES], shown.vblank)),
                    Some((scan, shown.scanned)),
                    Some((light, shown.scanned)),
                ];
                let way = way.into_iter().flatten();
                steps.extend(way.map(|(track, t)| (track, since(t))));
                events.flow("gaze to photon", &steps);
            }
            if let Some(error) = shown.gaze_error_deg() {
                events.counter(panel, "gaze error [deg]", since(shown.lit), error);
            }
            before = Some(shown);
        }
        events
    }
}

fn lanes(events: &mut TraceEvents, process: u32, name: &str) -> [Track; LANES] {
    std::array::from_fn(|k| events.track(process, &format!("{name} {}", k + 1)))
}

/// At least a nanosecond, or a viewer has nothing to fasten an arrow to.
fn visible(duration: Nanos) -> Nanos {
    duration.max(Nanos(1))
}
