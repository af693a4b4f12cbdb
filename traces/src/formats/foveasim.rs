use foveasim_models::{GazeDirection, Nanos, Pose, Provenance, Sample};

use super::columns::Columns;
use super::number::Row;
use super::rows::{AllRows, RowReader, RowSamples};
use super::{GAZE_ASSUMED, Head, POSE_ASSUMED, in_order, no_rows};
use crate::lines::Line;
use crate::{Labels, ReadOptions, TraceError};

/// The word after `#` with which the first line begins.
pub(crate) const MAGIC: &str = "foveasim-trace";
/// The version that is read and written.
pub(crate) const VERSION: u32 = 1;
/// In all fields of a group: this series has no sample at this time.
pub(crate) const NO_SAMPLE: &str = "n/a";

/// All columns, in the order they are written.
pub(crate) const COLUMNS: [&str; 10] = [
    "t_ns",
    "gaze_azimuth_deg",
    "gaze_elevation_deg",
    "position_x_m",
    "position_y_m",
    "position_z_m",
    "orientation_x",
    "orientation_y",
    "orientation_z",
    "orientation_w",
];

/// Reads our own CSV; see `docs/trace-format.md`.
pub(super) struct Rows<'a> {
    file: &'a str,
    stated: Stated,
    columns: Columns<10>,
    has_gaze: bool,
    has_pose: bool,
    previous: Option<Nanos>,
    /// Whether there was any sample of gaze, and of pose.
    any: [bool; 2],
}

impl<'a> Rows<'a> {
    pub(super) fn new(head: &Head, file: &'a str) -> Result<Self, TraceError> {
        let stated = comments(file, &head.comments)?;
        let columns = Columns::new(file, &head.columns, COLUMNS)?;
        let header = |what: String| TraceError::Header {
            file: file.to_owned(),
            line: head.columns.0,
            what,
        };
        if !columns.has(0) {
            return Err(header("no column t_ns".into()));
        }
        if let Some(extra) = columns.extra().first() {
            let names = foveasim_models::unknown_name("column", extra, &COLUMNS);
            return Err(header(names.to_string()));
        }
        let group =
            |range: std::ops::Range<usize>| match range.clone().filter(|&i| columns.has(i)).count()
            {
                0 => Ok(false),
                n if n == range.len() => Ok(true),
                _ => Err(header(format!(
                    "want all of {} or none",
                    COLUMNS[range].join(", ")
                ))),
            };
        let (has_gaze, has_pose) = (group(1..3)?, group(3..10)?);
        if !has_gaze && !has_pose {
            return Err(header("no gaze columns and no pose columns".into()));
        }
        Ok(Self {
            file,
            stated,
            columns,
            has_gaze,
            has_pose,
            previous: None,
            any: [false; 2],
        })
    }
}

impl RowReader for Rows<'_> {
    fn row(&mut self, line: &Line<'_>) -> Result<RowSamples, TraceError> {
        let row = Row::new(self.file, line, self.columns.decimal_comma());
        let texts = row.pick(&self.columns, line.text)?;
        let t = row.time(COLUMNS[0], texts[0], -9)?;
        in_order(&row, self.previous, t)?;
        self.previous = Some(t);
        let mut samples = RowSamples::default();
        if self.has_gaze {
            let value = match content(&row, &COLUMNS[1..3], &texts[1..3])? {
                Content::NoSample => None,
                Content::Missing => Some(None),
                Content::Value => {
                    let azimuth = row.number(COLUMNS[1], texts[1], -180.0..=180.0)?;
                    let elevation = row.number(COLUMNS[2], texts[2], -90.0..=90.0)?;
                    Some(Some(GazeDirection::new(azimuth, elevation)))
                }
            };
            samples.gaze = value.map(|value| Sample { t, value });
        }
        if self.has_pose {
            let value = match content(&row, &COLUMNS[3..], &texts[3..])? {
                Content::NoSample => None,
                Content::Missing => Some(None),
                Content::Value => {
                    let [_, _, _, x, y, z, qx, qy, qz, qw] = texts;
                    let [_, _, _, nx, ny, nz, nqx, nqy, nqz, nqw] = COLUMNS;
                    let position = row.vector([nx, ny, nz], [x, y, z])?;
                    let orientation = row.quaternion([nqx, nqy, nqz, nqw], [qx, qy, qz, qw])?;
                    Some(Some(Pose::new(position, orientation)))
                }
            };
            samples.pose = value.map(|value| Sample { t, value });
        }
        self.any[0] |= samples.gaze.is_some();
        self.any[1] |= samples.pose.is_some();
        Ok(samples)
    }

    fn finish(&mut self, _: &ReadOptions) -> Result<AllRows, TraceError> {
        if self.any == [false; 2] {
            return Err(no_rows(self.file));
        }
        let Stated {
            gaze,
            pose,
            mut notes,
        } = std::mem::take(&mut self.stated);
        let assumed = [(gaze, GAZE_ASSUMED), (pose, POSE_ASSUMED)];
        for (any, (is, note)) in self.any.into_iter().zip(assumed) {
            if any && is.is_none() {
                notes.push(note.to_owned());
            }
        }
        Ok(AllRows {
            range: 0..usize::MAX,
            provenance: [gaze, pose].map(Option::unwrap_or_default),
            notes,
            labels: Labels::default(),
        })
    }
}

