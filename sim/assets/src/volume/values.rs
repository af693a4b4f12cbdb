use glam::{DAffine3, DMat3, DVec3, UVec3};
use thiserror::Error;

use super::Voxels;

/// Most voxels along one axis: rays find their place to a thousandth of a voxel in single precision.
const LONGEST_SIDE: u32 = 4096;
/// Most memory of one volume's voxels \[bytes\].
const MOST_BYTES: u64 = 1 << 31;

/// Which way a volume's world points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Frame {
    /// As its file or generator says, +y taken to be up.
    #[default]
    Plain,
    /// +x to a body's right, +y to its front, +z to its head, as NIfTI has it. What a file gives as
    /// left-posterior-superior (DICOM, MetaImage) is turned by half when it is read.
    Anatomical,
}

/// What a [`Volume`] is built from.
#[derive(Debug, Clone, PartialEq)]
pub struct VolumeParts {
    /// Voxels along x, y and z: each 2 to 4096.
    pub dims: UVec3,
    /// As many as the product of `dims`.
    pub voxels: Voxels,
    /// A voxel's value is `slope` times what is stored plus `intercept`.
    pub slope: f64,
    /// See `slope`.
    pub intercept: f64,
    /// From voxel indices (voxel (0, 0, 0) has its centre at the origin) to the world.
    pub world_from_index: DAffine3,
    /// Which way that world points.
    pub frame: Frame,
}

/// Scalar values on a lattice in space; between voxel centres they are interpolated trilinearly, outside
/// there is nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Volume {
    parts: VolumeParts,
    range: [f64; 2],
    replaced: usize,
}

/// Why parts do not make a volume.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum VolumeError {
    /// Sides that no volume has here.
    #[error("{x} x {y} x {z} voxels: each side must be from 2 to 4096, all together at most 2 GiB")]
    Dims {
        /// Along x.
        x: u64,
        /// Along y.
        y: u64,
        /// Along z.
        z: u64,
    },
    /// Another number of voxels than the sides say.
    #[error("{count} voxels for {dims}: must be {wanted}")]
    Count {
        /// How many there are.
        count: usize,
        /// The sides.
        dims: UVec3,
        /// Their product.
        wanted: u64,
    },
    /// No voxel is a finite number.
    #[error("no voxel is a finite number")]
    NothingFinite,
    /// Values are scaled by what is no usable number.
    #[error(
        "slope {slope}, intercept {intercept}: must be finite, the slope not 0, and so must be all values"
    )]
    Scale {
        /// The slope.
        slope: f64,
        /// The intercept.
        intercept: f64,
    },
    /// Axes that span no space.
    #[error(
        "axes {axes} from {origin}: steps must be 1e-9 to 1e6 long and span three dimensions, the origin within 1e6 of 0"
    )]
    Axes {
        /// The steps from voxel to voxel along x, y and z.
        axes: String,
        /// Where the first voxel is.
        origin: DVec3,
    },
}

/// Checks sides before memory is asked for them; gives the number of voxels.
///
/// # Errors
/// If a side is not 2 to 4096, or all voxels take more than 2 GiB.
pub(super) fn check_dims(dims: [u64; 3], bytes_each: u64) -> Result<(UVec3, usize), VolumeError> {
    let [x, y, z] = dims;
    let valid = dims
        .iter()
        .all(|n| (2..=u64::from(LONGEST_SIDE)).contains(n));
    // At most 2¹² each, so neither product overflows.
    if !valid || x * y * z * bytes_each > MOST_BYTES {
        return Err(VolumeError::Dims { x, y, z });
    }
    Ok((
        UVec3::new(x as u32, y as u32, z as u32),
        (x * y * z) as usize,
    ))
}

