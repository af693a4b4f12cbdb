//! Papers' tables and figures, ours beside theirs: Guenter et al., *Foveated 3D Graphics*, 2012; Meng et al.,
//! *Eye-dominance-guided Foveated Rendering*, 2020; Friston et al., *Perceptual Rasterization*, 2019; Bruder et al.,
//! *Voronoi-Based Foveated Volume Rendering*, 2019; and the latencies of Stein et al., 2021.

mod all;
mod bruder;
mod friston;
mod guenter;
mod meng;
mod paper;
mod published;
mod reproduction;
mod stein;

use foveasim_mask::MaskError;
use foveasim_models::ModelError;
use foveasim_quality::QualityError;
use foveasim_render::RenderError;
use foveasim_reports::ReportError;
use foveasim_traces::TraceError;
use foveasim_volume::CastError;
use thiserror::Error;

pub use all::AllPublished;
pub use bruder::{
    Bruder2019, Bruder2019Outcome, BruderErrors, BruderFound, BruderMasks, BruderRing, BruderRow,
    BruderTimes, BruderVolume,
};
pub use friston::{
    Family, FoveatedRow, FoveatedWay, Friston2019, Friston2019Outcome, HeadRow, ResolutionRow,
    RollingRow, RollingWay, ShadowRow, StrengthRow,
};
pub use guenter::{
    Antialiasing, Column, Guenter2012, Guenter2012Outcome, LatencyBars, LatencyRow, Payoff,
    PayoffRow, Predicted, PredictedRow, QualityRow, QualitySweep, Table1, Table1Cell, TimeFit,
    Times,
};
pub use meng::{DominanceFit, Fig7User, Meng2020, UserSigmas};
pub use paper::Paper;
pub use published::{Footing, Printed, Published, Verdict};
pub use reproduction::{Progress, Reproduction};
pub use stein::{Stein2021, SteinRow};

use crate::{FrameError, LatencyError};

/// Why a paper could not be reproduced.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReproduceError {
    /// A number outside what can be measured.
    #[error("{field} = {value}: must be {valid}")]
    OutOfRange {
        /// What.
        field: &'static str,
        /// The value given.
        value: u32,
        /// What would be valid.
        valid: &'static str,
    },
    /// A model refuses a number.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A frame cannot be planned or drawn.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// A frame cannot be drawn.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// Images cannot be compared.
    #[error(transparent)]
    Quality(#[from] QualityError),
    /// There is no mask, or no image from it.
    #[error(transparent)]
    Mask(#[from] MaskError),
    /// Rays cannot be cast.
    #[error(transparent)]
    Cast(#[from] CastError),
    /// Latency cannot be bounded.
    #[error(transparent)]
    Latency(#[from] LatencyError),
    /// A movement cannot be made, or has no poses.
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// The report cannot be made.
    #[error(transparent)]
    Report(#[from] ReportError),
}

pub(crate) fn check(
    field: &'static str,
    value: u32,
    range: std::ops::RangeInclusive<u32>,
    valid: &'static str,
) -> Result<(), ReproduceError> {
    if range.contains(&value) {
        return Ok(());
    }
    Err(ReproduceError::OutOfRange {
        field,
        value,
        valid,
    })
}

/// Tells `progress` of `steps` equal steps from one share of the whole to another.
pub(crate) fn stepper<'a>(
    progress: &'a dyn Fn(&str, f64),
    what: &'static str,
    [from, to]: [f64; 2],
    steps: f64,
) -> impl FnMut() + 'a {
    let mut taken = 0.0;
    progress(what, from);
    move || {
        taken += 1.0;
        progress(what, from + (to - from) * taken / steps);
    }
}

/// What must hold of the printed numbers of a paper, however small its reproduction: they are there, nothing differs
/// unexplained, and no time of this machine agrees.
#[cfg(test)]
fn check_published(
    numbers: &[Published],
    paper: Paper,
    agreed: usize,
    explained: usize,
    times: usize,
) {
    for p in numbers {
        assert_eq!(p.paper, paper);
        assert_ne!(p.verdict(), Verdict::Differs, "{p:?}");
        let same = numbers
            .iter()
            .filter(|q| (q.place, &q.quantity) == (p.place, &p.quantity));
        assert_eq!(same.count(), 1, "{p:?} stands there once");
        assert_eq!(
            p.verdict() == Verdict::Explained,
            p.why().is_some(),
            "{p:?}"
        );
        assert!(
            !p.is_measured() || p.verdict() == Verdict::Explained,
            "{p:?}"
        );
    }
    let count = |verdict, measured| {
        let of = |p: &&Published| p.verdict() == verdict && p.is_measured() == measured;
        numbers.iter().filter(of).count()
    };
    let found = [
        count(Verdict::Agreed, false),
        count(Verdict::Explained, false),
        count(Verdict::Explained, true),
    ];
    assert_eq!(found, [agreed, explained, times], "{paper}");
}
