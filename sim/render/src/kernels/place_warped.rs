use fearless_simd::prelude::*;
use foveasim_models::{Affine, Falloff, Lens, Radial, Reach, ScanSkew};
use glam::{DVec2, UVec2};

use super::lanes::{Simd, two};
use super::wide::{F, I, WIDTH, max, min, piece, splat};
use super::{Kernel, transcendental::log2, transcendental::times_exp2};
use crate::project::SUBSAMPLES;
use crate::tile::{BLOCK, LANES, position_of};

/// From lattice to display by sums and products alone, and for a radial map one power.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Plain {
    /// Origin and scale.
    Affine([f32; 2], [f32; 2]),
    /// A power about the gaze.
    Radial(Magnified),
}

/// A radial map of a power in single precision.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Magnified {
    /// Origin of the buffer less the gaze \[px\]: small where precision counts.
    origin: [f32; 2],
    gaze: [f32; 2],
    /// Buffer pixels per lattice step.
    per_step: f32,
    exponent: f32,
    /// One over the reach \[1/px\]; none where it is that of the boundary.
    per_reach: Option<f32>,
    /// One over the way from the gaze to the left and upper, and to the right and lower edge \[1/px\].
    per_room: [[f32; 2]; 2],
}

/// When and through what display positions are seen.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen {
    /// The time of display position 0, 0, and how much later a pixel on along x and y lights.
    time: [f32; 3],
    lens: Option<SingleLens>,
}

#[derive(Debug, Clone, Copy)]
struct SingleLens {
    centre: [f32; 2],
    per_unit: f32,
    k: [f32; 2],
}

/// Finds where and when the samples of a tile look, in single precision: positions are off by less than 10⁻³
/// pixels (displays up to 4,000 pixels), and then rounded to sub-samples.
pub(crate) struct PlaceWarped<'a> {
    pub(crate) plain: Plain,
    pub(crate) seen: Seen,
    /// Lattice position of the tile's first sample, where it is taken.
    pub(crate) first: [f32; 2],
    /// Most steps that a sample of the tile may lie from it: lanes beyond the lattice repeat its last.
    pub(crate) last: [f32; 2],
    /// Whether positions off the display are moved onto its edge: the display's size \[px\].
    pub(crate) onto: Option<[f32; 2]>,
    /// Image positions of each block \[sub-samples\].
    pub(crate) at: &'a mut [[[i32; LANES]; 2]],
    /// Times; none where all are at the start.
    pub(crate) time: &'a mut [[f32; LANES]],
    /// Over how many pixels of the image samples average: the longer step between them, at least a pixel.
    pub(crate) width: &'a mut [[f32; LANES]],
}

/// Positions are at most so far off the image's corner \[px\], so that sub-samples are exact in single precision.
const FARTHEST_PX: f32 = 65_535.0;

impl Plain {
    /// An affine map.
    pub(crate) fn affine(map: &Affine) -> Self {
        Self::Affine(single(map.origin), single(map.scale))
    }

    /// A radial map; `None` if it is one of a table.
    pub(crate) fn radial(map: &Radial, display: UVec2) -> Option<Self> {
        let Falloff::Power(exponent) = map.falloff() else {
            return None;
        };
        let (gaze, room) = (map.gaze_px(), display.as_dvec2() - map.gaze_px());
        let corner = gaze.max(room);
        let per_reach = match map.reach() {
            Reach::Px(px) => Some(1.0 / px),
            Reach::Corner => Some(1.0 / corner.length().max(0.5)),
            _ => None,
        };
        Some(Self::Radial(Magnified {
            origin: single(-map.gaze() / map.scale()),
            gaze: single(gaze),
            per_step: (1.0 / map.scale()) as f32,
            exponent: exponent as f32,
            per_reach: per_reach.map(|r| r as f32),
            per_room: [single(1.0 / gaze), single(1.0 / room)],
        }))
    }
}

impl Seen {
    pub(crate) fn new(scan: Option<&ScanSkew>, lens: Option<&Lens>, display: UVec2) -> Self {
        let time = scan.map_or([0.0; 3], |scan| {
            let later = scan.direction() / display.as_dvec2();
            [scan.start(), later.x, later.y].map(|t| t as f32)
        });
        let lens = lens.map(|lens| SingleLens {
            centre: single(lens.centre_px()),
            per_unit: (1.0 / lens.unit_px()) as f32,
            k: lens.coefficients().map(|k| k as f32),
        });
        Self { time, lens }
    }
}

fn single(v: DVec2) -> [f32; 2] {
    [v.x as f32, v.y as f32]
}

/// A place, and the steps along the lattice's x and y there.
struct Placed<S: Simd> {
    at: [F<S>; 2],
    steps: [[F<S>; 2]; 2],
}

