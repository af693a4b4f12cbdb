use foveasim_models::Nanos;
use glam::DVec3;

use crate::{error, noted, parse};

#[test]
fn times_keep_all_their_decimals_and_frames_become_ours() {
    let r = parse(
        "# timestamp tx ty tz qx qy qz qw\n1311868163.8697 1 2 3 0 0 0 1\n\
         1311868163.869700001  1 2 3 1 0 0 0 \n\n1311868163.869700001 4 5 6 0 0 0 1.0\n",
    )
    .unwrap();
    let samples = r.pose.as_ref().unwrap().samples();
    assert_eq!(samples[0].t, Nanos(1_311_868_163_869_700_000));
    assert_eq!(samples[1].t, Nanos(1_311_868_163_869_700_001));
    assert_eq!(samples.len(), 3, "both samples of an equal time stay");
    assert!(noted(
        &r,
        "1 sample with the time of the sample before; the later one counts"
    ));

    let pose = samples[0].value.unwrap();
    assert_eq!(
        pose.position,
        DVec3::new(1.0, 3.0, -2.0),
        "their z is up, ours is y"
    );
    // A camera that is not turned looks along its world's +Z, which is up; its +Y (down in the
    // picture) along +Y, which is our -Z.
    assert!((pose.direction(DVec3::NEG_Z) - DVec3::Y).length() < 1e-15);
    assert!((pose.direction(DVec3::NEG_Y) - DVec3::NEG_Z).length() < 1e-15);
}

#[test]
fn what_is_wrong_is_named() {
    assert_eq!(
        error("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0\n"),
        "f: line 2: 7 fields; want 8"
    );
    assert!(error("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0").contains("line 2: truncated"));
    assert!(error("1 0 0 0 0 0 0 1\n0.5 0 0 0 0 0 0 1\n").contains("line 2: time goes back"));
    assert!(error("1 0 0 0 0 0 0 0\n").contains("qx,qy,qz,qw = `0,0,0,0`: must be a quaternion"));
    assert!(error("1 0 inf 0 0 0 0 1\n").contains("ty = `inf`"));
    assert!(error("1e30 0 0 0 0 0 0 1\n").contains("timestamp = `1e30`: must be a time [s]"));
}
