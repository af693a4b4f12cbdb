use foveasim_models::foveation::Method;
use foveasim_models::presets::Fact;
use foveasim_models::{Acuity, GazeMode, Geometry};
use foveasim_reports::{BarChart, BarSeries, Cell, Page, ReportError, Table, annotated};
use foveasim_traces::EventOptions;

use super::moments::PAGE_IMAGE_PX;
use super::{Evidence, Moment, Run, RunError, evidence, moments};
use crate::{
    GazePhases, LANDING, MapRatio, PhaseSpec, PhaseStudy, Quantity, RenderTime, Rows, Scenario,
    Suppression,
};

/// Everything in one page that needs nothing else.
pub(super) fn page(
    run: &Run,
    scenario: &Scenario,
    evidence: Option<&Evidence>,
) -> Result<String, RunError> {
    let mut page = Page::new(format!(
        "foveasim: {} with {}",
        scenario.display.title, scenario.tracker.title
    ));
    answer(&mut page, run, scenario);
    asked(&mut page, run, scenario);
    savings(&mut page, run, scenario)?;
    latency(&mut page, run, scenario);
    recording(&mut page, run, scenario)?;
    seen(&mut page, run, scenario)?;
    evidence::section(&mut page, evidence);
    rests_on(&mut page, scenario)?;
    Ok(page.html())
}

fn answer(page: &mut Page, run: &Run, scenario: &Scenario) {
    let featured = run.savings.featured();
    let photon = run.latency.histogram(Quantity::Gaze(Rows::Last));
    let error = run.replay.summary().gaze_error_deg;
    let error = error.map_or("unknown".into(), |e| format!("{:.1}°", e.p95));
    page.paragraph(&run.answer(scenario));
    page.key_numbers(&[
        (
            &format!("{:.1}×", featured.shading_ratio),
            "fewer shaded samples",
        ),
        (
            &format!("{:.1}×", featured.shading_ratio_staggered),
            "fewer, outer layers at half rate",
        ),
        (
            &format!("{:.1} ms", photon.mean_ms()),
            "gaze-to-photon, mean",
        ),
        (
            &format!("{:.1} ms", photon.quantile_ms(0.95)),
            "gaze-to-photon, 95th percentile",
        ),
        (&error, "gaze error, 95th percentile"),
    ]);
    page.table("Methods on this display, gaze at the centre. Times are predictions of the cost profile, each layer at its own rate; SSIM and PSNR are means over the rendered moments, all layers drawn at once.", &run.summary());
}

fn asked(page: &mut Page, run: &Run, scenario: &Scenario) {
    page.heading("What was asked");
    let spec = &scenario.spec;
    let panel = scenario.display.primary();
    let density = panel.viewport.pixel_density();
    let mut table = Table::new(["what", "value"]);
    let mut row = |what: &str, value: String| table.push(vec![what.into(), value.into()]);
    row(
        "display",
        format!("{} ({})", scenario.display.title, spec.display),
    );
    row("image", {
        let size = panel.viewport.size;
        let eyes = scenario.display.eyes.len();
        format!(
            "{} × {} pixels, {eyes} image(s), {} Hz",
            size.x,
            size.y,
            scenario.display.scan.rate.hz()
        )
    });
    row(
        "field of view",
        format!("{:.1}° horizontally", scenario.display.fov_h_deg()),
    );
    row(
        "pixels per degree",
        format!(
            "{:.1} at the centre, {:.1} on average, {:.1} at the least",
            density.centre, density.mean, density.min
        ),
    );
    row(
        "tracker",
        format!(
            "{} ({}), {} Hz",
            scenario.tracker.title,
            spec.tracker,
            scenario.tracker.rate.hz()
        ),
    );
    row(
        "recording",
        format!("{} ({})", run.recording.source, run.recording.format),
    );
    row("methods", spec.method.clone());
    row(
        "acuity",
        format!(
            "ω(e) = {} e + 1/48 degrees per cycle ({})",
            scenario.acuity.slope(),
            spec.slope
        ),
    );
    row(
        "gaze",
        format!("{}, margin {}°", scenario.gaze_mode, spec.margin_deg),
    );
    row("synchronisation", scenario.sync.to_string());
    row(
        "render time",
        match &scenario.render_time {
            RenderTime::Law(law) if law.min() == law.max() => {
                format!("{:.3} ms for every frame", law.min().as_ms())
            }
            RenderTime::Law(law) => {
                let (min, max) = (law.min().as_ms(), law.max().as_ms());
                format!("{}: {min:.3} to {max:.3} ms", spec.render_time)
            }
            RenderTime::Cost => format!(
                "cost profile {} on each frame's own samples",
                scenario.cost.name
            ),
        },
    );
    page.table("The scenario", &table);
}

