use std::ops::Range;

use fearless_simd::f32x4;
use fearless_simd::prelude::*;
use foveasim_models::{Affine, Feather, Image, Lattice, Map, View, Work};
use glam::{DVec2, UVec2};

use crate::kernels::Kernel;
use crate::kernels::lanes::{self, F, max, put_triple, saturate, splat, triple};

/// A pass as reconstruction sees it.
pub(crate) struct Layer<'a> {
    size: UVec2,
    map: Affine,
    image: &'a Image,
    /// Display pixel of the first sample, where samples are display pixels.
    aligned: Option<[i64; 2]>,
    /// For each pixel of a row, the first of the two samples beside it and the share of the second one.
    columns: Vec<(u32, f32)>,
}

/// The two samples beside a pixel along one axis, and the share of the second one.
type Beside = (u32, u32, f32);

impl<'a> Layer<'a> {
    pub(crate) fn new(lattice: Lattice, map: Map, image: &'a Image, width: u32) -> Self {
        let (Lattice::Grid(size), Map::Affine(map)) = (lattice, map) else {
            unreachable!("only affine grids pass the checks")
        };
        let on_grid = map.scale == DVec2::ONE && map.origin == map.origin.floor();
        let aligned = on_grid.then_some([map.origin.x as i64, map.origin.y as i64]);
        let mut layer = Self {
            size,
            map,
            image,
            aligned,
            columns: Vec::new(),
        };
        if aligned.is_none() && layer.samples() > 0 {
            layer.columns = (0..width)
                .map(|x| layer.beside(0, f64::from(x) + 0.5))
                .map(|(low, _, share)| (low, share))
                .collect();
        }
        layer
    }

    /// The two samples beside display position `c` along `axis`, clamped to the lattice, and the
    /// share of the second one.
    #[inline(always)]
    fn beside(&self, axis: usize, c: f64) -> Beside {
        let last = self.size[axis] - 1;
        let p = ((c - self.map.origin[axis]) / self.map.scale[axis] - 0.5).clamp(0.0, last.into());
        let low = p as u32;
        (low, (low + 1).min(last), (p - f64::from(low)) as f32)
    }
}

/// Memory of a thread.
#[derive(Default)]
pub(crate) struct RowScratch {
    /// Per layer but the last, its weight at each pixel of the row.
    weights: Vec<Vec<f32>>,
    /// Per layer but the last, columns outside which its weight is zero.
    columns: Vec<Range<usize>>,
    /// Per layer, its samples between the two rows beside the pixels', and the last one again: what is
    /// left is to interpolate along the row. Empty where nothing of it shows.
    between: Vec<Vec<f32>>,
}

/// Makes a row of the image from layers that are blended by eccentricity.
pub(crate) struct ResolveRow<'a> {
    pub(crate) view: &'a View,
    pub(crate) feather: &'a Feather,
    pub(crate) layers: &'a [Layer<'a>],
    pub(crate) y: u32,
    pub(crate) row: &'a mut [[f32; 3]],
    pub(crate) scratch: &'a mut RowScratch,
}

impl Kernel for ResolveRow<'_> {
    type Output = Work;

    #[inline(always)]
    fn run<S: lanes::Simd>(mut self, simd: S) -> Work {
        self.weights(simd);
        let y = f64::from(self.y) + 0.5;
        let between = &mut self.scratch.between;
        between.resize(self.layers.len(), Vec::new());
        for (k, (layer, between)) in self.layers.iter().zip(between).enumerate() {
            let columns = self.scratch.columns.get(k);
            let shows = columns.is_none_or(|columns| !columns.is_empty());
            if shows && layer.aligned.is_none() && layer.samples() > 0 {
                layer.blend_rows(simd, layer.beside(1, y), between);
            }
        }
        // Outside what any inner layer reaches, the outermost stands alone.
        let shown = self.inner_columns();
        let mut work = Work {
            pixels_resolved: self.row.len() as u64,
            ..Work::default()
        };
        let (start, end) = (shown.start, shown.end);
        // In the order of columns, as triples are to be stored.
        self.outermost(simd, 0..start, &mut work);
        self.several(simd, shown, &mut work);
        self.outermost(simd, end..self.row.len(), &mut work);
        work
    }
}

