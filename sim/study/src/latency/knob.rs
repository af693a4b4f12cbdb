use foveasim_models::{Nanos, Rate};
use foveasim_pipeline::{FrameStart, SyncMode};

use crate::Chain;

/// A part of the chain that engineering could make shorter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Knob {
    /// The time between exposures.
    TrackerPeriod,
    /// The exposure.
    Exposure,
    /// From the end of exposure to the sample.
    Processing,
    /// From there to the host.
    Transport,
    /// The time between head samples.
    HeadPeriod,
    /// From a head sample to the host.
    HeadDelay,
    /// The time between frames of a host that runs freely.
    HostPeriod,
    /// Reading the gaze later in the frame.
    GazeLatch,
    /// Reading the pose later in the frame.
    PoseLatch,
    /// Rendering. The time that a just-in-time start sets aside shrinks with it.
    Render,
    /// What a just-in-time start sets aside beyond the longest frame.
    Margin,
    /// The compositor's lead, as far as the late warp does not need it.
    Lead,
    /// Frames that the display holds, one at a time.
    DisplayBuffer,
    /// The time between refreshes, and that of a host at the display's rate.
    RefreshPeriod,
    /// Pixel switching.
    PixelResponse,
    /// The delay of a global flash.
    StrobeDelay,
    /// From the first light to the light that counts.
    Persistence,
}

/// All of them, in the order of the chain.
pub const KNOBS: [Knob; 17] = [
    Knob::TrackerPeriod,
    Knob::Exposure,
    Knob::Processing,
    Knob::Transport,
    Knob::HeadPeriod,
    Knob::HeadDelay,
    Knob::HostPeriod,
    Knob::GazeLatch,
    Knob::PoseLatch,
    Knob::Render,
    Knob::Margin,
    Knob::Lead,
    Knob::DisplayBuffer,
    Knob::RefreshPeriod,
    Knob::PixelResponse,
    Knob::StrobeDelay,
    Knob::Persistence,
];

