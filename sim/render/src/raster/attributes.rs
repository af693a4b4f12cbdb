use foveasim_assets::Scene;
use glam::{DVec2, DVec3};

use super::{Geometry, SetUpTriangle};
use crate::kernels::Attributes;
use crate::project::{Projection, SUBSAMPLES};

/// What shading needs of a triangle, in double precision up to the last step: triangles far away
/// are small differences of large numbers.
pub(crate) fn attributes(
    scene: &Scene,
    geometry: &Geometry,
    t: &SetUpTriangle,
    projection: &Projection,
) -> Attributes {
    let drawn = t.drawn as usize;
    let instance = &scene.instances()[geometry.drawn[drawn].instance as usize];
    let mesh = &scene.meshes()[instance.mesh];
    let corners = mesh.triangles()[t.triangle as usize];
    let eye = corners.map(|i| DVec3::from_array(geometry.vertex(drawn, i).eye.map(f64::from)));

    let mut a = [0.0; Attributes::COUNT];
    let lattice = t.corners[0].map(|c| f64::from(c) / f64::from(SUBSAMPLES));
    a[Attributes::CORNER] = lattice[0];
    a[Attributes::CORNER + 1] = lattice[1];

    // A point seen in direction d = (tx, ty, 1) is w·d = Σ βᵢpᵢ, so β/w = M⁻¹d with M = (p₀ p₁ p₂):
    // linear over the image, while β is not.
    let tangent = projection.tangent(DVec2::from_array(lattice));
    let step = projection.tangent_step();
    let det = eye[0].dot(eye[1].cross(eye[2]));
    let rows = [eye[2].cross(eye[0]) / det, eye[0].cross(eye[1]) / det];
    for (k, row) in rows.into_iter().enumerate() {
        let weights = [
            row.dot(DVec3::new(tangent.x, tangent.y, 1.0)),
            row.x * step.x,
            row.y * step.y,
        ];
        // Edge-on, a triangle has no weights; its first corner will do.
        if weights.iter().all(|w| w.is_finite()) {
            a[Attributes::WEIGHTS + 3 * k..][..3].copy_from_slice(&weights);
        }
    }

    let placed = instance.world_from_object;
    let normals = corners.map(|i| placed.pose.direction(triple(mesh.normals(), i)));
    let objects = corners.map(|i| mesh.position(i));
    let uvs = corners.map(|i| {
        let [u, v] = mesh.uvs();
        DVec3::new(u[i as usize].into(), v[i as usize].into(), 0.0)
    });
    for (first, stride, [p, q, r]) in [
        (Attributes::NORMAL, 3, normals),
        (Attributes::OBJECT, 3, objects),
        (Attributes::UV, 2, uvs),
    ] {
        for (k, value) in [p, q - p, r - p].into_iter().enumerate() {
            a[first + stride * k..][..stride].copy_from_slice(&value.to_array()[..stride]);
        }
    }

    let steepest = [(1, 0), (2, 0), (2, 1)]
        .map(|(i, j)| (uvs[i] - uvs[j]).length() / objects[i].distance(objects[j]).max(1e-12))
        .into_iter()
        .fold(0.0, f64::max);
    a[Attributes::PER_METRE] = 1.0 / placed.scale;
    a[Attributes::PER_METRE + 1] = steepest / placed.scale;
    Attributes(a.map(|v: f64| v as f32))
}

fn triple(columns: &[Vec<f32>; 3], index: u32) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|k| f64::from(columns[k][index as usize])))
}
