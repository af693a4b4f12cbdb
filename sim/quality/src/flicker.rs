use foveasim_models::{Viewport, math};
use glam::{DVec3, UVec2};
use rayon::prelude::*;

use crate::{Plane, QualityError, Rings};

/// Temporal quality against a reference sequence, one frame at a time; memory is that of a few images,
/// however many frames there are.
///
/// The error of a pixel in frame k is e_k = test_k − reference_k, in luma of 8-bit sRGB values like
/// every measure here \[grey levels of 255\]. Its *flicker* is the standard deviation of e_k over the
/// frames (of the population: of n frames, divided by n). What is constantly wrong, like blur of a
/// still edge, does not flicker; what moves as the reference moves does not either.
///
/// An error that travels with a moving picture (blur of moving detail) varies at each pixel and so
/// counts. The excess change tells it from twinkling: see [`FlickerMap::excess_change`].
#[derive(Debug, Clone)]
pub struct Flicker {
    size: UVec2,
    frames: u32,
    pixels: Vec<Moments>,
    /// The latest frame and its reference.
    latest: Option<[Plane; 2]>,
}

/// What is kept of one pixel.
#[derive(Debug, Clone, Copy, Default)]
struct Moments {
    /// Mean error so far.
    mean: f64,
    /// Sum of squared deviations from it (Welford 1962): no cancellation, however large the mean.
    squares: f64,
    /// Sum of |Δtest| − |Δreference| from frame to frame.
    excess: f64,
}

/// What a [`Flicker`] found, pixel by pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct FlickerMap {
    /// How many frames.
    pub frames: u32,
    /// Flicker of every pixel \[grey levels\].
    pub flicker: Plane,
    /// By how much a pixel changed more from one frame to the next than its reference did, mean of
    /// |Δtest| − |Δreference| over the steps \[grey levels\]; below zero where it lagged or was blurred,
    /// zero if there is only one frame.
    pub excess_change: Plane,
    /// Mean flicker \[grey levels\].
    pub mean: f64,
    /// Flicker that 99 % of the pixels stay below \[grey levels\].
    pub p99: f64,
    /// Mean excess change \[grey levels\].
    pub mean_excess_change: f64,
}

/// Flicker in one ring of eccentricity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingFlicker {
    /// Inner edge \[deg\].
    pub from_deg: f64,
    /// Outer edge \[deg\]; `None` for the last ring, which is open.
    pub to_deg: Option<f64>,
    /// Pixels whose centre lies in it; the values below are `None` if there is none.
    pub pixels: u64,
    /// Mean flicker \[grey levels\].
    pub mean: Option<f64>,
    /// Flicker that 99 % of its pixels stay below \[grey levels\].
    pub p99: Option<f64>,
    /// Mean excess change \[grey levels\].
    pub excess_change: Option<f64>,
}

/// Pixels that one thread takes at a time.
const CHUNK: usize = 1 << 14;

impl Flicker {
    /// No frames of `size` pixels yet.
    ///
    /// # Errors
    /// If that is no pixels.
    pub fn new(size: UVec2) -> Result<Self, QualityError> {
        let pixels = size.x as usize * size.y as usize;
        if pixels == 0 {
            return Err(QualityError::Empty { size });
        }
        Ok(Self {
            size,
            frames: 0,
            pixels: vec![Moments::default(); pixels],
            latest: None,
        })
    }

    /// Takes the next frame and its reference: lumas, as in a [`Comparison`](crate::Comparison).
    ///
    /// # Errors
    /// If one of them has another size.
    pub fn push(&mut self, test: &Plane, reference: &Plane) -> Result<(), QualityError> {
        for plane in [test, reference] {
            if plane.size() != self.size {
                return Err(QualityError::SizesDiffer {
                    a: plane.size(),
                    b: self.size,
                });
            }
        }
        self.frames += 1;
        let n = f64::from(self.frames);
        let (test_values, reference_values) = (test.values(), reference.values());
        let earlier = self.latest.as_ref().map(|[t, r]| (t.values(), r.values()));
        self.pixels
            .par_chunks_mut(CHUNK)
            .enumerate()
            .for_each(|(chunk, pixels)| {
                for (at, p) in (chunk * CHUNK..).zip(pixels) {
                    let (test, reference) = (test_values[at], reference_values[at]);
                    let error = test - reference;
                    let before = error - p.mean;
                    p.mean += before / n;
                    p.squares += before * (error - p.mean);
                    if let Some((t, r)) = earlier {
                        p.excess += (test - t[at]).abs() - (reference - r[at]).abs();
                    }
                }
            });
        self.latest = Some([test.clone(), reference.clone()]);
        Ok(())
    }

