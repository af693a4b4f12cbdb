use fearless_simd::prelude::*;
use foveasim_assets::EnvironmentMap;

use super::shade::Light;
use super::sky::over_ground;
use super::wide::{F, I, Simd, U, V3, WIDTH, max, min, piece, splat, two};

/// The environment in unit direction `d`, averaged over `angle` [rad]: bilinear in each of the two
/// halved copies whose texels are next in size, and linear between them.
#[inline(always)]
pub(super) fn environment<S: Simd>(
    simd: S,
    map: &EnvironmentMap,
    light: &Light,
    d: V3<S>,
    angle: F<S>,
) -> V3<S> {
    // Where the direction is in the map, 0 to 1. Straight down is nowhere in it: anywhere will do.
    let zero = splat(simd, 0.0);
    let around = d.x.abs() + d.z.abs();
    let up = max(d.y, zero) * EnvironmentMap::RISE as f32;
    let half = splat(simd, 0.5) / max(around + up, splat(simd, 1e-20));
    let place = [(d.x + d.z) * half + 0.5, (d.x - d.z) * half + 0.5];

    // 2^level·(1 + t) texels are averaged over. Bits of the exponent and of the mantissa say which: t is
    // log₂'s chord, off by 0.09 of a level at most.
    let coarsest = map.levels() - 1;
    let texels = angle * (1.0 / map.texel_angle()) as f32;
    let texels = min(
        max(texels, splat(simd, 1.0)),
        splat(simd, (1u32 << coarsest) as f32),
    );
    let bits: U<S> = texels.bitcast();
    let level = (bits >> 23) - 127;
    let t: F<S> = ((bits & 0x007f_ffff) | 0x3f80_0000).bitcast();
    let t = t - 1.0;

    let mut colour = bilinear(simd, map, level, place);
    // Most samples are finer than the map: then there is but one copy to read.
    if t.simd_gt(0.0).any_true() {
        let level = level.to_array().map(|l| (l + 1).min(coarsest as u32));
        let coarser = bilinear(simd, map, U::from_slice(simd, &level), place);
        colour = colour.mix(coarser, t);
    }
    over_ground(simd, light, colour, d, angle)
}

/// Between the four texels about a place, in one copy for each lane.
#[inline(always)]
fn bilinear<S: Simd>(simd: S, map: &EnvironmentMap, level: U<S>, place: [F<S>; 2]) -> V3<S> {
    piece(
        simd,
        #[inline(always)]
        || {
            let zero = splat(simd, 0.0);
            // 2^−level is exact, and so is the size of each copy.
            let shrink: F<S> = ((U::splat(simd, 127) - level) << 23).bitcast();
            let last = shrink * map.size() as f32 - 1.0;
            let size = last + 1.0;
            let [(x0, x1, fx), (y0, y1, fy)] = two(
                #[inline(always)]
                |k| {
                    let at = min(max(place[k] * size - 0.5, zero), last);
                    let low = at.floor();
                    let high = min(low + 1.0, last);
                    let (first, second) = (low.to_int::<I<S>>(), high.to_int::<I<S>>());
                    (first.to_array(), second.to_array(), at - low)
                },
            );
            let level = level.to_array();
            let upper = texel(simd, map, level, x0, y0).mix(texel(simd, map, level, x1, y0), fx);
            let lower = texel(simd, map, level, x0, y1).mix(texel(simd, map, level, x1, y1), fx);
            upper.mix(lower, fy)
        },
    )
}

/// One texel for each lane.
#[inline(always)]
fn texel<S: Simd>(
    simd: S,
    map: &EnvironmentMap,
    level: [u32; WIDTH],
    x: [i32; WIDTH],
    y: [i32; WIDTH],
) -> V3<S> {
    piece(
        simd,
        #[inline(always)]
        || {
            let mut texels = [0; WIDTH];
            for lane in 0..WIDTH {
                let level = level[lane] as usize;
                let row = y[lane] as usize * (map.size() as usize >> level);
                texels[lane] = map.texels()[map.starts()[level] + row + x[lane] as usize];
            }
            unpack(U::from_slice(simd, &texels))
        },
    )
}

/// Shared-exponent texels, as [`EnvironmentMap::unpack`].
#[inline(always)]
fn unpack<S: Simd>(texels: U<S>) -> V3<S> {
    piece(
        texels.simd,
        #[inline(always)]
        || {
            let scale: F<S> = (((texels >> 27) + (127 - 24)) << 23).bitcast();
            V3 {
                x: component(texels, scale),
                y: component(texels >> 9, scale),
                z: component(texels >> 18, scale),
            }
        },
    )
}

#[inline(always)]
fn component<S: Simd>(bits: U<S>, scale: F<S>) -> F<S> {
    piece(
        scale.simd,
        #[inline(always)]
        || {
            let whole: I<S> = (bits & 0x1ff).bitcast();
            whole.to_float::<F<S>>() * scale
        },
    )
}
