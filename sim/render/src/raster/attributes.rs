use foveasim_assets::{Material, Pattern, Scene};
use glam::{DVec2, DVec3};

use super::{EyeVertex, SetUpTriangle, ViewGeometry};
use crate::kernels::{Attributes, Details};
use crate::project::{Projection, SUBSAMPLES};

/// Which attributes a material reads beside place and normal.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Needs {
    /// Position in the object.
    pub(crate) object: bool,
    /// Texture coordinates.
    pub(crate) uv: bool,
}

impl Needs {
    pub(crate) fn of(material: &Material) -> Self {
        let (object, uv) = match material {
            Material::Unlit(_) | Material::Terrain(_) | Material::Phong(_) => (false, false),
            Material::Surface(s) => match s.pattern {
                Pattern::Plain => (false, false),
                Pattern::Checker | Pattern::Stripes => (false, true),
                _ => (true, false),
            },
            Material::Textured(_) => (false, true),
            _ => (true, true),
        };
        Self { object, uv }
    }
}

/// For the second and the third corner of the mesh triangle: barycentric weight over w, at the first corner
/// of the set-up triangle, its change along x, along y.
type Weights = [[f32; 3]; 2];

/// The vertices of a triangle, copied: to be asked for all triangles of a tile before anything is done with
/// them, so that far memory serves many reads at once.
pub(crate) fn vertices(
    scene: &Scene,
    geometry: &ViewGeometry,
    t: &SetUpTriangle,
) -> [EyeVertex; 3] {
    let object = &geometry.objects[t.object as usize];
    let corners = scene.meshes()[object.mesh as usize].triangles()[t.index()];
    let vertices = &geometry.vertices[object.first_vertex as usize..];
    corners.map(|i| vertices[i as usize])
}

/// The same at the end of a scan.
pub(crate) fn vertices_at_end(
    scene: &Scene,
    geometry: &ViewGeometry,
    t: &SetUpTriangle,
) -> [EyeVertex; 3] {
    let object = &geometry.objects[t.object as usize];
    let corners = scene.meshes()[object.mesh as usize].triangles()[t.index()];
    let vertices = geometry.at_end(object, scene);
    corners.map(|i| vertices[i as usize])
}

/// What every material needs of a triangle whose vertices are `vertices`.
pub(crate) fn attributes(
    t: &SetUpTriangle,
    vertices: &[EyeVertex; 3],
    projection: &Projection,
) -> Attributes {
    let mut a = [0.0f32; Attributes::COUNT];
    // Exact below 2¹⁵ samples.
    let per_sample = 1.0 / SUBSAMPLES as f32;
    a[Attributes::CORNER] = t.corners[0][0] as f32 * per_sample;
    a[Attributes::CORNER + 1] = t.corners[0][1] as f32 * per_sample;
    a[Attributes::DEPTH..Attributes::DEPTH + 3].copy_from_slice(&t.depth);
    a[Attributes::DEPTH + 3..Attributes::DEPTH + 5].copy_from_slice(&t.depth_range);

    // Normal over w is linear over the image, and its direction is the normal's. Seen from behind, the
    // other side's normal counts.
    let sign = if t.is_behind() { -1.0 } else { 1.0 };
    let normals = vertices.map(|v| v.normal.map(|n| n * sign));
    if t.is_whole {
        let inverse = vertices.map(|v| 1.0 / v.eye[2]);
        let [second, third] = gradients(t);
        for k in 0..3 {
            let [p, q, r] = [0, 1, 2].map(|i| normals[i][k] * inverse[i]);
            a[Attributes::NORMAL + k] = p;
            a[Attributes::NORMAL + 3 + k] = (q - p) * second[0] + (r - p) * third[0];
            a[Attributes::NORMAL + 6 + k] = (q - p) * second[1] + (r - p) * third[1];
        }
    } else {
        let [second, third] = exact_weights(vertices, t, projection);
        for k in 0..3 {
            let [p, q, r] = normals.map(|n| n[k]);
            for i in 0..3 {
                a[Attributes::NORMAL + 3 * i + k] =
                    p * t.depth[i] + (q - p) * second[i] + (r - p) * third[i];
            }
        }
    }
    Attributes(a)
}

