use glam::{DQuat, DVec2, DVec3};

/// A rigid transform: rotate, then move. `world_from_head` maps head to world coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Position of the inner frame's origin in the outer frame \[m\].
    pub position: DVec3,
    /// Rotation from the inner to the outer frame; unit length.
    pub orientation: DQuat,
}

impl Pose {
    /// No movement.
    pub const IDENTITY: Self = Self {
        position: DVec3::ZERO,
        orientation: DQuat::IDENTITY,
    };

    /// A pose from position \[m\] and unit quaternion.
    pub fn new(position: DVec3, orientation: DQuat) -> Self {
        Self {
            position,
            orientation,
        }
    }

    /// `a_from_b * b_from_c = a_from_c`.
    #[must_use]
    pub fn then(self, inner: Self) -> Self {
        Self {
            position: self.position + self.orientation * inner.position,
            orientation: (self.orientation * inner.orientation).normalize(),
        }
    }

    /// `a_from_b` to `b_from_a`.
    #[must_use]
    pub fn inverse(self) -> Self {
        let orientation = self.orientation.conjugate();
        Self {
            position: -(orientation * self.position),
            orientation,
        }
    }

    /// Maps a point.
    pub fn point(self, p: DVec3) -> DVec3 {
        self.position + self.orientation * p
    }

    /// Maps a direction.
    pub fn direction(self, d: DVec3) -> DVec3 {
        self.orientation * d
    }

    /// Between this pose (`f = 0`) and `other` (`f = 1`): linear in position, and along the shorter
    /// great arc in rotation.
    #[must_use]
    pub fn interpolate(self, other: Self, f: f64) -> Self {
        Self {
            position: self.position + (other.position - self.position) * f,
            orientation: self.orientation.slerp(other.orientation, f).normalize(),
        }
    }

    /// The angle between the two orientations \[deg\], 0 to 180.
    pub fn angle_to_deg(self, other: Self) -> f64 {
        let q = self.orientation.conjugate() * other.orientation;
        let sine = crate::math::sqrt(q.x * q.x + q.y * q.y + q.z * q.z);
        crate::math::to_deg(2.0 * crate::math::atan2(sine, q.w.abs()))
    }
}

/// The rotation by a vector's length \[rad\] about it: the exponential map of SO(3).
pub fn exp_so3(v: DVec3) -> DQuat {
    let angle = crate::math::sqrt(v.length_squared());
    // sin(x/2)/x is 1/2 to the last bit for an angle this small.
    let s = if angle < 1e-9 {
        0.5
    } else {
        crate::math::sin(0.5 * angle) / angle
    };
    DQuat::from_xyzw(v.x * s, v.y * s, v.z * s, crate::math::cos(0.5 * angle))
}

/// The axis of a rotation, as long as its (shorter) angle \[rad\]: the logarithm of SO(3).
pub fn log_so3(q: DQuat) -> DVec3 {
    let q = if q.w < 0.0 { -q } else { q };
    let axis = q.xyz();
    let sine = crate::math::sqrt(axis.length_squared());
    let scale = if sine < 1e-12 {
        2.0
    } else {
        2.0 * crate::math::atan2(sine, q.w) / sine
    };
    axis * scale
}

/// A rectangle in pixels, edges at `min` and `max`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rect {
    /// Top-left corner.
    pub min: DVec2,
    /// Bottom-right corner.
    pub max: DVec2,
}

impl Rect {
    /// The overlap of two rectangles; zero size (never negative) where they do not meet.
    #[must_use]
    pub fn intersection(self, other: Self) -> Self {
        let min = self.min.max(other.min);
        Self {
            min,
            max: self.max.min(other.max).max(min),
        }
    }

    /// Width and height.
    pub fn size(self) -> DVec2 {
        self.max - self.min
    }

    /// Width times height.
    pub fn area(self) -> f64 {
        let size = self.size();
        size.x * size.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_and_composition() {
        let a = Pose::new(DVec3::new(1.0, 2.0, 3.0), DQuat::from_rotation_y(0.3));
        let b = Pose::new(DVec3::new(-1.0, 0.5, 0.0), DQuat::from_rotation_x(-1.1));
        let p = DVec3::new(0.2, -0.7, 4.0);
        assert!((a.then(b).point(p) - a.point(b.point(p))).length() < 1e-15 * 16.0);
        assert!((a.inverse().point(a.point(p)) - p).length() < 1e-15 * 16.0);
        assert!((a.angle_to_deg(b) - b.angle_to_deg(a)).abs() < 1e-12);
    }

    #[test]
    fn exponential_and_logarithm_undo_each_other() {
        for v in [
            DVec3::ZERO,
            DVec3::new(1e-14, -2e-13, 0.0),
            DVec3::new(0.3, -1.2, 0.4),
            DVec3::new(0.0, 3.1, 0.1),
        ] {
            let q = exp_so3(v);
            assert!((log_so3(q) - v).length() < 1e-14 * 8.0, "{v}");
            assert!(
                (log_so3(-q) - v).length() < 1e-14 * 8.0,
                "both signs are one rotation"
            );
        }
        let turned = exp_so3(DVec3::Y * 0.7);
        assert!(turned.angle_between(DQuat::from_rotation_y(0.7)) < 1e-7);
    }

    #[test]
    fn rectangles_that_do_not_meet_have_no_area() {
        let a = Rect {
            min: DVec2::ZERO,
            max: DVec2::ONE,
        };
        let b = Rect {
            min: DVec2::splat(2.0),
            max: DVec2::splat(3.0),
        };
        assert_eq!(a.intersection(b).area(), 0.0);
    }
}
