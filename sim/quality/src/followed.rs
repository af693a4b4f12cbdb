use foveasim_models::{Viewport, math};
use glam::{DVec2, DVec3, UVec2};
use rayon::prelude::*;

use crate::{Plane, QualityError, Rings};

/// Flicker of the points that a picture shows, followed along their motion, against a reference
/// sequence: one point for each pixel of some frame.
///
/// The error of a point in a frame is test − reference at the place where it is seen, in luma of 8-bit
/// sRGB values, bilinear between pixels \[grey levels of 255\]. Its flicker is the standard deviation
/// of that error over the frames that see it (of the population). Blur and other errors that stay
/// with what they are on do not count, however the picture moves; twinkling, crawling and trembling
/// do. It is the temporal consistency of video (Lai et al. 2018, §4.3, the warping error) with the
/// motion known instead of estimated, over all frames instead of two, and taken of the difference to
/// a reference, so that what truly changes does not count.
#[derive(Debug, Clone)]
pub struct FollowedFlicker {
    size: UVec2,
    frames: u32,
    points: Vec<Moments>,
}

/// What is kept of one point.
#[derive(Debug, Clone, Copy, Default)]
struct Moments {
    seen: u32,
    mean: f64,
    /// Sum of squared deviations from the mean (Welford 1962).
    squares: f64,
}

/// What a [`FollowedFlicker`] found, point by point.
#[derive(Debug, Clone, PartialEq)]
pub struct FollowedMap {
    size: UVec2,
    /// Flicker of each point, row by row of the frame that they are the pixels of \[grey levels\];
    /// `None` where it was seen in less than half of the frames.
    pub flicker: Vec<Option<f64>>,
    /// Mean flicker \[grey levels\]; `None` if no point was followed.
    pub mean: Option<f64>,
}

impl FollowedFlicker {
    /// No frames yet, of points that are the pixels of a frame of `size`.
    ///
    /// # Errors
    /// If that is no pixels.
    pub fn new(size: UVec2) -> Result<Self, QualityError> {
        let count = size.x as usize * size.y as usize;
        if count == 0 {
            return Err(QualityError::Empty { size });
        }
        Ok(Self {
            size,
            frames: 0,
            points: vec![Moments::default(); count],
        })
    }

    /// Takes the next frame and its reference, and where each point is seen in it \[px\]: `None` if
    /// it is not, and none counts whose four pixels around are not all in the frame.
    ///
    /// # Errors
    /// If one of the planes has another size, or there is not one place for each point.
    pub fn push(
        &mut self,
        test: &Plane,
        reference: &Plane,
        places: &[Option<DVec2>],
    ) -> Result<(), QualityError> {
        for plane in [test, reference] {
            if plane.size() != self.size {
                return Err(QualityError::SizesDiffer {
                    a: plane.size(),
                    b: self.size,
                });
            }
        }
        if places.len() != self.points.len() {
            return Err(QualityError::Length {
                size: self.size,
                given: places.len(),
            });
        }
        self.frames += 1;
        self.points
            .par_iter_mut()
            .zip(places)
            .for_each(|(point, place)| {
                let error = place.and_then(|px| between(test, reference, px));
                if let Some(error) = error {
                    point.seen += 1;
                    let before = error - point.mean;
                    point.mean += before / f64::from(point.seen);
                    point.squares += before * (error - point.mean);
                }
            });
        Ok(())
    }

    /// What all frames together show.
    ///
    /// # Errors
    /// If there were none.
    pub fn finish(self) -> Result<FollowedMap, QualityError> {
        if self.frames == 0 {
            return Err(QualityError::NoFrames);
        }
        let flicker = |p: &Moments| {
            let deviation = || math::sqrt(p.squares.max(0.0) / f64::from(p.seen));
            (p.seen > 0 && 2 * p.seen >= self.frames).then(deviation)
        };
        let flicker: Vec<_> = self.points.iter().map(flicker).collect();
        Ok(FollowedMap {
            size: self.size,
            mean: mean(flicker.iter().flatten().copied().collect()),
            flicker,
        })
    }
}

impl FollowedMap {
    /// Mean flicker by ring of eccentricity about `gaze` (eye frame, any length) on the image plane of
    /// the frame that the points are the pixels of \[grey levels\]; `None` where none was followed.
    ///
    /// # Errors
    /// If the viewport does not have the frame's pixels, or the gaze is no direction.
    pub fn rings(
        &self,
        viewport: &Viewport,
        gaze: DVec3,
        rings: &Rings,
    ) -> Result<Vec<Option<f64>>, QualityError> {
        let places = rings.places(viewport, gaze, self.size)?;
        let mut all = vec![Vec::new(); places.count()];
        for (y, row) in (0..).zip(self.flicker.chunks(self.size.x as usize)) {
            for (ring, flicker) in places.of_row(y).zip(row) {
                if let (Some(ring), Some(flicker)) = (ring, flicker) {
                    all[ring].push(*flicker);
                }
            }
        }
        Ok(all.into_iter().map(mean).collect())
    }
}

