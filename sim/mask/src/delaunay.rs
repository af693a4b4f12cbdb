use glam::DVec2;
use robust::{Coord, incircle, orient2d};
use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation};

use crate::MaskError;

/// No triangle: beyond the hull.
pub(crate) const NONE: u32 = u32::MAX;

/// A Delaunay triangulation in flat arrays, made for questions about the triangles around a place.
///
/// Triangle t has corners `corners[t]`, counter-clockwise (y up), and beyond the side that is opposite to corner k lies
/// `beyond[t][k]`.
#[derive(Debug, Clone)]
pub struct Delaunay {
    pub(crate) sites: Vec<DVec2>,
    pub(crate) corners: Vec<[u32; 3]>,
    pub(crate) beyond: Vec<[u32; 3]>,
    /// One of the triangles at each site.
    at_site: Vec<u32>,
}

/// A site that remembers its number.
struct Numbered {
    at: DVec2,
    number: u32,
}

impl HasPosition for Numbered {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        Point2::new(self.at.x, self.at.y)
    }
}

impl Delaunay {
    /// Triangulates `sites`.
    ///
    /// # Errors
    /// If two coincide, one is not finite, or all lie on a line.
    pub fn new(sites: &[DVec2]) -> Result<Self, MaskError> {
        let refused = |reason: String| MaskError::Sites {
            sites: sites.len(),
            reason,
        };
        if sites.len() >= NONE as usize / 8 {
            return Err(refused("too many".into()));
        }
        let numbered = sites
            .iter()
            .zip(0..)
            .map(|(&at, number)| Numbered { at, number })
            .collect();
        let found = DelaunayTriangulation::<Numbered>::bulk_load(numbered)
            .map_err(|e| refused(e.to_string()))?;
        if found.num_vertices() != sites.len() {
            let reason = format!("only {} different places", found.num_vertices());
            return Err(refused(reason));
        }
        if found.num_inner_faces() == 0 {
            return Err(refused("all lie on a line".into()));
        }
        // The outer face is number 0.
        let triangle = |face: usize| face.checked_sub(1).map_or(NONE, |t| t as u32);
        let mut corners = vec![[0; 3]; found.num_inner_faces()];
        let mut beyond = vec![[NONE; 3]; found.num_inner_faces()];
        let mut at_site = vec![NONE; sites.len()];
        for face in found.inner_faces() {
            let t = triangle(face.fix().index());
            for (k, edge) in face.adjacent_edges().into_iter().enumerate() {
                let site = edge.from().data().number;
                corners[t as usize][k] = site;
                at_site[site as usize] = t;
                // This side is opposite to the corner before it.
                beyond[t as usize][(k + 2) % 3] = triangle(edge.rev().face().fix().index());
            }
        }
        Ok(Self {
            sites: sites.to_vec(),
            corners,
            beyond,
            at_site,
        })
    }

    /// The sites, in the order given.
    pub fn sites(&self) -> &[DVec2] {
        &self.sites
    }

    /// Triangles.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.corners
    }

    /// Whether `q` lies inside the circle through the corners of triangle `t`: exact.
    pub(crate) fn in_circle(&self, t: u32, q: DVec2) -> bool {
        let [a, b, c] = self.corners[t as usize].map(|s| coord(self.sites[s as usize]));
        incircle(a, b, c, coord(q)) > 0.0
    }

    /// Whether `q` lies in triangle `t` or on its sides: exact.
    pub(crate) fn contains(&self, t: u32, q: DVec2) -> bool {
        let [a, b, c] = self.corners[t as usize].map(|s| coord(self.sites[s as usize]));
        let q = coord(q);
        [(a, b), (b, c), (c, a)]
            .into_iter()
            .all(|(from, to)| orient2d(from, to, q) >= 0.0)
    }

    /// A triangle at `site` whose circle holds `q`. There is one if `site` is nearest to `q` and not at it, and `q`
    /// lies within the hull: in the triangulation with `q`, they would be joined.
    pub(crate) fn triangle_towards(&self, site: u32, q: DVec2) -> Option<u32> {
        let first = self.at_site[site as usize];
        // Once around, or to the hull in one direction and then in the other.
        for turn in [1, 2] {
            let mut t = first;
            loop {
                if self.in_circle(t, q) {
                    return Some(t);
                }
                let k = self.corner_at(t, site);
                t = self.beyond[t as usize][(k + turn) % 3];
                if t == first {
                    return None;
                }
                if t == NONE {
                    break;
                }
            }
        }
        None
    }

    /// Which corner of triangle `t` is `site`.
    fn corner_at(&self, t: u32, site: u32) -> usize {
        let corners = self.corners[t as usize];
        corners
            .iter()
            .position(|&s| s == site)
            .expect("triangles at a site have it as a corner")
    }
}

pub(crate) fn coord(p: DVec2) -> Coord<f64> {
    Coord { x: p.x, y: p.y }
}
