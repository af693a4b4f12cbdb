use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::error::in_range;
use crate::presets::Source;
use crate::{
    Durations, EnergyProfile, GazeDirection, ModelError, Nanos, Pose, Role, Stream, unknown_name,
};

/// What a frame knew when its rendering began: all that its cost may depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameInput {
    /// Frame number, from 0.
    pub id: u64,
    /// When rendering began.
    pub start: Nanos,
    /// The gaze believed then.
    pub gaze: Option<GazeDirection>,
    /// `world_from_head` believed then.
    pub pose: Option<Pose>,
}

/// How long a frame takes to render. Never measured with a clock inside a simulation: the same input
/// gives the same duration.
pub trait FrameCost {
    /// The rendering time of `frame`, at least 0.
    fn duration(&self, frame: &FrameInput) -> Nanos;
}

/// Every frame takes the same time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FixedCost(pub Nanos);

impl FrameCost for FixedCost {
    fn duration(&self, _: &FrameInput) -> Nanos {
        self.0
    }
}

/// Every frame takes a time of its own, drawn from a law: the same for the same seed, run and frame,
/// whatever else is drawn.
#[derive(Debug, Clone, Copy)]
pub struct DrawnCost<'a> {
    /// The law.
    pub law: &'a Durations,
    /// Seed of the draws.
    pub seed: u64,
    /// Runs of one seed draw independently.
    pub run: u64,
}

impl FrameCost for DrawnCost<'_> {
    fn duration(&self, frame: &FrameInput) -> Nanos {
        if self.law.min() == self.law.max() {
            return self.law.min();
        }
        let seed = self.seed.wrapping_add(self.run.rotate_left(32));
        self.law
            .draw(&mut Stream::new(seed, Role::RenderTime, frame.id))
    }
}

/// Measured frames one after the other, from the first again after the last.
#[derive(Debug, Clone, Copy)]
pub struct MeasuredCost<'a>(pub &'a [Nanos]);

impl FrameCost for MeasuredCost<'_> {
    /// 0 for every frame if nothing was measured.
    fn duration(&self, frame: &FrameInput) -> Nanos {
        match self.0.len() as u64 {
            0 => Nanos::ZERO,
            n => self.0[(frame.id % n) as usize],
        }
    }
}

/// What a planner can say of a frame before it is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrameWork {
    /// Evaluations of shading.
    pub samples_shaded: f64,
    /// Places where visibility is found: more than are shaded under variable-rate shading.
    pub samples: f64,
    /// Display pixels put together from samples that are not their own.
    pub pixels_resolved: f64,
    /// Passes drawn.
    pub passes: f64,
}

impl FrameWork {
    /// The names of its parts, as in profiles and in columns of measured rows.
    pub const TERMS: [&str; 4] = ["samples_shaded", "samples", "pixels_resolved", "passes"];

    /// Its parts, in the order of [`FrameWork::TERMS`].
    pub fn terms(&self) -> [f64; 4] {
        [
            self.samples_shaded,
            self.samples,
            self.pixels_resolved,
            self.passes,
        ]
    }
}

impl From<[f64; 4]> for FrameWork {
    fn from([samples_shaded, samples, pixels_resolved, passes]: [f64; 4]) -> Self {
        Self {
            samples_shaded,
            samples,
            pixels_resolved,
            passes,
        }
    }
}

/// How the parts of a frame's time go together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CostForm {
    /// One after the other.
    #[default]
    Sum,
    /// At once: after what is fixed, the stage that takes longest decides.
    Largest,
}

impl CostForm {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Sum, Self::Largest];

    /// As in profiles.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sum => "sum",
            Self::Largest => "largest",
        }
    }
}

/// Time from counts: what is fixed, and the sum (or the largest) of coefficients times work, with where the
/// coefficients come from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CostProfile {
    /// Short name, as given to `--cost`.
    pub name: String,
    /// What machine and content it stands for, and what it was checked against.
    #[serde(default)]
    pub title: String,
    /// How the parts go together.
    #[serde(default)]
    pub form: CostForm,
    /// What a frame costs before its first sample \[ms\].
    pub fixed_ms: f64,
    /// Cost of shading one sample \[ns\].
    pub per_sample_ns: f64,
    /// Cost of reconstructing one display pixel \[ns\]; a full-resolution frame pays none.
    #[serde(default)]
    pub per_pixel_ns: f64,
    /// Cost of finding what is visible in one sample \[ns\].
    #[serde(default)]
    pub per_visible_sample_ns: f64,
    /// Cost of a pass, whatever its samples \[ms\].
    #[serde(default)]
    pub per_pass_ms: f64,
    /// By name of a part of [`FrameWork::TERMS`]: from what to what the rows reach that the profile rests on.
    /// Beyond is extrapolation.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub fitted: BTreeMap<String, [f64; 2]>,
    /// Standard deviation of measured over predicted time of rows that were left out of the fit, where it is
    /// known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// What a frame takes of energy, where that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy: Option<EnergyProfile>,
    /// Where each number comes from, by field name.
    #[serde(default)]
    pub sources: BTreeMap<String, Source>,
}

