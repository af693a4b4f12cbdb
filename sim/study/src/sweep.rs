//! Savings across displays, methods, acuity, gaze and tracking margins.

mod display;
mod request;
mod row;
mod shard;
mod solve;
mod spread;
mod terms;

pub use display::{DensityAt, Resolution, SweepDisplay, SweepEye};
pub use row::{
    COLUMNS as SWEEP_COLUMNS, Drawn, MapRatio, SweepRow, TEXT_COLUMNS as SWEEP_TEXT_COLUMNS,
    WHOLE_COLUMNS as SWEEP_WHOLE_COLUMNS,
};
pub use shard::Shard;
pub use solve::{Outcome, Solution, Solve, Target, Unknown};
pub use spread::{SavingsSpread, SavingsSpreadRow};
pub use terms::{Buffers, Fits, Link, Needs, Terms};

use std::sync::Arc;

use foveasim_models::foveation::{
    Aim, Estimate, FloorDensity, Method, PassEstimate, PlanCache, Request, ideal_samples,
};
use foveasim_models::{Acuity, GazeDirection, GazeMode, ModelError};
use foveasim_reports::TableDigest;
use glam::DVec2;
use rayon::prelude::*;

/// Every combination of the lists is one row, in the order displays, slopes, gazes, margins, methods
/// (the last changes fastest), for any number of threads.
///
/// Head-mounted displays are planned eye by eye: an image plane may lie unevenly about its eye's
/// axis and have oblong pixels; radii are optimised for gaze along the axis, ω* is the larger pixel's
/// there, and samples are summed over the eyes. The hidden area is left out of the display's pixels and
/// of the pass that draws it, the coarsest; the floor keeps it, and so is a little high there.
///
/// Two things can fix the gaze. A sweep's mode puts what would be tracked straight ahead and changes
/// nothing else; a method that is [fixed](Aim::Fixed) stays there in either mode, and is designed for
/// an eye that looks away as far as it says. The floor of its row has that reach as well.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// Displays.
    pub displays: Vec<SweepDisplay>,
    /// Acuity lines.
    pub acuities: Vec<Acuity>,
    /// Where the eyes look.
    pub gazes: Vec<GazeAt>,
    /// Whether tracked methods follow the gaze. If not they stay straight ahead, and so does the floor
    /// they are compared with.
    pub gaze_mode: GazeMode,
    /// How far gaze may be off without the viewer noticing \[deg\].
    pub margins_deg: Vec<f64>,
    /// Methods.
    pub methods: Vec<Method>,
    /// What time, memory and link cost.
    pub terms: Arc<Terms>,
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
        let rows: Vec<Result<Vec<SweepRow>, ModelError>> = (0..self.groups())
            .into_par_iter()
            .map_init(PlanCache::default, |cache, group| {
                let rows = self.rows_from(cache, group);
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

    /// How many groups of rows there are that differ in their method alone.
    pub fn groups(&self) -> usize {
        self.len() / self.methods.len().max(1)
    }

    /// What the rows of one group are made from, as 64 hexadecimal digits: the same for the same display, acuity,
    /// gaze, margin, methods and terms in the same version, in whatever sweep.
    ///
    /// # Panics
    /// If there is no such group.
    pub fn address(&self, group: usize) -> String {
        let cache = PlanCache::default();
        let Situation {
            display,
            acuity,
            gaze,
            margin_deg,
            terms,
            ..
        } = self.situation(group, &cache);
        let made_from = format!(
            "{display:?} {acuity:?} {gaze:?} {margin_deg:?} {terms:?} {:?} {:?}",
            self.gaze_mode, self.methods
        );
        TableDigest::new(&[made_from.as_str(), env!("CARGO_PKG_VERSION")]).finish()
    }

    /// The rows of one group, a method each.
    ///
    /// # Errors
    /// As [`Sweep::run`].
    ///
    /// # Panics
    /// If there is no such group.
    pub fn rows(&self, group: usize) -> Result<Vec<SweepRow>, ModelError> {
        self.rows_from(&PlanCache::default(), group)
    }

    /// The same with what a cache has kept of the groups before: those of one display follow each other.
    ///
    /// # Errors
    /// As [`Sweep::run`].
    ///
    /// # Panics
    /// If there is no such group.
    pub fn rows_from(&self, cache: &PlanCache, group: usize) -> Result<Vec<SweepRow>, ModelError> {
        self.situation(group, cache)
            .rows(&self.methods, self.gaze_mode)
    }

    /// A sweep of one group.
    fn one(&self, group: usize) -> Self {
        let cache = PlanCache::default();
        let situation = self.situation(group, &cache);
        Self {
            displays: vec![situation.display.clone()],
            acuities: vec![situation.acuity],
            gazes: vec![situation.gaze],
            margins_deg: vec![situation.margin_deg],
            gaze_mode: self.gaze_mode,
            methods: self.methods.clone(),
            terms: self.terms.clone(),
        }
    }

    fn situation<'a>(&'a self, group: usize, cache: &'a PlanCache) -> Situation<'a> {
        let mut rest = group;
        let mut next = |n: usize| {
            let place = rest % n;
            rest /= n;
            place
        };
        let margin_deg = self.margins_deg[next(self.margins_deg.len())];
        let gaze = self.gazes[next(self.gazes.len())];
        let acuity = self.acuities[next(self.acuities.len())];
        let display = &self.displays[next(self.displays.len())];
        assert_eq!(rest, 0, "group {group} of {}", self.groups());
        Situation {
            display,
            acuity,
            gaze,
            margin_deg,
            terms: &self.terms,
            cache,
        }
    }
}

/// What rows of different methods share.
struct Situation<'a> {
    display: &'a SweepDisplay,
    acuity: Acuity,
    gaze: GazeAt,
    margin_deg: f64,
    terms: &'a Arc<Terms>,
    cache: &'a PlanCache,
}

