use std::f64::consts::SQRT_2;
use std::time::Duration;

use foveasim_assets::{Scene, study_scene};
use foveasim_models::foveation::Method;
use foveasim_models::math::mean;
use foveasim_models::{Acuity, Affine, Feather, Lattice, Map, Resolve, SamplePlan};
use foveasim_reports::Table;
use glam::{DVec3, UVec2};

use super::shooter::{self, Antialiasing, Flight, Shooter, Times, time};
use super::{Guenter2012, ReproduceError, check};
use crate::line::Line;

/// What layers save in time, and what of a frame's time samples are the cause of: on the full study
/// scene, with the antialiasing of the user study, at the slope of quality A.
///
/// The fixed part of a frame (geometry, putting the layers together) is measured: the same frame with no
/// sample of it drawn. All that is left is what samples cost: visibility, shading, and finding each in the
/// frame before.
///
/// Beside it, every way is timed at several densities: the same plan with its samples farther apart, of the same
/// meshes and shaded as finely. The slope of time over samples is another measure of what one costs. It leaves with the
/// geometry what triangles cost however few samples see them; the first measure has that among the samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Payoff {
    /// Full resolution, then every other way.
    pub rows: Vec<PayoffRow>,
}

/// One way to draw.
#[derive(Debug, Clone, PartialEq)]
pub struct PayoffRow {
    /// The method.
    pub method: Method,
    /// Whether outer layers take turns, or are drawn in every frame.
    pub in_turns: bool,
    /// Samples per frame and times, from the plan itself to the coarsest.
    pub densities: Vec<(f64, Times)>,
    /// Times of the plan itself with no sample drawn.
    pub fixed: Times,
    /// Slope of time over samples \[ns\].
    pub slope_ns: f64,
    /// Coefficient of determination of that line.
    pub r2: f64,
}

/// How many times farther apart samples are.
const STEPS: [f64; 4] = [1.0, SQRT_2, 2.0, 4.0];

/// The methods beside full resolution.
const METHODS: [&str; 2] = ["layers:3", "layers:4"];

impl Guenter2012 {
    /// Times full resolution and layers at these moments with this size and seed; the antialiasing
    /// frames do not matter. `clock` and `progress` are as in [`Guenter2012::run`].
    ///
    /// # Errors
    /// If there are no moments or too many, or the image cannot be drawn.
    pub fn payoff(
        &self,
        clock: &mut dyn FnMut() -> Duration,
        progress: &dyn Fn(&str, f64),
    ) -> Result<Payoff, ReproduceError> {
        check("moments", self.moments, 1..=1000, "from 1 to 1000")?;
        let flight = self.flight(self.size)?;
        let scene = study_scene(self.seed);
        let moments = shooter::moments(self.moments);
        let mut ways = vec![(Method::Full, false)];
        for method in METHODS {
            let method = method.parse()?;
            ways.extend([(method, false), (method, true)]);
        }
        // Full resolution as it is drawn, then all ways at all densities.
        let mut shooters = vec![shooter(&flight, &scene, ways[0], None)?];
        for way in &ways {
            for step in STEPS {
                shooters.push(shooter(&flight, &scene, *way, Some(step))?);
            }
            shooters.push(shooter(&flight, &scene, *way, None)?.without_samples());
        }
        let steps = (shooters.len() * moments.len()) as f64;
        let mut step = super::stepper(progress, "time over samples", [0.0, 1.0], steps);
        let mut shooters: Vec<_> = shooters.into_iter().map(Shooter::settled).collect();
        let times = time(&mut shooters, &moments, clock, &mut step)?;
        let mut measured = Vec::new();
        for (shooter, times) in shooters.iter().zip(times) {
            measured.push((shooter.samples_drawn(&moments)?, times));
        }
        let as_drawn = measured.remove(0);
        let rows = ways.iter().zip(measured.chunks_exact(STEPS.len() + 1));
        let mut rows: Vec<_> = rows
            .map(|(way, m)| PayoffRow::new(*way, &m[..STEPS.len()], m[STEPS.len()].1.clone()))
            .collect();
        rows[0].densities[0] = as_drawn;
        Ok(Payoff { rows })
    }
}

