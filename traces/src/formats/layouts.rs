use super::Format;
use super::axes::{Axes, PoseFrame};
use super::layout::{Coding, EyeColumns, Layout, PoseColumns, Rotation, Target, Time, Valid};
use crate::EventKind::{Blink, Fixation};
use crate::Screen;

/// 0001-01-01, from which .NET counts, to 1970-01-01 \[100 ns\].
const DOTNET_EPOCH: i64 = 621_355_968_000_000_000;

/// The set-up of the published recordings of ETDQualitizer (Niehorster 2024).
const ETDQ_SCREEN: Screen = Screen {
    size_px: [1920.0, 1080.0],
    size_mm: [528.0, 297.0],
    distance_mm: 650.0,
};

/// The Tobii TX300 of I2MC's published recordings (Hessels et al. 2017).
const TX300_SCREEN: Screen = Screen {
    size_px: [1920.0, 1080.0],
    size_mm: [509.2, 286.4],
    distance_mm: 650.0,
};

/// The set-up of JuDo1000 (Makowski et al. 2020).
const JUDO_SCREEN: Screen = Screen {
    size_px: [1280.0, 1024.0],
    size_mm: [380.0, 302.0],
    distance_mm: 680.0,
};

const fn time(column: &'static str, exponent: i32) -> Time {
    Time {
        column,
        exponent,
        epoch: None,
    }
}

const fn eye(columns: &'static [&'static str]) -> EyeColumns {
    EyeColumns {
        columns,
        valid: None,
    }
}

/// What most formats do not have.
const PLAIN: Layout = Layout {
    format: Format::ScreenCentred,
    marks: &[],
    time: time("timestamp", -3),
    eyes: &[],
    coding: Coding::None,
    pose: None,
    events: &[],
    target: None,
    session: None,
    glued: None,
    notes: &[],
};

/// Every delimited layout, more particular ones first.
pub(super) static LAYOUTS: [Layout; 13] = [
    VIVE_PRO_EYE,
    PICO_NEO3,
    PUPIL_GAZE,
    PUPIL_IMU,
    SALIENT360_DYNAMIC,
    SALIENT360_STATIC,
    TOBII_SDK,
    ARIA_VERGENCE,
    ARIA_GAZE,
    ARIA_TRAJECTORY,
    EUROC,
    GAZEBASE,
    JUDO1000,
];

/// Screen-centred gaze in pixels, as in ETDQualitizer's example recordings; one eye may be absent.
pub(super) static SCREEN_CENTRED: Layout = Layout {
    eyes: &[eye(&["left_x", "left_y"]), eye(&["right_x", "right_y"])],
    coding: Coding::CentredPixels(ETDQ_SCREEN),
    target: Some(Target {
        columns: ["tar_x", "tar_y"],
        none: Some(("target_id", "-1")),
    }),
    ..PLAIN
};

/// HTC Vive Pro Eye through SRanipal. Bit 1 of `eye_valid` says that the gaze direction is valid.
const VIVE_PRO_EYE: Layout = Layout {
    format: Format::ViveProEye,
    marks: &["time(100ns)", "eye_valid_L", "gaze_direct_L.x"],
    time: Time {
        column: "time(100ns)",
        exponent: -7,
        epoch: Some(DOTNET_EPOCH),
    },
    eyes: &[
        EyeColumns {
            columns: &["gaze_direct_L.x", "gaze_direct_L.y", "gaze_direct_L.z"],
            valid: Some(Valid {
                column: "eye_valid_L",
                rule: direction_bit,
                expected: "a bit mask from 0 to 255",
            }),
        },
        EyeColumns {
            columns: &["gaze_direct_R.x", "gaze_direct_R.y", "gaze_direct_R.z"],
            valid: Some(Valid {
                column: "eye_valid_R",
                rule: direction_bit,
                expected: "a bit mask from 0 to 255",
            }),
        },
    ],
    coding: Coding::Vector(Axes::LeftUpForward),
    pose: Some(PoseColumns {
        position: Some(["helmet_pos_x", "helmet_pos_y", "helmet_pos_z"]),
        rotation: Rotation::UnityEuler(["helmet_rot_x", "helmet_rot_y", "helmet_rot_z"]),
        frame: PoseFrame::Unity,
    }),
    notes: &[
        "times are of the computer's clock (time(100ns)), which does not repeat as time_stamp(ms) does",
    ],
    ..PLAIN
};

/// Pico Neo 3 Pro Eye, logged by Unity. Its `Foveated Gaze Direction` has +Z backwards and is not read.
const PICO_NEO3: Layout = Layout {
    format: Format::PicoNeo3,
    marks: &["Timeline", "Combine Eye Gaze Vector. x", "Head Rotation. x"],
    time: time("Timeline", 0),
    eyes: &[eye(&[
        "Combine Eye Gaze Vector. x",
        "Combine Eye Gaze Vector. y",
        "Combine Eye Gaze Vector. z",
    ])],
    coding: Coding::Vector(Axes::Unity),
    pose: Some(PoseColumns {
        position: Some(["Head Position. x", "Head Position. y", "Head Position. z"]),
        rotation: Rotation::UnityEuler([
            "Head Rotation. x",
            "Head Rotation. y",
            "Head Rotation. z",
        ]),
        frame: PoseFrame::Unity,
    }),
    ..PLAIN
};

