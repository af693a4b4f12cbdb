use fearless_simd::prelude::*;

use glam::{DVec2, UVec2};

use super::Kernel;
use super::lanes::{Simd, three, two};
use super::wide::{F, M, piece, splat};
use crate::moving::{EvenBlock, EvenPlaces, Target, px};
use crate::placed::BLOCKS;
use crate::tile::{ALL, BLOCKS_ACROSS, LANES, LaneSet, TILE};

/// Sixteen square blocks of samples, a block to a lane: planes for u, v and t, and how far samples are from them. They
/// are [`Node`](foveasim_models::raster::Node)s in lanes; names and proof are those of `docs/bounds.md`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sixteen {
    centre: [[f32; LANES]; 3],
    /// Along x, along y.
    slopes: [[[f32; LANES]; 3]; 2],
    residual: [[f32; LANES]; 3],
    reach: [[f32; LANES]; 3],
    most: [[f32; LANES]; 2],
    rounding: [f32; LANES],
    /// Boxes around u and v.
    low: [[f32; LANES]; 2],
    high: [[f32; LANES]; 2],
    /// Blocks with a live sample.
    live: LaneSet,
    /// Samples from the middle of a block to its outermost.
    extent: f32,
}

/// Which sides of a triangle the blocks may see.
#[derive(Clone, Copy)]
struct Sides<S: Simd> {
    front: M<S>,
    back: M<S>,
}

/// Parts of a tile: 4 × 4, each of 4 × 4 blocks.
pub(crate) const PARTS: usize = BLOCKS / LANES;

/// What a tile's samples look at, in blocks of three sizes.
#[derive(Debug, Clone)]
pub(crate) struct TileBlocks {
    /// By part, its 16 blocks.
    pub(crate) blocks: [Sixteen; PARTS],
    /// The 16 parts.
    pub(crate) parts: Sixteen,
    /// The tile, in lane 0.
    pub(crate) tile: Sixteen,
}

/// The block of a tile that is the `lane`-th of a part.
#[inline(always)]
pub(crate) fn block_of(part: usize, lane: usize) -> usize {
    let side = 4;
    let (y, x) = (
        part / side * side + lane / side,
        part % side * side + lane % side,
    );
    y * BLOCKS_ACROSS as usize + x
}

/// Finds the blocks of a tile. Samples that are not `valid` take the place of one of their block that is: no bound
/// needs to hold for them.
pub(crate) struct FindBlocks<'a> {
    pub(crate) at: &'a [[[i32; LANES]; 2]],
    /// Empty where all look at the start.
    pub(crate) time: &'a [[f32; LANES]],
    pub(crate) valid: &'a [LaneSet],
    pub(crate) out: &'a mut TileBlocks,
}

/// What rounding adds to f32 differences of numbers up to a size, as a share of it: 8 roundings (docs/bounds.md, step 5).
const SLACK: f32 = 8.0 / (1u32 << 24) as f32;
/// Unit roundoff of f32.
const ROUNDOFF: f32 = 1.0 / (1u32 << 24) as f32;
/// A little more, for what rounds on the way to a bound.
const MORE: f32 = 1.0 + 1e-5;
/// What underflow may add: 2⁻⁸⁰.
const UNDERFLOW: f32 = 8.271_806e-25;

impl Sixteen {
    pub(crate) const NONE: Self = Self {
        centre: [[0.0; LANES]; 3],
        slopes: [[[0.0; LANES]; 3]; 2],
        residual: [[0.0; LANES]; 3],
        reach: [[0.0; LANES]; 3],
        most: [[0.0; LANES]; 2],
        rounding: [0.0; LANES],
        low: [[f32::MAX; LANES]; 2],
        high: [[f32::MIN; LANES]; 2],
        live: 0,
        extent: 0.0,
    };

    /// Up to sixteen boxes, least and greatest along x and y: for [`Sixteen::meets`] alone.
    pub(crate) fn of_boxes(boxes: &[[[f32; 2]; 2]]) -> Self {
        let mut all = Self::NONE;
        for (lane, bounds) in boxes.iter().enumerate().take(LANES) {
            for (k, [low, high]) in bounds.iter().enumerate() {
                all.low[k][lane] = *low;
                all.high[k][lane] = *high;
            }
            all.live |= 1 << lane;
        }
        all
    }

