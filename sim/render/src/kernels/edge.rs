use crate::project::SUBSAMPLES;
use crate::tile::{CELL, TILE};

/// An edge function over the samples of a tile, at each position of visibility, in units of the
/// sub-sample grid divided by 256: at sample (x, y) it is `at_origin + x·step[0] + y·step[1]`, and its
/// sign is exact.
///
/// Between neighbouring samples an edge function changes by multiples of 256, so all its values at one
/// position are congruent mod 256 and the low 8 bits can be dropped without losing the sign.
#[derive(Clone, Copy)]
pub(super) struct Edge<const P: usize> {
    at_origin: [i32; P],
    pub(super) step: [i32; 2],
}

impl<const P: usize> Edge<P> {
    /// Inside everywhere.
    const ACCEPTED: Self = Self {
        at_origin: [0; P],
        step: [0, 0],
    };

    /// The edge from `a` to `b`; `None` if no sample of the tile at sample `origin` is inside.
    #[inline(always)]
    pub(super) fn new(
        a: [i32; 2],
        b: [i32; 2],
        origin: [i32; 2],
        offsets: &[[i32; 2]; P],
    ) -> Option<Self> {
        let d = [
            i64::from(b[0]) - i64::from(a[0]),
            i64::from(b[1]) - i64::from(a[1]),
        ];
        let half = SUBSAMPLES / 2;
        let p = [0, 1].map(|k| {
            i64::from(origin[k]) * i64::from(SUBSAMPLES) + i64::from(half) - i64::from(a[k])
        });
        // Top-left rule: a sample exactly on an edge belongs to the triangle below or right of it.
        let top_left = d[1] < 0 || (d[1] == 0 && d[0] > 0);
        let value = d[0] * p[1] - d[1] * p[0] - i64::from(!top_left);
        let values = offsets.map(|o| {
            (value + d[0] * i64::from(o[1]) - d[1] * i64::from(o[0])) >> SUBSAMPLES.ilog2()
        });
        let step = [-d[1], d[0]];
        let last = i64::from(TILE) - 1;
        let reach = |pick: fn(i64, i64) -> i64| {
            let value = values.into_iter().reduce(pick).unwrap_or(0);
            value + pick(0, step[0] * last) + pick(0, step[1] * last)
        };
        if reach(Ord::max) < 0 {
            return None;
        }
        if reach(Ord::min) >= 0 {
            return Some(Self::ACCEPTED);
        }
        // It crosses the tile, so |value| is at most 64·(|step x| + |step y|) < 2³¹ (see GUARD_SAMPLES).
        Some(Self {
            at_origin: values.map(|v| v as i32),
            step: step.map(|s| s as i32),
        })
    }

    #[inline(always)]
    pub(super) fn at(&self, p: usize, x: i32, y: i32) -> i32 {
        self.at_origin[p] + x * self.step[0] + y * self.step[1]
    }

    /// Greatest and least value in the cell whose first sample is (x, y).
    #[inline(always)]
    pub(super) fn over_cell(&self, x: i32, y: i32) -> [i32; 2] {
        let [dx, dy] = self.step.map(|s| s * (CELL - 1));
        let (mut high, mut low) = (i32::MIN, i32::MAX);
        for p in 0..P {
            let value = self.at(p, x, y);
            high = high.max(value);
            low = low.min(value);
        }
        [high + dx.max(0) + dy.max(0), low + dx.min(0) + dy.min(0)]
    }
}
