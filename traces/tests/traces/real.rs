//! Published recordings, where they are at hand (`shared/data` beside the project).

use std::path::PathBuf;

use foveasim_models::{Nanos, Recording};
use foveasim_traces::{ReadOptions, SeriesInfo, info, read_path, require_gaze, write};

use crate::noted;

#[expect(clippy::print_stderr, reason = "a test that is skipped says so")]
pub(crate) fn find(name: &str) -> Option<PathBuf> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let found = ["../../shared/data", "../shared/data"].map(|d| root.join(d).join(name));
    let path = found.into_iter().find(|p| p.exists());
    if path.is_none() {
        eprintln!("skipped: {name} is not here");
    }
    path
}

fn read(name: &str, options: &ReadOptions) -> Option<Recording> {
    find(name).map(|path| read_path(&path, options).unwrap_or_else(|e| panic!("{e}")))
}

fn eyenavgs(name: &str, scale: f64) -> Option<(Recording, SeriesInfo, SeriesInfo)> {
    let options = ReadOptions {
        scale: Some(scale),
        ..ReadOptions::default()
    };
    let r = read(&format!("head/eyenavgs/{name}"), &options)?;
    assert_eq!(r.format, "eyenavgs");
    let about = info(&r);
    Some((r, about.gaze?, about.pose?))
}

/// Low and high of a coordinate.
fn extent(about: &SeriesInfo, name: &str) -> (f64, f64) {
    let (_, low, high) = about
        .extents
        .iter()
        .find(|e| e.0 == name)
        .expect("a coordinate's name");
    (*low, *high)
}

#[test]
fn user102_is_two_sessions() {
    let Some((r, gaze, pose)) = eyenavgs("user102_london.csv", 0.53) else {
        return;
    };
    assert!(noted(
        &r,
        "2 sessions joined in one file (1517 and 5414 frames); segment 2 is read"
    ));
    assert_eq!((pose.samples, gaze.missing), (5414, 5414));
    assert!(noted(&r, "eyes 62.3 mm apart"));
    let options = ReadOptions {
        segment: Some(1),
        ..ReadOptions::default()
    };
    let first = read("head/eyenavgs/user102_london.csv", &options).unwrap();
    assert_eq!(first.pose.as_ref().unwrap().samples().len(), 1517);
    assert_eq!(first.span().unwrap().0, Nanos(0));
}

#[test]
fn user103_and_110_and_117_look_ahead_and_a_little_down() {
    for (name, scale, frames) in [
        ("user103_truck.csv", 0.76, 4549),
        ("user110_playroom.csv", 2.7, 4375),
        ("user117_treehill.csv", 1.0, 7154),
    ] {
        let Some((r, gaze, pose)) = eyenavgs(name, scale) else {
            return;
        };
        assert_eq!(
            (gaze.samples, gaze.missing, pose.samples),
            (frames, 0, frames),
            "{name}"
        );
        let (left, right) = extent(&gaze, "azimuth_deg");
        let (down, up) = extent(&gaze, "elevation_deg");
        // Taken in the wrong frame, gaze would go all around.
        assert!(
            left > -45.0 && right < 45.0 && down > -45.0 && up < 30.0,
            "{name}: {left} {right} {down} {up}"
        );
        let samples = require_gaze(&r).unwrap().samples();
        let mean = samples
            .iter()
            .filter_map(|s| s.value)
            .map(|g| g.azimuth_deg)
            .sum::<f64>()
            / frames as f64;
        assert!(mean.abs() < 2.0, "{name}: {mean}");
        let (low, high) = extent(&pose, "yaw_deg");
        assert!(high - low > 180.0, "{name}: the head does turn");
        assert!(noted(&r, "3 decimals"));
    }
}

