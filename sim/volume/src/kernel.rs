use fearless_simd::f32x4;
use fearless_simd::prelude::*;
use foveasim_lanes::Kernel;
use foveasim_lanes::transcendental::times_exp2;
use foveasim_lanes::wide::{F, I, M, Simd, V3, WIDTH, max, min, piece, splat};

use crate::cells::{Cells, OCCUPIED, SIDE, SIDE_BITS};
use crate::corners::{Corners, WEIGHT, at_sides, sides, weights};
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

/// Steps that are taken together: what is seen at them is worked out side by side, where the next alone would
/// have to wait for the last.
const STEPS: usize = 2;

/// A number for each lane, in memory.
#[repr(align(64))]
struct Lanes<T>([T; WIDTH]);

/// What sixteen rays meet at one step.
struct Met {
    /// Level and differences, [`WEIGHT`] times, four rays after four: of rays that take no sample, anything finite.
    values: [Lanes<f32>; 4],
    /// The parts of the volume that they are in.
    states: Lanes<u32>,
    /// Which rays are within the volume.
    within: u32,
    /// … of which take a sample.
    taken: u32,
}

impl Met {
    const NOTHING: Self = Self {
        values: [const { Lanes([0.0; WIDTH]) }; 4],
        states: Lanes([0; WIDTH]),
        within: 0,
        taken: 0,
    };
}

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
        let base_steps = factor.simd_eq(splat(simd, 1.0)).all_true();

        let mut k = zero;
        let mut through = splat(simd, 1.0);
        let mut light = V3::splat(simd, [0.0; 3]);
        let mut alive = samples.simd_gt(zero);
        let mut met = [Met::NOTHING; STEPS];
        let mut scratch = [0; 32];
        let mut skipped = zero;
        // The rays that had not ended one turn ago. Which have by now is known only when all that was met has been
        // worked out: a guess at what to sample next would wait for it.
        let mut lately = alive.to_bitmask() as u32;

        while alive.any_true() {
            let live = alive.to_bitmask() as u32;
            let (mut taken, mut at) = (0, k);
            for met in &mut met {
                let within = at.simd_lt(samples);
                let place = origin.add(step.scale(at));
                self.sample(simd, place, within, lately, met, &mut scratch);
                met.within = within.to_bitmask() as u32;
                taken |= met.taken;
                at += 1.0;
            }
            let jumps = taken & lately == 0;
            lately = live;
            if jumps {
                let cell = whole(origin.add(step.scale(k)));
                let next = max(self.leave(simd, origin, step, cell, &met[0].states), at);
                self.work.bricks_skipped += u64::from(live.count_ones());
                let next = min(next, samples);
                skipped += alive.select(next - k, zero);
                k = next;
                alive = k.simd_lt(samples) & alive;
                continue;
            }
            for met in &mut met {
                // A ray that ends at the first of these steps has no more of them: what was taken is not counted.
                let live = alive.to_bitmask() as u32;
                self.work.steps += u64::from((live & met.taken).count_ones());
                let skipped = live & met.within & !met.taken;
                self.work.steps_skipped += u64::from(skipped.count_ones());
                if met.taken == 0 {
                    continue;
                }
                let (colour, left) = self.classify(simd, met, factor, base_steps);
                // Nothing more reaches a ray that has ended.
                let seen = left.simd_lt(splat(simd, 1.0)) & alive;
                self.work.steps_seen += u64::from(seen.to_bitmask().count_ones());
                let left = alive.select(left * through, through);
                light = light.add(colour.scale(through - left));
                through = left;
                let ended = through.simd_lt(limit) & alive;
                self.work.rays_ended_early += u64::from(ended.to_bitmask().count_ones());
                alive &= !ended;
            }
            // Not beyond the volume, where what is worked out for rays that have ended might not be finite.
            k = min(at, samples);
            alive = k.simd_lt(samples) & alive;
        }
        self.count_skipped(skipped);
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
    /// Takes the samples of the rays `within` the volume at the places `at`, where something may be seen; those of
    /// rays that are not in `live` may be left out.
    #[inline(always)]
    fn sample<S: Simd>(
        &self,
        simd: S,
        at: V3<S>,
        within: M<S>,
        live: u32,
        met: &mut Met,
        scratch: &mut [i16; 32],
    ) {
        let cell = whole(at);
        let inside = fraction(at, cell);
        // Beyond the volume there are no parts: rays there are taken to the first.
        let nowhere = I::splat(simd, 0);
        let parts = Lanes(within.select(self.part(simd, cell), nowhere).to_array());
        let places = Lanes(
            within
                .select(self.voxels.places(simd, cell), nowhere)
                .to_array(),
        );
        let across = four_times(inside.x);
        let y = Lanes(inside.y.to_array());
        let z = Lanes(weights(simd, inside.z).to_array());
        let within = within.to_bitmask() as u32;
        let states = &self.cells.states[..];
        met.taken = 0;
        let mut taken = 0;
        #[expect(
            clippy::needless_range_loop,
            reason = "what iterates over vectors might not be inlined, and would lack the level's instructions"
        )]
        for group in 0..4 {
            let first = 4 * group;
            let mut seen = 0;
            for lane in 0..4 {
                let state = states[parts.0[first + lane] as usize];
                met.states.0[first + lane] = state;
                seen |= u32::from(state >= OCCUPIED) << lane;
            }
            seen &= within >> first;
            if seen & live >> first == 0 {
                continue;
            }
            taken |= seen << first;
            // All four, whether they are asked for or not: that is faster than to ask.
            let [left, right] = sides(four(
                #[inline(always)]
                |lane| {
                    let lane = first + lane;
                    let state = met.states.0[lane];
                    let rows = self.voxels.rows(places.0[lane], state, scratch);
                    at_sides(simd, rows, y.0[lane], z.0[lane])
                },
            ));
            let values = left + (right - left) * across[group];
            values.store_slice(&mut met.values[group].0);
        }
        met.taken = taken;
    }

    /// What samples look like: their colour, and the share of light that they let through. That is 1 for
    /// rays that took none. If all rays go in base steps, the table has the share; else it depends on each
    /// ray's step.
    #[inline(always)]
    fn classify<S: Simd>(
        &self,
        simd: S,
        met: &Met,
        factor: F<S>,
        base_steps: bool,
    ) -> (V3<S>, F<S>) {
        let [level, x, y, z] = apart(four(
            #[inline(always)]
            |group| F::from_slice(simd, &met.values[group].0),
        ));
        let per_level = self.table.per_level / WEIGHT as f32;
        let entries = (level * per_level + 0.5).to_int::<I<S>>();
        let entries = Lanes(entries.to_array());
        let table = match base_steps {
            true => &self.table.shares,
            false => &self.table.entries,
        };
        let [r, g, b, passes] = apart(four(
            #[inline(always)]
            |group| {
                let [a, b, c, d] = four(
                    #[inline(always)]
                    |lane| {
                        let number = entries.0[4 * group + lane] as usize;
                        f32x4::from_slice(simd, &table[number % ENTRIES])
                    },
                );
                a.combine(b).combine(c.combine(d))
            },
        ));
        let zero = splat(simd, 0.0);
        let taken = M::from_bitmask(simd, u64::from(met.taken));
        let colour = self.shade(simd, V3 { x: r, y: g, z: b }, V3 { x, y, z });
        let one = splat(simd, 1.0);
        let left = match base_steps {
            true => taken.select(passes, one),
            false => times_exp2(one, taken.select(passes, zero) * factor),
        };
        (colour, left)
    }

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
        min(min(x, y), z).ceil()
    }

    /// Phong's model for colours in lanes; `g` are gradients in voxel indices, of whatever length.
    #[inline(always)]
    fn shade<S: Simd>(&self, simd: S, colour: V3<S>, g: V3<S>) -> V3<S> {
        let Some(phong) = self.options.phong else {
            return colour;
        };
        piece(
            simd,
            #[inline(always)]
            || {
                let V3 { x, y, z } = g;
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

    /// Counts places of samples: whole numbers, which floats of 24 bits have whatever a ray's length.
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

/// `[f(0), f(1), f(2), f(3)]`, inlined.
#[inline(always)]
fn four<T>(mut f: impl FnMut(usize) -> T) -> [T; 4] {
    [f(0), f(1), f(2), f(3)]
}

/// Each number four times: of the first four lanes, of the next four and so on.
#[inline(always)]
fn four_times<S: Simd>(x: F<S>) -> [F<S>; 4] {
    piece(
        x.simd,
        #[inline(always)]
        || {
            let (low, high) = x.interleave(x);
            let (a, b) = low.interleave(low);
            let (c, d) = high.interleave(high);
            [a, b, c, d]
        },
    )
}

/// Lanes of four numbers each, from four lanes after four.
#[inline(always)]
fn apart<S: Simd>([a, b, c, d]: [F<S>; 4]) -> [F<S>; 4] {
    piece(
        a.simd,
        #[inline(always)]
        || {
            let (even, odd) = a.deinterleave(b);
            let (later_even, later_odd) = c.deinterleave(d);
            let (first, third) = even.deinterleave(later_even);
            let (second, fourth) = odd.deinterleave(later_odd);
            [first, second, third, fourth]
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
            result *= square;
        }
        square *= square;
        rest >>= 1;
    }
    result
}
