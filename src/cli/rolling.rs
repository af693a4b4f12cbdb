//! Rolling displays and lenses: how `render` draws what each pixel shows when it lights.

use std::path::PathBuf;

use anyhow::{Context as _, anyhow};
use foveasim_models::{Display, Emission, LensSpec, Nanos, Pose, ScanSkew, Series};
use foveasim_render::Bound;
use foveasim_study::{Drawing, ScanMotion, head_after};
use foveasim_traces::{ReadOptions, read_path};

use super::{Failure, options};

/// Flags of scan and lens.
#[derive(Debug, clap::Args)]
pub(crate) struct RollingArgs {
    /// Draw what a rolling display shows: each pixel as the world is seen when it lights, in the display's
    /// direction and time of scan. The study scene's camera flies on meanwhile
    #[arg(long, conflicts_with = "stereo")]
    rolling: bool,
    /// From the first to the last line of the scan [ms] [default: the display's]
    #[arg(long, value_name = "MS", requires = "rolling")]
    scan_ms: Option<f64>,
    /// How fast the head turns to the left and up during the scan [deg/s]
    #[arg(
        long,
        value_name = "LEFT,UP",
        value_parser = options::pair,
        requires = "rolling",
        allow_hyphen_values = true
    )]
    head_velocity: Option<[f64; 2]>,
    /// How fast the head moves to the right, up and backwards, as it is turned [m/s]
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_parser = options::triple,
        requires = "rolling",
        allow_hyphen_values = true
    )]
    head_shift: Option<[f64; 3]>,
    /// A recording of head poses: the head moves as in it, from --at on
    #[arg(
        long,
        value_name = "FILE",
        requires_all = ["rolling", "at"],
        conflicts_with_all = ["head_velocity", "head_shift"]
    )]
    head_trace: Option<PathBuf>,
    /// When in the recording the scan begins, from its start [s]
    #[arg(long, value_name = "SECONDS", value_parser = options::duration, requires = "head_trace")]
    at: Option<Nanos>,
    /// Shade everything as seen from where the scan begins: only places roll
    #[arg(long, requires = "rolling")]
    start_shading: bool,
    /// A lens before the display, r·(1 + K1·r² + K2·r⁴) with r in halves of the width [and how much larger
    /// red, green and blue are seen] [default: the display's]
    #[arg(long, value_name = "K1,K2[,R,G,B]", value_parser = lens, allow_hyphen_values = true)]
    lens: Option<LensSpec>,
    /// Draw all triangles as if they moved, and find the samples to test by this bound: box, simple,
    /// adaptive (as published; they may miss samples) or conservative
    #[arg(long, value_name = "BOUND")]
    bound: Option<Bound>,
}

fn lens(text: &str) -> Result<LensSpec, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|v| v.trim().parse().ok()).collect();
    let (coefficients, chromatic) = match numbers.as_deref() {
        Some(&[k1, k2]) => ([k1, k2], [1.0; 3]),
        Some(&[k1, k2, r, g, b]) => ([k1, k2], [r, g, b]),
        _ => return Err("want two numbers K1,K2 or five K1,K2,R,G,B, as in 0.22,0.12".into()),
    };
    Ok(LensSpec {
        coefficients,
        centre: [0.5; 2],
        radius: 1.0,
        chromatic,
    })
}

/// A scan, and how the head moves in it.
pub(crate) struct Rolling {
    /// How long it takes.
    pub(crate) seconds: f64,
    skew: ScanSkew,
    /// The head at the scan's end, as seen by the head at its start.
    start_from_end: Pose,
}

/// The fastest that heads turn, and move: beyond it a number is a slip.
const FASTEST_DEG_PER_S: f64 = 10_000.0;
const FASTEST_M_PER_S: f64 = 1000.0;
/// Between samples of a recording at most so long is interpolated.
const LONGEST_GAP: Nanos = Nanos(100_000_000);

