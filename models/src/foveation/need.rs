use glam::{DVec2, DVec3};

use super::cover::TanBox;
use super::{PlanCache, Screen};
use crate::Acuity;
use crate::math::{acos, sqrt, to_deg, to_rad};

/// How far apart samples may lie on a screen, place by place, for an eye that looks towards `gaze` to
/// within `margin_deg`.
///
/// A sample stands for half a cycle, so two of them may be ω(max(0, e − δ))/2 apart. A step of one
/// pixel along x at tangents (x, y) turns the ray by
///
/// p_x · √(1 + y²) / (1 + x² + y²)  \[rad\],
///
/// and likewise along y: off the axis pixels shrink, and along the radius faster than across it. If
/// both steps of a lattice are within a spacing Δ, so are all its families of lines, however the steps
/// are inclined: a family's lines cut at least one of the two steps into whole parts, and are no
/// farther apart than that step is long. So no wave of 2Δ or longer is missed, whether it runs along
/// the radius, across it, or between, and it is enough to bound the steps along x and y.
pub(super) struct Need<'a> {
    pub(super) screen: &'a Screen,
    pub(super) acuity: Acuity,
    /// Unit vector, eye frame.
    pub(super) gaze: DVec3,
    pub(super) margin_deg: f64,
    /// What is kept between needs of the same screen.
    pub(super) cache: Option<&'a PlanCache>,
}

/// What an area looks like from the eye: all that its spacing depends on, but for the acuity line and the margin.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sight {
    /// The least angle between the area and the gaze \[deg\].
    eccentricity_deg: f64,
    /// The largest angle of a pixel along x and along y \[rad\].
    pixel: DVec2,
}

impl Need<'_> {
    /// The widest spacing along x and y that suffices everywhere in what looks so \[display pixels\]: the
    /// acuity where it is nearest the gaze over the angle of its largest pixel. Below 1 the display is
    /// coarser than the eye.
    pub(super) fn allowed(&self, sight: Sight) -> DVec2 {
        let e = sight.eccentricity_deg;
        let step = to_rad(self.acuity.mar_deg(e - self.margin_deg) / 2.0);
        DVec2::splat(step) / sight.pixel
    }

    /// What `area` looks like.
    pub(super) fn sight(&self, area: TanBox) -> Sight {
        let [x, y] = [0, 1].map(|axis| nearest_and_farthest(area.min[axis], area.max[axis]));
        let turn = DVec2::new(largest_turn(x, y), largest_turn(y, x));
        Sight {
            eccentricity_deg: to_deg(acos(self.nearest_cos(area))),
            pixel: self.screen.pixel_tan() * turn,
        }
    }

    /// The cosine of the least angle between `area` and the gaze. Within the hemisphere about the gaze
    /// it is a quasi-concave function of the tangents, so its greatest value is at the gaze itself or
    /// on the edge.
    fn nearest_cos(&self, area: TanBox) -> f64 {
        let g = self.gaze;
        let at = DVec2::new(g.x, g.y) / -g.z;
        if g.z < 0.0 && at.cmpge(area.min).all() && at.cmple(area.max).all() {
            return 1.0;
        }
        let mut best = -1.0f64;
        for axis in 0..2 {
            let (along, across) = ([g.x, g.y][axis], [g.x, g.y][1 - axis]);
            let range = [area.min[axis], area.max[axis]];
            for c in [area.min[1 - axis], area.max[1 - axis]] {
                best = best.max(nearest_on_edge(range, along, across * c - g.z, 1.0 + c * c));
            }
        }
        best.min(1.0)
    }
}

/// The greatest of (a + b·t)/√(c + t²) for t in a range: its only stationary point is t = b·c/a, the
/// greatest value if a > 0 and the least otherwise.
fn nearest_on_edge([low, high]: [f64; 2], b: f64, a: f64, c: f64) -> f64 {
    let f = |t: f64| (a + b * t) / sqrt(c + t * t);
    if a > 0.0 {
        f((b * c / a).clamp(low, high))
    } else {
        f(low).max(f(high))
    }
}

