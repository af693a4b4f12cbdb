use std::sync::Arc;

use foveasim_models::foveation::{Estimate, Method};
use foveasim_models::{Acuity, FrameWork, GazeMode};
use foveasim_reports::{Cell, ColourScale, HeatCell, Heatmap, Table};

use super::terms::full_work;
use super::{Fits, Needs, SweepDisplay, Terms};

/// One cell of a sweep. Counts are summed over the eyes; what describes layers is the first eye's
/// (the other's mirrors it).
#[derive(Debug, Clone, PartialEq)]
pub struct SweepRow {
    /// The display.
    pub display: SweepDisplay,
    /// The method.
    pub method: Method,
    /// The acuity line.
    pub acuity: Acuity,
    /// Where the eye looks, in pixels of the first eye's image.
    pub gaze_px: [f64; 2],
    /// Whether the sharpest part follows it.
    pub gaze_mode: GazeMode,
    /// The angle between the gaze and where the sharpest part is \[deg\].
    pub gaze_error_deg: f64,
    /// The margin designed for \[deg\], without the reach of a fixed method.
    pub margin_deg: f64,
    /// Pixels.
    pub display_samples: f64,
    /// Samples in closed form when every layer is drawn.
    pub method_samples: f64,
    /// Samples in closed form per frame on average, each layer at its own cadence.
    pub method_samples_staggered: f64,
    /// Evaluations of shading in closed form when every layer is drawn.
    pub method_shadings: f64,
    /// Evaluations of shading in closed form per frame on average, each layer at its own cadence.
    pub method_shadings_staggered: f64,
    /// Samples of the continuous falloff.
    pub ideal_samples: f64,
    /// What the plan draws; `None` for a display without whole pixels.
    pub drawn: Option<Drawn>,
    /// How many times more a fixed method of the same quality shades than the tracked one: fixed as
    /// this is, or with the default reach ([`Aim`](foveasim_models::foveation::Aim)). `None` for a method
    /// whose samples are given ([`Method::is_given`]).
    pub tracked_over_fixed: Option<f64>,
    /// Passes of all eyes, when every one is drawn.
    pub passes: f64,
    /// Passes of all eyes per frame on average, each at its own cadence.
    pub passes_staggered: f64,
    /// Whether the displayed image is put together from samples that are not its own pixels.
    pub reconstructed: bool,
    /// What time, memory and link cost.
    pub terms: Arc<Terms>,
    /// The first eye's layers, or passes.
    pub layers: Estimate,
    /// Whether the acuity line is used farther from its centre than where it was measured.
    pub extrapolated: bool,
}

/// What a map of savings shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapRatio {
    /// Display pixels over evaluations of shading, every layer drawn; for methods that shade each sample, over samples.
    Shading,
    /// Predicted time of a frame with a sample for each pixel over that of the method, each layer at its own rate.
    Time,
}

impl MapRatio {
    /// Its value in a cell.
    pub fn of(self, row: &SweepRow) -> f64 {
        match self {
            Self::Shading => row.shading_ratio(),
            Self::Time => row.needs().speedup(),
        }
    }

    fn label(self) -> &'static str {
        match self {
            Self::Shading => "display pixels per shaded sample",
            Self::Time => "times as fast as full resolution",
        }
    }
}

/// What plans draw, in whole numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Drawn {
    /// Samples.
    pub samples: u64,
    /// Evaluations of shading, if no sample shows two triangles.
    pub shadings: u64,
}

impl SweepRow {
    /// Pixels per sample when every layer is drawn.
    pub fn sample_ratio(&self) -> f64 {
        self.display_samples / self.method_samples
    }

    /// Pixels per sample drawn, each layer at its own cadence.
    pub fn sample_ratio_staggered(&self) -> f64 {
        self.display_samples / self.method_samples_staggered
    }

    /// Pixels per evaluation of shading when every layer is drawn.
    pub fn shading_ratio(&self) -> f64 {
        self.display_samples / self.method_shadings
    }

    /// Pixels per evaluation of shading, each layer at its own cadence.
    pub fn shading_ratio_staggered(&self) -> f64 {
        self.display_samples / self.method_shadings_staggered
    }

    /// Pixels per sample of the continuous falloff.
    pub fn ideal_ratio(&self) -> f64 {
        self.display_samples / self.ideal_samples
    }

    /// How many times more evaluations of shading the method needs than the continuous falloff has
    /// samples.
    pub fn over_ideal(&self) -> f64 {
        self.method_shadings / self.ideal_samples
    }

    fn resolved(&self) -> f64 {
        match self.reconstructed {
            true => self.display_samples,
            false => 0.0,
        }
    }

    /// Work of a frame on average, each pass at its own cadence.
    pub fn work_staggered(&self) -> FrameWork {
        FrameWork {
            samples_shaded: self.method_shadings_staggered,
            samples: self.method_samples_staggered,
            pixels_resolved: self.resolved(),
            passes: self.passes_staggered,
        }
    }