/// Draws one way at `step` times the distance of its samples, put together as layers are; without one,
/// as users do.
fn shooter<'a>(
    flight: &'a Flight,
    scene: &'a Scene,
    (method, in_turns): (Method, bool),
    step: Option<f64>,
) -> Result<Shooter<'a>, ReproduceError> {
    let method = flight.prepare(method, Acuity::default())?;
    let shooter = Shooter::new(flight, scene, method, Antialiasing::ALL);
    let shooter = match step {
        Some(step) => shooter.coarser(step),
        None => shooter,
    };
    Ok(if in_turns {
        shooter
    } else {
        shooter.in_every_frame()
    })
}

/// The same plan with its samples `step` times as far apart along each axis, put together by
/// interpolation whatever `step` is.
pub(super) fn coarser(mut plan: SamplePlan, step: f64, gaze: DVec3) -> SamplePlan {
    for pass in &mut plan.passes {
        let (Lattice::Grid(size), Map::Affine(map)) = (pass.lattice, pass.map) else {
            continue;
        };
        let fewer = (size.as_dvec2() / step).ceil();
        pass.lattice = Lattice::Grid(UVec2::new(fewer.x as u32, fewer.y as u32));
        pass.map = Map::Affine(Affine {
            origin: map.origin,
            scale: map.scale * size.as_dvec2() / fewer,
        });
    }
    if plan.resolve == Resolve::Direct {
        plan.resolve = Resolve::Feather(Feather {
            gaze,
            edges_tan: Vec::new(),
        });
    }
    plan
}

impl Shooter<'_> {
    /// Samples per frame, each layer as often as it is drawn here; mean over the moments.
    fn samples_drawn(&self, moments: &[u32]) -> Result<f64, ReproduceError> {
        let of = |&moment| {
            let count = self.plan(moment)?.count();
            Ok(if self.takes_turns() {
                count.samples_staggered()
            } else {
                count.samples() as f64
            })
        };
        let all: Result<Vec<f64>, ReproduceError> = moments.iter().map(of).collect();
        Ok(mean(&all?))
    }
}

impl PayoffRow {
    fn new((method, in_turns): (Method, bool), densities: &[(f64, Times)], fixed: Times) -> Self {
        let points = densities.iter().map(|(n, times)| [*n, times.mean_ms()]);
        let line = Line::through(&points.collect::<Vec<_>>());
        Self {
            method,
            in_turns,
            densities: densities.to_vec(),
            fixed,
            slope_ns: line.slope * 1e6,
            r2: line.r2,
        }
    }

    /// Samples per frame.
    pub fn samples(&self) -> f64 {
        self.densities[0].0
    }

    /// Mean time of a frame \[ms\].
    pub fn frame_ms(&self) -> f64 {
        self.densities[0].1.mean_ms()
    }

    /// Mean time of a frame of which no sample is drawn \[ms\].
    pub fn fixed_ms(&self) -> f64 {
        self.fixed.mean_ms()
    }

    /// What each sample costs \[ns\].
    pub fn per_sample_ns(&self) -> f64 {
        (self.frame_ms() - self.fixed_ms()) / self.samples() * 1e6
    }
}

impl Payoff {
    /// How many times fewer samples a row has than full resolution.
    pub fn sample_ratio(&self, row: &PayoffRow) -> f64 {
        self.rows[0].samples() / row.samples()
    }

    /// How many times faster its whole frame is.
    pub fn speedup(&self, row: &PayoffRow) -> f64 {
        self.rows[0].frame_ms() / row.frame_ms()
    }

    /// How many times faster it is once the fixed part of both is taken out.
    pub fn speedup_of_samples(&self, row: &PayoffRow) -> f64 {
        let variable = |r: &PayoffRow| r.frame_ms() - r.fixed_ms();
        variable(&self.rows[0]) / variable(row)
    }

    /// How many times faster its samples are by the slopes of both lines.
    pub fn speedup_by_slope(&self, row: &PayoffRow) -> f64 {
        let variable = |r: &PayoffRow| r.slope_ns * r.samples();
        variable(&self.rows[0]) / variable(row)
    }

