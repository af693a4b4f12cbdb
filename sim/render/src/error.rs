use thiserror::Error;

/// Why a plan of a view cannot be drawn.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The view moves while it is scanned.
    #[error("the view moves between its first and last row; only still views can be drawn")]
    MovingView,
    /// The view or an option has a number that cannot be used.
    #[error("{field} = {value}: must be {valid}")]
    OutOfRange {
        /// Which number.
        field: &'static str,
        /// Its value.
        value: String,
        /// What would be valid.
        valid: String,
    },
    /// The plan is for an image of another size.
    #[error("the plan `{method}` is for {plan} pixels, the view has {view}")]
    OtherSize {
        /// The plan's method.
        method: String,
        /// Size the plan is for.
        plan: String,
        /// Size of the view.
        view: String,
    },
    /// A pass cannot be drawn.
    #[error("pass {pass} of the plan `{method}`: {why}")]
    Pass {
        /// The plan's method.
        method: String,
        /// Which pass, from 0.
        pass: usize,
        /// What is wrong.
        why: String,
    },
    /// The passes do not fit the way they are to be put together.
    #[error("the plan `{method}` cannot be resolved: {why}")]
    Resolve {
        /// The plan's method.
        method: String,
        /// What is wrong.
        why: String,
    },
}
