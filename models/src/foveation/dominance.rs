use std::fmt;
use std::str::FromStr;

use super::text::{Setting, number, settings};
use super::{Aim, KernelSettings};
use crate::error::in_range;
use crate::{Eye, ModelError, unknown_name};

/// Settings of eye-dominance-guided foveated rendering (Meng 2020, §3.2): kernel foveated rendering that is
/// coarser for the eye that vision relies on less, written `efr:SIGMA_D:SIGMA_ND[:setting]…`:
///
/// | setting | meaning |
/// |---|---|
/// | `SIGMA_D` | σ of the dominant eye, 0.25 to 100 |
/// | `SIGMA_ND` | σ of the other eye, from σ_d to 100 |
/// | `dominant=left`, `dominant=right` | which eye is dominant (right) |
/// | `alpha=ALPHA` | the kernel's exponent (4, the paper's) |
///
/// and those of [`KernelSettings`]. One image for both eyes is drawn as the dominant eye's.
///
/// [`Display`](fmt::Display) writes what differs from the default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DominanceSettings {
    dominant: KernelSettings,
    other: KernelSettings,
    dominant_eye: Eye,
}

impl DominanceSettings {
    /// As `kernel` says for the dominant eye, with `other_sigma` for the other one.
    ///
    /// # Errors
    /// If `other_sigma` is not from the kernel's σ to 100, or the dominant eye neither left nor right.
    pub fn new(
        kernel: KernelSettings,
        other_sigma: f64,
        dominant_eye: Eye,
    ) -> Result<Self, ModelError> {
        in_range(
            "sigma of the other eye",
            other_sigma,
            kernel.sigma()..=100.0,
        )?;
        if dominant_eye == Eye::Cyclopean {
            return Err(ModelError::range(
                "dominant eye",
                "cyclopean",
                "left or right",
            ));
        }
        Ok(Self {
            dominant: kernel,
            other: kernel.with_sigma(other_sigma)?,
            dominant_eye,
        })
    }

    /// Which eye is dominant: left or right.
    pub fn dominant_eye(&self) -> Eye {
        self.dominant_eye
    }

    /// How `eye`'s image is drawn.
    pub fn of_eye(&self, eye: Eye) -> KernelSettings {
        if eye == self.dominant_eye || eye == Eye::Cyclopean {
            self.dominant
        } else {
            self.other
        }
    }

    /// S of Eq. 9, over kernel foveated rendering with σ_d for both eyes.
    pub fn speedup(&self) -> f64 {
        dominance_speedup(self.dominant.sigma(), self.other.sigma())
    }

    /// Whether it follows the gaze.
    pub fn aim(&self) -> Aim {
        self.dominant.aim()
    }

    pub(super) fn with_aim(self, aim: Aim) -> Self {
        Self {
            dominant: self.dominant.with_aim(aim),
            other: self.other.with_aim(aim),
            ..self
        }
    }
}

/// How many times faster two eyes are drawn with σ_d and σ_nd than both with σ_d, as far as time goes with
/// the buffer: a frame of one eye that takes T takes T/σ² (Meng 2020, Eqs 6 and 7), so that
/// S = 2/(1 + (σ_d/σ_nd)²) (Eq. 9). It is at least 1 if σ_nd ≥ σ_d (Eq. 8). For (2, 3) it is 18/13.
pub fn dominance_speedup(dominant_sigma: f64, other_sigma: f64) -> f64 {
    let ratio = dominant_sigma / other_sigma;
    2.0 / (1.0 + ratio * ratio)
}

impl FromStr for DominanceSettings {
    type Err = ModelError;

    /// Reads what follows `efr:`.
    fn from_str(text: &str) -> Result<Self, ModelError> {
        const EXAMPLE: &str = "efr:2:3";
        let mut parts = settings(text);
        let sigma = number(
            "sigma of the dominant eye",
            parts.next(),
            0.25..=100.0,
            EXAMPLE,
        )?;
        let other = number(
            "sigma of the other eye",
            parts.next(),
            sigma..=100.0,
            EXAMPLE,
        )?;
        let mut kernel = KernelSettings::new(sigma, KernelSettings::PUBLISHED_ALPHA)?;
        let mut dominant = Eye::Right;
        for setting in parts {
            match setting {
                Setting("dominant", Some("left")) => dominant = Eye::Left,
                Setting("dominant", Some("right")) => dominant = Eye::Right,
                Setting("dominant", Some(eye)) => {
                    return Err(unknown_name("dominant eye", eye, &["left", "right"]));
                }
                Setting("alpha", Some(alpha)) => {
                    let alpha = alpha.parse().map_err(|_| {
                        ModelError::range("alpha", alpha, "a number from 0.01 to 100")
                    })?;
                    kernel = kernel.with_alpha(alpha)?;
                }
                other => kernel.set(other, "setting of efr", &["dominant=", "alpha="])?,
            }
        }
        Self::new(kernel, other, dominant)
    }
}

impl fmt::Display for DominanceSettings {
    /// What follows `efr`.
    #[expect(clippy::float_cmp_const, reason = "a default, exactly or not")]
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, ":{}:{}", self.dominant.sigma(), self.other.sigma())?;
        if self.dominant_eye == Eye::Left {
            f.write_str(":dominant=left")?;
        }
        if self.dominant.alpha() != KernelSettings::PUBLISHED_ALPHA {
            write!(f, ":alpha={}", self.dominant.alpha())?;
        }
        self.dominant.write_options(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// oracle s3 speedup
    #[test]
    fn speedups_are_equation_9() {
        for (d, nd, speedup) in [
            (2.0, 3.0, 18.0 / 13.0),
            (1.2, 2.0, 1.470_588_235_294_117_8),
            (1.2, 4.0, 1.834_862_385_321_100_8),
            (1.8, 2.4, 1.28),
            (1.8, 4.0, 1.663_201_663_201_663),
            (2.4, 2.4, 1.0),
            (2.4, 3.0, 1.219_512_195_121_951_2),
        ] {
            assert!((dominance_speedup(d, nd) - speedup).abs() < 1e-14);
        }
        let settings: DominanceSettings = "2:3:dominant=left:alpha=1".parse().unwrap();
        assert!((settings.speedup() - 1.384_615_384_615_384_6).abs() < 1e-15);
        let sigma = |eye| settings.of_eye(eye).sigma();
        assert_eq!(
            [Eye::Left, Eye::Right, Eye::Cyclopean].map(sigma),
            [2.0, 3.0, 2.0]
        );
    }
}
