use glam::DVec3;

use crate::noise::{filtered_2d, filtered_above};
use crate::{AnalyticSky, Sun};

/// The colours of an [`AnalyticSky`] by direction, in double precision: what the renderer's kernel of
/// that sky computes in lanes, for making an image of it once.
pub(crate) struct Atmosphere<'a> {
    sky: &'a AnalyticSky,
    zenith: DVec3,
    horizon: DVec3,
    mountains: DVec3,
    sun_direction: DVec3,
    sun_radiance: DVec3,
    /// Averaged over this angle [rad].
    angle: f64,
    /// Heights of the ridge, as slopes, by direction round the horizon.
    ridge: Vec<f64>,
}

/// Heights of the ridge in a table: thirteen and more for a period of its finest octave.
const RIDGE_STEPS: usize = 1 << 14;

fn wide(c: [f32; 3]) -> DVec3 {
    DVec3::from_array(c.map(f64::from))
}

/// 0 below `low`, 1 above `high`, 3x² − 2x³ between.
fn step(low: f64, high: f64, x: f64) -> f64 {
    foveasim_models::math::smoothstep((x - low) / (high - low))
}

/// Step `k` of the way round the square |x| + |z| = 1, from +x over +z.
fn round_horizon(k: usize) -> [f64; 2] {
    let turn = 4.0 * k as f64 / RIDGE_STEPS as f64;
    if turn <= 2.0 {
        [1.0 - turn, 1.0 - (1.0 - turn).abs()]
    } else {
        [turn - 3.0, (turn - 3.0).abs() - 1.0]
    }
}

impl<'a> Atmosphere<'a> {
    /// The colours averaged over `angle` [rad].
    pub(crate) fn new(sky: &'a AnalyticSky, sun: &Sun, angle: f64) -> Self {
        let ridge = (0..=RIDGE_STEPS)
            .map(|k| {
                let [x, z] = round_horizon(k);
                let flat = (x * x + z * z).sqrt();
                let (hx, hz) = (x / flat, z / flat);
                let noise = filtered_2d(hx * 3.0, hz * 3.0, angle * 3.0, 7, sky.seed ^ 0x0dd5);
                0.105 + 0.055 * noise
            })
            .collect();
        Self {
            sky,
            zenith: wide(sky.zenith),
            horizon: wide(sky.horizon),
            mountains: wide(sky.mountains),
            sun_direction: sun.direction.normalize(),
            sun_radiance: wide(sun.radiance),
            angle,
            ridge,
        }
    }

    /// Linear RGB in the unit direction `d`, on or above the horizon.
    pub(crate) fn colour(&self, d: DVec3) -> DVec3 {
        let angle = self.angle;
        let flat = (d.x * d.x + d.z * d.z).max(1e-12).sqrt();
        let slope = d.y / flat;
        let height = self.ridge_height(d);
        let above = step(height - angle - 5e-4, height + angle + 5e-4, slope);
        // What is hidden need not be known.
        if above == 1.0 {
            return self.sky(d, angle);
        }
        let mountain = self.mountain(d.x / flat, d.z / flat, slope, angle);
        if above == 0.0 {
            mountain
        } else {
            mountain.lerp(self.sky(d, angle), above)
        }
    }

    /// Between the two heights of the table that lie about a direction.
    fn ridge_height(&self, d: DVec3) -> f64 {
        let along = d.x / (d.x.abs() + d.z.abs()).max(1e-12);
        let turn = if d.z >= 0.0 { 1.0 - along } else { 3.0 + along };
        let place = turn * (RIDGE_STEPS as f64 / 4.0);
        let step = (place as usize).min(RIDGE_STEPS - 1);
        let (low, high) = (self.ridge[step], self.ridge[step + 1]);
        low + (high - low) * (place - step as f64)
    }

    /// Gradient, sun and clouds.
    fn sky(&self, d: DVec3, angle: f64) -> DVec3 {
        let up = d.y.max(0.0);
        let thin = (1.0 - up) * (1.0 - up);
        let mut colour = self.zenith.lerp(self.horizon, thin * thin);

        // The sun's disc, twice its true size, and the glow about it.
        let toward_sun = self.sun_direction.dot(d);
        let c8 = toward_sun.max(0.0).powi(8);
        let blur = angle * angle * 0.5 + 2e-5;
        let disc = step(0.99994 - blur, 0.99994 + blur, toward_sun);
        colour += self.sun_radiance * (c8 * 0.06 + c8.powi(8) * 0.18 + disc * 2.0);

        // Clouds on a plane overhead, seen ever more slantwise towards the horizon.
        let slant = 1.0 / (up + 0.08);
        let foot = angle * slant * slant * 0.25 + angle * slant;
        let (u, v) = (d.x * slant * 1.1, d.z * slant * 1.1);
        let threshold = 0.9 - 1.5 * f64::from(self.sky.cloud_cover);
        let density = filtered_above(threshold, u, v, foot, 6, self.sky.seed);
        let cloud = step(threshold, threshold + 0.75, density) * (up * 7.0).min(1.0);
        let lit = DVec3::new(0.92, 0.93, 0.95) * (1.0 - density.clamp(0.0, 1.0) * 0.25);
        colour.lerp(lit, cloud * 0.85)
    }

    /// Rock and snow, paler towards the foot.
    fn mountain(&self, hx: f64, hz: f64, slope: f64, angle: f64) -> DVec3 {
        let seed = self.sky.seed ^ 0x70c4;
        let grain = filtered_2d(hx * 23.0 + slope * 9.0, hz * 23.0, angle * 25.0, 5, seed);
        let snow = step(0.09, 0.13, slope + grain * 0.02);
        let face = self.mountains * (grain * 0.35 + 1.0);
        let face = face.lerp(DVec3::new(0.70, 0.74, 0.80), snow * 0.75);
        let haze = (1.0 - slope * 6.0).clamp(0.0, 1.0) * 0.75;
        face.lerp(self.horizon, haze)
    }
}