impl Volume {
    /// The volume that `parts` make. Voxels that are not finite become 0, or what is nearest to it among
    /// the others.
    ///
    /// # Errors
    /// If sides, number of voxels, scale or axes cannot be used, or no voxel is finite.
    pub fn build(mut parts: VolumeParts) -> Result<Self, VolumeError> {
        let dims = parts.dims;
        let sides = dims.to_array().map(u64::from);
        let (_, wanted) = check_dims(sides, 1)?;
        let count = parts.voxels.len();
        if count != wanted {
            let wanted = wanted as u64;
            return Err(VolumeError::Count {
                count,
                dims,
                wanted,
            });
        }
        if parts.voxels.bytes() as u64 > MOST_BYTES {
            let [x, y, z] = sides;
            return Err(VolumeError::Dims { x, y, z });
        }
        let (finite, replaced) = parts.voxels.finite_range();
        let [least, most] = finite.ok_or(VolumeError::NothingFinite)?;
        if replaced > 0 {
            let zero = -parts.intercept / parts.slope;
            let zero = if zero.is_finite() { zero } else { 0.0 };
            parts.voxels.replace_non_finite(zero.clamp(least, most));
        }
        let (slope, intercept) = (parts.slope, parts.intercept);
        let ends = [least, most].map(|x| slope * x + intercept);
        if slope == 0.0 || !slope.is_finite() || !ends.iter().all(|x| x.is_finite()) {
            return Err(VolumeError::Scale { slope, intercept });
        }
        check_axes(&parts.world_from_index)?;
        Ok(Self {
            range: [ends[0].min(ends[1]), ends[0].max(ends[1])],
            parts,
            replaced,
        })
    }

    /// Voxels along x, y and z.
    pub fn dims(&self) -> UVec3 {
        self.parts.dims
    }

    /// What is stored.
    pub fn voxels(&self) -> &Voxels {
        &self.parts.voxels
    }

    /// Slope and intercept by which a stored number becomes a value.
    pub fn scale(&self) -> [f64; 2] {
        [self.parts.slope, self.parts.intercept]
    }

    /// Least and greatest value.
    pub fn range(&self) -> [f64; 2] {
        self.range
    }

    /// How many voxels were not finite and have been replaced.
    pub fn replaced(&self) -> usize {
        self.replaced
    }

    /// From voxel indices to the world; whole numbers are voxel centres.
    pub fn world_from_index(&self) -> DAffine3 {
        self.parts.world_from_index
    }

    /// Which way the world points.
    pub fn frame(&self) -> Frame {
        self.parts.frame
    }

    /// The value of a voxel.
    ///
    /// # Panics
    /// If there is none.
    pub fn value(&self, voxel: UVec3) -> f64 {
        let dims = self.parts.dims;
        assert!(voxel.cmplt(dims).all(), "no voxel {voxel}");
        let [x, y, z] = voxel.to_array().map(|v| v as usize);
        let index = (z * dims.y as usize + y) * dims.x as usize + x;
        self.parts.slope * self.parts.voxels.get(index) + self.parts.intercept
    }

