use glam::DVec3;

use crate::EnvironmentMap;

/// What is seen where no triangle is, by direction alone.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Sky {
    /// One colour everywhere, linear RGB.
    Uniform([f32; 3]),
    /// Gradient, sun, clouds and a range of mountains, worked out anew for each sample.
    Analytic(AnalyticSky),
    /// An image of the upper half space over ground of one colour.
    Map(EnvironmentMap),
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

/// What a sky does to the surfaces under it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkyLight {
    /// Light that a surface facing straight up gathers from it, times 1/π, linear RGB.
    pub ambient_up: [f32; 3],
    /// Light that a surface facing straight down gathers from the ground, times 1/π, and the colour of
    /// that ground, linear RGB.
    pub ambient_down: [f32; 3],
    /// Colour that surfaces fade into with distance, linear RGB.
    pub haze: [f32; 3],
    /// One over the distance at which a surface keeps half of its colour \[1/m\]; 0 in clear air.
    pub per_visibility_m: f32,
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
    /// The light it sheds.
    pub fn light(&self) -> SkyLight {
        match self {
            Self::Uniform(c) => SkyLight {
                ambient_up: *c,
                ambient_down: *c,
                haze: *c,
                per_visibility_m: 0.0,
            },
            Self::Analytic(a) => a.light(),
            Self::Map(m) => m.light(),
        }
    }

    pub(crate) fn is_valid(&self) -> bool {
        match self {
            Self::Uniform(c) => colour(c),
            Self::Analytic(a) => {
                [a.zenith, a.horizon, a.mountains].iter().all(colour)
                    && (0.0..=1.0).contains(&a.cloud_cover)
                    && a.visibility_m > 0.0
            }
            // Texels cannot hold anything else.
            Self::Map(m) => {
                let light = m.light();
                [light.ambient_up, light.ambient_down, light.haze]
                    .iter()
                    .all(colour)
                    && (0.0..=1e3).contains(&light.per_visibility_m)
            }
        }
    }
}

impl AnalyticSky {
    /// The light it sheds: mostly the zenith's, some of the horizon's; grassy ground below.
    pub fn light(&self) -> SkyLight {
        SkyLight {
            ambient_up: std::array::from_fn(|i| 0.55 * self.zenith[i] + 0.30 * self.horizon[i]),
            ambient_down: [0.075, 0.085, 0.045],
            haze: self.horizon,
            per_visibility_m: 1.0 / self.visibility_m,
        }
    }
}

impl Sun {
    pub(crate) fn is_valid(&self) -> bool {
        colour(&self.radiance) && self.direction.is_finite() && self.direction.length() > 1e-9
    }
}
