use fearless_simd::f32x4;
use fearless_simd::prelude::*;
use foveasim_models::Interpolation;

use super::Kernel;
use super::cubic::cubic_of;
use super::lanes::Simd;
use crate::texels::{Sum, Texels};

/// Reads the colours of a display row from places of a lattice and of its halved copies.
pub(crate) struct FetchMips<'a> {
    /// The lattice, and copies of half the size each: as many as are needed.
    pub(crate) levels: &'a [Texels],
    pub(crate) interpolation: Interpolation,
    /// Places of the row's pixels, in steps of the finest lattice.
    pub(crate) xs: &'a [f32],
    pub(crate) ys: &'a [f32],
    /// Samples of the finest lattice in a pixel's length.
    pub(crate) density: &'a [f32],
    pub(crate) row: &'a mut [[f32; 3]],
}

impl Kernel for FetchMips<'_> {
    /// How many samples were read.
    type Output = u64;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> u64 {
        let mut fetches = 0;
        let places = self.xs.iter().zip(self.ys).zip(self.density);
        for (out, ((x, y), density)) in self.row.iter_mut().zip(places) {
            let (level, share) = level(*density, self.levels.len());
            let mut read = |level: usize| {
                let (scale, texels) = (half_to(level), &self.levels[level]);
                let at = [x * scale, y * scale];
                fetches += match self.interpolation {
                    Interpolation::Nearest => 1,
                    Interpolation::Cubic => 16,
                    _ => 4,
                };
                match self.interpolation {
                    Interpolation::Nearest => {
                        let [r, g, b, _] = owner(texels, at);
                        [r, g, b]
                    }
                    Interpolation::Cubic => cubic(simd, texels, at),
                    _ => bilinear(texels, at),
                }
            };
            let finer = read(level);
            *out = if share > 0.0 && self.interpolation != Interpolation::Nearest {
                let coarser = read(level + 1);
                let mix = |c: usize| finer[c] + share * (coarser[c] - finer[c]);
                [mix(0), mix(1), mix(2)]
            } else {
                finer
            };
        }
        fetches
    }
}

/// The finer of the two copies of `levels` between which samples are as dense as pixels, and the share of the
/// other. Between powers of two the logarithm is taken as straight, which it is within 0.09.
#[inline(always)]
fn level(density: f32, levels: usize) -> (usize, f32) {
    // NaN, too, is no reason for a coarser copy.
    if density.is_nan() || density <= 1.0 {
        return (0, 0.0);
    }
    let whole = ((density.to_bits() >> 23) - 127) as usize;
    if whole + 1 >= levels {
        return (levels - 1, 0.0);
    }
    (whole, density * half_to(whole) - 1.0)
}

/// ½ to a power of at most 100.
#[inline(always)]
fn half_to(power: usize) -> f32 {
    f32::from_bits((127 - power as u32) << 23)
}

/// The sample whose cell holds a place.
#[inline(always)]
fn owner(texels: &Texels, [x, y]: [f32; 2]) -> [f32; 4] {
    // The casts saturate, and make 0 of NaN.
    let x = (x as u32).min(texels.size.x - 1);
    let y = (y as u32).min(texels.size.y - 1);
    texels.live_near(x, y)
}

/// Which sample lies before a place along an axis, and how far after it the place is.
#[inline(always)]
fn before(at: f32) -> (i64, f32) {
    let low = (at - 0.5).floor();
    (low as i64, at - 0.5 - low)
}

/// Between the live ones of the four samples around a place.
#[inline(always)]
fn bilinear(texels: &Texels, at: [f32; 2]) -> [f32; 3] {
    let ((x, fx), (y, fy)) = (before(at[0]), before(at[1]));
    let mut sum = Sum::around(owner(texels, at));
    for (dy, wy) in [(0, 1.0 - fy), (1, fy)] {
        for (dx, wx) in [(0, 1.0 - fx), (1, fx)] {
            sum.add(texels.near(x + dx, y + dy), wx * wy);
        }
    }
    sum.mean()
}

/// By Catmull-Rom weights of sixteen live samples.
///
/// Differences to one of them are weighed, so that one colour everywhere gives that very colour.
#[inline(always)]
fn cubic<S: Simd>(simd: S, texels: &Texels, at: [f32; 2]) -> [f32; 3] {
    let ((x, fx), (y, fy)) = (before(at[0]), before(at[1]));
    let lanes = |v: [f32; 4]| f32x4::from_slice(simd, &v);
    let own = lanes(texels.near(x, y));
    let (across, down) = (cubic_of(fx), cubic_of(fy));
    let (mut sum, mut live) = (lanes([0.0; 4]), lanes([0.0; 4]));
    for (j, wy) in (-1..).zip(down) {
        let mut line = lanes([0.0; 4]);
        for (i, wx) in (-1..).zip(across) {
            let texel = lanes(texels.near(x + i, y + j));
            live += texel;
            line += (texel - own) * wx;
        }
        sum += line * wy;
    }
    if live.to_array()[3] < 16.0 {
        return bilinear(texels, at);
    }
    let [r, g, b, _] = (own + sum).to_array();
    let positive = |c: f32| if c < 0.0 { 0.0 } else { c };
    [positive(r), positive(g), positive(b)]
}

