use glam::DVec3;

/// What is seen where no triangle is, by direction alone.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Sky {
    /// One colour everywhere, linear RGB.
    Uniform([f32; 3]),
    /// Gradient, sun, clouds and a range of mountains.
    Analytic(AnalyticSky),
}

/// A generated sky, the same from every position (an environment at infinity).
#[derive(Debug, Clone, PartialEq)]
pub struct AnalyticSky {
    /// Seed of clouds and mountains.
    pub seed: u32,
    /// Colour straight up, linear RGB.
    pub zenith: [f32; 3],
    /// Colour at the horizon, linear RGB.
    pub horizon: [f32; 3],
    /// Colour of the mountains at their foot (they fade into the horizon's), linear RGB.
    pub mountains: [f32; 3],
    /// Share of the sky under clouds, 0 to 1.
    pub cloud_cover: f32,
    /// Distance at which a surface keeps half of its colour, the rest being the horizon's \[m\];
    /// infinite in clear air.
    pub visibility_m: f32,
}

/// A directional light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sun {
    /// Towards the sun, world frame; any length above zero.
    pub direction: DVec3,
    /// Light that falls on a surface facing it, times 1/π, linear RGB.
    pub radiance: [f32; 3],
}

fn colour(c: &[f32; 3]) -> bool {
    c.iter().all(|v| v.is_finite() && *v >= 0.0)
}

impl Sky {
    pub(crate) fn is_valid(&self) -> bool {
        match self {
            Self::Uniform(c) => colour(c),
            Self::Analytic(a) => {
                [a.zenith, a.horizon, a.mountains].iter().all(colour)
                    && (0.0..=1.0).contains(&a.cloud_cover)
                    && a.visibility_m > 0.0
            }
        }
    }
}

impl Sun {
    pub(crate) fn is_valid(&self) -> bool {
        colour(&self.radiance) && self.direction.is_finite() && self.direction.length() > 1e-9
    }
}
