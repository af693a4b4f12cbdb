use glam::DVec3;
use thiserror::Error;

/// One vertex of a mesh, object space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertex {
    /// Position \[m\].
    pub position: DVec3,
    /// Outward normal, any length above zero.
    pub normal: DVec3,
    /// Texture coordinates.
    pub uv: [f64; 2],
}

/// Triangles in object space, each attribute in its own array so that a kernel reads eight at once.
/// Front faces are counter-clockwise seen from outside.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    positions: [Vec<f32>; 3],
    normals: [Vec<f32>; 3],
    uvs: [Vec<f32>; 2],
    triangles: Vec<[u32; 3]>,
    /// Positions at the end of a scan, if vertices move by themselves.
    end_positions: Option<[Vec<f32>; 3]>,
    centre: DVec3,
    radius: f64,
}

/// Why vertices and indices are not a mesh.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MeshError {
    /// There is nothing to draw.
    #[error("a mesh needs at least one triangle; this one has none")]
    Empty,
    /// A vertex has a NaN, an infinity, a huge coordinate or no normal.
    #[error("vertex {index} has {what} = {value}: must be {valid}")]
    Vertex {
        /// Which vertex, from 0.
        index: usize,
        /// Which attribute.
        what: &'static str,
        /// Its value.
        value: String,
        /// What would be valid.
        valid: &'static str,
    },
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} names vertex {index}: there are {vertices}, counted from 0")]
    Index {
        /// Which triangle, from 0.
        triangle: usize,
        /// The index given.
        index: u32,
        /// How many vertices there are.
        vertices: usize,
    },
}

/// Largest coordinate of a mesh \[m\]: beyond it, single precision has no millimetres left.
const LARGEST_M: f64 = 1e6;

impl Mesh {
    /// A mesh of `vertices` joined by `triangles`.
    ///
    /// # Errors
    /// If there is no triangle, a vertex is not finite or a triangle names one that does not exist.
    pub fn new(vertices: &[Vertex], triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        if triangles.is_empty() {
            return Err(MeshError::Empty);
        }
        for (index, v) in vertices.iter().enumerate() {
            check(index, v)?;
        }
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(&index) = corners.iter().find(|&&i| i as usize >= vertices.len()) {
                return Err(MeshError::Index {
                    triangle,
                    index,
                    vertices: vertices.len(),
                });
            }
        }
        let low = vertices
            .iter()
            .fold(DVec3::INFINITY, |a, v| a.min(v.position));
        let high = vertices
            .iter()
            .fold(DVec3::NEG_INFINITY, |a, v| a.max(v.position));
        let centre = (low + high) / 2.0;
        let radius = vertices
            .iter()
            .map(|v| v.position.distance(centre))
            .fold(0.0, f64::max);
        let columns = |f: &dyn Fn(&Vertex) -> [f64; 3]| {
            let mut columns = [(); 3].map(|()| Vec::with_capacity(vertices.len()));
            for v in vertices {
                for (column, value) in columns.iter_mut().zip(f(v)) {
                    column.push(value as f32);
                }
            }
            columns
        };
        let [u, v, _] = columns(&|v| [v.uv[0], v.uv[1], 0.0]);
        Ok(Self {
            positions: columns(&|v| v.position.to_array()),
            normals: columns(&|v| v.normal.normalize().to_array()),
            uvs: [u, v],
            triangles,
            end_positions: None,
            centre,
            // Rounding a position to f32 may move it outwards by half a unit in the last place.
            radius: radius + LARGEST_M.min(centre.length() + radius) * f64::from(f32::EPSILON),
        })
    }

    /// x, y and z of all vertices \[m\].
    pub fn positions(&self) -> &[Vec<f32>; 3] {
        &self.positions
    }

    /// The same mesh whose vertices move within a scan, evenly and straight, from where they are to where
    /// `end` has them: a function of a vertex's position \[m\]. Normals stay as they are.
    ///
    /// # Errors
    /// If a vertex would leave ±1e6 m.
    pub fn moving_to(mut self, end: impl Fn(DVec3) -> DVec3) -> Result<Self, MeshError> {
        let mut columns = [(); 3].map(|()| Vec::with_capacity(self.vertex_count()));
        let mut farthest = self.radius;
        for index in 0..self.vertex_count() {
            let position = end(self.position(index as u32));
            let vertex = Vertex {
                position,
                normal: DVec3::Z,
                uv: [0.0; 2],
            };
            check(index, &vertex)?;
            let rounding = position.length() * f64::from(f32::EPSILON);
            farthest = farthest.max(position.distance(self.centre) + rounding);
            for (column, value) in columns.iter_mut().zip(position.to_array()) {
                column.push(value as f32);
            }
        }
        self.radius = farthest;
        self.end_positions = Some(columns);
        Ok(self)
    }

    /// x, y and z of all vertices at the end of a scan \[m\], if they move within it.
    pub fn end_positions(&self) -> Option<&[Vec<f32>; 3]> {
        self.end_positions.as_ref()
    }

    /// x, y and z of all normals, unit length.
    pub fn normals(&self) -> &[Vec<f32>; 3] {
        &self.normals
    }

    /// u and v of all vertices.
    pub fn uvs(&self) -> &[Vec<f32>; 2] {
        &self.uvs
    }

    /// Vertex indices of all triangles.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// How many vertices.
    pub fn vertex_count(&self) -> usize {
        self.positions[0].len()
    }

    /// Centre \[m\] and radius \[m\] of a sphere that holds all vertices, wherever they move within a scan.
    pub fn bounds(&self) -> (DVec3, f64) {
        (self.centre, self.radius)
    }

    /// The position of vertex `index` \[m\].
    pub fn position(&self, index: u32) -> DVec3 {
        let [x, y, z] = &self.positions;
        let i = index as usize;
        DVec3::new(x[i].into(), y[i].into(), z[i].into())
    }
}