    /// The image positions that any block has: least and greatest along x and y \[px\]; an empty range if none is live.
    pub(crate) fn image_bounds(&self) -> [[f32; 2]; 2] {
        [0, 1].map(|k| {
            let low = self.low[k].iter().fold(f32::MAX, |m, x| m.min(*x));
            [low, self.high[k].iter().fold(f32::MIN, |m, x| m.max(*x))]
        })
    }

    /// Whether any block has a live sample.
    pub(crate) fn is_live(&self) -> bool {
        self.live != 0
    }

    /// Puts lane `from` of another at lane `to`.
    pub(crate) fn put(&mut self, to: usize, other: &Self, from: usize) {
        for c in 0..3 {
            self.centre[c][to] = other.centre[c][from];
            self.residual[c][to] = other.residual[c][from];
            self.reach[c][to] = other.reach[c][from];
            for axis in 0..2 {
                self.slopes[axis][c][to] = other.slopes[axis][c][from];
            }
        }
        for k in 0..2 {
            self.most[k][to] = other.most[k][from];
            self.low[k][to] = other.low[k][from];
            self.high[k][to] = other.high[k][from];
        }
        self.rounding[to] = other.rounding[from];
        self.live |= (other.live >> from & 1) << to;
        self.extent = other.extent;
    }

    /// Fills a lane from what is known of its samples: slopes, the range of what the planes leave, and the range of
    /// the numbers themselves.
    #[expect(
        clippy::needless_range_loop,
        reason = "lanes lie side by side in many arrays"
    )]
    #[inline(always)]
    fn fill(
        &mut self,
        lane: usize,
        slopes: [[f32; 3]; 2],
        rest: [[f32; 2]; 3],
        range: [[f32; 2]; 3],
    ) {
        let mut kappa = 0.0f32;
        for c in 0..3 {
            let [low, high] = rest[c];
            let mut centre = (low + high) * 0.5;
            let mut residual = (high - low) * 0.5;
            // Sums over powers of t count on a time from 0 to 1.
            if c == 2 {
                let within = centre.clamp(0.0, 1.0);
                residual += (centre - within).abs();
                centre = within;
            }
            let [least, greatest] = range[c];
            let most = least.abs().max(greatest.abs()).max(centre.abs());
            let step = (slopes[0][c].abs() + slopes[1][c].abs()) * self.extent;
            let slack = (most + step) * SLACK;
            let residual = (residual + slack) * MORE;
            let reach = ((greatest - centre).max(centre - least) + slack) * MORE;
            let whole = match c {
                2 => 1.0,
                _ => most.max(f32::MIN_POSITIVE),
            };
            kappa = kappa.max((step + residual).max(reach) / whole);
            self.centre[c][lane] = centre;
            self.residual[c][lane] = residual;
            self.reach[c][lane] = reach;
            for axis in 0..2 {
                self.slopes[axis][c][lane] = slopes[axis][c];
            }
            if c < 2 {
                self.most[c][lane] = most;
                self.low[c][lane] = least;
                self.high[c][lane] = greatest;
            }
        }
        let terms = kappa * (3.0 + kappa * (3.0 + kappa));
        self.rounding[lane] = ROUNDOFF * (20.0 + 24.0 * terms) * MORE;
        self.live |= 1 << lane;
    }

    /// Fills a lane with a block of evenly placed samples about lattice position `middle`.
    fn fill_evenly(&mut self, lane: usize, places: &EvenPlaces, middle: DVec2) {
        let EvenBlock {
            middle,
            slopes,
            off,
        } = places.block(middle);
        let around = |c: usize, most: f32| [middle[c] - most, middle[c] + most];
        let rest = [0, 1, 2].map(|c| around(c, off[c]));
        let range = [0, 1, 2].map(|c| {
            let step = (slopes[0][c].abs() + slopes[1][c].abs()) * self.extent;
            around(c, (step + off[c]) * MORE)
        });
        self.fill(lane, slopes, rest, range);
    }

    /// The tile whose first sample is at lattice position `origin`, in lane 0, its samples evenly placed.
    pub(crate) fn even_tile(places: &EvenPlaces, origin: UVec2) -> Self {
        let half = f64::from(TILE - 1) / 2.0;
        let mut tile = Self {
            extent: half as f32,
            ..Self::NONE
        };
        tile.fill_evenly(0, places, origin.as_dvec2() + half);
        tile
    }

    /// A block of the sixteen blocks here, 4 × 4 of them, which have `side` samples each way.
    #[inline(always)]
    fn join(&self, side: f32, out: &mut Self, to: usize) {
        let live = self.live;
        if live == 0 {
            return;
        }
        let count = live.count_ones() as f32;
        let mut slopes = [[0.0f32; 3]; 2];
        for lane in (0..LANES).filter(|lane| live >> lane & 1 != 0) {
            for (axis, slopes) in slopes.iter_mut().enumerate() {
                for (c, slope) in slopes.iter_mut().enumerate() {
                    *slope += self.slopes[axis][c][lane] / count;
                }
            }
        }
        let (mut rest, mut range) = ([[f32::MAX, f32::MIN]; 3], [[f32::MAX, f32::MIN]; 3]);
        for lane in (0..LANES).filter(|lane| live >> lane & 1 != 0) {
            let place = [lane % 4, lane / 4].map(|k| (k as f32 - 1.5) * side);
            for c in 0..3 {
                let [sx, sy] = [slopes[0][c], slopes[1][c]];
                let middle = self.centre[c][lane] - (sx * place[0] + sy * place[1]);
                let turn =
                    (self.slopes[0][c][lane] - sx).abs() + (self.slopes[1][c][lane] - sy).abs();
                // Sums here are rounded, too.
                let most = self.centre[c][lane].abs() + (sx.abs() + sy.abs()) * 2.0 * side;
                let off = (turn * self.extent + self.residual[c][lane] + most * SLACK) * MORE;
                rest[c] = [rest[c][0].min(middle - off), rest[c][1].max(middle + off)];
                let [low, high] = match c {
                    2 => {
                        let (centre, reach) = (self.centre[2][lane], self.reach[2][lane]);
                        [centre - reach, centre + reach]
                    }
                    _ => [self.low[c][lane], self.high[c][lane]],
                };
                range[c] = [range[c][0].min(low), range[c][1].max(high)];
            }
        }
        out.extent = 2.0 * side - 0.5;
        out.fill(to, slopes, rest, range);
    }
}

