use glam::DVec2;

use super::{MovingPoint, MovingTriangle, Outline, Sampling};

/// The bounds of Friston 2019, §4, as published, to compare with: of a triangle's three edges, each bent by
/// lens, scan and magnification, they enclose the lattice positions.
///
/// None of them is conservative. The distance of a bent edge from a straight one is not convex, as the search
/// for its maximum takes it to be: it can return 0 beside a bulge of 52 pixels. Even with true
/// distances, the polygon of §4.2 joins the displaced edges' ends by straight lines that a bent edge may cross
/// (24 pixels). And a scan may catch a corner twice, or never, where the search takes one place for granted. For triangles
/// that reach behind the eye the paper splits and takes a box; here that is all of the lattice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PublishedBound {
    /// The box around the bent edges, taken at every pixel of them.
    Box,
    /// Search and displace from the unbent edges, as they lie at the frame's start.
    Simple,
    /// Search and displace from the straight lines between the bent edges' ends.
    Adaptive,
}

/// Steps of the ternary search: to a 4096th of an edge the paper needs 12, and 30 end the argument that more would
/// help.
const STEPS: u32 = 30;

/// The most places at which a box looks along an edge.
const MOST_PLACES: f64 = 4096.0;

impl PublishedBound {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Box, Self::Simple, Self::Adaptive];

    /// What the bound leaves of the lattice.
    pub fn outline(self, triangle: &MovingTriangle, sampling: &Sampling) -> Outline {
        let depths = triangle.0.map(|p| [p.start.z, p.end.z]);
        if depths.as_flattened().iter().all(|w| *w <= 0.0) {
            return Outline::Nothing;
        }
        if depths.as_flattened().iter().any(|w| *w <= 0.0) {
            return Outline::Everything;
        }
        let found = match self {
            Self::Box => boxed(triangle, sampling),
            Self::Simple => displaced(triangle, sampling, unbent),
            Self::Adaptive => displaced(triangle, sampling, |p, s| s.lattice_of(p)),
        };
        found.unwrap_or(Outline::Everything)
    }
}

impl Sampling {
    /// The lattice position at which a moving point lights, by the paper's forward map: the time at which the scan
    /// catches it ([`Zenon::catch`](super::Zenon::catch), within the frame or not), its place then, lens, and
    /// magnification. With a lens the time is found by repetition, which settles where the scan outruns the
    /// point. `None` if the scan never catches it, it is behind the eye then, or the lens does not show it.
    pub fn lattice_of(&self, point: &MovingPoint) -> Option<DVec2> {
        let mut t = match &self.scan {
            Some(scan) => point.zenon(scan, self.display_px).catch()?,
            None => 0.0,
        };
        if let (Some(scan), Some(lens)) = (&self.scan, &self.lens) {
            for _ in 0..64 {
                let display = lens.display_from_ray(place(point, t)?)?;
                let lights = scan.time(display, self.display_px);
                let moved = (lights - t).abs();
                t = lights;
                if moved < 1e-14 {
                    break;
                }
            }
        }
        self.lattice_from_ray(place(point, t)?)
    }
}

/// Where a point is seen at `t`.
fn place(point: &MovingPoint, t: f64) -> Option<DVec2> {
    let p = point.at(t);
    (p.z > 0.0).then(|| p.truncate() / p.z)
}

/// A lattice position without lens, scan and magnification: where the point is at the start, in steps of the
/// lattice as if nothing were magnified.
fn unbent(point: &MovingPoint, sampling: &Sampling) -> Option<DVec2> {
    let p = place(point, 0.0)?;
    Some(match sampling.map {
        crate::Map::Radial(map) => map.unmagnified(p),
        map => map.lattice_from_display(p),
    })
}

fn boxed(triangle: &MovingTriangle, sampling: &Sampling) -> Option<Outline> {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for i in 0..3 {
        let [a, b] = triangle.edge(i);
        let [from, to] = [&a, &b].map(|p| sampling.lattice_of(p));
        let places = (2.0 * from?.distance(to?)).ceil().clamp(8.0, MOST_PLACES);
        for k in 0..=places as u32 {
            let p = sampling.lattice_of(&a.towards(&b, f64::from(k) / places))?;
            low = low.min(p);
            high = high.max(p);
        }
    }
    Some(Outline::Polygon(vec![
        low,
        DVec2::new(high.x, low.y),
        high,
        DVec2::new(low.x, high.y),
    ]))
}

/// Each edge, straight between its ends by `straight`, moved outwards until the search finds nothing
/// beyond it (§4.1, §4.2). The polygon of the six ends is taken to be convex, as the paper has it: their hull.
fn displaced(
    triangle: &MovingTriangle,
    sampling: &Sampling,
    straight: impl Fn(&MovingPoint, &Sampling) -> Option<DVec2>,
) -> Option<Outline> {
    let [a, b, c] = [0, 1, 2].map(|i| straight(&triangle.0[i], sampling));
    let corners = [a?, b?, c?];
    let mut ends = Vec::with_capacity(6);
    for i in 0..3 {
        let (from, to, third) = (corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]);
        let along = (to - from).normalize_or_zero();
        let inwards = along.perp().dot(third - from);
        let outwards = if inwards > 0.0 {
            -along.perp()
        } else {
            along.perp()
        };
        let [start, end] = triangle.edge(i);
        let beyond = |s: f64| {
            let bent = sampling.lattice_of(&start.towards(&end, s))?;
            Some(outwards.dot(bent - from))
        };
        let move_by = outwards * searched(beyond)?.max(0.0);
        ends.extend([from + move_by, to + move_by]);
    }
    Some(Outline::hull(ends))
}

/// The largest value that a ternary search over \[0, 1\] meets, both ends and the middle among them.
fn searched(f: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    let (mut low, mut high) = (0.0, 1.0);
    let mut found = f(0.0)?.max(f(1.0)?).max(f(0.5)?);
    for _ in 0..STEPS {
        let third = (high - low) / 3.0;
        let (a, b) = (f(low + third)?, f(high - third)?);
        found = found.max(a).max(b);
        if a < b {
            low += third;
        } else {
            high -= third;
        }
    }
    Some(found)
}
