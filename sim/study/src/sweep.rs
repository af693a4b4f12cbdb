//! Savings across displays, methods, acuity, gaze and tracking margins.

mod display;
mod row;

pub use display::{DensityAt, Resolution, SweepDisplay, SweepEye};
pub use row::{COLUMNS as SWEEP_COLUMNS, SweepRow};

use foveasim_models::foveation::{Estimate, FloorDensity, Method, Request, ideal_samples};
use foveasim_models::{Acuity, GazeDirection, GazeMode, ModelError};
use glam::DVec2;
use rayon::prelude::*;

/// Every combination of the lists is one row, in the order displays, slopes, gazes, margins, methods
/// (the last changes fastest), for any number of threads.
///
/// Head-mounted displays are planned eye by eye: an image plane may lie unevenly about its eye's
/// axis and have oblong pixels; radii are optimised for gaze along the axis, ω* is the larger pixel's
/// there, and samples are summed over the eyes. The hidden area is left out of the display's pixels and
/// of the layer that fills the eye buffer; the floor keeps it, and so is a little high there.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// Displays.
    pub displays: Vec<SweepDisplay>,
    /// Acuity lines.
    pub acuities: Vec<Acuity>,
    /// Where the eyes look.
    pub gazes: Vec<GazeAt>,
    /// Whether layers follow the gaze. If fixed they stay on the axis, and so does the floor they are
    /// compared with.
    pub gaze_mode: GazeMode,
    /// How far gaze may be off without the viewer noticing \[deg\].
    pub margins_deg: Vec<f64>,
    /// Methods.
    pub methods: Vec<Method>,
}

/// Where the eyes look.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum GazeAt {
    /// Straight ahead of the head: the centre of a planar display.
    #[default]
    Centre,
    /// Through this pixel position of the first eye's image; the other looks in the same direction.
    Pixel([f64; 2]),
}

impl Sweep {
    /// How many rows.
    pub fn len(&self) -> usize {
        let lists = [
            self.displays.len(),
            self.acuities.len(),
            self.gazes.len(),
            self.margins_deg.len(),
            self.methods.len(),
        ];
        lists.into_iter().fold(1, usize::saturating_mul)
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All rows; calls `on_rows` from any thread with how many were just made.
    ///
    /// # Errors
    /// The first error in row order: a margin that is not from 0 to 90 degrees, or a gaze that is not
    /// finite.
    pub fn run(&self, on_rows: impl Fn(u64) + Sync) -> Result<Vec<SweepRow>, ModelError> {
        let mut situations = Vec::new();
        for display in &self.displays {
            for &acuity in &self.acuities {
                for &gaze in &self.gazes {
                    for &margin_deg in &self.margins_deg {
                        situations.push(Situation {
                            display,
                            acuity,
                            gaze,
                            margin_deg,
                        });
                    }
                }
            }
        }
        let rows: Vec<Result<Vec<SweepRow>, ModelError>> = situations
            .par_iter()
            .map(|s| {
                let rows = s.rows(&self.methods, self.gaze_mode);
                on_rows(self.methods.len() as u64);
                rows
            })
            .collect();
        let mut all = Vec::with_capacity(self.len());
        for some in rows {
            all.extend(some?);
        }
        Ok(all)
    }
}

/// What rows of different methods share.
struct Situation<'a> {
    display: &'a SweepDisplay,
    acuity: Acuity,
    gaze: GazeAt,
    margin_deg: f64,
}

