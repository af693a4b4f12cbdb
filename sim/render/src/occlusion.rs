use foveasim_models::{Pass, View, Work};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::Occlusion;
use crate::live::grid;
use crate::pass::PassSamples;

/// Directions and distances that are looked at around a sample: on a spiral that fills a circle evenly, ever the same.
const AROUND: [[f64; 2]; 12] = [
    [0.204_124_145, 0.0],
    [-0.260_699_7, 0.238_825_3],
    [0.039_904_5, -0.454_695_1],
    [0.328_581_5, 0.428_551_6],
    [-0.603_005_3, -0.106_650_6],
    [0.571_268_3, -0.363_357_6],
    [-0.191_161_3, 0.710_608_7],
    [-0.364_408_9, -0.701_577_3],
    [0.789_697_1, 0.288_265_4],
    [-0.824_838_1, 0.333_565_1],
    [0.385_604_3, -0.852_407_7],
    [0.297_563_4, 0.932_283_4],
];
/// Samples farther away in the lattice are not looked at, however near the eye is.
const FARTHEST: f64 = 96.0;
/// What lies less than this share of its distance before a surface's plane does not darken it: depths are single precision.
const LEAST_RISE: f64 = 0.06;
/// How much a sample darkens at most, all around it being covered.
const STRENGTH: f64 = 1.6;

/// Darkens the samples of a pass that others are near to.
pub(crate) fn occlude(
    samples: &mut PassSamples,
    pass: &Pass,
    view: &View,
    occlusion: Occlusion,
) -> Work {
    let size = grid(pass);
    let width = size.x as usize;
    let near = Near {
        places: places(pass, view, &samples.inverse_w),
        pixel_tan: view.optics.pixel_tan(),
        size: [i64::from(size.x), i64::from(size.y)],
        wraps: pass.map.wraps(),
        radius_m: occlusion.radius_m,
    };
    let rows = samples.image.rgb.par_chunks_mut(width).enumerate();
    let reads: Vec<u64> = rows
        .map(|(y, row)| {
            let mut reads = 0;
            for (x, rgb) in row.iter_mut().enumerate() {
                let factor = near.factor(x as i64, y as i64, &mut reads) as f32;
                *rgb = rgb.map(|c| c * factor);
            }
            reads
        })
        .collect();
    Work {
        occlusion_reads: reads.into_iter().sum(),
        ..Work::default()
    }
}

/// What a sample shows: where on the display \[px\], and where in the eye's frame \[m\].
#[derive(Debug, Clone, Copy)]
struct Point {
    px: DVec2,
    eye: DVec3,
}

/// What every sample shows; `None` of the sky, and where nothing is drawn.
fn places(pass: &Pass, view: &View, inverse_w: &[f32]) -> Vec<Option<Point>> {
    let width = grid(pass).x.max(1) as usize;
    let place = |(k, inverse_w): (usize, &f32)| {
        let drawn = *inverse_w > 0.0;
        drawn.then(|| {
            let middle = DVec2::new((k % width) as f64 + 0.5, (k / width) as f64 + 0.5);
            let px = pass.map.display_from_lattice(middle + pass.offset);
            Point {
                px,
                eye: view.optics.direction(px) / f64::from(*inverse_w),
            }
        })
    };
    inverse_w.par_iter().enumerate().map(place).collect()
}

struct Near {
    places: Vec<Option<Point>>,
    pixel_tan: DVec2,
    size: [i64; 2],
    wraps: bool,
    radius_m: f64,
}

impl Near {
    fn at(&self, x: i64, y: i64) -> Option<Point> {
        let [width, height] = self.size;
        let y = if self.wraps { y.rem_euclid(height) } else { y };
        if !(0..width).contains(&x) || !(0..height).contains(&y) {
            return None;
        }
        self.places[(y * width + x) as usize]
    }

    /// From a sample to the neighbour along an axis of the lattice whose depth is nearer to its own.
    fn step(&self, own: &Point, x: i64, y: i64, axis: [i64; 2]) -> Option<(DVec2, DVec3)> {
        let towards = |sign: i64| {
            let other = self.at(x + sign * axis[0], y + sign * axis[1])?;
            let sign = sign as f64;
            Some((sign * (other.px - own.px), sign * (other.eye - own.eye)))
        };
        let depth = |step: &(DVec2, DVec3)| step.1.z.abs();
        match (towards(1), towards(-1)) {
            (Some(a), Some(b)) => Some(if depth(&b) < depth(&a) { b } else { a }),
            (a, b) => a.or(b),
        }
    }

    /// What is left of a sample's light.
    fn factor(&self, x: i64, y: i64, reads: &mut u64) -> f64 {
        let Some(own) = self.at(x, y) else {
            return 1.0;
        };
        let (Some(across), Some(down)) =
            (self.step(&own, x, y, [1, 0]), self.step(&own, x, y, [0, 1]))
        else {
            return 1.0;
        };
        // Lattice axes may be turned or mirrored; a surface that is seen looks to the eye.
        let normal = across.1.cross(down.1).normalize_or_zero();
        let normal = if normal.dot(own.eye) > 0.0 {
            -normal
        } else {
            normal
        };
        // From display to lattice, by the steps around: what makes distances follow the density.
        let det = across.0.perp_dot(down.0);
        if det.is_nan() || det.abs() <= 1e-12 {
            return 1.0;
        }
        let radius = DVec2::splat(self.radius_m) / (self.pixel_tan * -own.eye.z);
        let mut sum = 0.0;
        for [u, v] in AROUND {
            let px = DVec2::new(u, v) * radius;
            let lattice = DVec2::new(px.perp_dot(down.0), across.0.perp_dot(px)) / det;
            let lattice = lattice.clamp(DVec2::splat(-FARTHEST), DVec2::splat(FARTHEST));
            let (i, j) = (lattice.x.round() as i64, lattice.y.round() as i64);
            if (i, j) == (0, 0) {
                continue;
            }
            *reads += 1;
            let Some(other) = self.at(x + i, y + j) else {
                continue;
            };
            let away = other.eye - own.eye;
            let square = away.length_squared();
            let nearness = 1.0 - square / (self.radius_m * self.radius_m);
            if nearness > 0.0 && square > 0.0 {
                let rise = normal.dot(away) / square.sqrt() - LEAST_RISE;
                sum += rise.max(0.0) * nearness;
            }
        }
        (1.0 - STRENGTH * sum / AROUND.len() as f64).max(0.0)
    }
}
