//! The page needs nothing but itself, and what is written into it stays text.

use foveasim_models::Image;
use foveasim_reports::{
    BarChart, Cell, ColourScale, HeatCell, Heatmap, Histogram, HistogramSeries, LineChart,
    LineSeries, Outline, Page, ReportError, Table, Waterfall, WaterfallStage, annotated,
};
use glam::{DVec2, UVec2};

const EVIL: &str = "<script src=\"https://x.example/a.js\">alert('1')</script> \u{1}& co";

fn charts() -> Vec<String> {
    let heatmap = |value: Option<f64>, scale| Heatmap {
        title: EVIL.into(),
        x_label: EVIL.into(),
        x: vec![10.0, 20.0],
        y_label: "width [px]".into(),
        y: vec![1920.0],
        value_label: EVIL.into(),
        cells: vec![
            HeatCell {
                value,
                extrapolated: true,
            },
            HeatCell {
                value: Some(f64::NAN),
                extrapolated: false,
            },
        ],
        scale,
        ends: None,
    };
    let stage = |ms: f64| WaterfallStage {
        name: EVIL.into(),
        best_ms: ms,
        mean_ms: ms,
        worst_ms: ms,
        bounds_ms: Some([0.0, ms]),
    };
    let line = |points: Vec<[f64; 2]>| LineChart {
        title: EVIL.into(),
        series: vec![LineSeries {
            label: EVIL.into(),
            points,
        }],
        shaded: vec![[0.0, 1.0], [f64::NAN, 2.0], [3.0, 2.0]],
        shaded_label: EVIL.into(),
        levels: vec![(1.0, EVIL.into()), (f64::INFINITY, "never".into())],
        ..LineChart::default()
    };
    let histogram = |bins: &[(f64, f64, f64)]| {
        Histogram {
            title: EVIL.into(),
            x_label: "latency [ms]".into(),
            series: vec![HistogramSeries {
                label: EVIL.into(),
                bins: bins.to_vec(),
                marks: vec![(EVIL.into(), 1.5), ("never".into(), f64::NAN)],
            }],
            bounds: Some([f64::NAN, 1.0]),
        }
        .svg()
    };
    let bars = |groups: Vec<String>| BarChart {
        title: EVIL.into(),
        value_label: EVIL.into(),
        series: vec![foveasim_reports::BarSeries {
            label: EVIL.into(),
            values: vec![Some(-1.5); groups.len()],
        }],
        groups,
    };
    let image = Image::filled(UVec2::new(32, 16), [0.5; 3]);
    let outline = Outline::ellipse(EVIL, DVec2::new(16.0, 8.0), DVec2::new(9.0, 5.0));
    vec![
        heatmap(Some(3.5), ColourScale::Linear).svg(),
        heatmap(Some(-1.0), ColourScale::Logarithmic).svg(),
        heatmap(None, ColourScale::Linear).svg(),
        heatmap(Some(1e-300), ColourScale::Logarithmic).svg(),
        heatmap(Some(1e99), ColourScale::Linear).svg(),
        Waterfall {
            title: EVIL.into(),
            stages: vec![stage(1.0), stage(0.0)],
            total: Some(stage(1.0)),
        }
        .svg(),
        Waterfall {
            title: EVIL.into(),
            stages: vec![stage(-2.0), stage(1e99), stage(1e300)],
            total: None,
        }
        .svg(),
        Waterfall {
            title: EVIL.into(),
            stages: vec![stage(-2.0), stage(1e99)],
            total: Some(stage(f64::MIN_POSITIVE)),
        }
        .svg(),
        Waterfall {
            title: EVIL.into(),
            stages: vec![stage(f64::NAN)],
            total: None,
        }
        .svg(),
        Waterfall {
            title: String::new(),
            stages: vec![],
            total: None,
        }
        .svg(),
        line(vec![[0.0, 1.0], [1.0, f64::NAN], [2.0, 5.0]]).svg(),
        line(vec![[1.0, 1.0]]).svg(),
        line(vec![[-1e99, -1e99], [1e99, 1e99], [1e300, f64::MAX]]).svg(),
        line(vec![[1e-300, 0.0], [2e-300, -0.0]]).svg(),
        line(vec![]).svg(),
        histogram(&[(1.0, 2.0, 0.5), (2.0, 3.0, f64::NAN), (3.0, 4.0, 0.5)]),
        histogram(&[(3.0, 3.0 + 1e-9, 1.0)]),
        histogram(&[(4.0, 3.0, 1.0), (f64::NAN, 3.0, 1.0)]),
        histogram(&[]),
        bars(vec![EVIL.into(), "b".into()]).svg(),
        bars(vec![]).svg(),
        annotated(EVIL, &image, &[outline]).unwrap(),
    ]
}

