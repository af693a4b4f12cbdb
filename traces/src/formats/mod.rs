//! The formats that can be read, behind one closed list: delimited ones are data (`layouts`), which one
//! reader (`table`) understands; the others have a file each.

mod axes;
mod columns;
mod eyelink;
mod eyenavgs;
mod eyes;
mod foveasim;
mod glasses3;
mod gyroscope;
mod head;
mod layout;
mod layouts;
mod number;
mod places;
mod rows;
mod runs;
mod segments;
mod table;
mod tum;

use std::io::BufRead;

use foveasim_models::{Interpolate, Nanos, Provenance, Recording, Sample, Series};

use crate::lines::Lines;
use crate::{Labels, ReadOptions, TraceError};

pub(crate) use foveasim::{COLUMNS, MAGIC, NO_SAMPLE, VERSION};
pub(crate) use head::Head;
pub use rows::RowSamples;
pub(crate) use rows::{RowReader, next_row};

/// The note on gaze of which nobody said what it is. Readers give it instead of a provenance, and
/// [`write`](crate::write) writes neither, so that an assumption does not become a statement.
pub(crate) const GAZE_ASSUMED: &str =
    "gaze taken as the truth: the file does not say what delay or filter its samples have";
/// The same of head pose.
pub(crate) const POSE_ASSUMED: &str =
    "head pose taken as the truth: the file does not say what delay or filter its samples have";

/// What a file held.
#[derive(Debug, Default)]
pub(crate) struct Parsed {
    pub(crate) recording: Recording,
    pub(crate) labels: Labels,
}

impl From<Recording> for Parsed {
    fn from(recording: Recording) -> Self {
        Self {
            recording,
            labels: Labels::default(),
        }
    }
}

/// The formats that can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// EyeNavGS: CSV of head pose and gaze, one row per eye (Meta Quest Pro).
    EyeNavGs,
    /// Tab-separated gaze in pixels from the centre of a screen (as in ETDQualitizer).
    ScreenCentred,
    /// EyeLink's ASC: samples, events and messages.
    EyeLink,
    /// Raw output of Tobii's SDK for screen-based trackers, tab-separated.
    TobiiSdk,
    /// HTC Vive Pro Eye through SRanipal: gaze and helmet, separated by semicolons.
    ViveProEye,
    /// Pico Neo 3 Pro Eye, logged by Unity: gaze and head, separated by tabs.
    PicoNeo3,
    /// Pupil Invisible as exported by Pupil Cloud: gaze.csv or imu.csv.
    PupilInvisible,
    /// Tobii Pro Glasses 3: JSON lines of gaze or of the IMU.
    Glasses3,
    /// Salient360: gaze and camera of a headset, while a film or a still image was seen.
    Salient360,
    /// Project Aria: eye gaze.
    AriaGaze,
    /// Project Aria: trajectory of the device.
    AriaTrajectory,
    /// EuRoC: trajectory with nanoseconds and the quaternion's w first.
    Euroc,
    /// GazeBase and GazeBaseVR: gaze in degrees.
    GazeBase,
    /// JuDo1000: gaze in pixels from the top-left corner.
    JuDo1000,
    /// TUM trajectory: `time x y z qx qy qz qw`, separated by spaces.
    Tum,
    /// Our own CSV; `docs/trace-format.md` describes it.
    Foveasim,
}

impl Format {
    /// Every format.
    pub const ALL: [Self; 16] = [
        Self::EyeNavGs,
        Self::ScreenCentred,
        Self::EyeLink,
        Self::TobiiSdk,
        Self::ViveProEye,
        Self::PicoNeo3,
        Self::PupilInvisible,
        Self::Glasses3,
        Self::Salient360,
        Self::AriaGaze,
        Self::AriaTrajectory,
        Self::Euroc,
        Self::GazeBase,
        Self::JuDo1000,
        Self::Tum,
        Self::Foveasim,
    ];

