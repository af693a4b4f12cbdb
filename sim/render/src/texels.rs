use foveasim_models::{Image, Region};
use glam::UVec2;
use rayon::prelude::*;

use crate::memory::Pool;

/// Where no sample is live.
const DEAD: [f32; 4] = [0.0; 4];

/// A pass as reconstruction reads it: colours, and 1 in the fourth place where a sample is live; else
/// nothing but zeros.
#[derive(Debug, Clone)]
pub(crate) struct Texels {
    pub(crate) size: UVec2,
    /// Whether the last row borders on the first.
    pub(crate) wraps: bool,
    pub(crate) rgba: Vec<[f32; 4]>,
}

impl Texels {
    pub(crate) fn new(
        image: &Image,
        region: &Region,
        wraps: bool,
        memory: &mut Pool<[f32; 4]>,
    ) -> Self {
        let size = image.size;
        let mut rgba = memory.any(image.rgb.len(), DEAD);
        let rows = rgba.par_chunks_mut(size.x.max(1) as usize);
        let from = image.rgb.par_chunks(size.x.max(1) as usize);
        rows.zip(from).enumerate().for_each(|(y, (out, row))| {
            let copy = |out: &mut [f32; 4], [r, g, b]: [f32; 3]| *out = [r, g, b, 1.0];
            match region {
                Region::Spans(spans) => {
                    let live = spans.row(y as u32);
                    let live = live.start as usize..live.end as usize;
                    out[..live.start].fill(DEAD);
                    out[live.end..].fill(DEAD);
                    for (out, rgb) in out[live.clone()].iter_mut().zip(&row[live]) {
                        copy(out, *rgb);
                    }
                }
                _ => {
                    for (x, (out, rgb)) in out.iter_mut().zip(row).enumerate() {
                        match region.is_live(UVec2::new(x as u32, y as u32)) {
                            true => copy(out, *rgb),
                            false => *out = DEAD,
                        }
                    }
                }
            }
        });
        Self { size, wraps, rgba }
    }

    /// The row at a place that may lie beyond the lattice.
    #[inline(always)]
    pub(crate) fn row_at(&self, y: i64) -> u32 {
        let rows = i64::from(self.size.y);
        match self.wraps {
            true => y.rem_euclid(rows) as u32,
            false => y.clamp(0, rows - 1) as u32,
        }
    }

    #[inline(always)]
    pub(crate) fn at(&self, x: u32, y: u32) -> [f32; 4] {
        self.rgba[y as usize * self.size.x as usize + x as usize]
    }

    /// The texel at a place that may lie beyond the lattice.
    #[inline(always)]
    pub(crate) fn near(&self, x: i64, y: i64) -> [f32; 4] {
        let column = x.clamp(0, i64::from(self.size.x) - 1);
        self.at(column as u32, self.row_at(y))
    }

    /// These, and halved copies down to where `density` samples of the first have become one along each side, or to
    /// one texel.
    pub(crate) fn chain(self, density: f32, memory: &mut Pool<[f32; 4]>) -> Vec<Self> {
        let mut levels = vec![self];
        let mut left = density;
        while left > 1.0 {
            let last = &levels[levels.len() - 1];
            if last.size.max_element() <= 1 {
                break;
            }
            let half = last.halved(memory);
            levels.push(half);
            left /= 2.0;
        }
        levels
    }

    /// Means of the live ones of two by two texels; a last row or column may stand alone.
    fn halved(&self, memory: &mut Pool<[f32; 4]>) -> Self {
        let size = (self.size + 1) / 2;
        let mut rgba = memory.any(size.x as usize * size.y as usize, DEAD);
        let rows = rgba.par_chunks_mut(size.x.max(1) as usize).enumerate();
        rows.for_each(|(y, row)| {
            for (x, out) in row.iter_mut().enumerate() {
                let (x, y) = (2 * x as u32, 2 * y as u32);
                let ends = (self.size - 1).min(UVec2::new(x + 1, y + 1));
                let of = [(x, y), (ends.x, y), (x, ends.y), (ends.x, ends.y)];
                let of = of.map(|(x, y)| self.at(x, y));
                let Some(own) = of.into_iter().find(|t| t[3] != 0.0) else {
                    *out = DEAD;
                    continue;
                };
                let mut sum = Sum::around(own);
                for texel in of {
                    sum.add(texel, 1.0);
                }
                let [r, g, b] = sum.mean();
                *out = [r, g, b, 1.0];
            }
        });
        Self {
            size,
            wraps: self.wraps,
            rgba,
        }
    }

