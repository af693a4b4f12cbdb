use std::fmt;
use std::str::FromStr;

use super::Aim;
use super::text::{Setting, number, settings};
use crate::error::in_range;
use crate::{Interpolation, ModelError, unknown_name};

/// Settings of kernel foveated rendering (Meng 2018; Meng 2020, §3.1), written
/// `kfr:SIGMA:ALPHA[:setting]…`:
///
/// | setting | meaning |
/// |---|---|
/// | `SIGMA` | display pixels per sample along each side of the buffer, which is W/σ × H/σ; 0.25 to 100 |
/// | `ALPHA` | the kernel's exponent: r = exp(L·(σu)^α); 0.01 to 100 |
/// | `form=direct` (`direct`), `form=published` (`published`) | the scene is sampled at log-polar positions, or visibility is found at full resolution and only shading is log-polar |
/// | `filter=bilinear`, `nearest`, `cubic`, `gather` | between samples (see [`Interpolation`]) |
/// | `smooth` | a 3 × 3 Gaussian in the periphery: over samples that are larger than a pixel |
/// | `mips` | the mean where several samples fall into a pixel |
/// | `tracked`, `fixed`, `fixed=DEG` | whether it follows the gaze (see [`Aim`]) |
///
/// The paper's α = 4 puts samples close together about the gaze: at σ = 2 on 1280 × 1440 pixels, 88 % of them
/// within 63 pixels, where they are denser than the display's. Its co-author's program has the inverse
/// exponent, which is α = ¼ here.
///
/// σ and α say where samples lie, whatever the acuity line and the margin; [`KernelSearch`](super::KernelSearch)
/// finds those that keep to them. For the same reason a fixed one is only moved, not made finer. With σ = 1
/// there are as many samples as pixels, not the pixels themselves: the periphery is coarser for what the
/// centre has more.
///
/// [`Display`](fmt::Display) writes what differs from the default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KernelSettings {
    sigma: f64,
    alpha: f64,
    /// Where visibility is found.
    pub form: KernelForm,
    /// Between samples.
    pub interpolation: Interpolation,
    /// Whether the periphery is smoothed.
    pub smooth: bool,
    /// Whether several samples in a pixel are averaged.
    pub mips: bool,
    aim: Aim,
}

/// Where visibility is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum KernelForm {
    /// At the log-polar samples: there is no pass at full resolution.
    #[default]
    Direct,
    /// At every display pixel, as published: a deferred pass of which log-polar samples are shaded.
    Published,
}

impl KernelForm {
    /// `direct` or `published`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Direct => "direct",
            Self::Published => "published",
        }
    }
}

impl KernelSettings {
    /// The kernel exponent that the paper suggests (Meng 2020, §3.1).
    pub const PUBLISHED_ALPHA: f64 = 4.0;

    /// The direct form, bilinear, following the gaze.
    ///
    /// # Errors
    /// If σ is not from 0.25 to 100 or α not from 0.01 to 100.
    pub fn new(sigma: f64, alpha: f64) -> Result<Self, ModelError> {
        Ok(Self {
            sigma: in_range("sigma", sigma, SIGMA)?,
            alpha: in_range("alpha", alpha, ALPHA)?,
            form: KernelForm::Direct,
            interpolation: Interpolation::Bilinear,
            smooth: false,
            mips: false,
            aim: Aim::Tracked,
        })
    }

    /// Display pixels per sample along each side of the buffer.
    pub fn sigma(&self) -> f64 {
        self.sigma
    }

    /// The kernel's exponent.
    pub fn alpha(&self) -> f64 {
        self.alpha
    }

    /// Whether it follows the gaze.
    pub fn aim(&self) -> Aim {
        self.aim
    }

    pub(super) fn with_aim(self, aim: Aim) -> Self {
        Self { aim, ..self }
    }

    /// The same with another σ.
    ///
    /// # Errors
    /// If σ is not from 0.25 to 100.
    pub fn with_sigma(self, sigma: f64) -> Result<Self, ModelError> {
        let sigma = in_range("sigma", sigma, SIGMA)?;
        Ok(Self { sigma, ..self })
    }

    /// The same with another α.
    ///
    /// # Errors
    /// If α is not from 0.01 to 100.
    pub fn with_alpha(self, alpha: f64) -> Result<Self, ModelError> {
        let alpha = in_range("alpha", alpha, ALPHA)?;
        Ok(Self { alpha, ..self })
    }

    /// Applies a setting other than σ and α; `others` are valid as well, for the error.
    pub(super) fn set(
        &mut self,
        setting: Setting<'_>,
        kind: &'static str,
        others: &[&str],
    ) -> Result<(), ModelError> {
        match setting {
            Setting("direct", None) | Setting("form", Some("direct")) => {
                self.form = KernelForm::Direct;
            }
            Setting("published", None) | Setting("form", Some("published")) => {
                self.form = KernelForm::Published;
            }
            Setting("form", Some(form)) => {
                return Err(unknown_name("form", form, &["direct", "published"]));
            }
            Setting("filter", Some(filter)) => self.interpolation = filter.parse()?,
            Setting("smooth", None) => self.smooth = true,
            Setting("mips", None) => self.mips = true,
            other => {
                let own = ["direct", "published", "form=", "filter=", "smooth", "mips"];
                self.aim = other.aim(kind, &[others, &own].concat())?;
            }
        }
        Ok(())
    }

    /// What [`KernelSettings::set`] reads, where it differs from the default.
    pub(super) fn write_options(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.form == KernelForm::Published {
            f.write_str(":published")?;
        }
        if self.interpolation != Interpolation::default() {
            write!(f, ":filter={}", self.interpolation.name())?;
        }
        if self.smooth {
            f.write_str(":smooth")?;
        }
        if self.mips {
            f.write_str(":mips")?;
        }
        fmt::Display::fmt(&self.aim, f)
    }
}

/// Valid σ.
pub(super) const SIGMA: std::ops::RangeInclusive<f64> = 0.25..=100.0;
/// Valid α.
pub(super) const ALPHA: std::ops::RangeInclusive<f64> = 0.01..=100.0;

impl FromStr for KernelSettings {
    type Err = ModelError;

    /// Reads what follows `kfr:`.
    fn from_str(text: &str) -> Result<Self, ModelError> {
        let mut parts = settings(text);
        let sigma = number("sigma of kfr", parts.next(), SIGMA, "kfr:2:4")?;
        let alpha = number("alpha of kfr", parts.next(), ALPHA, "kfr:2:4")?;
        let mut read = Self::new(sigma, alpha)?;
        for setting in parts {
            read.set(setting, "setting of kfr", &[])?;
        }
        Ok(read)
    }
}

impl fmt::Display for KernelSettings {
    /// What follows `kfr`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, ":{}:{}", self.sigma, self.alpha)?;
        self.write_options(f)
    }
}
