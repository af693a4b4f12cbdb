//! The flags that describe the loop between tracker and display.

use foveasim_study::ChainSpec;

use super::options;

/// The loop between tracker and display. Times are in ms; a LAW is milliseconds, `uniform:MIN..MAX`,
/// `normal:MEAN,SD`, `csv:FILE` (measured values: the first column whose name ends in `ms`) or `csv:FILE#COLUMN`.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "The loop between tracker and display (all off by default)")]
pub(crate) struct ChainFlags {
    /// How often a free-running host starts a frame [Hz] [default: the display's rate]
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    host_hz: Option<f64>,
    /// Lock a free-running host's clock to the display's: frames are due so long after a vertical blank
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    host_lock_ms: Option<f64>,
    /// When a host with --sync vsync starts frames: vblank, just-in-time (the longest frame is just in
    /// time) or just-in-time:MS (reserving that long)
    #[arg(long, value_name = "WHEN")]
    start: Option<String>,
    /// The compositor takes frames so long before each vertical blank [default: as long as the warp]
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    lead_ms: Option<f64>,
    /// Late warp to the newest head pose, and what it takes; at most the lead
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    warp_ms: Option<f64>,
    /// Frames in flight, 1 to 3
    #[arg(long, value_name = "N")]
    frames_in_flight: Option<u32>,
    /// What a refresh shows that no new frame is ready for: repeat, half-rate or reproject
    #[arg(long, value_name = "POLICY")]
    missed: Option<String>,
    /// Read the gaze so long after a frame starts
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    gaze_latch_ms: Option<f64>,
    /// Read the head pose so long after a frame starts
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    pose_latch_ms: Option<f64>,
    /// What the tracker's processing takes, instead of the tracker's own: milliseconds,
    /// uniform:MIN..MAX, normal:MEAN,SD, csv:FILE (measured values [ms]: the first column whose name ends
    /// in ms) or csv:FILE#COLUMN
    #[arg(long, value_name = "LAW")]
    processing: Option<String>,
    /// What a tracker sample's transport to the host takes, instead of the tracker's own; a law as for
    /// --processing
    #[arg(long, value_name = "LAW")]
    transport: Option<String>,
    /// Frames that the display holds, 0 to 4, instead of its own number
    #[arg(long, value_name = "N")]
    buffered_frames: Option<u32>,
    /// Head samples a second [Hz] [default: the pose is always new; in a replay, each recorded one]
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    head_hz: Option<f64>,
    /// From a head sample to the host having it
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    head_delay_ms: Option<f64>,
    /// Whose rows are looked at: left or right
    #[arg(long, value_name = "EYE")]
    eye: Option<String>,
    /// How much faster than stated clocks run, in parts in a million: tracker, host, display
    #[arg(long, value_name = "T,H,D", value_parser = options::triple, allow_hyphen_values = true)]
    drift_ppm: Option<[f64; 3]>,
    /// Parts to switch off, separated by commas: exposure, processing, transport, dropouts, blinks, bias,
    /// noise, slippage, head-delay, render, queue, lead, buffer, response, persistence. Without a part no
    /// mean, no 95th percentile and no bound rises, but: the best case of a host with --host-lock-ms whose
    /// frames overrun, without render or queue; motion with --warp-ms and without --missed reproject,
    /// without render, queue or lead. A note says so where it applies (docs/latency.md, Stages)
    #[arg(long, value_name = "PARTS", value_delimiter = ',')]
    off: Option<Vec<String>>,
}

impl ChainFlags {
    /// Puts the flags that were given on top of `spec`.
    pub(crate) fn over(&self, spec: &mut ChainSpec) {
        fn set<T: Clone>(place: &mut Option<T>, flag: &Option<T>) {
            if flag.is_some() {
                place.clone_from(flag);
            }
        }
        set(&mut spec.host_hz, &self.host_hz);
        set(&mut spec.host_lock_ms, &self.host_lock_ms);
        set(&mut spec.start, &self.start);
        set(&mut spec.lead_ms, &self.lead_ms);
        set(&mut spec.warp_ms, &self.warp_ms);
        set(&mut spec.frames_in_flight, &self.frames_in_flight);
        set(&mut spec.missed, &self.missed);
        set(&mut spec.gaze_latch_ms, &self.gaze_latch_ms);
        set(&mut spec.pose_latch_ms, &self.pose_latch_ms);
        set(&mut spec.processing, &self.processing);
        set(&mut spec.transport, &self.transport);
        set(&mut spec.buffered_frames, &self.buffered_frames);
        set(&mut spec.head_hz, &self.head_hz);
        set(&mut spec.head_delay_ms, &self.head_delay_ms);
        set(&mut spec.eye, &self.eye);
        if let Some([tracker, host, display]) = self.drift_ppm {
            let drift = &mut spec.drift_ppm;
            (drift.tracker, drift.host, drift.display) = (tracker, host, display);
        }
        if let Some(off) = &self.off {
            spec.off.clone_from(off);
        }
    }

    /// What the flags describe.
    pub(crate) fn spec(&self) -> ChainSpec {
        let mut spec = ChainSpec::default();
        self.over(&mut spec);
        spec
    }
}
