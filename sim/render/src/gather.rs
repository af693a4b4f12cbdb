use foveasim_models::{Map, Work};
use glam::{DMat2, DVec2};
use rayon::prelude::*;

use crate::texels::{Sum, Texels};

/// How far a pixel's kernel reaches \[px\]: (1 − q²)² then has a pixel's variance, 1/12 along each axis.
const PIXEL_REACH: f64 = 0.816_496_580_927_726;
/// How far it reaches in steps of the lattice where those are longer: between the variance of linear interpolation
/// (1.15) and that of a cubic B-spline (1.63).
const STEP_REACH: f64 = 1.5;
/// From so many steps on, where the kernel's edge lies in the lattice is asked of the map itself.
const FAR: f64 = 4.0;

/// Puts display pixels together from samples by where these truly are on the display (Friston 2019, §3.1.1: the mapping
/// of a reconstruction filter into the buffer).
///
/// With J the steps of the lattice at the pixel, a sample at d from it counts (1 − q²)² within q < 1, q² = dᵀ·Σ⁻¹·d,
/// where Σ has the directions of J·Jᵀ and for each of its values λ the larger of reach² of a pixel and λ·reach² of a
/// step. Weights are divided by their sum.
pub(crate) struct Gather<'a> {
    map: &'a Map,
    texels: &'a Texels,
    /// Where the samples are \[px\].
    places: Vec<[f32; 2]>,
}

/// A symmetric matrix: xx, xy, yy.
type Symmetric = [f64; 3];

impl<'a> Gather<'a> {
    pub(crate) fn new(map: &'a Map, texels: &'a Texels) -> Self {
        let width = texels.size.x.max(1) as usize;
        let mut places = vec![[0.0; 2]; texels.rgba.len()];
        let rows = places.par_chunks_mut(width);
        let live = texels.rgba.par_chunks(width);
        rows.zip(live).enumerate().for_each(|(y, (row, live))| {
            for (x, (place, texel)) in row.iter_mut().zip(live).enumerate() {
                if texel[3] != 0.0 {
                    let middle = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                    let px = map.display_from_lattice(middle);
                    *place = [px.x as f32, px.y as f32];
                }
            }
        });
        Self {
            map,
            texels,
            places,
        }
    }

    /// Fills row `y` of the display.
    pub(crate) fn row(&self, y: u32, row: &mut [[f32; 3]]) -> Work {
        let mut fetches = 0;
        for (x, out) in row.iter_mut().enumerate() {
            let px = DVec2::new(x as f64 + 0.5, f64::from(y) + 0.5);
            *out = self.pixel(px, &mut fetches);
        }
        Work {
            pixels_resolved: row.len() as u64,
            resolve_fetches: fetches,
            ..Work::default()
        }
    }

    fn pixel(&self, px: DVec2, fetches: &mut u64) -> [f32; 3] {
        let at = self.map.lattice_from_display(px);
        let steps = self.map.steps(at);
        let spread = spread(steps);
        let far = self.reach(px, at, steps, spread);
        let size = self.texels.size;
        let own = self
            .texels
            .live_near((at.x as u32).min(size.x - 1), (at.y as u32).min(size.y - 1));
        let mut sum = Sum::around(own);
        let [xx, xy, yy] = inverse(spread).map(|c| c as f32);
        let (px_x, px_y) = (px.x as f32, px.y as f32);
        let last = i64::from(size.x) - 1;
        let columns = ((at.x - far.x - 0.5).ceil() as i64).clamp(0, last)
            ..=((at.x + far.x - 0.5).floor() as i64).clamp(0, last);
        let (low, high) = self.rows(at.y, far.y);
        for y in low..=high {
            let first = self.texels.row_at(y) as usize * size.x as usize;
            let run = first + *columns.start() as usize..=first + *columns.end() as usize;
            for (texel, place) in self.texels.rgba[run.clone()].iter().zip(&self.places[run]) {
                let (dx, dy) = (place[0] - px_x, place[1] - px_y);
                let off = 1.0 - (xx * dx * dx + 2.0 * xy * dx * dy + yy * dy * dy);
                if off > 0.0 {
                    sum.add(*texel, off * off);
                }
            }
            *fetches += columns.clone().count() as u64;
        }
        sum.mean()
    }

