use foveasim_assets::Volume;
use foveasim_lanes::wide::WIDTH;
use foveasim_models::math::sqrt;
use foveasim_models::{Role, Stream, View, Viewport};
use glam::{DAffine3, DMat3, DVec3};

use crate::options::Light;
use crate::{CastError, CastOptions, CastWork, Ray};

/// How far within the outermost voxel centres samples stay \[voxels\]: more than rounding moves them on
/// sides of 4096.
const WITHIN: f64 = 1.0 / 512.0;
/// Least and greatest factor on the base step.
const FACTORS: std::ops::RangeInclusive<f32> = 1.0 / 16.0..=4096.0;

/// Sixteen rays through a volume, in voxel indices.
#[derive(Debug, Clone)]
pub(crate) struct Packet {
    /// Where each ray's first sample lies.
    pub(crate) origin: [[f32; WIDTH]; 3],
    /// From one sample to the next.
    pub(crate) step: [[f32; WIDTH]; 3],
    /// Samples within the volume: whole numbers.
    pub(crate) samples: [f32; WIDTH],
    /// The step in base steps.
    pub(crate) factor: [f32; WIDTH],
    /// The ray's direction, one shortest voxel step long.
    pub(crate) along: [[f32; WIDTH]; 3],
    /// Cosine between the directions to the light and to the eye.
    pub(crate) light_eye: [f32; WIDTH],
}

impl Packet {
    pub(crate) const EMPTY: Self = Self {
        origin: [[0.0; WIDTH]; 3],
        step: [[0.0; WIDTH]; 3],
        samples: [0.0; WIDTH],
        factor: [1.0; WIDTH],
        along: [[0.0; WIDTH]; 3],
        light_eye: [1.0; WIDTH],
    };
}

/// A view of a volume: what its rays have in common.
#[derive(Debug)]
pub(crate) struct Sight {
    optics: Viewport,
    /// The eye, in voxel indices.
    eye: DVec3,
    /// From the eye's frame to voxel indices, one shortest voxel step long where a unit was.
    index_from_eye: DMat3,
    /// From the eye's frame to the world.
    world_from_eye: DMat3,
    /// Direction to the light, world, if it is not the eye.
    light: Option<DVec3>,
    /// Greatest index of a sample.
    last: DVec3,
    /// Base step, in shortest voxel steps.
    step: f64,
    jitter: Option<u64>,
}

impl Sight {
    pub(crate) fn new(
        geometry: &Geometry,
        view: &View,
        options: &CastOptions,
    ) -> Result<Self, CastError> {
        if !view.is_still() {
            return Err(CastError::MovingView);
        }
        let pose = view.poses[0];
        let world_from_eye = DMat3::from_quat(pose.orientation);
        let eye = geometry.index_from_world.transform_point3(pose.position);
        if !(eye.is_finite() && eye.abs().max_element() <= 1e9 && world_from_eye.is_finite()) {
            let valid = "finite, within 1e9 voxels of the volume";
            return Err(CastError::range("eye position", pose.position, valid));
        }
        let light = match options.phong.map(|p| p.light) {
            Some(Light::Towards(d)) => Some(d.normalize()),
            _ => None,
        };
        Ok(Self {
            optics: view.optics,
            eye,
            index_from_eye: geometry.index_from_world.matrix3 * world_from_eye * geometry.spacing,
            world_from_eye,
            light,
            last: geometry.last - WITHIN,
            step: options.step_voxels,
            jitter: options.jitter,
        })
    }

