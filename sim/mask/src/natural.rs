use glam::DVec2;
use robust::orient2d;

use crate::Delaunay;
use crate::delaunay::{NONE, coord};

/// One site that a place is interpolated from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Neighbour {
    /// Its number.
    pub site: u32,
    /// Its share: all of a place's sum up to one.
    pub weight: f64,
}

/// Finds weights of places among the sites of a [`Delaunay`] triangulation; keeps its scratch memory between them.
///
/// A place is a natural neighbour of the corners of all triangles whose circles hold it: those are the triangles that
/// would go if it became a site. The weight of a site is the area that the place's new Voronoi cell would take of the
/// site's cell, over all of the new cell (Sibson 1980): a polygon of centres of circles, those of the triangles that
/// would go and those of the triangles that would come. Everything is computed relative to the place, in double
/// precision; which circles hold it is decided exactly.
#[derive(Debug)]
pub struct NaturalNeighbours<'a> {
    delaunay: &'a Delaunay,
    /// Triangles whose circles hold the place, and the centres of the circles.
    held: Vec<(u32, DVec2)>,
    /// Area taken of each natural neighbour, twice, and where its polygon leaves and meets the old cells' edges.
    taken: Vec<Taken>,
}

#[derive(Debug, Clone, Copy)]
struct Taken {
    site: u32,
    area: f64,
    enter: DVec2,
    leave: DVec2,
}

impl<'a> NaturalNeighbours<'a> {
    /// For places among the sites of `delaunay`.
    pub fn new(delaunay: &'a Delaunay) -> Self {
        Self {
            delaunay,
            held: Vec::new(),
            taken: Vec::new(),
        }
    }

    /// Sibson's weights at `q`, of which `nearest` is the (or a) nearest site, in `out`; false (and nothing in `out`)
    /// where they do not exist: outside the hull, or on it.
    pub fn sibson(&mut self, q: DVec2, nearest: u32, out: &mut Vec<Neighbour>) -> bool {
        out.clear();
        if self.is_at(q, nearest, out) {
            return true;
        }
        if !self.hold(q, nearest) {
            return false;
        }
        self.taken.clear();
        for k in 0..self.held.len() {
            let (t, centre) = self.held[k];
            for side in 0..3 {
                let [from, to] = self.side(t, side);
                let beyond = self.delaunay.beyond[t as usize][side];
                // Beyond the hull is no triangle, so none is held.
                if let Some(other) = self.held.iter().position(|(h, _)| *h == beyond) {
                    // An edge of old cells between the two sites: each pair of triangles once.
                    if other > k {
                        let step = centre.perp_dot(self.held[other].1);
                        self.taken(to).area += step;
                        self.taken(from).area -= step;
                    }
                    continue;
                }
                let Some(corner) = self.new_centre(q, from, to) else {
                    return false;
                };
                // The new cell's corner, where the two sites' cells meet it.
                let step = corner.perp_dot(centre);
                let taken = self.taken(from);
                taken.area += step;
                taken.leave = corner;
                let taken = self.taken(to);
                taken.area -= step;
                taken.enter = corner;
            }
        }
        let mut whole = 0.0;
        for taken in &mut self.taken {
            // Along the new cell, from one of its corners to the next.
            taken.area = (taken.area + taken.enter.perp_dot(taken.leave)).max(0.0);
            whole += taken.area;
        }
        if !(whole > 0.0 && whole.is_finite()) {
            return false;
        }
        let weight = |t: &Taken| Neighbour {
            site: t.site,
            weight: t.area / whole,
        };
        out.extend(self.taken.iter().map(weight));
        true
    }

    /// Barycentric weights at `q` in the triangle that holds it; false (and nothing in `out`) outside the hull.
    pub fn barycentric(&mut self, q: DVec2, nearest: u32, out: &mut Vec<Neighbour>) -> bool {
        out.clear();
        if self.is_at(q, nearest, out) {
            return true;
        }
        if !self.hold(q, nearest) {
            return false;
        }
        let holds = |(t, _): &&(u32, DVec2)| self.delaunay.contains(*t, q);
        let Some(&(t, _)) = self.held.iter().find(holds) else {
            return false;
        };
        let corners = self.delaunay.corners[t as usize];
        let [a, b, c] = corners.map(|s| self.delaunay.sites[s as usize] - q);
        let areas = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)].map(|v| v.max(0.0));
        let whole: f64 = areas.iter().sum();
        out.extend(
            corners
                .into_iter()
                .zip(areas)
                .map(|(site, area)| Neighbour {
                    site,
                    weight: area / whole,
                }),
        );
        true
    }

    /// Whether `q` is the site `nearest`, which then has all the weight.
    fn is_at(&self, q: DVec2, nearest: u32, out: &mut Vec<Neighbour>) -> bool {
        let at = self.delaunay.sites[nearest as usize] == q;
        if at {
            let weight = 1.0;
            out.push(Neighbour {
                site: nearest,
                weight,
            });
        }
        at
    }

    /// Collects the triangles whose circles hold `q`: they are connected, and one is at the nearest site.
    fn hold(&mut self, q: DVec2, nearest: u32) -> bool {
        self.held.clear();
        let Some(first) = self.delaunay.triangle_towards(nearest, q) else {
            return false;
        };
        self.held.push((first, self.centre(q, first)));
        let mut next = 0;
        while let Some(&(t, _)) = self.held.get(next) {
            next += 1;
            for beyond in self.delaunay.beyond[t as usize] {
                let known = beyond == NONE || self.held.iter().any(|(h, _)| *h == beyond);
                if !known && self.delaunay.in_circle(beyond, q) {
                    let centre = self.centre(q, beyond);
                    self.held.push((beyond, centre));
                }
            }
        }
        true
    }

    /// The side of triangle `t` that is opposite to corner `k`, counter-clockwise.
    fn side(&self, t: u32, k: usize) -> [u32; 2] {
        let corners = self.delaunay.corners[t as usize];
        [corners[(k + 1) % 3], corners[(k + 2) % 3]]
    }

    /// The centre of triangle `t`'s circle, relative to `q`.
    fn centre(&self, q: DVec2, t: u32) -> DVec2 {
        let [a, b, c] = self.delaunay.corners[t as usize].map(|s| self.delaunay.sites[s as usize]);
        (a - q) + circle_through_origin(b - a, c - a)
    }

    /// The centre of the circle through `q` and two sites, relative to `q`; `None` if they lie on a line, or `q` on the
    /// outer side of it.
    fn new_centre(&self, q: DVec2, from: u32, to: u32) -> Option<DVec2> {
        let [a, b] = [from, to].map(|s| self.delaunay.sites[s as usize]);
        let inside = orient2d(coord(a), coord(b), coord(q)) > 0.0;
        inside.then(|| circle_through_origin(a - q, b - q))
    }

    fn taken(&mut self, site: u32) -> &mut Taken {
        let at = self.taken.iter().position(|t| t.site == site);
        let at = at.unwrap_or_else(|| {
            self.taken.push(Taken {
                site,
                area: 0.0,
                enter: DVec2::ZERO,
                leave: DVec2::ZERO,
            });
            self.taken.len() - 1
        });
        &mut self.taken[at]
    }
}

/// The centre of the circle through the origin, `a` and `b`.
fn circle_through_origin(a: DVec2, b: DVec2) -> DVec2 {
    let d = 2.0 * a.perp_dot(b);
    let (aa, bb) = (a.length_squared(), b.length_squared());
    DVec2::new(aa * b.y - bb * a.y, bb * a.x - aa * b.x) / d
}
