//! Which samples of a lattice have a part of the display.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::ops::Range;

use glam::{DVec2, UVec2};

use super::{LensMatched, LogPolar, Map, Radial, Region, Spans};
use crate::math::{cos, hypot, sin};

/// Cells that share less than this of a lattice step with the display only touch it. It is far above
/// rounding, and far below the half pixel by which every pixel's middle lies within the display.
const TOUCH: f64 = 1e-9;

impl Region {
    /// The samples of a `lattice` whose cells lie on a display of `display` pixels, at least in part, so
    /// that every pixel's own cell is among them: all of an affine map's, runs of each row otherwise.
    pub fn on_display(map: &Map, lattice: UVec2, display: UVec2) -> Self {
        match map {
            Map::Affine(_) => Self::All,
            Map::LogPolar(map) => {
                Self::Spans(Spans::new(lattice, |y| ring_span(map, lattice, display, y)))
            }
            Map::LensMatched(map) => {
                Self::Spans(Spans::new(lattice, |y| warped_span(map, display, y)))
            }
            Map::Radial(map) => Self::Spans(Spans::new(lattice, |y| {
                magnified_span(map, lattice, display, y)
            })),
        }
    }
}

/// Columns of row `y` of rings and spokes: the row is a wedge about the gaze, and cuts a connected part out
/// of the display, which spans a range of distances.
fn ring_span(map: &LogPolar, lattice: UVec2, display: UVec2, y: u32) -> Range<u32> {
    let angle = TAU / map.samples().y;
    let (from, to) = (f64::from(y) + TOUCH, f64::from(y + 1) - TOUCH);
    // Half-planes bound a wedge of less than half a turn.
    let parts = ((to - from) * angle / FRAC_PI_2).ceil().max(1.0);
    let (mut near, mut far) = (f64::INFINITY, 0.0f64);
    for part in 0..parts as u32 {
        let side = |k: u32| {
            let turn = angle * (from + (to - from) * f64::from(k) / parts);
            DVec2::new(cos(turn), sin(turn))
        };
        let within = wedge(
            map.gaze_px(),
            [side(part), side(part + 1)],
            display.as_dvec2(),
        );
        if let Some([nearest, farthest]) = distances(map.gaze_px(), &within) {
            near = near.min(nearest);
            far = far.max(farthest);
        }
    }
    if far < TOUCH {
        return 0..0;
    }
    // Within a pixel of the gaze all is in the first column.
    let first = (map.x_at(near) + TOUCH).floor() as u32;
    let end = (map.x_at(far) - TOUCH).ceil().max(1.0) as u32;
    first.min(lattice.x - 1)..end
}

/// The corners of a convex polygon.
type Polygon = Vec<DVec2>;

/// The part of a display of `size` pixels between two directions from `apex`, the second one less than half
/// a turn on from the first.
fn wedge(apex: DVec2, [first, second]: [DVec2; 2], size: DVec2) -> Polygon {
    let corners = vec![
        DVec2::ZERO,
        DVec2::new(size.x, 0.0),
        size,
        DVec2::new(0.0, size.y),
    ];
    let after = clipped(corners, |p| first.perp_dot(p - apex));
    clipped(after, |p| (p - apex).perp_dot(second))
}

/// The part of a convex polygon where a linear function is not negative (Sutherland & Hodgman 1974).
fn clipped(polygon: Polygon, side: impl Fn(DVec2) -> f64) -> Polygon {
    let mut kept = Polygon::with_capacity(polygon.len() + 1);
    for (i, &p) in polygon.iter().enumerate() {
        let next = polygon[(i + 1) % polygon.len()];
        let (a, b) = (side(p), side(next));
        if a >= 0.0 {
            kept.push(p);
        }
        if (a >= 0.0) != (b >= 0.0) {
            kept.push(p + (next - p) * (a / (a - b)));
        }
    }
    kept
}

