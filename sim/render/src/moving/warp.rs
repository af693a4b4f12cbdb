use foveasim_assets::Scene;
use foveasim_models::{Affine, Lens, Map, Pass, ScanSkew, View};
use glam::{DVec2, UVec2};

use crate::RenderOptions;
use crate::project::Projection;

/// What bends or spreads over time what the samples of a view look at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Warp {
    /// When display positions light, if anything moves.
    pub(crate) scan: Option<ScanSkew>,
    pub(crate) lens: Option<Lens>,
}

impl Warp {
    /// Of a view; `None` where still triangles and display positions will do.
    pub(crate) fn of(scene: &Scene, view: &View, options: &RenderOptions) -> Option<Self> {
        let moves = !view.is_still() || scene.is_moving();
        let scan = view.scan.filter(|_| moves);
        let any = scan.is_some() || view.lens.is_some() || options.bound.is_some();
        any.then_some(Self {
            scan,
            lens: view.lens,
        })
    }

    /// When places in the image of a display of `size` pixels are looked at: known where no lens moves them.
    pub(crate) fn image_scan(&self, size: UVec2) -> Option<ImageScan> {
        let scan = self.scan.filter(|_| self.lens.is_none())?;
        Some(ImageScan {
            start: scan.start(),
            per_px: scan.direction() / size.as_dvec2(),
        })
    }

    /// Where and when the samples of a pass over a display of `size` pixels look, if that is evenly.
    pub(crate) fn even_places(&self, pass: &Pass, size: UVec2) -> Option<EvenPlaces> {
        let Map::Affine(map) = pass.map else {
            return None;
        };
        let is_even = self.lens.is_none()
            && map.scale.cmpgt(DVec2::ZERO).all()
            && size.max_element() <= EXACT_PX;
        is_even.then(|| EvenPlaces {
            first: map.origin + map.scale * (pass.offset + 0.5),
            step: map.scale,
            scan: self.image_scan(size),
        })
    }

    /// A projection whose sides hold all that is seen of a display of `size` pixels.
    pub(crate) fn widest(&self, view: &View, near: f64) -> Projection {
        let size = view.optics.size;
        let growth = self.lens.map_or(1.0, |lens| most_growth(&lens, size));
        let (centre, growth) = match self.lens {
            Some(lens) => (lens.centre_px(), growth.max(1.0)),
            None => (DVec2::ZERO, 1.0),
        };
        let low = (centre * (1.0 - growth)).floor() - 1.0;
        let high = (centre + (size.as_dvec2() - centre) * growth).ceil() + 1.0;
        let low = low.clamp(DVec2::splat(-FARTHEST), DVec2::ZERO);
        let high = high.clamp(size.as_dvec2(), DVec2::splat(FARTHEST));
        let map = Affine {
            origin: low,
            scale: DVec2::ONE,
        };
        Projection::new(&view.optics, &map, (high - low).as_uvec2(), near)
    }
}

/// How far from where they should be samples may look \[px\]: far more than rounding takes them off.
const SLACK_PX: f64 = 1.0 / 64.0;
/// Up to this size of a display that is so [px]: single precision has a thousandth of a pixel.
const EXACT_PX: u32 = 8192;
/// The same of when.
const SLACK_TIME: f64 = 1e-6;

/// When places of an image are looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ImageScan {
    start: f64,
    per_px: DVec2,
}

impl ImageScan {
    /// The first and last time that anything within `bounds` is looked at.
    pub(crate) fn times(&self, bounds: &[[f32; 2]; 2]) -> [f64; 2] {
        let mut times = [self.start - SLACK_TIME, self.start + SLACK_TIME];
        for (axis, bounds) in bounds.iter().enumerate() {
            let rate = self.per_px[axis];
            let ends = [bounds[0], bounds[1]].map(|px| f64::from(px) * rate);
            let slack = SLACK_PX * rate.abs();
            times[0] += ends[0].min(ends[1]) - slack;
            times[1] += ends[0].max(ends[1]) + slack;
        }
        times.map(|t| t.clamp(0.0, 1.0))
    }
}

/// Places that lie evenly along each axis \[px\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct EvenPlaces {
    first: DVec2,
    step: DVec2,
    scan: Option<ImageScan>,
}

/// What a square block of evenly placed samples looks at: u, v and t.
pub(crate) struct EvenBlock {
    pub(crate) middle: [f32; 3],
    /// From sample to sample along x, and along y.
    pub(crate) slopes: [[f32; 3]; 2],
    /// How far from that samples may be.
    pub(crate) off: [f32; 3],
}

impl EvenPlaces {
    /// The block about lattice position `middle`, whose first sample is at 0.
    pub(crate) fn block(&self, middle: DVec2) -> EvenBlock {
        let px = self.first + self.step * middle;
        let (start, per_px) = match self.scan {
            Some(scan) => (scan.start, scan.per_px),
            None => (0.0, DVec2::ZERO),
        };
        let [u, v, t] = [px.x, px.y, start + px.dot(per_px)].map(|x| x as f32);
        let later = (self.step * per_px).as_vec2();
        let step = self.step.as_vec2();
        let off_px = SLACK_PX as f32;
        let off_time = match self.scan {
            Some(_) => (SLACK_TIME + SLACK_PX * (per_px.x.abs() + per_px.y.abs())) as f32,
            None => 0.0,
        };
        EvenBlock {
            middle: [u, v, t],
            slopes: [[step.x, 0.0, later.x], [0.0, step.y, later.y]],
            off: [off_px, off_px, off_time],
        }
    }

    /// Whether any may lie within `bounds`.
    pub(crate) fn has_one_within(&self, bounds: &[[f32; 2]; 2]) -> bool {
        bounds.iter().enumerate().all(|(axis, bounds)| {
            let (first, step) = (self.first[axis], self.step[axis]);
            let [low, high] = bounds.map(f64::from);
            let next = first + step * ((low - SLACK_PX - first) / step).ceil();
            next <= high + SLACK_PX
        })
    }
}

/// Farther out nothing is sampled \[px\].
const FARTHEST: f64 = 65_536.0;

/// The most that a lens takes a display position away from its axis, as a factor: 1 + k₁r² + k₂r⁴ is
/// largest at an end or where it turns.
fn most_growth(lens: &Lens, size: UVec2) -> f64 {
    let [k1, k2] = lens.coefficients();
    let far = lens
        .centre_px()
        .abs()
        .max((size.as_dvec2() - lens.centre_px()).abs());
    let last = far.length_squared() / (lens.unit_px() * lens.unit_px());
    let at = |q: f64| 1.0 + q * (k1 + q * k2);
    let turn = -k1 / (2.0 * k2);
    let turn = if turn > 0.0 && turn < last {
        at(turn)
    } else {
        1.0
    };
    at(last).max(turn)
}
