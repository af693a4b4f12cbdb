//! The formats of makers and data sets: one small synthetic file each, with the quirks that real ones have.

use std::io::Write as _;

use foveasim_models::{Eye, Nanos};
use foveasim_traces::{
    EventKind, Labels, ReadOptions, ScreenSpec, TraceError, info, read, read_labelled,
};
use glam::DVec3;

use crate::{error, noted, parse};

pub(crate) const EYELINK: &str = "\
** CONVERTED FROM made-up.edf\n** VERSION: EYELINK II 1\n\n\
MSG\t90 DISPLAY_COORDS 0 0 999 499\nMSG\t95 !CAL \n>>>>>>> CALIBRATION (HV9,P-CR) FOR LEFT: <<<<<<<<<\n\
MSG\t95 !CAL eye check box: (L,R,T,B)\n\t  -76     7  -110    10\n     -0  117.22 -6.8171\n\
INPUT\t96\t127\nMSG\t99 GAZE_COORDS 0.00 0.00 1279.00 1023.00\n\
START\t100 \tLEFT\tRIGHT\tSAMPLES\tEVENTS\nPRESCALER\t1\nPUPIL\tAREA\n\
SAMPLES\tGAZE\tLEFT\tRIGHT\tRATE\t 500.00\tTRACKING\tCR\tFILTER\t2\nSFIX L   100\n\
100\t  639.5\t  511.5\t 1425.0\t  639.5\t  511.5\t 1387.0\t.....\n\
102\t  649.5\t  511.5\t 1425.0\t  649.5\t  511.5\t 1387.0\t.....\n\
MSG\t103 text with ümlauts\n\
EFIX L   100\t102\t4\t  739.5\t  511.5\t   1425\n\
104\t   .\t   .\t    0.0\t  639.5\t  411.5\t  401.0\t.C...\n\
106\t   .\t   .\t    0.0\t   .\t   .\t    0.0\t.C.C.\n\
EBLINK R 106\t106\t2\nESACC R  104\t108\t6\t  639.5\t  411.5\t  639.5\t  511.5\t   2.35\t    171\n\
END\t108 \tSAMPLES\tEVENTS\tRES\t  50.00\t  40.00\n\
START\t5000 \tLEFT\tRIGHT\tSAMPLES\tEVENTS\n\
SAMPLES\tGAZE\tLEFT\tRIGHT\tRATE\t 500.00\tTRACKING\tCR\tFILTER\t2\n\
5000\t  639.5\t  511.5\t 1425.0\t  639.5\t  511.5\t 1387.0\t.....\n\
END\t5002 \tSAMPLES\tEVENTS\tRES\t  60.00\t  48.00\n";

pub(crate) const TOBII_SDK: &str = "\
Time\tLGazePos2dx\tLGazePos2dy\tLPupilDm\tLValidity\tRGazePos2dx\tRGazePos2dy\tRPupilDm\tRValidity\tRelTimestamp\n\
2640808332\t0.5\t0.5\t3.6\t0\t0.5\t0.5\t3.1\t1\t0.0\n\
2640811685\t1.4\t0.5\t3.6\t0\t0.9\t0.9\t3.1\t3\t3.353\n\
2640815028\t-1.0\t-1.0\t-1.0\t4\t-1.0\t-1.0\t-1.0\t4\t6.696\n";

pub(crate) const VIVE: &str = "time(100ns);time_stamp(ms);eye_valid_L;eye_valid_R;\
gaze_direct_L.x;gaze_direct_L.y;gaze_direct_L.z;gaze_direct_R.x;gaze_direct_R.y;gaze_direct_R.z;\
helmet_pos_x;helmet_pos_y;helmet_pos_z;helmet_rot_x;helmet_rot_y;helmet_rot_z\r\n\
638342802882596202;-1511527596;31;31;0.6;0;0.8;0.6;0;0.8;1;2;3;0;90;0\r\n\
638342802882675967;-1511527587;25;31;0;0;0;0;0.6;0.8;1;2;3;30;0;0\r\n\
638342802882755770;-1511527587;24;8;0;0;0;0;0;0;0;0;0;0;0;0\r\n\r\n\r\n";

