use std::fmt;
use std::sync::Arc;

use glam::DVec3;

use crate::atmosphere::Atmosphere;
use crate::{AnalyticSky, SkyLight, Sun};

/// An image of the upper half space with a chain of halved copies, over ground of one colour.
///
/// A direction (x, y, z), y up and not below the horizon, is seen at (p + q, p − q) with
/// (p, q) = (x, z) / (|x| + |z| + [`RISE`](Self::RISE)·y): a square from −1 to 1 on both axes whose
/// border is the horizon and whose middle is the zenith (the octahedral map of a hemisphere, Cigolle et
/// al. 2014, stretched towards the horizon). Needing no trigonometry, it suits kernels; without a seam,
/// the halved copies are free of leaks; and it spends no texel on the ground.
///
/// Texels are shared-exponent RGB, 9 bits each and 5 of exponent (as OpenGL's RGB9_E5): steps of at
/// most 1/256 of a colour's largest component.
#[derive(Clone, PartialEq)]
pub struct EnvironmentMap {
    size: u32,
    starts: Vec<usize>,
    texels: Arc<[u32]>,
    light: SkyLight,
}

/// Bits of a component, and how far the exponent is shifted.
const BITS: i32 = 9;
const BIAS: i32 = 15;

impl EnvironmentMap {
    /// How much the map is stretched: texels then subtend much the same angle straight up and, by
    /// azimuth and by height, along the horizon.
    pub const RISE: f64 = 1.5;

    /// Copies at most, the first one with them: the last has one texel for the first's 4⁹.
    pub const MAX_LEVELS: usize = 10;

    /// An image of `sky` and `sun`, `size` texels along each side.
    ///
    /// # Panics
    /// If `size` is 0 or above 8192.
    pub fn of_sky(sky: &AnalyticSky, sun: &Sun, size: u32) -> Self {
        let atmosphere = Atmosphere::new(sky, sun, texel_angle(size));
        Self::new(size, sky.light(), |d| atmosphere.colour(d))
    }

    /// An image of `colour`, linear RGB by unit direction, `size` texels along each side; halved as often
    /// as that is even.
    ///
    /// # Panics
    /// If `size` is 0 or above 8192.
    pub fn new(size: u32, light: SkyLight, colour: impl Fn(DVec3) -> DVec3) -> Self {
        assert!((1..=8192).contains(&size), "{size} texels along each side");
        let levels = (size.trailing_zeros() as usize + 1).min(Self::MAX_LEVELS);
        let mut image = Vec::with_capacity((size * size) as usize);
        for j in 0..size {
            for i in 0..size {
                image.push(colour(direction(size, i, j)).as_vec3().to_array());
            }
        }
        let mut texels = Vec::with_capacity(image.len() * 4 / 3 + 1);
        let mut starts = Vec::with_capacity(levels);
        for level in 0..levels {
            if level > 0 {
                image = halved(&image, (size >> (level - 1)) as usize);
            }
            starts.push(texels.len());
            texels.extend(image.iter().map(|c| pack(*c)));
        }
        Self {
            size,
            starts,
            texels: texels.into(),
            light,
        }
    }

    /// Texels along each side of the finest copy.
    pub fn size(&self) -> u32 {
        self.size
    }

    /// How many copies, each half the size of the one before it along each side.
    pub fn levels(&self) -> usize {
        self.starts.len()
    }

    /// Where in [`texels`](Self::texels) each copy starts.
    pub fn starts(&self) -> &[usize] {
        &self.starts
    }

    /// The texels of all copies, row by row.
    pub fn texels(&self) -> &[u32] {
        &self.texels
    }

    /// The angle that a texel of the finest copy subtends on average \[rad\].
    pub fn texel_angle(&self) -> f64 {
        texel_angle(self.size)
    }

    /// The light it sheds.
    pub fn light(&self) -> SkyLight {
        self.light
    }

    /// Linear RGB of a texel.
    pub fn unpack(texel: u32) -> [f32; 3] {
        let exponent = (texel >> 27) as i32 - BIAS - BITS;
        let scale = f32::from_bits(((exponent + 127) as u32) << 23);
        [0, 9, 18].map(|shift| (texel >> shift & 0x1ff) as f32 * scale)
    }
}

/// The solid angle of the half space shared out evenly.
fn texel_angle(size: u32) -> f64 {
    (2.0 * std::f64::consts::PI).sqrt() / f64::from(size)
}

/// The unit direction of a texel's middle.
pub(crate) fn direction(size: u32, i: u32, j: u32) -> DVec3 {
    let middle = |k: u32| (2.0 * f64::from(k) + 1.0) / f64::from(size) - 1.0;
    let (u, v) = (middle(i), middle(j));
    let (p, q) = ((u + v) / 2.0, (u - v) / 2.0);
    let up = (1.0 - p.abs() - q.abs()).max(0.0);
    DVec3::new(p, up / EnvironmentMap::RISE, q).normalize()
}

