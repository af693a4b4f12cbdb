use glam::DVec2;

use super::kernel::{ALPHA, SIGMA};
use super::{KernelSettings, Request, Screen, kfr};
use crate::math::{cos, exp, log, sin};
use crate::{LogPolar, ModelError};

/// The log-polar kernel with the fewest samples that are nowhere farther apart than the eye can tell, or
/// than the display's pixels where those are coarser ([`Place::limit_deg`](super::Place::limit_deg)).
///
/// Outwards a sample's cell is r(x + ½) − r(x − ½) pixels long and around 2πr/n_y, whatever the direction. So
/// of all places at a distance r from the gaze the strictest along each counts, and those limits are found
/// once ([`KernelSearch::RADII`] distances, [`KernelSearch::DIRECTIONS`] directions and the image's
/// corners). For a kernel α, σ is as large as they allow, and α is found by scanning its logarithm and
/// golden section about the best. Within a pixel of the gaze the map has no inverse, and nothing is asked.
///
/// Between the places looked at limits are met because σ is taken [`KernelSearch::RESERVE`] smaller than it
/// need be: that is how far the search is from the fewest samples, twice over, and by about as much again
/// because α is rounded to three decimals.
///
/// Several gazes may be asked for at once: then limits hold at each, and the samples are the most that
/// any takes. Between those of [`Request::wherever`], which stand for all, limits may be exceeded by a
/// percent.
#[derive(Debug, Clone)]
pub struct KernelSearch {
    gazes: Vec<Limits>,
}

/// A kernel that keeps to the limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundKernel {
    /// Its σ and α, in the direct form.
    pub settings: KernelSettings,
    /// Samples it draws, in closed form, for the gaze that takes most.
    pub samples: f64,
}

/// How long cells may be, about one gaze.
#[derive(Debug, Clone)]
struct Limits {
    gaze_px: DVec2,
    size: DVec2,
    rings: Vec<Ring>,
}

/// The strictest limits at a distance from the gaze \[px\].
#[derive(Debug, Clone, Copy)]
struct Ring {
    radius: f64,
    outwards: f64,
    around: f64,
}

impl KernelSearch {
    /// Distances at which limits are taken, evenly in their logarithm.
    pub const RADII: usize = 1024;
    /// Directions in which they are taken.
    pub const DIRECTIONS: usize = 128;
    /// By how much σ is smaller than the limits at those places allow.
    pub const RESERVE: f64 = 2e-3;

    /// For an image, acuity and margin, and where the eye looks: one request for each gaze.
    ///
    /// # Errors
    /// If there is no request, a gaze is not finite or a margin not from 0 to 90 degrees.
    pub fn new(requests: &[Request]) -> Result<Self, ModelError> {
        if requests.is_empty() {
            return Err(ModelError::range("gazes", 0, "at least one"));
        }
        let gazes = requests.iter().map(Limits::new);
        Ok(Self {
            gazes: gazes.collect::<Result<_, _>>()?,
        })
    }

    /// The best kernel of all; `None` if even the least σ is too coarse with every α.
    pub fn best(&self) -> Option<FoundKernel> {
        // Kernels from nearly a step to nearly a straight line; beyond, samples grow without bound.
        const SCAN: (f64, f64, u32) = (0.1, 10.0, 20);
        let (low, high, steps) = (log(SCAN.0), log(SCAN.1), SCAN.2);
        let step = (high - low) / f64::from(steps);
        let samples = |l: f64| self.at_alpha(exp(l)).map_or(f64::INFINITY, |k| k.samples);
        let scanned = (0..=steps).map(|k| low + step * f64::from(k));
        let best = scanned.min_by(|a, b| samples(*a).total_cmp(&samples(*b)))?;
        let found = golden_section(best - step, best + step, 1e-4, samples);
        let alpha = (exp(found) * 1e3).round() / 1e3;
        self.at_alpha(alpha)
    }

    /// The largest σ with a given α, rounded down to four decimals; `None` if even the least σ is too coarse,
    /// or α is not from 0.01 to 100.
    pub fn at_alpha(&self, alpha: f64) -> Option<FoundKernel> {
        if !ALPHA.contains(&alpha) {
            return None;
        }
        let most = *SIGMA.end();
        let sigma = self
            .gazes
            .iter()
            .fold(most, |sigma, gaze| gaze.sigma(alpha, sigma));
        let sigma = sigma * (1.0 - Self::RESERVE);
        let sigma = (sigma * 1e4).floor() / 1e4;
        let settings = KernelSettings::new(sigma, alpha).ok()?;
        let samples = self.gazes.iter().map(|gaze| gaze.samples(&settings));
        Some(FoundKernel {
            settings,
            samples: samples.fold(0.0, f64::max),
        })
    }
}

