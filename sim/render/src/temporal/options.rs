use crate::RenderError;

/// What frames take from the ones before them. Each part can be used without the others; a clamp and a
/// blend mean nothing without reprojection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TemporalOptions {
    /// Whether samples move within their cells from frame to frame. It replaces the plan's offsets.
    pub jitter: bool,
    /// Whether samples are blended with what was seen of the same surface before (reverse
    /// reprojection; Nehab et al. 2007).
    pub reproject: bool,
    /// Whether passes are drawn only in the frames of their cadence.
    pub staggered: bool,
    /// Largest weight of a history that had to be found again, 0 to 0.99. Up to it every frame that was
    /// seen counts alike: the weight is n/(n+1) after n frames. Finding interpolates, so a long history
    /// is steady but soft. One that stays in its place is not: there, 64 frames count alike (none, if
    /// this is 0).
    pub blend: f32,
    /// What is done with a history that does not look like the sample's surroundings.
    pub clamp: Clamp,
    /// How what lies between samples is found, in the history and in the new frame.
    pub interpolation: Interpolation,
    /// Times [`RenderOptions::footprint`](crate::RenderOptions::footprint) while jittered samples add up
    /// over frames: several samples of a cell need not each be as soft as one that stands for all of it. Below 1
    /// it is the negative mip bias that goes with temporal antialiasing. 1/16 to 1.
    pub footprint: f64,
}

/// How what lies between samples is found, in the history and in the new frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Interpolation {
    /// Linear along both axes, in the history; new samples count where they were taken, as if that
    /// were the middle of their cells. What the least hardware does, and Nehab et al. 2007. It blurs a
    /// little more with every frame that a history goes through, and jitter shows as trembling.
    Bilinear,
    /// Catmull-Rom (cubic convolution, Keys 1981): of 4×4 samples of the history, and of 3×3 new samples
    /// for the middle of the one that was taken beside it. Near outlines of the history, and at the
    /// edges of a pass, the history is interpolated linearly.
    #[default]
    CatmullRom,
}

/// What is done with a history that does not look like the sample's surroundings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Clamp {
    /// Nothing.
    Off,
    /// Each channel is clamped to the least and greatest value of the 3×3 samples around.
    ///
    /// In linear light, where means over frames are taken: the box of the nine colours then holds all
    /// their means, so it can only strike a history that shows something else. A rotated space
    /// (YCoCg) gives a tighter box, but rounds: one colour everywhere would not stay that colour to
    /// the bit.
    #[default]
    Neighbourhood,
}

impl Default for TemporalOptions {
    /// Jitter and reprojection with at most three quarters of found history, clamped; every pass in
    /// every frame.
    fn default() -> Self {
        Self {
            jitter: true,
            reproject: true,
            staggered: false,
            blend: 0.75,
            clamp: Clamp::Neighbourhood,
            interpolation: Interpolation::CatmullRom,
            footprint: 0.5,
        }
    }
}

/// Most frames before the present one that count where nothing moves: with it, four periods of jitter.
const LONGEST_IN_PLACE: f32 = 63.0;

impl TemporalOptions {
    /// Each frame by itself.
    pub const OFF: Self = Self {
        jitter: false,
        reproject: false,
        staggered: false,
        blend: 0.0,
        clamp: Clamp::Off,
        interpolation: Interpolation::CatmullRom,
        footprint: 1.0,
    };

    pub(super) fn check(&self) -> Result<(), RenderError> {
        if !(0.0..=0.99).contains(&self.blend) {
            return Err(RenderError::OutOfRange {
                field: "blend",
                value: self.blend.to_string(),
                valid: "a weight of the history from 0 to 0.99".into(),
            });
        }
        if !(0.0625..=1.0).contains(&self.footprint) {
            return Err(RenderError::OutOfRange {
                field: "footprint",
                value: self.footprint.to_string(),
                valid: "from 1/16 to 1".into(),
            });
        }
        Ok(())
    }

    /// Most frames that a history counts for: n/(n+1) is then the largest weight.
    pub(super) fn longest(&self, in_place: bool) -> f32 {
        if in_place && self.blend > 0.0 {
            LONGEST_IN_PLACE
        } else {
            self.blend / (1.0 - self.blend)
        }
    }
}
