use foveasim_assets::Volume;
use rayon::prelude::*;

/// The highest level: differences of two fit 16 bits.
pub(crate) const HIGHEST: i16 = i16::MAX;

/// Values of voxels as levels of 15 bits.
///
/// Whole numbers whose range is no longer keep their differences: one level is one step, nothing is lost.
/// Others are rounded to the nearest of 32,768 levels of the range: off by at most a 65,534th of it.
#[derive(Debug)]
pub(crate) struct Levels {
    /// Voxels along x, y and z.
    pub(crate) dims: [usize; 3],
    /// x runs fastest.
    pub(crate) levels: Vec<i16>,
    /// The value of level 0.
    pub(crate) lowest: f64,
    /// What a level adds.
    pub(crate) per_level: f64,
}

impl Levels {
    pub(crate) fn new(volume: &Volume) -> Self {
        let dims = volume.dims().to_array().map(|n| n as usize);
        let [slope, intercept] = volume.scale();
        let [low, high] = volume.range();
        // What is stored for the lowest value, and how many steps there are to the highest.
        let first = (low - intercept) / slope;
        let span = (high - low) / slope;
        let exact = volume.voxels().is_integer() && span.abs() <= f64::from(HIGHEST);
        let (lowest, per_level, per_stored) = if exact {
            (low, slope.abs(), slope.signum())
        } else if span == 0.0 {
            (low, 1.0, 0.0)
        } else {
            let steps = f64::from(HIGHEST);
            (low, (high - low) / steps, steps / span)
        };
        // Whole numbers stay whole, however they are scaled.
        let first = if exact { first.round() } else { first };
        let row = dims[0] * dims[1];
        let mut levels = vec![0i16; row * dims[2]];
        levels
            .par_chunks_mut(row)
            .enumerate()
            .for_each(|(z, slice)| {
                volume.voxels().for_each(z * row, row, |k, stored| {
                    // From 0 to HIGHEST but for rounding, which must not lead beyond.
                    let level = (stored - first) * per_stored + 0.5;
                    slice[k] = (level as i16).max(0);
                });
            });
        Self {
            dims,
            levels,
            lowest,
            per_level,
        }
    }

    /// The level of the voxel nearest to a place, which may lie outside.
    #[inline]
    pub(crate) fn at(&self, place: [isize; 3]) -> i16 {
        let [x, y, z]: [usize; 3] =
            std::array::from_fn(|a| place[a].clamp(0, self.dims[a] as isize - 1) as usize);
        self.levels[(z * self.dims[1] + y) * self.dims[0] + x]
    }

    /// Level of a voxel, and the differences of its neighbours along x, y and z: twice its gradient, but
    /// once at the border, where the voxel stands for the neighbour that is not there.
    #[inline]
    pub(crate) fn with_gradient(&self, [x, y, z]: [isize; 3]) -> [i16; 4] {
        let at = |dx, dy, dz| self.at([x + dx, y + dy, z + dz]);
        [
            at(0, 0, 0),
            at(1, 0, 0) - at(-1, 0, 0),
            at(0, 1, 0) - at(0, -1, 0),
            at(0, 0, 1) - at(0, 0, -1),
        ]
    }
}

#[cfg(test)]
mod tests {
    use foveasim_assets::{Frame, VolumeParts, Voxels};
    use glam::{DAffine3, UVec3};

    use super::*;

    fn volume(voxels: Voxels, slope: f64, intercept: f64) -> Volume {
        Volume::build(VolumeParts {
            dims: UVec3::new(2, 2, 2),
            voxels,
            slope,
            intercept,
            world_from_index: DAffine3::IDENTITY,
            frame: Frame::Plain,
        })
        .unwrap()
    }

    fn worst(volume: &Volume) -> f64 {
        let levels = Levels::new(volume);
        let [slope, intercept] = volume.scale();
        let error = |k: usize| {
            let value = slope * volume.voxels().get(k) + intercept;
            let level = levels.lowest + levels.per_level * f64::from(levels.levels[k]);
            (value - level).abs()
        };
        (0..8).map(error).fold(0.0, f64::max)
    }

    #[test]
    fn whole_numbers_lose_nothing() {
        let bytes = Voxels::U8(vec![3, 255, 0, 7, 9, 100, 200, 254]);
        for (slope, intercept) in [(1.0, 0.0), (0.37, -1024.0), (-2.5, 3.0)] {
            assert!(worst(&volume(bytes.clone(), slope, intercept)) < 1e-9);
        }
        let words = vec![-1024, 3071, 0, 1, 2, -1000, 17, 3];
        assert_eq!(worst(&volume(Voxels::I16(words), 1.0, 0.0)), 0.0);
    }

    #[test]
    fn others_are_off_by_a_65534th_of_the_range_at_most() {
        let v = vec![-1.0, 0.1, 0.2, 0.33, 0.0, 1e-9, 4.0, 3.999];
        assert!(worst(&volume(Voxels::F64(v), 2.0, 1.0)) <= 10.0 / 65_534.0 * 1.000_001);
        let v = vec![0, 65_535, 1, 2, 3, 40_000, 50_001, 9];
        assert!(worst(&volume(Voxels::U16(v), 1.0, 0.0)) <= 65_535.0 / 65_534.0);
        assert_eq!(worst(&volume(Voxels::F32(vec![2.5; 8]), 1.0, 0.0)), 0.0);
    }
}
