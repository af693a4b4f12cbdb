//! Writes every kind of chart and picture, and a page with all of them, to a folder:
//! `cargo run -p foveasim-reports --example gallery -- FOLDER`. For looking at after a change.

use foveasim_models::{Image, Nanos, Rect, Stream, Viewport, math};
use foveasim_reports::{
    BarChart, BarSeries, ColourScale, HeatCell, Heatmap, Histogram, HistogramSeries, LineChart,
    LineSeries, Outline, Outputs, Page, ReportError, Table, TraceEvents, Waterfall, WaterfallStage,
    annotated, error_map, overlay, png, side_by_side,
};
use glam::{DVec2, DVec3, UVec2};

fn main() -> Result<(), ReportError> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "gallery".into());
    let mut out = Outputs::new(folder)?;
    let mut page = Page::new("Gallery: LG W2363D with Tobii TX300 & \"layers:3\" <test>");
    page.key_numbers(&[
        (
            "13.3 ×",
            "fewer samples than full resolution, layers staggered",
        ),
        ("29.97 ms", "mean gaze-to-photon latency, gaze row, tearing"),
        ("0.93", "SSIM, whole image"),
        ("2.31°", "95th percentile of gaze error"),
    ]);
    page.heading("What it would save");
    page.paragraph("Each cell is one display; colour says how many times fewer samples are drawn.");
    for (name, chart) in [
        ("heatmap_few", heatmap(9, 6)),
        ("heatmap_many", heatmap(25, 20)),
    ] {
        out.add(format!("{name}.svg"), chart.svg());
        page.svg("Predicted from the plan's exact counts.", &chart.svg());
    }
    out.add("bars.svg", bars().svg());
    page.svg("", &bars().svg());
    page.heading("How late the picture is");
    let samples = latencies();
    page.row(|page| {
        let chart = histogram(&samples).svg();
        page.svg("One million runs with random phases.", &chart);
        out.add("histogram.svg", chart);
        let chart = waterfall().svg();
        page.svg("Each stage begins where the one before ended.", &chart);
        out.add("waterfall.svg", chart);
        Ok::<(), ReportError>(())
    })?;
    page.table("Stages of the pipeline", &table());
    out.add("gaze.svg", gaze_error().svg());
    page.svg(
        "Angle between where the eye is and the fovea that was drawn.",
        &gaze_error().svg(),
    );
    page.heading("What the viewer sees");
    let viewport = Viewport::symmetric(UVec2::new(640, 360), 0.432).map_err(|_| no_pixels())?;
    let gaze = DVec3::new(0.1, 0.05, -1.0).normalize();
    let (image, reference) = (scene(3.0), scene(0.0));
    let outlines = [
        Outline::eccentricity("layer 1 · 3.4°", &viewport, gaze, 3.36),
        Outline::eccentricity("layer 2 · 8.1°", &viewport, gaze, 8.12),
        Outline::rect(
            "edge of layer 2",
            Rect {
                min: DVec2::new(180.0, -20.0),
                max: DVec2::new(602.0, 340.0),
            },
        ),
    ];
    let map = error_map(&image, &reference, 32.0)?;
    out.add("annotated.svg", annotated("layers:3", &image, &outlines)?);
    out.add(
        "overlay.png",
        png(&side_by_side(
            &[&overlay(&image, &outlines), &reference, &map.image],
            8,
        ))?,
    );
    out.add("scale.svg", map.scale_svg());
    page.row(|page| {
        page.svg(
            "Drawn with layers:3; rings are the layers' edges.",
            &annotated("layers:3", &image, &outlines)?,
        );
        page.picture("Reference: every pixel.", &reference)?;
        page.picture(&map.caption(), &map.image)?;
        page.svg("", &map.scale_svg());
        Ok::<(), ReportError>(())
    })?;
    page.details("The scenario, as it was run", |page| {
        page.preformatted(
            "[display]\nname = \"lg-w2363d\"\n\n[method]\nname = \"layers:3\" # <script>",
        );
        page.list(["First assumption.", "Second assumption."]);
        page.note("Numbers with a star are unverified.");
        Ok::<(), ReportError>(())
    })?;
    out.add("trace.json", timeline().json());
    out.add("report.html", page.html());
    out.commit()?;
    Ok(())
}

