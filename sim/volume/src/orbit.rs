use foveasim_assets::look_at;
use foveasim_models::math::{atan, cos, sin, to_rad};
use foveasim_models::{Pose, Viewport};
use glam::DVec3;

/// An eye that looks at the middle of a box (two opposite corners, world) from `azimuth_deg` to the right of
/// +z and `elevation_deg` above it, so far that the sphere about the box just fits into `optics`, times
/// `distance`. `None` if that is no place to look from: straight above or below is one, numbers that are not
/// finite, or a distance of 0 are not.
pub fn orbit(
    bounds: [DVec3; 2],
    optics: &Viewport,
    azimuth_deg: f64,
    elevation_deg: f64,
    distance: f64,
) -> Option<Pose> {
    let centre = (bounds[0] + bounds[1]) / 2.0;
    let radius = (bounds[1] - bounds[0]).length() / 2.0;
    let [left, right, up, down] = optics.tan;
    let half = [-left, right, up, -down]
        .map(atan)
        .into_iter()
        .fold(f64::INFINITY, f64::min)
        // Off-axis optics may not see straight ahead.
        .max(0.05);
    let (azimuth, elevation) = (to_rad(azimuth_deg), to_rad(elevation_deg));
    let towards_eye = DVec3::new(
        sin(azimuth) * cos(elevation),
        sin(elevation),
        cos(azimuth) * cos(elevation),
    );
    look_at(
        centre + towards_eye * (distance * radius / sin(half)),
        centre,
    )
}

#[cfg(test)]
mod tests {
    use glam::UVec2;

    use super::*;

    #[test]
    fn the_whole_sphere_is_seen() {
        let optics = Viewport::symmetric(UVec2::new(100, 60), 0.5).unwrap();
        let bounds = [DVec3::new(-1.0, 2.0, 3.0), DVec3::new(5.0, 4.0, 9.0)];
        for (azimuth, elevation) in [(0.0, 0.0), (130.0, -40.0), (20.0, 90.0)] {
            let eye = orbit(bounds, &optics, azimuth, elevation, 1.0).unwrap();
            let centre = eye.inverse().point(DVec3::new(2.0, 3.0, 6.0));
            assert!(centre.x.abs() < 1e-9 && centre.y.abs() < 1e-9);
            // The nearest edge touches the sphere: sin of the half angle is radius over distance.
            let radius = DVec3::new(3.0, 1.0, 3.0).length();
            let half = atan(0.3);
            assert!((radius / -centre.z - sin(half)).abs() < 1e-12);
        }
        assert!(orbit(bounds, &optics, 0.0, 0.0, 0.0).is_none());
        assert!(orbit(bounds, &optics, f64::NAN, 0.0, 1.0).is_none());
    }
}
