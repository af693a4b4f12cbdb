use foveasim_models::{Affine, Viewport};
use glam::{DVec2, DVec3, UVec2};

use crate::raster::EyeVertex;

/// Sub-sample positions per sample: vertices are snapped to this grid.
pub(crate) const SUBSAMPLES: i32 = 256;

/// Vertices farther than this from the middle of the lattice are clipped [samples]. With tiles of 64
/// samples it keeps every edge function that crosses a tile within 31 bits: differences of snapped
/// coordinates stay below 2·16383·256 < 2²³, times 64 samples, times two axes.
pub(crate) const GUARD_SAMPLES: f64 = 16_383.0;

/// Farthest from the middle of the lattice that a snapped vertex lies, whatever its coordinates
/// [samples]; a sample beyond the guard, for rounding.
const SNAP_SAMPLES: i32 = GUARD_SAMPLES as i32 + 1;

/// From eye space to display pixels: the part of a projection that all passes of a view share.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Optics {
    /// Display pixels per unit of tangent; y points down.
    pub(crate) px_per_tan: [f32; 2],
    /// Display pixel of the axis.
    pub(crate) axis_px: [f32; 2],
}

impl Optics {
    pub(crate) fn new(optics: &Viewport) -> Self {
        let step = optics.pixel_tan();
        let axis = optics.axis_px();
        Self {
            px_per_tan: [(1.0 / step.x) as f32, (-1.0 / step.y) as f32],
            axis_px: [axis.x as f32, axis.y as f32],
        }
    }
}

/// From eye space to the samples of one pass.
///
/// Snapping happens in display pixels scaled to the lattice, and whole sub-samples of the lattice's
/// origin are subtracted as integers: passes that sit on the display's own grid therefore snap every
/// vertex alike, and see the same picture bit for bit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Projection {
    pub(crate) optics: Optics,
    /// Sub-samples per display pixel.
    pub(crate) sub_per_px: [f32; 2],
    /// Display pixels per sub-sample.
    pub(crate) px_per_sub: [f32; 2],
    /// Tangent per display pixel.
    pub(crate) tan_per_px: [f32; 2],
    /// Fraction of a sub-sample of the origin.
    pub(crate) origin_fraction: [f32; 2],
    /// Whole sub-samples of the origin.
    pub(crate) origin_whole: [i32; 2],
    /// Samples, width and height.
    pub(crate) size: UVec2,
    /// Near plane \[m\].
    pub(crate) near: f64,
    tan_origin: DVec2,
    tan_step: DVec2,
    map: Affine,
}

impl Projection {
    pub(crate) fn new(optics: &Viewport, map: &Affine, size: UVec2, near: f64) -> Self {
        let step = optics.pixel_tan();
        let sub = f64::from(SUBSAMPLES) / map.scale;
        let origin = map.origin * sub;
        let whole = origin.floor();
        let single = |v: DVec2| [v.x as f32, v.y as f32];
        Self {
            optics: Optics::new(optics),
            sub_per_px: single(sub),
            px_per_sub: single(1.0 / sub),
            tan_per_px: single(DVec2::new(step.x, -step.y)),
            origin_fraction: single(origin - whole),
            origin_whole: [whole.x as i32, whole.y as i32],
            size,
            near,
            tan_origin: DVec2::new(optics.tan[0], optics.tan[2]),
            tan_step: DVec2::new(step.x, -step.y),
            map: *map,
        }
    }

    /// Tangents (x right, y up) of a lattice position.
    pub(crate) fn tangent(&self, lattice: DVec2) -> DVec2 {
        self.tan_origin + self.tan_step * self.map.display_from_lattice(lattice)
    }

    /// Tangent change per sample along x and along y (the latter negative: y points down).
    pub(crate) fn tangent_step(&self) -> DVec2 {
        self.tan_step * self.map.scale
    }

    /// Tangent of display pixel (0, 0), and tangent per display pixel.
    pub(crate) fn display_tangents(&self) -> (DVec2, DVec2) {
        (self.tan_origin, self.tan_step)
    }

    /// Lattice position = scale · (x, y)/w + shift, in double precision.
    pub(crate) fn lattice_from_tangent(&self) -> (DVec2, DVec2) {
        let scale = 1.0 / self.tangent_step();
        (scale, -self.tangent(DVec2::ZERO) * scale)
    }

    /// Least and greatest position along `axis` that a vertex may be snapped to, in sub-samples and
    /// before the whole sub-samples of the origin are subtracted: below 2²⁵.
    pub(crate) fn snap_range(&self, axis: usize) -> [i32; 2] {
        let middle = self.origin_whole[axis] + self.size[axis] as i32 * (SUBSAMPLES / 2);
        let reach = SNAP_SAMPLES * SUBSAMPLES;
        [middle - reach, middle + reach]
    }

