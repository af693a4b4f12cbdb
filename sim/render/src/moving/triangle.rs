use foveasim_models::raster::{Facing, Forms, MovingTriangle};

use super::warp::{EvenPlaces, ImageScan};
use crate::project::SUBSAMPLES;

/// A moving triangle ready for rasterization, in single precision: [`Forms`] of image positions \[px\] and time.
///
/// These numbers are the triangle: it covers a sample (u, v, t) where the forms say so and the sample lies
/// within the box of all its places. No more rounding is hidden in it, so that a rasterizer, which leaves out blocks by
/// [a bound](super::Blocks), and a ray tracer, which does not, agree to the bit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Target {
    /// Edges by power of t and component.
    pub(crate) edges: [[[f32; 3]; 3]; 3],
    pub(crate) volume: [f32; 4],
    /// 1/w is d·plane(t)/volume(t).
    pub(crate) plane: [[f32; 3]; 3],
    /// For each edge, the sum of its powers' sizes by component.
    pub(crate) sizes: [[f32; 3]; 3],
    /// Least and greatest image position along x and y, at any time \[px\].
    pub(crate) bounds: [[f32; 2]; 2],
    /// Least and greatest 1/w.
    pub(crate) depth_range: [f32; 2],
    /// Whether it is seen from behind as well.
    pub(crate) both_faces: bool,
    /// Whether its corners move.
    pub(crate) moves: bool,
    /// Which object of the view.
    pub(crate) object: u32,
    /// Which triangle of its mesh.
    pub(crate) triangle: u32,
}

/// Why a triangle is not drawn at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Dropped {
    /// It shows its back at all times, or has no area.
    BackFacing,
    /// It is behind the near plane at all times, where no sample looks, or is not finite.
    Outside,
}

/// How far beyond its corners a triangle may cover samples \[px\]. Rounded, its edges move by less than a hundredth
/// of a pixel; corners of slivers would reach on from there, and are cut off here.
const MARGIN: f64 = 1.0 / 16.0;

/// Times between the ends of which a triangle's places are not asked for anew: it is there most of the scan.
const MOST_OF_THE_SCAN: f64 = 0.75;

/// Bounds of what crosses the eye's plane: anywhere.
pub(crate) const ANYWHERE: [[f32; 2]; 2] = [[f32::MIN, f32::MAX]; 2];

impl Target {
    /// Sets a triangle up that is not nearer than `near` at all times \[m\], if it may be seen where samples look, within
    /// `image` \[px\]. With a `scan`, its bounds are those of where it is when that part of the image is looked at.
    #[inline(always)]
    pub(crate) fn set_up(
        t: &MovingTriangle,
        near: f64,
        image: &Seen<'_>,
        both_faces: bool,
        [object, triangle]: [u32; 2],
    ) -> Result<Self, Dropped> {
        let corners = Corners::new(t);
        let [least, most] = range(&corners.at[2]);
        if !corners.at.as_flattened().iter().all(|x| x.is_finite()) || most < near {
            return Err(Dropped::Outside);
        }
        let in_front = least > 0.0;
        let bounds = match in_front {
            true => image.bounds(&corners),
            false => ANYWHERE,
        };
        if !image.shows(&bounds) {
            return Err(Dropped::Outside);
        }
        let facing = match both_faces {
            true => Facing::Both,
            false => Facing::Front,
        };
        let Some(forms) = Forms::<f32>::new(t, facing) else {
            return Err(Dropped::BackFacing);
        };
        let volume = *forms.volume_coefficients();
        let depth_range = match in_front {
            true => [
                (1.0 / most) as f32,
                (1.0 / least).min(f32::MAX.into()) as f32,
            ],
            false => [(1.0 / most) as f32, f32::MAX],
        };
        let edges = *forms.edges();
        let size = |i: usize, c: usize| {
            let [a, b, d]: [[f32; 3]; 3] = edges[i];
            a[c].abs() + b[c].abs() + d[c].abs()
        };
        Ok(Self {
            sizes: [0, 1, 2].map(|i| [0, 1, 2].map(|c| size(i, c))),
            moves: t.0.iter().any(|p| p.start != p.end),
            edges,
            volume,
            plane: *forms.plane(),
            bounds,
            depth_range,
            both_faces,
            object,
            triangle,
        })
    }