#[cfg(test)]
mod tests {
    use foveasim_models::{Image, Region};
    use glam::UVec2;

    use super::*;
    use crate::kernels::dispatch;
    use crate::memory::Pool;

    /// Catmull-Rom in double precision, by Keys' kernel over the plane.
    fn oracle(image: &Image, x: f64, y: f64) -> f64 {
        let kernel = |d: f64| {
            let d = d.abs();
            match d {
                ..1.0 => (1.5 * d - 2.5) * d * d + 1.0,
                ..2.0 => ((-0.5 * d + 2.5) * d - 4.0) * d + 2.0,
                _ => 0.0,
            }
        };
        let mut sum = 0.0;
        for (k, rgb) in image.rgb.iter().enumerate() {
            let (i, j) = (k as u32 % image.size.x, k as u32 / image.size.x);
            let (dx, dy) = (x - f64::from(i) - 0.5, y - f64::from(j) - 0.5);
            sum += f64::from(rgb[0]) * kernel(dx) * kernel(dy);
        }
        sum.max(0.0)
    }

    fn fetch(levels: &[Texels], places: &[[f32; 2]], density: f32, simd: crate::Simd) -> Vec<f32> {
        let xs: Vec<f32> = places.iter().map(|p| p[0]).collect();
        let ys: Vec<f32> = places.iter().map(|p| p[1]).collect();
        let mut row = vec![[0.0; 3]; places.len()];
        let density = vec![density; places.len()];
        let kernel = FetchMips {
            levels,
            interpolation: Interpolation::Cubic,
            xs: &xs,
            ys: &ys,
            density: &density,
            row: &mut row,
        };
        dispatch(simd, kernel);
        row.into_iter().map(|rgb| rgb[0]).collect()
    }

    #[test]
    fn cubic_is_that_of_double_precision_and_keeps_slopes() {
        let size = UVec2::new(16, 12);
        let random = &mut foveasim_models::Stream::new(1, foveasim_models::Role::Scene, 0);
        let mut image = Image::filled(size, [0.0; 3]);
        for rgb in &mut image.rgb {
            *rgb = [random.uniform() as f32; 3];
        }
        let texels = [Texels::new(
            &image,
            &Region::All,
            false,
            &mut Pool::default(),
        )];
        let places: Vec<[f32; 2]> = (0..500)
            .map(|_| {
                [
                    random.range(2.5, 13.5) as f32,
                    random.range(2.5, 9.5) as f32,
                ]
            })
            .collect();
        let lanes = fetch(&texels, &places, 0.7, crate::Simd::Auto);
        assert_eq!(lanes, fetch(&texels, &places, 0.7, crate::Simd::Scalar));
        for ([x, y], found) in places.iter().zip(&lanes) {
            let exact = oracle(&image, (*x).into(), (*y).into());
            // Sixteen products of weights below 1.3 and differences below 1: 2⁻²⁴ of each, and of the place.
            assert!((f64::from(*found) - exact).abs() < 4e-6, "{found} {exact}");
        }
        // A slope, on a lattice of its own: linear to rounding.
        for (k, rgb) in image.rgb.iter_mut().enumerate() {
            *rgb = [(k as u32 % 16) as f32 * 0.25 + (k as u32 / 16) as f32 * 0.5; 3];
        }
        let texels = [Texels::new(
            &image,
            &Region::All,
            false,
            &mut Pool::default(),
        )];
        for ([x, y], found) in places
            .iter()
            .zip(fetch(&texels, &places, 1.0, crate::Simd::Auto))
        {
            let exact = (x - 0.5) * 0.25 + (y - 0.5) * 0.5;
            assert!((found - exact).abs() < 5e-6, "{found} {exact}");
        }
    }

    /// Halved copies of a slope lie on it, so that any density gives the slope.
    #[test]
    fn copies_lie_where_the_lattice_does() {
        let mut image = Image::filled(UVec2::new(64, 64), [0.0; 3]);
        for (k, rgb) in image.rgb.iter_mut().enumerate() {
            *rgb = [(k % 64) as f32 + (k / 64) as f32 * 2.0; 3];
        }
        let levels = Texels::new(&image, &Region::All, false, &mut Pool::default())
            .chain(9.0, &mut Pool::default());
        assert_eq!(levels.len(), 5);
        let places = [[32.0, 30.5], [33.7, 29.1]];
        for density in [0.2, 1.0, 1.5, 2.0, 3.9, 7.5] {
            for ([x, y], found) in
                places
                    .iter()
                    .zip(fetch(&levels, &places, density, crate::Simd::Auto))
            {
                let exact = (x - 0.5) + (y - 0.5) * 2.0;
                assert!((found - exact).abs() < 1e-4, "{density}: {found} {exact}");
            }
        }
        assert_eq!(level(3.0, 9), (1, 0.5));
        assert_eq!(level(f32::NAN, 9), (0, 0.0));
        assert_eq!(level(1e9, 3), (2, 0.0));
    }
}