fn savings(page: &mut Page, run: &Run, scenario: &Scenario) -> Result<(), RunError> {
    page.heading("What foveation saves");
    let methods = &run.savings.methods;
    let chart = BarChart {
        title: "Display pixels per shaded sample".into(),
        value_label: "times fewer shaded samples than full resolution".into(),
        groups: methods.iter().map(|m| m.method.to_string()).collect(),
        series: vec![
            BarSeries {
                label: "every layer in every frame".into(),
                values: methods.iter().map(|m| Some(m.shading_ratio)).collect(),
            },
            BarSeries {
                label: "each layer at its own rate".into(),
                values: methods
                    .iter()
                    .map(|m| Some(m.shading_ratio_staggered))
                    .collect(),
            },
        ],
    };
    page.svg(
        "Closed-form counts of the same design that is drawn; the drawn plan has whole samples, up to a percent more (plan_samples in plan.csv).",
        &chart.svg(),
    );
    let times = BarChart {
        title: "Predicted frame time".into(),
        value_label: "frame time [ms]".into(),
        groups: methods.iter().map(|m| m.method.to_string()).collect(),
        series: vec![BarSeries {
            label: format!("cost profile {}", scenario.cost.name),
            values: methods.iter().map(|m| Some(m.predicted_ms)).collect(),
        }],
    };
    page.svg(
        &format!("Predicted with: {}.", scenario.cost.title),
        &times.svg(),
    );
    page.subheading("Other fields of view and resolutions");
    page.paragraph(&format!(
        "Flat displays, 16:9, gaze at the centre; a colour stands for the same number in all maps of the same quantity. Hatched: the \
         display reaches beyond {:.1}° from its centre, farther than acuity slopes were measured. The times are those of \
         the cost profile.",
        Acuity::MEASURED_TO_DEG
    ));
    let times = run.savings.heatmaps(MapRatio::Time);
    for (samples, times) in run.savings.heatmaps(MapRatio::Shading).iter().zip(&times) {
        page.row(|page| {
            page.svg("", &samples.svg());
            page.svg("", &times.svg());
            Ok::<(), RunError>(())
        })?;
    }
    if methods.iter().any(|m| m.extrapolated) {
        page.note("This display reaches beyond the eccentricities at which acuity slopes were measured: its savings are extrapolated.");
    }
    if scenario.gaze_mode == GazeMode::Fixed {
        page.note("The sharp region stays at the centre: these savings hold only while the eye looks there, within the margin.");
    }
    growth(page, run, scenario)
}

fn growth(page: &mut Page, run: &Run, scenario: &Scenario) -> Result<(), RunError> {
    let growth = &run.savings.growth;
    page.subheading("Cost over field of view");
    page.paragraph(&format!(
        "Flat displays as sharp at the centre as this one and of its shape, every layer in every frame: Figs 12 and 13 of \
         Guenter et al. 2012 for this set-up. {}",
        growth.sentence(*scenario.featured())
    ));
    let [full, foveated] = growth.cost_charts();
    page.svg("", &growth.speedup_chart().svg());
    page.row(|page| {
        page.svg("", &full.svg());
        page.svg("", &foveated.svg());
        Ok(())
    })
}

fn latency(page: &mut Page, run: &Run, scenario: &Scenario) {
    page.heading("Latency");
    let latency = &run.latency;
    page.svg(
        &format!("The chain of {} and {} with {}, from the eye's movement to light at the gaze row. Shaded: the longest possible, by interval arithmetic.", scenario.tracker.title, scenario.display.title, scenario.sync),
        &latency.waterfall().svg(),
    );
    page.svg("All clocks have independent phases. Shaded: the bounds, found by interval arithmetic; the table says which are exact.", &latency.chart(Quantity::Gaze(Rows::Last)).svg());
    for caution in scenario.chain.cautions() {
        page.note(&format!("{caution}."));
    }
    if scenario.render_time == RenderTime::Cost {
        page.note("Frames take what the cost profile says of their own samples; here each takes the mean over the layers' cadence, and the bounds are those of that time.");
    }
    page.table("Every stage and quantity", &latency.table());
}

fn recording(page: &mut Page, run: &Run, scenario: &Scenario) -> Result<(), RunError> {
    page.heading("The recording");
    page.list(run.replay.summary().lines());
    let notes: Vec<&String> = run
        .recording
        .notes
        .iter()
        .chain(&run.replay.notes)
        .collect();
    if !notes.is_empty() {
        page.subheading("What was repaired or assumed");
        page.list(notes);
    }
    // Recordings without gaze, or too short for events, have none to mark.
    let phases = GazePhases::find(&run.recording, &EventOptions::default()).ok();
    page.svg(
        "The angle between where the eye was when the row it looked at gave light, and where the fovea of \
         that picture had been drawn. Saccades stand out: the picture follows one latency later.",
        &run.replay.gaze_error_chart(phases.as_ref()).svg(),
    );
    if let Some(phases) = &phases {
        let spec = PhaseSpec {
            display: &scenario.display,
            method: *scenario.featured(),
            acuity: scenario.acuity,
            suppression: Suppression::default(),
        };
        let study = PhaseStudy::new(&run.replay, phases, &spec)?;
        page.table(
            &format!(
                "That angle by what the eye did: in fixations, in saccades, and up to {} ms after landing; beside it, \
                 what margins that cover it cost with {}, and how often a jump beyond them would be seen",
                LANDING.as_ms(),
                scenario.featured()
            ),
            &study.table(None),
        );
    }
    page.svg(
        "How old each picture was: from the start of the exposure whose gaze it used to the light of the row \
         looked at. Over a blink or a loss the last gaze is held, and ages.",
        &run.replay.latency_chart(phases.as_ref()).svg(),
    );
    page.details("What was recorded", |page| -> Result<(), RunError> {
        page.table("", &run.recording_table());
        Ok(())
    })
}

