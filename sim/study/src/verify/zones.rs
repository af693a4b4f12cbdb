use foveasim_models::math::{log, sqrt};
use foveasim_models::{Lattice, Map, Resolve, SamplePlan, Shading, Viewport};
use glam::{DVec2, DVec3};

/// Parts of the image by distance from the gaze: within a quarter of its width and height, within half of it, and
/// the rest.
pub(super) const ZONES: usize = 3;

/// Samples of one pass in one zone.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct ZoneCount {
    /// Places where visibility is found.
    pub(super) samples: f64,
    /// Evaluations of shading.
    pub(super) shadings: f64,
    /// Mean logarithm of the distance of evaluations of shading \[ln px\].
    pub(super) log_shading_px: f64,
    /// … of samples.
    pub(super) log_sample_px: f64,
}

/// Where the samples of one pass lie.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct PassZones {
    /// By zone, from the inside.
    pub(super) zones: [ZoneCount; ZONES],
    /// How far it reaches from the gaze, as a share of the image: 1 is all of it.
    pub(super) reach: f64,
    /// Whether samples do not lie evenly.
    pub(super) placed: bool,
    /// Whether it finds its own visibility.
    pub(super) finds: bool,
    /// Tiles of 64 × 64 samples.
    pub(super) tiles: f64,
}

/// Places along each side of the image at which a plan is asked for its density.
const ASKED: [u32; 2] = [160, 90];
/// Samples along each side of a tile, as the renderer has it.
const TILE: u32 = 64;

/// Where the samples of each pass lie, from the plan alone. Samples of layers that inner ones hide do not count.
pub(super) fn zones(plan: &SamplePlan, viewport: &Viewport, gaze: DVec3) -> Vec<PassZones> {
    let size = viewport.size.as_dvec2();
    let centre = viewport.project(gaze).unwrap_or(size / 2.0);
    let cell = size / DVec2::new(f64::from(ASKED[0]), f64::from(ASKED[1]));
    let mut found = Vec::with_capacity(plan.passes.len());
    for (k, pass) in plan.passes.iter().enumerate() {
        let Lattice::Grid(lattice) = pass.lattice else {
            continue;
        };
        let mut of_pass = PassZones {
            placed: !matches!(pass.map, Map::Affine(_)),
            finds: pass.samples() > 0,
            tiles: f64::from(lattice.x.div_ceil(TILE)) * f64::from(lattice.y.div_ceil(TILE)),
            ..PassZones::default()
        };
        for (x, y) in (0..ASKED[1]).flat_map(|y| (0..ASKED[0]).map(move |x| (x, y))) {
            let px = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) * cell;
            let at = pass.map.lattice_from_display(px);
            let inside = at.cmpge(DVec2::ZERO).all() && at.cmplt(lattice.as_dvec2()).all();
            if !inside || is_hidden(plan, k, viewport, px) {
                continue;
            }
            let sample = at.as_uvec2();
            if !pass.region.is_live(sample) {
                continue;
            }
            let area = pass.map.steps(at).determinant().abs().max(1e-9);
            let samples = cell.element_product() / area;
            let shared = match &pass.shading {
                Shading::Nowhere => f64::INFINITY,
                Shading::Coarse(rates) => {
                    let rate = rates.rate(sample);
                    f64::from(rate.x) * f64::from(rate.y)
                }
                _ => 1.0,
            };
            // A quarter of the image's sides is an eighth to either side of the gaze.
            let away = ((px - centre).abs() / size).max_element();
            let zone = &mut of_pass.zones[usize::from(away > 0.125) + usize::from(away > 0.25)];
            of_pass.reach = of_pass.reach.max((2.0 * away).min(1.0));
            zone.samples += samples;
            zone.shadings += samples / shared;
            zone.log_sample_px += samples * log(sqrt(area));
            if shared.is_finite() {
                zone.log_shading_px += samples / shared * log(sqrt(area * shared));
            }
        }
        of_pass.scale_to(pass.live() as f64, pass.shadings() as f64, plan, k);
        found.push(of_pass);
    }
    found
}