#[test]
fn user104_and_116_have_no_gaze() {
    let Some((r, gaze, pose)) = eyenavgs("user104_berlin.csv", 0.8) else {
        return;
    };
    assert_eq!((gaze.samples, gaze.missing, pose.missing), (2635, 2635, 0));
    assert!(
        require_gaze(&r)
            .unwrap_err()
            .to_string()
            .contains("all 2635 samples are lost")
    );
    // 698 of its 12,800 rows have a zero GazePos, and none has a GazeQ.
    let Some((r, gaze, pose)) = eyenavgs("user116_playroom.csv", 2.7) else {
        return;
    };
    assert_eq!((gaze.samples, gaze.missing, pose.missing), (6400, 6400, 0));
    assert!(noted(&r, "12102 rows with a GazePos but no gaze direction"));
    assert!(noted(&r, "eyes 65.9 mm apart"));
    assert!(noted(&r, "no row has a gaze direction"));
    assert!(
        (pose.angle_step_deg - 0.1).abs() < 0.03,
        "{}",
        pose.angle_step_deg
    );
}

#[test]
fn user117_stalls() {
    let Some((_, _, pose)) = eyenavgs("user117_treehill.csv", 1.0) else {
        return;
    };
    assert!(
        (2880.0..2930.0).contains(&pose.longest_gap.as_ms()),
        "{}",
        pose.longest_gap
    );
    assert!(pose.gaps >= 1 && (pose.rate_hz - 71.43).abs() < 0.01);
}

#[test]
fn screen_centred() {
    // Missing where both eyes are; 165 more rows of the 1200 Hz file have one eye, one of the 120 Hz.
    for (name, rows, rate, missing) in [
        ("EyeLink_1000+_binocular_1000Hz.tsv", 20_916, 1000.0, 0),
        ("EyeLink_1000+_right_1000Hz.tsv", 21_599, 1000.0, 0),
        ("SMI_RED500_500Hz.tsv", 10_494, 500.0, 0),
        ("Tobii_Spectrum_1200Hz.tsv", 25_780, 1200.0, 5),
        ("Tobii_Spectrum_120Hz.tsv", 2_510, 120.0, 0),
    ] {
        let Some(r) = read(&format!("gaze/etdq_tsv/{name}"), &ReadOptions::default()) else {
            return;
        };
        assert!(r.pose.is_none());
        let about = info(&r).gaze.unwrap();
        assert_eq!((about.samples, about.missing), (rows, missing), "{name}");
        assert!(
            (about.rate_hz / rate - 1.0).abs() < 0.01,
            "{name}: {} Hz",
            about.rate_hz
        );
        // Targets lie at ±480 and ±270 px: ±11.5° and ±6.5°.
        let (left, right) = extent(&about, "azimuth_deg");
        assert!(
            (-20.0..-11.0).contains(&left) && (11.0..20.0).contains(&right),
            "{name}: {left} {right}"
        );
    }
}

#[test]
fn tum() {
    let Some(r) = read("head/tum/fr2_desk_groundtruth.txt", &ReadOptions::default()) else {
        return;
    };
    let about = info(&r).pose.unwrap();
    assert_eq!(
        (about.samples, about.duplicates, about.missing),
        (20_957, 1, 0)
    );
    assert!(
        (about.longest_gap.as_secs() - 12.0).abs() < 0.1,
        "{}",
        about.longest_gap
    );
    assert_eq!(r.span().unwrap().0, Nanos(1_311_868_163_869_700_000));
    // The camera is held a metre and a half above the floor and looks down at a desk.
    assert_eq!(extent(&about, "y_m"), (1.2211, 1.7918));
    assert!(extent(&about, "pitch_deg").1 < 0.0);
}

#[test]
fn our_own_format_holds_them_all() {
    for name in [
        "head/eyenavgs/user110_playroom.csv",
        "head/tum/fr2_desk_groundtruth.txt",
        "gaze/etdq_tsv/Tobii_Spectrum_1200Hz.tsv",
    ] {
        let Some(r) = read(name, &ReadOptions::default()) else {
            return;
        };
        let mut bytes = Vec::new();
        write(&r, &mut bytes).unwrap();
        let back = foveasim_traces::read(bytes.as_slice(), "f", &ReadOptions::default()).unwrap();
        assert_eq!((back.gaze, back.pose), (r.gaze, r.pose), "{name}");
    }
}

#[test]
fn what_is_no_recording_is_refused() {
    for (name, why) in [
        (
            "gaze/pupil_invisible/trampoline_01/blinks.csv",
            "not a recording in a known format",
        ),
        (
            "gaze/tobii_glasses3/eventdata.gz",
            "rows of neither gaze nor gyroscope",
        ),
        (
            "gaze/vive_pro_eye/TESTVA03_2D_Spread9.csv",
            "a header alone",
        ),
        (
            "head/eyenavgs/scene_setting.csv",
            "not a recording in a known format",
        ),
    ] {
        let Some(path) = find(name) else { return };
        let text = read_path(&path, &ReadOptions::default())
            .unwrap_err()
            .to_string();
        assert!(text.contains(why), "{name}: {text}");
    }
}

