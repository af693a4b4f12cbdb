use std::collections::HashMap;

use glam::DVec3;

use super::Warnings;
use super::error::Flaw;
use super::normals::Normals;
use crate::{Mesh, Vertex};

/// Stands for an attribute that a corner does not have.
pub(super) const NONE: u32 = u32::MAX;

/// One corner of a triangle: indices into the columns of a [`Soup`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Corner {
    pub(super) position: u32,
    pub(super) uv: u32,
    pub(super) normal: u32,
}

/// Triangles as files give them, each attribute with its own indices. Whoever fills it has checked
/// that indices are in range and numbers finite.
#[derive(Debug, Default)]
pub(super) struct Soup {
    pub(super) positions: Vec<DVec3>,
    pub(super) uvs: Vec<[f64; 2]>,
    pub(super) normals: Vec<DVec3>,
    pub(super) triangles: Vec<[Corner; 3]>,
    /// Material of each triangle; empty if all are of material 0.
    pub(super) materials: Vec<u32>,
}

/// Largest coordinate that a mesh may have \[file units\]; texture coordinates too.
pub(super) const LARGEST: f64 = 1e6;

/// `value` if it is a coordinate.
pub(super) fn coordinate(value: f64, what: &str) -> Result<f64, String> {
    if value.abs() <= LARGEST {
        Ok(value)
    } else {
        Err(format!("{what} = {value}: must be a number within ±1e6"))
    }
}

impl Soup {
    /// One mesh for each material, with normals for all corners that have none: the average by area
    /// of the triangles about a position, apart where they meet at more than the angle of cosine
    /// `crease`. Triangles without area are dropped and counted.
    pub(super) fn into_meshes(
        mut self,
        crease: f64,
        warnings: &mut Warnings,
    ) -> Result<Vec<(u32, Mesh)>, Flaw> {
        let dropped = self.drop_degenerate();
        if dropped > 0 {
            warnings.add(format!(
                "triangles without area, which are not drawn: {dropped}"
            ));
        }
        self.complete_normals(crease, warnings);
        let material = |t: u32| self.materials.get(t as usize).copied().unwrap_or(0);
        let mut order: Vec<u32> = (0..self.triangles.len() as u32).collect();
        // Stable: triangles of one material stay in the file's order.
        order.sort_by_key(|&t| material(t));
        order
            .chunk_by(|&a, &b| material(a) == material(b))
            .map(|triangles| Ok((material(triangles[0]), self.mesh(triangles)?)))
            .collect()
    }

    fn drop_degenerate(&mut self) -> usize {
        let before = self.triangles.len();
        // In the precision of the mesh, in which it is drawn.
        let at = |c: Corner| self.positions[c.position as usize].as_vec3().as_dvec3();
        let has_area = |t: &[Corner; 3]| {
            let [a, b, c] = t.map(at);
            (b - a).cross(c - a) != DVec3::ZERO
        };
        let keep: Vec<bool> = self.triangles.iter().map(has_area).collect();
        let mut kept = keep.iter();
        self.triangles.retain(|_| *kept.next().unwrap_or(&true));
        let mut kept = keep.iter();
        self.materials.retain(|_| *kept.next().unwrap_or(&true));
        before - self.triangles.len()
    }

    fn complete_normals(&mut self, crease: f64, warnings: &mut Warnings) {
        // A normal of no length is none.
        let usable = |n: &DVec3| (1e-30..1e30).contains(&n.length());
        let without = self.normals.iter().filter(|n| !usable(n)).count();
        if without > 0 {
            warnings.add(format!(
                "normals of no length, which are computed instead: {without}"
            ));
            for corner in self.triangles.iter_mut().flatten() {
                if corner.normal != NONE && !usable(&self.normals[corner.normal as usize]) {
                    corner.normal = NONE;
                }
            }
        }
        if !self.triangles.iter().flatten().any(|c| c.normal == NONE) {
            return;
        }
        let mut computed = Normals::new(self.positions.len(), crease);
        let names: Vec<[u32; 3]> = self
            .triangles
            .iter()
            .map(|corners| {
                let [a, b, c] = corners.map(|c| self.positions[c.position as usize]);
                let area = (b - a).cross(c - a);
                corners.map(|c| computed.add(c.position, area))
            })
            .collect();
        let first = self.normals.len() as u32;
        self.normals.extend(computed.finish());
        for (corners, names) in self.triangles.iter_mut().zip(names) {
            for (corner, name) in corners.iter_mut().zip(names) {
                if corner.normal == NONE {
                    corner.normal = first + name;
                }
            }
        }
    }

    /// The mesh of some of the triangles.
    fn mesh(&self, triangles: &[u32]) -> Result<Mesh, Flaw> {
        let mut vertices = Vec::new();
        let mut index_of: HashMap<Corner, u32> = HashMap::new();
        let mut index = |corner: Corner| {
            *index_of.entry(corner).or_insert_with(|| {
                vertices.push(self.vertex(corner));
                vertices.len() as u32 - 1
            })
        };
        let indices = triangles
            .iter()
            .map(|&t| self.triangles[t as usize].map(&mut index))
            .collect();
        Mesh::new(&vertices, indices).map_err(|e| Flaw::new("mesh", e))
    }

    fn vertex(&self, c: Corner) -> Vertex {
        Vertex {
            position: self.positions[c.position as usize],
            normal: self.normals[c.normal as usize],
            uv: self.uvs.get(c.uv as usize).copied().unwrap_or([0.0; 2]),
        }
    }
}
