/// How the step along a ray follows the place where the ray is cast.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StepLaw {
    /// The same for all.
    Equal,
    /// As far as rays are apart there, times `scale`; at least the base step, and at most `most` of it.
    Spacing {
        /// Base steps per pixel of spacing.
        scale: f32,
        /// Most base steps.
        most: f32,
    },
    /// 1 + `slope`·r/1024 with r the distance from the gaze \[px\]: the authors' program, with slope 2.
    Distance {
        /// More base steps in 1024 px.
        slope: f32,
    },
}

impl StepLaw {
    /// The authors' program's.
    pub const AUTHORS: Self = Self::Distance { slope: 2.0 };

    /// Base steps to take at once by a ray `distance` from the gaze where rays are `spacing` apart \[px\].
    pub fn factor(self, spacing: f32, distance: f32) -> f32 {
        match self {
            Self::Equal => 1.0,
            // Not f32::clamp, which panics where most is below one.
            Self::Spacing { scale, most } => (spacing * scale).min(most).max(1.0),
            Self::Distance { slope } => 1.0 + slope * distance / 1024.0,
        }
    }
}
