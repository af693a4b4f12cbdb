use fearless_simd::prelude::*;
use fearless_simd::{SimdInterleaved, f32x4, f32x8, i16x8};
use foveasim_lanes::Kernel;
use foveasim_lanes::transcendental::times_exp2;
use foveasim_lanes::wide::{F, I, Simd, V3, WIDTH, max, min, piece, splat};

use crate::cells::{Cells, OCCUPIED, SIDE, SIDE_BITS};
use crate::gradients::{BRICK, Gradients, NUMBERS, ROW, SLICE};
use crate::levels::Levels;
use crate::packet::{Geometry, Packet};
use crate::table::{ENTRIES, Table};
use crate::{CastOptions, CastWork};

/// Follows the rays of a packet through the volume.
pub(crate) struct Follow<'a, V> {
    pub(crate) voxels: &'a V,
    pub(crate) cells: &'a Cells,
    pub(crate) table: &'a Table,
    pub(crate) geometry: &'a Geometry,
    pub(crate) options: &'a CastOptions,
    pub(crate) packet: &'a Packet,
    pub(crate) work: &'a mut CastWork,
}

/// Where the corners of a cell come from.
pub(crate) trait Corners {
    /// Level and differences of a cell's corners, in pairs along x: at (y, z) = (0, 0), (1, 0), (0, 1),
    /// (1, 1). `state` is that of the part of the volume that it is in; `scratch` may be used.
    fn pairs<'a>(
        &'a self,
        cell: [i32; 3],
        state: u32,
        scratch: &'a mut [i16; 32],
    ) -> [&'a [i16]; 4];
}

impl Corners for Gradients {
    #[inline(always)]
    fn pairs<'a>(&'a self, cell: [i32; 3], state: u32, _: &'a mut [i16; 32]) -> [&'a [i16]; 4] {
        let mask = BRICK as i32 - 1;
        let [x, y, z] = [cell[0] & mask, cell[1] & mask, cell[2] & mask];
        let place = (4 * x) as usize + ROW * y as usize + SLICE * z as usize;
        let first = (state - OCCUPIED) as usize * NUMBERS + place;
        // Checked once; the four places in it are constants.
        let all = &self.numbers[first..first + SLICE + ROW + 8];
        [
            &all[..8],
            &all[ROW..ROW + 8],
            &all[SLICE..SLICE + 8],
            &all[SLICE + ROW..SLICE + ROW + 8],
        ]
    }
}

impl Corners for Levels {
    #[inline(always)]
    fn pairs<'a>(&'a self, cell: [i32; 3], _: u32, scratch: &'a mut [i16; 32]) -> [&'a [i16]; 4] {
        gather(self, cell, scratch);
        let [a, b, c, d] = [0, 8, 16, 24];
        [
            &scratch[a..b],
            &scratch[b..c],
            &scratch[c..d],
            &scratch[d..],
        ]
    }
}

/// The corners of a cell, gradients computed anew.
fn gather(levels: &Levels, cell: [i32; 3], out: &mut [i16; 32]) {
    for (k, voxel) in out.chunks_exact_mut(4).enumerate() {
        let place = std::array::from_fn(|a| cell[a] as isize + (k >> a & 1) as isize);
        voxel.copy_from_slice(&levels.with_gradient(place));
    }
}

/// Samples of sixteen rays, lane after lane: four numbers each.
#[repr(align(64))]
struct Four([f32; 4 * WIDTH]);

/// A number for each lane, in memory.
#[repr(align(64))]
struct Lanes<T>([T; WIDTH]);

