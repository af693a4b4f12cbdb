use foveasim_assets::{Scene, Textured};

use super::shade::{Hit, Light};
use super::sky::sky;
use super::surface::{lobe, schlick};
use super::texture::sample;
use super::wide::{F, Simd, V3, max, mix, piece, splat};

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

    let sun = light.sun(simd, hit).scale(n_l);
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
    piece(
        facing.simd,
        #[inline(always)]
        || V3 {
            x: mix(f0.x, edge.x, facing),
            y: mix(f0.y, edge.y, facing),
            z: mix(f0.z, edge.z, facing),
        },
    )
}

#[cfg(test)]
mod tests {
    use fearless_simd::prelude::*;
    use foveasim_assets::{Encoding, Material, SceneParts, Sky, Sun, Texture, Wrap, study_sky};

    use super::super::wide::{Simd, WIDTH};
    use super::super::{Kernel, dispatch};
    use super::*;
    use crate::Simd as Choice;

    const DARK: Light<'static> = Light {
        sun_direction: [0.0, 1.0, 0.0],
        sun_radiance: [0.0; 3],
        ambient_up: [0.0; 3],
        ambient_down: [0.0; 3],
        fog: [0.0; 3],
        per_visibility_m: 0.0,
        shadows: &[],
        irradiance: None,
    };

    struct Probe<'a> {
        scene: &'a Scene,
        light: &'a Light<'a>,
    }

    impl Kernel for Probe<'_> {
        type Output = [[f32; WIDTH]; 3];

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Self::Output {
            let Material::Textured(m) = &self.scene.materials()[0] else {
                panic!("not textured")
            };
            // From facing the eye to edge-on, over the texture, near and far.
            let slope = F::from_slice(
                simd,
                &[
                    0.0, 0.1, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99, 0.999,
                    0.9999, 1.0,
                ],
            );
            let n = V3 {
                x: slope,
                y: (splat(simd, 1.0) - slope * slope).sqrt(),
                z: splat(simd, 0.0),
            };
            let hit = Hit {
                world: n,
                object: n,
                normal: n,
                view: V3::splat(simd, [0.0, 1.0, 0.0]),
                uv: [slope * 7.0, slope * -3.0],
                footprint: slope,
                object_footprint: slope,
                uv_footprint: slope * slope,
                angle: splat(simd, 1e-3),
            };
            let c = textured(simd, m, self.scene, self.light, &hit);
            [c.x.to_array(), c.y.to_array(), c.z.to_array()]
        }
    }

    /// Both ways, which must agree to the bit.
    fn probe(material: Textured, sky: Sky, light: &Light) -> [[f32; WIDTH]; 3] {
        let texels = (0..16 * 16).map(|i| [(i % 256) as u8, (i * 7 % 256) as u8, 90, 255]);
        let texture = |encoding| {
            Texture::new(
                [16; 2],
                texels.clone().collect(),
                encoding,
                [Wrap::Mirror; 2],
            )
            .unwrap()
        };
        let scene = Scene::build(SceneParts {
            lods: Vec::new(),
            meshes: vec![],
            instances: vec![],
            materials: vec![Material::Textured(material)],
            textures: vec![texture(Encoding::Srgb), texture(Encoding::Linear)],
            motions: vec![],
            sky,
            sun: Sun {
                direction: glam::DVec3::Y,
                radiance: [1.0; 3],
            },
        });
        let scene = &scene.unwrap();
        let a = dispatch(Choice::Auto, Probe { scene, light });
        let b = dispatch(Choice::Scalar, Probe { scene, light });
        let bits = |c: [[f32; WIDTH]; 3]| c.map(|row| row.map(f32::to_bits));
        assert_eq!(bits(a), bits(b));
        a
    }

    #[test]
    fn all_textures_at_once_are_the_same_in_any_width() {
        let material = Textured {
            base_texture: Some(0),
            finish_texture: Some(1),
            metallic: 1.0,
            emissive: [0.5; 3],
            emissive_texture: Some(0),
            ..Textured::default()
        };
        let light = Light {
            sun_radiance: [1.0, 0.9, 0.8],
            ambient_up: [0.3, 0.4, 0.6],
            ..DARK
        };
        let got = probe(material, Sky::Analytic(study_sky(1)), &light);
        assert!(
            got.iter().flatten().all(|v| v.is_finite() && *v >= 0.0),
            "{got:?}"
        );
    }

    #[test]
    fn in_the_dark_only_its_own_light_is_seen() {
        let material = Textured {
            emissive: [2.0, 0.25, 0.0],
            ..Textured::default()
        };
        let got = probe(material, Sky::Uniform([0.0; 3]), &DARK);
        assert_eq!(got, [[2.0; WIDTH], [0.25; WIDTH], [0.0; WIDTH]]);
    }

    #[test]
    fn a_mirror_in_a_room_of_one_colour_has_that_colour() {
        let mirror = Textured {
            base_colour: [1.0; 3],
            metallic: 1.0,
            roughness: 0.0,
            ..Textured::default()
        };
        let got = probe(mirror, Sky::Uniform([0.25, 0.5, 0.75]), &DARK);
        assert_eq!(got, [[0.25; WIDTH], [0.5; WIDTH], [0.75; WIDTH]]);
    }
}