impl Limits {
    fn new(request: &Request) -> Result<Self, ModelError> {
        request.check()?;
        let size = request.viewport.size.as_dvec2();
        let gaze_px = Screen::from(&request.viewport).nearest_px(request.gaze.vector());
        let turn = |k: usize| std::f64::consts::TAU * k as f64 / KernelSearch::DIRECTIONS as f64;
        let even = (0..KernelSearch::DIRECTIONS).map(|k| DVec2::new(cos(turn(k)), sin(turn(k))));
        let corners = [
            DVec2::ZERO,
            DVec2::new(size.x, 0.0),
            size,
            DVec2::new(0.0, size.y),
        ];
        let to_corners = corners.map(|c| c - gaze_px);
        let towards: Vec<DVec2> = to_corners
            .iter()
            .filter_map(|c| c.try_normalize())
            .chain(even)
            .collect();
        let reach = to_corners
            .into_iter()
            .map(DVec2::length)
            .fold(1.0, f64::max);
        let radii = (0..KernelSearch::RADII)
            .map(|k| exp(log(reach) * k as f64 / (KernelSearch::RADII - 1) as f64));
        let ring = |radius: f64| {
            let mut ring = Ring {
                radius,
                outwards: f64::INFINITY,
                around: f64::INFINITY,
            };
            for &direction in &towards {
                let px = gaze_px + direction * radius;
                // Rounding must not take the farthest corner off the image.
                let edge = 1e-9 * size;
                if px.cmpge(-edge).all() && px.cmple(size + edge).all() {
                    let place = request.place(px);
                    let limit = place.limit_deg();
                    ring.outwards = ring.outwards.min(limit / place.angle_deg(direction));
                    ring.around = ring.around.min(limit / place.angle_deg(direction.perp()));
                }
            }
            ring
        };
        Ok(Self {
            gaze_px,
            size,
            rings: radii.map(ring).collect(),
        })
    }

    fn map(&self, sigma: f64, alpha: f64) -> Result<LogPolar, ModelError> {
        LogPolar::over(self.gaze_px, self.size, alpha, self.size / sigma)
    }

    /// The largest σ up to `most` that keeps to the limits with a given α.
    fn sigma(&self, alpha: f64, most: f64) -> f64 {
        // Cells are nearly proportional to σ, so a few steps of that do.
        const MOST_STEPS: usize = 40;
        const CLOSE: f64 = 1e-5;
        let mut sigma = most;
        for _ in 0..MOST_STEPS {
            let room = self.room(sigma, alpha);
            if (room >= 1.0 && sigma >= most) || !(1e-3..1e4).contains(&sigma) {
                break;
            }
            sigma = (sigma * room).min(most);
            if (room - 1.0).abs() < CLOSE {
                break;
            }
        }
        sigma
    }

    /// How many times longer than with this kernel cells may be: less than 1 if they are too long.
    fn room(&self, sigma: f64, alpha: f64) -> f64 {
        let Ok(map) = self.map(sigma, alpha) else {
            return 0.0;
        };
        self.rings.iter().fold(f64::INFINITY, |room, ring| {
            let [outwards, around] = map.cell_lengths(map.x_at(ring.radius));
            room.min(ring.outwards / outwards).min(ring.around / around)
        })
    }

    fn samples(&self, settings: &KernelSettings) -> f64 {
        self.map(settings.sigma(), settings.alpha())
            .map_or(f64::INFINITY, |map| kfr::on_screen(&map, self.size))
    }
}

/// Where a function with one minimum in [low, high] is least, to within `tolerance` (Kiefer 1953).
pub(super) fn golden_section(low: f64, high: f64, tolerance: f64, f: impl Fn(f64) -> f64) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_894_9;
    let (mut low, mut high) = (low, high);
    let (mut a, mut b) = (high - RATIO * (high - low), low + RATIO * (high - low));
    let (mut at_a, mut at_b) = (f(a), f(b));
    while high - low > tolerance {
        if at_a <= at_b {
            (high, b, at_b) = (b, a, at_a);
            a = high - RATIO * (high - low);
            at_a = f(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + RATIO * (high - low);
            at_b = f(b);
        }
    }
    (low + high) / 2.0
}
