use fearless_simd::prelude::*;
use fearless_simd::{SimdInterleaved, f32x4, f32x8, i16x8};
use foveasim_lanes::Kernel;
use foveasim_lanes::transcendental::times_exp2;
use foveasim_lanes::wide::{F, I, M, Simd, V3, WIDTH, max, min, piece, splat};

use crate::cells::{Cells, OCCUPIED, SIDE, SIDE_BITS};
use crate::gradients::{BRICK, Gradients, ROW, SLICE};
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
    /// A number by which [`pairs`](Self::pairs) finds each cell.
    fn places<S: Simd>(&self, simd: S, cell: [I<S>; 3]) -> I<S>;

    /// Level and differences of a cell's corners, in pairs along x: at (y, z) = (0, 0), (1, 0), (0, 1),
    /// (1, 1). `state` is that of the part of the volume that it is in; `scratch` may be used.
    fn pairs<'a>(&'a self, place: i32, state: u32, scratch: &'a mut [i16; 32]) -> [&'a [i16]; 4];
}

impl Corners for Gradients {
    #[inline(always)]
    fn places<S: Simd>(&self, simd: S, cell: [I<S>; 3]) -> I<S> {
        let mask = I::splat(simd, BRICK as i32 - 1);
        let (row, slice) = (I::splat(simd, ROW as i32), I::splat(simd, SLICE as i32));
        ((cell[0] & mask) << 2) + (cell[1] & mask) * row + (cell[2] & mask) * slice
    }

    #[inline(always)]
    fn pairs<'a>(&'a self, place: i32, state: u32, _: &'a mut [i16; 32]) -> [&'a [i16]; 4] {
        // Checked once; the four places in it are constants.
        let first = place as usize;
        let all = &self.bricks[(state - OCCUPIED) as usize][first..first + SLICE + ROW + 8];
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
    fn places<S: Simd>(&self, simd: S, cell: [I<S>; 3]) -> I<S> {
        // At most 2³⁰ voxels of two bytes.
        let row = I::splat(simd, self.dims[0] as i32);
        let slice = I::splat(simd, (self.dims[0] * self.dims[1]) as i32);
        cell[0] + cell[1] * row + cell[2] * slice
    }

    #[inline(always)]
    fn pairs<'a>(&'a self, place: i32, _: u32, scratch: &'a mut [i16; 32]) -> [&'a [i16]; 4] {
        gather(self, place as usize, scratch);
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
fn gather(levels: &Levels, place: usize, out: &mut [i16; 32]) {
    let [nx, ny, _] = levels.dims;
    let cell = [place % nx, place / nx % ny, place / nx / ny];
    for (k, voxel) in out.chunks_exact_mut(4).enumerate() {
        let place = std::array::from_fn(|a| (cell[a] + (k >> a & 1)) as isize);
        voxel.copy_from_slice(&levels.with_gradient(place));
    }
}

/// Steps that are taken together: what is seen at them is worked out side by side, where the next alone would
/// have to wait for the last.
const STEPS: usize = 2;

/// Samples of sixteen rays, lane after lane: four numbers each.
#[repr(align(64))]
struct Four([f32; 4 * WIDTH]);

/// A number for each lane, in memory.
#[repr(align(64))]
struct Lanes<T>([T; WIDTH]);

/// What sixteen rays meet at one step.
struct Met {
    /// Level and differences: of rays that take no sample, those of an earlier step.
    values: Four,
    /// What the transfer function has for the levels.
    colours: Four,
    /// The parts of the volume that they are in.
    states: Lanes<u32>,
    /// Which rays are within the volume.
    within: u32,
    /// … of which take a sample.
    taken: u32,
}

impl Met {
    const NOTHING: Self = Self {
        values: Four([0.0; 4 * WIDTH]),
        colours: Four([0.0; 4 * WIDTH]),
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
        let mut scratch = [0i16; 32];
        let mut skipped = zero;

        while alive.any_true() {
            let live = alive.to_bitmask() as u32;
            let (mut taken, mut at) = (0, k);
            for met in &mut met {
                let within = (at.simd_lt(samples) & alive).to_bitmask() as u32;
                self.sample(simd, origin.add(step.scale(at)), within, met, &mut scratch);
                met.within = within;
                taken |= met.taken;
                at += 1.0;
            }
            if taken == 0 {
                let cell = whole(origin.add(step.scale(k)));
                let next = max(self.leave(simd, origin, step, cell, &met[0].states), at);
                self.work.bricks_skipped += u64::from(live.count_ones());
                skipped += alive.select(min(next, samples) - k, zero);
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
            k = at;
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
    /// Takes the samples of the rays `within` at the places `at`, where something may be seen.
    #[inline(always)]
    fn sample<S: Simd>(
        &self,
        simd: S,
        at: V3<S>,
        within: u32,
        met: &mut Met,
        scratch: &mut [i16; 32],
    ) {
        let cell = whole(at);
        let inside = fraction(at, cell);
        let parts = Lanes(self.part(simd, cell).to_array());
        let places = Lanes(self.voxels.places(simd, cell).to_array());
        let [x, y, z] = [
            Lanes(inside.x.to_array()),
            Lanes(inside.y.to_array()),
            Lanes(inside.z.to_array()),
        ];
        met.taken = 0;
        for lane in 0..WIDTH {
            if within >> lane & 1 == 0 {
                continue;
            }
            let state = self.cells.states[parts.0[lane] as usize];
            met.states.0[lane] = state;
            if state < OCCUPIED {
                continue;
            }
            met.taken |= 1 << lane;
            let pairs = self.voxels.pairs(places.0[lane], state, scratch);
            let sample = interpolate(simd, pairs, [x.0[lane], y.0[lane], z.0[lane]]);
            sample.store_slice(&mut met.values.0[4 * lane..4 * lane + 4]);
        }
    }

    /// What samples look like: their colour, and the share of light that they let through. That is 1 for
    /// rays that took none. If all rays go in base steps, the table has the share; else it depends on each
    /// ray's step.
    #[inline(always)]
    fn classify<S: Simd>(
        &self,
        simd: S,
        met: &mut Met,
        factor: F<S>,
        base_steps: bool,
    ) -> (V3<S>, F<S>) {
        let [level, x, y, z] = four(simd, &met.values);
        let entries = (level * self.table.per_level + 0.5).to_int::<I<S>>();
        let entries = Lanes(entries.to_array());
        let table = match base_steps {
            true => &self.table.shares,
            false => &self.table.entries,
        };
        for lane in 0..WIDTH {
            let entry = &table[entries.0[lane] as usize % ENTRIES];
            met.colours.0[4 * lane..4 * lane + 4].copy_from_slice(entry);
        }
        let [r, g, b, passes] = four(simd, &met.colours);
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
            result *= square;
        }
        square *= square;
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
