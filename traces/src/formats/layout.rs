use foveasim_models::{GazeDirection, math};
use glam::DVec3;

use super::Format;
use super::axes::{Axes, PoseFrame};
use crate::{EventKind, Screen};

/// A delimited format, as data: which columns it has and what they mean.
///
/// A column is named as in the file, in any letter case; `a|b` stands for either name.
#[derive(Debug)]
pub(super) struct Layout {
    pub(super) format: Format,
    /// Columns that together say that a file is of this layout.
    pub(super) marks: &'static [&'static str],
    pub(super) time: Time,
    /// The columns of both eyes together, or of the left eye and the right one.
    pub(super) eyes: &'static [EyeColumns],
    pub(super) coding: Coding,
    pub(super) pose: Option<PoseColumns>,
    /// Events: rows in a run with the same text in a column, which is empty outside of them.
    pub(super) events: &'static [(EventKind, &'static str)],
    /// Where the viewer was asked to look, coded as gaze is.
    pub(super) target: Option<Target>,
    /// A column whose value changes where a new session begins, whose clock may start again.
    pub(super) session: Option<&'static str>,
    /// Two neighbouring columns, a number and a truth value, that some files write as one field.
    pub(super) glued: Option<[&'static str; 2]>,
    pub(super) notes: &'static [&'static str],
}

/// The clock.
#[derive(Debug)]
pub(super) struct Time {
    pub(super) column: &'static str,
    /// The unit is 10^`exponent` s.
    pub(super) exponent: i32,
    /// What is taken off each time \[units\]; such times are whole numbers.
    pub(super) epoch: Option<i64>,
}

/// The columns of an eye, or of both eyes together.
#[derive(Debug)]
pub(super) struct EyeColumns {
    /// Two coordinates, or three.
    pub(super) columns: &'static [&'static str],
    pub(super) valid: Option<Valid>,
}

/// A column that says whether an eye was seen, and how to read it; `None` for what it cannot hold.
#[derive(Debug)]
pub(super) struct Valid {
    pub(super) column: &'static str,
    pub(super) rule: fn(&str) -> Option<bool>,
    pub(super) expected: &'static str,
}

/// What the coordinates of gaze are.
#[derive(Debug, Clone, Copy)]
pub(super) enum Coding {
    /// None: the file has no gaze.
    None,
    /// A direction; one of length 0 is lost.
    Vector(Axes),
    /// Azimuth to the right and elevation upwards \[deg\].
    Degrees,
    /// Angles whose tangents are the sides of a direction with these axes, of depth 1 \[rad\].
    Tangents(Axes),
    /// Pixels from a screen's centre, y down.
    CentredPixels(Screen),
    /// Pixels from a screen's top-left corner, y down.
    CornerPixels(Screen),
    /// Shares of a screen's width and height, from its top-left corner.
    Shares(Screen),
}

impl Coding {
    /// The screen looked at, where there is one.
    pub(super) fn screen(&self) -> Option<Screen> {
        match *self {
            Self::CentredPixels(s) | Self::CornerPixels(s) | Self::Shares(s) => Some(s),
            _ => None,
        }
    }

    /// The largest value that a coordinate can have.
    pub(super) fn limit(&self) -> f64 {
        match self {
            Self::None | Self::Vector(_) => 2.0,
            Self::Degrees => 180.0,
            Self::Tangents(_) => 1.57,
            Self::CentredPixels(_) | Self::CornerPixels(_) => 1e6,
            Self::Shares(_) => 1e3,
        }
    }

    /// The direction that coordinates stand for, on `screen` if they are of one; `None` for a vector
    /// without length.
    pub(super) fn direction(&self, v: DVec3, screen: &Screen) -> Option<GazeDirection> {
        let mm = |i: usize, px: f64| px * (screen.size_mm[i] / screen.size_px[i]);
        Some(match self {
            Self::None => return None,
            Self::Vector(axes) => {
                if v.length() < 1e-3 {
                    return None;
                }
                GazeDirection::from_vector(axes.vector(v))
            }
            Self::Degrees => GazeDirection::new(v.x, v.y),
            Self::Tangents(axes) => {
                let sides = DVec3::new(math::tan(v.x), math::tan(v.y), 1.0);
                GazeDirection::from_vector(axes.vector(sides))
            }
            Self::CentredPixels(_) => screen.direction([mm(0, v.x), mm(1, v.y)]),
            Self::CornerPixels(_) => {
                let half = screen.size_px.map(|px| 0.5 * px);
                screen.direction([mm(0, v.x - half[0]), mm(1, v.y - half[1])])
            }
            Self::Shares(_) => {
                let [w, h] = screen.size_mm;
                screen.direction([(v.x - 0.5) * w, (v.y - 0.5) * h])
            }
        })
    }

    /// What a mean of two eyes is taken of.
    pub(super) fn of(&self) -> &'static str {
        if self.screen().is_some() {
            " on the screen"
        } else {
            ""
        }
    }
}

/// Where the viewer was asked to look.
#[derive(Debug)]
pub(super) struct Target {
    pub(super) columns: [&'static str; 2],
    /// A column, and its value while there is no target.
    pub(super) none: Option<(&'static str, &'static str)>,
}

/// Where the head is.
#[derive(Debug)]
pub(super) struct PoseColumns {
    /// \[m\]; without them the head stays at the origin.
    pub(super) position: Option<[&'static str; 3]>,
    pub(super) rotation: Rotation,
    pub(super) frame: PoseFrame,
}

/// How a head is turned.
#[derive(Debug)]
pub(super) enum Rotation {
    /// x, y, z, w.
    Quaternion([&'static str; 4]),
    /// Unity's Euler angles, x, y and z \[deg\].
    UnityEuler([&'static str; 3]),
    /// Angular velocity of the device \[deg/s\], where its quaternion (x, y, z, w) is empty.
    Gyroscope {
        quaternion: [&'static str; 4],
        rate: [&'static str; 3],
        axes: Axes,
    },
}
