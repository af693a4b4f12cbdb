use thiserror::Error;

/// Why a plan of a view cannot be drawn.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The view moves, and nothing says when which pixel lights.
    #[error(
        "the view moves from its first to its last pose, but has no scan that says when each pixel lights"
    )]
    MovingView,
    /// Something that is drawn of still views alone.
    #[error("{what} cannot be drawn of {of}: {valid}")]
    Still {
        /// What was asked for.
        what: &'static str,
        /// Of which view.
        of: &'static str,
        /// What can be.
        valid: &'static str,
    },
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
