use std::time::Duration;

use foveasim_reports::{LineChart, LineSeries, Page, Table};

use super::{KernelErrorRow, KernelErrors, KernelTimes, KernelTimings};
use crate::reproduce::ReproduceError;

/// Times and errors of kernels together: the measured half of a reproduction of Meng 2020.
#[derive(Debug, Clone, PartialEq)]
pub struct KernelMeasured {
    /// Frames and shading, of both forms and of eye dominance.
    pub timings: KernelTimings,
    /// Error by ring.
    pub errors: Vec<KernelErrorRow>,
}

/// Share of the progress that times take.
const TIMES: f64 = 0.6;

impl KernelMeasured {
    /// Measures both; `clock` and `progress` as for [`KernelTimes::run`].
    ///
    /// # Errors
    /// As [`KernelTimes::run`] and [`KernelErrors::run`].
    pub fn run(
        times: &KernelTimes,
        errors: &KernelErrors,
        clock: &mut dyn FnMut() -> Duration,
        progress: &dyn Fn(&str, f64),
    ) -> Result<Self, ReproduceError> {
        let timings = times.run(clock, &|what, done| progress(what, TIMES * done))?;
        let rest = |what: &str, done: f64| progress(what, TIMES + (1.0 - TIMES) * done);
        let errors = errors.run(&rest)?;
        Ok(Self { timings, errors })
    }

    /// How much faster eye dominance, σ = (2, 3), is than σ = 2 for both eyes: in shading, and for a whole frame;
    /// in one form. The equation has 1.3846 for the part that goes with samples.
    pub fn dominance_gain(&self, published: bool) -> Option<[f64; 2]> {
        let form = if published { ":published" } else { "" };
        let row = |method: &str| self.timings.row(&format!("{method}{form}"));
        let (one, two) = (row("kfr:2:4")?, row("efr:2:3")?);
        Some([
            two.shading_speedup / one.shading_speedup,
            two.speedup / one.speedup,
        ])
    }

    /// Every table by the name of its file.
    pub(crate) fn tables(&self) -> [(&'static str, Table); 2] {
        [
            ("times.csv", self.timings.table()),
            ("errors.csv", KernelErrors::table(&self.errors)),
        ]
    }

    /// Every chart, as SVG, by the name of its file.
    pub(crate) fn charts(&self) -> [(&'static str, String); 2] {
        [
            ("times.svg", self.speedup_chart().svg()),
            ("errors.svg", KernelErrors::chart(&self.errors).svg()),
        ]
    }

    /// Adds what was measured to a page.
    pub(crate) fn add_to(&self, page: &mut Page) {
        page.heading("Measured: time");
        let [frame, shading] = self.timings.noise.map(|n| 100.0 * n);
        page.paragraph(&format!(
            "The study scene for two eyes, drawn on this machine. Shading is what a frame takes beyond one whose \
             materials are all of one colour; the rest (visibility, detail, the inverse map) is fixed. All \
             speedups are medians of paired rounds. Two equal draws differed by up to {frame:.1} % of a frame \
             and {shading:.1} % of its shading in 9 of 10 rounds: less than that says nothing.",
        ));
        page.table("Times, both eyes", &self.timings.table());
        page.svg("", &self.speedup_chart().svg());
        for (published, form) in [(false, "direct"), (true, "published")] {
            if let Some([shading, frame]) = self.dominance_gain(published) {
                page.paragraph(&format!(
                    "Eye dominance (2, 3) over σ = 2 for both eyes, {form} form: {shading:.3} in shading, \
                     {frame:.3} in the frame; Eq. 9 has 1.385.",
                ));
            }
        }
        page.heading("Measured: error");
        page.paragraph(
            "The left eye against many samples to the pixel, by ring of eccentricity. All methods shade as often \
             as three layers do, but full resolution and variable-rate shading, which shades as its acuity \
             line asks.",
        );
        page.table("Error by ring", &KernelErrors::table(&self.errors));
        page.svg("", &KernelErrors::chart(&self.errors).svg());
    }

    /// Speedups over full resolution by σ: shading and frames of both forms, with σ² beside them.
    fn speedup_chart(&self) -> LineChart {
        let kernels = |form: &str| {
            let of_form = self.timings.rows.iter().filter(|r| {
                let name = r.method.to_string();
                name.starts_with("kfr:") && name.ends_with(":published") == (form == "published")
            });
            of_form.collect::<Vec<_>>()
        };
        let line = |label: &str, form: &str, of: fn(&super::KernelTimeRow) -> f64| {
            let point = |r: &&super::KernelTimeRow| [r.buffer_ratio.sqrt(), of(r)];
            LineSeries {
                label: label.into(),
                points: kernels(form).iter().map(point).collect(),
            }
        };
        LineChart {
            title: "Speedup of kernel foveated rendering over full resolution, α = 4".into(),
            x_label: "σ".into(),
            y_label: "times as fast".into(),
            series: vec![
                line("σ²", "", |r| r.buffer_ratio),
                line("shading, direct", "", |r| r.shading_speedup),
                line("shading, published", "published", |r| r.shading_speedup),
                line("frame, direct", "", |r| r.speedup),
                line("frame, published", "published", |r| r.speedup),
            ],
            ..LineChart::default()
        }
    }
}