/// What SOURCES.md says of each file: rows, rows without any gaze, rate [Hz], and what its notes say.
#[test]
fn gaze_agrees_with_its_sources() {
    for (name, rows, missing, rate, note) in [
        ("aria/eyegaze.csv", 123, 0, 10.0, ""),
        ("aria/generalized_eye_gaze.csv", 123, 0, 10.0, ""),
        (
            "aria/vergence_generalized_gaze.csv",
            123,
            0,
            10.0,
            "mean of both",
        ),
        // 862 samples have a lost eye, 820 of them both.
        (
            "eyelink_asc/both_eyes.asc",
            70_328,
            820,
            500.0,
            "at least one in 862 rows",
        ),
        ("eyelink_asc/both_eyes.asc", 70_328, 820, 500.0, "4 blocks"),
        ("eyelink_asc/left_eye.asc", 70_291, 1_356, 500.0, "4 blocks"),
        ("format_samples/gazebase_example.csv", 10, 0, 1000.0, ""),
        ("format_samples/gazebase_vr_example.csv", 10, 0, 250.0, ""),
        ("format_samples/judo1000_example.csv", 10, 0, 1000.0, ""),
        (
            "format_samples/eyelink_binocular_example.asc",
            368,
            80,
            1000.0,
            "1 block",
        ),
        ("pico_neo3/boxing_VR.csv", 492, 6, 90.0, ""),
        // Values go on in its blinks, which are taken as lost.
        (
            "pupil_invisible/trampoline_01/gaze.csv",
            8_567,
            2_376,
            250.0,
            "2376 samples inside blinks",
        ),
        (
            "salient360/rawDataDyn1.csv",
            5_150,
            149,
            250.0,
            "at least one in 184 rows",
        ),
        (
            "salient360/rawDataDyn1.csv",
            5_150,
            149,
            250.0,
            "5150 rows in which binPor.y and Lval",
        ),
        (
            "salient360/rawDataStatic1.csv",
            1_412,
            0,
            120.0,
            "at least one in 6 rows",
        ),
        (
            "tobii_glasses3/gazedata.gz",
            6_547,
            412,
            100.0,
            "left eye lost in 587 rows, right eye in 1025",
        ),
        ("tobii_sdk/p1-1.txt", 651, 9, 300.0, ""),
        (
            "tobii_sdk/p1-2.txt",
            1_206,
            39,
            300.0,
            "left eye lost in 39 rows",
        ),
        (
            "tobii_sdk/p1-3.txt",
            1_207,
            446,
            300.0,
            "left eye lost in 447 rows",
        ),
        (
            "vive_pro_eye/TESTNA01_360VR_Fist3.csv",
            1_665,
            32,
            125.0,
            "",
        ),
        (
            "vive_pro_eye/TESTNA05_2D_Spread7.csv",
            1_354,
            150,
            125.0,
            "",
        ),
        (
            "vive_pro_eye/TESTNA10_360VR_Fist3.csv",
            1_664,
            619,
            125.0,
            "left eye lost in 624 rows",
        ),
    ] {
        let Some(r) = read(&format!("gaze/{name}"), &ReadOptions::default()) else {
            return;
        };
        let about = info(&r).gaze.unwrap();
        assert_eq!((about.samples, about.missing), (rows, missing), "{name}");
        assert!(
            (about.rate_hz / rate - 1.0).abs() < 0.01,
            "{name}: {} Hz",
            about.rate_hz
        );
        assert!(noted(&r, note), "{name}: {note}: {:?}", r.notes);
    }
}

