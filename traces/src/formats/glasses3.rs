use std::io::BufRead;

use foveasim_models::math::to_rad;
use foveasim_models::{GazeDirection, Nanos, Pose, Provenance, Recording, Sample};
use glam::DVec3;
use serde::Deserialize;

use super::axes::Axes;
use super::eyes::EyePair;
use super::gyroscope::Gyroscope;
use super::number::Row;
use super::{GAZE_ASSUMED, POSE_ASSUMED, Parsed, count, in_order, series};
use crate::lines::Lines;
use crate::{Labels, TraceError};

/// Latest time that is read \[s\]: a century.
const MAX_SECS: f64 = 4e9;

/// Whether a line can be the first of a file of this format.
pub(super) fn begins(line: &str) -> bool {
    line.starts_with('{') && line.contains("\"type\"") && line.contains("\"timestamp\"")
}

#[derive(Deserialize)]
struct Entry {
    #[serde(rename = "type")]
    kind: String,
    timestamp: f64,
    #[serde(default)]
    data: Data,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Data {
    eyeleft: EyeData,
    eyeright: EyeData,
    gyroscope: Option<[f64; 3]>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct EyeData {
    gazedirection: Option<[f64; 3]>,
}

impl EyeData {
    fn direction(&self) -> Option<DVec3> {
        let d = DVec3::from_array(self.gazedirection?);
        let length = d.length();
        (length > 1e-3).then(|| d / length)
    }
}

/// Tobii Pro Glasses 3: JSON lines (gazedata.gz, imudata.gz), +X left, +Y up, +Z forward.
///
/// A row of gaze without data, or an eye without, is lost. Rows of the IMU without a gyroscope (the
/// magnetometer has its own, with times of its own) are passed over.
pub(super) fn parse<R: BufRead>(lines: &mut Lines<'_, R>) -> Result<Parsed, TraceError> {
    let file = lines.file();
    let axes = Axes::LeftUpForward;
    let mut pair = EyePair::new([true, true], "");
    let mut gyroscope = Gyroscope::default();
    let (mut gaze, mut poses): (Vec<Sample<GazeDirection>>, Vec<Sample<Pose>>) = Default::default();
    let (mut without, mut others) = (0, 0);
    while let Some(line) = lines.next()? {
        let row = Row::new(file, &line, false);
        let entry: Entry = match serde_json::from_str(line.text) {
            Ok(entry) => entry,
            Err(_) if !line.complete => {
                let line = line.number;
                let file = file.to_owned();
                return Err(TraceError::Truncated { file, line });
            }
            Err(error) => {
                let valid = format!("a JSON object with type, timestamp and data ({error})");
                return Err(row.bad("row", line.text, valid));
            }
        };
        let t = time(&row, entry.timestamp)?;
        match entry.kind.as_str() {
            "gaze" => {
                in_order(&row, gaze.last().map(|s| s.t), t)?;
                let eyes = [entry.data.eyeleft, entry.data.eyeright].map(|e| e.direction());
                let value = pair.combine(eyes).filter(|d| d.length() > 1e-3);
                let value = value.map(|d| GazeDirection::from_vector(axes.vector(d)));
                gaze.push(Sample { t, value });
            }
            "imu" => {
                let Some(rate) = entry.data.gyroscope else {
                    without += 1;
                    continue;
                };
                in_order(&row, poses.last().map(|s| s.t), t)?;
                let rate = axes.axial(DVec3::from_array(rate) * to_rad(1.0));
                let value = Some(Pose::new(DVec3::ZERO, gyroscope.turn(t, rate)));
                poses.push(Sample { t, value });
            }
            _ => others += 1,
        }
    }
    let mut notes = Vec::new();
    if !gaze.is_empty() {
        notes.push(GAZE_ASSUMED.to_owned());
        notes.extend(pair.notes());
    }
    if !poses.is_empty() {
        notes.push(POSE_ASSUMED.to_owned());
        notes.push(
            "head orientation integrated from the gyroscope from an arbitrary start: it drifts, and the head's \
             place is not known"
                .into(),
        );
    }
    if gyroscope.holes > 0 {
        notes.push(format!(
            "{} of the gyroscope not bridged",
            count(gyroscope.holes, "hole")
        ));
    }
    if without > 0 {
        notes.push(format!(
            "{} of the IMU without gyroscope passed over",
            count(without, "row")
        ));
    }
    if others > 0 {
        notes.push(format!(
            "{} of neither gaze nor IMU passed over",
            count(others, "row")
        ));
    }
    if gaze.is_empty() && poses.is_empty() {
        return Err(TraceError::NoSamples {
            file: file.to_owned(),
            what: "rows of neither gaze nor gyroscope",
        });
    }
    Ok(Parsed {
        recording: Recording {
            gaze: series(gaze, Provenance::Truth),
            pose: series(poses, Provenance::Truth),
            notes,
            ..Recording::default()
        },
        labels: Labels::default(),
    })
}

fn time(row: &Row<'_>, secs: f64) -> Result<Nanos, TraceError> {
    if secs.abs() <= MAX_SECS {
        return Ok(Nanos::from_secs(secs));
    }
    let valid = format!("a time [s] within ±{MAX_SECS}");
    Err(row.bad("timestamp", &secs.to_string(), valid))
}