impl Situation<'_> {
    fn rows(&self, methods: &[Method], mode: GazeMode) -> Result<Vec<SweepRow>, ModelError> {
        let mut ideal = 0.0;
        for eye in &self.display.eyes {
            let drawn = self.drawn_gaze(eye, mode);
            let density = FloorDensity::PerSolidAngle;
            ideal += ideal_samples(&eye.screen, self.acuity, drawn, self.margin_deg, density)?;
        }
        methods
            .iter()
            .map(|&method| self.row(method, mode, ideal))
            .collect()
    }

    fn row(&self, method: Method, mode: GazeMode, ideal: f64) -> Result<SweepRow, ModelError> {
        let mut estimates = Vec::with_capacity(self.display.eyes.len());
        let mut plan_samples = Some(0);
        for eye in &self.display.eyes {
            let gaze = self.drawn_gaze(eye, mode);
            let estimate = method.estimate(&eye.screen, self.acuity, gaze, self.margin_deg)?;
            estimates.push(without_hidden_area(estimate, eye.hidden_area_fraction));
            plan_samples = match (plan_samples, eye.viewport) {
                (Some(sum), Some(viewport)) => {
                    let (eye, acuity, margin_deg) = (eye.eye, self.acuity, self.margin_deg);
                    let request = Request {
                        eye,
                        viewport,
                        acuity,
                        gaze,
                        margin_deg,
                    };
                    Some(sum + method.plan(&request)?.count().samples())
                }
                _ => None,
            };
        }
        let total = |f: fn(&Estimate) -> f64| estimates.iter().map(f).sum();
        let first = &self.display.eyes[0];
        let (true_gaze, drawn) = (self.true_gaze(first), self.drawn_gaze(first, mode));
        let reach = |e: &SweepEye| e.screen.reach_from_deg(self.drawn_gaze(e, mode));
        let farthest = self.display.eyes.iter().map(reach);
        Ok(SweepRow {
            display: self.display.clone(),
            method,
            acuity: self.acuity,
            gaze_px: self.gaze_px(first).into(),
            gaze_mode: mode,
            gaze_error_deg: match mode {
                GazeMode::Tracked => 0.0,
                GazeMode::Fixed => true_gaze.angle_to_deg(drawn),
            },
            margin_deg: self.margin_deg,
            display_samples: total(|e| e.display_pixels),
            method_samples: total(Estimate::samples),
            method_samples_staggered: total(Estimate::samples_staggered),
            ideal_samples: ideal,
            plan_samples,
            extrapolated: farthest.fold(0.0, f64::max) > MEASURED_TO_DEG,
            layers: estimates.swap_remove(0),
        })
    }

    /// Where `eye` looks, in its own frame.
    fn true_gaze(&self, eye: &SweepEye) -> GazeDirection {
        match self.gaze {
            GazeAt::Centre => eye.ahead(),
            GazeAt::Pixel(px) => {
                let first = &self.display.eyes[0];
                let in_head = first
                    .head_from_eye
                    .direction(first.screen.direction(px.into()));
                GazeDirection::from_vector(eye.head_from_eye.inverse().direction(in_head))
            }
        }
    }

    /// Where the layers are centred, in the eye's own frame.
    fn drawn_gaze(&self, eye: &SweepEye, mode: GazeMode) -> GazeDirection {
        match mode {
            GazeMode::Tracked => self.true_gaze(eye),
            GazeMode::Fixed => eye.ahead(),
        }
    }

    fn gaze_px(&self, eye: &SweepEye) -> DVec2 {
        match self.gaze {
            GazeAt::Centre => eye
                .screen
                .project(eye.ahead().vector())
                .unwrap_or(DVec2::NAN),
            GazeAt::Pixel(px) => px.into(),
        }
    }
}

/// Leaves the hidden area out of the display and of the layer that fills it, the outermost.
fn without_hidden_area(mut estimate: Estimate, fraction: f64) -> Estimate {
    estimate.display_pixels *= 1.0 - fraction;
    if let Some(outermost) = estimate.passes.last_mut() {
        outermost.samples *= 1.0 - fraction;
    }
    estimate
}

/// [`Acuity::MEASURED_TO_DEG`] is the study display's half-width rounded to a hundredth; the display
/// itself is not an extrapolation.
const MEASURED_TO_DEG: f64 = Acuity::MEASURED_TO_DEG + 0.005;

#[cfg(test)]
mod tests {
    use foveasim_models::presets;
    use foveasim_reports::Cell;

    use super::*;

    fn sweep(displays: Vec<SweepDisplay>, methods: &str) -> Sweep {
        Sweep {
            displays,
            acuities: vec![Acuity::default()],
            gazes: vec![GazeAt::Centre],
            gaze_mode: GazeMode::Tracked,
            margins_deg: vec![0.0],
            methods: Method::parse_list(methods).unwrap(),
        }
    }

    #[test]
    fn the_study_display() {
        let lg = SweepDisplay::from(&presets::display("lg-w2363d").unwrap());
        let rows = sweep(vec![lg], "full,layers:3").run(|_| ()).unwrap();
        assert_eq!(rows[0].sample_ratio(), 1.0);
        assert_eq!(rows[0].plan_samples, Some(1920 * 1080));
        // oracle s1 mA_0.0275_n3
        assert!((rows[1].sample_ratio() - 8.497_841_827).abs() < 1e-6);
        assert!((rows[1].sample_ratio_staggered() - 13.292_452).abs() < 1e-4);
        let plan = rows[1].plan_samples.unwrap() as f64;
        assert!(plan > rows[1].method_samples && plan < 1.01 * rows[1].method_samples);
        assert!(rows[1].over_ideal() > 1.0 && !rows[1].extrapolated);
    }