impl TileBlocks {
    pub(crate) const NONE: Self = Self {
        blocks: [Sixteen::NONE; PARTS],
        parts: Sixteen::NONE,
        tile: Sixteen::NONE,
    };

    /// Those of the tile whose first sample is at lattice position `origin`, its samples evenly placed: what [`FindBlocks`]
    /// finds from the samples themselves, without looking at them. Blocks without a `valid` sample are left out.
    pub(crate) fn find_even(&mut self, places: &EvenPlaces, origin: UVec2, valid: &[LaneSet]) {
        let origin = origin.as_dvec2();
        let middle = |k: usize, side: f64| {
            let at = DVec2::new((k % 4) as f64, (k / 4) as f64);
            at * side + (side - 1.0) / 2.0
        };
        self.parts = Sixteen {
            extent: 7.5,
            ..Sixteen::NONE
        };
        self.tile = Sixteen::NONE;
        for part in 0..PARTS {
            let out = &mut self.blocks[part];
            out.live = 0;
            out.extent = 1.5;
            let first = origin + DVec2::new((part % 4) as f64, (part / 4) as f64) * 16.0;
            for lane in 0..LANES {
                if valid[block_of(part, lane)] != 0 {
                    out.fill_evenly(lane, places, first + middle(lane, 4.0));
                }
            }
            if out.live != 0 {
                self.parts
                    .fill_evenly(part, places, origin + middle(part, 16.0));
            }
        }
    }
}

