use foveasim_assets::Scene;
use foveasim_models::{Affine, Lens, ScanSkew, View};
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
