mod frames;

use std::io::BufRead;

use foveasim_models::{Nanos, Recording};
use glam::{DQuat, DVec3};

use frames::Frames;

use super::Head;
use super::columns::Columns;
use super::number::Row;
use crate::lines::Lines;
use crate::{ReadOptions, TraceError};

const COLUMNS: [&str; 20] = [
    "ViewIndex",
    "FOV1",
    "FOV2",
    "FOV3",
    "FOV4",
    "PositionX",
    "PositionY",
    "PositionZ",
    "QuaternionX",
    "QuaternionY",
    "QuaternionZ",
    "QuaternionW",
    "GazePosX",
    "GazePosY",
    "GazePosZ",
    "GazeQX",
    "GazeQY",
    "GazeQZ",
    "GazeQW",
    "Timestamp",
];

/// EyeNavGS (Rutgers, 2025): head pose and gaze in a scene, one row per eye, `Timestamp` in ms.
///
/// What the six recordings at hand show, and what is therefore done:
///
/// * A frame is a left row and then a right one, and both carry the same `Quaternion`, digit for
///   digit; the position is the eye's. The head is the midpoint of the eyes, at the time of the left
///   row. Any other row (its partner is missing, or is of another frame: the head has turned) is a
///   frame of its own, and moved along the head's X axis by half the median distance between the eyes.
/// * Positions are in scene units, `scale` of them to a metre (0.76 · 65.3 mm = 0.0496 between the
///   eyes in `truck`).
/// * `GazeQ` turns −Z into the direction of gaze **in the world**. Taken so, gaze relative to the head
///   stays within ±20° of azimuth about a mean of 2.1° for the left eye and −1.0° for the right (the
///   eyes converge); taken as relative to the head it would scatter by 90°.
/// * `GazePos` is not a direction (its offset from the eye stands at 110–130° to `GazeQ`) and is not
///   used. In recordings without eye tracking it holds the same for both eyes, a displacement that
///   walking by controller leaves.
/// * Gaze is lost where `GazeQ` is the identity, **whatever** `GazePos` holds: two recordings keep the
///   identity to the end while `GazePos` moves, and as a direction it would be fixed in the world.
/// * `FOV1..4` are told apart by sign, not by name: left and down are negative.
pub(super) fn parse<R: BufRead>(
    head: &Head,
    lines: &mut Lines<'_, R>,
    options: &ReadOptions,
) -> Result<Recording, TraceError> {
    let file = lines.file();
    let columns = Columns::new(file, &head.columns, COLUMNS)?;
    if let Some(i) = (0..COLUMNS.len()).find(|&i| !columns.has(i) && !(1..5).contains(&i)) {
        let what = format!("no column {}", COLUMNS[i]);
        return Err(TraceError::Header {
            file: file.to_owned(),
            line: head.columns.0,
            what,
        });
    }
    let mut frames = Frames::default();
    while let Some(line) = lines.next()? {
        let row = Row::new(file, &line, columns.decimal_comma());
        let texts = row.pick(&columns, line.text)?;
        frames.push(&row, eye_row(&row, &texts)?)?;
        frames.fields_of_view(&row, &texts, (1..5).all(|i| columns.has(i)))?;
        frames.decimals = frames
            .decimals
            .max(texts[8..12].iter().map(|t| decimals(t)).max().unwrap_or(0));
    }
    if !columns.extra().is_empty() {
        frames
            .notes
            .push(format!("columns not used: {}", columns.extra().join(", ")));
    }
    frames.finish(file, options)
}

/// One row, as the file has it.
struct EyeRow {
    view: usize,
    t: Nanos,
    /// Scene units.
    position: DVec3,
    world_from_head: DQuat,
    /// Relative to the head; `None` where lost.
    gaze: Option<DVec3>,
    stray_gaze_position: bool,
}

fn eye_row(row: &Row<'_>, texts: &[&str; 20]) -> Result<EyeRow, TraceError> {
    let view = match texts[0] {
        "0" => 0,
        "1" => 1,
        other => return Err(row.bad(COLUMNS[0], other, "0 (left) or 1 (right)")),
    };
    let three = |i: usize| {
        (
            [COLUMNS[i], COLUMNS[i + 1], COLUMNS[i + 2]],
            [texts[i], texts[i + 1], texts[i + 2]],
        )
    };
    let four = |i: usize| {
        (
            [COLUMNS[i], COLUMNS[i + 1], COLUMNS[i + 2], COLUMNS[i + 3]],
            [texts[i], texts[i + 1], texts[i + 2], texts[i + 3]],
        )
    };
    let vector = |i| {
        let (names, texts) = three(i);
        row.vector(names, texts)
    };
    let rotation = |i| {
        let (names, texts) = four(i);
        row.quaternion(names, texts)
    };
    let world_from_head = rotation(8)?;
    let gaze_position = vector(12)?;
    let world_from_gaze = rotation(15)?;
    let lost = world_from_gaze == DQuat::IDENTITY;
    let gaze = (!lost).then(|| world_from_head.conjugate() * (world_from_gaze * DVec3::NEG_Z));
    Ok(EyeRow {
        view,
        t: row.time(COLUMNS[19], texts[19], -3)?,
        position: vector(5)?,
        world_from_head,
        gaze,
        stray_gaze_position: lost && gaze_position != DVec3::ZERO,
    })
}

/// Digits after the decimal sign.
fn decimals(text: &str) -> usize {
    text.rsplit_once(['.', ','])
        .map_or(0, |(_, digits)| digits.len())
}
