use fearless_simd::prelude::*;
use fearless_simd::{f32x8, i16x16, i32x8};
use foveasim_lanes::wide::{F, I, Simd, piece};

use crate::cells::OCCUPIED;
use crate::gradients::{BRICK, Gradients, RECORD, ROW, SLICE};
use crate::levels::Levels;

/// What the weights of two slices add up to: places along z are rounded to so many parts of a voxel. More would not
/// fit 16 bits beside a sign.
pub(crate) const WEIGHT: i32 = 1 << 14;

/// Where the corners of a cell come from.
pub(crate) trait Corners {
    /// A number by which [`rows`](Self::rows) finds each cell.
    fn places<S: Simd>(&self, simd: S, cell: [I<S>; 3]) -> I<S>;

    /// The two rows of a cell's corners, along x: of each corner level and differences, each number beside
    /// that of the corner that is next along z. `state` is that of the part of the volume that the cell is in:
    /// if nothing can be seen there, the numbers mean nothing. `scratch` may be used.
    fn rows<'a>(&'a self, place: i32, state: u32, scratch: &'a mut [i16; 32]) -> [&'a [i16]; 2];
}

impl Corners for Gradients {
    #[inline(always)]
    fn places<S: Simd>(&self, simd: S, cell: [I<S>; 3]) -> I<S> {
        let mask = I::splat(simd, BRICK as i32 - 1);
        let (row, slice) = (I::splat(simd, ROW as i32), I::splat(simd, SLICE as i32));
        (cell[0] & mask) + (cell[1] & mask) * row + (cell[2] & mask) * slice
    }

    #[inline(always)]
    fn rows<'a>(&'a self, place: i32, state: u32, _: &'a mut [i16; 32]) -> [&'a [i16]; 2] {
        let first = match state >= OCCUPIED {
            true => (state - OCCUPIED + place as u32) as usize,
            false => 0,
        };
        // Checked once; the places in it are constants.
        let all = self.records[first..first + ROW + 2].as_flattened();
        [&all[..2 * RECORD], &all[ROW * RECORD..]]
    }
}

impl Corners for Levels {
    #[inline(always)]
    fn places<S: Simd>(&self, simd: S, cell: [I<S>; 3]) -> I<S> {
        // At most 2³¹ voxels: their numbers fit.
        let row = I::splat(simd, self.dims[0] as i32);
        let slice = I::splat(simd, (self.dims[0] * self.dims[1]) as i32);
        cell[0] + cell[1] * row + cell[2] * slice
    }

    #[inline(always)]
    fn rows<'a>(&'a self, place: i32, state: u32, scratch: &'a mut [i16; 32]) -> [&'a [i16]; 2] {
        if state >= OCCUPIED {
            gather(self, place as usize, scratch);
        }
        let (near, far) = scratch.split_at(2 * RECORD);
        [near, far]
    }
}

/// The corners of a cell, gradients computed anew.
fn gather(levels: &Levels, place: usize, out: &mut [i16; 32]) {
    let [nx, ny, _] = levels.dims;
    let cell = [place % nx, place / nx % ny, place / nx / ny];
    for (k, record) in out.chunks_exact_mut(RECORD).enumerate() {
        let at = |z: usize| [cell[0] + k % 2, cell[1] + k / 2, cell[2] + z];
        let [near, far] = [0, 1].map(|z| levels.with_gradient(at(z).map(|p| p as isize)));
        for (pair, (a, b)) in record.chunks_exact_mut(2).zip(near.into_iter().zip(far)) {
            pair.copy_from_slice(&[a, b]);
        }
    }
}

/// The weights of the near and the far slice for places along z in their cells, 0 to 1: two numbers of 16 bits in one, in
/// the order in which they lie in memory.
#[inline(always)]
pub(crate) fn weights<S: Simd>(simd: S, z: F<S>) -> I<S> {
    let far = (z * WEIGHT as f32 + 0.5).to_int::<I<S>>();
    let near = I::splat(simd, WEIGHT) - far;
    let (first, second) = match cfg!(target_endian = "little") {
        true => (near, far),
        false => (far, near),
    };
    first + (second << 16)
}