    /// The length of the shortest step from voxel to voxel along an axis, in the world.
    pub fn spacing(&self) -> f64 {
        let axes = self.parts.world_from_index.matrix3;
        let steps = [axes.x_axis, axes.y_axis, axes.z_axis].map(DVec3::length);
        steps.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// The smallest box that holds all voxel centres: two opposite corners, world.
    pub fn bounds(&self) -> [DVec3; 2] {
        let last = self.parts.dims.as_dvec3() - 1.0;
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for corner in 0..8 {
            let pick = |axis: usize| f64::from((corner >> axis) & 1) * last[axis];
            let index = DVec3::new(pick(0), pick(1), pick(2));
            let at = self.parts.world_from_index.transform_point3(index);
            low = low.min(at);
            high = high.max(at);
        }
        [low, high]
    }

    /// The same volume elsewhere: `to_from_world` is applied after what its file says.
    ///
    /// # Errors
    /// If the axes span no space any more.
    pub fn placed(mut self, to_from_world: DAffine3) -> Result<Self, VolumeError> {
        self.parts.world_from_index = to_from_world * self.parts.world_from_index;
        check_axes(&self.parts.world_from_index)?;
        Ok(self)
    }

    /// The same volume as it stands before a viewer who looks along −z with +y up: an anatomical one upright
    /// and facing the viewer, others as they are.
    pub fn facing_viewer(self) -> Self {
        match self.parts.frame {
            Frame::Plain => self,
            // The right to −x (the viewer's left), the front to +z, the head to +y.
            Frame::Anatomical => {
                let turn = DMat3::from_cols(DVec3::NEG_X, DVec3::Z, DVec3::Y);
                let parts = VolumeParts {
                    world_from_index: DAffine3::from_mat3(turn) * self.parts.world_from_index,
                    frame: Frame::Plain,
                    ..self.parts
                };
                Self { parts, ..self }
            }
        }
    }
}

fn check_axes(world_from_index: &DAffine3) -> Result<(), VolumeError> {
    let axes = world_from_index.matrix3;
    let steps = [axes.x_axis, axes.y_axis, axes.z_axis];
    let origin = world_from_index.translation;
    let lengths = steps.map(DVec3::length);
    let volume = axes.determinant().abs();
    // Of unit steps: 1 where they are orthogonal, 0 in a plane.
    let spans = volume / (lengths[0] * lengths[1] * lengths[2]);
    let usable = lengths.iter().all(|l| (1e-9..=1e6).contains(l))
        && origin.is_finite()
        && origin.abs().max_element() <= 1e6;
    if usable && spans > 1e-6 {
        return Ok(());
    }
    let axes = steps.map(|s| s.to_string()).join(", ");
    Err(VolumeError::Axes { axes, origin })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts(voxels: Voxels) -> VolumeParts {
        VolumeParts {
            dims: UVec3::new(2, 3, 4),
            voxels,
            slope: 2.0,
            intercept: -1.0,
            world_from_index: DAffine3::from_scale(DVec3::new(1.0, 2.0, 0.5)),
            frame: Frame::Plain,
        }
    }

    #[test]
    fn values_are_scaled_and_bounded() {
        let volume = Volume::build(parts(Voxels::U8((0..24).collect()))).unwrap();
        assert_eq!(volume.range(), [-1.0, 45.0]);
        assert_eq!(volume.value(UVec3::new(1, 2, 3)), 45.0);
        assert_eq!(volume.value(UVec3::new(0, 1, 0)), 3.0);
        assert_eq!(volume.bounds(), [DVec3::ZERO, DVec3::new(1.0, 4.0, 1.5)]);
        assert_eq!(volume.spacing(), 0.5);
    }

    #[test]
    fn what_is_not_finite_becomes_zero_or_what_is_nearest() {
        let mut v: Vec<f32> = (0..24).map(|k| k as f32).collect();
        v[3] = f32::NAN;
        v[9] = f32::INFINITY;
        let volume = Volume::build(parts(Voxels::F32(v.clone()))).unwrap();
        assert_eq!(volume.replaced(), 2);
        // Stored ½ is value 0.
        assert_eq!(volume.value(UVec3::new(1, 1, 0)), 0.0);
        let above: Vec<f32> = v.iter().map(|x| x + 10.0).collect();
        let volume = Volume::build(parts(Voxels::F32(above))).unwrap();
        assert_eq!(volume.value(UVec3::new(1, 1, 0)), 19.0);
        let nothing = Voxels::F64(vec![f64::NAN; 24]);
        assert_eq!(
            Volume::build(parts(nothing)),
            Err(VolumeError::NothingFinite)
        );
    }

    #[test]
    fn what_is_no_volume_is_refused() {
        let good = || parts(Voxels::U8(vec![1; 24]));
        let refused = |change: &dyn Fn(&mut VolumeParts)| {
            let mut parts = good();
            change(&mut parts);
            Volume::build(parts).is_err()
        };
        assert!(refused(&|p| p.dims.x = 1));
        assert!(refused(&|p| p.dims.z = 5));
        assert!(refused(&|p| p.slope = 0.0));
        assert!(refused(&|p| p.intercept = f64::NAN));
        assert!(refused(&|p| p.world_from_index.matrix3.x_axis = DVec3::Y));
        assert!(refused(&|p| p.world_from_index.translation.x = f64::NAN));
        assert!(check_dims([10_000; 3], 1).is_err());
        assert!(check_dims([u64::MAX; 3], 1).is_err());
        assert!(check_dims([4096, 4096, 128], 2).is_err());
    }

    #[test]
    fn a_head_looks_at_the_viewer() {
        let mut p = parts(Voxels::U8(vec![1; 24]));
        p.frame = Frame::Anatomical;
        p.world_from_index = DAffine3::IDENTITY;
        let volume = Volume::build(p).unwrap().facing_viewer();
        let axes = volume.world_from_index().matrix3;
        assert_eq!(axes.z_axis, DVec3::Y);
        assert_eq!(axes.y_axis, DVec3::Z);
        assert!(axes.determinant() > 0.0);
    }
}
