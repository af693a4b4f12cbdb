use foveasim_assets::{Terrain, TerrainDetail};

use super::noise::{Fractal, fractal_2d};
use super::shade::{Hit, Light};
use super::wide::{F, Simd, V3, max, piece, saturate, smoothstep, splat};

/// Grass, rock and snow by slope and height, each with its own grain, under sun and sky; cheaply, in
/// broad patches without grain and relief.
#[inline(always)]
pub(super) fn terrain<S: Simd>(simd: S, t: &Terrain, light: &Light, hit: &Hit<S>) -> V3<S> {
    let zero = splat(simd, 0.0);
    let broad = noise(simd, t, hit, 23.0, 0x1111);
    let [grain, bump_x, bump_z] = match t.detail {
        TerrainDetail::Procedural => [
            noise(simd, t, hit, 3.1, 0x2222),
            noise(simd, t, hit, 1.7, 0x3333),
            noise(simd, t, hit, 1.7, 0x4444),
        ],
        TerrainDetail::Cheap => [zero; 3],
    };
    let normal = match t.detail {
        TerrainDetail::Procedural => {
            let bumps = V3 {
                x: bump_x * 0.35,
                y: zero,
                z: bump_z * 0.35,
            };
            hit.normal.add(bumps).normalize()
        }
        TerrainDetail::Cheap => hit.normal,
    };
    let albedo = piece(
        simd,
        #[inline(always)]
        || albedo(simd, t, hit, [broad, grain, bump_x]),
    );
    let sun = V3::splat(simd, light.sun_direction).dot(normal);
    let sun = light.sun(simd, hit).scale(max(sun, zero));
    albedo.mul(sun.add(light.ambient(simd, normal)))
}

/// What grows or lies there, by slope, height and noise: in broad patches, in grains, of the relief.
#[inline(always)]
fn albedo<S: Simd>(simd: S, t: &Terrain, hit: &Hit<S>, [broad, grain, bump]: [F<S>; 3]) -> V3<S> {
    let one = splat(simd, 1.0);
    let steep = one - hit.normal.y;
    let rockiness = smoothstep(splat(simd, 0.06), splat(simd, 0.20), steep + grain * 0.06);
    let height = hit.world.y + broad * 3.0 + grain * 1.5;
    let line = splat(simd, t.snow_line_m);
    let snowiness = smoothstep(line - 2.0, line + 2.0, height) * (one - rockiness * 0.75);

    let green = V3::splat(simd, [0.085, 0.150, 0.035]);
    let dry = V3::splat(simd, [0.240, 0.205, 0.080]);
    let grass = green.mix(dry, saturate(broad * 0.6 + grain * 0.5 + 0.35));
    let dark = V3::splat(simd, [0.105, 0.090, 0.078]);
    let pale = V3::splat(simd, [0.330, 0.300, 0.270]);
    let rock = dark.mix(pale, saturate(grain * 0.7 + broad * 0.3 + 0.4));
    let snow = V3::splat(simd, [0.80, 0.84, 0.90]);
    let albedo = grass.mix(rock, rockiness).mix(snow, snowiness);
    // Fine relief darkens hollows.
    albedo.scale(saturate(bump * 0.35 + 0.85))
}

/// Fractal noise over the ground, from a period of `period_m` downwards.
#[inline(always)]
fn noise<S: Simd>(simd: S, t: &Terrain, hit: &Hit<S>, period_m: f32, seed: u32) -> F<S> {
    let k = 1.0 / period_m;
    let fractal = Fractal {
        octaves: match t.detail {
            TerrainDetail::Procedural => t.octaves,
            TerrainDetail::Cheap => t.octaves.min(1),
        },
        seed: t.seed ^ seed,
    };
    fractal_2d(
        simd,
        hit.world.x * k,
        hit.world.z * k,
        hit.footprint * k,
        fractal,
    )
}
