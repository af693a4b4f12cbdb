//! The samples in `traces/data`: one per format, made here from one synthetic recording.
//!
//! Where one is not what the code makes, the test leaves the new one in the target folder and says where.

use std::fmt::Write as _;
use std::path::PathBuf;

use foveasim_models::{GazeDirection, Nanos, Rate, Recording};
use foveasim_traces::{ReadOptions, SynthSpec, info, read_path, resample_recording, synth, write};
use glam::{DQuat, DVec3};

const EYE_SEPARATION_M: f64 = 0.064;
const SCALE: f64 = 2.0;

fn truth(rate: f64) -> Recording {
    let spec = SynthSpec {
        seed: 5,
        duration: Nanos(1_000_000_000),
        gaze_rate_hz: rate,
        pose_rate_hz: rate,
        blinks_per_minute: 60.0,
        ..SynthSpec::default()
    };
    synth(&spec).unwrap()
}

/// The rotation from −Z to a direction of gaze.
fn gaze_rotation(g: GazeDirection) -> DQuat {
    DQuat::from_rotation_y(-g.azimuth_deg.to_radians())
        * DQuat::from_rotation_x(g.elevation_deg.to_radians())
}

fn eyenavgs() -> String {
    let r = truth(60.0);
    let mut text = "ViewIndex,FOV1,FOV2,FOV3,FOV4,PositionX,PositionY,PositionZ,QuaternionX,QuaternionY,\
                    QuaternionZ,QuaternionW,GazePosX,GazePosY,GazePosZ,GazeQX,GazeQY,GazeQZ,GazeQW,Timestamp\n"
        .to_owned();
    let poses = r.pose.as_ref().unwrap().samples();
    for (g, p) in r.gaze.as_ref().unwrap().samples().iter().zip(poses) {
        let head = p.value.unwrap();
        for (view, side, fov) in [(0, -0.5, "-0.942,0.698"), (1, 0.5, "-0.698,0.942")] {
            let eye = head.point(DVec3::X * side * EYE_SEPARATION_M) * SCALE;
            let q = head.orientation;
            let (at, gaze) = match g.value {
                Some(g) => (eye, q * gaze_rotation(g)),
                None => (DVec3::ZERO, DQuat::IDENTITY),
            };
            let ms = (g.t.as_ms().round() as i64) + 4 * view;
            let _ = writeln!(
                text,
                "{view},{fov},-0.942,0.733,{:.3},{:.3},{:.3},{:.3},{:.3},{:.3},{:.3},{:.3},{:.3},{:.3},\
                 {:.3},{:.3},{:.3},{:.3},{ms}",
                eye.x,
                eye.y,
                eye.z,
                q.x,
                q.y,
                q.z,
                q.w,
                at.x,
                at.y,
                at.z,
                gaze.x,
                gaze.y,
                gaze.z,
                gaze.w
            );
        }
    }
    text
}

fn screen_centred() -> String {
    let mut text = "timestamp\tleft_x\tleft_y\tright_x\tright_y\n".to_owned();
    for s in truth(120.0).gaze.unwrap().samples() {
        let _ = write!(text, "{:.3}", 5000.0 + s.t.as_ms());
        let place = s.value.map(|g| {
            let v = g.vector() * 650.0 / -g.vector().z;
            [v.x * 1920.0 / 528.0, -v.y * 1080.0 / 297.0]
        });
        let _ = match place {
            Some([x, y]) => writeln!(text, "\t{:.2}\t{y:.2}\t{:.2}\t{y:.2}", x - 3.0, x + 3.0),
            None => writeln!(text, "\tnan\tnan\tnan\tnan"),
        };
    }
    text
}

fn tum() -> String {
    let mut text = "# synthetic\n# timestamp tx ty tz qx qy qz qw\n".to_owned();
    let theirs_from_ours = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    for s in truth(100.0).pose.unwrap().samples() {
        let pose = s.value.unwrap();
        let q = theirs_from_ours * pose.orientation * DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0);
        let p = pose.position;
        let _ = writeln!(
            text,
            "{}.{:04} {:.4} {:.4} {:.4} {:.4} {:.4} {:.4} {:.4}",
            1_700_000_000 + s.t.0 / 1_000_000_000,
            s.t.0 % 1_000_000_000 / 100_000,
            p.x,
            -p.z,
            p.y,
            q.x,
            q.y,
            q.z,
            q.w
        );
    }
    text
}

