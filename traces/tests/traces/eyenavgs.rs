use foveasim_models::{GazeDirection, Pose, Recording, Sample};
use foveasim_traces::{ReadOptions, TraceError, read};
use glam::DVec3;

use crate::{noted, parse};

const HEADER: &str = "ViewIndex,FOV1,FOV2,FOV3,FOV4,PositionX,PositionY,PositionZ,QuaternionX,QuaternionY,\
QuaternionZ,QuaternionW,GazePosX,GazePosY,GazePosZ,GazeQX,GazeQY,GazeQZ,GazeQW,Timestamp\n";

/// An eye's row: x of its position, head quaternion, gaze position x, gaze quaternion, time.
fn row(view: u8, x: f64, head: &str, gaze_x: f64, gaze: &str, t: i64) -> String {
    let fov = if view == 0 {
        "-0.942,0.698"
    } else {
        "-0.698,0.942"
    };
    format!("{view},{fov},-0.942,0.733,{x},1,2,{head},{gaze_x},0,0,{gaze},{t}\n")
}

const STRAIGHT: &str = "0.0,0.0,0.0,1.0";
/// 90° to the left about +Y, three decimals.
const LEFT: &str = "0.0,0.707,0.0,0.707";
/// 90° and 10° more to the left; 90° and 10° less.
const LEFT_100: &str = "0.0,0.766,0.0,0.643";
const LEFT_80: &str = "0.0,0.643,0.0,0.766";

fn scaled(text: &str, scale: f64) -> Recording {
    let options = ReadOptions {
        scale: Some(scale),
        ..ReadOptions::default()
    };
    read(text.as_bytes(), "f", &options).unwrap()
}

#[test]
fn two_rows_are_one_frame() {
    let text = [
        HEADER,
        &row(0, 1.0, LEFT, 0.5, LEFT_100, 0),
        &row(1, 1.126, LEFT, 0.5, LEFT_80, 4),
        &row(0, 1.0, LEFT, 0.5, LEFT_100, 14),
        &row(1, 1.126, LEFT, 0.0, STRAIGHT, 18),
        &row(0, 1.0, LEFT, 0.0, STRAIGHT, 28),
        &row(1, 1.126, LEFT, 0.7, STRAIGHT, 32),
    ]
    .concat();
    let r = scaled(&text, 2.0);
    let (gaze, pose) = (
        r.gaze.as_ref().unwrap().samples(),
        r.pose.as_ref().unwrap().samples(),
    );
    assert_eq!(
        pose.iter().map(|s| s.t.as_ms()).collect::<Vec<_>>(),
        [0.0, 14.0, 28.0]
    );
    let head = pose[0].value.unwrap();
    assert!(
        (head.position - DVec3::new(1.063, 1.0, 2.0) / 2.0).length() < 1e-15,
        "metres: {head:?}"
    );
    assert!(
        (head.orientation.length() - 1.0).abs() < 1e-15,
        "renormalised"
    );
    assert!(
        (head.direction(DVec3::NEG_Z) - DVec3::NEG_X).length() < 1e-12,
        "turned to the left"
    );

    // The eyes look 10° to the left and 10° to the right of the head: ahead in the mean.
    assert!(
        gaze[0].value.unwrap().azimuth_deg.abs() < 1e-9,
        "{:?}",
        gaze[0]
    );
    let left_alone = gaze[1].value.unwrap().azimuth_deg;
    assert!(
        (left_alone + 10.0).abs() < 0.06,
        "left is negative; 3 decimals: {left_alone}"
    );
    assert_eq!(
        gaze[2].value, None,
        "an identity is no direction, wherever GazePos is"
    );
    assert!(noted(&r, "1 frame with gaze of one eye alone"));
    assert!(noted(&r, "1 row with a GazePos but no gaze direction"));
    assert!(noted(&r, "3 decimals") && noted(&r, "steps of some 0.115 deg"));
    assert!(noted(
        &r,
        "left eye sees 54.0 deg left, 40.0 right, 54.0 down, 42.0 up"
    ));
    assert!(noted(
        &r,
        "2 scene units to a metre, as given; eyes 63.0 mm apart"
    ));
}

#[test]
fn the_scale_is_estimated_from_the_eyes() {
    let text = [
        HEADER,
        &row(0, 0.0, STRAIGHT, 0.0, LEFT, 0),
        &row(1, 0.171_072, STRAIGHT, 0.0, LEFT, 4),
    ]
    .concat();
    let r = parse(&text).unwrap();
    assert!(noted(
        &r,
        "2.700 scene units to a metre, estimated from eyes 0.1711 units apart"
    ));
    let alone = parse(&[HEADER, &row(0, 0.5, STRAIGHT, 0.0, LEFT, 0)].concat()).unwrap();
    assert!(noted(&alone, "scene units taken as metres"));
    assert_eq!(
        alone.pose.unwrap().samples()[0].value.unwrap().position.x,
        0.5
    );
}

#[test]
fn a_row_without_its_partner() {
    let text = [
        HEADER,
        &row(0, 0.0, STRAIGHT, 0.0, LEFT, 0),
        &row(1, 0.06, STRAIGHT, 0.0, LEFT, 4),
        &row(0, 0.0, STRAIGHT, 0.0, LEFT, 14),
        &row(0, 0.0, STRAIGHT, 0.0, LEFT, 28),
        &row(1, 0.06, STRAIGHT, 0.0, LEFT, 32),
        &row(1, 0.06, STRAIGHT, 0.0, LEFT, 46),
    ]
    .concat();
    let r = scaled(&text, 1.0);
    let frames: Vec<_> = r
        .pose
        .as_ref()
        .unwrap()
        .samples()
        .iter()
        .map(|s| (s.t.as_ms(), s.value.unwrap().position.x))
        .collect();
    assert_eq!(
        frames,
        [(0.0, 0.03), (14.0, 0.03), (28.0, 0.03), (46.0, 0.03)],
        "each in the middle"
    );
    assert!(noted(&r, "2 frames without the other eye's row"));
}

