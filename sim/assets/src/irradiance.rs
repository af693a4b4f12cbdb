use glam::DVec3;

use crate::environment::direction;
use crate::{AnalyticSky, EnvironmentMap, Sky, Sun};

/// Light that a surface gathers from all directions, by its normal: spherical harmonics of the second order
/// (Ramamoorthi & Hanrahan 2001), within 1 % of the integral for smooth skies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Irradiance {
    /// Linear RGB of 1, y, z, x, xy, yz, 3z² − 1, xz and x² − y² of a unit normal; their sum is the light over π.
    pub coefficients: [[f32; 3]; 9],
}

/// Texels along each side that are summed: light is smooth.
const TEXELS: u32 = 64;

/// Polynomials of a direction that are orthogonal over the sphere.
fn basis(d: DVec3) -> [f64; 9] {
    let DVec3 { x, y, z } = d;
    [
        1.0,
        y,
        z,
        x,
        x * y,
        y * z,
        3.0 * z * z - 1.0,
        x * z,
        x * x - y * y,
    ]
}

/// Of each of them, one over the integral of its square times what a cosine lobe leaves of its order, over π
/// (1, ⅔, ¼: Ramamoorthi & Hanrahan 2001, eq. 8).
const WEIGHTS: [f64; 9] = {
    const PI: f64 = std::f64::consts::PI;
    let first = 2.0 / 3.0 * 3.0 / (4.0 * PI);
    let mixed = 0.25 * 15.0 / (4.0 * PI);
    [
        1.0 / (4.0 * PI),
        first,
        first,
        first,
        mixed,
        mixed,
        0.25 * 5.0 / (16.0 * PI),
        mixed,
        0.25 * 15.0 / (16.0 * PI),
    ]
};

impl Sky {
    /// The light of the sky, and of the ground below it, without the sun's own.
    pub fn irradiance(&self, sun: &Sun) -> Irradiance {
        match self {
            Self::Uniform(colour) => {
                let mut coefficients = [[0.0; 3]; 9];
                coefficients[0] = *colour;
                Irradiance { coefficients }
            }
            Self::Analytic(sky) => of_map(&without_sun(sky, sun)),
            Self::Map(map) => of_map(map),
        }
    }
}

fn without_sun(sky: &AnalyticSky, sun: &Sun) -> EnvironmentMap {
    let dark = Sun {
        radiance: [0.0; 3],
        ..*sun
    };
    EnvironmentMap::of_sky(sky, &dark, TEXELS)
}

/// Sums a copy of the map that is coarse enough, and the ground.
fn of_map(map: &EnvironmentMap) -> Irradiance {
    let level = (0..map.levels())
        .find(|level| map.size() >> level <= TEXELS)
        .unwrap_or(map.levels() - 1);
    let size = map.size() >> level;
    let texels = &map.texels()[map.starts()[level]..][..(size * size) as usize];
    let mut sums = [[0.0; 3]; 9];
    let mut add = |d: DVec3, colour: [f64; 3], solid_angle: f64| {
        for (sum, b) in sums.iter_mut().zip(basis(d)) {
            for (sum, c) in sum.iter_mut().zip(colour) {
                *sum += b * c * solid_angle;
            }
        }
    };
    for (k, texel) in texels.iter().enumerate() {
        let (i, j) = (k as u32 % size, k as u32 / size);
        let d = direction(size, i, j);
        let colour = EnvironmentMap::unpack(*texel).map(f64::from);
        add(d, colour, solid_angle(d, size));
        // The ground is as far below the horizon as the sky is above.
        let ground = map.light().ambient_down.map(f64::from);
        add(DVec3::new(d.x, -d.y, d.z), ground, solid_angle(d, size));
    }
    let coefficients = std::array::from_fn(|k| sums[k].map(|sum| (sum * WEIGHTS[k]) as f32));
    Irradiance { coefficients }
}

/// What a texel of `size` along each side subtends in direction `d` \[sr\]. With P = (p, (1 − |p| − |q|)/R, q) and the
/// image's axes u = p + q, v = p − q it is P·(∂P/∂u × ∂P/∂v)/|P|³, whose product is 1/2R everywhere.
fn solid_angle(d: DVec3, size: u32) -> f64 {
    let rise = EnvironmentMap::RISE;
    // |P| is where |x| + |z| + R·y is 1.
    let length = 1.0 / (d.x.abs() + d.z.abs() + rise * d.y.abs());
    let texel = 2.0 / f64::from(size);
    texel * texel / (2.0 * rise * length * length * length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{STUDY_SUN, SkyLight, study_sky};

    fn light(irradiance: &Irradiance, n: DVec3) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (c, b) in irradiance.coefficients.iter().zip(basis(n)) {
            for (sum, c) in sum.iter_mut().zip(c) {
                *sum += f64::from(*c) * b;
            }
        }
        sum
    }

    fn map(ground: [f32; 3], sky: impl Fn(DVec3) -> DVec3) -> Sky {
        let light = SkyLight {
            ambient_up: [0.0; 3],
            ambient_down: ground,
            haze: [0.0; 3],
            per_visibility_m: 0.0,
        };
        Sky::Map(EnvironmentMap::new(128, light, sky))
    }

    #[test]
    fn skies_whose_light_is_known() {
        let one = map([0.5; 3], |_| DVec3::splat(0.5)).irradiance(&STUDY_SUN);
        // Bright above and dark below gather ½ + ½·n·up of the sky.
        let half = map([0.0; 3], |_| DVec3::splat(0.5)).irradiance(&STUDY_SUN);
        let uniform = Sky::Uniform([0.5; 3]).irradiance(&STUDY_SUN);
        for n in [DVec3::Y, DVec3::X, DVec3::new(0.6, -0.8, 0.0), DVec3::NEG_Z] {
            assert!((light(&one, n)[0] - 0.5).abs() < 3e-3, "{n}");
            assert_eq!(light(&uniform, n)[1], 0.5);
            let exact = 0.25 + 0.25 * n.y;
            assert!((light(&half, n)[2] - exact).abs() < 5e-3, "{n}");
        }
        // Light that grows towards +x is gathered by what looks there: ∫ (1 + x)·cos/π = 1 + ⅔·n·x.
        let side = map([1.0; 3], |d| DVec3::splat(1.0 + d.x)).irradiance(&STUDY_SUN);
        let [left, right] = [DVec3::NEG_X, DVec3::X].map(|n| light(&side, n)[0]);
        assert!((right - left - 2.0 / 3.0).abs() < 0.02, "{right} {left}");
    }

    #[test]
    fn the_study_sky_sheds_about_what_it_is_said_to() {
        let sky = study_sky(1);
        let told = sky.light();
        let found = Sky::Analytic(sky.clone()).irradiance(&STUDY_SUN);
        let map = Sky::Map(EnvironmentMap::of_sky(&sky, &STUDY_SUN, 256)).irradiance(&STUDY_SUN);
        for c in 0..3 {
            let up = light(&found, DVec3::Y)[c];
            assert!(
                (0.5..3.0).contains(&(up / f64::from(told.ambient_up[c]))),
                "{up}"
            );
            // The map's own sun is a small part of it.
            let with_sun = light(&map, DVec3::Y)[c];
            assert!((with_sun / up - 1.0).abs() < 0.5, "{with_sun} {up}");
        }
    }
}