pub(crate) const PUPIL: &str = "section id,recording id,timestamp [ns],gaze x [px],gaze y [px],worn,\
fixation id,blink id,azimuth [deg],elevation [deg]\n\
s,r,1650316509598345895,284.4,772.2,1,,,-19.5,-15.25\ns,r,1650316509602370895,298,767,1,1,,-18,-15\n\
s,r,1650316509606363895,298,767,1,1,,-18,-15\ns,r,1650316509606471895,298,767,1,,7,-18,-15\n\
s,r,1650316509622641895,298,767,1,,7,-18,-15\ns,r,1650316509626641895,298,767,0,,,-18,-15\n";

pub(crate) const PUPIL_IMU: &str = "timestamp [ns],gyro x [deg/s],gyro y [deg/s],gyro z [deg/s],roll [deg],\
pitch [deg],yaw [deg],quaternion w,quaternion x,quaternion y,quaternion z\n\
1000000000,0,-90,0,7,89,,,,,\n1050000000,0,-90,0,7,89,,,,,\n1100000000,0,-90,0,7,89,,,,,\n";

pub(crate) const GLASSES3: &str = concat!(
    r#"{"type":"gaze","timestamp":0.006684,"data":{"gaze2d":[0.5,0.5],"eyeleft":{"gazedirection":[-0.6,0,0.8]},"eyeright":{"gazedirection":[-0.6,0,0.8]}}}"#,
    "\n",
    r#"{"type":"gaze","timestamp":0.016710,"data":{"eyeleft":{},"eyeright":{"gazedirection":[0,0.6,0.8],"pupildiameter":4.5}}}"#,
    "\n",
    r#"{"type":"gaze","timestamp":0.026704,"data":{}}"#,
    "\n",
    r#"{"type":"syncport","timestamp":0.03,"data":{"direction":"out","value":1}}"#,
    "\n",
    r#"{"type":"imu","timestamp":0.0,"data":{"accelerometer":[0,9.8,0],"gyroscope":[0,90,0]}}"#,
    "\n",
    r#"{"type":"imu","timestamp":0.01,"data":{"accelerometer":[0,9.8,0],"gyroscope":[0,90,0]}}"#,
    "\n",
    r#"{"type":"imu","timestamp":0.005,"data":{"magnetometer":[1,2,3]}}"#,
    "\n",
);

pub(crate) const PICO: &str = "User Name\tTimeline\tHead Position. x\tHead Position. y\tHead Position. z\t\
Head Rotation. x\tHead Rotation. y\tHead Rotation. z\tCombine Eye Gaze Vector. x\tCombine Eye Gaze Vector. y\t\
Combine Eye Gaze Vector. z\tFoveated Gaze Direction. x\tFoveated Gaze Direction. y\tFoveated Gaze Direction. z\n\
SE05\t0.01111111\t0\t1.6\t-0.4\t30\t0\t0\t0.6\t0\t0.8\t0.6\t0\t-0.8\n\
SE05\t0.02222222\t0\t1.6\t-0.4\t30\t0\t0\t0\t0\t0\t0\t0\t0\n";

pub(crate) const SALIENT_DYNAMIC: &str = "oculoTS,cam_pitch,cam_yaw,cam_roll,leftGazeDir.x,leftGazeDir.y,\
leftGazeDir.z,rightGazeDir.x,rightGazeDir.y,rightGazeDir.z,binPor.x,binPor.y,Lval,Rval\r\n\
657528133153,0,90,0,0.6,0,0.8,0.6,0,0.8,1310.969,666.5324True,True\r\n\
657532116039,0,90,0,0.6,0,0.8,0,0,1,1310.969,666.5324True,False\r\n\
657536178185,0,90,0,NaN,NaN,NaN,NaN,NaN,NaN,NaN,NaNFalse,False\r\n";

pub(crate) const SALIENT_STATIC: &str = "OcutimeStamp,cameraPosition.x,cameraPosition.y,cameraPosition.z,\
cameraRotation.x,cameraRotation.y,cameraRotation.z,cameraRotation.w,leftEyeDirection.x,leftEyeDirection.y,\
leftEyeDirection.z,rightEyeDirection.x,rightEyeDirection.y,rightEyeDirection.z,valL,valR\n\
19861628208,1,2,3,0,0,0,1,0.6,0,0.8,0.6,0,0.8,True,True\n19861636221,1,2,3,0,0,0,1,0.6,0,0.8,NaN,NaN,NaN,True,False\n";