/// Level and differences at a place in a cell along z and y, [`WEIGHT`] times: at its two sides along x. `z` are
/// [`weights`].
#[inline(always)]
pub(crate) fn at_sides<S: Simd>(simd: S, rows: [&[i16]; 2], y: f32, z: i32) -> f32x8<S> {
    piece(
        simd,
        #[inline(always)]
        || {
            let weights: i16x16<S> = i32x8::splat(simd, z).bitcast();
            let near = between(simd, rows[0], weights);
            near + (between(simd, rows[1], weights) - near) * y
        },
    )
}

/// Eight pairs of numbers, weighted, in whole numbers.
///
/// Nothing overflows: levels are 0 to 2¹⁵ − 1 and differences between two of them, so numbers a and b of a pair are at most
/// 2¹⁵ − 1 in size; weights v and w are not negative and v + w = 2¹⁴. Hence |a·v + b·w| ≤ (2¹⁵ − 1)·2¹⁴ < 2²⁹, and each
/// product is no more than that. The sum is exact, whatever instruction takes it; rounding it to 24 bits is what every
/// level does alike.
#[inline(always)]
fn between<S: Simd>(simd: S, row: &[i16], weights: i16x16<S>) -> f32x8<S> {
    let pairs = i16x16::from_slice(simd, row);
    pairs.pairwise_dot_product(weights).to_float()
}

/// What four cells have on their left sides, and on their right.
#[inline(always)]
pub(crate) fn sides<S: Simd>(cells: [f32x8<S>; 4]) -> [F<S>; 2] {
    let [(a, e), (b, f), (c, g), (d, h)] = [
        cells[0].split(),
        cells[1].split(),
        cells[2].split(),
        cells[3].split(),
    ];
    [
        a.combine(b).combine(c.combine(d)),
        e.combine(f).combine(g.combine(h)),
    ]
}

#[cfg(test)]
mod tests {
    use foveasim_lanes::{Instructions, Kernel, dispatch};

    use super::*;

    const ROWS: [[i16; 16]; 2] = [
        [
            32_767, 32_767, -32_767, -32_767, 32_767, -32_767, 0, 32_767, 1, 2, 3, 4, -5, -6, 7, -8,
        ],
        [32_767; 16],
    ];

    /// Both rows by themselves, for each of sixteen places along z.
    struct Rows([f32; 16]);

    impl Kernel for Rows {
        type Output = Vec<[f32; 8]>;

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Self::Output {
            let z = weights(simd, F::from_slice(simd, &self.0)).to_array();
            let mut all = Vec::new();
            for z in z {
                for y in [0.0, 1.0] {
                    let sides = at_sides(simd, [&ROWS[0], &ROWS[1]], y, z);
                    all.push(std::array::from_fn(|k| sides[k]));
                }
            }
            all
        }
    }

    #[test]
    fn the_greatest_numbers_fit_and_weights_add_up() {
        let below_one = 1.0 - f32::EPSILON / 2.0;
        let places = std::array::from_fn(|k| below_one * k as f32 / 15.0);
        for instructions in [Instructions::Auto, Instructions::Scalar] {
            let all = dispatch(instructions, Rows(places));
            for (n, row) in all.iter().enumerate() {
                let far = (places[n / 2] * WEIGHT as f32 + 0.5) as i64;
                assert!(
                    (far as f64 / f64::from(WEIGHT) - f64::from(places[n / 2])).abs()
                        <= 1.0 / 32_768.0
                );
                for (k, found) in row.iter().enumerate() {
                    let [a, b] = [0, 1].map(|i| i64::from(ROWS[n % 2][2 * k + i]));
                    let exact = a * (i64::from(WEIGHT) - far) + b * far;
                    // `near + (far - near)` rounds twice.
                    let slack = if n % 2 == 1 { 64.0 } else { 0.0 };
                    assert!(
                        (found - exact as f32).abs() <= slack,
                        "{n} {k}: {found} {exact}"
                    );
                }
            }
        }
    }
}
