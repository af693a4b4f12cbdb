use foveasim_models::SamplePlan;
use foveasim_models::foveation::{Place, Request};
use foveasim_models::math::sqrt;
use foveasim_reports::Cell;
use glam::{DMat2, DVec2, UVec2};

/// Spacing over eccentricity, in steps of [`SpacingCurve::STEP_DEG`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SpacingCurve {
    /// By eccentricity; where the image has none there is no point.
    pub points: Vec<CurvePoint>,
}

/// All places within a step of eccentricity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// The middle of the step \[deg\].
    pub eccentricity_deg: f64,
    /// The largest spacing along the radius \[deg\].
    pub radial_deg: f64,
    /// The largest across it \[deg\].
    pub tangential_deg: f64,
    /// The longest step between samples, which bounds the spacing along every direction \[deg\].
    pub longest_deg: f64,
    /// The same on average over the step's pixels \[deg\].
    pub mean_deg: f64,
    /// The acuity line: half a cycle \[deg\], on average over the step.
    pub acuity_deg: f64,
}

pub(super) const COLUMNS: [&str; 7] = [
    "method",
    "eccentricity_deg",
    "radial_deg",
    "tangential_deg",
    "longest_step_deg",
    "mean_step_deg",
    "acuity_deg",
];

/// What a plan's samples are at worst, against what is asked of them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Worst {
    /// Longest step over what is asked.
    pub(super) over_limit: f64,
    /// Where \[deg\].
    pub(super) at_deg: f64,
}

/// At most so many pixels of an image are looked at, evenly spread.
const MOST_PIXELS: f64 = 150_000.0;
/// So far from the gaze, along x and y, every pixel is looked at.
const NEAR_PX: f64 = 24.0;

impl SpacingCurve {
    /// Degrees between points.
    pub const STEP_DEG: f64 = 0.5;

    /// Of plans and the requests that they are for.
    pub(super) fn of_plans(requests: &[Request], plans: &[SamplePlan]) -> (Self, Worst) {
        let mut bins = Bins::default();
        for (request, plan) in requests.iter().zip(plans) {
            let gaze = request.viewport.project(request.gaze.vector());
            for px in pixels(request, requests.len()) {
                // Within a pixel of the gaze log-polar maps have no inverse.
                if gaze.is_none_or(|gaze| gaze.distance(px) > 1.0) {
                    bins.add(&request.place(px), plan.shading_steps(request, px));
                }
            }
        }
        (bins.curve(), bins.worst)
    }

    /// What is asked: no farther apart than the eye can tell, or than the display's pixels are.
    pub(super) fn of_limits(requests: &[Request]) -> Self {
        let mut bins = Bins::default();
        for request in requests {
            for px in pixels(request, requests.len()) {
                let place = request.place(px);
                // A step that is as long as allowed.
                let scale = place.limit_deg() / place.pixel_deg;
                bins.add(&place, DMat2::from_diagonal(DVec2::splat(scale)));
            }
        }
        bins.curve()
    }

    pub(super) fn cells(&self, label: &str) -> Vec<Vec<Cell>> {
        let row = |p: &CurvePoint| {
            vec![
                label.into(),
                p.eccentricity_deg.into(),
                p.radial_deg.into(),
                p.tangential_deg.into(),
                p.longest_deg.into(),
                p.mean_deg.into(),
                p.acuity_deg.into(),
            ]
        };
        self.points.iter().map(row).collect()
    }
}

/// Pixels of an image: all near the gaze, where methods differ from one to the next, and others evenly
/// spread, those of the edges among them; fewer each if there are several images.
fn pixels(request: &Request, images: usize) -> impl Iterator<Item = DVec2> {
    let size = request.viewport.size;
    let all = size.as_dvec2().element_product() * images as f64;
    let stride = sqrt(all / MOST_PIXELS).ceil().max(1.0) as usize;
    let along = move |n: u32| {
        let even = (0..n).step_by(stride);
        even.chain((!(n - 1).is_multiple_of(stride as u32)).then_some(n - 1))
    };
    let spread = along(size.y).flat_map(move |y| along(size.x).map(move |x| UVec2::new(x, y)));
    let gaze = request.viewport.project(request.gaze.vector());
    let on_image = |px: &DVec2| px.cmpge(DVec2::ZERO).all() && px.cmple(size.as_dvec2()).all();
    let near = gaze.filter(on_image).map(|gaze| {
        let from = (gaze - NEAR_PX).max(DVec2::ZERO).as_uvec2();
        let to = (gaze + NEAR_PX).ceil().as_uvec2().min(size);
        (from.y..to.y).flat_map(move |y| (from.x..to.x).map(move |x| UVec2::new(x, y)))
    });
    let pixels = spread.chain(near.into_iter().flatten());
    pixels.map(|px| px.as_dvec2() + 0.5)
}

#[derive(Default)]
struct Bins {
    bins: Vec<Bin>,
    worst: Worst,
}

#[derive(Clone, Copy, Default)]
struct Bin {
    count: f64,
    radial: f64,
    tangential: f64,
    longest: f64,
    sum: f64,
    acuity: f64,
}

impl Bins {
    fn add(&mut self, place: &Place, steps: DMat2) {
        let index = (place.eccentricity_deg / SpacingCurve::STEP_DEG) as usize;
        if index >= self.bins.len() {
            self.bins.resize(index + 1, Bin::default());
        }
        let (bin, spacing, longest) = (
            &mut self.bins[index],
            place.spacing_deg(steps),
            place.longest(steps),
        );
        bin.count += 1.0;
        bin.radial = bin.radial.max(spacing.radial);
        bin.tangential = bin.tangential.max(spacing.tangential);
        bin.longest = bin.longest.max(longest);
        bin.sum += longest;
        bin.acuity += place.acuity_deg;
        let over_limit = longest / place.limit_deg();
        if over_limit > self.worst.over_limit {
            self.worst = Worst {
                over_limit,
                at_deg: place.eccentricity_deg,
            };
        }
    }

    fn curve(&self) -> SpacingCurve {
        let filled = self
            .bins
            .iter()
            .enumerate()
            .filter(|(_, bin)| bin.count > 0.0);
        let point = |(index, bin): (usize, &Bin)| CurvePoint {
            eccentricity_deg: (index as f64 + 0.5) * SpacingCurve::STEP_DEG,
            radial_deg: bin.radial,
            tangential_deg: bin.tangential,
            longest_deg: bin.longest,
            mean_deg: bin.sum / bin.count,
            acuity_deg: bin.acuity / bin.count,
        };
        SpacingCurve {
            points: filled.map(point).collect(),
        }
    }
}