    #[test]
    fn order_does_not_depend_on_threads() {
        let fovs = [30.0, 50.0, 70.0];
        let displays = fovs
            .iter()
            .map(|f| Resolution::Sharpness(0.5).display(*f, 0.75).unwrap())
            .collect();
        let mut many = sweep(displays, "full,layers:2,layers:3");
        many.margins_deg = vec![0.0, 2.0];
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            SweepRow::table(&pool.install(|| many.run(|_| ())).unwrap())
        };
        let one = run(1);
        assert_eq!(one.rows().len(), many.len());
        assert_eq!(one.digest(), run(7).digest());
        assert_eq!(one.rows()[0][1], Cell::Float(30.0));
        assert_eq!(one.rows()[2][0], Cell::Text("layers:3".into()));
    }

    #[test]
    fn head_mounted_displays_sum_over_eyes() {
        let quest = presets::display("quest-pro").unwrap();
        let rows = sweep(vec![SweepDisplay::from(&quest)], "full,layers:3")
            .run(|_| ())
            .unwrap();
        assert_eq!(rows[0].method_samples.round(), quest.render_pixels() as f64);
        assert!(rows[1].sample_ratio() > 2.0 && rows[1].over_ideal() > 1.0 && rows[1].extrapolated);
        let plan = rows[1].plan_samples.unwrap() as f64;
        assert!((plan / rows[1].method_samples - 1.0).abs() < 0.03);
        // Mirrored images need the same samples.
        let one = &rows[1].layers;
        assert!((rows[1].method_samples / one.samples() - 2.0).abs() < 1e-12);
    }

    #[test]
    fn the_hidden_area_is_not_counted() {
        let mut spec = presets::display_spec("quest-pro").unwrap();
        let rows = |spec: &foveasim_models::DisplaySpec| {
            let display = foveasim_models::Display::try_from(spec.clone()).unwrap();
            sweep(vec![SweepDisplay::from(&display)], "full,layers:3")
                .run(|_| ())
                .unwrap()
        };
        let whole = rows(&spec);
        spec.hmd.as_mut().unwrap().hidden_area_fraction = 0.2;
        let masked = rows(&spec);
        assert!((masked[0].method_samples / whole[0].method_samples - 0.8).abs() < 1e-12);
        assert_eq!(masked[0].sample_ratio(), 1.0);
        let outermost = 2.0 * whole[1].layers.passes[2].samples;
        let left_out = whole[1].method_samples - masked[1].method_samples;
        assert!((left_out / (0.2 * outermost) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn with_a_cant_the_centre_is_ahead_of_the_head() {
        let mut spec = presets::display_spec("quest-pro").unwrap();
        spec.hmd.as_mut().unwrap().cant_deg = 5.0;
        let display = foveasim_models::Display::try_from(spec).unwrap();
        // The left eye's axis points 5° to the left, so ahead is 5° to its right.
        assert!((display.eyes[0].ahead().azimuth_deg - 5.0).abs() < 1e-12);
        assert!((display.eyes[1].ahead().azimuth_deg + 5.0).abs() < 1e-12);
        let row = sweep(vec![SweepDisplay::from(&display)], "layers:3")
            .run(|_| ())
            .unwrap()
            .remove(0);
        let axis = display.eyes[0].viewport.axis_px();
        assert!(row.gaze_px[0] > axis.x + 10.0 && (row.gaze_px[1] - axis.y).abs() < 1e-6);
    }

    #[test]
    fn fixed_layers_do_not_follow() {
        let lg = SweepDisplay::from(&presets::display("lg-w2363d").unwrap());
        let mut at_edge = sweep(vec![lg], "layers:3");
        at_edge.gazes = vec![GazeAt::Pixel([0.0, 540.0])];
        let tracked = at_edge.run(|_| ()).unwrap().remove(0);
        at_edge.gaze_mode = GazeMode::Fixed;
        let fixed = at_edge.run(|_| ()).unwrap().remove(0);
        assert!((fixed.gaze_error_deg - 23.374).abs() < 1e-3 && tracked.gaze_error_deg == 0.0);
        // oracle s1 gaze_clipping, edge_left, exact coverage
        assert!((tracked.sample_ratio() - 11.127_819).abs() < 1e-5);
        assert!((fixed.sample_ratio() - 8.497_841).abs() < 1e-5);
        // From its edge the study display reaches twice as far as from its centre.
        assert!(tracked.extrapolated && !fixed.extrapolated);
    }

    #[test]
    fn pixels_per_degree_say_where() {
        let width = |at| {
            let display = Resolution::PerDegree(at, 40.0)
                .display(120.0, 0.5625)
                .unwrap();
            display.eyes[0].viewport.unwrap().size.x
        };
        // methods.md §1
        assert_eq!(width(DensityAt::Centre), 7939);
        assert_eq!(width(DensityAt::Mean), 4800);
        assert!(
            Resolution::PerDegree(DensityAt::Mean, 1e9)
                .display(120.0, 1.0)
                .is_err()
        );
        assert!(Resolution::Sharpness(1.0).display(180.0, 1.0).is_err());
    }
}
