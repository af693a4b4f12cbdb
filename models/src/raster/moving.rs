use glam::{DVec2, DVec3};

use super::{Catches, Zenon};
use crate::ScanSkew;

/// A point of a scene in homogeneous display pixels (x/w, y/w; w > 0 in front of the eye), linear from the
/// frame's start to its end: object and viewer may both have moved (Friston 2019, §3.2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingPoint {
    /// At t = 0.
    pub start: DVec3,
    /// At t = 1.
    pub end: DVec3,
}

impl MovingPoint {
    /// At a time.
    pub fn at(&self, t: f64) -> DVec3 {
        self.start + (self.end - self.start) * t
    }

    /// The point at share `s` of the way to another, at every time.
    #[must_use]
    pub fn towards(&self, other: &Self, s: f64) -> Self {
        Self {
            start: self.start + (other.start - self.start) * s,
            end: self.end + (other.end - self.end) * s,
        }
    }

    /// How a scan over an image of `size` pixels catches it. With a lens, `skew` and `size` are those of
    /// the image that is seen, for which time is not linear in position: then it is a first guess.
    pub fn zenon(&self, skew: &ScanSkew, size: DVec2) -> Zenon {
        let along = |p: DVec3| (p.truncate() / size).dot(skew.direction());
        let (start, end) = (along(self.start), along(self.end));
        let w = [self.start.z, self.end.z - self.start.z];
        // The scan is at position x·d = t − t₀.
        Zenon::new([-skew.start(), 1.0], [start, end - start], w)
    }

    /// When it lights on a rolling display, all times of it.
    pub fn catches(&self, skew: &ScanSkew, size: DVec2) -> Catches {
        self.zenon(skew, size).catches()
    }
}

/// A triangle between three moving points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingTriangle(pub [MovingPoint; 3]);

impl MovingTriangle {
    /// From its corners at the start and at the end, homogeneous display pixels.
    pub fn new(start: [DVec3; 3], end: [DVec3; 3]) -> Self {
        Self([0, 1, 2].map(|i| MovingPoint {
            start: start[i],
            end: end[i],
        }))
    }

    /// The edge from corner `i` (0, 1, 2) to the next.
    ///
    /// # Panics
    /// If there is no such corner.
    pub fn edge(&self, i: usize) -> [MovingPoint; 2] {
        [self.0[i], self.0[(i + 1) % 3]]
    }
}