/// What only some materials need of a triangle, or only fragments whose middle may lie outside of it.
pub(crate) fn details(
    scene: &Scene,
    geometry: &ViewGeometry,
    t: &SetUpTriangle,
    vertices: &[EyeVertex; 3],
    projection: &Projection,
    needs: Needs,
) -> Details {
    let object = &geometry.objects[t.object as usize];
    let mesh = &scene.meshes()[object.mesh as usize];
    let corners = mesh.triangles()[t.index()];
    let mut a = [0.0f32; Details::COUNT];
    let weights = weights(vertices, t, projection);
    a[Details::WEIGHTS..Details::WEIGHTS + 6].copy_from_slice(weights.as_flattened());
    let sign = if t.is_behind() { -1.0 } else { 1.0 };
    let normals = vertices.map(|v| v.normal.map(|n| n * sign));
    spread(&mut a, Details::NORMAL, normals);
    if needs.object || needs.uv {
        let scale = scene.instances()[object.instance as usize]
            .world_from_object
            .scale;
        a[Details::PER_METRE] = (1.0 / scale) as f32;
        let [xs, ys, zs] = mesh.positions();
        let objects = corners.map(|i| [xs[i as usize], ys[i as usize], zs[i as usize]]);
        spread(&mut a, Details::OBJECT, objects);
        if needs.uv {
            let [us, vs] = mesh.uvs();
            let uvs = corners.map(|i| [us[i as usize], vs[i as usize]]);
            spread(&mut a, Details::UV, uvs);
            let steepest = [(1, 0), (2, 0), (2, 1)]
                .map(|(i, j)| length2(uvs[i], uvs[j]) / length2(objects[i], objects[j]).max(1e-24))
                .into_iter()
                .fold(0.0, f32::max);
            a[Details::PER_METRE + 1] = steepest.sqrt() * (1.0 / scale) as f32;
        }
    }
    Details(a)
}

/// Change along x and along y of the barycentric weight, in the image, of the second and the third corner
/// of the mesh triangle.
///
/// From snapped corners, whose differences and area are exact integers: a covered sample's weights are
/// within 0..=1 but for rounding, whatever the triangle's shape, and neighbours meet without a step.
/// Against the corners before snapping, what is interpolated shifts by less than 1/360 of a sample.
fn gradients(t: &SetUpTriangle) -> [[f32; 2]; 2] {
    let [a, p, q] = t.corners;
    let (b, c) = if t.is_behind() { (p, q) } else { (q, p) };
    let (abx, aby) = (b[0] - a[0], b[1] - a[1]);
    let (acx, acy) = (c[0] - a[0], c[1] - a[1]);
    // Set-up keeps no triangle without area.
    let scale = SUBSAMPLES as f32 / (abx * acy - acx * aby) as f32;
    [
        [acy as f32 * scale, acx as f32 * -scale],
        [aby as f32 * -scale, abx as f32 * scale],
    ]
}

fn weights(vertices: &[EyeVertex; 3], t: &SetUpTriangle, projection: &Projection) -> Weights {
    if !t.is_whole {
        return exact_weights(vertices, t, projection);
    }
    let [second, third] = gradients(t);
    let over = |v: &EyeVertex, [x, y]: [f32; 2]| [0.0, x / v.eye[2], y / v.eye[2]];
    [over(&vertices[1], second), over(&vertices[2], third)]
}

