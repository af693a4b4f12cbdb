use std::process::ExitCode;

use foveasim_study::{LatencyError, RunError};

/// Why a command did not succeed.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The input cannot be used: exit 2.
    BadInput(anyhow::Error),
    /// The command ran, and a check that was asked for did not hold: exit 1.
    CheckFailed(String),
    /// Nobody reads our output any more (`foveasim … | head`): not a failure.
    PipeClosed,
}

impl Failure {
    /// Bad input described by `text`.
    pub(crate) fn bad_input(text: impl std::fmt::Display) -> Self {
        Self::BadInput(anyhow::anyhow!("{text}"))
    }

    /// Prints one line on standard error and returns the exit code.
    #[expect(
        clippy::print_stderr,
        reason = "the one place where failures reach the user"
    )]
    pub(crate) fn report(self) -> ExitCode {
        match self {
            Self::BadInput(error) => {
                eprintln!("foveasim: {error:#}");
                ExitCode::from(2)
            }
            Self::CheckFailed(text) => {
                eprintln!("foveasim: {text}");
                ExitCode::from(1)
            }
            Self::PipeClosed => ExitCode::SUCCESS,
        }
    }
}

impl<E: Into<anyhow::Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        let error = error.into();
        match contradicts(&error) {
            true => Self::CheckFailed(format!("{error:#}")),
            false => Self::BadInput(error),
        }
    }
}

/// Whether a simulation contradicts its own bounds: no fault of the input.
fn contradicts(error: &anyhow::Error) -> bool {
    let latency = match error.downcast_ref::<RunError>() {
        Some(RunError::Latency(latency)) => Some(latency),
        _ => error.downcast_ref::<LatencyError>(),
    };
    matches!(latency, Some(LatencyError::OutsideBounds { .. }))
}