impl ResolveRow<'_> {
    /// Columns outside which only the outermost layer shows.
    #[inline(always)]
    fn inner_columns(&self) -> Range<usize> {
        let mut all = 0..0;
        for (columns, layer) in self.scratch.columns.iter().zip(self.layers) {
            if columns.is_empty() || layer.samples() == 0 {
                continue;
            }
            all = if all.is_empty() {
                columns.clone()
            } else {
                all.start.min(columns.start)..all.end.max(columns.end)
            };
        }
        all
    }

    /// Fills `columns` with the outermost layer.
    #[inline(always)]
    fn outermost<S: lanes::Simd>(&mut self, simd: S, columns: Range<usize>, work: &mut Work) {
        let outer = self.layers.len() - 1;
        let (layer, between) = (&self.layers[outer], &self.scratch.between[outer]);
        let out = self.row.as_flattened_mut();
        for x in columns {
            let at = [x, self.y as usize];
            let colour = layer.fetch(simd, at, between, &mut work.resolve_fetches);
            put_triple(out, x, colour);
        }
    }

    /// Fills `columns`, where several layers may show.
    #[inline(always)]
    fn several<S: lanes::Simd>(&mut self, simd: S, columns: Range<usize>, work: &mut Work) {
        let (layers, y) = (self.layers, self.y as usize);
        let RowScratch {
            weights, between, ..
        } = &*self.scratch;
        for x in columns {
            // From the innermost layer that hides all beyond it, inwards.
            let mut k = 0;
            while k < weights.len() && (weights[k][x] != 1.0 || layers[k].samples() == 0) {
                k += 1;
            }
            let mut colour = layers[k].fetch(simd, [x, y], &between[k], &mut work.resolve_fetches);
            while k > 0 {
                k -= 1;
                let w = weights[k][x];
                if w > 0.0 && layers[k].samples() > 0 {
                    let inner =
                        layers[k].fetch(simd, [x, y], &between[k], &mut work.resolve_fetches);
                    colour += (inner - colour) * w;
                }
            }
            put_triple(self.row.as_flattened_mut(), x, colour);
        }
    }

    /// Weights of all layers but the last along the row: 1 up to the inner edge's tangent of
    /// eccentricity, 0 from the outer one's on, smoothstep between.
    #[inline(always)]
    fn weights<S: lanes::Simd>(&mut self, simd: S) {
        let optics = &self.view.optics;
        let step = optics.pixel_tan();
        let gaze = self.feather.gaze;
        let ty = optics.tan[2] - step.y * (f64::from(self.y) + 0.5);
        // With the gaze g and the ray d = (tx, ty, −1): tan e = |d × g| / d·g.
        let along_rest = (ty * gaze.y - gaze.z) as f32;
        let cross_x_rest = (ty * gaze.z + gaze.y) as f32;
        let width = self.row.len();
        let edges = &self.feather.edges_tan;
        let RowScratch {
            weights, columns, ..
        } = &mut *self.scratch;
        weights.resize(edges.len(), Vec::new());
        for row in &mut *weights {
            row.clear();
            row.resize(width.next_multiple_of(8), 0.0);
        }
        columns.clear();
        columns.resize(edges.len(), 0..0);
        let g = gaze.to_array().map(|c| c as f32);
        // Beyond the outermost edge all weights are zero, and whether a pixel lies there is cheap to ask;
        // the margin is far above rounding.
        let edge = edges.iter().map(|e| e[1] as f32);
        let farthest = edge.fold(0.0f32, |a, b| if b > a { b } else { a });
        let limit = farthest * farthest * 1.001;
        for start in (0..width).step_by(8) {
            let lanes = [0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5];
            let x = F::from_slice(simd, &lanes) + start as f32;
            let tx = x * (step.x as f32) + (optics.tan[0] as f32);
            let along = tx * g[0] + along_rest;
            let cross_y = -tx * g[2] - g[0];
            let cross_z = tx * g[1] - (ty as f32) * g[0];
            let squares = cross_y * cross_y + cross_z * cross_z + cross_x_rest * cross_x_rest;
            let ahead = along.simd_gt(0.0);
            let near = if limit.is_finite() {
                ahead & squares.simd_le(along * along * limit)
            } else {
                ahead
            };
            if !near.any_true() {
                continue;
            }
            let tan = squares.sqrt() / max(along, splat(simd, f32::MIN_POSITIVE));
            let tan = ahead.select(tan, splat(simd, f32::INFINITY));
            for (k, [from, to]) in edges.iter().enumerate() {
                let (from, to) = (*from as f32, *to as f32);
                let weight = if to - from > 0.0 && to.is_finite() {
                    let t = saturate((splat(simd, to) - tan) / (to - from));
                    t * t * (splat(simd, 3.0) - t * 2.0)
                } else {
                    tan.simd_lt(to).select(splat(simd, 1.0), splat(simd, 0.0))
                };
                weight.store_slice(&mut weights[k][start..start + 8]);
                if weight.simd_gt(0.0).any_true() {
                    let end = (start + 8).min(width);
                    let so_far = columns[k].clone();
                    let first = if so_far.end == 0 { start } else { so_far.start };
                    columns[k] = first..end;
                }
            }
        }
    }
}