    /// Sets a lane of a packet to a ray, the `index`-th of its image or list, and counts it.
    #[inline]
    pub(crate) fn aim(
        &self,
        packet: &mut Packet,
        lane: usize,
        ray: Ray,
        index: usize,
        work: &mut CastWork,
    ) -> Result<(), CastError> {
        packet.samples[lane] = 0.0;
        let size = self.optics.size.as_dvec2();
        if !(ray.px.cmpge(glam::DVec2::ZERO).all() && ray.px.cmple(size).all()) {
            work.rays_off_screen += 1;
            return Ok(());
        }
        if !FACTORS.contains(&ray.step) {
            let step = ray.step;
            return Err(CastError::Step { ray: index, step });
        }
        work.rays += 1;
        let eye_direction = self.optics.direction(ray.px);
        let unit = 1.0 / sqrt(eye_direction.length_squared());
        let along = self.index_from_eye * eye_direction * unit;
        let step = along * (self.step * f64::from(ray.step));
        // Where the ray is within the volume, in steps from the eye.
        let to_low = (DVec3::splat(WITHIN) - self.eye) / step;
        let to_high = (self.last - self.eye) / step;
        // Along an axis that the ray does not follow, both are infinite: all of it or nothing.
        let enter = to_low.min(to_high).max_element().max(0.0);
        let exit = to_low.max(to_high).min_element();
        let shift = match self.jitter {
            Some(seed) => Stream::new(seed, Role::Jitter, index as u64).uniform(),
            None => 0.0,
        };
        let first = (enter - shift).ceil().max(0.0);
        let samples = (exit - shift).floor() - first + 1.0;
        if samples.is_nan() || samples < 1.0 {
            work.rays_missed += 1;
            return Ok(());
        }
        let origin = self.eye + step * (first + shift);
        for axis in 0..3 {
            packet.origin[axis][lane] = origin[axis] as f32;
            packet.step[axis][lane] = step[axis] as f32;
            packet.along[axis][lane] = along[axis] as f32;
        }
        packet.samples[lane] = samples as f32;
        packet.factor[lane] = ray.step;
        packet.light_eye[lane] = match self.light {
            Some(light) => {
                let world = self.world_from_eye * eye_direction * unit;
                -light.dot(world) as f32
            }
            None => 1.0,
        };
        Ok(())
    }
}

/// Where a volume lies.
#[derive(Debug)]
pub(crate) struct Geometry {
    pub(crate) index_from_world: DAffine3,
    /// Shortest voxel step, world.
    pub(crate) spacing: f64,
    /// Index of the last voxel along each axis.
    pub(crate) last: DVec3,
    /// Squared length of a normal, from a gradient in voxel indices: xx, yy, zz, 2xy, 2xz, 2yz. A gradient
    /// along an axis whose step is the shortest keeps its length.
    pub(crate) metric: [f32; 6],
    /// Direction to the light in voxel indices, if it is not the eye.
    pub(crate) light: Option<[f32; 3]>,
}

impl Geometry {
    pub(crate) fn new(volume: &Volume, options: &CastOptions) -> Result<Self, CastError> {
        let index_from_world = volume.world_from_index().inverse();
        let spacing = volume.spacing();
        let last = volume.dims().as_dvec3() - 1.0;
        // Longer than any ray.
        let bounds = volume.bounds();
        let longest = (bounds[1] - bounds[0]).length() / (spacing * options.step_voxels);
        if longest > f64::from(1u32 << 18) {
            let valid = "such that no ray has more than 262144 steps: voxels are much longer one way than \
                         another";
            return Err(CastError::range("step_voxels", options.step_voxels, valid));
        }
        let m = index_from_world.matrix3 * spacing;
        let g = m * m.transpose();
        let metric = [
            g.x_axis.x,
            g.y_axis.y,
            g.z_axis.z,
            2.0 * g.x_axis.y,
            2.0 * g.x_axis.z,
            2.0 * g.y_axis.z,
        ];
        let light = match options.phong.map(|p| p.light) {
            Some(Light::Towards(d)) => {
                let d = m * d.normalize();
                Some([d.x as f32, d.y as f32, d.z as f32])
            }
            _ => None,
        };
        Ok(Self {
            index_from_world,
            spacing,
            last,
            metric: metric.map(|v| v as f32),
            light,
        })
    }
}
