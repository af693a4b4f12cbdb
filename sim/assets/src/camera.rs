use foveasim_models::math::{atan, cos, hypot, sin};
use foveasim_models::{Pose, Viewport};
use glam::{DMat3, DQuat, DVec3};

/// An eye at `position` that looks at `target` with the world's +y up; straight up or down, with −z
/// at the top. `None` if the two are the same point, or not finite.
pub fn look_at(position: DVec3, target: DVec3) -> Option<Pose> {
    let back = (position - target).try_normalize()?;
    let up = if hypot(back.x, back.z) > 1e-9 {
        DVec3::Y
    } else {
        DVec3::NEG_Z
    };
    let right = up.cross(back).try_normalize()?;
    let rotation = DMat3::from_cols(right, back.cross(right), back);
    let finite = position.is_finite() && target.is_finite();
    finite.then(|| Pose::new(position, DQuat::from_mat3(&rotation).normalize()))
}

/// An eye that sees a whole box (two opposite corners, world \[m\]) from the right, in front and above
/// (a three-quarter view), as near as `optics` allow.
///
/// The sphere about the box just touches the nearest edge of the image, with a twentieth to spare.
pub fn framing(bounds: [DVec3; 2], optics: &Viewport) -> Pose {
    const AROUND: f64 = 0.62;
    const ABOVE: f64 = 0.34;
    let centre = (bounds[0] + bounds[1]) / 2.0;
    // A single point is looked at from where a thing of 2 cm would be.
    let radius = (bounds[1] - bounds[0]).length().max(0.02) / 2.0;
    let [left, right, up, down] = optics.tan;
    let half = [-left, right, up, -down]
        .map(atan)
        .into_iter()
        .fold(f64::INFINITY, f64::min)
        // Off-axis optics may not see straight ahead; then the middle of the image is not theirs.
        .max(0.05);
    let towards_eye = DVec3::new(
        sin(AROUND) * cos(ABOVE),
        sin(ABOVE),
        cos(AROUND) * cos(ABOVE),
    );
    let distance = 1.05 * radius / sin(half);
    look_at(centre + towards_eye * distance, centre).expect("the eye is off the centre")
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, UVec2};

    use super::*;

    #[test]
    fn the_target_is_in_the_middle_and_up_is_up() {
        let optics = Viewport::symmetric(UVec2::new(200, 100), 1.0).unwrap();
        let eye = look_at(DVec3::new(3.0, 2.0, 5.0), DVec3::new(1.0, 1.0, 1.0)).unwrap();
        let see = |p: DVec3| optics.project(eye.inverse().point(p)).unwrap();
        assert!(see(DVec3::ONE).distance(DVec2::new(100.0, 50.0)) < 1e-9);
        assert!(see(DVec3::new(1.0, 1.5, 1.0)).y < 50.0);
        assert!(look_at(DVec3::Y, DVec3::ZERO).is_some());
        assert!(look_at(DVec3::ONE, DVec3::ONE).is_none());
        assert!(look_at(DVec3::NAN, DVec3::ONE).is_none());
    }

    #[test]
    fn all_corners_of_a_framed_box_are_in_the_image() {
        for size in [UVec2::new(960, 540), UVec2::new(100, 300)] {
            let optics = Viewport::symmetric(size, 0.7).unwrap();
            let bounds = [DVec3::new(-3.0, 10.0, 0.0), DVec3::new(5.0, 11.0, 2.0)];
            let eye = framing(bounds, &optics);
            for i in 0..8 {
                let pick = |k: usize| bounds[(i >> k) & 1][k];
                let corner = DVec3::new(pick(0), pick(1), pick(2));
                let px = optics.project(eye.inverse().point(corner)).unwrap();
                assert!(
                    px.cmpge(DVec2::ZERO).all() && px.cmple(size.as_dvec2()).all(),
                    "{px}"
                );
            }
        }
    }
}
