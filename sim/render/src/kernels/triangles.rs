use fearless_simd::prelude::*;

use super::Kernel;
use super::lanes::{F, Simd, i32x8, mask32x8, piece, splat, three, two};
use crate::project::{Projection, SUBSAMPLES};
use crate::raster::{BEHIND, Emitter, EyeVertex, SetUpTriangle};

/// Largest extent of a triangle whose area fits 31 bits [sub-samples].
const LARGEST_EXTENT: i32 = 1 << 15;

/// Triangles of smaller extent [sub-samples] have edge functions of 31 bits anywhere near them.
const SMALL_EXTENT: i32 = 1 << 14;

/// Sets up triangles of one object, eight at a time. What needs more than 32 bits, or clipping, goes to
/// [`Emitter::exact`].
pub(crate) struct SetUpEight<'a, 'b> {
    pub(crate) vertices: &'a [EyeVertex],
    pub(crate) triangles: &'a [[u32; 3]],
    /// Index of the first of them in the mesh.
    pub(crate) first: u32,
    pub(crate) object: u32,
    /// Whether triangles seen from behind are drawn.
    pub(crate) both_faces: bool,
    pub(crate) emitter: &'a mut Emitter<'b>,
}

/// One corner of eight triangles.
#[derive(Clone, Copy)]
struct Corner<S: Simd> {
    /// x, y and w in eye space.
    eye: [F<S>; 3],
    /// Display position.
    px: [F<S>; 2],
    /// In sub-samples, before the whole sub-samples of the origin are subtracted; garbage where not
    /// usable.
    sub: [F<S>; 2],
    snapped: [i32x8<S>; 2],
    usable: mask32x8<S>,
}

impl Kernel for SetUpEight<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        for (k, eight) in self.triangles.chunks(8).enumerate() {
            self.eight(simd, eight, self.first + 8 * k as u32);
        }
    }
}

impl SetUpEight<'_, '_> {
    #[inline(always)]
    fn eight<S: Simd>(&mut self, simd: S, triangles: &[[u32; 3]], first: u32) {
        let projection = self.emitter.pass.projection;
        let all = 0xffu32 >> (8 - triangles.len());
        // A group that is not full repeats its last triangle.
        let mut names = [triangles[triangles.len() - 1]; 8];
        names[..triangles.len()].copy_from_slice(triangles);
        let [a, b, c] = three(
            #[inline(always)]
            |k| self.corner(simd, projection, names.map(|t| t[k])),
        );

        let usable = mask(a.usable & b.usable & c.usable) & all;
        let behind_near = a.eye[2].simd_lt(projection.near as f32)
            & b.eye[2].simd_lt(projection.near as f32)
            & c.eye[2].simd_lt(projection.near as f32);
        let gone = mask(behind_near) & all;
        self.emitter.work.triangles_outside += u64::from(gone.count_ones());

        // Bounds, and whether they hold a sample.
        let [[low_x, high_x], [low_y, high_y]] = two(
            #[inline(always)]
            |k| {
                let (a, b, c) = (a.snapped[k], b.snapped[k], c.snapped[k]);
                [a.min(b).min(c), a.max(b).max(c)]
            },
        );
        let reach = self.emitter.pass.reach;
        let first_sample = SUBSAMPLES / 2 - 1 - reach;
        let last_sample = reach - SUBSAMPLES / 2;
        let bits = SUBSAMPLES.ilog2();
        let x0 = (low_x + first_sample) >> bits;
        let x1 = (high_x + last_sample) >> bits;
        let y0 = (low_y + first_sample) >> bits;
        let y1 = (high_y + last_sample) >> bits;
        let [begin, end] = self.emitter.pass.drawn.map(|place| place.as_ivec2());
        let (first_x, first_y) = (i32x8::splat(simd, begin.x), i32x8::splat(simd, begin.y));
        let last_x = x1.min(i32x8::splat(simd, end.x - 1));
        let last_y = y1.min(i32x8::splat(simd, end.y - 1));
        let hits =
            x0.simd_le(last_x) & y0.simd_le(last_y) & x1.simd_ge(first_x) & y1.simd_ge(first_y);
        let misses = usable & !mask(hits);
        self.emitter.work.triangles_outside += u64::from(misses.count_ones());

        let tiny =
            mask((high_x - low_x).simd_lt(SMALL_EXTENT) & (high_y - low_y).simd_lt(SMALL_EXTENT));
        let small =
            (high_x - low_x).simd_lt(LARGEST_EXTENT) & (high_y - low_y).simd_lt(LARGEST_EXTENT);
        let (abx, aby) = (b.snapped[0] - a.snapped[0], b.snapped[1] - a.snapped[1]);
        let (acx, acy) = (c.snapped[0] - a.snapped[0], c.snapped[1] - a.snapped[1]);
        // Negative faces the eye: y points down.
        let area = abx * acy - acx * aby;
        let simple = usable & mask(hits & small);
        let flat = simple & mask(area.simd_eq(0));
        self.emitter.work.triangles_outside += u64::from(flat.count_ones());
        let away = simple & mask(area.simd_gt(0));
        let mut drawn = simple & !flat;
        if !self.both_faces {
            self.emitter.work.triangles_back_facing += u64::from(away.count_ones());
            drawn &= !away;
        }
        if drawn != 0 {
            let depth = depth_plane(simd, projection, [&a, &b, &c]);
            let bounds = [x0.max(first_x), last_x, y0.max(first_y), last_y];
            self.emit(drawn, away, tiny, first, [a, b, c], depth, bounds);
        }

        // The rest, one by one.
        let mut rest = all & !gone & !misses & !simple;
        while rest != 0 {
            let lane = rest.trailing_zeros();
            rest &= rest - 1;
            let corners = names[lane as usize].map(|i| &self.vertices[i as usize]);
            self.emitter
                .exact(corners, self.object, first + lane, self.both_faces);
        }
    }