    /// What all frames together show.
    ///
    /// # Errors
    /// If there were none.
    pub fn finish(self) -> Result<FlickerMap, QualityError> {
        if self.frames == 0 {
            return Err(QualityError::NoFrames);
        }
        let n = f64::from(self.frames);
        let steps = (n - 1.0).max(1.0);
        let map = |f: &(dyn Fn(&Moments) -> f64 + Sync)| -> Vec<f64> {
            self.pixels.par_iter().map(f).collect()
        };
        let flicker = map(&|p| math::sqrt(p.squares.max(0.0) / n));
        let excess = map(&|p| p.excess / steps);
        Ok(FlickerMap {
            frames: self.frames,
            mean: math::mean(&flicker),
            p99: p99(flicker.clone()),
            mean_excess_change: math::mean(&excess),
            flicker: Plane::from_finite(self.size, flicker),
            excess_change: Plane::from_finite(self.size, excess),
        })
    }
}

impl FlickerMap {
    /// The same by ring of eccentricity about `gaze` (eye frame, any length) on the image plane that
    /// all frames were seen on. Where the gaze moves during the frames, that is its middle for all.
    ///
    /// # Errors
    /// If the viewport does not have the images' pixels, or the gaze is no direction.
    pub fn rings(
        &self,
        viewport: &Viewport,
        gaze: DVec3,
        rings: &Rings,
    ) -> Result<Vec<RingFlicker>, QualityError> {
        let places = rings.places(viewport, gaze, self.flicker.size())?;
        let mut flicker = vec![Vec::new(); places.count()];
        let mut excess = vec![Vec::new(); places.count()];
        for y in 0..self.flicker.size().y {
            let values = self.flicker.row(y as usize).iter();
            let values = values.zip(self.excess_change.row(y as usize));
            for (ring, (f, e)) in places.of_row(y).zip(values) {
                if let Some(ring) = ring {
                    flicker[ring].push(*f);
                    excess[ring].push(*e);
                }
            }
        }
        let edges = rings.edges_deg();
        let ring = |(k, (flicker, excess)): (usize, (Vec<f64>, Vec<f64>))| {
            let some = !flicker.is_empty();
            RingFlicker {
                from_deg: edges[k],
                to_deg: edges.get(k + 1).copied(),
                pixels: flicker.len() as u64,
                mean: some.then(|| math::mean(&flicker)),
                excess_change: some.then(|| math::mean(&excess)),
                p99: some.then(|| p99(flicker)),
            }
        };
        let all = flicker.into_iter().zip(excess).enumerate();
        Ok(all.map(ring).collect())
    }
}