impl Situation<'_> {
    fn rows(&self, methods: &[Method], mode: GazeMode) -> Result<Vec<SweepRow>, ModelError> {
        let tracked = self.ideal(Aim::Tracked, mode)?;
        methods
            .iter()
            .map(|&method| {
                let ideal = match method.aim() {
                    Aim::Tracked => tracked,
                    aim => self.ideal(aim, mode)?,
                };
                self.row(method, mode, ideal)
            })
            .collect()
    }

    /// Samples of the continuous falloff.
    fn ideal(&self, aim: Aim, mode: GazeMode) -> Result<f64, ModelError> {
        let margin_deg = aim.margin_deg(self.margin_deg);
        let mut ideal = 0.0;
        for eye in &self.display.eyes {
            let gaze = self.drawn_gaze(eye, aim, mode);
            let density = FloorDensity::PerSolidAngle;
            ideal += ideal_samples(&eye.screen, self.acuity, gaze, margin_deg, density)?;
        }
        Ok(ideal)
    }

    /// Each eye's closed form.
    fn estimates(&self, method: Method, mode: GazeMode) -> Result<Vec<Estimate>, ModelError> {
        let estimate = |eye: &SweepEye| {
            let gaze = self.drawn_gaze(eye, method.aim(), mode);
            let own = method.of_eye(eye.eye);
            let (acuity, margin_deg) = (self.acuity, self.margin_deg);
            let estimate = (self.cache).estimate(&own, &eye.screen, acuity, gaze, margin_deg)?;
            Ok(without_hidden_area(estimate, eye.hidden_area_fraction))
        };
        self.display.eyes.iter().map(estimate).collect()
    }

    /// What both eyes' plans draw; `None` for a display without whole pixels.
    fn drawn(&self, method: Method, mode: GazeMode) -> Result<Option<Drawn>, ModelError> {
        let mut drawn = Drawn::default();
        for eye in &self.display.eyes {
            let Some(viewport) = eye.viewport else {
                return Ok(None);
            };
            let request = Request {
                eye: eye.eye,
                viewport,
                acuity: self.acuity,
                gaze: self.drawn_gaze(eye, method.aim(), mode),
                ahead: eye.ahead(),
                margin_deg: self.margin_deg,
            };
            let count = self.cache.plan(&method, &request)?.count();
            drawn.samples += count.samples();
            drawn.shadings += count.shadings();
        }
        Ok(Some(drawn))
    }

    /// Evaluations of shading of the fixed method over those of the tracked one: fixed as `method` is,
    /// or with the default reach. `own` are the method's as it is. `None` for a method whose samples are given, fixed or not.
    fn tracked_over_fixed(
        &self,
        method: Method,
        mode: GazeMode,
        own: &[Estimate],
    ) -> Result<Option<f64>, ModelError> {
        if method.is_given() {
            return Ok(None);
        }
        let fixed = match method.aim() {
            Aim::Tracked => Aim::FIXED,
            aim @ Aim::Fixed { .. } => aim,
        };
        let shadings = |aim| {
            let sum = |all: &[Estimate]| all.iter().map(Estimate::shadings).sum::<f64>();
            match aim == method.aim() {
                true => Ok(sum(own)),
                false => Ok(sum(&self.estimates(method.with_aim(aim), mode)?)),
            }
        };
        Ok(Some(shadings(fixed)? / shadings(Aim::Tracked)?))
    }

    fn row(&self, method: Method, mode: GazeMode, ideal: f64) -> Result<SweepRow, ModelError> {
        let aim = method.aim();
        let mut estimates = self.estimates(method, mode)?;
        let total = |f: fn(&Estimate) -> f64| estimates.iter().map(f).sum();
        let passes = |count: fn(&PassEstimate) -> f64| {
            let all = estimates.iter().flat_map(|e| &e.passes);
            all.filter(|p| p.samples > 0.0 || p.shadings > 0.0)
                .map(count)
                .sum()
        };
        let first = &self.display.eyes[0];
        let (true_gaze, drawn) = (self.true_gaze(first), self.drawn_gaze(first, aim, mode));
        let reach = |e: &SweepEye| e.screen.reach_from_deg(self.drawn_gaze(e, aim, mode));
        let farthest = self.display.eyes.iter().map(reach);
        let mode_of_row = match aim {
            Aim::Tracked => mode,
            Aim::Fixed { .. } => GazeMode::Fixed,
        };
        Ok(SweepRow {
            display: self.display.clone(),
            method,
            acuity: self.acuity,
            gaze_px: self.gaze_px(first).into(),
            gaze_mode: mode_of_row,
            gaze_error_deg: match mode_of_row {
                GazeMode::Tracked => 0.0,
                GazeMode::Fixed => true_gaze.angle_to_deg(drawn),
            },
            margin_deg: self.margin_deg,
            display_samples: total(|e| e.display_pixels),
            method_samples: total(Estimate::samples),
            method_samples_staggered: total(Estimate::samples_staggered),
            method_shadings: total(Estimate::shadings),
            method_shadings_staggered: total(Estimate::shadings_staggered),
            ideal_samples: ideal,
            drawn: self.drawn(method, mode)?,
            tracked_over_fixed: self.tracked_over_fixed(method, mode, &estimates)?,
            extrapolated: farthest.fold(0.0, f64::max) > MEASURED_TO_DEG,
            terms: self.terms.clone(),
            passes: passes(|_| 1.0),
            passes_staggered: passes(|p| 1.0 / f64::from(p.every)),
            reconstructed: estimates.iter().any(Estimate::is_reconstructed),
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

    /// Where the sharpest part is, in the eye's own frame.
    fn drawn_gaze(&self, eye: &SweepEye, aim: Aim, mode: GazeMode) -> GazeDirection {
        match mode {
            GazeMode::Tracked => aim.gaze(self.true_gaze(eye), eye.ahead()),
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

/// Leaves the hidden area out of the display and of the pass that draws it: the coarsest, which fills
/// the image or at least its corners. Where one pass finds visibility and another shades, of both.
fn without_hidden_area(mut estimate: Estimate, fraction: f64) -> Estimate {
    let hidden = estimate.display_pixels * fraction;
    estimate.display_pixels -= hidden;
    let mut passes = estimate.passes.iter_mut();
    if let Some(seen) = passes.rfind(|p| p.samples > 0.0) {
        let samples = hidden / seen.scale.element_product();
        seen.samples = (seen.samples - samples).max(0.0);
    }
    let mut passes = estimate.passes.iter_mut();
    if let Some(shaded) = passes.rfind(|p| p.shadings > 0.0) {
        let shadings = hidden / shaded.scale.element_product() / shaded.block;
        shaded.shadings = (shaded.shadings - shadings).max(0.0);
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
            terms: Arc::default(),
        }
    }

    #[test]
    fn the_study_display() {
        let lg = SweepDisplay::from(&presets::display("lg-w2363d").unwrap());
        let rows = sweep(vec![lg], "full,layers:3").run(|_| ()).unwrap();
        assert_eq!(rows[0].sample_ratio(), 1.0);
        assert_eq!(rows[0].drawn.unwrap().samples, 1920 * 1080);
        // oracle s1 mA_0.0275_n3
        assert!((rows[1].sample_ratio() - 8.497_841_827).abs() < 1e-6);
        assert!((rows[1].sample_ratio_staggered() - 13.292_452).abs() < 1e-4);
        let plan = rows[1].drawn.unwrap().samples as f64;
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
        let alone = (0..many.groups()).flat_map(|g| many.rows(g).unwrap());
        assert_eq!(one, SweepRow::table(&alone.collect::<Vec<_>>()));
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
        let plan = rows[1].drawn.unwrap().samples as f64;
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
    fn a_fixed_method_stays_ahead_and_covers_its_reach() {
        let lg = SweepDisplay::from(&presets::display("lg-w2363d").unwrap());
        let mut aside = sweep(
            vec![lg],
            "layers:3,layers:3:fixed,layers:3:fixed=3,full,vrs:fixed",
        );
        aside.gazes = vec![GazeAt::Pixel([1300.0, 540.0])];
        let rows = aside.run(|_| ()).unwrap();
        let cell = |row: &SweepRow, name: &str| {
            let table = SweepRow::table(std::slice::from_ref(row));
            let place = table.columns().iter().position(|c| c == name).unwrap();
            table.rows()[0][place].clone()
        };
        // The gaze is 8.7° aside: within 15°, not within 3°.
        let within = rows.iter().map(|r| cell(r, "gaze_within_margin"));
        let within: Vec<Cell> = within.collect();
        assert_eq!(
            within,
            ["yes", "yes", "no", "yes", "yes"].map(|t| Cell::Text(t.into()))
        );
        assert_eq!(cell(&rows[0], "gaze_mode"), Cell::Text("tracked".into()));
        assert_eq!(cell(&rows[1], "gaze_mode"), Cell::Text("fixed".into()));
        assert!(
            (rows[1].gaze_error_deg - 8.702_829).abs() < 1e-6,
            "{}",
            rows[1].gaze_error_deg
        );
        // The same pair of samples from either side, and a floor that allows for the reach as well.
        assert_eq!(rows[0].tracked_over_fixed, rows[1].tracked_over_fixed);
        let measured = rows[1].method_samples / rows[0].method_samples;
        assert!((rows[0].tracked_over_fixed.unwrap() / measured - 1.0).abs() < 1e-12);
        assert!(rows[0].tracked_over_fixed > rows[2].tracked_over_fixed);
        assert!(rows[1].over_ideal() >= 1.0 && rows[1].ideal_ratio() < rows[0].ideal_ratio());
        assert_eq!(rows[3].tracked_over_fixed, Some(1.0));
        // oracle s1: a margin of 3° about the centre.
        assert!((rows[2].sample_ratio() - 4.218).abs() < 1e-3);
        // Variable-rate shading saves shading, not samples.
        assert_eq!(rows[4].sample_ratio(), 1.0);
        assert!(rows[4].shading_ratio() > 1.0 && rows[0].shading_ratio() == rows[0].sample_ratio());
    }

    #[test]
    fn every_method_leaves_the_hidden_area_out_once() {
        let mut spec = presets::display_spec("quest-pro").unwrap();
        let methods =
            "full,layers:3,vrs,fdm,rates,quad,quad:auto,kfr:2:4,kfr:2:4:published,lms:1:1,radial:2";
        let rows = |spec: &foveasim_models::DisplaySpec| {
            let display = foveasim_models::Display::try_from(spec.clone()).unwrap();
            sweep(vec![SweepDisplay::from(&display)], methods)
                .run(|_| ())
                .unwrap()
        };
        let whole = rows(&spec);
        spec.hmd.as_mut().unwrap().hidden_area_fraction = 0.01;
        for (masked, whole) in rows(&spec).iter().zip(&whole) {
            let hidden = whole.display_samples - masked.display_samples;
            // As published, kernel foveated rendering finds visibility elsewhere than it shades.
            let found = |f: fn(&PassEstimate) -> f64| {
                let passes = whole.layers.passes.iter();
                passes.rev().find(|p| f(p) > 0.0).unwrap()
            };
            let (seen, coarsest) = (found(|p| p.samples), found(|p| p.shadings));
            let [samples, shadings] = [
                whole.method_samples - masked.method_samples,
                whole.method_shadings - masked.method_shadings,
            ];
            let expected = hidden / seen.scale.element_product();
            assert!((samples / expected - 1.0).abs() < 1e-6, "{}", whole.method);
            let expected = hidden / coarsest.scale.element_product() / coarsest.block;
            assert!((shadings / expected - 1.0).abs() < 1e-6, "{}", whole.method);
        }
    }

    #[test]
    fn columns_hold_what_they_say() {
        let quest = SweepDisplay::from(&presets::display("quest-pro").unwrap());
        let made_up = Resolution::Sharpness(0.3).display(70.0, 1.0).unwrap();
        let rows = sweep(vec![quest, made_up], "full,layers:3,vrs:fixed,kfr:2:4");
        let table = SweepRow::table(&rows.run(|_| ()).unwrap());
        for (place, name) in table.columns().iter().enumerate() {
            for row in table.rows() {
                let fits = match &row[place] {
                    Cell::Text(_) => SWEEP_TEXT_COLUMNS.contains(&name.as_str()),
                    Cell::Int(_) => !SWEEP_TEXT_COLUMNS.contains(&name.as_str()),
                    Cell::Float(_) => ![&SWEEP_TEXT_COLUMNS[..], &SWEEP_WHOLE_COLUMNS]
                        .concat()
                        .contains(&name.as_str()),
                    Cell::Empty => true,
                };
                assert!(fits, "{name}: {:?}", row[place]);
            }
        }
        let known = |name: &&str| SWEEP_COLUMNS.contains(name);
        assert!(SWEEP_TEXT_COLUMNS.iter().all(known) && SWEEP_WHOLE_COLUMNS.iter().all(known));
    }

    #[test]
    fn energy_is_told_where_the_profile_does() {
        let lg = SweepDisplay::from(&presets::display("lg-w2363d").unwrap());
        let mut one = sweep(vec![lg], "full,layers:3");
        let cells = |sweep: &Sweep, row: usize| {
            let table = SweepRow::table(&sweep.run(|_| ()).unwrap());
            let place = |name: &str| table.columns().iter().position(|c| c == name).unwrap();
            ["energy_mj", "full_energy_mj", "power_w", "full_power_w"]
                .map(|name| table.rows()[row][place(name)].clone())
        };
        assert_eq!(cells(&one, 1), [(); 4].map(|()| Cell::Empty));
        let mut terms = Terms::default();
        terms.link.compression = 2.0;
        terms.cost.energy = Some(foveasim_models::EnergyProfile {
            fixed_mj: 1.0,
            per_sample_nj: 2.0,
            per_gbit_mj: 100.0,
            ..Default::default()
        });
        one.terms = Arc::new(terms);
        // 2,073,600 samples of 24 bits, halved: 0.0249 Gbit.
        let full = 1.0 + 2.0736 * 2.0 + 0.024_883_2 * 100.0;
        let hz = one.displays[0].refresh.unwrap().hz();
        for (cell, want) in
            cells(&one, 0)
                .into_iter()
                .zip([full, full, full * hz / 1e3, full * hz / 1e3])
        {
            let Cell::Float(got) = cell else {
                panic!("{cell:?}")
            };
            assert!((got - want).abs() < 1e-9, "{got}, {want}");
        }
        let [Cell::Float(layers), Cell::Float(all), ..] = cells(&one, 1) else {
            panic!()
        };
        assert!(layers > 1.0 && layers < all / 2.0 && (all - full).abs() < 1e-9);
        one.displays[0].refresh = None;
        assert_eq!(cells(&one, 1)[2], Cell::Empty);
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