impl RollingArgs {
    /// Refuses flags that say nothing about a volume.
    pub(crate) fn none_for_a_volume(&self) -> Result<(), Failure> {
        let given = [
            ("--rolling", self.rolling),
            ("--lens", self.lens.is_some()),
            ("--bound", self.bound.is_some()),
        ];
        match given.iter().find(|(_, given)| *given) {
            Some((flag, _)) => Err(Failure::bad_input(format!("{flag}: not with a volume"))),
            None => Ok(()),
        }
    }

    /// The scan that the flags ask for, if any.
    pub(crate) fn scan(&self, display: &Display) -> Result<Option<Rolling>, Failure> {
        if !self.rolling {
            return Ok(None);
        }
        let refuse = |text: String| Err(Failure::bad_input(text));
        let name = &display.name;
        if display.response.emission == Emission::Global && self.scan_ms.is_none() {
            return refuse(format!(
                "--rolling: {name} lights all rows at once; give --scan-ms for one that does not"
            ));
        }
        let time = match self.scan_ms {
            Some(ms) => options::milliseconds("--scan-ms", ms)?,
            None => display.scan.active(),
        };
        let start_from_end = match (&self.head_trace, self.at) {
            (Some(path), Some(at)) => recorded(path, at, time)?,
            _ => self.given(time.as_secs())?,
        };
        Ok(Some(Rolling {
            seconds: time.as_secs(),
            skew: display.scan.picture_skew(),
            start_from_end,
        }))
    }

    /// How the head moves in a scan by the velocities given.
    fn given(&self, seconds: f64) -> Result<Pose, Failure> {
        let [left, up] = self.head_velocity.unwrap_or_default();
        if left.abs().max(up.abs()) > FASTEST_DEG_PER_S {
            return Err(Failure::bad_input(format!(
                "--head-velocity {left},{up}: must be within ±{FASTEST_DEG_PER_S} degrees per second"
            )));
        }
        let shift = self.head_shift.unwrap_or_default();
        if shift.iter().any(|v| v.abs() > FASTEST_M_PER_S) {
            return Err(Failure::bad_input(format!(
                "--head-shift {shift:?}: must be within ±{FASTEST_M_PER_S} metres per second"
            )));
        }
        Ok(head_after([left, up], shift, seconds))
    }

    /// Tells the renderer what the flags say besides; a display's own lens counts unless another is given.
    pub(crate) fn apply(&self, drawing: &mut Drawing, own: Option<LensSpec>) {
        drawing.lens = self.lens.or(own);
        drawing.options.bound = self.bound;
        drawing.options.rolling_shading = !self.start_shading;
    }
}

/// How a recorded head moves from `at` on for `time`.
fn recorded(path: &std::path::Path, at: Nanos, time: Nanos) -> Result<Pose, Failure> {
    let named = || format!("--head-trace {}", path.display());
    let recording = read_path(path, &ReadOptions::default()).with_context(named)?;
    let Some(poses) = &recording.pose else {
        return Err(anyhow!("{}: has no head poses", named()).into());
    };
    let start = recording.span().map_or(poses.start(), |(start, _)| start) + at;
    let pose = |poses: &Series<Pose>, t: Nanos| {
        let found = poses.at(t, LONGEST_GAP);
        found.ok_or_else(|| {
            let lasts = (poses.end() - poses.start()).as_secs();
            let (at, time) = (at.as_secs(), time.as_ms());
            anyhow!("--at {at}: no head pose from there on for {time} ms; poses last {lasts} s")
        })
    };
    let (first, last) = (pose(poses, start)?, pose(poses, start + time)?);
    Ok(first.inverse().then(last))
}

impl Rolling {
    /// The scan of an eye that the scene's own camera takes to `later` meanwhile. The head's motion comes on top.
    pub(crate) fn motion(&self, later: Pose) -> ScanMotion {
        ScanMotion {
            end: later.then(self.start_from_end),
            skew: self.skew,
        }
    }
}