/// Times [ms], x of the head [m] and gaze azimuth [deg, whole] of all frames.
fn frames(r: &Recording) -> Vec<(f64, f64, Option<f64>)> {
    let poses = r.pose.as_ref().unwrap().samples();
    let gaze = r.gaze.as_ref().unwrap().samples();
    let frame = |(p, g): (&Sample<Pose>, &Sample<GazeDirection>)| {
        let x = (p.value.unwrap().position.x * 1e6).round() / 1e6;
        (p.t.as_ms(), x, g.value.map(|g| g.azimuth_deg.round() + 0.0))
    };
    poses.iter().zip(gaze).map(frame).collect()
}

#[test]
fn rows_of_two_frames_are_not_averaged() {
    // The file begins with a right row; the left rows of the frames at 28 and 56 ms are missing.
    let text = [
        HEADER,
        &row(1, 1.06, STRAIGHT, 0.0, LEFT, 4),
        &row(0, 1.0, STRAIGHT, 0.0, LEFT, 14),
        &row(1, 1.06, STRAIGHT, 0.0, LEFT, 18),
        &row(1, 3.06, STRAIGHT, 0.0, LEFT, 32),
        &row(0, 5.0, STRAIGHT, 0.0, LEFT, 42),
        &row(1, 5.06, STRAIGHT, 0.0, LEFT, 46),
        &row(1, 7.06, STRAIGHT, 0.0, LEFT, 60),
    ]
    .concat();
    let r = scaled(&text, 1.0);
    let left = Some(-90.0);
    assert_eq!(
        frames(&r),
        [
            (4.0, 1.03, left),
            (14.0, 1.03, left),
            (32.0, 3.03, left),
            (42.0, 5.03, left),
            (60.0, 7.03, left)
        ]
    );
    assert!(noted(&r, "2 frames of two rows each"));
    assert!(noted(&r, "3 frames without the other eye's row, moved"));
    assert!(!noted(&r, "not paired"));
}

#[test]
fn rows_whose_head_has_turned_are_of_two_frames() {
    // The right row of the first frame and the left row of the second are missing.
    let text = [
        HEADER,
        &row(0, 1.0, STRAIGHT, 0.0, LEFT, 0),
        &row(1, 2.0, LEFT_80, 0.0, LEFT, 18),
        &row(0, 1.0, STRAIGHT, 0.0, LEFT, 28),
        &row(1, 1.06, STRAIGHT, 0.0, LEFT, 32),
    ]
    .concat();
    let r = scaled(&text, 1.0);
    // The right eye's position is moved to its left: along the head's own X axis, turned by 80°.
    let x = 2.0 - 0.03 * 80.0_f64.to_radians().cos();
    let got = frames(&r);
    assert_eq!(got.len(), 3);
    assert_eq!(got[0], (0.0, 1.03, Some(-90.0)));
    assert!((got[1].1 - x).abs() < 1e-4, "{:?}", got[1]);
    assert_eq!((got[1].0, got[1].2), (18.0, Some(-10.0)));
    assert!(noted(&r, "1 right eye's row not paired"));
    assert!(noted(&r, "2 frames without the other eye's row"));
}

#[test]
fn sessions_joined_in_one_file() {
    let frame = |t| row(0, 0.0, STRAIGHT, 0.0, LEFT, t) + &row(1, 0.06, STRAIGHT, 0.0, LEFT, t + 4);
    let text = [
        HEADER,
        &frame(0),
        &frame(14),
        &frame(2000),
        &frame(0),
        &frame(14),
    ]
    .concat();
    let r = parse(&text).unwrap();
    assert_eq!(r.pose.as_ref().unwrap().samples().len(), 3);
    assert!(noted(
        &r,
        "2 sessions joined in one file (3 and 2 frames); segment 1 is read, the longest"
    ));
    let segment = |n| {
        read(
            text.as_bytes(),
            "f",
            &ReadOptions {
                segment: Some(n),
                ..ReadOptions::default()
            },
        )
    };
    assert_eq!(segment(2).unwrap().pose.unwrap().samples().len(), 2);
    assert!(matches!(
        segment(3),
        Err(TraceError::NoSuchSegment {
            wanted: 3,
            segments: 2,
            ..
        })
    ));
    // A clock that goes back but not to a session's start is damage.
    let damaged = [HEADER, &frame(5000), &frame(4000)].concat();
    assert!(
        parse(&damaged)
            .unwrap_err()
            .to_string()
            .contains("line 4: time goes back")
    );
}

#[test]
fn what_is_wrong_is_named() {
    let error = |row: &str| parse(&format!("{HEADER}{row}")).unwrap_err().to_string();
    assert!(
        error(&row(2, 0.0, STRAIGHT, 0.0, LEFT, 0))
            .contains("ViewIndex = `2`: must be 0 (left) or 1")
    );
    let half = "0.0,0.0,0.0,0.5";
    assert!(
        error(&row(0, 0.0, half, 0.0, LEFT, 0))
            .contains("QuaternionX,QuaternionY,QuaternionZ,QuaternionW = `0.0,0.0,0.0,0.5`")
    );
    assert!(error(&row(0, f64::NAN, STRAIGHT, 0.0, LEFT, 0)).contains("PositionX = `NaN`"));
    assert!(error("0,0,0").contains("line 2: truncated"));
    let short = HEADER.replace("PositionZ,", "");
    assert!(
        parse(&format!("{short}1\n"))
            .unwrap_err()
            .to_string()
            .contains("no column PositionZ")
    );
}