/// What the fields of one group say.
enum Content {
    /// All `n/a`.
    NoSample,
    /// All empty or `nan`.
    Missing,
    /// Numbers.
    Value,
}

fn content(row: &Row<'_>, names: &[&str], texts: &[&str]) -> Result<Content, TraceError> {
    let missing = |t: &str| t.is_empty() || t.eq_ignore_ascii_case("nan");
    let none = texts.iter().filter(|t| **t == NO_SAMPLE).count();
    let lost = texts.iter().filter(|t| missing(t)).count();
    if none == texts.len() {
        Ok(Content::NoSample)
    } else if lost == texts.len() {
        Ok(Content::Missing)
    } else if none + lost == 0 {
        Ok(Content::Value)
    } else {
        let i = texts
            .iter()
            .position(|t| missing(t) || *t == NO_SAMPLE)
            .unwrap_or(0);
        let valid =
            format!("a number like the others of its group, or all of them empty or {NO_SAMPLE}");
        Err(row.bad(names[i], texts[i], valid))
    }
}

/// What the comments of a header say.
#[derive(Default)]
struct Stated {
    gaze: Option<Provenance>,
    pose: Option<Provenance>,
    notes: Vec<String>,
}

fn comments(file: &str, comments: &[(usize, String)]) -> Result<Stated, TraceError> {
    let mut stated = Stated::default();
    for (line, text) in comments {
        let header = |what: String| TraceError::Header {
            file: file.to_owned(),
            line: *line,
            what,
        };
        if let Some(version) = text.strip_prefix(MAGIC) {
            if version.trim() != VERSION.to_string() {
                let what = format!(
                    "version `{}` of the format; this reads {VERSION}",
                    version.trim()
                );
                return Err(header(what));
            }
            continue;
        }
        let Some((key, value)) = text.split_once(':') else {
            continue;
        };
        let provenance = || {
            let valid = "want `truth` or `tracker_output delay_ns=WHOLE_NUMBER`";
            parse_provenance(value.trim())
                .ok_or_else(|| header(format!("provenance `{}`: {valid}", value.trim())))
        };
        match key.trim() {
            "provenance" => {
                stated.gaze = Some(provenance()?);
                stated.pose = stated.gaze;
            }
            "gaze_provenance" => stated.gaze = Some(provenance()?),
            "pose_provenance" => stated.pose = Some(provenance()?),
            "note" => stated.notes.push(value.trim().to_owned()),
            _ => {}
        }
    }
    Ok(stated)
}

fn parse_provenance(text: &str) -> Option<Provenance> {
    if text == "truth" {
        return Some(Provenance::Truth);
    }
    let delay = text
        .strip_prefix("tracker_output")?
        .trim()
        .strip_prefix("delay_ns=")?;
    // A tracker that is ten minutes late is a slip of the pen.
    let delay = delay
        .parse()
        .ok()
        .filter(|ns| (0..=600_000_000_000).contains(ns))?;
    Some(Provenance::TrackerOutput {
        delay: Nanos(delay),
    })
}