    /// Short name.
    pub fn name(self) -> &'static str {
        match self {
            Self::EyeNavGs => "eyenavgs",
            Self::ScreenCentred => "screen-centred",
            Self::EyeLink => "eyelink",
            Self::TobiiSdk => "tobii-sdk",
            Self::ViveProEye => "vive-pro-eye",
            Self::PicoNeo3 => "pico-neo3",
            Self::PupilInvisible => "pupil-invisible",
            Self::Glasses3 => "tobii-glasses3",
            Self::Salient360 => "salient360",
            Self::AriaGaze => "aria-gaze",
            Self::AriaTrajectory => "aria-trajectory",
            Self::Euroc => "euroc",
            Self::GazeBase => "gazebase",
            Self::JuDo1000 => "judo1000",
            Self::Tum => "tum",
            Self::Foveasim => "foveasim",
        }
    }

    /// Whether its first line names the columns, and is no data.
    fn names_columns(self) -> bool {
        !matches!(self, Self::Tum | Self::EyeLink | Self::Glasses3)
    }

    /// Whether a file may hold several sessions of which one is read.
    fn has_segments(self) -> bool {
        matches!(self, Self::EyeNavGs | Self::JuDo1000)
    }

    /// A file that holds one session has no other to be asked for, and one in metres has no scale.
    fn check_options(self, file: &str, options: &ReadOptions) -> Result<(), TraceError> {
        match options.segment {
            Some(wanted) if wanted != 1 && !self.has_segments() => Err(TraceError::NoSuchSegment {
                file: file.to_owned(),
                wanted,
                segments: 1,
            }),
            _ => match options.scale {
                Some(scale) if self != Self::EyeNavGs => {
                    let valid = format!(
                        "absent: {file} is {}, which has no scene units; {} has",
                        self.name(),
                        Self::EyeNavGs.name()
                    );
                    Err(TraceError::option("scale", scale, valid))
                }
                _ => Ok(()),
            },
        }
    }

    /// A reader of a file that is understood row by row; `None` for the formats that are not.
    pub(crate) fn rows<'a>(
        self,
        head: &Head,
        file: &'a str,
        options: &ReadOptions,
    ) -> Result<Option<Box<dyn RowReader + 'a>>, TraceError> {
        self.check_options(file, options)?;
        let layout = match self {
            Self::EyeNavGs | Self::EyeLink | Self::Glasses3 => return Ok(None),
            Self::Foveasim => return Ok(Some(Box::new(foveasim::Rows::new(head, file)?))),
            Self::Tum => return Ok(Some(Box::new(tum::Rows::new(file)))),
            Self::ScreenCentred => &layouts::SCREEN_CENTRED,
            _ => {
                let names = columns::names(&head.columns.1);
                let layout = layout_of(&names).filter(|layout| layout.format == self);
                layout.expect("the format was found by its layout's columns")
            }
        };
        let table = table::Table::new(layout, head, file, options)?;
        Ok(Some(Box::new(table)))
    }

    pub(crate) fn parse<R: BufRead>(
        self,
        head: &Head,
        lines: &mut Lines<'_, R>,
        options: &ReadOptions,
    ) -> Result<Parsed, TraceError> {
        self.check_options(lines.file(), options)?;
        match self {
            Self::EyeNavGs => eyenavgs::parse(head, lines, options).map(Parsed::from),
            Self::EyeLink => eyelink::parse(lines, options),
            Self::Glasses3 => glasses3::parse(lines),
            _ => {
                let rows = self.rows(head, lines.file(), options)?;
                let mut rows = rows.expect("all others are read row by row");
                rows::collect(rows.as_mut(), lines, options)
            }
        }
    }

    fn of_line(first: &str) -> Option<Self> {
        if glasses3::begins(first) {
            return Some(Self::Glasses3);
        }
        if eyelink::begins(first) {
            return Some(Self::EyeLink);
        }
        let names = columns::names(first);
        let has = |name: &str| names.iter().any(|n| n.eq_ignore_ascii_case(name));
        if has("t_ns") {
            Some(Self::Foveasim)
        } else if ["ViewIndex", "QuaternionX", "GazeQX", "Timestamp"]
            .iter()
            .all(|n| has(n))
        {
            Some(Self::EyeNavGs)
        } else if has("timestamp")
            && ["left_x", "left_y", "right_x", "right_y"]
                .iter()
                .any(|n| has(n))
        {
            Some(Self::ScreenCentred)
        } else if let Some(layout) = layout_of(&names) {
            Some(layout.format)
        } else if first.split_ascii_whitespace().count() == tum::FIELDS
            && first
                .split_ascii_whitespace()
                .all(|f| f.parse::<f64>().is_ok())
        {
            Some(Self::Tum)
        } else {
            None
        }
    }
}

/// The first layout whose marks are all among these columns.
fn layout_of(names: &[&str]) -> Option<&'static layout::Layout> {
    let has = |mark: &&str| names.iter().any(|name| columns::called(mark, name));
    layouts::LAYOUTS
        .iter()
        .find(|layout| layout.marks.iter().all(has))
}

impl std::fmt::Display for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Refuses a row whose time is before the one above it.
fn in_order(row: &number::Row<'_>, previous: Option<Nanos>, t: Nanos) -> Result<(), TraceError> {
    match previous {
        // The last row of a file that was cut off may have lost digits of its time.
        Some(from) if t < from && !row.complete => Err(TraceError::Truncated {
            file: row.file.to_owned(),
            line: row.line,
        }),
        Some(from) if t < from => Err(TraceError::TimeReversed {
            file: row.file.to_owned(),
            line: row.line,
            from,
            to: t,
        }),
        _ => Ok(()),
    }
}

/// A series of samples whose order was checked; `None` where there is none.
fn series<T: Interpolate>(samples: Vec<Sample<T>>, provenance: Provenance) -> Option<Series<T>> {
    (!samples.is_empty())
        .then(|| Series::new(samples, provenance).expect("readers check the order of time"))
}

/// The error for a file with a header and no row.
fn no_rows(file: &str) -> TraceError {
    TraceError::NoSamples {
        file: file.to_owned(),
        what: "a header alone",
    }
}

/// "1 sample", "2 samples".
pub(crate) fn count(n: usize, noun: &str) -> String {
    format!("{n} {noun}{}", if n == 1 { "" } else { "s" })
}