    /// The texels from column `first` on smoothed by (1 2 1)·(1 2 1)/16, of live neighbours only.
    pub(crate) fn smoothed(&self, first: u32, memory: &mut Pool<[f32; 4]>) -> Self {
        let mut rgba = memory.any(self.rgba.len(), DEAD);
        let width = self.size.x.max(1) as usize;
        rgba.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            let begin = y * width;
            row.copy_from_slice(&self.rgba[begin..begin + row.len()]);
            let rows = [-1, 0, 1].map(|d| self.row_at(y as i64 + d));
            for (x, out) in row.iter_mut().enumerate().skip(first as usize) {
                if out[3] == 0.0 {
                    continue;
                }
                let own = *out;
                let mut sum = Sum::around(own);
                for (row, across) in rows.into_iter().zip([1.0, 2.0, 1.0]) {
                    for (k, along) in [1.0, 2.0, 1.0].into_iter().enumerate() {
                        let x = (x + k).saturating_sub(1).min(width - 1);
                        sum.add(self.at(x as u32, row), along * across);
                    }
                }
                let [r, g, b] = sum.mean();
                *out = [r, g, b, 1.0];
            }
        });
        Self { rgba, ..*self }
    }

    /// The mean of the live ones in a rectangle; `own` is one that counts in any case.
    pub(crate) fn mean(&self, own: [u32; 2], across: Stretch, down: Stretch) -> [f32; 3] {
        let mut sum = Sum::around(self.live_near(own[0], own[1]));
        for (y, height) in down.places() {
            let row = self.row_at(y);
            for (x, width) in across.places() {
                let column = x.clamp(0, i64::from(self.size.x) - 1);
                sum.add(self.at(column as u32, row), width * height);
            }
        }
        sum.mean()
    }

    /// The texel at column `x` and row `y` if it is live; else the nearest that is. The cell of a pixel is
    /// live; but places of pixels are rounded, and then it may be the neighbour's.
    pub(crate) fn live_near(&self, x: u32, y: u32) -> [f32; 4] {
        let own = self.at(x, y);
        if own[3] != 0.0 {
            return own;
        }
        self.search(x, y)
    }

    #[cold]
    fn search(&self, x: u32, y: u32) -> [f32; 4] {
        let (x, y) = (i64::from(x), i64::from(y));
        for away in 1..=i64::from(self.size.max_element()) {
            for dy in -away..=away {
                let step = if dy.abs() == away { 1 } else { 2 * away };
                let mut dx = -away;
                while dx <= away {
                    let column = (x + dx).clamp(0, i64::from(self.size.x) - 1);
                    let texel = self.at(column as u32, self.row_at(y + dy));
                    if texel[3] != 0.0 {
                        return texel;
                    }
                    dx += step;
                }
            }
        }
        [0.0; 4]
    }
}

/// Texels along one axis, and how much each counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Stretch {
    /// So many from a first one on, all alike.
    Run(i64, u32),
    /// The two beside a place, and the share of the second.
    Between(i64, f32),
}

impl Stretch {
    /// The two beside lattice position `at`.
    pub(crate) fn beside(at: f64) -> Self {
        let low = (at - 0.5).floor();
        Self::Between(low as i64, (at - 0.5 - low) as f32)
    }

    /// How many texels are read.
    pub(crate) fn count(self) -> u64 {
        match self {
            Self::Run(_, count) => count.into(),
            Self::Between(..) => 2,
        }
    }

    fn places(self) -> impl Iterator<Item = (i64, f32)> {
        let (first, weights) = match self {
            Self::Run(first, _) => (first, [1.0, 1.0]),
            Self::Between(first, share) => (first, [1.0 - share, share]),
        };
        (0..self.count() as usize).map(move |k| (first + k as i64, weights[k.min(1)]))
    }
}

/// A weighted mean of live texels, as a colour and the mean difference from it: of equal colours it is that
/// colour, bit for bit.
pub(crate) struct Sum {
    own: [f32; 4],
    difference: [f32; 3],
    weight: f32,
}

impl Sum {
    #[inline(always)]
    pub(crate) fn around(own: [f32; 4]) -> Self {
        Self {
            own,
            difference: [0.0; 3],
            weight: 0.0,
        }
    }

    #[inline(always)]
    pub(crate) fn add(&mut self, texel: [f32; 4], weight: f32) {
        if texel[3] != 0.0 {
            self.weight += weight;
            for (c, difference) in self.difference.iter_mut().enumerate() {
                *difference += weight * (texel[c] - self.own[c]);
            }
        }
    }

    /// The colour itself if nothing was added.
    #[inline(always)]
    pub(crate) fn mean(&self) -> [f32; 3] {
        let weight = if self.weight > 0.0 { self.weight } else { 1.0 };
        std::array::from_fn(
            #[inline(always)]
            |c| self.own[c] + self.difference[c] / weight,
        )
    }
}