impl Kernel for FindBlocks<'_> {
    type Output = ();

    /// Plain loops, which the compiler gives the instructions of the level.
    #[expect(
        clippy::needless_range_loop,
        reason = "lanes lie side by side in many arrays"
    )]
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let out = self.out;
        *out = TileBlocks::NONE;
        for part in 0..PARTS {
            let mut sixteen = Sixteen {
                extent: 1.5,
                ..Sixteen::NONE
            };
            // By component and sample, the blocks side by side.
            let mut looks = [[[0.0f32; LANES]; LANES]; 3];
            let mut live = 0;
            for lane in 0..LANES {
                let block = block_of(part, lane);
                let valid = self.valid[block];
                if valid == 0 {
                    continue;
                }
                live |= 1 << lane;
                let first = valid.trailing_zeros() as usize;
                for sample in 0..LANES {
                    let from = match valid == ALL || valid >> sample & 1 != 0 {
                        true => sample,
                        false => first,
                    };
                    looks[0][sample][lane] = px(self.at[block][0][from]);
                    looks[1][sample][lane] = px(self.at[block][1][from]);
                    if !self.time.is_empty() {
                        looks[2][sample][lane] = self.time[block][from];
                    }
                }
            }
            if live == 0 {
                continue;
            }
            let mut slopes = [[[0.0f32; 3]; LANES]; 2];
            let (mut rest, mut range) = (
                [[[f32::MAX, f32::MIN]; 3]; LANES],
                [[[f32::MAX, f32::MIN]; 3]; LANES],
            );
            for (c, looks) in looks.iter().enumerate() {
                let (mut along, mut down) = ([0.0f32; LANES], [0.0f32; LANES]);
                for lane in 0..LANES {
                    let [a, b, c, d] = [looks[0], looks[3], looks[12], looks[15]].map(|s| s[lane]);
                    along[lane] = ((b - a) + (d - c)) * (1.0 / 6.0);
                    down[lane] = ((c - a) + (d - b)) * (1.0 / 6.0);
                }
                let (mut low, mut high) = ([f32::MAX; LANES], [f32::MIN; LANES]);
                let (mut least, mut greatest) = ([f32::MAX; LANES], [f32::MIN; LANES]);
                for (sample, looks) in looks.iter().enumerate() {
                    let [x, y] = [sample % 4, sample / 4].map(|k| k as f32 - 1.5);
                    for lane in 0..LANES {
                        let value = looks[lane];
                        let r = value - (along[lane] * x + down[lane] * y);
                        low[lane] = if r < low[lane] { r } else { low[lane] };
                        high[lane] = if r > high[lane] { r } else { high[lane] };
                        least[lane] = if value < least[lane] {
                            value
                        } else {
                            least[lane]
                        };
                        greatest[lane] = if value > greatest[lane] {
                            value
                        } else {
                            greatest[lane]
                        };
                    }
                }
                for lane in 0..LANES {
                    slopes[0][lane][c] = along[lane];
                    slopes[1][lane][c] = down[lane];
                    rest[lane][c] = [low[lane], high[lane]];
                    range[lane][c] = [least[lane], greatest[lane]];
                }
            }
            for lane in (0..LANES).filter(|lane| live >> lane & 1 != 0) {
                let of_lane = [slopes[0][lane], slopes[1][lane]];
                sixteen.fill(lane, of_lane, rest[lane], range[lane]);
            }
            sixteen.join(4.0, &mut out.parts, part);
            out.blocks[part] = sixteen;
        }
        let parts = std::mem::replace(&mut out.parts, Sixteen::NONE);
        parts.join(16.0, &mut out.tile, 0);
        out.parts = parts;
    }
}

/// (u, v, 1)·m.
#[inline(always)]
fn dot<S: Simd>([u, v]: [F<S>; 2], m: [F<S>; 3]) -> F<S> {
    (u * m[0] + v * m[1]) + m[2]
}

impl Sixteen {
    /// The blocks of which a sample may be covered by a triangle: never without one of which a sample is.
    #[inline(always)]
    pub(crate) fn may_cover<S: Simd>(&self, simd: S, t: &Target) -> LaneSet {
        let met = piece(
            simd,
            #[inline(always)]
            || self.meets(simd, t),
        );
        // To ask the bound of one block costs as much as to go on into it.
        if met.count_ones() <= 1 {
            return met;
        }
        let volume = piece(
            simd,
            #[inline(always)]
            || self.volume(simd, t),
        );
        let mut sides = volume;
        if !t.both_faces {
            sides.back = M::from_bitmask(simd, 0);
        }
        for i in 0..3 {
            let [low, high] = piece(
                simd,
                #[inline(always)]
                || self.edge(simd, t, i),
            );
            let zero = splat(simd, 0.0);
            // Only what a range shows leaves a side out; one with NaN shows nothing.
            sides.front &= !low.simd_gt(zero);
            sides.back &= !high.simd_lt(zero);
            if met & (sides.front | sides.back).to_bitmask() as LaneSet == 0 {
                return 0;
            }
        }
        met & (sides.front | sides.back).to_bitmask() as LaneSet
    }

