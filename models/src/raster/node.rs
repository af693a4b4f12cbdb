use glam::UVec2;

use super::{Facing, Forms, Real, SampleTable};

/// A square block of samples: planes over the lattice for u, v and t, and how far the samples are from them.
/// `docs/bounds.md` says why [`Node::may_cover`] is never false for a covered sample; the names are its.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node<T> {
    /// u₀, v₀, t₀: the planes in the block's middle.
    centre: [T; 3],
    /// Their slopes per sample along x and along y.
    slopes: [[T; 3]; 2],
    /// E: samples from the middle to the outermost one.
    extent: T,
    /// ρ: the farthest that a live sample is from each plane.
    residual: [T; 3],
    /// Δu, Δv and T: no live sample is farther from the centre.
    reach: [T; 3],
    /// U and V: the largest sizes of u and v, of live samples and the centre.
    most: [T; 2],
    /// φ: what rounding can do, as a share of a form's size.
    rounding: T,
}

/// Which sides of a triangle a block's samples may see.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Sides {
    pub(super) front: bool,
    pub(super) back: bool,
}

/// A range that holds all values of a form in a block, if computed as [`Forms`] does.
#[derive(Clone, Copy)]
struct Range<T> {
    low: T,
    high: T,
}

impl<T: Real> Range<T> {
    fn is_positive(self) -> bool {
        self.low > T::zero()
    }

    fn is_negative(self) -> bool {
        self.high < T::zero()
    }

    /// Whether nothing in it is below 0.
    fn is_never_negative(self) -> bool {
        self.low >= T::zero()
    }

    /// Whether nothing in it is above 0.
    fn is_never_positive(self) -> bool {
        self.high <= T::zero()
    }
}

impl<T: Real> Node<T> {
    /// Of the block of `size` samples each way from `first` on; `None` if none is live.
    pub fn of(table: &SampleTable<T>, first: UVec2, size: u32) -> Option<Self> {
        let live = || table.block(first, size);
        let middle = f64::from(size - 1) / 2.0;
        let place =
            |s: UVec2| [s.x - first.x, s.y - first.y].map(|steps| f64::from(steps) - middle);
        // Any planes do; those through samples far apart lie close.
        let (mut low, mut high) = ([[f64::INFINITY; 3]; 2], [[f64::NEG_INFINITY; 3]; 2]);
        let mut ends = [[None; 2]; 2];
        for (s, looks) in live() {
            let (at, looks) = (place(s), looks.map(T::exact));
            for axis in 0..2 {
                if at[axis] < low[axis][0] {
                    (low[axis][0], ends[axis][0]) = (at[axis], Some((at, looks)));
                }
                if at[axis] > high[axis][0] {
                    (high[axis][0], ends[axis][1]) = (at[axis], Some((at, looks)));
                }
            }
        }
        let slopes = solve(ends).map(|slope| slope.map(T::nearest));
        let exact = slopes.map(|slope| slope.map(T::exact));
        let plane = |at: [f64; 2], c: usize| exact[0][c] * at[0] + exact[1][c] * at[1];
        let mut off = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
        let mut any = false;
        for (s, looks) in live() {
            any = true;
            for c in 0..3 {
                let rest = looks[c].exact() - plane(place(s), c);
                off[c] = [off[c][0].min(rest), off[c][1].max(rest)];
            }
        }
        if !any {
            return None;
        }
        let mut centre = off.map(|[low, high]| T::nearest((low + high) / 2.0));
        // Sums over powers of t count on a time from 0 to 1.
        if !(0.0..=1.0).contains(&centre[2].exact()) {
            centre[2] = T::nearest(centre[2].exact().clamp(0.0, 1.0));
        }
        let (mut residual, mut reach, mut most) = ([0.0f64; 3], [0.0f64; 3], [0.0f64; 3]);
        for c in 0..3 {
            most[c] = centre[c].exact().abs();
        }
        for (s, looks) in live() {
            for c in 0..3 {
                let away = looks[c].exact() - centre[c].exact();
                residual[c] = residual[c].max((away - plane(place(s), c)).abs());
                reach[c] = reach[c].max(away.abs());
                most[c] = most[c].max(looks[c].exact().abs());
            }
        }
        let step = |c: usize| (exact[0][c].abs() + exact[1][c].abs()) * middle;
        let mut kappa = 0.0f64;
        for c in 0..3 {
            // What these f64 differences of numbers below 2²¹ round to, many times over.
            let slack = (most[c] + step(c)) * 1e-14;
            residual[c] += slack;
            reach[c] += slack;
            let whole = if c == 2 {
                1.0
            } else {
                most[c].max(f64::MIN_POSITIVE)
            };
            kappa = kappa.max((step(c) + residual[c]).max(reach[c]) / whole);
        }
        let terms = kappa * (3.0 + kappa * (3.0 + kappa));
        Some(Self {
            centre,
            slopes,
            extent: T::nearest(middle),
            residual: residual.map(T::no_less),
            reach: reach.map(T::no_less),
            most: [most[0], most[1]].map(T::no_less),
            rounding: T::no_less(T::ROUNDOFF * (20.0 + 24.0 * terms)),
        })
    }