pub(crate) const ARIA: &str = "tracking_timestamp_us,yaw_rads_cpf,pitch_rads_cpf,yaw_low_rads_cpf,depth_m,session_uid\n\
148502622,0.7853981633974483,0,0.8,,8d34\n148602622,0,0.1,0.7,,8d34\n";

pub(crate) const ARIA_TRAJECTORY: &str = "graph_uid,tracking_timestamp_us,utc_timestamp_ns,tx_world_device,\
ty_world_device,tz_world_device,qx_world_device,qy_world_device,qz_world_device,qw_world_device\n\
g,149202610,5,1,2,3,0,0,0,1\ng,149203459,5,1,2,3,0,0,0,1\n";

pub(crate) const EUROC: &str = "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], \
q_RS_y [], q_RS_z [], v_RS_R_x [m s^-1]\n\
1403636580838555648,4.688319,-1.786938,0.783338,0,1,0,0,-0.02\n1403636580843555328,4.7,-1.7,0.8,0,1,0,0,-0.02\n";

pub(crate) const GAZEBASE: &str =
    "n,x,lab,y,xT,yT\n0,-16.5,0,5.25,NaN,NaN\n1,NaN,0,NaN,2,3\n2,1,0,2,2,3\n";

pub(crate) const JUDO: &str = "trialId\tpointId\ttime\tx_left\ty_left\tx_right\ty_right\n\
1\t1\t8005274\t640\t512\t640\t512\n2\t1\t8005270\t1280\t512\t1280\t512\n2\t1\t8005271\t1280\t512\t1280\t512\n";

/// Every one of them, with the number of samples that a whole one has.
pub(crate) const ALL: [(&str, &str, usize); 14] = [
    ("eyelink", EYELINK, 5),
    ("tobii-sdk", TOBII_SDK, 3),
    ("vive-pro-eye", VIVE, 3),
    ("pupil-invisible", PUPIL, 6),
    ("pupil-invisible", PUPIL_IMU, 3),
    ("tobii-glasses3", GLASSES3, 3),
    ("pico-neo3", PICO, 2),
    ("salient360", SALIENT_DYNAMIC, 3),
    ("salient360", SALIENT_STATIC, 2),
    ("aria-gaze", ARIA, 2),
    ("aria-trajectory", ARIA_TRAJECTORY, 2),
    ("euroc", EUROC, 2),
    ("gazebase", GAZEBASE, 3),
    ("judo1000", JUDO, 2),
];

