use thiserror::Error;

/// Why rays are not cast.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CastError {
    /// A number that cannot be used.
    #[error("{field} = {value}: must be {valid}")]
    OutOfRange {
        /// Which number.
        field: &'static str,
        /// What it is.
        value: String,
        /// What it may be.
        valid: &'static str,
    },
    /// The view moves while it is scanned.
    #[error("the view moves while it is scanned: volumes are drawn from one place")]
    MovingView,
    /// The plan is for an image of another size.
    #[error("{method} is planned for {plan} pixels, the view has {view}")]
    OtherSize {
        /// The plan's method.
        method: String,
        /// Its size.
        plan: String,
        /// The view's.
        view: String,
    },
    /// A pass's samples do not lie on a grid.
    #[error("{method}: pass {pass}: its samples lie on no grid")]
    Lattice {
        /// The plan's method.
        method: String,
        /// Which pass.
        pass: usize,
    },
    /// The steps of a ray cannot be used.
    #[error("ray {ray}: step factor {step}: must be from 1/16 to 4096")]
    Step {
        /// Which ray.
        ray: usize,
        /// Its factor.
        step: f32,
    },
}

impl CastError {
    pub(crate) fn range(field: &'static str, value: impl ToString, valid: &'static str) -> Self {
        Self::OutOfRange {
            field,
            value: value.to_string(),
            valid,
        }
    }
}
