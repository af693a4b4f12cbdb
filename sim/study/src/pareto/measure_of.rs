use std::str::FromStr;

use foveasim_models::{ModelError, unknown_name};

use super::ParetoRow;

/// What is compared as error: 0 is the reference, and more is worse.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ErrorMeasure {
    /// 1 − SSIM of luma.
    #[default]
    Dssim,
    /// Root of the mean squared error of luma \[grey levels of 255\]; PSNR is 20·log₁₀ of 255 over it.
    Rmse,
    /// Flicker of the error along the motion \[grey levels\].
    Flicker,
    /// 10 − JOD, as imported from FovVideoVDP.
    Jod,
}

impl ErrorMeasure {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Dssim, Self::Rmse, Self::Flicker, Self::Jod];

    /// As users write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Dssim => "dssim",
            Self::Rmse => "rmse",
            Self::Flicker => "flicker",
            Self::Jod => "jod",
        }
    }

    /// Name and unit, for an axis.
    pub fn label(self) -> &'static str {
        match self {
            Self::Dssim => "1 - SSIM",
            Self::Rmse => "error of luma (rms) [grey levels of 255]",
            Self::Flicker => "flicker along the motion [grey levels of 255]",
            Self::Jod => "quality lost, FovVideoVDP [JOD]",
        }
    }

    /// The error of a row; `None` where it is not known.
    pub fn of(self, row: &ParetoRow) -> Option<f64> {
        match self {
            Self::Dssim => Some(1.0 - row.errors.ssim),
            Self::Rmse => Some(row.errors.rmse()),
            Self::Flicker => row.errors.followed,
            Self::Jod => row.jod.map(|jod| 10.0 - jod),
        }
    }
}

impl FromStr for ErrorMeasure {
    type Err = ModelError;

    /// Reads a [name](Self::name).
    fn from_str(text: &str) -> Result<Self, ModelError> {
        let found = Self::ALL.into_iter().find(|m| m.name() == text);
        found.ok_or_else(|| unknown_name("measure of error", text, &Self::ALL.map(Self::name)))
    }
}
