use foveasim_models::{Nanos, exp_so3};
use glam::{DQuat, DVec3};

/// Holes longer than this are not integrated across: the head may have turned anywhere.
const LONGEST_STEP: Nanos = Nanos(100_000_000);

/// A head's orientation from its angular velocity, from an arbitrary start.
///
/// The rate at the middle of a step is the mean of the two at its ends, and is constant over the step
/// (the exponential map), so that the error of a step is of third order in its length. A gyroscope's
/// bias makes the orientation drift: differences over a second hold, differences over minutes do not.
#[derive(Debug, Default)]
pub(super) struct Gyroscope {
    orientation: DQuat,
    previous: Option<(Nanos, DVec3)>,
    pub(super) holes: usize,
}

impl Gyroscope {
    /// The orientation at `t`, from the angular velocity there \[rad/s\], head axes.
    pub(super) fn turn(&mut self, t: Nanos, rate: DVec3) -> DQuat {
        if let Some((then, before)) = self.previous {
            let step = t - then;
            if step > LONGEST_STEP {
                self.holes += 1;
            } else {
                let turn = 0.5 * (before + rate) * step.as_secs();
                self.orientation = (self.orientation * exp_so3(turn)).normalize();
            }
        }
        self.previous = Some((t, rate));
        self.orientation
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_steady_turn_is_exact_and_holes_are_not_bridged() {
        let mut gyroscope = Gyroscope::default();
        let rate = DVec3::new(0.3, -1.2, 0.4);
        let mut q = DQuat::IDENTITY;
        for ms in 0..=1000 {
            q = gyroscope.turn(Nanos(ms * 1_000_000), rate);
        }
        let want = exp_so3(rate);
        assert!(q.angle_between(want) < 1e-7, "{q} {want}");
        assert_eq!(gyroscope.turn(Nanos(2_000_000_000), rate), q);
        assert_eq!(gyroscope.holes, 1);
    }
}
