use std::fmt;
use std::str::FromStr;

use foveasim_models::{Durations, ModelError, Nanos, unknown_name};
use foveasim_pipeline::{FrameStart, Missed};

use super::Chain;

/// A part of the chain that can be switched off: it then takes no time, or adds no error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Part {
    /// The tracker's exposure takes no time.
    Exposure,
    /// Its samples are ready at once.
    Processing,
    /// They reach the host at once.
    Transport,
    /// The tracker never loses the eye for a moment.
    Dropouts,
    /// The viewer does not blink.
    Blinks,
    /// No systematic error, neither constant nor over the field of gaze.
    Bias,
    /// No noise.
    Noise,
    /// The headset does not slip.
    Slippage,
    /// Head samples reach the host at once.
    HeadDelay,
    /// Frames render in no time: each is finished once it has read its input, which it does as long after its start
    /// as before.
    Render,
    /// Frames in flight wait for no earlier ones and are shown at once
    /// ([`Runtime::overlapped`](foveasim_pipeline::Runtime)). One frame in flight has no queue.
    Queue,
    /// The compositor takes frames at the vertical blank itself, and warps in no time.
    Lead,
    /// The display holds no frames.
    Buffer,
    /// Pixels switch at once, and a global flash follows the scan at once.
    Response,
    /// The first light counts.
    Persistence,
}

/// All of them.
pub const PARTS: [Part; 15] = [
    Part::Exposure,
    Part::Processing,
    Part::Transport,
    Part::Dropouts,
    Part::Blinks,
    Part::Bias,
    Part::Noise,
    Part::Slippage,
    Part::HeadDelay,
    Part::Render,
    Part::Queue,
    Part::Lead,
    Part::Buffer,
    Part::Response,
    Part::Persistence,
];

impl Part {
    /// As given to `--off`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exposure => "exposure",
            Self::Processing => "processing",
            Self::Transport => "transport",
            Self::Dropouts => "dropouts",
            Self::Blinks => "blinks",
            Self::Bias => "bias",
            Self::Noise => "noise",
            Self::Slippage => "slippage",
            Self::HeadDelay => "head-delay",
            Self::Render => "render",
            Self::Queue => "queue",
            Self::Lead => "lead",
            Self::Buffer => "buffer",
            Self::Response => "response",
            Self::Persistence => "persistence",
        }
    }
}

impl FromStr for Part {
    type Err = ModelError;

    fn from_str(text: &str) -> Result<Self, ModelError> {
        PARTS
            .into_iter()
            .find(|part| part.name() == text)
            .ok_or_else(|| unknown_name("part of the chain", text, &PARTS.map(Self::name)))
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What may rise although a part takes no time any more.
///
/// Latencies of chains whose frames wait for clocks, for each other and for a display are no sums; these are all
/// the cases in which less of a part may mean more of the whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Anomaly {
    /// The best case, not the mean. A host whose clock is the display's, and whose frames overrun it, meets the
    /// display in any way, the luckiest among them; one that keeps up meets it as its lock says, for ever.
    BestCase,
    /// What answers the head. A late warp that leaves refreshes without a new frame alone (no reprojection) turns
    /// new frames only: how far these are apart counts, and frames that are ready sooner may come less evenly.
    WarpRhythm,
}

impl fmt::Display for Anomaly {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::BestCase => {
                "the best case may be worse without it: frames that overrun meet the display in any way, \
                 those that keep up as the host's lock says"
            }
            Self::WarpRhythm => {
                "motion may be slower without it: the late warp turns new frames only, and these may come \
                 less evenly (`reproject` turns all)"
            }
        })
    }
}

impl Chain {
    /// What may rise if `part` is off; nothing in most chains.
    pub fn anomalies_without(&self, part: Part) -> Vec<Anomaly> {
        let runtime = &self.runtime;
        let overruns = self.render.max() > self.host_rate.period();
        let mut anomalies = Vec::new();
        if matches!(part, Part::Render | Part::Queue) && runtime.host_lock.is_some() && overruns {
            anomalies.push(Anomaly::BestCase);
        }
        let turns_new_frames = runtime.warp.is_some() && runtime.missed != Missed::Reproject;
        if matches!(part, Part::Render | Part::Queue | Part::Lead) && turns_new_frames {
            anomalies.push(Anomaly::WarpRhythm);
        }
        anomalies
    }

    /// The same chain with one part off.
    #[must_use]
    pub fn without(mut self, part: Part) -> Self {
        if self.is_off(part) {
            return self;
        }
        self.off.push((part, self.anomalies_without(part)));
        let (tracker, runtime) = (&mut self.tracker, &mut self.runtime);
        match part {
            Part::Exposure => tracker.exposure = Nanos::ZERO,
            Part::Processing => tracker.processing = Durations::ZERO,
            Part::Transport => tracker.transport = Durations::ZERO,
            Part::Dropouts => tracker.dropouts = None,
            Part::Blinks => tracker.blinks = None,
            Part::Bias => (tracker.bias_deg, tracker.bias_map) = (0.0, None),
            Part::Noise => tracker.precision_deg = 0.0,
            Part::Slippage => tracker.slippage_deg_per_sqrt_min = 0.0,
            Part::HeadDelay => self.head.delay = Nanos::ZERO,
            Part::Render => {
                // Input is read when it was; no frame is finished before.
                let read = runtime.gaze_latch.max(runtime.pose_latch);
                self.render = Durations::fixed(read);
                if let FrameStart::JustInTime { reserve } = &mut runtime.start {
                    *reserve = read.min(*reserve);
                }
            }
            Part::Queue => {
                runtime.overlapped |= runtime.in_flight > 1;
                runtime.in_flight = 1;
            }
            Part::Lead => {
                runtime.lead = Nanos::ZERO;
                runtime.warp = runtime.warp.map(|_| Nanos::ZERO);
            }
            Part::Buffer => self.display.scan.buffered_frames = 0,
            Part::Response => {
                let response = &mut self.display.response;
                (response.settle, response.strobe_delay) = (Nanos::ZERO, Nanos::ZERO);
            }
            Part::Persistence => self.display.response.to_counted_light = Nanos::ZERO,
        }
        self
    }
}
