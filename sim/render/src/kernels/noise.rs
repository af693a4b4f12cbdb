//! Band-limited value noise, in lanes.

use fearless_simd::prelude::*;

use super::wide::{F, I, Simd, U, V3, apart, max, min, mix, piece, saturate, splat};

/// Coordinates beyond this are clamped: they must fit the conversion to integers.
const FAR: f32 = 1e6;

/// Cell index and smooth position in the cell of one coordinate.
#[inline(always)]
fn cell<S: Simd>(simd: S, x: F<S>) -> (U<S>, F<S>) {
    piece(
        simd,
        #[inline(always)]
        || {
            let x = min(max(x, splat(simd, -FAR)), splat(simd, FAR));
            let whole = x.floor();
            let t = x - whole;
            // 6t⁵ − 15t⁴ + 10t³ (Perlin 2002).
            let smooth = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
            (whole.to_int::<I<S>>().bitcast(), smooth)
        },
    )
}

/// −1 to 1 from mixed coordinates; the finalizer is lowbias32 (Wellons 2018).
#[inline(always)]
fn corner<S: Simd>(h: U<S>) -> F<S> {
    piece(
        h.simd,
        #[inline(always)]
        || {
            let h = (h ^ (h >> 16)) * 0x7feb_352d;
            let h = (h ^ (h >> 15)) * 0x846c_a68b;
            let h: I<S> = ((h ^ (h >> 16)) >> 8).bitcast();
            h.to_float::<F<S>>() * (2.0 / 16_777_215.0) - 1.0
        },
    )
}

const PRIMES: [u32; 3] = [0x9e37_79b1, 0x85eb_ca77, 0xc2b2_ae3d];

/// Value noise on the plane, −1 to 1.
#[inline(always)]
pub(super) fn value_2d<S: Simd>(simd: S, x: F<S>, y: F<S>, seed: u32) -> F<S> {
    piece(
        simd,
        #[inline(always)]
        || {
            let ((ix, fx), (iy, fy)) = (cell(simd, x), cell(simd, y));
            let (x0, y0) = ((ix * PRIMES[0]) ^ seed, iy * PRIMES[1]);
            let (x1, y1) = (((ix + 1) * PRIMES[0]) ^ seed, y0 + PRIMES[1]);
            let low = mix(corner(x0 ^ y0), corner(x1 ^ y0), fx);
            let high = mix(corner(x0 ^ y1), corner(x1 ^ y1), fx);
            mix(low, high, fy)
        },
    )
}

/// Value noise in space, −1 to 1.
#[inline(always)]
pub(super) fn value_3d<S: Simd>(simd: S, p: V3<S>, seed: u32) -> F<S> {
    piece(
        simd,
        #[inline(always)]
        || {
            let ((ix, fx), (iy, fy), (iz, fz)) =
                (cell(simd, p.x), cell(simd, p.y), cell(simd, p.z));
            let x = [(ix * PRIMES[0]) ^ seed, ((ix + 1) * PRIMES[0]) ^ seed];
            let y = [iy * PRIMES[1], (iy + 1) * PRIMES[1]];
            let z = [iz * PRIMES[2], (iz + 1) * PRIMES[2]];
            let near = mix(edge(x, y[0] ^ z[0], fx), edge(x, y[1] ^ z[0], fx), fy);
            let far = mix(edge(x, y[0] ^ z[1], fx), edge(x, y[1] ^ z[1], fx), fy);
            mix(near, far, fz)
        },
    )
}

/// Between two corners along x.
#[inline(always)]
fn edge<S: Simd>(x: [U<S>; 2], yz: U<S>, fx: F<S>) -> F<S> {
    piece(
        fx.simd,
        #[inline(always)]
        || mix(corner(x[0] ^ yz), corner(x[1] ^ yz), fx),
    )
}

/// Weight of an octave of `frequency` seen through a footprint: 1 while a period spans at least four
/// footprints, 0 from two on, where it could only alias.
#[inline(always)]
pub(super) fn visible<S: Simd>(simd: S, frequency: f32, footprint: F<S>) -> F<S> {
    piece(
        simd,
        #[inline(always)]
        || saturate(splat(simd, 2.0) - footprint * (4.0 * frequency)),
    )
}

/// How many octaves, and the seed of the first.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fractal {
    pub(super) octaves: u32,
    pub(super) seed: u32,
}

/// Octaves of [`value_2d`], each twice as fine and half as high, those too fine for the footprint
/// faded out. Coordinates and footprint are in units of the first octave's period. Skipping octaves
/// that no lane sees changes nothing: they would add zero.
///
/// Compiled once, not into each caller: there are many, and it is long enough that the call does not show.
#[inline(always)]
pub(super) fn fractal_2d<S: Simd>(simd: S, x: F<S>, y: F<S>, foot: F<S>, f: Fractal) -> F<S> {
    apart(
        simd,
        #[inline(always)]
        || {
            let mut octaves = Octaves::new(simd, foot, f);
            while let Some((weight, scale, seed)) = octaves.next(simd) {
                let value = piece(
                    simd,
                    #[inline(always)]
                    || value_2d(simd, x * scale, y * scale, seed),
                );
                octaves.sum += weight * value;
            }
            octaves.sum
        },
    )
}

/// As [`fractal_2d`], in space.
#[inline(always)]
pub(super) fn fractal_3d<S: Simd>(simd: S, p: V3<S>, foot: F<S>, f: Fractal) -> F<S> {
    apart(
        simd,
        #[inline(always)]
        || {
            let mut octaves = Octaves::new(simd, foot, f);
            while let Some((weight, scale, seed)) = octaves.next(simd) {
                let value = piece(
                    simd,
                    #[inline(always)]
                    || value_3d(simd, p.scale(splat(simd, scale)), seed),
                );
                octaves.sum += weight * value;
            }
            octaves.sum
        },
    )
}

/// The octaves of a fractal that some lane sees, from coarse to fine.
struct Octaves<S: Simd> {
    sum: F<S>,
    foot: F<S>,
    amplitude: f32,
    scale: f32,
    seed: u32,
    left: u32,
}

impl<S: Simd> Octaves<S> {
    #[inline(always)]
    fn new(simd: S, foot: F<S>, f: Fractal) -> Self {
        let sum = splat(simd, 0.0);
        Self {
            sum,
            foot,
            amplitude: 1.0,
            scale: 1.0,
            seed: f.seed,
            left: f.octaves,
        }
    }

    /// Weight, scale and seed of the next octave.
    #[inline(always)]
    fn next(&mut self, simd: S) -> Option<(F<S>, f32, u32)> {
        let visible = visible(simd, self.scale, self.foot);
        if self.left == 0 || !visible.simd_gt(0.0).any_true() {
            return None;
        }
        let octave = (visible * self.amplitude, self.scale, self.seed);
        self.amplitude *= 0.5;
        self.scale *= 2.0;
        self.seed = self.seed.wrapping_add(1);
        self.left -= 1;
        Some(octave)
    }
}