/// Whether inner layers hide what pass `k` has at a pixel.
fn is_hidden(plan: &SamplePlan, k: usize, viewport: &Viewport, px: DVec2) -> bool {
    let Resolve::Feather(feather) = &plan.resolve else {
        return false;
    };
    let Some([from, _]) = k
        .checked_sub(1)
        .and_then(|inner| feather.edges_tan.get(inner))
    else {
        return false;
    };
    let cosine = viewport.direction(px).normalize().dot(feather.gaze);
    cosine > 0.0 && sqrt((1.0 - cosine * cosine).max(0.0)) < from * cosine
}

impl PassZones {
    /// Exact counts where nothing is hidden: the places asked know them to a part of a percent.
    fn scale_to(&mut self, live: f64, shadings: f64, plan: &SamplePlan, k: usize) {
        let hides = k > 0 && matches!(plan.resolve, Resolve::Feather(_));
        let total = |f: fn(&ZoneCount) -> f64| self.zones.iter().map(f).sum::<f64>();
        let sums = [total(|z| z.samples), total(|z| z.shadings)];
        let factor = |exact: f64, sum: f64| {
            if hides || sum <= 0.0 {
                1.0
            } else {
                exact / sum
            }
        };
        let factors = [factor(live, sums[0]), factor(shadings, sums[1])];
        for zone in &mut self.zones {
            if zone.samples > 0.0 {
                zone.log_sample_px /= zone.samples;
            }
            if zone.shadings > 0.0 {
                zone.log_shading_px /= zone.shadings;
            }
            zone.samples *= factors[0];
            zone.shadings *= factors[1];
        }
    }

    /// Distance of samples in the innermost zone that has any \[ln px\].
    pub(super) fn finest_log_px(&self) -> f64 {
        let inner = self.zones.iter().find(|z| z.samples > 0.0);
        inner.map_or(0.0, |z| z.log_sample_px)
    }
}

#[cfg(test)]
mod tests {
    use foveasim_models::foveation::{Method, Request};
    use foveasim_models::{Acuity, Eye, GazeDirection};
    use glam::UVec2;

    use super::*;

    fn of(method: &str) -> (SamplePlan, Vec<PassZones>) {
        let viewport = Viewport::symmetric(UVec2::new(1280, 720), 1.0).unwrap();
        let request = Request {
            eye: Eye::Cyclopean,
            viewport,
            acuity: Acuity::default(),
            gaze: GazeDirection::AHEAD,
            ahead: GazeDirection::AHEAD,
            margin_deg: 0.0,
        };
        let plan = method.parse::<Method>().unwrap().plan(&request).unwrap();
        let found = zones(&plan, &viewport, DVec3::NEG_Z);
        (plan, found)
    }

    #[test]
    fn samples_lie_where_the_plan_has_them() {
        let (_, full) = of("full");
        let shares = full[0].zones.map(|z| z.samples / (1280.0 * 720.0));
        for (share, expected) in shares.into_iter().zip([1.0 / 16.0, 3.0 / 16.0, 0.75]) {
            assert!((share - expected).abs() < 0.01, "{shares:?}");
        }
        assert_eq!((full[0].reach, full[0].placed), (1.0 - 1.0 / 160.0, false));
        // Layers: the outer one's middle is hidden.
        let (plan, layers) = of("layers:3");
        assert!(layers[0].reach < 1.0 && layers[2].reach > 0.99);
        assert!(layers[2].zones[0].samples < 0.2 * layers[0].zones[0].samples);
        assert!(plan.passes[2].live() as f64 > layers[2].zones.iter().map(|z| z.samples).sum());
        // Coarse shading shares evaluations, but not samples.
        let (plan, vrs) = of("vrs");
        let sum = |f: fn(&ZoneCount) -> f64| vrs[0].zones.iter().map(f).sum::<f64>();
        assert!((sum(|z| z.samples) - 1280.0 * 720.0).abs() < 1.0);
        assert!((sum(|z| z.shadings) - plan.count().shadings() as f64).abs() < 1.0);
        // A log-polar map is densest at the gaze.
        let (_, kfr) = of("kfr:2:4");
        let log_px = kfr[0].zones.map(|z| z.log_sample_px);
        assert!(kfr[0].placed && log_px[0] < log_px[1] && log_px[1] < log_px[2]);
    }
}
