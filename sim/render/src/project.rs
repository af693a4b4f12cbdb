use foveasim_models::{Affine, Viewport};
use glam::{DVec2, DVec3, UVec2};

/// Sub-sample positions per sample: vertices are snapped to this grid.
pub(crate) const SUBSAMPLES: i32 = 256;

/// Vertices farther than this from the middle of the lattice are clipped [samples]. With tiles of 64
/// samples it keeps every edge function that crosses a tile within 31 bits: differences of snapped
/// coordinates stay below 2·16383·256 < 2²³, times 64 samples, times two axes.
pub(crate) const GUARD_SAMPLES: f64 = 16_383.0;

/// Farthest from the middle of the lattice that a snapped vertex lies, whatever its coordinates
/// [samples]; a sample beyond the guard, for rounding.
const SNAP_SAMPLES: i32 = GUARD_SAMPLES as i32 + 1;

/// From eye space to the samples of one pass.
///
/// Snapping happens in display pixels scaled to the lattice, and whole sub-samples of the lattice's
/// origin are subtracted as integers: passes that sit on the display's own grid therefore snap every
/// vertex alike, and see the same picture bit for bit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Projection {
    /// Display pixels per unit of tangent; y points down.
    pub(crate) px_per_tan: [f32; 2],
    /// Display pixel of the axis.
    pub(crate) axis_px: [f32; 2],
    /// Sub-samples per display pixel.
    pub(crate) sub_per_px: [f32; 2],
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
        let axis = optics.axis_px();
        let sub = f64::from(SUBSAMPLES) / map.scale;
        let origin = map.origin * sub;
        let whole = origin.floor();
        let single = |v: DVec2| [v.x as f32, v.y as f32];
        Self {
            px_per_tan: single(DVec2::new(1.0 / step.x, -1.0 / step.y)),
            axis_px: single(axis),
            sub_per_px: single(sub),
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

    /// Snaps a point (x, y, w in eye space, w > 0) as the vertex kernel does.
    pub(crate) fn snap(&self, p: DVec3) -> [i32; 2] {
        let axis = |c: f64, k: usize| {
            let px = c / p.z * f64::from(self.px_per_tan[k]) + f64::from(self.axis_px[k]);
            let sub = px * f64::from(self.sub_per_px[k]) - f64::from(self.origin_fraction[k]);
            let [low, high] = self.snap_range(k);
            // The cast saturates, and makes 0 of NaN.
            ((sub + 0.5).floor() as i32).clamp(low, high) - self.origin_whole[k]
        };
        [axis(p.x, 0), axis(p.y, 1)]
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

    /// Whether a sphere (centre x, y, w in eye space) lies wholly outside the view of this pass.
    pub(crate) fn misses_sphere(&self, centre: DVec3, radius: f64) -> bool {
        // A sample's worth of slack is far below a thousandth of any radius that matters; rounding
        // of eye coordinates to f32 is below 1e-6 of the distance.
        let reach = radius * 1.001 + centre.length() * 1e-6;
        centre.z + reach < self.near
            || self
                .side_planes()
                .iter()
                .any(|plane| plane.dot(centre) < -reach)
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