fn labelled(text: &str) -> (foveasim_models::Recording, Labels) {
    read_labelled(text.as_bytes(), "f", &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// Azimuths [deg] of gaze, NaN where lost.
fn azimuths(text: &str) -> Vec<f64> {
    let gaze = parse(text).unwrap().gaze.unwrap();
    let azimuth = |s: &foveasim_models::Sample<_>| {
        s.value
            .map_or(f64::NAN, |g: foveasim_models::GazeDirection| g.azimuth_deg)
    };
    gaze.samples().iter().map(azimuth).collect()
}

#[test]
fn each_is_found_by_content_and_read_whole() {
    for (format, text, samples) in ALL {
        let r = parse(text).unwrap_or_else(|e| panic!("{format}: {e}"));
        assert_eq!(r.format, format);
        let about = info(&r);
        let found = about.gaze.or(about.pose).unwrap().samples;
        assert_eq!(found, samples, "{format}");
        // A byte order mark and CRLF change nothing.
        let dos = format!(
            "\u{feff}{}",
            text.replace("\r\n", "\n").replace('\n', "\r\n")
        );
        let again = parse(&dos).unwrap_or_else(|e| panic!("{format}: {e}"));
        assert_eq!((again.gaze, again.pose), (r.gaze, r.pose), "{format}");
    }
}

#[test]
fn gzip_is_unpacked_and_a_cut_one_is_an_error() {
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(GLASSES3.as_bytes()).unwrap();
    let packed = packed.finish().unwrap();
    let r = read(packed.as_slice(), "f.gz", &ReadOptions::default()).unwrap();
    assert_eq!(r.gaze, parse(GLASSES3).unwrap().gaze);
    let cut = read(
        &packed[..packed.len() - 12],
        "f.gz",
        &ReadOptions::default(),
    );
    assert!(matches!(cut, Err(TraceError::Io { .. })), "{cut:?}");
}

#[test]
fn eyelink_blocks_losses_events_and_resolution() {
    let (r, labels) = labelled(EYELINK);
    let gaze = r.gaze.as_ref().unwrap().samples();
    assert_eq!(gaze[4].t, Nanos(5_000_000_000), "blocks follow one another");
    // 55 px per degree across is the mean of both blocks; the last pixel is 1279, so the centre 639.5.
    let degree = 55.0
        * (10.0_f64 / (55.0 * 180.0 / std::f64::consts::PI))
            .atan()
            .to_degrees();
    assert!((gaze[1].value.unwrap().azimuth_deg * 55.0 - degree).abs() < 1e-9);
    assert_eq!(gaze[0].value.unwrap().azimuth_deg, 0.0);
    assert!(
        gaze[2].value.unwrap().elevation_deg > 2.0,
        "y is down, and the right eye alone counts"
    );
    assert_eq!(gaze[3].value, None);
    assert!(noted(
        &r,
        "left eye lost in 2 rows, right eye in 1 row, at least one in 2 rows"
    ));
    assert!(noted(&r, "55.0 x 44.0 px per degree") && noted(&r, "2 blocks"));
    let kinds: Vec<_> = labels
        .events
        .iter()
        .map(|e| (e.kind, e.eye.unwrap()))
        .collect();
    assert_eq!(
        kinds,
        [
            (EventKind::Fixation, Eye::Left),
            (EventKind::Blink, Eye::Right),
            (EventKind::Saccade, Eye::Right)
        ]
    );
    assert_eq!(
        (labels.events[2].start, labels.events[2].end),
        (Nanos(104_000_000), Nanos(108_000_000))
    );
}

#[test]
fn eyelink_of_one_eye_at_2_khz_with_a_column_more() {
    let text = "** CONVERTED\nMSG\t1 GAZE_COORDS 0 0 1919 1079\nSTART\t2154556.0 \tLEFT\tSAMPLES\tEVENTS\n\
                SAMPLES\tGAZE\tLEFT\tRATE\t2000.00\tTRACKING\tCR\tFILTER\t2\tINPUT\n\
                2154556.5\t  959.5\t  539.5\t  778.0\t    0.0\t...\n2154557.0\t  .\t  .\t  0.0\t    0.0\t...\n";
    let r = parse(text).unwrap();
    let gaze = r.gaze.as_ref().unwrap().samples();
    assert_eq!(gaze[0].t, Nanos(2_154_556_500_000));
    assert_eq!(
        (gaze[0].value.unwrap().azimuth_deg, gaze[1].value),
        (0.0, None)
    );
    assert!(noted(&r, "is assumed") && noted(&r, "left eye alone"));
    let options = ReadOptions {
        screen: ScreenSpec {
            size_mm: Some([1920.0, 1080.0]),
            distance_mm: Some(100.0),
            ..ScreenSpec::default()
        },
        ..ReadOptions::default()
    };
    let text = text.replace("  959.5", " 1059.5");
    let r = read(text.as_bytes(), "f", &options).unwrap();
    assert!((r.gaze.unwrap().samples()[0].value.unwrap().azimuth_deg - 45.0).abs() < 1e-12);
}

#[test]
fn eyelink_errors_name_line_and_value() {
    let with = |from: &str, to: &str| error(&EYELINK.replacen(from, to, 1));
    assert!(with("  649.5\t", "  64x.5\t").contains("x = `64x.5`"));
    assert!(with("GAZE\tLEFT", "HREF\tLEFT").contains("samples of GAZE of LEFT, RIGHT or both"));
    assert!(with("\n102\t", "\n98\t").contains("time goes back"));
    assert!(with("EFIX L   100\t102", "EFIX L   100").contains("time goes back"));
    assert!(with("EBLINK R", "EBLINK X").contains("eye = `X`: must be L or R"));
    assert!(with("\nSAMPLES\tGAZE", "\nSAMPLED\tGAZE").contains("before any line SAMPLES"));
    assert!(with("0.00 0.00 1279.00", "0.00 0.00 -5").contains("GAZE_COORDS"));
    assert!(with("\t  649.5\t  511.5\t 1387.0\t.....", "").contains("4 fields; want 7"));
}

#[test]
fn tobii_sdk_validity_and_places_beyond_the_screen() {
    let r = parse(TOBII_SDK).unwrap();
    let gaze = r.gaze.as_ref().unwrap().samples();
    assert_eq!(gaze[0].t, Nanos(2_640_808_332_000));
    assert_eq!(gaze[0].value.unwrap().azimuth_deg, 0.0);
    let mm = gaze[1].value.unwrap().azimuth_deg.to_radians().tan() * 650.0;
    assert!(
        (mm - 0.9 * 509.2).abs() < 1e-9,
        "code 3 is another eye: the left counts alone: {mm}"
    );
    assert_eq!(gaze[2].value, None);
    assert!(error(&TOBII_SDK.replace("\t3.6\t0\t", "\t3.6\t7\t")).contains("LValidity = `7`"));
}

#[test]
fn vive_ticks_bit_masks_and_frames() {
    let r = parse(VIVE).unwrap();
    let gaze = r.gaze.as_ref().unwrap().samples();
    // 638342802882596202 ticks are 2023-10-30 16:31:28.2596202 UTC.
    assert_eq!(gaze[0].t, Nanos(1_698_683_488_259_620_200));
    assert_eq!(gaze[1].t - gaze[0].t, Nanos(7_976_500));
    let first = gaze[0].value.unwrap();
    assert!(
        (first.azimuth_deg + 36.869_897_645_844_02).abs() < 1e-9,
        "+x is to the left: {first:?}"
    );
    assert!((gaze[1].value.unwrap().elevation_deg - 36.869_897_645_844_02).abs() < 1e-9);
    assert_eq!(gaze[2].value, None);
    assert!(noted(&r, "left eye lost in 2 rows, right eye in 1 row"));
    let poses = r.pose.as_ref().unwrap().samples();
    let pose = poses[0].value.unwrap();
    assert_eq!(pose.position, DVec3::new(1.0, 2.0, -3.0));
    assert!((pose.direction(DVec3::NEG_Z) - DVec3::X).length() < 1e-15);
    assert!(
        poses[1].value.unwrap().direction(DVec3::NEG_Z).y < -0.49,
        "+30 degrees look down"
    );
    assert_eq!(poses[2].value, None, "a helmet that was not tracked");
    assert!(error(&VIVE.replace(";25;31;", ";x;31;")).contains("eye_valid_L = `x`"));
    assert!(
        error(&VIVE.replace("638342802882596202", "6.4e17")).contains("time(100ns) = `6.4e17`")
    );
}

#[test]
fn pupil_invisible_blinks_and_an_imu_without_quaternion() {
    let (r, labels) = labelled(PUPIL);
    let gaze = r.gaze.as_ref().unwrap().samples();
    assert_eq!(
        gaze[0].t,
        Nanos(1_650_316_509_598_345_895),
        "to the nanosecond"
    );
    assert_eq!(gaze[0].value.unwrap().elevation_deg, -15.25);
    let lost: Vec<_> = gaze.iter().map(|s| s.value.is_none()).collect();
    assert_eq!(lost, [false, false, false, true, true, true]);
    assert!(noted(&r, "2 samples inside blinks"));
    let kinds: Vec<_> = labels
        .events
        .iter()
        .map(|e| (e.kind, e.start, e.end))
        .collect();
    assert_eq!(
        kinds,
        [
            (EventKind::Fixation, gaze[1].t, gaze[2].t),
            (EventKind::Blink, gaze[3].t, gaze[4].t)
        ]
    );
    let imu = parse(PUPIL_IMU).unwrap();
    let poses = imu.pose.as_ref().unwrap().samples();
    // Y is down: −90°/s about it turns to the left, 9° in 0.1 s.
    let forward = poses[2].value.unwrap().direction(DVec3::NEG_Z);
    assert!(
        (forward.x + 9.0_f64.to_radians().sin()).abs() < 1e-12,
        "{forward}"
    );
    assert!(noted(&imu, "integrated from the gyroscope"));
    let turned = PUPIL_IMU.replace(",,,,,\n", ",0,1,0,0,0\n");
    let imu = parse(&turned).unwrap();
    assert!(
        !noted(&imu, "integrated"),
        "a quaternion is used where there is one"
    );
}

#[test]
fn glasses3_lost_eyes_and_a_clock_of_the_magnetometer() {
    let r = parse(GLASSES3).unwrap();
    let gaze = r.gaze.as_ref().unwrap().samples();
    assert_eq!(gaze[0].t, Nanos(6_684_000));
    assert!((gaze[0].value.unwrap().azimuth_deg - 36.869_897_645_844_02).abs() < 1e-9);
    assert!((gaze[1].value.unwrap().elevation_deg - 36.869_897_645_844_02).abs() < 1e-9);
    assert_eq!(gaze[2].value, None);
    assert!(noted(
        &r,
        "left eye lost in 2 rows, right eye in 1 row, at least one in 2 rows"
    ));
    assert!(noted(&r, "1 row of the IMU without gyroscope") && noted(&r, "1 row of neither"));
    let turned = r.pose.unwrap().samples()[1].value.unwrap();
    assert!(
        turned.direction(DVec3::NEG_Z).x < 0.0,
        "about +y turns to the left"
    );
    assert!(error(&GLASSES3.replace("[0,90,0]", "[0,90]")).contains("line 5: row ="));
    assert!(error(&GLASSES3.replace("0.016710", "1e99")).contains("timestamp = "));
    assert!(error("{\"type\":\"event\",\"timestamp\":1}\n").contains("neither gaze nor gyroscope"));
}

#[test]
fn pico_names_with_spaces_and_a_zero_vector() {
    let azimuth = azimuths(PICO);
    assert!(
        (azimuth[0] - 36.869_897_645_844_02).abs() < 1e-9 && azimuth[1].is_nan(),
        "{azimuth:?}"
    );
    let r = parse(PICO).unwrap();
    let pose = r.pose.unwrap().samples()[0].value.unwrap();
    assert!(
        (pose.direction(DVec3::NEG_Z).y + 0.5).abs() < 1e-12,
        "+30 degrees look down"
    );
    assert_eq!(r.gaze.unwrap().samples()[0].t, Nanos(11_111_110));
}

#[test]
fn salient360_units_and_glued_fields() {
    let r = parse(SALIENT_DYNAMIC).unwrap();
    let gaze = r.gaze.as_ref().unwrap().samples();
    assert_eq!(gaze[0].t, Nanos(657_528_133_153), "nanoseconds");
    assert!(
        (gaze[1].value.unwrap().azimuth_deg - 36.869_897_645_844_02).abs() < 1e-9,
        "left alone"
    );
    assert_eq!(gaze[2].value, None);
    assert!(noted(&r, "3 rows in which binPor.y and Lval are one field"));
    let whole = parse(
        &SALIENT_DYNAMIC
            .replace("24True", "24,True")
            .replace("NaNFalse", "NaN,False"),
    );
    assert_eq!(whole.unwrap().gaze, r.gaze, "and files that are whole");
    assert!(
        error(&SALIENT_DYNAMIC.replace("666.5324True,True\r\n65753", "666.5324,True\r\n65753"))
            .contains("line 2: 13 fields; want 14")
    );
    let r = parse(SALIENT_STATIC).unwrap();
    assert_eq!(
        r.gaze.as_ref().unwrap().samples()[0].t,
        Nanos(19_861_628_208_000),
        "microseconds"
    );
    assert_eq!(
        r.pose.unwrap().samples()[0].value.unwrap().position,
        DVec3::new(1.0, 2.0, -3.0)
    );
}

#[test]
fn aria_in_any_order_of_columns() {
    let azimuth = azimuths(ARIA);
    assert!(
        (azimuth[0] + 45.0).abs() < 1e-9,
        "+x is to the left: {azimuth:?}"
    );
    let older = "tracking_timestamp_us,pitch_rads_cpf,depth_m,yaw_rads_cpf\n148502622,0,,0.7853981633974483\n";
    assert_eq!(azimuths(older)[0], azimuth[0]);
    let both = "tracking_timestamp_us,left_yaw_rads_cpf,right_yaw_rads_cpf,pitch_rads_cpf,depth_m\n\
                148502622,0.7,0.8707963267948966,0,1.5\n";
    assert!((azimuths(both)[0] + 45.0).abs() < 1e-9);
    let r = parse(ARIA_TRAJECTORY).unwrap();
    let pose = r.pose.as_ref().unwrap().samples()[0];
    assert_eq!(
        (pose.t, pose.value.unwrap().position),
        (Nanos(149_202_610_000), DVec3::new(1.0, 3.0, -2.0))
    );
}

#[test]
fn euroc_names_its_columns_in_a_comment() {
    let r = parse(EUROC).unwrap();
    let pose = r.pose.as_ref().unwrap().samples()[0];
    assert_eq!(pose.t, Nanos(1_403_636_580_838_555_648));
    let at = DVec3::new(4.688_319, 0.783_338, 1.786_938);
    assert_eq!(pose.value.unwrap().position, at);
    // w stands first: 0,1,0,0 is half a turn about x, which leaves up what the body's x is in the world.
    let up = pose.value.unwrap().direction(DVec3::Y);
    assert!((up - DVec3::X).length() < 1e-12, "{up}");
}

#[test]
fn gazebase_nan_and_targets() {
    let (r, labels) = labelled(GAZEBASE);
    let gaze = r.gaze.unwrap();
    let first = gaze.samples()[0].value.unwrap();
    assert_eq!(
        (first.azimuth_deg, first.elevation_deg),
        (-16.5, 5.25),
        "columns in any order"
    );
    assert_eq!(gaze.samples()[1].value, None);
    assert_eq!(labels.targets.len(), 2);
    assert_eq!(labels.targets[1].target.unwrap().elevation_deg, 3.0);
    let semicolons = GAZEBASE
        .replace(',', ";")
        .replace("-16.5", "-16,5")
        .replace("5.25", "5,25");
    assert_eq!(
        parse(&semicolons).unwrap().gaze.unwrap(),
        gaze,
        "decimal commas"
    );
}

#[test]
fn judo_clock_starts_again_at_a_trial() {
    let r = parse(JUDO).unwrap();
    assert!(noted(
        &r,
        "2 sessions joined in one file (1 and 2 rows); segment 2 is read, the longest"
    ));
    let options = ReadOptions {
        segment: Some(1),
        ..ReadOptions::default()
    };
    let first = read(JUDO.as_bytes(), "f", &options).unwrap();
    let gaze = first.gaze.unwrap();
    assert_eq!(
        (
            gaze.samples().len(),
            gaze.samples()[0].value.unwrap().azimuth_deg
        ),
        (1, 0.0)
    );
    assert!(error(&JUDO.replace("\n2\t1\t8005270", "\n1\t1\t8005270")).contains("time goes back"));
}

#[test]
fn targets_of_a_screen_are_directions() {
    let text = "timestamp\tleft_x\tleft_y\ttarget_id\ttar_x\ttar_y\n1\t0\t0\t-1\t-1\t-1\n2\t0\t0\t3\t480\t0\n\
                3\t0\t0\t3\t480\t0\n4\t0\t0\t-1\t-1\t-1\n";
    let (_, labels) = labelled(text);
    let steps: Vec<_> = labels
        .targets
        .iter()
        .map(|s| (s.t.0 / 1_000_000, s.target.is_some()))
        .collect();
    assert_eq!(steps, [(1, false), (2, true), (4, false)]);
    let target = labels.targets[1].target.unwrap();
    assert!((target.azimuth_deg - (132.0_f64 / 650.0).atan().to_degrees()).abs() < 1e-12);
}

/// A small generator, so that damage is the same in every run.
struct Lcg(u64);

impl Lcg {
    fn next(&mut self, below: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % below
    }
}

#[test]
fn cut_anywhere_they_are_shorter_or_an_error() {
    for (format, text, samples) in ALL {
        for end in 0..text.len() {
            if let Ok(r) = read(&text.as_bytes()[..end], "f", &ReadOptions::default()) {
                let about = info(&r);
                let found = about.gaze.or(about.pose).map_or(0, |s| s.samples);
                assert!(found <= samples.max(3), "{format} cut at {end}: {found}");
            }
        }
    }
}

#[test]
fn flipped_bits_never_panic() {
    let mut lcg = Lcg(1);
    for (_, text, _) in ALL {
        for _ in 0..400 {
            let mut bytes = text.as_bytes().to_vec();
            for _ in 0..=lcg.next(3) {
                let at = lcg.next(bytes.len());
                bytes[at] ^= 1 << lcg.next(8);
            }
            if let Ok((r, _)) = read_labelled(bytes.as_slice(), "f", &ReadOptions::default()) {
                info(&r);
            }
        }
    }
}