    /// Work of a frame in which every pass is drawn.
    pub fn work(&self) -> FrameWork {
        FrameWork {
            samples_shaded: self.method_shadings,
            samples: self.method_samples,
            pixels_resolved: self.resolved(),
            passes: self.passes,
        }
    }

    /// What that needs of time, memory and link.
    pub fn needs(&self) -> Needs {
        let Terms {
            cost,
            buffers,
            link,
        } = &*self.terms;
        let ms = |work: &FrameWork| cost.time_ns(work) / 1e6;
        let full = full_work(self.display_samples, self.display.eyes.len());
        let works = [self.work_staggered(), self.work()];
        let gigabits = |samples| Some(link.gigabits(samples, self.display.refresh?));
        let energy = |work: &FrameWork| {
            let sent = link.frame_gigabits(work.samples);
            Some(cost.energy?.frame_mj(work, sent))
        };
        let [energy_mj, full_energy_mj] = [energy(&works[0]), energy(&full)];
        let power = |mj: Option<f64>| Some(mj? * 1e-3 * self.display.refresh?.hz());
        Needs {
            frame_ms: ms(&works[0]),
            frame_all_ms: ms(&works[1]),
            full_ms: ms(&full),
            beyond_fit: works.iter().find_map(|w| cost.extrapolates(w)),
            framebuffer_mb: buffers.megabytes(self.method_samples, self.resolved()),
            link_gbps: gigabits(self.method_samples_staggered),
            full_link_gbps: gigabits(self.display_samples),
            energy_mj,
            full_energy_mj,
            power_w: power(energy_mj),
            full_power_w: power(full_energy_mj),
        }
    }

    /// Rows as a table; see the column names of [`COLUMNS`].
    pub fn table(rows: &[Self]) -> Table {
        let mut table = Table::new(COLUMNS);
        rows.iter().for_each(|row| table.push(row.cells()));
        table
    }

    /// A ratio over field of view and another quantity (its name and values): `rows` is the map row
    /// by row from the first value of that, every field of view in each. Extrapolated cells are hatched.
    ///
    /// # Panics
    /// If there is not one row per cell.
    pub fn heatmap<'a>(
        rows: impl IntoIterator<Item = &'a Self>,
        ratio: MapRatio,
        title: String,
        fov_deg: Vec<f64>,
        (y_label, y): (&str, Vec<f64>),
    ) -> Heatmap {
        let cell = |row: &Self| HeatCell {
            value: Some(ratio.of(row)),
            extrapolated: row.extrapolated,
        };
        let cells: Vec<HeatCell> = rows.into_iter().map(cell).collect();
        assert_eq!(cells.len(), fov_deg.len() * y.len(), "one row per cell");
        Heatmap {
            title,
            x_label: "horizontal field of view [deg]".into(),
            x: fov_deg,
            y_label: y_label.into(),
            y,
            value_label: ratio.label().into(),
            cells,
            scale: ColourScale::Logarithmic,
            ends: None,
        }
    }

    fn cells(&self) -> Vec<Cell> {
        let screen = &self.display.eyes[0].screen;
        let size = screen.size_px();
        let (coverage, blending) = match self.method {
            Method::Layers(s) => (Some(s.coverage.name()), Some(s.blending.name())),
            _ => (None, None),
        };
        let passes = &self.layers.passes;
        let rates = self.display.refresh.map(|r| {
            list(
                passes
                    .iter()
                    .map(|p| (r.hz() / f64::from(p.every)).to_string()),
            )
        });
        let needs = self.needs();
        let refresh = self.display.refresh;
        let fits = refresh.map(|r| Fits::of(needs.frame_ms, needs.frame_all_ms, r));
        vec![
            self.method.to_string().into(),
            self.display.fov_h_deg.into(),
            pixels(self, size.x, |v| v.x),
            pixels(self, size.y, |v| v.y),
            whole_or(self, self.display_samples),
            self.method_samples.into(),
            self.sample_ratio().into(),
            self.sample_ratio_staggered().into(),
            self.ideal_ratio().into(),
            self.display.name.as_str().into(),
            self.display.eyes.len().into(),
            (1.0 / foveasim_models::math::to_deg(screen.pixel_tan().x)).into(),
            (size.x / screen.fov_deg().x).into(),
            (self.acuity.omega_0_deg() / screen.sharpness_deg()).into(),
            self.acuity.slope().into(),
            self.margin_deg.into(),
            self.gaze_mode.to_string().into(),
            self.gaze_px[0].into(),
            self.gaze_px[1].into(),
            self.gaze_error_deg.into(),
            yes(self.gaze_error_deg <= self.method.aim().margin_deg(self.margin_deg)),
            coverage.into(),
            blending.into(),
            self.ideal_samples.into(),
            self.over_ideal().into(),
            self.drawn.map(|d| d.samples).into(),
            list(passes.iter().filter_map(|p| p.radius_deg).map(rounded)).into(),
            list(passes.iter().map(|p| scale(p.scale))).into(),
            list(passes.iter().map(|p| format!("1/{}", p.every))).into(),
            rates.into(),
            yes(self.extrapolated),
            self.method_shadings.into(),
            self.shading_ratio().into(),
            self.drawn.map(|d| d.shadings).into(),
            self.tracked_over_fixed.into(),
            refresh.map(|r| r.hz()).into(),
            self.terms.cost.name.as_str().into(),
            needs.frame_ms.into(),
            needs.frame_all_ms.into(),
            needs.full_ms.into(),
            needs.speedup().into(),
            fits.map(Fits::name).into(),
            needs.beyond_fit.into(),
            needs.framebuffer_mb.into(),
            needs.link_gbps.into(),
            needs.full_link_gbps.into(),
            needs.energy_mj.into(),
            needs.full_energy_mj.into(),
            needs.power_w.into(),
            needs.full_power_w.into(),
        ]
    }
}