/// Pupil Invisible, gaze.csv of Pupil Cloud. Values go on through blinks, which are labelled.
const PUPIL_GAZE: Layout = Layout {
    format: Format::PupilInvisible,
    marks: &["timestamp [ns]", "azimuth [deg]", "elevation [deg]"],
    time: time("timestamp [ns]", -9),
    eyes: &[EyeColumns {
        columns: &["azimuth [deg]", "elevation [deg]"],
        valid: Some(Valid {
            column: "worn",
            rule: one,
            expected: "1 (worn), 0 or empty",
        }),
    }],
    coding: Coding::Degrees,
    events: &[(Blink, "blink id"), (Fixation, "fixation id")],
    ..PLAIN
};

/// Pupil Invisible, imu.csv of Pupil Cloud.
const PUPIL_IMU: Layout = Layout {
    format: Format::PupilInvisible,
    marks: &["timestamp [ns]", "gyro x [deg/s]", "gyro z [deg/s]"],
    time: time("timestamp [ns]", -9),
    pose: Some(PoseColumns {
        position: None,
        rotation: Rotation::Gyroscope {
            quaternion: [
                "quaternion x",
                "quaternion y",
                "quaternion z",
                "quaternion w",
            ],
            rate: ["gyro x [deg/s]", "gyro y [deg/s]", "gyro z [deg/s]"],
            axes: Axes::RightDownForward,
        },
        frame: PoseFrame::CAMERA,
    }),
    ..PLAIN
};

const SALIENT360_NOTE: &str = "gaze is relative to the head, from the directions of the eyes; places on the screen are not used";

/// Salient360, recorded while a film was seen.
const SALIENT360_DYNAMIC: Layout = Layout {
    format: Format::Salient360,
    marks: &["oculoTS", "leftGazeDir.x", "cam_pitch"],
    time: time("oculoTS", -9),
    eyes: &[
        EyeColumns {
            columns: &["leftGazeDir.x", "leftGazeDir.y", "leftGazeDir.z"],
            valid: Some(truth("Lval")),
        },
        EyeColumns {
            columns: &["rightGazeDir.x", "rightGazeDir.y", "rightGazeDir.z"],
            valid: Some(truth("Rval")),
        },
    ],
    coding: Coding::Vector(Axes::Unity),
    pose: Some(PoseColumns {
        position: None,
        rotation: Rotation::UnityEuler(["cam_pitch", "cam_yaw", "cam_roll"]),
        frame: PoseFrame::Unity,
    }),
    glued: Some(["binPor.y", "Lval"]),
    notes: &[SALIENT360_NOTE],
    ..PLAIN
};

/// Salient360, recorded while a still image was seen.
const SALIENT360_STATIC: Layout = Layout {
    format: Format::Salient360,
    marks: &["OcutimeStamp", "leftEyeDirection.x", "cameraRotation.w"],
    time: time("OcutimeStamp", -6),
    eyes: &[
        EyeColumns {
            columns: &[
                "leftEyeDirection.x",
                "leftEyeDirection.y",
                "leftEyeDirection.z",
            ],
            valid: Some(truth("valL")),
        },
        EyeColumns {
            columns: &[
                "rightEyeDirection.x",
                "rightEyeDirection.y",
                "rightEyeDirection.z",
            ],
            valid: Some(truth("valR")),
        },
    ],
    coding: Coding::Vector(Axes::Unity),
    pose: Some(PoseColumns {
        position: Some(["cameraPosition.x", "cameraPosition.y", "cameraPosition.z"]),
        rotation: Rotation::Quaternion([
            "cameraRotation.x",
            "cameraRotation.y",
            "cameraRotation.z",
            "cameraRotation.w",
        ]),
        frame: PoseFrame::Unity,
    }),
    notes: &[SALIENT360_NOTE],
    ..PLAIN
};

/// What a Tobii screen-based tracker's SDK gives, as I2MC's example recordings keep it.
const TOBII_SDK: Layout = Layout {
    format: Format::TobiiSdk,
    marks: &["Time", "LGazePos2dx", "RGazePos2dx"],
    time: time("Time", -6),
    eyes: &[
        EyeColumns {
            columns: &["LGazePos2dx", "LGazePos2dy"],
            valid: Some(Valid {
                column: "LValidity",
                rule: tobii,
                expected: "0, 1, 2, 3 or 4",
            }),
        },
        EyeColumns {
            columns: &["RGazePos2dx", "RGazePos2dy"],
            valid: Some(Valid {
                column: "RValidity",
                rule: tobii,
                expected: "0, 1, 2, 3 or 4",
            }),
        },
    ],
    coding: Coding::Shares(TX300_SCREEN),
    ..PLAIN
};

const ARIA_NOTE: &str =
    "angles taken as tangents of x (left) and y (up) in the central pupil frame";