/// The squares of the numbers nearest to and farthest from zero in [low, high].
fn nearest_and_farthest(low: f64, high: f64) -> [f64; 2] {
    let nearest = 0f64.clamp(low, high);
    let farthest = low.abs().max(high.abs());
    [nearest * nearest, farthest * farthest]
}

/// The greatest √u/(u + t²), u = 1 + v², over ranges of t² and v²: it falls with t², and with u from
/// u = t² on.
fn largest_turn([t2, _]: [f64; 2], [v_near, v_far]: [f64; 2]) -> f64 {
    let u = t2.clamp(1.0 + v_near, 1.0 + v_far);
    sqrt(u) / (u + t2)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::GazeDirection;

    impl Need<'_> {
        fn spacing(&self, area: TanBox) -> DVec2 {
            self.allowed(self.sight(area))
        }
    }

    proptest! {
        /// No place of a rectangle allows less than the bound, and a dense search comes near it.
        #[test]
        fn the_bound_holds_everywhere(
            x in -3.0f64..3.0, y in -3.0f64..3.0, w in 1e-3f64..2.0, h in 1e-3f64..2.0,
            az in -180.0f64..180.0, el in -90.0f64..90.0, margin_deg in 0.0f64..30.0,
        ) {
            let screen = Screen::planar(1000.0, 1.5, 0.7).unwrap();
            let gaze = GazeDirection::new(az, el).vector();
            let need = Need { screen: &screen, acuity: Acuity::default(), gaze, margin_deg, cache: None };
            let area = TanBox { min: DVec2::new(x, y), max: DVec2::new(x + w, y + h) };
            let bound = need.spacing(area);
            let (mut cos, mut turn) = (-1.0f64, DVec2::ZERO);
            for i in 0..=60 {
                for j in 0..=60 {
                    let p = area.min + DVec2::new(w * f64::from(i), h * f64::from(j)) / 60.0;
                    let point = need.spacing(TanBox { min: p, max: p });
                    prop_assert!(bound.cmple(point * (1.0 + 1e-7)).all(), "{bound} at {p}: {point}");
                    cos = cos.max(gaze.dot(DVec3::new(p.x, p.y, -1.0).normalize()));
                    let r = 1.0 + p.length_squared();
                    turn = turn.max(DVec2::new(1.0 + p.y * p.y, 1.0 + p.x * p.x).map(f64::sqrt) / r);
                }
            }
            // The two extremes apart, as the bound takes them: within half a step of the search.
            let e = to_deg(cos.acos());
            let near = to_rad(need.acuity.mar_deg(e - margin_deg) / 2.0) / (screen.pixel_tan() * turn);
            prop_assert!(bound.cmpge(near * 0.95 - 0.02).all(), "{bound}, found {near}");
        }
    }

    #[test]
    fn straight_ahead_it_is_the_acuity_over_a_pixel() {
        let screen = Screen::planar(1000.0, 0.5, 1.0).unwrap();
        let need = Need {
            screen: &screen,
            acuity: Acuity::default(),
            gaze: DVec3::NEG_Z,
            margin_deg: 0.0,
            cache: None,
        };
        let at = |x: f64, y: f64| {
            let p = DVec2::new(x, y);
            need.spacing(TanBox { min: p, max: p })
        };
        let foveal = to_rad(1.0 / 96.0) / 0.001;
        assert!((at(0.0, 0.0) - foveal).abs().max_element() < 1e-12);
        // At 45° to the right pixels are half as wide along the radius, 0.7 times across it.
        let there = to_rad((0.0275 * 45.0 + 1.0 / 48.0) / 2.0) / 0.001;
        let expected = DVec2::new(2.0, 2f64.sqrt()) * there;
        assert!((at(1.0, 0.0) - expected).abs().max_element() < 1e-6);
    }
}