fn no_pixels() -> ReportError {
    ReportError::Picture {
        width: 0,
        height: 0,
        why: "no viewport".into(),
    }
}

fn heatmap(columns: usize, rows: usize) -> Heatmap {
    let x: Vec<f64> = (0..columns)
        .map(|i| 10.0 + 120.0 * i as f64 / (columns - 1) as f64)
        .map(f64::round)
        .collect();
    let y: Vec<f64> = (0..rows)
        .map(|j| 1000.0 + 7000.0 * j as f64 / (rows - 1) as f64)
        .map(f64::round)
        .collect();
    let cell = |k: usize| {
        let (fov, width) = (x[k % columns], y[k / columns]);
        let value =
            (k != 5).then(|| 1.0 + math::pow(fov / 25.0, 1.6) * math::pow(width / 1500.0, 1.3));
        HeatCell {
            value,
            extrapolated: fov > 95.0,
        }
    };
    Heatmap {
        title: "How many times fewer samples layers:3 draws, by field of view and resolution"
            .into(),
        x_label: "horizontal field of view [deg]".into(),
        y_label: "width [px]".into(),
        value_label: "full / foveated".into(),
        cells: (0..columns * rows).map(cell).collect(),
        x,
        y,
        scale: ColourScale::Logarithmic,
        ends: None,
    }
}

fn latencies() -> [Vec<f64>; 3] {
    let mut random = Stream::new(1, foveasim_models::Role::Phase, 0);
    let mut draw = |low: f64| {
        (0..20_000)
            .map(|_| low + random.uniform() * 8.3 + random.uniform() * 13.0)
            .collect()
    };
    [draw(17.4), draw(18.97), draw(20.5)]
}

fn histogram(samples: &[Vec<f64>; 3]) -> Histogram {
    let labels = ["first row", "gaze row", "last inner row"];
    let series = labels.iter().zip(samples);
    Histogram {
        title: "Gaze-to-photon latency, LG W2363D with TX300, tearing".into(),
        x_label: "latency [ms]".into(),
        series: series
            .map(|(l, s)| HistogramSeries {
                label: (*l).into(),
                bins: bins(s),
                marks: [0.5, 0.95]
                    .map(|q| (format!("p{}", 100.0 * q), quantile(s, q)))
                    .into(),
            })
            .collect(),
        bounds: Some([16.1, 43.0]),
    }
}

/// Half-millisecond bins.
fn bins(samples: &[f64]) -> Vec<(f64, f64, f64)> {
    let bin = |k: usize| {
        let (from, to) = (16.0 + 0.5 * k as f64, 16.5 + 0.5 * k as f64);
        let inside = samples.iter().filter(|v| (from..to).contains(*v)).count();
        (from, to, inside as f64 / samples.len() as f64)
    };
    (0..54).map(bin).collect()
}

fn quantile(samples: &[f64], q: f64) -> f64 {
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    math::quantile_sorted(&sorted, q)
}

fn waterfall() -> Waterfall {
    let stage = |name: &str, best_ms, mean_ms, worst_ms| WaterfallStage {
        name: name.into(),
        best_ms,
        mean_ms,
        worst_ms,
        bounds_ms: Some([best_ms, worst_ms + 0.2]),
    };
    Waterfall {
        title: "Where the time goes, from the eye to the light".into(),
        stages: vec![
            stage("exposure", 1.0, 1.65, 3.3),
            stage("tracker processing", 1.0, 2.0, 3.0),
            stage("wait for frame", 0.0, 1.67, 3.33),
            stage("render", 8.33, 8.33, 8.33),
            stage("wait for flip", 0.0, 0.0, 0.0),
            stage("scan to row", 0.0, 4.2, 8.33),
            stage("pixel response", 2.0, 2.5, 5.0),
        ],
        total: Some(stage("gaze to photon", 18.97, 29.97, 40.77)),
    }
}

fn table() -> Table {
    let mut table = Table::new([
        "stage",
        "min_ms",
        "p5_ms",
        "p50_ms",
        "mean_ms",
        "p95_ms",
        "p99_ms",
        "max_ms",
        "bound_min_ms",
        "bound_max_ms",
    ]);
    for stage in waterfall().stages {
        let mut row = vec![stage.name.into()];
        row.extend([1.0, 1.1, 1.5, 1.6, 2.2, 2.3, 2.41, 0.9].map(|f| (f * stage.mean_ms).into()));
        row.push(foveasim_reports::Cell::Empty);
        table.push(row);
    }
    table
}

