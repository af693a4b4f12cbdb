use glam::DVec3;

use super::EyeVertex;
use crate::project::{GUARD_SAMPLES, Projection};

/// A corner of a clipped triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corner {
    /// x, y and w in eye space.
    eye: DVec3,
    /// The snapped position of a vertex that was there before clipping: neighbours that needed no
    /// clipping use it, so this triangle must too.
    snapped: Option<[i32; 2]>,
}

/// A corner that can be rasterized: snapped position, and 1/w.
pub(super) type SnappedCorner = ([i32; 2], f64);

/// Clips a triangle to the near plane and to the guard band (Sutherland and Hodgman 1974); fewer
/// than three corners where nothing is left.
///
/// A new corner is computed from the kept end towards the cut-off end. Both triangles at a shared
/// edge agree on which end that is, so they get the same corner and no gap can open.
pub(super) fn clip(vertices: [&EyeVertex; 3], projection: &Projection) -> Vec<SnappedCorner> {
    let mut polygon: Vec<Corner> = vertices
        .iter()
        .map(|v| Corner {
            eye: DVec3::from_array(v.eye.map(f64::from)),
            snapped: projection.snap_vertex(v),
        })
        .collect();
    let near = projection.near;
    cut(&mut polygon, |p| p.z - near);
    let (scale, shift) = projection.lattice_from_tangent();
    for axis in 0..2 {
        let middle = f64::from(projection.size[axis]) / 2.0;
        let (low, high) = (middle - GUARD_SAMPLES, middle + GUARD_SAMPLES);
        let lattice = |p: DVec3| p[axis] * scale[axis] + p.z * shift[axis];
        cut(&mut polygon, |p| lattice(p) - low * p.z);
        cut(&mut polygon, |p| high * p.z - lattice(p));
    }
    let snap = |c: &Corner| {
        (
            c.snapped.unwrap_or_else(|| projection.snap(c.eye)),
            1.0 / c.eye.z,
        )
    };
    polygon.iter().map(snap).collect()
}

/// Keeps the part of a convex polygon where `distance` is not negative.
fn cut(polygon: &mut Vec<Corner>, distance: impl Fn(DVec3) -> f64) {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, b) in polygon.iter().enumerate() {
        let a = &polygon[(i + polygon.len() - 1) % polygon.len()];
        // A vertex that the vertex kernel could snap is inside, whatever rounding says here.
        let at = |c: &Corner| {
            if c.snapped.is_some() {
                1.0
            } else {
                distance(c.eye)
            }
        };
        let (inside_a, inside_b) = (at(a) >= 0.0, at(b) >= 0.0);
        if inside_a != inside_b {
            let (keep, drop) = if inside_a { (a, b) } else { (b, a) };
            let (dk, dd) = (distance(keep.eye).max(0.0), distance(drop.eye));
            let eye = keep.eye + (drop.eye - keep.eye) * (dk / (dk - dd));
            kept.push(Corner { eye, snapped: None });
        }
        if inside_b {
            kept.push(*b);
        }
    }
    *polygon = kept;
}
