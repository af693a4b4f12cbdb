use foveasim_models::math::{asin, to_deg};
use foveasim_models::{Eye, Pose, Role, Stream, View, Viewport};
use foveasim_volume::orbit;
use glam::{DVec2, DVec3};

use super::Bruder2019;

/// A camera and its gazes.
#[derive(Debug, Clone)]
pub(super) struct Camera {
    pub(super) azimuth_deg: f64,
    pub(super) elevation_deg: f64,
    /// Of that at which the whole volume is seen.
    pub(super) distance: f64,
    pub(super) view: View,
    pub(super) gazes: Vec<DVec2>,
}

/// Nearest, of the distance at which the whole volume is seen.
const NEAREST: f64 = 0.5;

impl Camera {
    /// Cameras around a volume, evenly over the sphere and over distances up to that at which the whole volume is seen; they
    /// look at its middle (§5).
    pub(super) fn draw(asked: &Bruder2019, bounds: [DVec3; 2], viewport: &Viewport) -> Vec<Self> {
        let size = viewport.size.as_dvec2();
        let camera = |k: u32| {
            let random = &mut Stream::new(asked.seed, Role::Population, u64::from(k));
            let azimuth_deg = random.range(-180.0, 180.0);
            // Short of straight above, where no direction is up.
            let elevation_deg = to_deg(asin(random.range(-0.999, 0.999)));
            let distance = random.range(NEAREST, 1.0);
            let pose = orbit(bounds, viewport, azimuth_deg, elevation_deg, distance);
            let gazes = (0..asked.gazes)
                .map(|_| (DVec2::new(random.uniform(), random.uniform()) * size).floor() + 0.5)
                .collect();
            Self {
                azimuth_deg,
                elevation_deg,
                distance,
                view: View::still(Eye::Cyclopean, *viewport, pose.unwrap_or(Pose::IDENTITY)),
                gazes,
            }
        };
        (0..asked.cameras).map(camera).collect()
    }
}