/// The least and the greatest distance of a convex polygon from a point outside it or on its edge; `None`
/// if it has no corners.
fn distances(from: DVec2, polygon: &Polygon) -> Option<[f64; 2]> {
    let length = |v: DVec2| hypot(v.x, v.y);
    let mut found: Option<[f64; 2]> = None;
    for (i, &p) in polygon.iter().enumerate() {
        let edge = polygon[(i + 1) % polygon.len()] - p;
        let along = ((from - p).dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
        // An edge of no length has no foot: its corner it is.
        let foot = if along.is_nan() { p } else { p + edge * along };
        let [near, far] = found.unwrap_or([f64::INFINITY, 0.0]);
        found = Some([near.min(length(foot - from)), far.max(length(p - from))]);
    }
    found
}

/// Columns of row `y` of warped quadrants, from left to right. In lattice steps from the centre a quadrant's
/// part of the display, unscaled, is bounded by two lines, x ≤ X·(1 − b·y)/(1 + a·X) and a·x ≤ 1 − y·(1/Y + b), for X
/// and Y the pixels from the centre to the display's edge; both recede outwards, so the side of the row
/// nearest the centre reaches farthest.
fn warped_span(map: &LensMatched, display: UVec2, y: u32) -> Range<u32> {
    let (centre, growth, scale) = (map.centre(), map.growth(), map.scale());
    let after = display.as_dvec2() - map.centre_px();
    let (below, inner) = (f64::from(y) + 0.5 > centre.y, {
        let [top, bottom] = [f64::from(y) - centre.y, f64::from(y + 1) - centre.y];
        top.max(-bottom).max(0.0) / scale
    });
    let height = if below { after.y } else { map.centre_px().y };
    // Where the row begins beyond the display's edge over the centre, it does so everywhere.
    if inner + TOUCH >= height / (1.0 + growth.y * height) {
        return 0..0;
    }
    let reach = |width: f64| {
        let side = width * (1.0 - growth.y * inner) / (1.0 + growth.x * width);
        let end = (1.0 - inner * (1.0 / height + growth.y)) / growth.x;
        scale * if growth.x > 0.0 { side.min(end) } else { side }
    };
    let (left, right) = (reach(map.centre_px().x), reach(after.x));
    let first = (centre.x - left + TOUCH).floor().max(0.0);
    let end = (centre.x + right - TOUCH).ceil().max(0.0);
    first as u32..end as u32
}

/// Columns of row `y` of a magnifying buffer. Display x and y grow in size with those of the lattice, both
/// counted from the gaze, since a step around never shortens outwards. So of a cell the place nearest the gaze is the
/// first to be on the display, and in a row nothing follows a cell that is off it.
fn magnified_span(map: &Radial, lattice: UVec2, display: UVec2, y: u32) -> Range<u32> {
    let (gaze, size) = (map.gaze(), display.as_dvec2());
    let nearest = |cell: u32, gaze: f64| {
        let first = f64::from(cell);
        gaze.clamp(first + TOUCH, first + 1.0 - TOUCH)
    };
    let row = nearest(y, gaze.y);
    let is_live = |x: u32| {
        let at = DVec2::new(nearest(x, gaze.x), row);
        let p = map.display_from_lattice(at);
        // Only an edge ahead can be passed; one at the gaze itself a magnified touch may round to.
        let within = |axis: usize| match at[axis] > gaze[axis] {
            true => p[axis] < size[axis],
            false => p[axis] > 0.0,
        };
        within(0) && within(1)
    };
    let own = (gaze.x as u32).min(lattice.x - 1);
    if !is_live(own) {
        return 0..0;
    }
    let first = partition(0, own, |x| !is_live(x));
    let end = partition(own, lattice.x, is_live);
    first..end
}

/// The first of `from..to` that does not have a property which a first part of them has.
fn partition(mut from: u32, mut to: u32, has: impl Fn(u32) -> bool) -> u32 {
    while from < to {
        let middle = from + (to - from) / 2;
        if has(middle) {
            from = middle + 1;
        } else {
            to = middle;
        }
    }
    from
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{Falloff, FalloffTable, Reach};

    /// Whether some of 30 × 30 places in a sample's cell lie on the display.
    fn has_display(map: &Map, sample: UVec2, display: UVec2) -> bool {
        (0..900).any(|k| {
            let within = DVec2::new(f64::from(k % 30), f64::from(k / 30)) / 29.0;
            // Not the very edge, which two cells share.
            let within = within * (1.0 - 2e-6) + 1e-6;
            let p = map.display_from_lattice(sample.as_dvec2() + within);
            p.cmpgt(DVec2::ZERO).all() && p.cmplt(display.as_dvec2()).all()
        })
    }

    /// Live are the cells that have a part of the display, and no others: every cell that a search finds on
    /// the display is live, and every pixel's own; those that are live without being found reach it by a
    /// corner at most, so there are few.
    fn check(map: &Map, lattice: UVec2, display: UVec2) -> Result<(), TestCaseError> {
        let region = Region::on_display(map, lattice, display);
        let mut corners = 0;
        for y in 0..lattice.y {
            for x in 0..lattice.x {
                let sample = UVec2::new(x, y);
                let (live, found) = (region.is_live(sample), has_display(map, sample, display));
                prop_assert!(live || !found, "{sample} of {map:?} is on the display");
                corners += u32::from(live && !found);
            }
        }
        prop_assert!(
            corners <= 8 + lattice.y / 4,
            "{corners} of {map:?} are not on the display"
        );
        for y in 0..display.y {
            for x in 0..display.x {
                let px = UVec2::new(x, y).as_dvec2() + 0.5;
                let own = map.lattice_from_display(px).as_uvec2();
                prop_assert!(region.is_live(own), "{own} holds {px} of {map:?}");
            }
        }
        Ok(())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]

        #[test]
        fn rings_on_the_display(
            w in 1u32..40, h in 1u32..40, gx in -0.5f64..1.5, gy in -0.5f64..1.5,
            nx in 1u32..14, ny in 1u32..14, log_alpha in -1.5f64..1.5, corner: bool,
        ) {
            let display = UVec2::new(w, h);
            let gaze = if corner { DVec2::ZERO } else { DVec2::new(gx, gy) * display.as_dvec2() };
            let lattice = UVec2::new(nx, ny);
            let map = LogPolar::new(gaze, display, log_alpha.exp(), lattice.as_dvec2()).unwrap();
            check(&Map::LogPolar(map), lattice, display)?;
        }

        #[test]
        fn quadrants_on_the_display(
            w in 1u32..40, h in 1u32..40, gx in 0.0f64..1.0, gy in 0.0f64..1.0, a in 0.0f64..3.0, b in 0.0f64..3.0,
            scale in 0.3f64..3.0, scaled: bool,
        ) {
            let display = UVec2::new(w, h);
            let size = display.as_dvec2();
            let gaze = (DVec2::new(gx, gy) * size).round();
            let growth = DVec2::new(a, b) * 2.0 / size;
            let scale = if scaled { scale } else { 1.0 };
            let steps = |far: DVec2| (far / (1.0 + growth * far) * scale).ceil();
            let centre = steps(gaze);
            let lattice = (centre + steps(size - gaze)).as_uvec2();
            let map = LensMatched::new(gaze, centre, growth).unwrap().scaled(scale).unwrap();
            check(&Map::LensMatched(map), lattice, display)?;
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]

        #[test]
        fn magnified_on_the_display(
            w in 1u32..40, h in 1u32..40, gx in -0.1f64..1.1, gy in -0.1f64..1.1, k in 1.0f64..4.0,
            scale in 0.2f64..1.5, boundary: bool, table: bool,
        ) {
            let display = UVec2::new(w, h);
            let gaze = (DVec2::new(gx, gy)).clamp(DVec2::ZERO, DVec2::ONE) * display.as_dvec2();
            let points = [[0.0, 0.0], [0.4, 0.1], [0.8, 0.6], [1.0, 1.0]];
            let falloff = match table {
                true => Falloff::Table(FalloffTable::new(&points).unwrap()),
                false => Falloff::Power(k),
            };
            let reach = if boundary { Reach::Boundary } else { Reach::Corner };
            let map = Radial::new(gaze, display, falloff, reach, scale).unwrap();
            let region = Region::on_display(&Map::Radial(map), map.lattice(), display);
            if boundary {
                let all = u64::from(map.lattice().element_product());
                prop_assert_eq!(match &region { Region::Spans(s) => s.samples(), _ => 0 }, all);
            }
            check(&Map::Radial(map), map.lattice(), display)?;
        }
    }

    #[test]
    fn a_corner_sees_a_quarter() {
        let display = UVec2::new(1280, 1440);
        let lattice = UVec2::new(640, 720);
        let count = |gaze| {
            let map = LogPolar::new(gaze, display, 4.0, lattice.as_dvec2()).unwrap();
            match Region::on_display(&Map::LogPolar(map), lattice, display) {
                Region::Spans(spans) => (spans.row(180).len(), spans.samples()),
                other => panic!("{other:?}"),
            }
        };
        let (beyond, samples) = count(DVec2::ZERO);
        assert_eq!(beyond, 0);
        assert!(samples > 113_000 && samples < 640 * 180, "{samples}");
        let (_, whole) = count(DVec2::new(640.0, 720.0));
        assert!(whole > 450_000 && whole < 640 * 720, "{whole}");
    }
}