    /// Blocks with a live sample whose box meets that of the triangle.
    #[inline(always)]
    pub(crate) fn meets<S: Simd>(&self, simd: S, t: &Target) -> LaneSet {
        let [x, y] = t.bounds;
        let met = F::from_slice(simd, &self.low[0]).simd_le(x[1])
            & F::from_slice(simd, &self.high[0]).simd_ge(x[0])
            & F::from_slice(simd, &self.low[1]).simd_le(y[1])
            & F::from_slice(simd, &self.high[1]).simd_ge(y[0]);
        met.to_bitmask() as LaneSet & self.live
    }

    #[inline(always)]
    fn load<S: Simd>(simd: S, from: &[[f32; LANES]; 3]) -> [F<S>; 3] {
        three(
            #[inline(always)]
            |c| F::from_slice(simd, &from[c]),
        )
    }

    /// The range of d·N(t).
    #[inline(always)]
    fn edge<S: Simd>(&self, simd: S, target: &Target, i: usize) -> [F<S>; 2] {
        let n = &target.edges[i];
        let size = target.sizes[i];
        let [u, v, t] = Self::load(simd, &self.centre);
        let [ru, rv, rt] = Self::load(simd, &self.residual);
        let [du, dv, dt] = Self::load(simd, &self.reach);
        let value = three(
            #[inline(always)]
            |c| match target.moves {
                true => (t * n[2][c] + n[1][c]) * t + n[0][c],
                false => splat(simd, n[0][c]),
            },
        );
        let centre = dot([u, v], value);
        let [x, y] = [&self.slopes[0], &self.slopes[1]];
        let whole = F::from_slice(simd, &self.most[0]) * size[0]
            + F::from_slice(simd, &self.most[1]) * size[1]
            + size[2];
        let rounding = F::from_slice(simd, &self.rounding) * whole + UNDERFLOW;
        let mut off = ru * value[0].abs() + rv * value[1].abs();
        let mut along = two(
            #[inline(always)]
            |axis| {
                let slope = [x, y][axis];
                F::from_slice(simd, &slope[0]) * value[0]
                    + F::from_slice(simd, &slope[1]) * value[1]
            },
        );
        if target.moves {
            let rate = three(
                #[inline(always)]
                |c| t * (n[2][c] + n[2][c]) + n[1][c],
            );
            let per_time = dot([u, v], rate);
            along = two(
                #[inline(always)]
                |axis| along[axis] + F::from_slice(simd, &[x, y][axis][2]) * per_time,
            );
            let bend = three(
                #[inline(always)]
                |c| splat(simd, n[2][c]),
            );
            let turns = du * rate[0].abs() + dv * rate[1].abs();
            let bends = dot([u, v], bend).abs() + du * bend[0].abs() + dv * bend[1].abs();
            off = off + rt * per_time.abs() + dt * (turns + dt * bends);
        }
        let off = along[0].abs() * self.extent + along[1].abs() * self.extent + off + rounding;
        [centre - off, centre + off]
    }

    /// Sides that the range of D(t) leaves.
    #[inline(always)]
    fn volume<S: Simd>(&self, simd: S, target: &Target) -> Sides<S> {
        let zero = splat(simd, 0.0);
        let [d0, d1, d2, d3] = target.volume;
        let whole = d0.abs() + d1.abs() + d2.abs() + d3.abs();
        let mut off = F::from_slice(simd, &self.rounding) * whole + UNDERFLOW;
        let mut centre = splat(simd, d0);
        if target.moves {
            let t = F::from_slice(simd, &self.centre[2]);
            let dt = F::from_slice(simd, &self.reach[2]);
            centre = ((t * d3 + d2) * t + d1) * t + d0;
            let three = d3 + d3 + d3;
            let first = (t * three + d2 + d2) * t + d1;
            let second = t * three + d2;
            off += dt * (first.abs() + dt * (second.abs() + dt * d3.abs()));
        }
        Sides {
            front: !(centre - off).simd_ge(zero),
            back: !(centre + off).simd_le(zero),
        }
    }
}