impl Layer<'_> {
    fn samples(&self) -> usize {
        self.image.rgb.len()
    }

    /// Interpolates between two rows of samples. The last sample is there twice, and one number more.
    #[inline(always)]
    fn blend_rows<S: lanes::Simd>(&self, simd: S, (y0, y1, share): Beside, out: &mut Vec<f32>) {
        let stride = self.size.x as usize;
        let row = |y: u32| self.image.rgb[y as usize * stride..][..stride].as_flattened();
        let (upper, lower) = (row(y0), row(y1));
        out.resize(upper.len() + 4, 0.0);
        let whole = upper.len() / 8 * 8;
        for start in (0..whole).step_by(8) {
            let a = F::from_slice(simd, &upper[start..start + 8]);
            let b = F::from_slice(simd, &lower[start..start + 8]);
            (a + (b - a) * share).store_slice(&mut out[start..start + 8]);
        }
        for i in whole..upper.len() {
            out[i] = upper[i] + share * (lower[i] - upper[i]);
        }
        let last = upper.len() - 3;
        out.copy_within(last..last + 3, upper.len());
    }

    /// The layer's colour at the centre of pixel (x, y): bilinear between sample centres, or the
    /// sample itself where samples are pixels. The fourth number is none.
    #[inline(always)]
    fn fetch<S: lanes::Simd>(
        &self,
        simd: S,
        [x, y]: [usize; 2],
        between: &[f32],
        count: &mut u64,
    ) -> f32x4<S> {
        if let Some(origin) = self.aligned {
            *count += 1;
            let on = |axis: usize, p: usize| {
                let p = p as i64 - origin[axis];
                p.clamp(0, i64::from(self.size[axis]) - 1) as usize
            };
            let sample = on(1, y) * self.size.x as usize + on(0, x);
            return triple(simd, self.image.rgb.as_flattened(), sample);
        }
        *count += 4;
        let (low, share) = self.columns[x];
        let beside = &between[3 * low as usize..][..7];
        let a = f32x4::from_slice(simd, &beside[..4]);
        let b = f32x4::from_slice(simd, &beside[3..]);
        a + (b - a) * share
    }
}
