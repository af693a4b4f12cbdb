mod charts;

use foveasim_models::math::quantile_sorted;
use foveasim_models::{GazeSeries, Nanos, Recording};
use foveasim_reports::{Cell, Table};
use foveasim_traces::{
    Agreement, EventKind, EventOptions, GazeEvent, GazeEvents, Labels, MainSequence, TraceError,
    find_events, main_sequence, require_gaze, target_agreement, vendor_agreement,
};

/// Fixations, saccades and blinks of a recording, their main sequence, and how well they agree with what
/// the file itself says of events and targets.
#[derive(Debug, Clone, PartialEq)]
pub struct EventStudy {
    /// What was found, and how.
    pub events: GazeEvents,
    /// The limits it was found with.
    pub options: EventOptions,
    /// The fit to its saccades, where there are enough.
    pub main_sequence: Option<MainSequence>,
    /// Agreement with each kind of label, and with targets.
    pub agreements: Vec<Agreement>,
    /// How long was recorded, holes left out \[min\].
    minutes: f64,
    /// Time of the first sample \[s\].
    start_s: f64,
}

impl EventStudy {
    /// Finds the events of a recording.
    ///
    /// # Errors
    /// If it has no gaze, or an option is out of range.
    pub fn new(
        recording: &Recording,
        labels: &Labels,
        options: &EventOptions,
    ) -> Result<Self, TraceError> {
        let gaze = require_gaze(recording)?;
        let events =
            find_events(gaze, recording.gaze_rate, options).map_err(|error| match error {
                TraceError::NoGaze { why, .. } => TraceError::NoGaze {
                    source_name: recording.source.clone(),
                    why,
                },
                other => other,
            })?;
        let mut agreements = vendor_agreement(&events, labels);
        agreements.extend(target_agreement(gaze, &events, &labels.targets));
        Ok(Self {
            main_sequence: main_sequence(&events),
            agreements,
            minutes: recorded_s(gaze) / 60.0,
            start_s: gaze.start().as_secs(),
            options: *options,
            events,
        })
    }

    /// One row per event, in order of time.
    pub fn table(&self) -> Table {
        let mut table = Table::new([
            "kind",
            "start_s",
            "end_s",
            "duration_ms",
            "from_azimuth_deg",
            "from_elevation_deg",
            "to_azimuth_deg",
            "to_elevation_deg",
            "amplitude_deg",
            "peak_deg_per_s",
        ]);
        for e in &self.events.events {
            let angle = |gaze: Option<foveasim_models::GazeDirection>| match gaze {
                Some(g) => [g.azimuth_deg.into(), g.elevation_deg.into()],
                None => [Cell::Empty, Cell::Empty],
            };
            let [from_az, from_el] = angle(e.from);
            let [to_az, to_el] = angle(e.to);
            let of_gaze = |v: f64| e.from.map_or(Cell::Empty, |_| v.into());
            table.push(vec![
                e.kind.name().into(),
                e.start.as_secs().into(),
                e.end.as_secs().into(),
                e.duration().as_ms().into(),
                from_az,
                from_el,
                to_az,
                to_el,
                of_gaze(e.amplitude_deg),
                of_gaze(e.peak_deg_per_s),
            ]);
        }
        table
    }

    /// Counts, durations, main sequence and agreement: one row per number.
    pub fn summary(&self) -> Table {
        let mut table = Table::new(["part", "quantity", "value", "standard_error"]);
        self.limits(&mut table);
        for kind in EventKind::ALL {
            self.kind(kind, &mut table);
        }
        if let Some(fit) = &self.main_sequence {
            fitted(fit, &mut table);
        }
        for agreement in &self.agreements {
            agreed(agreement, &mut table);
        }
        table
    }

    fn limits(&self, table: &mut Table) {
        let mut row = |quantity: &str, value: Cell| {
            table.push(vec![
                "detection".into(),
                quantity.into(),
                value,
                Cell::Empty,
            ]);
        };
        row("method", self.options.method.name().into());
        row("rate_hz", self.events.rate_hz.into());
        if let Some(limits) = self.events.limits {
            row("limit_peak_deg_per_s", limits.peak_deg_per_s.into());
            row("limit_onset_deg_per_s", limits.onset_deg_per_s.into());
        }
        if !self.events.shapes_reliable {
            let text = "below 300 Hz: peak speeds and durations of saccades are not in the samples";
            row("warning", text.into());
        }
    }

    fn kind(&self, kind: EventKind, table: &mut Table) {
        let mut row = |quantity: &str, value: f64| {
            let value = if value.is_finite() {
                value.into()
            } else {
                Cell::Empty
            };
            table.push(vec![
                kind.name().into(),
                quantity.into(),
                value,
                Cell::Empty,
            ]);
        };
        let n = self.events.of(kind).count();
        row("count", n as f64);
        row("per_minute", n as f64 / self.minutes);
        let mut quantiles = |name: &str, unit: &str, value: fn(&GazeEvent) -> f64| {
            let mut values: Vec<f64> = self.events.of(kind).map(value).collect();
            values.sort_by(f64::total_cmp);
            for (q, at) in [("p50", 0.5), ("p95", 0.95)] {
                row(&format!("{name}_{q}_{unit}"), quantile_sorted(&values, at));
            }
        };
        quantiles("duration", "ms", |e| e.duration().as_ms());
        if kind == EventKind::Saccade {
            quantiles("amplitude", "deg", |e| e.amplitude_deg);
            quantiles("peak", "deg_per_s", |e| e.peak_deg_per_s);
        }
    }
}

/// Time between samples, without holes of a second and more \[s\].
fn recorded_s(gaze: &GazeSeries) -> f64 {
    const HOLE: Nanos = Nanos(1_000_000_000);
    let steps = gaze.samples().windows(2).map(|w| w[1].t - w[0].t);
    steps.filter(|s| *s < HOLE).map(|s| s.0).sum::<i64>() as f64 * 1e-9
}

fn fitted(fit: &MainSequence, table: &mut Table) {
    let mut row = |quantity: &str, value: f64, error: Cell| {
        table.push(vec![
            "main sequence".into(),
            quantity.into(),
            value.into(),
            error,
        ]);
    };
    row("saccades", fit.saccades as f64, Cell::Empty);
    for (name, e) in [
        ("peak_deg_per_s", fit.peak_deg_per_s),
        ("scale_deg", fit.scale_deg),
        ("duration_ms", fit.duration_ms),
        ("duration_ms_per_deg", fit.duration_ms_per_deg),
    ] {
        row(name, e.value, e.error.into());
    }
    row(
        "peak_residual_deg_per_s",
        fit.peak_residual_deg_per_s,
        Cell::Empty,
    );
    row(
        "duration_residual_ms",
        fit.duration_residual_ms,
        Cell::Empty,
    );
}

fn agreed(a: &Agreement, table: &mut Table) {
    let part = format!("{} against {}", a.kind.name(), a.reference_name);
    let mut row = |quantity: &str, value: f64| {
        if value.is_finite() {
            table.push(vec![
                part.as_str().into(),
                quantity.into(),
                value.into(),
                Cell::Empty,
            ]);
        }
    };
    row("reference", a.reference as f64);
    row("found", a.found as f64);
    row("matched", a.matched as f64);
    row("precision", a.precision());
    row("recall", a.recall());
    row("f1", a.f1());
    for (name, e) in [("onset", a.onset), ("offset", a.offset)] {
        row(&format!("{name}_mean_ms"), e.mean_ms);
        row(&format!("{name}_error_p50_ms"), e.median_ms);
        row(&format!("{name}_error_p95_ms"), e.p95_ms);
    }
}