/// From eye space, in double precision: corners may be behind the eye, or far outside the image.
fn exact_weights(vertices: &[EyeVertex; 3], t: &SetUpTriangle, projection: &Projection) -> Weights {
    let eye = vertices.map(|v| DVec3::from_array(v.eye.map(f64::from)));
    // A point seen in direction d = (tx, ty, 1) is w·d = Σ βᵢpᵢ, so β/w = M⁻¹d with M = (p₀ p₁ p₂):
    // linear over the image, while β is not.
    let lattice = t.corners[0].map(|c| f64::from(c) / f64::from(SUBSAMPLES));
    let tangent = projection.tangent(DVec2::from_array(lattice));
    let step = projection.tangent_step();
    let rows = [eye[2].cross(eye[0]), eye[0].cross(eye[1])];
    let inverse = 1.0 / eye[1].dot(rows[0]);
    rows.map(|row| {
        let row = row * inverse;
        let weights = [
            row.dot(DVec3::new(tangent.x, tangent.y, 1.0)),
            row.x * step.x,
            row.y * step.y,
        ];
        // Edge-on, a triangle has no weights; its first corner will do.
        if weights.iter().all(|w| w.is_finite()) {
            weights.map(|w| w as f32)
        } else {
            [0.0; 3]
        }
    })
}

/// Writes an attribute as its value at the first corner and its changes towards the other two.
#[inline(always)]
fn spread<const N: usize>(a: &mut [f32; Details::COUNT], first: usize, [p, q, r]: [[f32; N]; 3]) {
    for k in 0..N {
        a[first + k] = p[k];
        a[first + N + k] = q[k] - p[k];
        a[first + 2 * N + k] = r[k] - p[k];
    }
}

fn length2<const N: usize>(a: [f32; N], b: [f32; N]) -> f32 {
    let mut sum = 0.0;
    for k in 0..N {
        sum += (a[k] - b[k]) * (a[k] - b[k]);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::super::BEHIND;
    use super::*;

    /// From any corner, four roundings (of two integers, their quotient, its product with 256 or a
    /// difference) are 4 · 2⁻²⁴ of each product; products are at most extent² / area.
    #[test]
    fn weights_are_one_at_their_corner_and_nothing_at_the_others() {
        let corners = [
            [[0, 0], [2560, 0], [0, 1280]],
            [[-70_000, 3], [-69_999, 4], [-70_001, 5]],
            [[4_000_000, 9], [4_000_000 + 32_000, 10], [4_000_000, 500]],
            [[17, 33], [16_000, 20_000], [15_900, 20_001]],
        ];
        for corners in corners {
            for behind in [0, BEHIND] {
                let t = SetUpTriangle {
                    corners,
                    depth: [1.0, 0.0, 0.0],
                    depth_range: [1.0; 2],
                    bounds: [[0; 2]; 2],
                    is_small: true,
                    is_whole: true,
                    object: 0,
                    triangle: behind,
                };
                let gradients = gradients(&t);
                let [a, p, q] = corners.map(|c| c.map(f64::from));
                let (b, c) = if behind == 0 { (q, p) } else { (p, q) };
                let area = (p[0] - a[0]) * (q[1] - a[1]) - (p[1] - a[1]) * (q[0] - a[0]);
                for (k, g) in gradients.into_iter().enumerate() {
                    for (i, corner) in [b, c].into_iter().enumerate() {
                        let d = [0, 1].map(|k| (corner[k] - a[k]) / f64::from(SUBSAMPLES));
                        let weight = f64::from(g[0]) * d[0] + f64::from(g[1]) * d[1];
                        let largest =
                            (f64::from(g[0]) * d[0]).abs() + (f64::from(g[1]) * d[1]).abs();
                        let wanted = if i == k { 1.0 } else { 0.0 };
                        let error = (weight - wanted).abs();
                        assert!(
                            error <= 4.0 * 2f64.powi(-24) * largest.max(1.0),
                            "{corners:?} of area {area}: {error:e}"
                        );
                    }
                }
            }
        }
    }
}
