//! Studies: where models, traces, pipeline, renderer, metrics and reports meet.
//!
//! * [`Sweep`]: sample counts over displays, methods, acuity, gaze and margins;
//! * [`Calibration`]: what work costs, fitted to measured frames;
//! * [`Verify`]: frame times predicted before cells are drawn, beside those measured ([`measure()`]);
//! * [`Pareto`]: methods by time and error, on scenes and recordings;
//! * [`SpacingStudy`]: how far apart every method's samples lie, and the kernel that needs the fewest;
//! * [`LatencyStudy`]: gaze-to-photon time, simulated and bounded;
//! * [`EventStudy`]: fixations, saccades and blinks of a recording;
//! * [`PredictionStudy`]: how well head pose is foreseen in a recording;
//! * [`ScanlineStudy`]: how far the view is off, row by row;
//! * [`replay()`]: a recording, frame by displayed frame, and [`PhaseStudy`]: by what the eye does;
//! * [`FrameStudy`]: one frame by any method beside its reference;
//! * [`StereoStudy`]: one frame of both eyes of a headset;
//! * [`TemporalStudy`]: consecutive frames beside a [`supersampled`] reference: what flickers;
//! * [`MaskReport`]: what there is to say of a sampling mask;
//! * [`KernelTimes`], [`KernelErrors`]: what kernel foveated rendering pays in time and costs in error;
//! * [`StressStudy`]: closed forms and kernels over extreme inputs;
//! * [`Guenter2012`], [`Meng2020`], [`Friston2019`], [`Bruder2019`]: a paper's tables and figures, ours beside theirs;
//! * [`Scenario`] and [`run()`]: all of it, in one report.

mod calibrate;
mod chain;
mod events;
mod frame;
mod kernel;
mod latency;
mod line;
mod mask;
mod measure;
mod numbers;
mod pareto;
mod prediction;
mod recording;
mod replay;
mod reproduce;
mod run;
mod scan_motion;
mod scanlines;
mod scenario;
mod spacing;
mod stereo;
mod stress;
mod supersample;
mod sweep;
mod temporal;
mod tracks;
mod verify;

pub use calibrate::{
    Calibration, Coefficient, CostFit, CostRow, CostRows, non_negative_least_squares,
};
pub use chain::{Anomaly, Chain, ChainSpec, DriftSpec, HeadSampling, PARTS, Part, render_law};
pub use events::EventStudy;
pub use frame::{Drawing, FrameError, FrameOutcome, FrameStudy, Shot, Sight};
pub use kernel::{
    KernelErrorRow, KernelErrors, KernelMeasured, KernelRing, KernelTimeRow, KernelTimes,
    KernelTimings,
};
pub use latency::{
    Band, Budget, FIG5_READINGS, Fig5Reading, Fig5Result, Histogram, KNOBS, Knob, LatencyError,
    LatencyResult, LatencySample, LatencyStudy, MAX_RUNS, QUANTITIES, Quantity, ROWS, Rows,
    RunStart, Sensitivity, sensitivity_table, tornado,
};
pub use mask::{MaskReport, interpolation as mask_interpolation};
pub use measure::{Clock, Job, JobFrame, Measured, measure};
pub use numbers::parse_numbers;
pub use pareto::{
    Answer, Clip, ClipFrame, ErrorMeasure, Export, Pareto, ParetoErrors, ParetoOutcome, ParetoRing,
    ParetoRow, Scores, ShowPair, Timing,
};
pub use prediction::{ErrorSpread, Prediction, PredictionRow, PredictionStudy};
pub use recording::recording_table;
pub use replay::{
    Difference, GazePhase, GazePhases, GazeState, Golden, GoldenCheck, LANDING, Margin, PhaseRow,
    PhaseSpec, PhaseStudy, REPLAY_COLUMNS, Replay, ReplayError, ReplayFrame, ReplayOptions,
    ReplayRun, ReplaySummary, ReplayTally, Sketch, Spread, Suppression, head_predictor, replay,
    replay_each, replay_streamed,
};
pub use reproduce::{
    AllPublished, Antialiasing, Bruder2019, Bruder2019Outcome, BruderErrors, BruderFound,
    BruderMasks, BruderRing, BruderRow, BruderTimes, BruderVolume, Column, DominanceFit, Family,
    Fig7User, Footing, FoveatedRow, FoveatedWay, Friston2019, Friston2019Outcome, Guenter2012,
    Guenter2012Outcome, HeadRow, LatencyBars, LatencyRow, Meng2020, Paper, Payoff, PayoffRow,
    Predicted, PredictedRow, Printed, Progress, Published, QualityRow, QualitySweep,
    ReproduceError, Reproduction, ResolutionRow, RollingRow, RollingWay, ShadowRow, Stein2021,
    SteinRow, StrengthRow, Table1, Table1Cell, TimeFit, Times, UserSigmas, Verdict,
};
pub use run::{
    Evidence, EvidenceError, Growth, MARGIN_TOLERANCE_DEG, MOMENT_PICTURES, MarginLoop, MarginStep,
    MethodSaving, Moment, PlanCost, Run, RunError, Savings, close_margin, run,
};
pub use scan_motion::{ScanMotion, head_after};
pub use scanlines::{ImageKind, ScanlineErrors, ScanlineStudy, Scanlines};
pub use scenario::{
    GazeSource, MapGrid, RenderTime, Scenario, ScenarioError, ScenarioSpec, cost, display,
    read_text, tracker,
};
pub use spacing::{CurvePoint, SpacingCurve, SpacingOutcome, SpacingRow, SpacingStudy};
pub use stereo::{StereoOutcome, StereoStudy};
pub use stress::{StressRow, StressStudy};
pub use supersample::supersampled;
pub use sweep::{
    Buffers, DensityAt, Drawn, Fits, GazeAt, Link, MapRatio, Needs, Outcome, Resolution,
    SWEEP_COLUMNS, SWEEP_TEXT_COLUMNS, SWEEP_WHOLE_COLUMNS, SavingsSpread, SavingsSpreadRow, Shard,
    Solution, Solve, Sweep, SweepDisplay, SweepEye, SweepRow, Target, Terms, Unknown,
};
pub use temporal::{FrameSource, PlaceSource, TemporalQuality, TemporalRing, TemporalStudy};
pub use tracks::Tracks;
pub use verify::{HeldOutFor, Verify, VerifyOutcome, VerifyRow, VerifyScene};