impl<V: Corners> Kernel for Follow<'_, V> {
    /// Red, green, blue (linear, weighted by opacity) and opacity of each ray.
    type Output = [[f32; 4]; WIDTH];

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> Self::Output {
        let origin = load(simd, &self.packet.origin);
        let step = load(simd, &self.packet.step);
        let samples = F::from_slice(simd, &self.packet.samples);
        let factor = F::from_slice(simd, &self.packet.factor);
        let zero = splat(simd, 0.0);
        let limit = self.limit();

        let mut k = zero;
        let mut through = splat(simd, 1.0);
        let mut light = V3::splat(simd, [0.0; 3]);
        let mut alive = samples.simd_gt(zero);
        let mut values = Four([0.0; 4 * WIDTH]);
        let mut colours = Four([0.0; 4 * WIDTH]);
        let mut states = Lanes([0u32; WIDTH]);
        let mut scratch = [0i16; 32];

        while alive.any_true() {
            let at = origin.add(step.scale(k));
            let cell = whole(at);
            let inside = fraction(at, cell);
            let part = self.part(simd, cell);
            let live = alive.to_bitmask() as u32;
            let parts = Lanes(part.to_array());
            let [cx, cy, cz] = [
                Lanes(cell[0].to_array()),
                Lanes(cell[1].to_array()),
                Lanes(cell[2].to_array()),
            ];
            let [fx, fy, fz] = [
                Lanes(inside.x.to_array()),
                Lanes(inside.y.to_array()),
                Lanes(inside.z.to_array()),
            ];
            let mut taken = 0u32;
            for lane in 0..WIDTH {
                let state = if live >> lane & 1 == 1 {
                    self.cells.states[parts.0[lane] as usize]
                } else {
                    0
                };
                states.0[lane] = state;
                if state < OCCUPIED {
                    f32x4::splat(simd, 0.0).store_slice(&mut colours.0[4 * lane..4 * lane + 4]);
                    continue;
                }
                taken |= 1 << lane;
                let corner = [cx.0[lane], cy.0[lane], cz.0[lane]];
                let pairs = self.voxels.pairs(corner, state, &mut scratch);
                let sample = interpolate(simd, pairs, [fx.0[lane], fy.0[lane], fz.0[lane]]);
                sample.store_slice(&mut values.0[4 * lane..4 * lane + 4]);
                let entry = (sample[0] * self.table.per_level + 0.5) as u32 as usize;
                let entry = &self.table.entries[entry.min(ENTRIES - 1)];
                colours.0[4 * lane..4 * lane + 4].copy_from_slice(entry);
            }
            self.work.steps += u64::from(taken.count_ones());
            if taken == 0 {
                let next = self.leave(simd, origin, step, cell, &states, k);
                let next = min(next, samples);
                self.work.bricks_skipped += u64::from(live.count_ones());
                self.count_skipped(alive.select(next - k, zero));
                k = next;
                alive = k.simd_lt(samples) & alive;
                continue;
            }
            let empty = live & !taken;
            self.work.steps_skipped += u64::from(empty.count_ones());
            let [r, g, b, passes] = four(simd, &colours);
            let seen = passes.simd_lt(zero);
            let seen_lanes = seen.to_bitmask() as u32;
            if seen_lanes != 0 {
                self.work.steps_seen += u64::from(seen_lanes.count_ones());
                let colour = V3 { x: r, y: g, z: b };
                let colour = self.shade(simd, colour, &values);
                let left = times_exp2(through, passes * factor);
                light = light.add(colour.scale(through - left));
                through = left;
                let ended = through.simd_lt(limit) & alive;
                let ended_lanes = ended.to_bitmask() as u32;
                if ended_lanes != 0 {
                    self.work.rays_ended_early += u64::from(ended_lanes.count_ones());
                    alive = alive & !ended;
                }
            }
            k = k + 1.0;
            alive = k.simd_lt(samples) & alive;
        }
        let [red, green, blue] = [light.x.to_array(), light.y.to_array(), light.z.to_array()];
        let through = through.to_array();
        let mut rays = [[0.0; 4]; WIDTH];
        for lane in 0..WIDTH {
            rays[lane] = [red[lane], green[lane], blue[lane], 1.0 - through[lane]];
        }
        rays
    }
}