impl Knob {
    /// As in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::TrackerPeriod => "tracker_period",
            Self::Exposure => "tracker_exposure",
            Self::Processing => "tracker_processing",
            Self::Transport => "tracker_transport",
            Self::HeadPeriod => "head_period",
            Self::HeadDelay => "head_delay",
            Self::HostPeriod => "host_period",
            Self::GazeLatch => "later_gaze_latch",
            Self::PoseLatch => "later_pose_latch",
            Self::Render => "render",
            Self::Margin => "just_in_time_margin",
            Self::Lead => "compositor_lead",
            Self::DisplayBuffer => "display_buffer",
            Self::RefreshPeriod => "refresh_period",
            Self::PixelResponse => "pixel_response",
            Self::StrobeDelay => "strobe_delay",
            Self::Persistence => "persistence",
        }
    }

    /// What to do to shorten it, in words and with what it is in `chain`. Parts that are stages go by the names
    /// that these have in tables.
    pub fn advice(self, chain: &Chain) -> String {
        let ms = |t: Nanos| format!("{:.2} ms", t.as_ms());
        let every = |rate: Rate| ms(rate.period());
        let (tracker, runtime) = (&chain.tracker, &chain.runtime);
        let (response, scan) = (&chain.display.response, &chain.display.scan);
        let stage = |name: &str, t: Nanos| format!("shorten {name} (of {})", ms(t));
        let later = |what: &str, flag: &str, latch: Nanos| {
            format!(
                "read the {what} later in the frame ({flag}, now {}, can be up to {}, the shortest frame)",
                ms(latch),
                ms(chain.render.min())
            )
        };
        match self {
            Self::TrackerPeriod => format!(
                "shorten tracker_wait (an exposure begins every {}) by a higher tracker rate",
                every(tracker.rate)
            ),
            Self::Exposure => stage("tracker_exposure", tracker.exposure),
            Self::Processing => stage("tracker_processing", tracker.processing.max()),
            Self::Transport => stage("tracker_transport", tracker.transport.max()),
            Self::HeadPeriod => format!(
                "shorten motion_head_wait (a head sample every {}) by a higher head rate",
                chain.head.rate.map_or_else(String::new, every)
            ),
            Self::HeadDelay => stage("motion_head_delay", chain.head.delay),
            Self::HostPeriod => format!(
                "shorten frame_wait (a frame is due every {}) by a higher host rate",
                every(chain.host_rate)
            ),
            Self::GazeLatch => later("gaze", "--gaze-latch-ms", runtime.gaze_latch),
            Self::PoseLatch => later("head pose", "--pose-latch-ms", runtime.pose_latch),
            Self::Render => stage("render", chain.render.max()),
            Self::Margin => format!(
                "shorten flip_wait (just-in-time frames have {}, the longest takes {}) by a smaller reserve",
                ms(chain.reserve().unwrap_or_default()),
                ms(chain.render.max())
            ),
            Self::Lead => stage("compose", runtime.lead),
            Self::DisplayBuffer => format!(
                "shorten display_buffer (the display holds {} of {} each)",
                match scan.buffered_frames {
                    1 => "1 frame".into(),
                    n => format!("{n} frames"),
                },
                every(scan.rate)
            ),
            Self::RefreshPeriod => format!(
                "shorten the display's refresh (of {}) by a higher refresh rate",
                every(scan.rate)
            ),
            Self::PixelResponse => stage("pixel_response", response.settle),
            Self::StrobeDelay => format!(
                "shorten pixel_response (the flash comes {} after the last row)",
                ms(response.strobe_delay)
            ),
            Self::Persistence => stage("persistence", response.to_counted_light),
        }
    }

    /// How much there is of it in `chain`: the most that can be taken away. A period can be halved.
    pub fn length(self, chain: &Chain) -> Nanos {
        let half = |rate: Rate| Nanos(rate.period().0 / 2);
        let (tracker, runtime) = (&chain.tracker, &chain.runtime);
        let (response, scan) = (&chain.display.response, &chain.display.scan);
        let shortest = chain.render.min();
        match self {
            Self::TrackerPeriod => half(tracker.rate),
            Self::Exposure => tracker.exposure,
            Self::Processing => tracker.processing.max(),
            Self::Transport => tracker.transport.max(),
            Self::HeadPeriod => chain.head.rate.map_or(Nanos::ZERO, half),
            Self::HeadDelay => chain.head.delay,
            Self::HostPeriod if chain.sync != SyncMode::Vsync && runtime.host_lock.is_none() => {
                half(chain.host_rate)
            }
            Self::HostPeriod => Nanos::ZERO,
            Self::GazeLatch => shortest - runtime.gaze_latch,
            Self::PoseLatch => match runtime.warp {
                Some(_) => Nanos::ZERO,
                None => shortest - runtime.pose_latch,
            },
            Self::Render => chain.render.max(),
            Self::Margin => {
                let spare = |reserve: Nanos| (reserve - chain.render.max()).max(Nanos::ZERO);
                chain.reserve().map_or(Nanos::ZERO, spare)
            }
            Self::Lead => runtime.lead - runtime.warp.unwrap_or(Nanos::ZERO),
            Self::DisplayBuffer => scan.rate.period() * i64::from(scan.buffered_frames),
            Self::RefreshPeriod => half(scan.rate),
            Self::PixelResponse => response.settle,
            Self::StrobeDelay => response.strobe_delay,
            Self::Persistence => response.to_counted_light,
        }
    }

    /// What is taken away at a time: 1 ms, or all there is; of held frames, one.
    pub(super) fn step(self, chain: &Chain) -> Nanos {
        let most = match self {
            Self::DisplayBuffer => chain.display.scan.rate.period(),
            _ => Nanos(1_000_000),
        };
        most.min(self.length(chain))
    }

    /// The chain with `by` less of it, at most [`Knob::length`].
    pub(super) fn shortened(self, chain: &Chain, by: Nanos) -> Chain {
        let mut chain = chain.clone();
        let faster = |rate: Rate| {
            let period = rate.period() - by;
            Rate::from_hz("rate", 1e9 / period.0 as f64).unwrap_or(rate)
        };
        let runtime = &mut chain.runtime;
        match self {
            Self::TrackerPeriod => chain.tracker.rate = faster(chain.tracker.rate),
            Self::Exposure => chain.tracker.exposure -= by,
            Self::Processing => chain.tracker.processing = chain.tracker.processing.shifted(-by),
            Self::Transport => chain.tracker.transport = chain.tracker.transport.shifted(-by),
            Self::HeadPeriod => chain.head.rate = chain.head.rate.map(faster),
            Self::HeadDelay => chain.head.delay -= by,
            Self::HostPeriod => chain.host_rate = faster(chain.host_rate),
            Self::GazeLatch => runtime.gaze_latch += by,
            Self::PoseLatch => runtime.pose_latch += by,
            Self::Render => {
                let reserve = match &mut runtime.start {
                    FrameStart::JustInTime { reserve } => Some(reserve),
                    FrameStart::AtVblank => None,
                };
                if let Some(reserve) = reserve {
                    *reserve = (*reserve - by).max(Nanos::ZERO);
                }
                chain.render = chain.render.shifted(-by);
                let shortest = chain.render.min();
                runtime.gaze_latch = runtime.gaze_latch.min(shortest);
                runtime.pose_latch = runtime.pose_latch.min(shortest);
            }
            Self::Margin => {
                if let FrameStart::JustInTime { reserve } = &mut runtime.start {
                    *reserve -= by;
                }
            }
            Self::Lead => runtime.lead -= by,
            Self::DisplayBuffer => chain.display.scan.buffered_frames -= 1,
            Self::RefreshPeriod => {
                let rate = chain.display.scan.rate;
                if chain.host_rate == rate {
                    chain.host_rate = faster(rate);
                }
                chain.display.scan.rate = faster(rate);
                let period = chain.display.scan.rate.period();
                runtime.host_lock = runtime.host_lock.map(|lock| lock.min(period));
                runtime.lead = runtime.lead.min(period - Nanos(1));
            }
            Self::PixelResponse => chain.display.response.settle -= by,
            Self::StrobeDelay => chain.display.response.strobe_delay -= by,
            Self::Persistence => chain.display.response.to_counted_light -= by,
        }
        chain
    }
}
