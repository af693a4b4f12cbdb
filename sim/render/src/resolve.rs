use fearless_simd::prelude::*;
use foveasim_models::{Affine, Feather, Image, Lattice, Map, Resolve, SamplePlan, View, Work};
use glam::{DVec2, UVec2};
use rayon::prelude::*;

use crate::inverse::invert;
use crate::kernels::lanes::{self, F, max, saturate, splat};
use crate::kernels::{Kernel, dispatch};
use crate::mosaic::mosaic;
use crate::{RenderOptions, Simd};

/// Puts the passes together to the displayed image; also gives back the passes, if they are to be
/// kept.
pub(crate) fn resolve(
    view: &View,
    plan: &SamplePlan,
    mut passes: Vec<Image>,
    options: &RenderOptions,
) -> (Image, Vec<Image>, Work) {
    match &plan.resolve {
        Resolve::Feather(feather) => {
            let (image, work) = blend(view, plan, feather, &passes, options.simd);
            if !options.keep_passes {
                passes.clear();
            }
            (image, passes, work)
        }
        Resolve::Mosaic => {
            let (image, work) = mosaic(plan, &passes);
            if !options.keep_passes {
                passes.clear();
            }
            (image, passes, work)
        }
        Resolve::Inverse(filter) => {
            let Some(last) = passes.last() else {
                unreachable!("a plan without passes does not pass the checks")
            };
            let (image, work) = invert(plan, filter, last, options.simd);
            if !options.keep_passes {
                passes.clear();
            }
            (image, passes, work)
        }
        // The one pass is the image; nothing is interpolated.
        _ => {
            let image = passes.remove(0);
            if options.keep_passes {
                passes.push(image.clone());
            }
            let work = Work {
                pixels_resolved: plan.count().display_pixels,
                ..Work::default()
            };
            (image, passes, work)
        }
    }
}

/// Interpolates the passes and blends them by eccentricity.
fn blend(
    view: &View,
    plan: &SamplePlan,
    feather: &Feather,
    passes: &[Image],
    simd: Simd,
) -> (Image, Work) {
    let size = plan.display_px;
    let layers: Vec<Layer<'_>> = plan
        .passes
        .iter()
        .zip(passes)
        .map(|(p, image)| Layer::new(p.lattice, p.map, image, size.x))
        .collect();
    let mut image = Image::filled(size, [0.0; 3]);
    let works: Vec<Work> = image
        .rgb
        .par_chunks_mut(size.x as usize)
        .enumerate()
        .map_init(RowScratch::default, |scratch, (y, row)| {
            let kernel = ResolveRow {
                view,
                feather,
                layers: &layers,
                y: y as u32,
                row,
                scratch,
            };
            dispatch(simd, kernel)
        })
        .collect();
    let mut work = Work::default();
    for row in works {
        work += row;
    }
    (image, work)
}

/// A pass as reconstruction sees it.
struct Layer<'a> {
    size: UVec2,
    map: Affine,
    image: &'a Image,
    /// Display pixel of the first sample, where samples are display pixels.
    aligned: Option<[i64; 2]>,
    /// For each pixel of a row, the two samples beside it and the share of the second one.
    columns: Vec<Beside>,
}

/// The two samples beside a pixel along one axis, and the share of the second one.
type Beside = (u32, u32, f32);

impl<'a> Layer<'a> {
    fn new(lattice: Lattice, map: Map, image: &'a Image, width: u32) -> Self {
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

#[derive(Default)]
struct RowScratch {
    /// Per layer but the last, its weight at each pixel of the row.
    weights: Vec<Vec<f32>>,
    /// Per layer, its samples between the two rows beside the pixels': what is left is to interpolate
    /// along the row. Empty where nothing of it shows.
    between: Vec<Vec<[f32; 3]>>,
}

struct ResolveRow<'a> {
    view: &'a View,
    feather: &'a Feather,
    layers: &'a [Layer<'a>],
    y: u32,
    row: &'a mut [[f32; 3]],
    scratch: &'a mut RowScratch,
}