impl<V: Corners> Follow<'_, V> {
    /// A ray ends when less than this shines through: what is behind it, as bright as anything shown can be,
    /// then changes no channel by as much as is allowed.
    #[inline(always)]
    fn limit(&self) -> f32 {
        let shown = match self.options.phong {
            Some(p) => self.table.brightest * (p.ambient + p.diffuse) + p.specular,
            None => self.table.brightest,
        };
        self.options.terminate / if shown > 1.0 { shown } else { 1.0 }
    }

    /// The number of the part of the volume that each cell is in.
    #[inline(always)]
    fn part<S: Simd>(&self, simd: S, cell: [I<S>; 3]) -> I<S> {
        let [nx, ny, _] = self.cells.count;
        let across = I::splat(simd, nx as i32);
        let slice = I::splat(simd, (nx * ny) as i32);
        let [x, y, z] = [
            cell[0] >> SIDE_BITS,
            cell[1] >> SIDE_BITS,
            cell[2] >> SIDE_BITS,
        ];
        x + y * across + z * slice
    }

    /// The number of the first sample of each ray that lies beyond what is empty about its cell.
    #[inline(always)]
    fn leave<S: Simd>(
        &self,
        simd: S,
        origin: V3<S>,
        step: V3<S>,
        cell: [I<S>; 3],
        states: &Lanes<u32>,
        k: F<S>,
    ) -> F<S> {
        let reach: F<S> = I::from_fn(
            simd,
            #[inline(always)]
            |lane| states.0[lane] as i32,
        )
        .to_float();
        let x = steps_to_face(origin.x, step.x, cell[0], reach);
        let y = steps_to_face(origin.y, step.y, cell[1], reach);
        let z = steps_to_face(origin.z, step.z, cell[2], reach);
        max(min(min(x, y), z).ceil(), k + 1.0)
    }

    /// Phong's model for colours in lanes; `values` are their levels and differences.
    #[inline(always)]
    fn shade<S: Simd>(&self, simd: S, colour: V3<S>, values: &Four) -> V3<S> {
        let Some(phong) = self.options.phong else {
            return colour;
        };
        piece(
            simd,
            #[inline(always)]
            || {
                let [_, x, y, z] = four(simd, values);
                let g = V3 { x, y, z };
                let [xx, yy, zz, xy, xz, yz] = self.geometry.metric;
                let squared = x * (x * xx + y * xy + z * xz) + y * (y * yy + z * yz) + z * z * zz;
                let unit = splat(simd, 1.0) / max(squared, splat(simd, 1e-12)).sqrt();
                let zero = splat(simd, 0.0);
                // Towards the eye is against the ray.
                let to_eye = (zero - g.dot(load(simd, &self.packet.along))) * unit;
                let (diffuse, mirrored) = match self.geometry.light {
                    None => (to_eye.abs(), to_eye * to_eye * 2.0 - 1.0),
                    Some(light) => {
                        let cosine = g.dot(V3::splat(simd, light)) * unit;
                        let towards = to_eye.simd_lt(zero).select(zero - cosine, cosine);
                        let between = F::from_slice(simd, &self.packet.light_eye);
                        // r·v with r = 2(n·l)n − l; on the side away from the light there is none.
                        let mirrored = cosine * to_eye * 2.0 - between;
                        (
                            max(towards, zero),
                            towards.simd_gt(zero).select(mirrored, zero),
                        )
                    }
                };
                let highlight = power(simd, max(mirrored, zero), phong.shininess) * phong.specular;
                let lit = diffuse * phong.diffuse + phong.ambient;
                colour.scale(lit).add(V3 {
                    x: highlight,
                    y: highlight,
                    z: highlight,
                })
            },
        )
    }

    #[inline(always)]
    fn count_skipped<S: Simd>(&mut self, steps: F<S>) {
        let steps = steps.to_array();
        let mut all = 0;
        for n in steps {
            all += n as u64;
        }
        self.work.steps_skipped += all;
    }
}