#[test]
fn excerpts_of_eyelink_files() {
    for (name, rows, missing, rate, note) in [
        // Of most of its samples nothing is left: the rate is the one that the file states.
        (
            "eyelink_monocular_2khz_example.asc",
            16,
            0,
            2000.0,
            "37.2 x 37.8 px per degree",
        ),
        (
            "eyelink_monocular_no_dummy_example.asc",
            297,
            69,
            500.0,
            "is assumed",
        ),
    ] {
        let Some(r) = read(
            &format!("gaze/format_samples/{name}"),
            &ReadOptions::default(),
        ) else {
            return;
        };
        let about = info(&r).gaze.unwrap();
        assert_eq!((about.samples, about.missing), (rows, missing), "{name}");
        assert_eq!(about.rate_hz, rate, "{name}");
        assert!(noted(&r, note), "{name}: {:?}", r.notes);
    }
}

#[test]
fn head_agrees_with_its_sources() {
    for (name, rows, missing, rate) in [
        ("head/aria/closed_loop_trajectory.csv", 11_517, 0, 1000.0),
        ("gaze/pico_neo3/boxing_VR.csv", 492, 0, 90.0),
        (
            "gaze/pupil_invisible/trampoline_01/imu.csv",
            8_346,
            0,
            200.0,
        ),
        ("gaze/salient360/rawDataDyn1.csv", 5_150, 0, 250.0),
        ("gaze/salient360/rawDataStatic1.csv", 1_412, 0, 120.0),
        // 8,092 rows, 616 of which are the magnetometer's.
        ("gaze/tobii_glasses3/imudata.gz", 7_476, 0, 117.0),
        (
            "gaze/vive_pro_eye/TESTNA01_360VR_Fist3.csv",
            1_665,
            0,
            125.0,
        ),
        ("gaze/vive_pro_eye/TESTNA05_2D_Spread7.csv", 1_354, 0, 125.0),
        // Its helmet is zero throughout: it was not tracked.
        (
            "gaze/vive_pro_eye/TESTNA10_360VR_Fist3.csv",
            1_664,
            1_664,
            125.0,
        ),
    ] {
        let Some(r) = read(name, &ReadOptions::default()) else {
            return;
        };
        let about = info(&r).pose.unwrap();
        assert_eq!((about.samples, about.missing), (rows, missing), "{name}");
        assert!(
            (about.rate_hz / rate - 1.0).abs() < 0.02,
            "{name}: {} Hz",
            about.rate_hz
        );
    }
}

/// A head that looks about is upright on the whole, and so is one that wears glasses.
#[test]
fn frames_of_heads_are_upright() {
    for name in [
        "head/aria/closed_loop_trajectory.csv",
        "gaze/pico_neo3/boxing_VR.csv",
        "gaze/salient360/rawDataDyn1.csv",
        "gaze/salient360/rawDataStatic1.csv",
        "gaze/vive_pro_eye/TESTNA01_360VR_Fist3.csv",
        "gaze/vive_pro_eye/TESTNA05_2D_Spread7.csv",
    ] {
        let Some(r) = read(name, &ReadOptions::default()) else {
            return;
        };
        let poses: Vec<_> = r
            .pose
            .as_ref()
            .unwrap()
            .samples()
            .iter()
            .filter_map(|s| s.value)
            .collect();
        let up = poses
            .iter()
            .map(|p| p.direction(glam::DVec3::Y).y)
            .sum::<f64>()
            / poses.len() as f64;
        assert!(up > 0.85, "{name}: {up}");
    }
}

#[test]
fn labels_of_eyelink_and_pupil() {
    use foveasim_models::Eye;
    use foveasim_traces::{EventKind, read_labelled_path};
    let Some(path) = find("gaze/eyelink_asc/both_eyes.asc") else {
        return;
    };
    let (_, labels) = read_labelled_path(&path, &ReadOptions::default()).unwrap();
    let count = |kind, eye| {
        let of = |e: &&foveasim_traces::LabelledEvent| e.kind == kind && e.eye == Some(eye);
        labels.events.iter().filter(of).count()
    };
    // 529 EFIX, 521 ESACC, 20 EBLINK.
    assert_eq!(
        count(EventKind::Fixation, Eye::Left) + count(EventKind::Fixation, Eye::Right),
        529
    );
    assert_eq!(
        count(EventKind::Saccade, Eye::Left) + count(EventKind::Saccade, Eye::Right),
        521
    );
    assert_eq!(
        count(EventKind::Blink, Eye::Left) + count(EventKind::Blink, Eye::Right),
        20
    );
}
