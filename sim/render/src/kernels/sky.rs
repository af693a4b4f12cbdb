use fearless_simd::prelude::*;
use foveasim_assets::{AnalyticSky, Sky};

use super::environment::environment;
use super::noise::{Fractal, fractal_2d};
use super::shade::Light;
use super::wide::{F, Simd, V3, apart, max, mix, piece, saturate, smoothstep, splat};

/// Colour of the sky in unit direction `d`; `angle` is the angle [rad] it is averaged over.
#[inline(always)]
pub(super) fn sky<S: Simd>(simd: S, sky: &Sky, light: &Light, d: V3<S>, angle: F<S>) -> V3<S> {
    match sky {
        Sky::Uniform(colour) => V3::splat(simd, *colour),
        // A function of its own: called for the background and for each mirror.
        Sky::Analytic(a) => apart(
            simd,
            #[inline(always)]
            || analytic(simd, a, light, d, angle),
        ),
        Sky::Map(map) => apart(
            simd,
            #[inline(always)]
            || environment(simd, map, light, d, angle),
        ),
        _ => V3::splat(simd, light.ambient_up),
    }
}

#[inline(always)]
fn analytic<S: Simd>(simd: S, a: &AnalyticSky, light: &Light, d: V3<S>, angle: F<S>) -> V3<S> {
    let one = splat(simd, 1.0);
    let up = max(d.y, splat(simd, 0.0));
    let thin = (one - up) * (one - up);
    let horizon = V3::splat(simd, a.horizon);
    let mut colour = V3::splat(simd, a.zenith).mix(horizon, thin * thin);

    // The sun, and the glow about it.
    let toward_sun = V3::splat(simd, light.sun_direction).dot(d);
    let c = max(toward_sun, splat(simd, 0.0));
    let c8 = pow8(c);
    let c64 = pow8(c8);
    let glow = V3::splat(simd, light.sun_radiance);
    // 0.99996 is cos 0.5°: a disc twice the sun's, blurred by the angle averaged over.
    let blur = angle * angle * 0.5 + 2e-5;
    let disc = smoothstep(
        splat(simd, 0.99994) - blur,
        splat(simd, 0.99994) + blur,
        toward_sun,
    );
    colour = colour.add(glow.scale(c8 * 0.06 + c64 * 0.18 + disc * 2.0));

    colour = piece(
        simd,
        #[inline(always)]
        || clouds(simd, a, colour, d, angle),
    );
    colour = piece(
        simd,
        #[inline(always)]
        || mountains(simd, a, colour, d, angle),
    );
    over_ground(simd, light, colour, d, angle)
}

#[inline(always)]
fn clouds<S: Simd>(simd: S, a: &AnalyticSky, colour: V3<S>, d: V3<S>, angle: F<S>) -> V3<S> {
    let one = splat(simd, 1.0);
    let up = max(d.y, splat(simd, 0.0));
    // Clouds on a plane overhead, seen ever more slantwise towards the horizon.
    let slant = one / (up + 0.08);
    let (u, v) = (d.x * slant * 1.1, d.z * slant * 1.1);
    let foot = angle * slant * slant * 0.25 + angle * slant;
    let density = fractal_2d(
        simd,
        u,
        v,
        foot,
        Fractal {
            octaves: 6,
            seed: a.seed,
        },
    );
    let threshold = splat(simd, 0.9 - 1.5 * a.cloud_cover);
    let cloud = smoothstep(threshold, threshold + 0.75, density) * saturate(up * 7.0);
    let lit = V3::splat(simd, [0.92, 0.93, 0.95]).scale(one - saturate(density) * 0.25);
    colour.mix(lit, cloud * 0.85)
}

#[inline(always)]
fn mountains<S: Simd>(simd: S, a: &AnalyticSky, colour: V3<S>, d: V3<S>, angle: F<S>) -> V3<S> {
    let one = splat(simd, 1.0);
    // Mountains: a ridge line over the circle of horizontal directions.
    let flat = max(d.x * d.x + d.z * d.z, splat(simd, 1e-12)).sqrt();
    let (hx, hz) = (d.x / flat, d.z / flat);
    let ridge = Fractal {
        octaves: 7,
        seed: a.seed ^ 0x0dd5,
    };
    let height = fractal_2d(simd, hx * 3.0, hz * 3.0, angle * 3.0, ridge) * 0.055 + 0.105;
    let slope = d.y / flat;
    let behind = smoothstep(height - angle - 5e-4, height + angle + 5e-4, slope);
    let rock = Fractal {
        octaves: 5,
        seed: a.seed ^ 0x70c4,
    };
    let grain = fractal_2d(simd, hx * 23.0 + slope * 9.0, hz * 23.0, angle * 25.0, rock);
    let snow = smoothstep(splat(simd, 0.09), splat(simd, 0.13), slope + grain * 0.02);
    let face = V3::splat(simd, a.mountains).scale(grain * 0.35 + 1.0);
    let face = face.mix(V3::splat(simd, [0.70, 0.74, 0.80]), snow * 0.75);
    // Distance pales them towards their foot.
    let haze = saturate(one - slope * 6.0) * 0.75;
    face.mix(V3::splat(simd, a.horizon), haze)
        .mix(colour, behind)
}

/// What reflections see below the horizon.
#[inline(always)]
pub(super) fn over_ground<S: Simd>(
    simd: S,
    light: &Light,
    colour: V3<S>,
    d: V3<S>,
    angle: F<S>,
) -> V3<S> {
    piece(
        simd,
        #[inline(always)]
        || {
            let below = smoothstep(splat(simd, 0.0), splat(simd, 0.06) + angle, -d.y);
            colour.mix(V3::splat(simd, light.ambient_down), below)
        },
    )
}

#[inline(always)]
fn pow8<S: Simd>(x: F<S>) -> F<S> {
    piece(
        x.simd,
        #[inline(always)]
        || {
            let x2 = x * x;
            let x4 = x2 * x2;
            x4 * x4
        },
    )
}

/// Fades a surface `distance` \[m\] away into the horizon.
#[inline(always)]
pub(super) fn aerial<S: Simd>(simd: S, light: &Light, colour: V3<S>, distance: F<S>) -> V3<S> {
    piece(
        simd,
        #[inline(always)]
        || {
            let far = distance * light.per_visibility_m;
            let clear = splat(simd, 1.0) / (far * far + 1.0);
            let fog = V3::splat(simd, light.fog);
            V3 {
                x: mix(fog.x, colour.x, clear),
                y: mix(fog.y, colour.y, clear),
                z: mix(fog.z, colour.z, clear),
            }
        },
    )
}