fn seen(page: &mut Page, run: &Run, scenario: &Scenario) -> Result<(), RunError> {
    page.heading("What the viewer would see");
    if run.moments.is_empty() {
        page.paragraph("No picture was asked for.");
        return Ok(());
    }
    let from = match scenario.display.geometry {
        Geometry::Planar { .. } => "from a still head",
        Geometry::HeadMounted => "from the recorded head pose",
    };
    let about = match run.moments.iter().all(|m| m.gaze.is_some()) {
        true => "the true gaze",
        false => "where the gaze was taken to be: where the eye was is not known",
    };
    page.paragraph(&format!(
        "The study scene {from}, as the display's first image shows it with {}. All layers are drawn in \
         the same frame here; at their own rate the outer ones are up to a frame older. Pictures in this \
         page are at most {PAGE_IMAGE_PX} pixels wide; the PNG files beside it have all.",
        scenario.featured(),
    ));
    for (k, moment) in run.moments.iter().enumerate() {
        page.subheading(&format!(
            "Moment {}, {:.2} s into the recording",
            k + 1,
            moment.time.as_secs()
        ));
        picture(page, moment, scenario.featured())?;
    }
    page.table(
        &format!(
            "Image quality against full resolution, whole and by ring of eccentricity about {about}"
        ),
        &moments::quality_table(&run.moments),
    );
    page.details("What drawing took", |page| -> Result<(), RunError> {
        page.table("Exact work counts", &moments::work_table(&run.moments));
        Ok(())
    })
}

fn picture(page: &mut Page, moment: &Moment, featured: &Method) -> Result<(), RunError> {
    let Some((frame, outlines, error)) = &moment.small.featured else {
        return Ok(page.picture("Full resolution", &moment.small.reference)?);
    };
    page.row(|page| -> Result<(), RunError> {
        let eye = match moment.gaze {
            Some(_) => "the cross is where the eye was",
            None => "where the eye was is not known",
        };
        let caption = format!("{featured}: circles are the layers' edges; {eye}");
        page.svg(&caption, &annotated(&caption, frame, outlines)?);
        page.picture("Full resolution", &moment.small.reference)?;
        page.picture(&error.caption(), &error.image)?;
        Ok(())
    })?;
    page.svg("", &error.scale_svg());
    Ok(())
}

fn rests_on(page: &mut Page, scenario: &Scenario) -> Result<(), RunError> {
    page.heading("What this rests on");
    page.list([
        "Sample counts are those of the design that is drawn: its closed form, within 1e-9 of the optimum of its equations. The ideal floor is integrated to 1e-6.",
        "Latency is simulated event by event in whole nanoseconds; the bounds beside it are exact for independent clocks, but for those marked as outer: these hold and need not be reached.",
        "Predicted times use samples alone. That is a first estimate, not a measurement of your GPU: geometry, overdraw and bandwidth are not in it.",
        "SSIM (Wang 2004) and PSNR compare pixels; they do not know what an eye can see at an eccentricity. Read them by ring.",
        "Between samples of the recording the gaze is interpolated linearly. Below 500 Hz the shape of saccades is not in the data, and errors during them are underestimated.",
    ]);
    let unverified = scenario
        .facts
        .iter()
        .filter(|(_, f)| f.source.as_ref().is_some_and(|s| s.unverified))
        .count();
    page.paragraph(&format!(
        "{unverified} numbers of the devices could not be verified by us:"
    ));
    page.details(
        "Every number and its source",
        |page| -> Result<(), ReportError> {
            let mut table = Table::new(["what", "field", "value", "unverified", "source"]);
            for (
                kind,
                Fact {
                    field,
                    value,
                    source,
                },
            ) in &scenario.facts
            {
                let source = source.as_ref();
                table.push(vec![
                    (*kind).into(),
                    field.as_str().into(),
                    value.as_str().into(),
                    source.map_or(Cell::Empty, |s| {
                        (if s.unverified { "yes" } else { "no" }).into()
                    }),
                    source.map_or(Cell::Empty, |s| s.source.as_str().into()),
                ]);
            }
            page.table("", &table);
            Ok(())
        },
    )?;
    page.heading("How to reproduce it");
    page.paragraph("Save this as scenario.toml and run: foveasim run scenario.toml. The same file and version give the same numbers and pictures.");
    page.preformatted(&scenario.to_toml());
    Ok(())
}