impl Kernel for ResolveRow<'_> {
    type Output = Work;

    #[inline(always)]
    fn run<S: lanes::Simd>(mut self, simd: S) -> Work {
        self.scratch
            .weights
            .resize(self.feather.edges_tan.len(), Vec::new());
        self.weights(simd);
        let y = f64::from(self.y) + 0.5;
        let vertical: Vec<_> = self
            .layers
            .iter()
            .map(|l| {
                if l.samples() == 0 {
                    (0, 0, 0.0)
                } else {
                    l.beside(1, y)
                }
            })
            .collect();
        self.scratch.between.resize(self.layers.len(), Vec::new());
        for (k, (layer, between)) in self
            .layers
            .iter()
            .zip(&mut self.scratch.between)
            .enumerate()
        {
            between.clear();
            let weights = self.scratch.weights.get(k);
            let shows = weights.is_none_or(|row| row.iter().any(|w| *w > 0.0));
            if shows && layer.aligned.is_none() && layer.samples() > 0 {
                layer.blend_rows(vertical[k], between);
            }
        }
        let mut work = Work {
            pixels_resolved: self.row.len() as u64,
            ..Work::default()
        };
        for (x, out) in self.row.iter_mut().enumerate() {
            let weight = |k: usize| match self.scratch.weights.get(k) {
                Some(_) if self.layers[k].samples() == 0 => 0.0,
                Some(row) => row[x],
                None => 1.0,
            };
            // From the innermost layer that hides all beyond it, inwards.
            let mut k = (0..self.layers.len())
                .find(|&k| weight(k) == 1.0)
                .unwrap_or(0);
            let mut fetch = |k: usize| {
                let between = &self.scratch.between[k];
                self.layers[k].fetch([x, self.y as usize], between, &mut work.resolve_fetches)
            };
            let mut colour = fetch(k);
            while k > 0 {
                k -= 1;
                let w = weight(k);
                if w > 0.0 {
                    let inner = fetch(k);
                    for c in 0..3 {
                        colour[c] += w * (inner[c] - colour[c]);
                    }
                }
            }
            *out = colour;
        }
        work
    }
}

impl ResolveRow<'_> {
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
        for row in &mut self.scratch.weights {
            row.clear();
            row.resize(width.next_multiple_of(8), 0.0);
        }
        let g = gaze.to_array().map(|c| c as f32);
        for start in (0..width).step_by(8) {
            let lanes = [0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5];
            let x = F::from_slice(simd, &lanes) + start as f32;
            let tx = x * (step.x as f32) + (optics.tan[0] as f32);
            let along = tx * g[0] + along_rest;
            let cross_y = -tx * g[2] - g[0];
            let cross_z = tx * g[1] - (ty as f32) * g[0];
            let squares = cross_y * cross_y + cross_z * cross_z + cross_x_rest * cross_x_rest;
            let ahead = along.simd_gt(0.0);
            let tan = squares.sqrt() / max(along, splat(simd, f32::MIN_POSITIVE));
            let tan = ahead.select(tan, splat(simd, f32::INFINITY));
            for (row, [from, to]) in self.scratch.weights.iter_mut().zip(&self.feather.edges_tan) {
                let (from, to) = (*from as f32, *to as f32);
                let weight = if to - from > 0.0 && to.is_finite() {
                    let t = saturate((splat(simd, to) - tan) / (to - from));
                    t * t * (splat(simd, 3.0) - t * 2.0)
                } else {
                    tan.simd_lt(to).select(splat(simd, 1.0), splat(simd, 0.0))
                };
                weight.store_slice(&mut row[start..start + 8]);
            }
        }
    }
}

impl Layer<'_> {
    fn samples(&self) -> usize {
        self.image.rgb.len()
    }

    /// Interpolates between two rows of samples.
    fn blend_rows(&self, (y0, y1, share): Beside, out: &mut Vec<[f32; 3]>) {
        let stride = self.size.x as usize;
        let row = |y: u32| &self.image.rgb[y as usize * stride..][..stride];
        out.extend(row(y0).iter().zip(row(y1)).map(|(a, b)| {
            let [a0, a1, a2] = *a;
            let [b0, b1, b2] = *b;
            [
                a0 + share * (b0 - a0),
                a1 + share * (b1 - a1),
                a2 + share * (b2 - a2),
            ]
        }));
    }

    /// The layer's colour at the centre of pixel (x, y): bilinear between sample centres, or the
    /// sample itself where samples are pixels.
    #[inline(always)]
    fn fetch(&self, [x, y]: [usize; 2], between: &[[f32; 3]], count: &mut u64) -> [f32; 3] {
        if let Some(origin) = self.aligned {
            *count += 1;
            let [sx, sy] = [0, 1].map(|k| {
                let p = [x, y][k] as i64 - origin[k];
                p.clamp(0, i64::from(self.size[k]) - 1) as usize
            });
            return self.image.rgb[sy * self.size.x as usize + sx];
        }
        *count += 4;
        let (x0, x1, share) = self.columns[x];
        let (a, b) = (between[x0 as usize], between[x1 as usize]);
        [
            a[0] + share * (b[0] - a[0]),
            a[1] + share * (b[1] - a[1]),
            a[2] + share * (b[2] - a[2]),
        ]
    }
}

#[cfg(test)]
mod tests {
    use foveasim_models::{Eye, Pose, Viewport};

    use super::*;

    #[test]
    fn the_only_pass_is_moved_not_copied() {
        let size = UVec2::new(8, 4);
        let optics = Viewport::symmetric(size, 1.0).expect("a viewport");
        let view = View::still(Eye::Cyclopean, optics, Pose::IDENTITY);
        let plan = SamplePlan::full(Eye::Cyclopean, size);
        let pass = Image::filled(size, [0.25; 3]);
        let memory = pass.rgb.as_ptr();
        let (image, kept, _) = resolve(&view, &plan, vec![pass], &RenderOptions::default());
        assert_eq!(image.rgb.as_ptr(), memory);
        assert!(kept.is_empty());
    }
}
