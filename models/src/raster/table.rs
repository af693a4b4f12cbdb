use glam::{DVec2, UVec2};

use super::{Real, Sampling};
use crate::{ModelError, Region};

/// Where and when every sample of a lattice looks: (u, v, t), position in the image \[px\] and time from 0
/// to 1. Bounds are taken over these numbers themselves, so they hold for any map, lens and scan, and need no
/// inverse of any.
#[derive(Debug, Clone, PartialEq)]
pub struct SampleTable<T> {
    lattice: UVec2,
    samples: Vec<Option<[T; 3]>>,
}

/// Positions are at most so far from the image's corner \[px\]: rounding and underflow are bounded for these.
const FARTHEST_PX: f64 = 1_048_576.0;

impl<T: Real> SampleTable<T> {
    /// The most samples.
    pub const MOST: u64 = 1 << 26;

    /// Of the live samples of a lattice, each in the middle of its cell.
    ///
    /// # Errors
    /// If the lattice is empty or has more than [`SampleTable::MOST`] samples, or a sample looks farther
    /// than 2²⁰ pixels off.
    ///
    /// # Panics
    /// If the region is for another lattice.
    pub fn new(sampling: &Sampling, lattice: UVec2, region: &Region) -> Result<Self, ModelError> {
        let count = u64::from(lattice.x) * u64::from(lattice.y);
        if !(1..=Self::MOST).contains(&count) {
            let value = format!("{} x {}", lattice.x, lattice.y);
            let valid = format!("1 to {} samples", Self::MOST);
            return Err(ModelError::range("lattice", value, valid));
        }
        let mut samples = Vec::with_capacity(count as usize);
        for y in 0..lattice.y {
            for x in 0..lattice.x {
                let sample = UVec2::new(x, y);
                let found = match region.is_live(sample) {
                    true => Some(Self::sample(sampling, sample, region)?),
                    false => None,
                };
                samples.push(found);
            }
        }
        Ok(Self { lattice, samples })
    }

    fn sample(sampling: &Sampling, sample: UVec2, region: &Region) -> Result<[T; 3], ModelError> {
        let at = sample.as_dvec2() + 0.5;
        let looks = match region {
            Region::Spans(_) => sampling.at_clamped(at),
            _ => sampling.at(at),
        };
        let ray: DVec2 = looks.ray;
        if ray.is_nan() || ray.abs().max_element() > FARTHEST_PX {
            let (value, valid) = (format!("{ray} of sample {sample}"), "within ±2^20");
            return Err(ModelError::range("position [px]", value, valid));
        }
        Ok([ray.x, ray.y, looks.time].map(T::nearest))
    }

    /// Samples across and down.
    pub fn lattice(&self) -> UVec2 {
        self.lattice
    }

    /// Where and when a sample looks; `None` if it is not live.
    ///
    /// # Panics
    /// If there is no such sample.
    pub fn get(&self, sample: UVec2) -> Option<[T; 3]> {
        assert!(sample.cmplt(self.lattice).all(), "no sample {sample}");
        self.samples[(sample.y * self.lattice.x + sample.x) as usize]
    }

    /// The live samples of the block from `first` on with `size` samples each way, cut off at the
    /// lattice's end.
    pub fn block(&self, first: UVec2, size: u32) -> impl Iterator<Item = (UVec2, [T; 3])> + '_ {
        let end = (first + size).min(self.lattice);
        let all =
            (first.y..end.y).flat_map(move |y| (first.x..end.x).map(move |x| UVec2::new(x, y)));
        all.filter_map(|s| self.get(s).map(|looks| (s, looks)))
    }
}