/// Columns of [`SweepRow::table`]; the first nine are what scripts rely on.
///
/// `width_px` and `height_px` are one eye's; `method_samples` is the closed form (Guenter 2012, Eqs
/// 2–8), `plan_samples` the whole number that is drawn; `gaze_within_margin` says whether the eye is
/// still where the design holds; `extrapolated` whether the screen reaches farther from where the
/// sharpest part is than acuity slopes were measured ([`Acuity::MEASURED_TO_DEG`]). Samples are places
/// where visibility is found, shadings evaluations of shading: fewer under variable-rate shading, else
/// as many. `over_ideal` compares shadings. `tracked_over_fixed` is how many times more a fixed method
/// shades for the same quality; it is empty for `kfr`, `efr`, `lms` and `radial`, whose settings say where samples
/// lie, and which may need fewer than the ideal because they promise no quality. From `refresh_hz` on:
/// what the sweep's [`Terms`] make of it. `frame_ms` has each pass at its own cadence, `frame_all_ms` every
/// pass; `beyond_fit` names the work that the cost profile does not rest on; framebuffers are of all passes
/// and of the image put together from them, and the link carries samples as they are drawn. Energy and power are of
/// frames as `frame_ms` has them, and empty where the cost profile states none.
pub const COLUMNS: [&str; 50] = [
    "method",
    "fov_h_deg",
    "width_px",
    "height_px",
    "display_samples",
    "method_samples",
    "sample_ratio",
    "sample_ratio_staggered",
    "ideal_ratio",
    "display",
    "eyes",
    "ppd_centre",
    "ppd_mean",
    "sharpness",
    "slope",
    "margin_deg",
    "gaze_mode",
    "gaze_x_px",
    "gaze_y_px",
    "gaze_error_deg",
    "gaze_within_margin",
    "coverage",
    "blending",
    "ideal_samples",
    "over_ideal",
    "plan_samples",
    "layer_radii_deg",
    "layer_scales",
    "layer_drawn",
    "layer_rates_hz",
    "extrapolated",
    "method_shadings",
    "shading_ratio",
    "plan_shadings",
    "tracked_over_fixed",
    "refresh_hz",
    "cost_profile",
    "frame_ms",
    "frame_all_ms",
    "full_frame_ms",
    "predicted_speedup",
    "fits_refresh",
    "beyond_fit",
    "framebuffer_mb",
    "link_gbps",
    "full_link_gbps",
    "energy_mj",
    "full_energy_mj",
    "power_w",
    "full_power_w",
];

/// Columns of [`SweepRow::table`] that hold text.
pub const TEXT_COLUMNS: [&str; 14] = [
    "method",
    "display",
    "gaze_mode",
    "gaze_within_margin",
    "coverage",
    "blending",
    "layer_radii_deg",
    "layer_scales",
    "layer_drawn",
    "layer_rates_hz",
    "extrapolated",
    "cost_profile",
    "fits_refresh",
    "beyond_fit",
];

/// Columns of [`SweepRow::table`] that hold whole numbers in every row. What is neither here nor among
/// [`TEXT_COLUMNS`] is a number, whole or not.
pub const WHOLE_COLUMNS: [&str; 3] = ["eyes", "plan_samples", "plan_shadings"];

fn yes(is: bool) -> Cell {
    if is { "yes" } else { "no" }.into()
}

/// Values within one cell.
fn list(values: impl Iterator<Item = String>) -> String {
    values.collect::<Vec<_>>().join(" ")
}

/// Pixels per sample: one number where both axes are alike.
fn scale(scale: glam::DVec2) -> String {
    if scale.x == scale.y {
        rounded(scale.x)
    } else {
        format!("{}x{}", rounded(scale.x), rounded(scale.y))
    }
}

fn rounded(value: f64) -> String {
    format!("{value:.4}")
}

/// A pixel count: whole where the display has whole pixels.
fn pixels(row: &SweepRow, fraction: f64, axis: fn(glam::UVec2) -> u32) -> Cell {
    match row.display.eyes[0].viewport {
        Some(viewport) => axis(viewport.size).into(),
        None => fraction.into(),
    }
}

/// A count that is whole where the display has whole pixels.
fn whole_or(row: &SweepRow, count: f64) -> Cell {
    match row.display.eyes[0].viewport {
        Some(_) => (count.round() as u64).into(),
        None => count.into(),
    }
}