    /// First and last row within `far` of `at`; each row once where they wrap.
    fn rows(&self, at: f64, far: f64) -> (i64, i64) {
        let count = i64::from(self.texels.size.y);
        let low = (at - far - 0.5).ceil() as i64;
        let high = (at + far - 0.5).floor() as i64;
        match self.texels.wraps {
            true => (low, high.min(low + count - 1)),
            false => (low.clamp(0, count - 1), high.clamp(0, count - 1)),
        }
    }

    /// How far from `at` along each axis of the lattice samples of the kernel may lie.
    fn reach(&self, px: DVec2, at: DVec2, steps: DMat2, spread: Symmetric) -> DVec2 {
        let size = self.texels.size.as_dvec2();
        // The kernel seen from the lattice: J⁻¹·Σ·J⁻ᵀ, of which the diagonal is asked.
        let back = steps.inverse();
        let along = |row: DVec2| {
            let [xx, xy, yy] = spread;
            (xx * row.x * row.x + 2.0 * xy * row.x * row.y + yy * row.y * row.y).sqrt()
        };
        let straight = DVec2::new(along(back.row(0)), along(back.row(1)));
        if straight.max_element() <= FAR {
            return straight;
        }
        // Many samples in a pixel: the lattice bends within it.
        let [xx, _, yy] = spread.map(f64::sqrt);
        let mut far = DVec2::splat(STEP_REACH);
        for edge in [DVec2::new(xx, 0.0), DVec2::new(0.0, yy)] {
            for edge in [edge, -edge] {
                let mut away = self.map.lattice_from_display(px + edge) - at;
                if self.texels.wraps {
                    away.y -= size.y * (away.y / size.y).round();
                }
                far = far.max(away.abs());
            }
        }
        // Where the map has no inverse steps are no numbers.
        let straight = DVec2::select(straight.cmple(size), straight, DVec2::ZERO);
        far.max(straight).min(size)
    }
}

/// Σ of the kernel where lattice steps are `steps` \[px²\]; a pixel's if those are no numbers.
fn spread(steps: DMat2) -> Symmetric {
    let square = steps * steps.transpose();
    let [xx, xy, yy] = [square.x_axis.x, square.x_axis.y, square.y_axis.y];
    let pixel = PIXEL_REACH * PIXEL_REACH;
    if !(xx + yy).is_finite() {
        return [pixel, 0.0, pixel];
    }
    let wide = |value: f64| (STEP_REACH * STEP_REACH * value).max(pixel);
    // Its two values, and what a function of the matrix is by them.
    let middle = (xx + yy) / 2.0;
    let half = ((xx - yy) * (xx - yy) / 4.0 + xy * xy).sqrt();
    let (large, small) = (wide(middle + half), wide((middle - half).max(0.0)));
    let slope = if half > 1e-12 * middle {
        (large - small) / (2.0 * half)
    } else {
        0.0
    };
    let mean = (large + small) / 2.0;
    [
        mean + slope * (xx - middle),
        slope * xy,
        mean + slope * (yy - middle),
    ]
}

fn inverse([xx, xy, yy]: Symmetric) -> Symmetric {
    let det = xx * yy - xy * xy;
    [yy / det, -xy / det, xx / det]
}

#[cfg(test)]
mod tests {
    use foveasim_models::{Affine, Falloff, Image, Radial, Reach, Region};
    use glam::UVec2;

    use super::*;
    use crate::memory::Pool;

    #[test]
    fn the_kernel_is_as_wide_as_pixels_and_steps() {
        let pixel = PIXEL_REACH * PIXEL_REACH;
        let wide = STEP_REACH * STEP_REACH;
        let close = |a: Symmetric, b: Symmetric| {
            for (a, b) in a.into_iter().zip(b) {
                assert!((a - b).abs() < 1e-12, "{a} {b}");
            }
        };
        close(spread(DMat2::IDENTITY * 0.1), [pixel, 0.0, pixel]);
        close(
            spread(DMat2::from_diagonal(DVec2::new(4.0, 0.1))),
            [16.0 * wide, 0.0, pixel],
        );
        // Turned by 45°.
        let turn = DMat2::from_cols(DVec2::new(0.5, 0.5), DVec2::new(-0.5, 0.5)) * 2f64.sqrt();
        let turned = turn * DMat2::from_diagonal(DVec2::new(4.0, 0.1));
        let (mean, half) = ((16.0 * wide + pixel) / 2.0, (16.0 * wide - pixel) / 2.0);
        close(spread(turned), [mean, half, mean]);
        close(
            spread(DMat2::from_diagonal(DVec2::splat(f64::NAN))),
            [pixel, 0.0, pixel],
        );
    }

