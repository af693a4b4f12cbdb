use foveasim_assets::{Scene, Textured};

use super::lanes::{F, Simd, V3, max, mix, splat};
use super::shade::{Hit, Light};
use super::sky::sky;
use super::surface::{lobe, schlick};
use super::texture::sample;

/// Reflectance head on of what is not metal (glTF 2.0, B.2.1: an index of refraction of 1.5).
const DIELECTRIC_F0: f32 = 0.04;
/// Least microfacet α: below it, one light's highlight is narrower than any pixel.
const LEAST_ALPHA: f32 = 0.002;

/// The metallic-roughness model (glTF 2.0, appendix B) under one sun, ambient light and a mirrored sky.
#[inline(always)]
pub(super) fn textured<S: Simd>(
    simd: S,
    m: &Textured,
    scene: &Scene,
    light: &Light,
    hit: &Hit<S>,
) -> V3<S> {
    let (one, zero) = (splat(simd, 1.0), splat(simd, 0.0));
    let times_texture = |factor: [f32; 3], texture: Option<usize>| {
        let factor = V3::splat(simd, factor);
        match texture {
            Some(i) => factor.mul(sample(simd, &scene.textures()[i], hit.uv, hit.uv_footprint)),
            None => factor,
        }
    };
    let base = times_texture(m.base_colour, m.base_texture);
    // Green is roughness, blue is metal (glTF 2.0, 3.9.2).
    let finish = times_texture([1.0, m.roughness, m.metallic], m.finish_texture);
    let (rough, metal) = (finish.y, finish.z);
    let alpha = max(rough * rough, splat(simd, LEAST_ALPHA));
    let f0 = V3::splat(simd, [DIELECTRIC_F0; 3]).mix(base, metal);

    let (n, v) = (hit.normal, hit.view);
    let l = V3::splat(simd, light.sun_direction);
    let h = l.add(v).normalize();
    let n_l = max(n.dot(l), zero);
    let n_h = max(n.dot(h), zero);
    let l_h = max(l.dot(h), zero);
    let n_v = max(n.dot(v), zero);

    let sun = V3::splat(simd, light.sun_radiance).scale(n_l);
    let diffuse = base
        .mul(sun.add(light.ambient(simd, n)))
        .scale((one - metal) * (1.0 - DIELECTRIC_F0));
    let facing = schlick(simd, l_h);
    let gloss = sun
        .mul(fresnel(f0, V3::splat(simd, [1.0; 3]), facing))
        .scale(lobe(simd, alpha * alpha, n_h, l_h));

    // A rough surface's facets face all ways: less of it is seen edge-on, where all mirrors
    // (max(1 − r, f0) in place of 1 in Schlick's term: Lagarde 2011, "Adopting a physically based
    // shading model").
    let smooth = one - rough;
    let edge = V3 {
        x: max(smooth, f0.x),
        y: max(smooth, f0.y),
        z: max(smooth, f0.z),
    };
    let mirrored = n.scale(n_v * 2.0).add(v.scale(-one)).normalize();
    let seen = sky(simd, scene.sky(), light, mirrored, hit.angle + alpha);
    // Fully rough, the lobe spans half the sky and sees its mean.
    let seen = seen.mix(light.ambient(simd, n), rough * rough);
    let mirror = seen.mul(fresnel(f0, edge, schlick(simd, n_v)));

    let glow = times_texture(m.emissive, m.emissive_texture);
    diffuse.add(gloss).add(mirror).add(glow)
}

/// From `f0` head on to `edge` at a grazing angle.
#[inline(always)]
fn fresnel<S: Simd>(f0: V3<S>, edge: V3<S>, facing: F<S>) -> V3<S> {
    V3 {
        x: mix(f0.x, edge.x, facing),
        y: mix(f0.y, edge.y, facing),
        z: mix(f0.z, edge.z, facing),
    }
}