fn mean(values: Vec<f64>) -> Option<f64> {
    (!values.is_empty()).then(|| math::mean(&values))
}

/// test − reference at a place, bilinear between the pixels around it, if they are all there.
fn between(test: &Plane, reference: &Plane, px: DVec2) -> Option<f64> {
    let p = px - 0.5;
    let low = p.floor();
    let last = test.size().as_dvec2() - 2.0;
    let inside = low.cmpge(DVec2::ZERO).all() && low.cmple(last).all();
    if !inside {
        return None;
    }
    let (x, y, f) = (low.x as usize, low.y as usize, p - low);
    let row = |y: usize| {
        let error = |x: usize| test.row(y)[x] - reference.row(y)[x];
        (1.0 - f.x) * error(x) + f.x * error(x + 1)
    };
    Some((1.0 - f.y) * row(y) + f.y * row(y + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: UVec2 = UVec2::new(16, 6);

    fn plane(f: impl Fn(f64) -> f64) -> Plane {
        let value = |i: u32| f(f64::from(i % SIZE.x));
        Plane::new(SIZE, (0..SIZE.x * SIZE.y).map(value).collect()).unwrap()
    }

    /// Where each pixel of frame 0 is when everything has moved by `shift` pixels to the right.
    fn places(shift: f64) -> Vec<Option<DVec2>> {
        let middle = |i: u32| DVec2::new(f64::from(i % SIZE.x) + 0.5, f64::from(i / SIZE.x) + 0.5);
        (0..SIZE.x * SIZE.y)
            .map(|i| Some(middle(i) + DVec2::new(shift, 0.0)))
            .collect()
    }

    #[test]
    fn what_moves_with_the_picture_does_not_flicker_and_what_twinkles_does() {
        let mut still = FollowedFlicker::new(SIZE).unwrap();
        let mut twinkles = still.clone();
        for k in 0..6 {
            let shift = f64::from(k);
            let reference = plane(|x| 100.0 + 3.0 * (x - shift));
            // Wrong by an amount that each point keeps; then by ±2 besides.
            let wrong = move |x: f64| 103.0 + 4.0 * (x - shift);
            let sign = if k % 2 == 0 { 2.0 } else { -2.0 };
            still
                .push(&plane(wrong), &reference, &places(shift))
                .unwrap();
            twinkles
                .push(&plane(|x| wrong(x) + sign), &reference, &places(shift))
                .unwrap();
        }
        let (still, twinkles) = (still.finish().unwrap(), twinkles.finish().unwrap());
        assert!(still.mean.unwrap() < 1e-9, "{:?}", still.mean);
        for (k, flicker) in twinkles.flicker.iter().enumerate() {
            // Points of the last row start at the frame's edge; those of the right columns leave it.
            let followed = k / 16 < 5 && k % 16 < 13;
            assert_eq!(flicker.is_some(), followed, "{k}");
            if followed && k % 16 < 10 {
                assert!((flicker.unwrap() - 2.0).abs() < 1e-9, "{k}: {flicker:?}");
            }
        }
        let viewport = Viewport::symmetric(SIZE, 0.4).unwrap();
        let rings = Rings::new(vec![0.0, 8.0]).unwrap();
        let found = twinkles.rings(&viewport, DVec3::NEG_Z, &rings).unwrap();
        assert!((found[0].unwrap() - 2.0).abs() < 0.1, "{found:?}");
    }

    #[test]
    fn what_does_not_fit_is_an_error() {
        let mut flicker = FollowedFlicker::new(SIZE).unwrap();
        let (even, other) = (plane(|_| 1.0), Plane::new(UVec2::ONE, vec![0.0]).unwrap());
        let sizes = flicker.push(&even, &other, &places(0.0));
        assert!(matches!(sizes, Err(QualityError::SizesDiffer { .. })));
        let few = flicker.push(&even, &even, &[None]);
        assert!(matches!(few, Err(QualityError::Length { given: 1, .. })));
        assert_eq!(flicker.finish(), Err(QualityError::NoFrames));
        assert!(FollowedFlicker::new(UVec2::new(0, 3)).is_err());
        let mut unseen = FollowedFlicker::new(SIZE).unwrap();
        let nowhere = vec![Some(DVec2::NAN); 96];
        unseen.push(&even, &even, &nowhere).unwrap();
        assert_eq!(unseen.finish().unwrap().mean, None);
    }
}
