use foveasim_models::{Display, Nanos};
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
        let host = events.process("host");
        let render = events.track(host, "render");
        let panel = events.process("display");
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
                let (lasts, works) = (visible(end - start), visible(gaze.delivered - end));
                events.complete(exposure[lane], "exposure", since(start), lasts, &value);
                events.complete(processing[lane], "processing", since(end), works, &[]);
            }
            if new_frame {
                let name = format!("frame {}", frame.id);
                let lasts = visible(frame.end - frame.start);
                events.complete(render, &name, since(frame.start), lasts, &[]);
            }
            let name = format!("scan {}", shown.scan);
            let args = [
                ("frame", Cell::from(frame.id)),
                ("gaze_state", shown.state.name().into()),
            ];
            events.complete(scan, &name, since(shown.vblank), active, &args);
            let lasts = visible(shown.lit - shown.scanned);
            events.complete(light, "pixels switch", since(shown.scanned), lasts, &[]);
            if let Some(gaze) = sample {
                events.flow(
                    "gaze to photon",
                    &[
                        (exposure[lane], since(gaze.exposure_start)),
                        (processing[lane], since(gaze.exposure_end)),
                        (render, since(frame.start)),
                        (scan, since(shown.scanned)),
                        (light, since(shown.scanned)),
                    ],
                );
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