/// Four numbers of each lane, from lanes in memory.
#[inline(always)]
fn four<S: Simd>(simd: S, all: &Four) -> [F<S>; 4] {
    piece(
        simd,
        #[inline(always)]
        || {
            let a = f32x4::load_four_interleaved(simd, &all.0[..16]);
            let b = f32x4::load_four_interleaved(simd, &all.0[16..32]);
            let c = f32x4::load_four_interleaved(simd, &all.0[32..48]);
            let d = f32x4::load_four_interleaved(simd, &all.0[48..]);
            [
                a[0].combine(b[0]).combine(c[0].combine(d[0])),
                a[1].combine(b[1]).combine(c[1].combine(d[1])),
                a[2].combine(b[2]).combine(c[2].combine(d[2])),
                a[3].combine(b[3]).combine(c[3].combine(d[3])),
            ]
        },
    )
}

/// Vectors in lanes.
#[inline(always)]
fn load<S: Simd>(simd: S, v: &[[f32; WIDTH]; 3]) -> V3<S> {
    V3 {
        x: F::from_slice(simd, &v[0]),
        y: F::from_slice(simd, &v[1]),
        z: F::from_slice(simd, &v[2]),
    }
}

/// After how many steps along one axis each ray leaves the part of the volume that `cell` is in, and `reach`
/// more.
#[inline(always)]
fn steps_to_face<S: Simd>(origin: F<S>, step: F<S>, cell: I<S>, reach: F<S>) -> F<S> {
    let simd = origin.simd;
    piece(
        simd,
        #[inline(always)]
        || {
            let part: F<S> = (cell >> SIDE_BITS).to_float();
            let back = step.simd_lt(splat(simd, 0.0));
            // A step of almost nothing leads nowhere.
            let tiny = splat(simd, 1e-20);
            let step = step.abs().simd_gt(tiny).select(step, tiny);
            let face = back.select(part - reach, part + reach + 1.0) * SIDE as f32;
            (face - origin) / step
        },
    )
}

/// The cell that each place is in; places are not negative.
#[inline(always)]
fn whole<S: Simd>(at: V3<S>) -> [I<S>; 3] {
    [at.x.to_int(), at.y.to_int(), at.z.to_int()]
}

/// Where in its cell each place is, 0 to 1.
#[inline(always)]
fn fraction<S: Simd>(at: V3<S>, cell: [I<S>; 3]) -> V3<S> {
    V3 {
        x: at.x - cell[0].to_float::<F<S>>(),
        y: at.y - cell[1].to_float::<F<S>>(),
        z: at.z - cell[2].to_float::<F<S>>(),
    }
}

/// x to a whole power, by squaring.
#[inline(always)]
fn power<S: Simd>(simd: S, x: F<S>, exponent: u32) -> F<S> {
    let (mut result, mut square, mut rest) = (splat(simd, 1.0), x, exponent);
    while rest > 0 {
        if rest & 1 == 1 {
            result = result * square;
        }
        square = square * square;
        rest >>= 1;
    }
    result
}

/// Eight numbers.
#[inline(always)]
fn numbers<S: Simd>(simd: S, pair: &[i16]) -> f32x8<S> {
    let (low, high) = i16x8::from_slice(simd, pair).widen();
    low.combine(high).to_float()
}

/// Level and differences at a place in a cell, trilinearly: along z, then y, then x.
#[inline(always)]
fn interpolate<S: Simd>(simd: S, pairs: [&[i16]; 4], [x, y, z]: [f32; 3]) -> f32x4<S> {
    piece(
        simd,
        #[inline(always)]
        || {
            let (a, b) = (numbers(simd, pairs[0]), numbers(simd, pairs[1]));
            let near = a + (numbers(simd, pairs[2]) - a) * z;
            let far = b + (numbers(simd, pairs[3]) - b) * z;
            let (left, right) = (near + (far - near) * y).split();
            left + (right - left) * x
        },
    )
}