fn gaze_error() -> LineChart {
    let mut random = Stream::new(2, foveasim_models::Role::GazeNoise, 0);
    let mut since_saccade = 1.0;
    let mut size = 0.0;
    let mut points = Vec::new();
    let mut truth = Vec::new();
    let mut at = 0.0;
    for k in 0..36_000 {
        let t = f64::from(k) / 1200.0;
        since_saccade += 1.0 / 1200.0;
        if random.uniform() < 2.5 / 1200.0 {
            since_saccade = 0.0;
            size = 3.0 + 9.0 * random.uniform();
            at = 20.0 * random.uniform() - 10.0;
        }
        let lost = (8.0..9.2).contains(&t) || (21.0..21.15).contains(&t);
        let error = size * math::exp(-since_saccade / 0.03) + 0.4 + 0.1 * random.normal().abs();
        points.push([t, if lost { f64::NAN } else { error }]);
        truth.push([t, if lost { f64::NAN } else { at }]);
    }
    LineChart {
        title: "Gaze error over time, Tobii Spectrum recording".into(),
        x_label: "time [s]".into(),
        y_label: "angle [deg]".into(),
        series: vec![
            LineSeries {
                label: "drawn minus true gaze".into(),
                points,
            },
            LineSeries {
                label: "true azimuth".into(),
                points: truth,
            },
        ],
        shaded: vec![[8.0, 9.2], [21.0, 21.15]],
        shaded_label: "gaze missing".into(),
        levels: vec![(3.36, "edge of the inner layer".into())],
        ..LineChart::default()
    }
}

fn bars() -> BarChart {
    BarChart {
        title: "Samples per frame by method".into(),
        value_label: "samples per frame".into(),
        groups: ["full", "layers:3", "layers:4", "ideal floor"]
            .map(String::from)
            .into(),
        series: vec![
            BarSeries {
                label: "every layer each frame".into(),
                values: vec![
                    Some(2_073_600.0),
                    Some(244_000.0),
                    Some(215_500.0),
                    Some(75_810.0),
                ],
            },
            BarSeries {
                label: "staggered".into(),
                values: vec![None, Some(156_000.0), Some(127_613.0), Some(f64::NAN)],
            },
        ],
    }
}

/// A picture with fine detail, blurred outwards by averaging `blur` px.
fn scene(blur: f64) -> Image {
    let size = UVec2::new(640, 360);
    let mut image = Image::filled(size, [0.0; 3]);
    for y in 0..size.y {
        for x in 0..size.x {
            let (fx, fy) = (f64::from(x), f64::from(y));
            let away = math::hypot(fx - 400.0, fy - 160.0);
            let soft = 1.0 / (1.0 + blur * away / 150.0);
            let wave = math::sin(fx * fx / 600.0 + fy * 0.2) * soft * 0.5 + 0.5;
            let colour = [wave * 0.8, 0.2 + 0.5 * wave, 0.3 + fy / 900.0];
            image.rgb[(y * size.x + x) as usize] = colour.map(|v| v as f32);
        }
    }
    image
}

fn timeline() -> TraceEvents {
    let mut trace = TraceEvents::new();
    let pipeline = trace.process("pipeline");
    let [tracker, render, scan] =
        ["tracker", "render", "scan-out"].map(|n| trace.track(pipeline, n));
    for k in 0..40 {
        let t = Nanos(k * 8_333_333);
        trace.complete(
            tracker,
            "sample",
            t,
            Nanos(3_300_000),
            &[("azimuth_deg", 1.25.into())],
        );
        trace.complete(
            render,
            "frame",
            t + Nanos(4_000_000),
            Nanos(4_100_000),
            &[("frame", k.into())],
        );
        trace.complete(scan, "scan", t + Nanos(8_333_333), Nanos(8_000_000), &[]);
        trace.flow(
            "gaze",
            &[
                (tracker, t),
                (render, t + Nanos(4_500_000)),
                (scan, t + Nanos(9_000_000)),
            ],
        );
        trace.counter(pipeline, "gaze_error_deg", t, 0.5 + (k % 7) as f64 * 0.1);
    }
    trace
}
