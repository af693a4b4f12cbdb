use glam::{DMat2, DVec2};

use super::kernel_search::golden_section;
use super::{LensMatchedSettings, Place, Request, Screen};
use crate::math::{cos, exp, log, sin};
use crate::{LensMatched, ModelError};

/// The coefficients of lens-matched shading with the fewest samples that keep to the limits of
/// [`KernelSearch`](super::KernelSearch): for each A the largest B they allow, and the best A among them.
///
/// Limits are taken at [`LensSearch::RADII`] × [`LensSearch::DIRECTIONS`] places about each gaze, the
/// image's edge and corners among them, and a reserve as there is left between them. A and B are rounded
/// down to three decimals.
#[derive(Debug, Clone)]
pub struct LensSearch {
    gazes: Vec<Gaze>,
}

/// Coefficients that keep to the limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundLens {
    /// A and B.
    pub settings: LensMatchedSettings,
    /// Samples they draw, in closed form, for the gaze that takes most.
    pub samples: f64,
}

#[derive(Debug, Clone)]
struct Gaze {
    request: Request,
    centre_px: DVec2,
    places: Vec<(DVec2, Place)>,
}

/// The largest coefficient that is looked at.
const MOST: f64 = 20.0;

impl LensSearch {
    /// Distances at which limits are taken.
    pub const RADII: usize = 64;
    /// Directions in which they are taken.
    pub const DIRECTIONS: usize = 96;
    /// By how much steps are shorter than the limits at those places allow.
    pub const RESERVE: f64 = 2e-3;

    /// For an image, acuity and margin, and where the eye looks: one request for each gaze.
    ///
    /// # Errors
    /// If there is no request, a gaze is not finite or a margin not from 0 to 90 degrees.
    pub fn new(requests: &[Request]) -> Result<Self, ModelError> {
        if requests.is_empty() {
            return Err(ModelError::range("gazes", 0, "at least one"));
        }
        let gazes = requests.iter().map(Gaze::new);
        Ok(Self {
            gazes: gazes.collect::<Result<_, _>>()?,
        })
    }

    /// The best of all. With A = B = 0, which is full resolution, every limit is met.
    ///
    /// # Errors
    /// If the image is too large to be mapped.
    pub fn best(&self) -> Result<FoundLens, ModelError> {
        let samples = |a: f64| {
            let settings = LensMatchedSettings::new(a, self.largest_b(a));
            settings.map_or(f64::INFINITY, |s| self.samples(&s))
        };
        let largest = self.largest(|a| [a, 0.0]);
        let step = largest / 16.0;
        let scanned = (0..=16).map(|k| step * f64::from(k));
        let best = scanned.min_by(|a, b| samples(*a).total_cmp(&samples(*b)));
        let best = best.unwrap_or_default();
        let (low, high) = ((best - step).max(0.0), (best + step).min(largest));
        let a = golden_section(low, high, 1e-4, samples);
        let down = |x: f64| (x * 1e3).floor() / 1e3;
        let a = down(a);
        let settings = LensMatchedSettings::new(a, down(self.largest_b(a)))?;
        Ok(FoundLens {
            settings,
            samples: self.samples(&settings),
        })
    }

    fn largest_b(&self, a: f64) -> f64 {
        self.largest(|b| [a, b])
    }

    /// The largest value that keeps to the limits: steps grow with either coefficient.
    fn largest(&self, coefficients: impl Fn(f64) -> [f64; 2]) -> f64 {
        let fits = |x: f64| self.gazes.iter().all(|g| g.fits(coefficients(x)));
        let (mut low, mut high) = (0.0, MOST);
        if fits(high) {
            return high;
        }
        while high - low > 1e-5 {
            let middle = (low + high) / 2.0;
            if fits(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }

    fn samples(&self, settings: &LensMatchedSettings) -> f64 {
        let of = |gaze: &Gaze| {
            let screen = Screen::from(&gaze.request.viewport);
            let estimate = settings.estimate(&screen, gaze.request.gaze.vector());
            estimate.map_or(f64::INFINITY, |e| e.samples())
        };
        self.gazes.iter().map(of).fold(0.0, f64::max)
    }
}

impl Gaze {
    fn new(request: &Request) -> Result<Self, ModelError> {
        request.check()?;
        let size = request.viewport.size.as_dvec2();
        let gaze = request.gaze.vector();
        let centre_px = Screen::from(&request.viewport).nearest_px(gaze).round();
        let room = size - centre_px;
        let corners = [
            -centre_px,
            DVec2::new(room.x, -centre_px.y),
            room,
            DVec2::new(-centre_px.x, room.y),
        ];
        let turn = |k: usize| std::f64::consts::TAU * k as f64 / LensSearch::DIRECTIONS as f64;
        let even = (0..LensSearch::DIRECTIONS).map(|k| DVec2::new(cos(turn(k)), sin(turn(k))));
        let towards = corners
            .into_iter()
            .filter_map(DVec2::try_normalize)
            .chain(even);
        let mut places = Vec::new();
        for direction in towards {
            // As far as the nearer of the two edges that lie ahead.
            let edge = DVec2::select(direction.cmplt(DVec2::ZERO), centre_px, room);
            let far = (edge / direction.abs()).min_element();
            if far < 1.0 {
                continue;
            }
            for k in 0..LensSearch::RADII {
                let share = k as f64 / (LensSearch::RADII - 1) as f64;
                let px = centre_px + direction * exp(log(far) * share);
                places.push((px, request.place(px)));
            }
        }
        Ok(Self {
            request: request.clone(),
            centre_px,
            places,
        })
    }

    fn fits(&self, coefficients: [f64; 2]) -> bool {
        let growth = DVec2::from(coefficients) * 2.0 / self.request.viewport.size.as_dvec2();
        let Ok(map) = LensMatched::new(self.centre_px, DVec2::ZERO, growth) else {
            return false;
        };
        self.places.iter().all(|(px, place)| {
            let steps: DMat2 = map.steps(map.lattice_from_display(*px));
            let longest = place.longest(steps);
            // The display's own pixels need no reserve.
            longest
                <= place
                    .pixel_deg
                    .max(place.limit_deg() * (1.0 - LensSearch::RESERVE))
        })
    }
}