    /// Snaps a vertex as the set-up kernel does; nothing where it is nearer than the near plane or too
    /// far off the lattice.
    pub(crate) fn snap_vertex(&self, v: &EyeVertex) -> Option<[i32; 2]> {
        let ahead = v.eye[2] >= self.near as f32 && v.eye[2] <= f32::MAX;
        let sub =
            [0, 1].map(|k| (v.px[k] * self.sub_per_px[k] - self.origin_fraction[k] + 0.5).floor());
        let within = (0..2).all(|k| {
            let [low, high] = self.usable_range(k);
            sub[k] >= low && sub[k] <= high
        });
        (ahead && within).then(|| [0, 1].map(|k| sub[k] as i32 - self.origin_whole[k]))
    }

    /// What a vertex may be snapped to along `axis` without being clipped: a few samples inside the
    /// guard, for the rounding of this very test. In sub-samples, before the whole sub-samples of the
    /// origin are subtracted.
    pub(crate) fn usable_range(&self, axis: usize) -> [f32; 2] {
        let middle = self.origin_whole[axis] + self.size[axis] as i32 * (SUBSAMPLES / 2);
        let reach = (GUARD_SAMPLES as i32 - 4) * SUBSAMPLES;
        [(middle - reach) as f32, (middle + reach) as f32]
    }

    /// Snaps a point (x, y, w in eye space, w > 0) that clipping made.
    pub(crate) fn snap(&self, p: DVec3) -> [i32; 2] {
        let axis = |c: f64, k: usize| {
            let px =
                c / p.z * f64::from(self.optics.px_per_tan[k]) + f64::from(self.optics.axis_px[k]);
            let sub = px * f64::from(self.sub_per_px[k]) - f64::from(self.origin_fraction[k]);
            let [low, high] = self.snap_range(k);
            // The cast saturates, and makes 0 of NaN.
            ((sub + 0.5).floor() as i32).clamp(low, high) - self.origin_whole[k]
        };
        [axis(p.x, 0), axis(p.y, 1)]
    }

    /// Whether three vertices lie all behind the near plane, or all beyond the same edge of the lattice
    /// by more than a sample.
    pub(crate) fn all_beyond_one_side(&self, v: [&EyeVertex; 3]) -> bool {
        let near = self.near as f32;
        if v.iter().all(|v| v.eye[2] < near) {
            return true;
        }
        let (scale, shift) = self.lattice_from_tangent();
        (0..2).any(|k| {
            let size = self.size[k] as f32;
            // Lattice position times w, for planes that hold in front and behind alike.
            let at = v.map(|v| {
                (
                    v.eye[k] * scale[k] as f32 + v.eye[2] * shift[k] as f32,
                    v.eye[2],
                )
            });
            at.iter().all(|(p, w)| *p < -w) || at.iter().all(|(p, w)| *p > w * (size + 1.0))
        })
    }

    /// Inward normals (x, y, w) of the four planes through the eye and the lattice's edges.
    pub(crate) fn side_planes(&self) -> [DVec3; 4] {
        let low = self.tangent(DVec2::ZERO);
        let high = self.tangent(self.size.as_dvec2());
        [
            DVec3::new(1.0, 0.0, -low.x),
            DVec3::new(-1.0, 0.0, high.x),
            DVec3::new(0.0, -1.0, low.y),
            DVec3::new(0.0, 1.0, -high.y),
        ]
        .map(DVec3::normalize)
    }

    /// Beyond which sides of the view of this pass a sphere (centre x, y, w in eye space) lies wholly: a bit for
    /// the near plane, and one for each [side](Self::side_planes).
    pub(crate) fn sides_missed(&self, centre: DVec3, radius: f64) -> u8 {
        // A sample's worth of slack is far below a thousandth of any radius that matters; rounding
        // of eye coordinates to f32 is below 1e-6 of the distance.
        let reach = radius * 1.001 + centre.length() * 1e-6;
        let sides = self.side_planes().map(|plane| plane.dot(centre) < -reach);
        let mut missed = u8::from(centre.z + reach < self.near);
        for (k, is_missed) in sides.into_iter().enumerate() {
            missed |= u8::from(is_missed) << (k + 1);
        }
        missed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn snapping_stays_in_range_whatever_the_point() {
        let size = UVec2::new(100, 60);
        let optics = Viewport::symmetric(size, 1.0).expect("a viewport");
        for origin in [-65_536.0, 0.0, 65_536.0] {
            let map = Affine {
                origin: DVec2::splat(origin),
                scale: DVec2::ONE,
            };
            let projection = Projection::new(&optics, &map, size, 0.05);
            for x in [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e300, -1e300, 0.0] {
                for w in [f64::NAN, f64::INFINITY, 1e-300, 1.0] {
                    let snapped = projection.snap(DVec3::new(x, -x, w));
                    for (axis, s) in snapped.into_iter().enumerate() {
                        let middle = size[axis] as i32 * 128;
                        assert!((s - middle).abs() <= 16_384 * 256, "{x} {w}: {s}");
                    }
                }
            }
        }
    }
}
