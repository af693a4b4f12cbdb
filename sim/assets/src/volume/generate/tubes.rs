use foveasim_models::math::{exp, sin, sqrt};
use foveasim_models::{Role, Stream};
use glam::DVec3;
use rayon::prelude::*;

/// Generations of tubes.
const GENERATIONS: u32 = 4;
/// Pieces of which a bent tube consists.
const PIECES: usize = 6;

/// A straight piece of a vortex.
struct Piece {
    from: DVec3,
    to: DVec3,
    radius: f64,
    strength: f64,
}

/// Vorticity of a cascade of tubes, `size` voxels along each side: the first generation has six, each next
/// one eight times as many, half as long and thick.
pub(super) fn vortices(size: u32, seed: u64) -> Vec<f32> {
    let pieces = cascade(seed);
    let n = size as usize;
    let place = |k: usize| 2.0 * k as f64 / (n - 1) as f64 - 1.0;
    // The first voxel at or after a place.
    let index = |x: f64| (((x + 1.0) / 2.0 * (n - 1) as f64).ceil().max(0.0) as usize).min(n);
    let mut values = vec![0.0f32; n * n * n];
    values
        .par_chunks_mut(n * n)
        .enumerate()
        .for_each(|(z, slice)| {
            let pz = place(z);
            let mut sums = vec![0.0f64; n * n];
            for piece in &pieces {
                // Beyond two and a half radii there is less than a 500th of it.
                let reach = DVec3::splat(2.5 * piece.radius);
                let low = piece.from.min(piece.to) - reach;
                let high = piece.from.max(piece.to) + reach;
                if pz < low.z || pz > high.z {
                    continue;
                }
                for y in index(low.y)..index(high.y) {
                    for x in index(low.x)..index(high.x) {
                        let at = DVec3::new(place(x), place(y), pz);
                        sums[y * n + x] += piece.at(at);
                    }
                }
            }
            for (value, sum) in slice.iter_mut().zip(sums) {
                // Where tubes cross, they do not add up without end.
                *value = (1.0 - exp(-sum)) as f32;
            }
        });
    values
}

impl Piece {
    fn at(&self, p: DVec3) -> f64 {
        let along = self.to - self.from;
        let t = ((p - self.from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        let q = (p - self.from - along * t).length_squared() / (self.radius * self.radius);
        if q > 6.25 {
            return 0.0;
        }
        self.strength * exp(-q)
    }
}

fn cascade(seed: u64) -> Vec<Piece> {
    let mut pieces = Vec::new();
    for generation in 0..GENERATIONS {
        let mut stream = Stream::new(seed, Role::Scene, u64::from(generation));
        let share = 1.0 / f64::from(1u32 << generation);
        for _ in 0..6 * 8u32.pow(generation) {
            let direction = |s: &mut Stream| {
                let d = DVec3::new(s.normal(), s.normal(), s.normal());
                d / sqrt(d.length_squared()).max(1e-9)
            };
            let middle = DVec3::new(
                stream.range(-0.8, 0.8),
                stream.range(-0.8, 0.8),
                stream.range(-0.8, 0.8),
            );
            let (along, side) = (direction(&mut stream), direction(&mut stream));
            let (length, bow) = (0.9 * share, stream.range(0.1, 0.4) * share);
            let strength = stream.range(0.6, 1.6);
            let at = |k: usize| {
                let t = k as f64 / PIECES as f64;
                let bend = bow * sin(2.0 * std::f64::consts::PI * t);
                middle + along * (length * (t - 0.5)) + side * bend
            };
            for k in 0..PIECES {
                pieces.push(Piece {
                    from: at(k),
                    to: at(k + 1),
                    radius: 0.075 * share,
                    // The pieces of a tube overlap where they meet: together they count once in the middle.
                    strength: 0.7 * strength,
                });
            }
        }
    }
    pieces
}