impl CostProfile {
    /// Checks that every number is in range and every name known.
    ///
    /// # Errors
    /// Names the number that is not, and what would be valid.
    pub fn validate(self) -> Result<Self, ModelError> {
        in_range("fixed_ms", self.fixed_ms, 0.0..=1e6)?;
        in_range("per_sample_ns", self.per_sample_ns, 0.0..=1e9)?;
        in_range("per_pixel_ns", self.per_pixel_ns, 0.0..=1e9)?;
        in_range(
            "per_visible_sample_ns",
            self.per_visible_sample_ns,
            0.0..=1e9,
        )?;
        in_range("per_pass_ms", self.per_pass_ms, 0.0..=1e6)?;
        in_range("error", self.error.unwrap_or(0.0), 0.0..=1e3)?;
        if let Some(energy) = &self.energy {
            energy.validate()?;
        }
        for (name, [from, to]) in &self.fitted {
            if !FrameWork::TERMS.contains(&name.as_str()) {
                return Err(unknown_name(
                    "part of a frame's work in `fitted`",
                    name,
                    &FrameWork::TERMS,
                ));
            }
            in_range("fitted", *from, 0.0..=1e15)?;
            in_range("fitted", *to, *from..=1e15)?;
        }
        Ok(self)
    }

    /// What each part of a frame's work takes, in the order of [`FrameWork::TERMS`] \[ns\].
    fn coefficients(&self) -> [f64; 4] {
        [
            self.per_sample_ns,
            self.per_visible_sample_ns,
            self.per_pixel_ns,
            self.per_pass_ms * 1e6,
        ]
    }

    /// The time of a frame \[ns\], not rounded.
    pub fn time_ns(&self, work: &FrameWork) -> f64 {
        let parts = self.coefficients().into_iter().zip(work.terms());
        let parts = parts.map(|(each, n)| each * n);
        let fixed = self.fixed_ms * 1e6;
        match self.form {
            CostForm::Sum => parts.fold(fixed, |sum, part| sum + part),
            CostForm::Largest => fixed + parts.fold(0.0, f64::max),
        }
    }

    /// The time of a frame.
    pub fn time(&self, work: &FrameWork) -> Nanos {
        Nanos(libm::round(self.time_ns(work)) as i64)
    }

    /// Whether a frame does more, or less, of what its time depends on than any row that the profile rests on:
    /// the first part it does, in the order of [`FrameWork::TERMS`].
    pub fn extrapolates(&self, work: &FrameWork) -> Option<&'static str> {
        let parts = FrameWork::TERMS.into_iter().zip(work.terms());
        let mut charged = parts
            .zip(self.coefficients())
            .filter(|(_, each)| *each > 0.0);
        let beyond = charged.find(|((name, n), _)| {
            let range = self.fitted.get(*name);
            range.is_some_and(|[from, to]| n < from || n > to)
        });
        beyond.map(|((name, _), _)| name)
    }
}

#[cfg(test)]
mod tests {
    use super::FrameWork;
    use crate::presets;

    #[test]
    fn published_times_that_the_profile_was_and_was_not_fitted_to() {
        let profile = presets::cost("guenter2012").unwrap();
        let full = 1920.0 * 1080.0;
        let work = |samples_shaded, pixels_resolved| FrameWork {
            samples_shaded,
            pixels_resolved,
            ..FrameWork::default()
        };
        let time = |ratio: f64| profile.time(&work(full / ratio, full)).as_ms();
        // Table 1, row Full: fitted to N2 and Q_A ...
        assert!((profile.time(&work(full, 0.0)).as_ms() - 27.9).abs() < 0.05);
        assert!((time(13.29) - 4.9).abs() < 0.05);
        // ... and predicts Q_B (5.9 ms) 7 % too low, as its title says.
        assert!((time(10.11) / 5.9 - 0.93).abs() < 0.01);
        assert_eq!(profile.extrapolates(&work(full, 0.0)), None);
        assert_eq!(
            profile.extrapolates(&work(4.0 * full, 0.0)),
            Some("samples_shaded")
        );
    }

    #[test]
    fn the_largest_stage_decides_or_all_add_up() {
        let text =
            "name = 'x'\nform = 'largest'\nfixed_ms = 1\nper_sample_ns = 10\nper_pass_ms = 2";
        let mut profile = presets::parse_cost(text, "x").unwrap();
        let work = FrameWork {
            samples_shaded: 1e6,
            passes: 3.0,
            ..FrameWork::default()
        };
        assert!((profile.time(&work).as_ms() - 11.0).abs() < 1e-9);
        profile.form = super::CostForm::Sum;
        assert!((profile.time(&work).as_ms() - 17.0).abs() < 1e-9);
        let bad = text.replace("largest", "most");
        assert!(presets::parse_cost(&bad, "x").is_err());
        let bad = format!("{text}\n[fitted]\nsample = [1, 2]");
        let error = presets::parse_cost(&bad, "x").unwrap_err().to_string();
        assert!(error.contains("samples"), "{error}");
    }
}