impl Kernel for PlaceWarped<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let columns: [f32; WIDTH] = std::array::from_fn(|k| (k % BLOCK[0] as usize) as f32);
        let rows: [f32; WIDTH] = std::array::from_fn(|k| (k / BLOCK[0] as usize) as f32);
        let within = [F::from_slice(simd, &columns), F::from_slice(simd, &rows)];
        for block in 0..self.at.len() {
            let [x, y] = position_of(block * LANES).map(|c| c as f32);
            let from = [x, y];
            let lattice = two(
                #[inline(always)]
                |k| {
                    let steps = within[k] + from[k];
                    min(steps, splat(simd, self.last[k])) + self.first[k]
                },
            );
            let mut placed = piece(
                simd,
                #[inline(always)]
                || self.plain.place(simd, lattice),
            );
            if let Some(size) = self.onto {
                placed.at = two(
                    #[inline(always)]
                    |k| min(max(placed.at[k], splat(simd, 0.0)), splat(simd, size[k])),
                );
            }
            if let Some(time) = self.time.get_mut(block) {
                let [start, x, y] = self.seen.time;
                let t = placed.at[0] * x + placed.at[1] * y + start;
                let t = min(max(t, splat(simd, 0.0)), splat(simd, 1.0));
                t.store_slice(time);
            }
            if let Some(lens) = self.seen.lens {
                placed = piece(
                    simd,
                    #[inline(always)]
                    || lens.look(simd, placed),
                );
            }
            for k in 0..2 {
                let far = splat(simd, FARTHEST_PX);
                let px = min(max(placed.at[k], splat(simd, -FARTHEST_PX)), far);
                let sub = (px * SUBSAMPLES as f32 + 0.5).floor();
                sub.to_int::<I<S>>().store_slice(&mut self.at[block][k]);
            }
            let [a, b] = two(
                #[inline(always)]
                |k| {
                    let [x, y] = placed.steps[k];
                    (x * x + y * y).sqrt()
                },
            );
            max(max(a, b), splat(simd, 1.0)).store_slice(&mut self.width[block]);
        }
    }
}

impl Plain {
    #[inline(always)]
    fn place<S: Simd>(&self, simd: S, lattice: [F<S>; 2]) -> Placed<S> {
        let zero = splat(simd, 0.0);
        match self {
            Self::Affine(origin, scale) => Placed {
                at: two(
                    #[inline(always)]
                    |k| lattice[k] * scale[k] + origin[k],
                ),
                steps: [[splat(simd, scale[0]), zero], [zero, splat(simd, scale[1])]],
            },
            Self::Radial(map) => map.place(simd, lattice),
        }
    }
}

impl Magnified {
    #[inline(always)]
    fn place<S: Simd>(&self, simd: S, lattice: [F<S>; 2]) -> Placed<S> {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let [ax, ay] = two(
            #[inline(always)]
            |k| lattice[k] * self.per_step + self.origin[k],
        );
        // The share of the reach, and how it grows per pixel.
        let (s, grows) = match self.per_reach {
            Some(per_reach) => {
                let length = (ax * ax + ay * ay).sqrt();
                let per = one / max(length, splat(simd, 1e-20)) * per_reach;
                (length * per_reach, [ax * per, ay * per])
            }
            None => {
                let [[left, up], [right, down]] = self.per_room;
                let share = |a: F<S>, [before, after]: [f32; 2]| {
                    let ahead = a.simd_gt(zero).select(a * after, zero);
                    let back = a.simd_lt(zero).select(a * -before, zero);
                    ahead + back
                };
                let (x, y) = (share(ax, [left, right]), share(ay, [up, down]));
                let along_x = x.simd_ge(y);
                let of_x = along_x.select(x / ax, zero);
                let of_y = along_x.select(zero, y / ay);
                (max(x, y), [of_x, of_y])
            }
        };
        // Off the display from a gaze on its edge there is no reach, and nothing is magnified.
        let is_finite = s.simd_lt(1e6) & s.simd_gt(0.0);
        let safe = is_finite.select(s, one);
        let k = self.exponent;
        let power = if k == 2.0 {
            safe
        } else if k == 3.0 {
            safe * safe
        } else {
            piece(
                simd,
                #[inline(always)]
                || times_exp2(one, log2(safe) * (k - 1.0)),
            )
        };
        let ratio = is_finite.select(power, s.simd_gt(0.0).select(one, zero));
        // a/s·(p′ − p/s) = a·ratio·(k − 1)/s
        let bends = is_finite.select(ratio * (k - 1.0) / safe, zero);
        let step = self.per_step;
        let out = [ax * bends, ay * bends];
        let grows = two(
            #[inline(always)]
            |k| is_finite.select(grows[k], zero),
        );
        Placed {
            at: [ax * ratio + self.gaze[0], ay * ratio + self.gaze[1]],
            steps: [
                [(out[0] * grows[0] + ratio) * step, out[1] * grows[0] * step],
                [out[0] * grows[1] * step, (out[1] * grows[1] + ratio) * step],
            ],
        }
    }
}

impl SingleLens {
    #[inline(always)]
    fn look<S: Simd>(&self, simd: S, placed: Placed<S>) -> Placed<S> {
        let [ax, ay] = two(
            #[inline(always)]
            |k| placed.at[k] - self.centre[k],
        );
        let square = ax * ax + ay * ay;
        let r2 = square * (self.per_unit * self.per_unit);
        let [k1, k2] = self.k;
        let more = (r2 * k2 + k1) * r2;
        // (r·growth)′ − growth, along the radius.
        let along = (r2 * (4.0 * k2) + 2.0 * k1) * r2 / max(square, splat(simd, 1e-20));
        let growth = more + 1.0;
        Placed {
            at: [ax * more + placed.at[0], ay * more + placed.at[1]],
            steps: two(
                #[inline(always)]
                |k| {
                    let [x, y] = placed.steps[k];
                    let outwards = (ax * x + ay * y) * along;
                    [x * growth + ax * outwards, y * growth + ay * outwards]
                },
            ),
        }
    }
}
