use foveasim_models::{GazeDirection, Pose};
use glam::DVec3;

use crate::study_objects::objects;
use crate::{STUDY_FRAMES, study_camera};

/// Where a viewer of the fly-through looks, frame by frame: at the centre of the nearest object that
/// comes nearer.
///
/// Guenter et al. 2012, §6, note 11: "Gaze control was performed by recording the gaze position when
/// constantly looking at the nearest approaching object and then using those recorded positions in the
/// performance test." Here an object is looked at from when the eye is free until its centre leaves the
/// display or begins to recede; then the eye goes on, within a frame, to the nearest one whose centre is
/// on the display and approaches. With none there it looks straight ahead. Objects hidden by others are
/// looked at all the same.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyGaze {
    frames: Vec<(GazeDirection, Option<usize>)>,
}

/// Half the study's display as tangents: 51 cm wide, 59 cm away, 9/16 as high (Guenter 2012, §5).
const HALF_DISPLAY_TAN: [f64; 2] = [51.0 / 118.0, 51.0 / 118.0 * 9.0 / 16.0];

impl StudyGaze {
    /// Records the gaze over the whole fly-through of the scene of `seed`.
    pub fn record(seed: u64) -> Self {
        let centres: Vec<DVec3> = objects(seed)
            .into_iter()
            .map(|o| o.world_from_object.pose.position)
            .collect();
        let camera = |frame: u32| study_camera(f64::from(frame) / f64::from(STUDY_FRAMES), seed);
        let mut target = None;
        let frames = (0..STUDY_FRAMES)
            .map(|frame| {
                let (now, next) = (camera(frame), camera(frame + 1));
                let worth_looking = |&object: &usize| {
                    let centre = centres[object];
                    on_display(now, centre)
                        && next.position.distance(centre) < now.position.distance(centre)
                };
                target = target.filter(worth_looking).or_else(|| {
                    let distance = |&object: &usize| now.position.distance(centres[object]);
                    (0..centres.len())
                        .filter(worth_looking)
                        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
                });
                let direction = target.map_or(GazeDirection::AHEAD, |object| {
                    GazeDirection::from_vector(now.inverse().point(centres[object]))
                });
                (direction, target)
            })
            .collect();
        Self { frames }
    }

    /// Where the eye looks in `frame`, in its own frame; in the last one from then on.
    pub fn direction(&self, frame: u32) -> GazeDirection {
        self.at(frame).0
    }

    /// Index of the object that it looks at in `frame`, row by row over the grid, if any.
    pub fn target(&self, frame: u32) -> Option<usize> {
        self.at(frame).1
    }

    fn at(&self, frame: u32) -> (GazeDirection, Option<usize>) {
        self.frames[(frame as usize).min(self.frames.len() - 1)]
    }
}

fn on_display(camera: Pose, point: DVec3) -> bool {
    let p = camera.inverse().point(point);
    let [x, y] = HALF_DISPLAY_TAN;
    p.z < 0.0 && p.x.abs() <= -p.z * x && p.y.abs() <= -p.z * y
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_stays_on_the_display_and_on_what_approaches() {
        for seed in [1, 2] {
            let gaze = StudyGaze::record(seed);
            let objects = objects(seed);
            let (mut changes, mut ahead, mut last) = (0, 0, None);
            for frame in 0..STUDY_FRAMES {
                let d = gaze.direction(frame).vector();
                let [x, y] = HALF_DISPLAY_TAN;
                assert!(d.x.abs() <= -d.z * x * 1.000_001 && d.y.abs() <= -d.z * y * 1.000_001);
                let target = gaze.target(frame);
                ahead += u32::from(target.is_none());
                changes += u32::from(target != last);
                if let Some(object) = target {
                    let camera = study_camera(f64::from(frame) / f64::from(STUDY_FRAMES), seed);
                    let centre = objects[object].world_from_object.pose.position;
                    let seen = camera
                        .direction(d)
                        .cross((centre - camera.position).normalize());
                    assert!(
                        seen.length() < 1e-9,
                        "frame {frame} looks beside its target"
                    );
                }
                last = target;
            }
            // 160 m through rows 8 m apart: an object or two a row, and the edges of the display.
            assert!((20..150).contains(&changes), "{changes}");
            // Beyond the last row there is nothing left to look at.
            assert!(ahead < STUDY_FRAMES / 10, "{ahead}");
        }
    }

    #[test]
    fn it_is_the_same_everywhere() {
        let gaze = StudyGaze::record(1);
        for (frame, target, azimuth_deg, elevation_deg) in [
            (0, 369, -14.036_243_467_926_48, 9.431_291_135_167_46),
            (1500, 269, -20.788_380_990_022_88, 7.894_968_177_336_78),
            (3000, 169, -17.580_461_989_838_14, -4.825_034_044_991_66),
        ] {
            let seen = gaze.direction(frame);
            assert_eq!(gaze.target(frame), Some(target));
            let off = GazeDirection::new(azimuth_deg, elevation_deg).angle_to_deg(seen);
            assert!(off < 1e-9, "frame {frame}: {seen:?}");
        }
        assert_eq!(gaze.direction(u32::MAX), gaze.direction(STUDY_FRAMES - 1));
    }

    #[test]
    fn the_first_target_is_the_nearest() {
        let gaze = StudyGaze::record(1);
        let camera = study_camera(0.0, 1);
        let nearest = objects(1)
            .iter()
            .map(|o| o.world_from_object.pose.position)
            .filter(|c| on_display(camera, *c))
            .map(|c| c.distance(camera.position))
            .fold(f64::INFINITY, f64::min);
        let target = objects(1)[gaze.target(0).unwrap()]
            .world_from_object
            .pose
            .position;
        assert_eq!(target.distance(camera.position), nearest);
    }
}