fn full_page() -> Page {
    let mut table = Table::new([EVIL, "mean_ms"]);
    table.push(vec![EVIL.into(), f64::INFINITY.into()]);
    table.push(vec!["b".into(), Cell::Empty]);
    let mut page = Page::new(EVIL);
    for k in 0..3 {
        page.heading(&format!("{k} {EVIL}"));
    }
    page.subheading(EVIL);
    page.paragraph(EVIL);
    page.note(EVIL);
    page.list([EVIL, "b"]);
    page.preformatted(EVIL);
    page.key_numbers(&[(EVIL, EVIL)]);
    page.table(EVIL, &table);
    page.row(|page| {
        for chart in charts() {
            page.svg(EVIL, &chart);
        }
        page.picture(EVIL, &Image::filled(UVec2::new(3, 2), [0.5; 3]))
    })
    .unwrap();
    page.details(EVIL, |page| {
        page.paragraph(EVIL);
        Ok::<(), ReportError>(())
    })
    .unwrap();
    page
}

#[test]
fn letters_stay_letters_and_suit_dark_surroundings() {
    for chart in charts() {
        assert!(
            chart.contains("<text ") || chart.contains("<image "),
            "{chart}"
        );
        assert!(chart.contains("prefers-color-scheme:dark"));
        // Nothing is painted behind the drawing: the page shows through.
        assert!(!chart.contains("<rect x=\"0\" y=\"0\" width=\"2240\""));
    }
}

/// Checks that tags are balanced and nothing but tags begins with `<`; returns all tags.
fn tags(text: &str) -> Vec<&str> {
    let (mut open, mut all) = (Vec::new(), Vec::new());
    let mut rest = text;
    while let Some(start) = rest.find('<') {
        rest = &rest[start..];
        let end = rest.find('>').expect("every tag ends");
        let tag = &rest[1..end];
        all.push(tag);
        rest = &rest[end + 1..];
        let name = tag
            .trim_start_matches('/')
            .split([' ', '/'])
            .next()
            .unwrap_or_default();
        assert!(
            name.chars().all(|c| c.is_ascii_alphanumeric() || c == '!'),
            "<{tag}>"
        );
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "closed by </{name}>");
        } else if !tag.ends_with('/') && !["!DOCTYPE", "meta", "img", "wbr"].contains(&name) {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "left open: {open:?}");
    all
}

#[test]
fn needs_no_network_and_no_script() {
    let html = full_page().html();
    for tag in tags(&html) {
        let name = tag.split(' ').next().unwrap();
        assert!(
            ![
                "script", "link", "iframe", "object", "embed", "base", "form"
            ]
            .contains(&name),
            "{tag}"
        );
        for attribute in ["src=\"", "href=\""] {
            if let Some((_, value)) = tag.split_once(attribute) {
                assert!(
                    value.starts_with("data:image/png;base64,") || value.starts_with("#section-"),
                    "{tag}"
                );
            }
        }
    }
    // A name too long for its chart may be cut anywhere after this.
    let elsewhere = html
        .replace("xmlns=\"http://www.w3.org/2000/svg\"", "")
        .replace("https://x", "");
    assert!(!elsewhere.contains("http:") && !elsewhere.contains("https:"));
    assert!(!html.contains("url(") && !html.contains("@import"));
    assert!(!html.contains("<script"), "text stays text");
}

#[test]
fn every_chart_is_well_formed_whatever_it_is_given() {
    for (k, chart) in charts().iter().enumerate() {
        assert!(tags(chart)[0].starts_with("svg xmlns="), "chart {k}");
        assert!(
            !chart.contains("NaN") && !chart.contains("inf\"") && !chart.contains('\u{1}'),
            "chart {k}:\n{chart}"
        );
    }
}

#[test]
fn same_input_same_bytes() {
    assert_eq!(full_page().html(), full_page().html());
}

#[test]
fn is_made_for_phones_and_both_colour_schemes() {
    let html = full_page().html();
    for needed in [
        "name=\"viewport\"",
        "prefers-color-scheme:dark",
        "overflow-x:auto",
        "max-width:100%",
        "lang=\"en\"",
    ] {
        assert!(html.contains(needed), "{needed}");
    }
}

#[test]
fn missing_and_infinite_cells_are_shown() {
    let html = full_page().html();
    assert!(html.contains("<td class=\"n\">inf</td>") && html.contains("<td class=\"n\"></td>"));
}