/// Means of two by two texels. Texels subtend much the same angle as their neighbours, so that their
/// plain mean will do.
fn halved(image: &[[f32; 3]], size: usize) -> Vec<[f32; 3]> {
    let mut half = Vec::with_capacity(image.len() / 4);
    for rows in image.chunks_exact(2 * size) {
        let (upper, lower) = rows.split_at(size);
        for (a, b) in upper.chunks_exact(2).zip(lower.chunks_exact(2)) {
            half.push([0, 1, 2].map(|k| (a[0][k] + a[1][k] + b[0][k] + b[1][k]) * 0.25));
        }
    }
    half
}

/// The nearest texel; below 0 (and NaN) is 0, above 65408 that.
fn pack(colour: [f32; 3]) -> u32 {
    let [r, g, b] = colour.map(|c| if c > 0.0 { c.min(65_408.0) } else { 0.0 });
    let largest = r.max(g).max(b);
    // The exponent that leaves the largest component in 256..512, unless that is too small.
    let mut exponent = ((largest.to_bits() >> 23) as i32 - 127 + 1).max(-BIAS);
    let scaled = |exponent: i32, c: f32| {
        let scale = f32::from_bits(((BITS - exponent + 127) as u32) << 23);
        (c * scale + 0.5) as u32
    };
    if scaled(exponent, largest) > 511 {
        exponent += 1;
    }
    let e = (exponent + BIAS) as u32;
    scaled(exponent, r) | scaled(exponent, g) << 9 | scaled(exponent, b) << 18 | e << 27
}

impl fmt::Debug for EnvironmentMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("EnvironmentMap")
            .field("size", &self.size)
            .field("levels", &self.levels())
            .field("light", &self.light)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use foveasim_models::{Role, Stream};

    const LIGHT: SkyLight = SkyLight {
        ambient_up: [0.0; 3],
        ambient_down: [0.0; 3],
        haze: [0.0; 3],
        per_visibility_m: 0.0,
    };

    #[test]
    fn packing_keeps_eight_bits_of_the_largest_component() {
        let random = &mut Stream::new(1, Role::Scene, 0);
        for _ in 0..10_000 {
            let brightness = foveasim_models::math::exp(random.range(-9.0, 11.0));
            let colour = [(); 3].map(|()| (random.uniform() * brightness) as f32);
            let largest = colour.into_iter().fold(0.0, f32::max);
            let back = EnvironmentMap::unpack(pack(colour));
            for (a, b) in colour.into_iter().zip(back) {
                // Half a step of 2⁻⁸, or of the smallest exponent's 2⁻²⁴.
                assert!(
                    (a.min(65_408.0) - b).abs() <= largest / 512.0 + 3e-8,
                    "{colour:?} {back:?}"
                );
            }
        }
        for exact in [[0.0; 3], [1.0, 0.5, 0.25], [511.0, 3.0, 256.0]] {
            assert_eq!(EnvironmentMap::unpack(pack(exact)), exact);
        }
        assert_eq!(
            EnvironmentMap::unpack(pack([f32::NAN, -1.0, f32::INFINITY])),
            [0.0, 0.0, 65_408.0]
        );
    }

    #[test]
    fn directions_are_where_the_map_says() {
        let size = 64;
        let mut up: f64 = 0.0;
        for j in 0..size {
            for i in 0..size {
                let d = direction(size, i, j);
                assert!(d.y > 0.0);
                up = up.max(d.y);
                let k = d.x.abs() + d.z.abs() + EnvironmentMap::RISE * d.y;
                let back = |c: f64| ((c / k + 1.0) * f64::from(size) - 1.0) / 2.0;
                assert!((back(d.x + d.z) - f64::from(i)).abs() < 1e-9);
                assert!((back(d.x - d.z) - f64::from(j)).abs() < 1e-9);
            }
        }
        assert!(up > 0.999);
    }

    #[test]
    fn texels_subtend_much_the_same_angle() {
        let size = 256;
        for (i, j) in [
            (0, 128),
            (0, 1),
            (128, 128),
            (60, 128),
            (60, 70),
            (128, 254),
        ] {
            let angle = |di: u32, dj: u32| {
                direction(size, i, j)
                    .cross(direction(size, i + di, j + dj))
                    .length()
            };
            for ratio in [angle(1, 0), angle(0, 1)].map(|a| a / texel_angle(size)) {
                assert!((0.4..2.0).contains(&ratio), "{i} {j}: {ratio}");
            }
        }
    }

    #[test]
    fn copies_are_halved_and_keep_the_mean() {
        let map = EnvironmentMap::new(48, LIGHT, |d| DVec3::new(d.y, 0.25, d.x + 1.0));
        assert_eq!(map.levels(), 5);
        assert_eq!(map.starts(), [0, 2304, 2880, 3024, 3060]);
        assert_eq!(map.texels().len(), 3069);
        let mean = |texels: &[u32]| {
            let sum: f64 = texels
                .iter()
                .map(|&t| f64::from(EnvironmentMap::unpack(t)[0]))
                .sum();
            sum / texels.len() as f64
        };
        let (first, last) = (mean(&map.texels()[..2304]), mean(&map.texels()[3060..]));
        assert!((first - last).abs() < 2e-3, "{first} {last}");
    }
}
