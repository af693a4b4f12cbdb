use foveasim_assets::{Material, Pattern, Scene};
use glam::{DVec2, DVec3};

use super::{SetUpTriangle, ViewGeometry};
use crate::kernels::Attributes;
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

/// What shading needs of a triangle, in double precision up to the last step: triangles far away
/// are small differences of large numbers.
pub(crate) fn attributes(
    scene: &Scene,
    geometry: &ViewGeometry,
    t: &SetUpTriangle,
    projection: &Projection,
    needs: Needs,
) -> Attributes {
    let object = &geometry.objects[t.object as usize];
    let mesh = &scene.meshes()[object.mesh as usize];
    let corners = mesh.triangles()[t.index()];
    let vertices = geometry.of(object, scene);
    let eye = corners.map(|i| DVec3::from_array(vertices[i as usize].eye.map(f64::from)));

    let mut a = [0.0f32; Attributes::COUNT];
    let lattice = t.corners[0].map(|c| f64::from(c) / f64::from(SUBSAMPLES));
    a[Attributes::CORNER] = lattice[0] as f32;
    a[Attributes::CORNER + 1] = lattice[1] as f32;
    a[Attributes::DEPTH..Attributes::DEPTH + 3].copy_from_slice(&t.depth);
    a[Attributes::DEPTH + 3..Attributes::DEPTH + 5].copy_from_slice(&t.depth_range);

    // A point seen in direction d = (tx, ty, 1) is w·d = Σ βᵢpᵢ, so β/w = M⁻¹d with M = (p₀ p₁ p₂):
    // linear over the image, while β is not.
    let tangent = projection.tangent(DVec2::from_array(lattice));
    let step = projection.tangent_step();
    let rows = [eye[2].cross(eye[0]), eye[0].cross(eye[1])];
    let inverse = 1.0 / eye[1].dot(rows[0]);
    for (k, row) in rows.into_iter().enumerate() {
        let row = row * inverse;
        let weights = [
            row.dot(DVec3::new(tangent.x, tangent.y, 1.0)),
            row.x * step.x,
            row.y * step.y,
        ];
        // Edge-on, a triangle has no weights; its first corner will do.
        if weights.iter().all(|w| w.is_finite()) {
            a[Attributes::WEIGHTS + 3 * k..][..3].copy_from_slice(&weights.map(|w| w as f32));
        }
    }

    // Seen from behind, the other side's normal counts.
    let sign = if t.is_behind() { -1.0 } else { 1.0 };
    let normals = corners.map(|i| vertices[i as usize].normal.map(|n| n * sign));
    spread(&mut a, Attributes::NORMAL, normals);
    if needs.object || needs.uv {
        let scale = scene.instances()[object.instance as usize]
            .world_from_object
            .scale;
        a[Attributes::PER_METRE] = (1.0 / scale) as f32;
        let [xs, ys, zs] = mesh.positions();
        let objects = corners.map(|i| [xs[i as usize], ys[i as usize], zs[i as usize]]);
        spread(&mut a, Attributes::OBJECT, objects);
        if needs.uv {
            let [us, vs] = mesh.uvs();
            let uvs = corners.map(|i| [us[i as usize], vs[i as usize]]);
            spread(&mut a, Attributes::UV, uvs);
            let steepest = [(1, 0), (2, 0), (2, 1)]
                .map(|(i, j)| length2(uvs[i], uvs[j]) / length2(objects[i], objects[j]).max(1e-24))
                .into_iter()
                .fold(0.0, f32::max);
            a[Attributes::PER_METRE + 1] = steepest.sqrt() * (1.0 / scale) as f32;
        }
    }
    Attributes(a)
}

/// Writes an attribute as its value at the first corner and its changes towards the other two.
#[inline(always)]
fn spread<const N: usize>(
    a: &mut [f32; Attributes::COUNT],
    first: usize,
    [p, q, r]: [[f32; N]; 3],
) {
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