fn own() -> String {
    let mut bytes = Vec::new();
    let rate = Rate::from_hz("hz", 100.0).unwrap();
    write(
        &resample_recording(&truth(200.0), rate, Nanos(20_000_000)).unwrap(),
        &mut bytes,
    )
    .unwrap();
    String::from_utf8(bytes).unwrap()
}

fn samples() -> [(&'static str, String); 4] {
    [
        ("eyenavgs.csv", eyenavgs()),
        ("screen_centred.tsv", screen_centred()),
        ("tum.txt", tum()),
        ("foveasim.csv", own()),
    ]
}

fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("data")
        .join(name)
}

#[test]
fn they_are_what_this_makes() {
    for (name, text) in samples() {
        let kept = std::fs::read_to_string(path(name)).unwrap_or_default();
        if kept != text {
            let made = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
            std::fs::write(&made, &text).unwrap();
            panic!(
                "{name} differs from what is made now; if that is meant, copy {}",
                made.display()
            );
        }
    }
}

/// The largest angle between gaze that was read and the truth [deg], and how many samples were compared.
fn gaze_error(read: &Recording, truth: &Recording) -> (f64, usize) {
    let pairs: Vec<_> = read
        .gaze
        .as_ref()
        .unwrap()
        .samples()
        .iter()
        .zip(truth.gaze.as_ref().unwrap().samples())
        .collect();
    assert!(
        pairs
            .iter()
            .all(|(a, b)| a.value.is_some() == b.value.is_some())
    );
    let errors: Vec<_> = pairs
        .iter()
        .filter_map(|(a, b)| Some(a.value?.angle_to_deg(b.value?)))
        .collect();
    (errors.iter().copied().fold(0.0, f64::max), errors.len())
}

#[test]
fn they_read_back_as_what_they_were_made_from() {
    let read = |name: &str| read_path(&path(name), &ReadOptions::default()).unwrap();

    let options = ReadOptions {
        scale: Some(SCALE),
        ..ReadOptions::default()
    };
    let (r, t) = (
        read_path(&path("eyenavgs.csv"), &options).unwrap(),
        truth(60.0),
    );
    let (error, n) = gaze_error(&r, &t);
    // A quaternion whose components are off by up to 0.0005 is off by up to 2 · √4 · 0.0005 rad =
    // 0.115°; head and gaze are two of them.
    assert!(error < 0.23 && n > 40, "{error}° over {n}");
    for (a, b) in r
        .pose
        .as_ref()
        .unwrap()
        .samples()
        .iter()
        .zip(t.pose.as_ref().unwrap().samples())
    {
        let (a, b) = (a.value.unwrap(), b.value.unwrap());
        assert!((a.position - b.position).length() < 0.0005 * 1.8 / SCALE + 1e-9);
        assert!(a.angle_to_deg(b) < 0.12);
    }

    let (error, n) = gaze_error(&read("screen_centred.tsv"), &truth(120.0));
    // 0.01 px are 0.00024°.
    assert!(error < 0.000_3 && n > 90, "{error}° over {n}");

    let (r, t) = (read("tum.txt"), truth(100.0));
    for (a, b) in r
        .pose
        .as_ref()
        .unwrap()
        .samples()
        .iter()
        .zip(t.pose.as_ref().unwrap().samples())
    {
        assert_eq!(a.t - b.t, Nanos(1_700_000_000_000_000_000));
        let (a, b) = (a.value.unwrap(), b.value.unwrap());
        assert!((a.position - b.position).length() < 0.0001 && a.angle_to_deg(b) < 0.012);
    }

    let about = info(&read("foveasim.csv"));
    assert!((about.gaze.unwrap().rate_hz - 100.0).abs() < 1e-9 && about.pose.is_some());
}