    /// One row per way to draw.
    pub fn table(&self) -> Table {
        let mut table = Table::new([
            "method",
            "in_turns",
            "samples_per_frame",
            "sample_ratio",
            "frame_ms",
            "speedup",
            "speedup_over_sample_ratio",
            "fixed_ms",
            "fixed_share",
            "per_sample_ns",
            "speedup_without_fixed",
            "speedup_without_fixed_over_sample_ratio",
            "slope_ns",
            "r2",
            "speedup_by_slope_over_sample_ratio",
        ]);
        for row in &self.rows {
            let ratio = self.sample_ratio(row);
            let (whole, variable) = (self.speedup(row), self.speedup_of_samples(row));
            table.push(vec![
                row.method.to_string().into(),
                if row.in_turns { "yes" } else { "no" }.into(),
                row.samples().into(),
                ratio.into(),
                row.frame_ms().into(),
                whole.into(),
                (whole / ratio).into(),
                row.fixed_ms().into(),
                (row.fixed_ms() / row.frame_ms()).into(),
                row.per_sample_ns().into(),
                variable.into(),
                (variable / ratio).into(),
                row.slope_ns.into(),
                row.r2.into(),
                (self.speedup_by_slope(row) / ratio).into(),
            ]);
        }
        table
    }

    /// Every time that was measured: one row for each way, density and moment; no samples stand for the
    /// fixed part.
    pub fn raw_table(&self) -> Table {
        let columns = [
            "method",
            "in_turns",
            "samples_per_frame",
            "moment",
            "frame_ms",
        ];
        let mut table = Table::new(columns);
        for row in &self.rows {
            let fixed = (0.0, row.fixed.clone());
            for (samples, times) in row.densities.iter().chain([&fixed]) {
                for (moment, ms) in times.frame_ms.iter().enumerate() {
                    table.push(vec![
                        row.method.to_string().into(),
                        if row.in_turns { "yes" } else { "no" }.into(),
                        (*samples).into(),
                        moment.into(),
                        (*ms).into(),
                    ]);
                }
            }
        }
        table
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(method: &str, fixed_ms: f64, ns: f64, samples: f64) -> PayoffRow {
        let at = |step: f64| {
            let n = samples / (step * step);
            let frame_ms = vec![fixed_ms + n * ns * 1e-6; 2];
            (n, Times { frame_ms })
        };
        let fixed = Times {
            frame_ms: vec![fixed_ms; 2],
        };
        PayoffRow::new((method.parse().unwrap(), false), &STEPS.map(at), fixed)
    }

    #[test]
    fn a_fixed_part_is_found_and_taken_out() {
        let rows = vec![
            row("full", 10.0, 100.0, 2e6),
            row("layers:3", 20.0, 110.0, 2e5),
        ];
        let payoff = Payoff { rows };
        let layers = &payoff.rows[1];
        assert!((layers.per_sample_ns() - 110.0).abs() < 1e-9);
        assert!((layers.slope_ns - 110.0).abs() < 1e-9 && (layers.r2 - 1.0).abs() < 1e-12);
        assert!((payoff.sample_ratio(layers) - 10.0).abs() < 1e-12);
        assert!((payoff.speedup(layers) - 210.0 / 42.0).abs() < 1e-12);
        assert!((payoff.speedup_of_samples(layers) - 200.0 / 22.0).abs() < 1e-9);
        assert!((payoff.speedup_by_slope(layers) - 200.0 / 22.0).abs() < 1e-9);
        assert_eq!(payoff.table().rows().len(), 2);
        assert_eq!(payoff.raw_table().rows().len(), 2 * (STEPS.len() + 1) * 2);
    }

    #[test]
    fn every_way_is_measured() {
        let mut ticks = 0;
        let mut clock = || {
            ticks += 1;
            Duration::from_millis(ticks * ticks)
        };
        // Small, but with pixels fine enough for outer layers to be of use.
        let small = Guenter2012 {
            size: UVec2::new(480, 270),
            ..Guenter2012::quick()
        };
        let payoff = small.payoff(&mut clock, &|_, _| ()).unwrap();
        let ways: Vec<_> = payoff.rows.iter().map(|r| r.in_turns).collect();
        assert_eq!(ways, [false, false, true, false, true]);
        let pixels = f64::from(small.size.x * small.size.y);
        assert_eq!(payoff.rows[0].samples(), pixels);
        for row in &payoff.rows {
            let samples: Vec<f64> = row.densities.iter().map(|(n, _)| *n).collect();
            // Lattices end on whole samples.
            for (n, step) in samples.iter().zip(STEPS) {
                let expected = samples[0] / (step * step);
                assert!((n / expected - 1.0).abs() < 0.2, "{samples:?}");
            }
            assert!(row.samples() <= pixels);
            assert_eq!(row.fixed.frame_ms.len(), row.densities[0].1.frame_ms.len());
        }
        assert!(payoff.rows[2].samples() < payoff.rows[1].samples());
    }
}