fn p99(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    math::quantile_sorted(&values, 0.99)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: UVec2 = UVec2::new(6, 4);

    fn plane(f: impl Fn(usize) -> f64) -> Plane {
        Plane::new(SIZE, (0..24).map(f).collect()).unwrap()
    }

    fn flicker(frames: &[(Plane, Plane)]) -> FlickerMap {
        let mut flicker = Flicker::new(SIZE).unwrap();
        for (test, reference) in frames {
            flicker.push(test, reference).unwrap();
        }
        flicker.finish().unwrap()
    }

    #[test]
    fn what_is_constantly_wrong_does_not_flicker() {
        // The reference moves; the picture is 7 levels too bright throughout, and moves with it.
        let frames: Vec<_> = (0..9)
            .map(|k| {
                let reference = move |i: usize| 10.0 * ((i + k) % 5) as f64;
                (plane(move |i| reference(i) + 7.0), plane(reference))
            })
            .collect();
        let found = flicker(&frames);
        assert_eq!(
            (found.mean, found.p99, found.mean_excess_change),
            (0.0, 0.0, 0.0)
        );
        assert_eq!(found.frames, 9);
    }

    #[test]
    fn what_alternates_flickers_by_its_amplitude() {
        // ±a about an error of 3: the standard deviation is a, each step changes by 2a too much.
        let a = |i: usize| i as f64 / 2.0;
        let frames: Vec<_> = (0..10)
            .map(|k| {
                let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                (plane(move |i| 103.0 + sign * a(i)), plane(|_| 100.0))
            })
            .collect();
        let found = flicker(&frames);
        for i in 0..24 {
            assert!((found.flicker.values()[i] - a(i)).abs() < 1e-12);
            assert!((found.excess_change.values()[i] - 2.0 * a(i)).abs() < 1e-12);
        }
        assert!((found.mean - a(23) / 2.0).abs() < 1e-12);
        // Type 7 of 0, ½ … 11½ at 0.99 · 23 = 22.77.
        assert!((found.p99 - 22.77 / 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_ramp_of_errors_has_the_deviation_of_a_ramp() {
        // 0 … n − 1 has variance (n² − 1)/12; a huge constant error beside it costs no digits.
        let frames: Vec<_> = (0..16)
            .map(|k| (plane(|_| 1e9 + f64::from(k)), plane(|_| 0.0)))
            .collect();
        let exact = ((16.0 * 16.0 - 1.0) / 12.0f64).sqrt();
        assert!((flicker(&frames).mean - exact).abs() < 1e-9);
    }

    #[test]
    fn what_lags_changes_less_than_its_reference() {
        let frames: Vec<_> = (0..5)
            .map(|k| (plane(|_| 50.0), plane(|_| 50.0 + 4.0 * f64::from(k))))
            .collect();
        let found = flicker(&frames);
        assert_eq!(found.mean_excess_change, -4.0);
        assert!((found.mean - 32f64.sqrt()).abs() < 1e-12, "0, 4 … 16");
    }

    #[test]
    fn rings_share_the_pixels_out() {
        let viewport = Viewport::symmetric(SIZE, 0.3).unwrap();
        let frames: Vec<_> = (0..4)
            .map(|k| (plane(|i| (k * i % 7) as f64), plane(|_| 2.0)))
            .collect();
        let found = flicker(&frames);
        let rings = Rings::new(vec![0.0, 6.0, 12.0, 60.0]).unwrap();
        let parts = found.rings(&viewport, DVec3::NEG_Z, &rings).unwrap();
        assert_eq!(parts.iter().map(|r| r.pixels).sum::<u64>(), 24);
        assert_eq!(
            (parts[3].pixels, parts[3].mean, parts[3].p99),
            (0, None, None)
        );
        let share = |r: &RingFlicker| r.mean.unwrap_or(0.0) * r.pixels as f64 / 24.0;
        let together: f64 = parts.iter().map(share).sum();
        assert!((together - found.mean).abs() < 1e-12 && found.mean > 0.0);
        let wrong = Viewport::symmetric(UVec2::new(5, 4), 0.3).unwrap();
        assert!(found.rings(&wrong, DVec3::NEG_Z, &rings).is_err());
        assert!(found.rings(&viewport, DVec3::ZERO, &rings).is_err());
    }

    #[test]
    fn what_is_no_sequence_is_refused() {
        assert!(Flicker::new(UVec2::new(0, 3)).is_err());
        let mut flicker = Flicker::new(SIZE).unwrap();
        let other = Plane::new(UVec2::new(4, 6), vec![0.0; 24]).unwrap();
        assert!(flicker.push(&other, &plane(|_| 0.0)).is_err());
        assert!(flicker.push(&plane(|_| 0.0), &other).is_err());
        assert_eq!(flicker.finish(), Err(QualityError::NoFrames));
    }

    #[test]
    fn threads_do_not_matter() {
        let frames: Vec<_> = (0..5)
            .map(|k| (plane(|i| (k * i) as f64 * 0.37), plane(|i| i as f64 * 1.1)))
            .collect();
        let run = |n| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(n)
                .build()
                .unwrap();
            pool.install(|| flicker(&frames))
        };
        assert_eq!(run(1), run(5));
    }
}