    /// Against a sum over all samples in double precision, with the kernel written down anew.
    #[test]
    fn pixels_are_the_sums_of_double_precision() {
        let display = UVec2::new(48, 40);
        let gaze = DVec2::new(17.3, 22.8);
        let falloff = Falloff::power(2.0).unwrap();
        let radial = Radial::new(gaze, display, falloff, Reach::Corner, 1.0).unwrap();
        let affine = Affine {
            origin: DVec2::new(-0.25, 0.5),
            scale: DVec2::new(1.7, 2.3),
        };
        let maps = [
            (Map::Radial(radial), radial.lattice(), 5e-3),
            (Map::Affine(affine), UVec2::new(29, 18), 2e-6),
        ];
        for (map, lattice, bound) in maps {
            let random = &mut foveasim_models::Stream::new(2, foveasim_models::Role::Scene, 0);
            let mut image = Image::filled(lattice, [0.0; 3]);
            for rgb in &mut image.rgb {
                *rgb = [random.uniform() as f32; 3];
            }
            let region = Region::on_display(&map, lattice, display);
            let texels = Texels::new(&image, &region, false, &mut Pool::default());
            let gather = Gather::new(&map, &texels);
            let mut worst: f64 = 0.0;
            for y in 0..display.y {
                let mut row = vec![[0.0; 3]; display.x as usize];
                gather.row(y, &mut row);
                for (x, found) in row.iter().enumerate() {
                    let px = DVec2::new(x as f64 + 0.5, f64::from(y) + 0.5);
                    let sigma = spread(map.steps(map.lattice_from_display(px)));
                    let [xx, xy, yy] = inverse(sigma);
                    let (mut sum, mut weight) = (0.0, 0.0);
                    for (k, texel) in texels.rgba.iter().enumerate() {
                        let (i, j) = (k as u32 % lattice.x, k as u32 / lattice.x);
                        let middle = DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5);
                        let d = map.display_from_lattice(middle) - px;
                        let q = xx * d.x * d.x + 2.0 * xy * d.x * d.y + yy * d.y * d.y;
                        let w = if q < 1.0 && texel[3] > 0.0 {
                            (1.0 - q) * (1.0 - q)
                        } else {
                            0.0
                        };
                        sum += w * f64::from(texel[0]);
                        weight += w;
                    }
                    worst = worst.max((f64::from(found[0]) - sum / weight).abs());
                }
            }
            // Where the lattice bends within a kernel, the box that is searched may miss samples at its rim, where they
            // hardly count. Elsewhere what is off is the rounding of places.
            assert!(worst < bound, "{worst}");
        }
    }

    /// What is linear over the display comes out within a thousandth of a pixel where samples lie evenly and no farther
    /// apart than half a pixel, within a twelfth of a step where they are longer.
    #[test]
    fn slopes_over_the_display_are_kept() {
        let display = UVec2::new(40, 40);
        for (scale, bound) in [(0.25, 0.01), (0.5, 0.03), (1.0, 0.0834), (3.0, 0.0834)] {
            let map = Map::Affine(Affine {
                origin: DVec2::new(0.31, 0.17),
                scale: DVec2::splat(scale),
            });
            let lattice = (display.as_dvec2() / scale).ceil().as_uvec2();
            let mut image = Image::filled(lattice, [0.0; 3]);
            for (k, rgb) in image.rgb.iter_mut().enumerate() {
                let middle = DVec2::new(
                    (k as u32 % lattice.x) as f64 + 0.5,
                    (k as u32 / lattice.x) as f64 + 0.5,
                );
                *rgb = [map.display_from_lattice(middle).x as f32; 3];
            }
            let texels = Texels::new(&image, &Region::All, false, &mut Pool::default());
            let gather = Gather::new(&map, &texels);
            let mut row = vec![[0.0; 3]; 40];
            gather.row(20, &mut row);
            for (x, found) in row.iter().enumerate().take(32).skip(8) {
                let off = (f64::from(found[0]) - x as f64 - 0.5).abs();
                assert!(off <= bound * scale.max(1.0), "{scale}: {off}");
            }
        }
    }
}