/// Project Aria, eye gaze of both eyes.
const ARIA_VERGENCE: Layout = Layout {
    format: Format::AriaGaze,
    marks: &[
        "tracking_timestamp_us",
        "left_yaw_rads_cpf",
        "right_yaw_rads_cpf",
        "pitch_rads_cpf",
    ],
    time: time("tracking_timestamp_us", -6),
    eyes: &[
        eye(&["left_yaw_rads_cpf", "pitch_rads_cpf"]),
        eye(&["right_yaw_rads_cpf", "pitch_rads_cpf"]),
    ],
    coding: Coding::Tangents(Axes::LeftUpForward),
    notes: &[ARIA_NOTE],
    ..PLAIN
};

/// Project Aria, one direction of gaze.
const ARIA_GAZE: Layout = Layout {
    format: Format::AriaGaze,
    marks: &["tracking_timestamp_us", "yaw_rads_cpf", "pitch_rads_cpf"],
    time: time("tracking_timestamp_us", -6),
    eyes: &[eye(&["yaw_rads_cpf", "pitch_rads_cpf"])],
    coding: Coding::Tangents(Axes::LeftUpForward),
    notes: &[ARIA_NOTE],
    ..PLAIN
};

/// Project Aria, closed-loop or open-loop trajectory.
const ARIA_TRAJECTORY: Layout = Layout {
    format: Format::AriaTrajectory,
    marks: &[
        "tracking_timestamp_us",
        "tx_world_device",
        "qw_world_device",
    ],
    time: time("tracking_timestamp_us", -6),
    pose: Some(PoseColumns {
        position: Some(["tx_world_device", "ty_world_device", "tz_world_device"]),
        rotation: Rotation::Quaternion([
            "qx_world_device",
            "qy_world_device",
            "qz_world_device",
            "qw_world_device",
        ]),
        frame: PoseFrame::ARIA,
    }),
    notes: &[
        "the head looks along the device's +Z (its left camera's axis) with -X up: the calibration that would say exactly is not in the file",
    ],
    ..PLAIN
};

/// EuRoC's ground truth: a drone, not a head.
const EUROC: Layout = Layout {
    format: Format::Euroc,
    marks: &[
        "timestamp|timestamp [ns]",
        "p_RS_R_x [m]|p_RS_R_x",
        "q_RS_w []|q_RS_w",
    ],
    time: time("timestamp|timestamp [ns]", -9),
    pose: Some(PoseColumns {
        position: Some([
            "p_RS_R_x [m]|p_RS_R_x",
            "p_RS_R_y [m]|p_RS_R_y",
            "p_RS_R_z [m]|p_RS_R_z",
        ]),
        rotation: Rotation::Quaternion([
            "q_RS_x []|q_RS_x",
            "q_RS_y []|q_RS_y",
            "q_RS_z []|q_RS_z",
            "q_RS_w []|q_RS_w",
        ]),
        frame: PoseFrame::EUROC,
    }),
    notes: &[
        "body frame (+Z forward, +X up) and world (+Z up) turned into head frame (-Z forward, +Y up) and world (+Y up)",
    ],
    ..PLAIN
};

/// GazeBase and GazeBaseVR: milliseconds in `n`, degrees.
const GAZEBASE: Layout = Layout {
    format: Format::GazeBase,
    marks: &["n", "x", "y", "xT", "yT"],
    time: time("n", -3),
    eyes: &[eye(&["x", "y"])],
    coding: Coding::Degrees,
    target: Some(Target {
        columns: ["xT", "yT"],
        none: None,
    }),
    ..PLAIN
};

/// JuDo1000: pixels from the top-left corner; the clock may start again at each trial.
const JUDO1000: Layout = Layout {
    format: Format::JuDo1000,
    marks: &["trialId", "time", "x_left", "y_left"],
    time: time("time", -3),
    eyes: &[eye(&["x_left", "y_left"]), eye(&["x_right", "y_right"])],
    coding: Coding::CornerPixels(JUDO_SCREEN),
    session: Some("trialId"),
    ..PLAIN
};

const fn truth(column: &'static str) -> Valid {
    Valid {
        column,
        rule: boolean,
        expected: "True or False",
    }
}

fn boolean(text: &str) -> Option<bool> {
    let is = |word| text.eq_ignore_ascii_case(word);
    (is("true") || is("false")).then(|| is("true"))
}

fn one(text: &str) -> Option<bool> {
    match text {
        "1" | "1.0" | "255" | "True" | "true" => Some(true),
        "0" | "0.0" | "" | "False" | "false" => Some(false),
        _ => None,
    }
}

/// 0 certain, 1 probable, 2 uncertain which eye, 3 probably the other eye, 4 not found.
fn tobii(text: &str) -> Option<bool> {
    let code = text.parse::<u8>().ok().filter(|code| *code <= 4)?;
    Some(code <= 1)
}

/// SRanipal's `eye_valid`: bit 0 the origin, 1 the direction, 2 the pupil's size, 3 the opening, 4 its
/// place in the sensor.
fn direction_bit(text: &str) -> Option<bool> {
    Some(text.parse::<u8>().ok()? & 2 != 0)
}