    /// 1/w of what a sample at (u, v) \[px\] and t sees of the triangle, if it is covered and not nearer than
    /// 1/`nearest`: the specification of the kernel, operation by operation.
    pub(crate) fn sees(&self, [u, v, t]: [f32; 3], nearest: f32) -> Option<f32> {
        let [x, y] = self.bounds;
        if !(u >= x[0] && u <= x[1] && v >= y[0] && v <= y[1]) {
            return None;
        }
        let form = |n: &[[f32; 3]; 3]| {
            let at = |c: usize| match self.moves {
                true => (n[2][c] * t + n[1][c]) * t + n[0][c],
                false => n[0][c],
            };
            (u * at(0) + v * at(1)) + at(2)
        };
        let [d0, d1, d2, d3] = self.volume;
        let volume = match self.moves {
            true => ((d3 * t + d2) * t + d1) * t + d0,
            false => d0,
        };
        let e = [
            form(&self.edges[0]),
            form(&self.edges[1]),
            form(&self.edges[2]),
        ];
        let front = volume < 0.0 && e.iter().all(|e| *e <= 0.0);
        let back = self.both_faces && volume > 0.0 && e.iter().all(|e| *e >= 0.0);
        if !(front || back) {
            return None;
        }
        let depth = form(&self.plane) / volume;
        let [low, high] = self.depth_range;
        let depth = if depth < high { depth } else { high };
        let depth = if depth > low { depth } else { low };
        (depth <= nearest).then_some(depth)
    }
}

/// What of the image samples look at, and when: what decides whether a triangle can be seen at all.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen<'a> {
    /// Around all places \[px\].
    pub(crate) around: &'a [[f32; 2]; 2],
    /// When places are looked at, where that is known.
    pub(crate) scan: Option<ImageScan>,
    /// Which places, where they lie evenly.
    pub(crate) grid: Option<EvenPlaces>,
}

impl Seen<'_> {
    /// The box around all places of a triangle in front of the eye, wider by [`MARGIN`]: at the times that the box around
    /// its places at all times is looked at. What is seen of it is seen there and then.
    #[inline(always)]
    fn bounds(&self, corners: &Corners) -> [[f32; 2]; 2] {
        let all = corners.places();
        let Some(scan) = self.scan else {
            return all;
        };
        let times = scan.times(&all);
        if times[1] - times[0] > MOST_OF_THE_SCAN {
            return all;
        }
        let then = corners.between(times).places();
        [0, 1].map(|k| [all[k][0].max(then[k][0]), all[k][1].min(then[k][1])])
    }

    /// Whether a sample may look at a place within `bounds`.
    #[inline(always)]
    fn shows(&self, bounds: &[[f32; 2]; 2]) -> bool {
        let meets = |k: usize| {
            let ([low, high], [first, last]) = (bounds[k], self.around[k]);
            low <= last && high >= first
        };
        meets(0) && meets(1) && self.grid.is_none_or(|grid| grid.has_one_within(bounds))
    }
}

/// The corners of a triangle at two times, in homogeneous pixels: by component, the three at the first time, then
/// those at the second. Side by side, so that what is done to all is done at once.
struct Corners {
    at: [[f64; 6]; 3],
}

impl Corners {
    /// At the scan's start and end.
    #[inline(always)]
    fn new(t: &MovingTriangle) -> Self {
        let mut at = [[0.0; 6]; 3];
        for (i, corner) in t.0.iter().enumerate() {
            let (start, end) = (corner.start.to_array(), corner.end.to_array());
            for (at, (start, end)) in at.iter_mut().zip(start.into_iter().zip(end)) {
                at[i] = start;
                at[i + 3] = end;
            }
        }
        Self { at }
    }

    /// Those from `times[0]` to `times[1]`, of those from 0 to 1.
    #[inline(always)]
    fn between(&self, times: [f64; 2]) -> Self {
        let mut at = [[0.0; 6]; 3];
        for (at, own) in at.iter_mut().zip(&self.at) {
            for i in 0..3 {
                let way = own[i + 3] - own[i];
                at[i] = own[i] + way * times[0];
                at[i + 3] = own[i] + way * times[1];
            }
        }
        Self { at }
    }

    /// The box around all their places in the image between the two times, wider by [`MARGIN`]: each goes along a
    /// straight line.
    #[inline(always)]
    fn places(&self) -> [[f32; 2]; 2] {
        let [x, y, w] = &self.at;
        let (mut u, mut v) = ([0.0; 6], [0.0; 6]);
        for i in 0..6 {
            let per_w = 1.0 / w[i];
            u[i] = x[i] * per_w;
            v[i] = y[i] * per_w;
        }
        let around = |[low, high]: [f64; 2]| [(low - MARGIN) as f32, (high + MARGIN) as f32];
        [around(range(&u)), around(range(&v))]
    }
}

/// The least and greatest of numbers.
#[inline(always)]
fn range(numbers: &[f64; 6]) -> [f64; 2] {
    let least = |a: f64, b: f64| if b < a { b } else { a };
    let most = |a: f64, b: f64| if b > a { b } else { a };
    let [a, b, c, d, e, f] = *numbers;
    [
        least(least(least(a, b), least(c, d)), least(e, f)),
        most(most(most(a, b), most(c, d)), most(e, f)),
    ]
}

/// Image position of a place in sub-samples \[px\]: exact.
#[inline(always)]
pub(crate) fn px(sub: i32) -> f32 {
    sub as f32 * (1.0 / SUBSAMPLES as f32)
}
