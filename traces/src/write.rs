use std::io::{self, Write};

use foveasim_models::{GazeDirection, Pose, Provenance, Recording, Sample, Series};

use crate::formats::{COLUMNS, GAZE_ASSUMED, MAGIC, NO_SAMPLE, POSE_ASSUMED, VERSION};

/// Writes a recording in our own format (`docs/trace-format.md`), from which it reads back to the bit:
/// numbers have the fewest digits that do so.
///
/// Samples of gaze and pose at the same time share a row. A recording without any sample gives a
/// header alone, which is not readable. A provenance that its reader only assumed is not written: who
/// reads the file assumes it again, and notes that.
///
/// # Errors
/// If `out` cannot be written to.
pub fn write(recording: &Recording, mut out: impl Write) -> io::Result<()> {
    let gaze = recording.gaze.as_ref();
    let pose = recording.pose.as_ref();
    writeln!(out, "# {MAGIC} {VERSION}")?;
    let lines = [
        ("gaze", GAZE_ASSUMED, gaze.map(Series::provenance)),
        ("pose", POSE_ASSUMED, pose.map(Series::provenance)),
    ];
    for (name, assumed, is) in lines {
        let stated = is.filter(|p| *p != Provenance::Truth || !noted(recording, assumed));
        if let Some(is) = stated {
            writeln!(out, "# {name}_provenance: {}", provenance(is))?;
        }
    }
    if recording.format != "foveasim" && !recording.source.is_empty() {
        writeln!(out, "# note: made from {}", one_line(&recording.source))?;
    }
    let kept = |note: &&String| *note != GAZE_ASSUMED && *note != POSE_ASSUMED;
    for note in recording.notes.iter().filter(kept) {
        writeln!(out, "# note: {}", one_line(note))?;
    }
    let groups = [
        (0..1, true),
        (1..3, gaze.is_some()),
        (3..10, pose.is_some()),
    ];
    let names: Vec<_> = groups
        .into_iter()
        .filter(|g| g.1)
        .flat_map(|g| &COLUMNS[g.0])
        .copied()
        .collect();
    writeln!(out, "{}", names.join(","))?;

    let mut gazes = gaze.map_or(&[][..], |s| s.samples());
    let mut poses = pose.map_or(&[][..], |s| s.samples());
    while let Some(t) = [gazes.first().map(|s| s.t), poses.first().map(|s| s.t)]
        .into_iter()
        .flatten()
        .min()
    {
        write!(out, "{}", t.0)?;
        if gaze.is_some() {
            gaze_fields(&mut out, take(&mut gazes, t))?;
        }
        if pose.is_some() {
            pose_fields(&mut out, take(&mut poses, t))?;
        }
        writeln!(out)?;
    }
    out.flush()
}

fn noted(recording: &Recording, note: &str) -> bool {
    recording.notes.iter().any(|n| n == note)
}

/// The first of `samples`, taken off, if it is of time `t`.
fn take<T: Copy>(samples: &mut &[Sample<T>], t: foveasim_models::Nanos) -> Option<Sample<T>> {
    let (first, rest) = samples.split_first().filter(|(s, _)| s.t == t)?;
    *samples = rest;
    Some(*first)
}

fn gaze_fields(out: &mut impl Write, sample: Option<Sample<GazeDirection>>) -> io::Result<()> {
    match sample.map(|s| s.value) {
        None => write!(out, ",{NO_SAMPLE},{NO_SAMPLE}"),
        Some(None) => out.write_all(b",,"),
        Some(Some(g)) => write!(out, ",{},{}", g.azimuth_deg, g.elevation_deg),
    }
}

fn pose_fields(out: &mut impl Write, sample: Option<Sample<Pose>>) -> io::Result<()> {
    match sample.map(|s| s.value) {
        None => (0..7).try_for_each(|_| write!(out, ",{NO_SAMPLE}")),
        Some(None) => out.write_all(b",,,,,,,"),
        Some(Some(Pose {
            position: p,
            orientation: q,
        })) => {
            write!(
                out,
                ",{},{},{},{},{},{},{}",
                p.x, p.y, p.z, q.x, q.y, q.z, q.w
            )
        }
    }
}

fn provenance(provenance: Provenance) -> String {
    match provenance {
        Provenance::Truth => "truth".into(),
        Provenance::TrackerOutput { delay } => format!("tracker_output delay_ns={}", delay.0),
    }
}

fn one_line(text: &str) -> String {
    text.chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect::<String>()
        .trim()
        .to_owned()
}
