use foveasim_models::math::smoothstep;
use glam::DVec3;

use crate::noise::fractal_2d;
use crate::{Mesh, Vertex};

/// Side of the square of ground, centred on the origin \[m\].
pub const TERRAIN_EXTENT_M: f64 = 400.0;

/// Height of the ground at (x, z) \[m\]: a rolling valley with hills around it.
pub fn terrain_height(x: f64, z: f64, seed: u32) -> f64 {
    let rolling = 5.0 * fractal_2d(x / 45.0, z / 45.0, 5, seed);
    let from_centre = (x * x + z * z).sqrt() / (TERRAIN_EXTENT_M / 2.0);
    let hills = smoothstep((from_centre - 0.42) / 0.5);
    let ridges = 1.0 + 0.6 * fractal_2d(x / 70.0, z / 70.0, 3, seed ^ 0x5eed);
    rolling + 26.0 * hills * ridges
}

/// The ground as `cells` × `cells` squares of two triangles.
///
/// # Panics
/// If `cells` is 0.
pub fn terrain_mesh(seed: u32, cells: u32) -> Mesh {
    assert!(cells > 0, "ground needs at least one cell");
    let step = TERRAIN_EXTENT_M / f64::from(cells);
    let mut vertices = Vec::new();
    for j in 0..=cells {
        for i in 0..=cells {
            let x = f64::from(i) * step - TERRAIN_EXTENT_M / 2.0;
            let z = f64::from(j) * step - TERRAIN_EXTENT_M / 2.0;
            let h = |dx: f64, dz: f64| terrain_height(x + dx, z + dz, seed);
            // Slopes over one cell: the normal of what the mesh shows, not of detail it misses.
            let slope_x = (h(step, 0.0) - h(-step, 0.0)) / (2.0 * step);
            let slope_z = (h(0.0, step) - h(0.0, -step)) / (2.0 * step);
            vertices.push(Vertex {
                position: DVec3::new(x, h(0.0, 0.0), z),
                normal: DVec3::new(-slope_x, 1.0, -slope_z),
                uv: [f64::from(i), f64::from(j)],
            });
        }
    }
    let row = cells + 1;
    let mut triangles = Vec::new();
    for j in 0..cells {
        for i in 0..cells {
            let a = j * row + i;
            let (b, c, d) = (a + 1, a + row, a + row + 1);
            // z grows towards the viewer: counter-clockwise from above is a, c, b.
            triangles.push([a, c, b]);
            triangles.push([b, c, d]);
        }
    }
    Mesh::new(&vertices, triangles).expect("a height field has finite points")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ground_faces_up() {
        let mesh = terrain_mesh(1, 20);
        assert_eq!(mesh.triangles().len(), 800);
        for t in mesh.triangles() {
            let [a, b, c] = t.map(|i| mesh.position(i));
            assert!((b - a).cross(c - a).y > 0.0);
        }
    }
}