    #[inline(always)]
    fn corner<S: Simd>(&self, simd: S, projection: &Projection, names: [u32; 8]) -> Corner<S> {
        piece(
            simd,
            #[inline(always)]
            || {
                let mut columns = [[0.0; 8]; 5];
                for (lane, name) in names.into_iter().enumerate() {
                    let v = &self.vertices[name as usize];
                    let [x, y, w] = v.eye;
                    for (column, value) in columns.iter_mut().zip([x, y, w, v.px[0], v.px[1]]) {
                        column[lane] = value;
                    }
                }
                let [x, y, w] = three(
                    #[inline(always)]
                    |k| F::from_slice(simd, &columns[k]),
                );
                let [u, v] = two(
                    #[inline(always)]
                    |k| F::from_slice(simd, &columns[3 + k]),
                );
                // Asked so that NaN is not usable.
                let mut usable = w.simd_ge(projection.near as f32) & w.simd_le(f32::MAX);
                let px = [u, v];
                let sub = two(
                    #[inline(always)]
                    |k| {
                        (px[k] * projection.sub_per_px[k] - projection.origin_fraction[k] + 0.5)
                            .floor()
                    },
                );
                for (k, sub) in sub.iter().enumerate() {
                    let [low, high] = projection.usable_range(k);
                    usable &= sub.simd_ge(low) & sub.simd_le(high);
                }
                // The conversion to integers is undefined for NaN and large numbers.
                let snapped = two(
                    #[inline(always)]
                    |k| {
                        let safe = usable.select(sub[k], splat(simd, 0.0));
                        safe.to_int::<i32x8<S>>() - projection.origin_whole[k]
                    },
                );
                Corner {
                    eye: [x, y, w],
                    px,
                    sub,
                    snapped,
                    usable,
                }
            },
        )
    }

