use fearless_simd::prelude::*;
use foveasim_assets::{Pattern, Sky, Surface};

use super::noise::{Fractal, fractal_3d, visible};
use super::shade::{Hit, Light};
use super::sky::sky;
use super::wide::{F, Simd, V3, max, mix, piece, saturate, smoothstep, splat};

/// A diffuse base under one GGX lobe (Walter et al. 2007) with Schlick's Fresnel term, and the sky
/// mirrored with the lobe's width.
#[inline(always)]
pub(super) fn surface<S: Simd>(
    simd: S,
    m: &Surface,
    environment: &Sky,
    light: &Light,
    hit: &Hit<S>,
) -> V3<S> {
    let (one, zero) = (splat(simd, 1.0), splat(simd, 0.0));
    let share = piece(
        simd,
        #[inline(always)]
        || pattern(simd, m, hit),
    );
    let albedo = V3::splat(simd, m.albedo[0]).mix(V3::splat(simd, m.albedo[1]), share);

    let (n, v) = (hit.normal, hit.view);
    let l = V3::splat(simd, light.sun_direction);
    let h = l.add(v).normalize();
    let n_l = max(n.dot(l), zero);
    let n_h = max(n.dot(h), zero);
    let l_h = max(l.dot(h), zero);
    let n_v = max(n.dot(v), zero);

    let sun = light.sun(simd, hit).scale(n_l);
    let diffuse = albedo
        .mul(sun.add(light.ambient(simd, n)))
        .scale(splat(simd, 1.0 - m.f0));
    let lobe = lobe(simd, splat(simd, m.roughness * m.roughness), n_h, l_h);
    let gloss = sun.scale(lobe * fresnel(simd, m.f0, l_h));
    let mut colour = diffuse.add(gloss);
    if m.environment > 0.0 {
        let mirrored = n.scale(n_v * 2.0).add(v.scale(-one)).normalize();
        let angle = hit.angle + m.roughness;
        let seen = sky(simd, environment, light, mirrored, angle);
        colour = colour.add(seen.scale(fresnel(simd, m.f0, n_v) * m.environment));
    }
    colour
}

/// Mean share of marble's veins over all places (Monte Carlo over five octaves, 10⁵ points, ±0.001).
const MARBLE_MEAN: f32 = 0.223;

/// π·D·V with D = α²/(π((n·h)²(α²−1)+1)²) (GGX) and V ≈ 1/(4·max((l·h)², 0.1)) (after Kelemen and
/// Szirmay-Kalos 2001); `a2` is α².
#[inline(always)]
pub(super) fn lobe<S: Simd>(simd: S, a2: F<S>, n_h: F<S>, l_h: F<S>) -> F<S> {
    piece(
        simd,
        #[inline(always)]
        || {
            let k = n_h * n_h * (a2 - 1.0) + 1.0;
            a2 / (k * k) / (max(l_h * l_h, splat(simd, 0.1)) * 4.0)
        },
    )
}

/// (1 − c)⁵: how far reflectance has gone from f0 to 1 at an angle of cosine c (Schlick 1994).
#[inline(always)]
pub(super) fn schlick<S: Simd>(simd: S, c: F<S>) -> F<S> {
    piece(
        simd,
        #[inline(always)]
        || {
            let x = splat(simd, 1.0) - c;
            let x2 = x * x;
            x2 * x2 * x
        },
    )
}

/// f0 + (1 − f0)(1 − c)⁵.
#[inline(always)]
fn fresnel<S: Simd>(simd: S, f0: f32, c: F<S>) -> F<S> {
    piece(
        simd,
        #[inline(always)]
        || schlick(simd, c) * (1.0 - f0) + f0,
    )
}

/// Share of the second colour, averaged over the footprint.
#[inline(always)]
fn pattern<S: Simd>(simd: S, m: &Surface, hit: &Hit<S>) -> F<S> {
    let k = m.frequency;
    let uv_foot = hit.uv_footprint * k;
    let foot = hit.object_footprint * k;
    let fractal = Fractal {
        octaves: 5,
        seed: m.seed,
    };
    let p = hit.object.scale(splat(simd, k));
    match m.pattern {
        Pattern::Checker => {
            let u = square_wave(simd, hit.uv[0] * (2.0 * k), uv_foot * 2.0);
            let v = square_wave(simd, hit.uv[1] * (2.0 * k), uv_foot * 2.0);
            splat(simd, 0.5) - u * v * 0.5
        }
        Pattern::Stripes => {
            let wave = square_wave(simd, hit.uv[0] * (2.0 * k), uv_foot * 2.0 + 0.3);
            wave * 0.5 + 0.5
        }
        Pattern::Marble => {
            let folded = fractal_3d(simd, p, foot, fractal).abs();
            let veins = splat(simd, 1.0) - smoothstep(splat(simd, 0.0), splat(simd, 0.28), folded);
            // Folding is not linear: noise that is filtered away would leave veins everywhere, so
            // they give way to their mean as the coarsest octave fades.
            mix(splat(simd, MARBLE_MEAN), veins, visible(simd, 1.0, foot))
        }
        Pattern::Patches => {
            let n = fractal_3d(simd, p, foot, fractal);
            smoothstep(splat(simd, -0.12) - foot, splat(simd, 0.12) + foot, n)
        }
        _ => splat(simd, 0.0),
    }
}

/// ±1 with period 2, averaged over `width` (the difference of its integral at both ends).
#[inline(always)]
fn square_wave<S: Simd>(simd: S, x: F<S>, width: F<S>) -> F<S> {
    piece(
        simd,
        #[inline(always)]
        || {
            let width = max(width, splat(simd, 1e-3));
            let half = width * 0.5;
            let mean = (integral(x - half) - integral(x + half)) * 2.0 / width;
            saturate(mean * 0.5 + 0.5) * 2.0 - 1.0
        },
    )
}

/// Half the integral of a square wave, up to a constant.
#[inline(always)]
fn integral<S: Simd>(x: F<S>) -> F<S> {
    piece(
        x.simd,
        #[inline(always)]
        || {
            let half = x * 0.5;
            let phase = half - half.floor();
            (phase - 0.5).abs()
        },
    )
}