fn check(index: usize, v: &Vertex) -> Result<(), MeshError> {
    let error = |what, value: String, valid| {
        Err(MeshError::Vertex {
            index,
            what,
            value,
            valid,
        })
    };
    if !(v.position.abs().max_element() <= LARGEST_M && v.position.is_finite()) {
        return error(
            "position",
            v.position.to_string(),
            "three numbers within ±1e6 m",
        );
    }
    if !(v.normal.is_finite() && v.normal.length() > 1e-30 && v.normal.length() < 1e30) {
        return error(
            "normal",
            v.normal.to_string(),
            "a finite vector longer than zero",
        );
    }
    if !v.uv.iter().all(|c| c.abs() <= LARGEST_M) {
        return error("uv", format!("{:?}", v.uv), "two numbers within ±1e6");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vertex(x: f64) -> Vertex {
        Vertex {
            position: DVec3::new(x, 0.0, 0.0),
            normal: DVec3::Z,
            uv: [0.0; 2],
        }
    }

    #[test]
    fn malformed_meshes_are_refused_by_name() {
        let good = [vertex(0.0), vertex(1.0), vertex(2.0)];
        assert_eq!(Mesh::new(&good, vec![]), Err(MeshError::Empty));
        let text = Mesh::new(&good, vec![[0, 1, 3]]).unwrap_err().to_string();
        assert!(text.contains("triangle 0 names vertex 3"), "{text}");
        let text = Mesh::new(&[vertex(f64::NAN)], vec![[0, 0, 0]])
            .unwrap_err()
            .to_string();
        assert!(text.contains("vertex 0 has position"), "{text}");
        let flat = Vertex {
            normal: DVec3::ZERO,
            ..vertex(0.0)
        };
        assert!(Mesh::new(&[flat], vec![[0, 0, 0]]).is_err());
    }
}
