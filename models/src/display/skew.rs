use glam::DVec2;

use super::{ScanClock, ScanDirection};
use crate::ModelError;

/// When pixels of a rolling display light: at t = t₀ + x·d, with x the position in units of the image's
/// width and height, and d the skew direction (Friston 2019, §3.1.2); what of d is missing to 1 is
/// blanking. Where a component of d is negative, t₀ moves t back into 0..=1.
///
/// The paper calls d = (0, 0.9) a scan along x; by t = x·d it runs along y, downwards, and so it does here.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanSkew {
    start: f64,
    direction: DVec2,
}

impl ScanSkew {
    /// With skew `direction`; the scan begins at t = 0.
    ///
    /// # Errors
    /// If the sizes of both parts are not finite and together at most 1.
    pub fn new(direction: DVec2) -> Result<Self, ModelError> {
        let reach = direction.x.abs() + direction.y.abs();
        if reach.is_nan() || reach > 1.0 {
            let valid = "parts whose sizes sum to at most 1, so that times are from 0 to 1";
            return Err(ModelError::range("scan direction", direction, valid));
        }
        let start = (-direction).max(DVec2::ZERO);
        Ok(Self {
            start: start.x + start.y,
            direction,
        })
    }

    /// Of the part of an image of `size` pixels that is `part` pixels large from `first` on: the same times at the
    /// same places.
    #[must_use]
    pub fn of_part(&self, first: DVec2, part: DVec2, size: DVec2) -> Self {
        Self {
            start: self.time(first, size),
            direction: self.direction * part / size,
        }
    }

    /// The time of position 0, 0.
    pub fn start(&self) -> f64 {
        self.start
    }

    /// How much later a position lights, per width and per height of the image.
    pub fn direction(&self) -> DVec2 {
        self.direction
    }

    /// When position `px` of an image of `size` pixels lights; from 0 to 1 on the image.
    pub fn time(&self, px: DVec2, size: DVec2) -> f64 {
        self.start + (px / size).dot(self.direction)
    }
}

impl ScanClock {
    /// When pixels are scanned, as shares of a refresh: [`ScanClock::row_offset`] over the period, before it
    /// is rounded.
    pub fn skew(&self) -> ScanSkew {
        let total = f64::from(self.total_lines);
        let [active, before] = [self.active_lines, self.lines_before].map(|n| f64::from(n) / total);
        let picture = self.picture_skew();
        ScanSkew {
            start: before + active * picture.start,
            direction: active * picture.direction,
        }
    }

    /// When pixels are scanned, from 0 at the edge scanned first to 1 at the one scanned last: between
    /// the two poses of a [`View`](crate::View).
    pub fn picture_skew(&self) -> ScanSkew {
        let (start, direction) = match self.direction {
            ScanDirection::Down => (0.0, DVec2::Y),
            ScanDirection::Up => (1.0, DVec2::NEG_Y),
            ScanDirection::Right => (0.0, DVec2::X),
            ScanDirection::Left => (1.0, DVec2::NEG_X),
        };
        ScanSkew { start, direction }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rate;

    #[test]
    fn times_are_those_of_rows() {
        use ScanDirection::{Down, Left, Right, Up};
        let rate = Rate::from_hz("f", 90.0).unwrap();
        for direction in [Down, Up, Right, Left] {
            let clock = ScanClock {
                direction,
                lines_before: 7,
                ..ScanClock::new(rate, 1000, [900, 1000])
            };
            for row in [0, 1, 333, 999, 1000] {
                let px = match direction.across() {
                    true => DVec2::new(f64::from(row), 13.0),
                    false => DVec2::new(13.0, f64::from(row)),
                };
                let time = clock.skew().time(px, DVec2::splat(1000.0));
                let wanted = clock.row_offset(row).0 as f64;
                let off = time * rate.period().0 as f64 - wanted;
                assert!((-1.0..=2.0).contains(&off), "{direction:?} {row}: {off}");
            }
        }
    }

    #[test]
    fn parts_light_with_the_whole() {
        let size = DVec2::new(640.0, 480.0);
        let whole = ScanSkew::new(DVec2::new(-0.2, 0.7)).unwrap();
        let (first, part) = (DVec2::new(100.0, 40.0), DVec2::new(64.0, 32.0));
        let cut = whole.of_part(first, part, size);
        // At three samples to the pixel.
        for px in [DVec2::ZERO, DVec2::new(33.0, 7.0), part] {
            let (a, b) = (whole.time(first + px, size), cut.time(px * 3.0, part * 3.0));
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
    }

    #[test]
    fn times_stay_within_the_refresh() {
        for (x, y) in [
            (1.0, 0.0),
            (0.0, 0.9),
            (-0.3, 0.7),
            (-0.5, -0.4),
            (0.0, 0.0),
        ] {
            let skew = ScanSkew::new(DVec2::new(x, y)).unwrap();
            let times = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)]
                .map(|(x, y)| skew.time(DVec2::new(x, y) * 640.0, DVec2::splat(640.0)));
            assert!(times.iter().all(|t| (0.0..=1.0).contains(t)), "{times:?}");
            assert!(times.contains(&0.0));
        }
        for (x, y) in [
            (0.6, 0.5),
            (f64::NAN, 0.0),
            (0.0, f64::NEG_INFINITY),
            (-2.0, 0.0),
        ] {
            assert!(ScanSkew::new(DVec2::new(x, y)).is_err());
        }
    }
}