    /// Whether a live sample of the block may be covered. It may be true where none is; it is never false where
    /// [`Forms::covers`] finds one.
    pub fn may_cover(&self, forms: &Forms<T>) -> bool {
        let sides = self.sides(forms);
        sides.front || sides.back
    }

    /// The same side by side.
    pub(super) fn sides(&self, forms: &Forms<T>) -> Sides {
        let volume = self.volume(forms);
        // Covered is where all three edges and the volume have one sign. Only what a range shows leaves a
        // side out; one with NaN shows nothing.
        let mut sides = Sides {
            front: !volume.is_never_negative(),
            back: forms.facing() == Facing::Both && !volume.is_never_positive(),
        };
        for i in 0..3 {
            if !(sides.front || sides.back) {
                break;
            }
            let edge = self.edge(&forms.edges[i]);
            sides.front &= !edge.is_positive();
            sides.back &= !edge.is_negative();
        }
        sides
    }

    /// The range of d·N(t).
    fn edge(&self, n: &[[T; 3]; 3]) -> Range<T> {
        let ([u, v, t], [du, dv, dt]) = (self.centre, self.reach);
        // N and N′ at t₀.
        let value = [0, 1, 2].map(|c| (n[2][c] * t + n[1][c]) * t + n[0][c]);
        let rate = [0, 1, 2].map(|c| (n[2][c] + n[2][c]) * t + n[1][c]);
        let dot = |m: [T; 3]| u * m[0] + v * m[1] + m[2];
        let (centre, per_time) = (dot(value), dot(rate));
        let along = |slope: [T; 3]| {
            (slope[0] * value[0] + slope[1] * value[1] + slope[2] * per_time).size() * self.extent
        };
        let [ru, rv, rt] = self.residual;
        let off = ru * value[0].size() + rv * value[1].size() + rt * per_time.size();
        let turns = du * rate[0].size() + dv * rate[1].size();
        let bends = dot(n[2]).size() + du * n[2][0].size() + dv * n[2][1].size();
        let second = dt * (turns + dt * bends);
        let size = |c: usize| n[0][c].size() + n[1][c].size() + n[2][c].size();
        let whole = self.most[0] * size(0) + self.most[1] * size(1) + size(2);
        self.range(
            centre,
            along(self.slopes[0]) + along(self.slopes[1]) + off + second,
            whole,
        )
    }

    /// The range of D(t).
    fn volume(&self, forms: &Forms<T>) -> Range<T> {
        let ([_, _, t], [_, _, dt]) = (self.centre, self.reach);
        let [d0, d1, d2, d3] = forms.volume;
        let three = d3 + d3 + d3;
        let first = (three * t + d2 + d2) * t + d1;
        let second = three * t + d2;
        let off = dt * (first.size() + dt * (second.size() + dt * d3.size()));
        let whole = d0.size() + d1.size() + d2.size() + d3.size();
        self.range(forms.volume(t), off, whole)
    }

    /// centre ± (off + rounding).
    fn range(&self, centre: T, off: T, whole: T) -> Range<T> {
        let off = off + (self.rounding * whole + T::nearest(T::UNDERFLOW));
        Range {
            low: centre - off,
            high: centre + off,
        }
    }
}

/// A sample's place in its block, and u, v and t.
type Placed = ([f64; 2], [f64; 3]);

/// The slopes that meet the differences between the outermost samples along each axis; none where there are not
/// two, or they lie in line.
fn solve(ends: [[Option<Placed>; 2]; 2]) -> [[f64; 3]; 2] {
    let apart = ends.map(|ends| match ends {
        [Some((a, from)), Some((b, to))] => (
            [b[0] - a[0], b[1] - a[1]],
            [to[0] - from[0], to[1] - from[1], to[2] - from[2]],
        ),
        _ => ([0.0; 2], [0.0; 3]),
    });
    let [([ax, ay], a), ([bx, by], b)] = apart;
    let area = ax * by - ay * bx;
    if area != 0.0 {
        return [
            [0, 1, 2].map(|c| (a[c] * by - b[c] * ay) / area),
            [0, 1, 2].map(|c| (b[c] * ax - a[c] * bx) / area),
        ];
    }
    let along = |length: f64, rise: [f64; 3]| match length == 0.0 {
        true => [0.0; 3],
        false => rise.map(|r| r / length),
    };
    [
        along(if ay == 0.0 { ax } else { 0.0 }, a),
        along(if bx == 0.0 { by } else { 0.0 }, b),
    ]
}
