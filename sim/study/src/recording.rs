use foveasim_models::{Provenance, Recording};
use foveasim_reports::{Cell, Table};
use foveasim_traces::SeriesInfo;

/// What a recording holds: one row per property.
pub fn recording_table(recording: &Recording) -> Table {
    let mut table = Table::new(["series", "quantity", "value"]);
    let mut row = |series: &str, quantity: &str, value: Cell| {
        table.push(vec![series.into(), quantity.into(), value]);
    };
    row("", "format", recording.format.as_str().into());
    if let Some((start, _)) = recording.span() {
        row("", "start_ns", start.0.into());
    }
    let about = foveasim_traces::info(recording);
    for (series, about) in [("gaze", about.gaze), ("pose", about.pose)] {
        match about {
            Some(about) => describe(&about, |quantity, value| row(series, quantity, value)),
            None => row(series, "samples", 0_usize.into()),
        }
    }
    for note in &recording.notes {
        row("", "note", note.as_str().into());
    }
    table
}

fn describe(about: &SeriesInfo, mut row: impl FnMut(&str, Cell)) {
    let known = |v: f64| {
        if v.is_finite() {
            Cell::Float(v)
        } else {
            Cell::Empty
        }
    };
    let missing_percent = 100.0 * about.missing as f64 / about.samples as f64;
    row("samples", about.samples.into());
    row("missing", about.missing.into());
    row("missing_percent", missing_percent.into());
    row("longest_loss_ms", about.longest_loss.as_ms().into());
    row("duplicates", about.duplicates.into());
    row("duration_s", about.duration.as_secs().into());
    row("rate_hz", known(about.rate_hz));
    row("interval_iqr_ms", known(about.interval_iqr_ms));
    row("interval_sd_ms", known(about.interval_sd_ms));
    row("gaps", about.gaps.into());
    row("longest_gap_ms", about.longest_gap.as_ms().into());
    for (name, low, high) in &about.extents {
        let (stem, unit) = name.rsplit_once('_').unwrap_or((name, ""));
        row(&format!("{stem}_min_{unit}"), (*low).into());
        row(&format!("{stem}_max_{unit}"), (*high).into());
    }
    row("angle_step_deg", known(about.angle_step_deg));
    match about.provenance {
        Provenance::Truth => row("provenance", "truth".into()),
        Provenance::TrackerOutput { delay } => {
            row("provenance", "tracker_output".into());
            row("delay_ms", delay.as_ms().into());
        }
    }
    if about.missing == about.samples {
        row("warning", "no valid sample: every one is lost".into());
    }
}
