use std::fmt;
use std::str::FromStr;

use super::text::Setting;
use super::{Aim, Coverage};
use crate::error::in_range;
use crate::{ModelError, unknown_name};

/// The most layers a plan may have.
pub const MAX_LAYERS: usize = 16;

/// Whether the ring in which two layers blend may be coarser than the acuity line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Blending {
    /// s from ω(e) (Guenter 2012, Eq. 2). Blending begins at 0.6·e, so in that ring the coarser layer
    /// mixes in too early and the image falls short of the acuity line.
    #[default]
    Paper,
    /// s from ω(0.6·e): no pixel is coarser than the acuity line.
    Strict,
}

/// How much samples of the layers that are drawn in every second frame count when the radii are
/// chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Weights {
    /// All alike (Guenter 2012, Eq. 4).
    #[default]
    Unit,
    /// The inner layer 1, all others ½.
    Half,
}

/// Settings of eccentricity layers, written `layers:N[:setting]…`:
///
/// | setting | meaning |
/// |---|---|
/// | `coverage=exact` (`exact`), `coverage=paper` (`paper`) | rectangles that estimates count; a drawn plan is always exact |
/// | `blending=paper`, `blending=strict` (`strict`) | whether the blended ring meets the acuity line |
/// | `weights=unit`, `weights=half` | what the radii are optimised for |
/// | `s2=VALUE` | the second layer's scale is given instead of found (Guenter's n = 3* has `s2=2`) |
/// | `tracked`, `fixed`, `fixed=DEG` | whether it follows the gaze (see [`Aim`]) |
///
/// Short forms stand in brackets; [`Display`](fmt::Display) writes what differs from the default, in
/// the order of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LayersSettings {
    /// At most how many layers, 1 to [`MAX_LAYERS`].
    pub count: usize,
    /// What estimates count.
    pub coverage: Coverage,
    /// Which acuity the blended ring meets.
    pub blending: Blending,
    /// What the radii are optimised for.
    pub weights: Weights,
    /// The second layer's scale, if given.
    pub second_scale: Option<f64>,
    /// Whether the layers follow the gaze.
    pub aim: Aim,
}

impl Blending {
    /// A layer keeps its full weight up to this fraction of its radius (Guenter 2012, §4.2: blended
    /// over the outer 40 %).
    pub const FULL_WEIGHT_TO: f64 = 0.6;

    /// The fraction of e_i from which layer i + 1 must satisfy the acuity line.
    pub(super) fn reach(self) -> f64 {
        match self {
            Self::Paper => 1.0,
            Self::Strict => Self::FULL_WEIGHT_TO,
        }
    }

    /// `paper` or `strict`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Strict => "strict",
        }
    }
}

impl Coverage {
    /// `exact` or `paper`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Paper => "paper",
        }
    }
}

impl Weights {
    /// The weight of every layer but the first.
    pub(super) fn outer(self) -> f64 {
        match self {
            Self::Unit => 1.0,
            Self::Half => 0.5,
        }
    }
}

impl LayersSettings {
    /// `count` layers and defaults.
    ///
    /// # Errors
    /// If `count` is not from 1 to [`MAX_LAYERS`].
    pub fn new(count: usize) -> Result<Self, ModelError> {
        let valid = 1..=MAX_LAYERS;
        if !valid.contains(&count) {
            return Err(bad_count(&count.to_string()));
        }
        Ok(Self {
            count,
            coverage: Coverage::default(),
            blending: Blending::default(),
            weights: Weights::default(),
            second_scale: None,
            aim: Aim::Tracked,
        })
    }

    /// Applies one setting.
    fn set(&mut self, text: &str) -> Result<(), ModelError> {
        const VALID: [&str; 10] = [
            "coverage=",
            "blending=",
            "weights=",
            "s2=",
            "exact",
            "paper",
            "strict",
            "tracked",
            "fixed",
            "fixed=",
        ];
        let Setting(key, value) = Setting::from(text);
        if let Some(aim) = Aim::read(key, value) {
            self.aim = aim?;
            return Ok(());
        }
        let (key, value) = match text {
            "exact" | "paper" => ("coverage", text),
            "strict" => ("blending", text),
            _ => (key, value.unwrap_or_default()),
        };
        match (key, value) {
            ("coverage", "exact") => self.coverage = Coverage::Exact,
            ("coverage", "paper") => self.coverage = Coverage::Paper,
            ("coverage", _) => return Err(unknown_name("coverage", value, &["exact", "paper"])),
            ("blending", "paper") => self.blending = Blending::Paper,
            ("blending", "strict") => self.blending = Blending::Strict,
            ("blending", _) => return Err(unknown_name("blending", value, &["paper", "strict"])),
            ("weights", "unit") => self.weights = Weights::Unit,
            ("weights", "half") => self.weights = Weights::Half,
            ("weights", _) => return Err(unknown_name("weights", value, &["unit", "half"])),
            ("s2", _) => self.second_scale = Some(self.parse_second_scale(value)?),
            _ => return Err(unknown_name("setting of layers", text, &VALID)),
        }
        Ok(())
    }

    fn parse_second_scale(&self, text: &str) -> Result<f64, ModelError> {
        let scale = text.parse().unwrap_or(f64::NAN);
        if self.count < 2 {
            let valid = "left out of layers:1, which has no second layer";
            return Err(ModelError::range("s2", text, valid));
        }
        let error = |_| ModelError::range("s2", text, "a number from 1 to 1000000");
        in_range("s2", scale, 1.0..=1e6).map_err(error)
    }
}

fn bad_count(given: &str) -> ModelError {
    let valid = format!("a whole number from 1 to {MAX_LAYERS}, as in layers:3");
    ModelError::range("number of layers", given, valid)
}

impl FromStr for LayersSettings {
    type Err = ModelError;

    /// Reads what follows `layers:`.
    fn from_str(text: &str) -> Result<Self, ModelError> {
        let mut parts = text.split(':');
        let count = parts.next().unwrap_or_default();
        let mut settings = Self::new(count.parse().map_err(|_| bad_count(count))?)?;
        for part in parts {
            settings.set(part)?;
        }
        Ok(settings)
    }
}

impl fmt::Display for LayersSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "layers:{}", self.count)?;
        if self.coverage == Coverage::Paper {
            f.write_str(":coverage=paper")?;
        }
        if self.blending == Blending::Strict {
            f.write_str(":blending=strict")?;
        }
        if self.weights == Weights::Half {
            f.write_str(":weights=half")?;
        }
        if let Some(scale) = self.second_scale {
            write!(f, ":s2={scale}")?;
        }
        self.aim.fmt(f)
    }
}