    /// Writes out the triangles of the lanes in `drawn`.
    #[inline(always)]
    fn emit<S: Simd>(
        &mut self,
        drawn: u32,
        away: u32,
        tiny: u32,
        first: u32,
        corners: [Corner<S>; 3],
        depth: [F<S>; 5],
        bounds: [i32x8<S>; 4],
    ) {
        let snapped = three(
            #[inline(always)]
            |k| {
                [
                    corners[k].snapped[0].to_array(),
                    corners[k].snapped[1].to_array(),
                ]
            },
        );
        let depth = [
            depth[0].to_array(),
            depth[1].to_array(),
            depth[2].to_array(),
            depth[3].to_array(),
            depth[4].to_array(),
        ];
        let bounds = [
            bounds[0].to_array(),
            bounds[1].to_array(),
            bounds[2].to_array(),
            bounds[3].to_array(),
        ];
        self.emitter.work.triangles_set_up += u64::from(drawn.count_ones());
        let mut rest = drawn;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let behind = away >> lane & 1 != 0;
            let [a, b, c] = snapped.map(|[x, y]| [x[lane], y[lane]]);
            let [at, dx, dy, low, high] = depth.map(|v| v[lane]);
            // Seen edge-on there may be no usable slope; such a sliver is as far as its farthest
            // corner.
            let finite = at.is_finite() && dx.is_finite() && dy.is_finite();
            self.emitter.out.push(SetUpTriangle {
                corners: if behind { [a, b, c] } else { [a, c, b] },
                depth: if finite {
                    [at, dx, dy]
                } else {
                    [low, 0.0, 0.0]
                },
                depth_range: [low, high],
                bounds: [
                    [bounds[0][lane] as u16, bounds[1][lane] as u16],
                    [bounds[2][lane] as u16, bounds[3][lane] as u16],
                ],
                is_small: tiny >> lane & 1 != 0,
                is_whole: true,
                object: self.object,
                triangle: (first + lane as u32) | if behind { BEHIND } else { 0 },
            });
        }
    }
}

#[inline(always)]
fn mask<S: Simd>(m: mask32x8<S>) -> u32 {
    m.to_bitmask() as u32
}

/// 1/w at the first corner, its change per sample along x and y, its least and greatest value.
///
/// With edges e = b − a and f = c − a, whose differences single precision rounds only once, n = e × f
/// and 1/w = n·(tx, ty, 1)/(n·a). Measured from the vertex itself, of which the snapped corner is
/// never more than half a sub-sample away, nothing large is subtracted.
#[inline(always)]
fn depth_plane<S: Simd>(simd: S, projection: &Projection, [a, b, c]: [&Corner<S>; 3]) -> [F<S>; 5] {
    piece(
        simd,
        #[inline(always)]
        || {
            let e = three(
                #[inline(always)]
                |k| b.eye[k] - a.eye[k],
            );
            let f = three(
                #[inline(always)]
                |k| c.eye[k] - a.eye[k],
            );
            let nx = e[1] * f[2] - e[2] * f[1];
            let ny = e[2] * f[0] - e[0] * f[2];
            let nw = e[0] * f[1] - e[1] * f[0];
            let det = nx * a.eye[0] + ny * a.eye[1] + nw * a.eye[2];
            let one = splat(simd, 1.0);
            let inverse = [one / a.eye[2], one / b.eye[2], one / c.eye[2]];
            let (nx, ny) = (nx / det, ny / det);
            let shift = two(
                #[inline(always)]
                |k| {
                    let snapped =
                        (a.sub[k] + projection.origin_fraction[k]) * projection.px_per_sub[k];
                    (snapped - a.px[k]) * projection.tan_per_px[k]
                },
            );
            let step = projection.tangent_step();
            let at = inverse[0] + (nx * shift[0] + ny * shift[1]);
            let [p, q, r] = inverse;
            let low = super::lanes::min(super::lanes::min(p, q), r);
            let high = super::lanes::max(super::lanes::max(p, q), r);
            [at, nx * (step.x as f32), ny * (step.y as f32), low, high]
        },
    )
}
