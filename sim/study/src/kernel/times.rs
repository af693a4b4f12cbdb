use std::time::Duration;

use foveasim_assets::{Material, Scene, SceneError, SceneParts, Sky, study_scene};
use foveasim_models::Acuity;
use foveasim_models::foveation::Method;
use foveasim_models::math::quantile_sorted;
use foveasim_render::{RenderOptions, render_stereo};
use foveasim_reports::Table;
use glam::UVec2;

use super::pair::Pair;
use crate::reproduce::{ReproduceError, check, stepper};

/// Times full resolution, kernel foveated rendering in both forms and eye dominance, for two eyes on the study
/// scene.
///
/// A round draws a moment once in every way, with the study's materials and again with all of one colour
/// (nothing is then evaluated for a sample; visibility, detail and reconstruction are the same): the
/// difference is the time of shading. Of each moment the median over its rounds is taken, and speedups are
/// of the moments' sums: what is looked at differs from moment to moment, and with it what a sample costs (a third
/// of a full image may be sky, and hardly any of a kernel's), so a moment's own speedup says little of a flight's.
/// Full resolution is drawn twice in each round; by how much the two differ says what can be told apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KernelTimes {
    /// Pixels of each eye's image.
    pub size: UVec2,
    /// Moments of the flight.
    pub moments: u32,
    /// Rounds at each.
    pub rounds: u32,
    /// Of the scene.
    pub seed: u64,
}

/// What [`KernelTimes`] found.
#[derive(Debug, Clone, PartialEq)]
pub struct KernelTimings {
    /// Full resolution, then every other way.
    pub rows: Vec<KernelTimeRow>,
    /// How far the ratio of two equal draws is from one, in 9 of 10 rounds, each a sum over the moments: whole
    /// frames, and shading.
    pub noise: [f64; 2],
}

/// One way to draw both eyes.
#[derive(Debug, Clone, PartialEq)]
pub struct KernelTimeRow {
    /// The method.
    pub method: Method,
    /// Display pixels over samples of the buffers, both eyes together, those beyond the display among them: σ²
    /// but for whole samples; 1 of full resolution.
    pub buffer_ratio: f64,
    /// Evaluations of shading, both eyes together, mean over the moments.
    pub shadings: f64,
    /// Time of a frame, both eyes \[ms\].
    pub frame_ms: f64,
    /// … of which shading \[ms\].
    pub shading_ms: f64,
    /// How many times faster than full resolution: a frame.
    pub speedup: f64,
    /// … shading alone.
    pub shading_speedup: f64,
    /// The least and the greatest of the moments' own shading speedups.
    pub shading_range: [f64; 2],
}

/// The ways, full resolution first: it is drawn again at the end of each round.
const METHODS: [&str; 11] = [
    "full",
    "kfr:1.8:4",
    "kfr:1.8:4:published",
    "kfr:2:4",
    "kfr:2:4:published",
    "kfr:2.4:4",
    "kfr:2.4:4:published",
    "kfr:3:4",
    "kfr:3:4:published",
    "efr:2:3",
    "efr:2:3:published",
];

/// Milliseconds of a frame with the study's materials, and of one colour.
#[derive(Debug, Clone, Copy)]
struct Sample {
    frame: f64,
    bare: f64,
}

impl Sample {
    fn shading(self) -> f64 {
        self.frame - self.bare
    }
}

impl KernelTimes {
    /// One moment of small images: what a test can wait for.
    pub fn quick() -> Self {
        Self {
            size: UVec2::new(160, 180),
            moments: 1,
            rounds: 3,
            seed: 1,
        }
    }

    /// Measures. `clock` tells the time since whenever; `progress` hears how far it is.
    ///
    /// # Errors
    /// If there are no moments or rounds or too many, or an image cannot be drawn.
    pub fn run(
        &self,
        clock: &mut dyn FnMut() -> Duration,
        progress: &dyn Fn(&str, f64),
    ) -> Result<KernelTimings, ReproduceError> {
        check("moments", self.moments, 1..=1000, "from 1 to 1000")?;
        check("rounds", self.rounds, 1..=1000, "from 1 to 1000")?;
        let methods = METHODS.map(str::parse::<Method>);
        let methods = methods.into_iter().collect::<Result<Vec<_>, _>>()?;
        let scene = study_scene(self.seed);
        let Ok(bare) = one_colour(&scene) else {
            unreachable!("the parts of a scene make one")
        };
        let steps = f64::from(self.moments * self.rounds);
        let mut step = stepper(progress, "times of kernels", [0.0, 1.0], steps);
        // For each way, and full resolution again, all rounds.
        let mut samples: Vec<Vec<Sample>> = vec![Vec::new(); methods.len() + 1];
        let mut shadings = vec![0.0; methods.len()];
        let mut ratios = vec![1.0; methods.len()];
        for moment in 0..self.moments {
            let pair = Pair::new(self.size, moment, self.moments, self.seed)?;
            for (method, ratio) in methods.iter().zip(&mut ratios) {
                let plans = pair.plans(method, Acuity::default())?;
                let texels = plans.iter().filter_map(|p| p.passes.last());
                let texels: u64 = texels.map(|p| p.lattice.samples()).sum();
                let pixels = 2 * u64::from(self.size.x) * u64::from(self.size.y);
                *ratio = pixels as f64 / texels as f64;
            }
            for _ in 0..self.rounds {
                for way in 0..=methods.len() {
                    let method = &methods[way % methods.len()];
                    let (frame, count) = time(&pair, &scene, method, clock)?;
                    let (bare, _) = time(&pair, &bare, method, clock)?;
                    samples[way].push(Sample { frame, bare });
                    if let Some(sum) = shadings.get_mut(way) {
                        *sum += count as f64 / steps;
                    }
                }
                step();
            }
        }
        let rounds = self.rounds as usize;
        Ok(KernelTimings::new(
            &methods, &samples, rounds, &shadings, &ratios,
        ))
    }
}

impl KernelTimings {
    /// From the samples of each way, those of a moment's `rounds` one after the other.
    fn new(
        methods: &[Method],
        samples: &[Vec<Sample>],
        rounds: usize,
        shadings: &[f64],
        ratios: &[f64],
    ) -> Self {
        // The median of each moment.
        let moments = |way: &[Sample], of: &dyn Fn(&Sample) -> f64| -> Vec<f64> {
            way.chunks(rounds)
                .map(|moment| median(moment.iter().map(of)))
                .collect()
        };
        let frame = |way: &[Sample]| moments(way, &|s| s.frame);
        let shading = |way: &[Sample]| moments(way, &|s| s.shading());
        let (full_frame, full_shading) = (frame(&samples[0]), shading(&samples[0]));
        let rows = methods.iter().zip(samples).zip(shadings.iter().zip(ratios));
        let rows = rows.map(|((method, way), (count, ratio))| {
            let (frame, shading) = (frame(way), shading(way));
            let own = full_shading.iter().zip(&shading).map(|(f, s)| f / s);
            let range = own.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], r| {
                [low.min(r), high.max(r)]
            });
            KernelTimeRow {
                method: *method,
                buffer_ratio: *ratio,
                shadings: *count,
                frame_ms: total(&frame) / frame.len() as f64,
                shading_ms: total(&shading) / shading.len() as f64,
                speedup: total(&full_frame) / total(&frame),
                shading_speedup: total(&full_shading) / total(&shading),
                shading_range: range,
            }
        });
        let again = &samples[methods.len()];
        let noise = |of: &dyn Fn(&Sample) -> f64| {
            let sum = |way: &[Sample], round: usize| {
                total(
                    &way.iter()
                        .skip(round)
                        .step_by(rounds)
                        .map(of)
                        .collect::<Vec<_>>(),
                )
            };
            let ratios = (0..rounds).map(|r| sum(&samples[0], r) / sum(again, r));
            let mut away: Vec<f64> = ratios.map(|r| (r - 1.0).abs()).collect();
            away.sort_by(f64::total_cmp);
            quantile_sorted(&away, 0.9)
        };
        Self {
            rows: rows.collect(),
            noise: [noise(&|s| s.frame), noise(&|s| s.shading())],
        }
    }

    /// The row of a method, as users write it.
    pub fn row(&self, method: &str) -> Option<&KernelTimeRow> {
        self.rows.iter().find(|r| r.method.to_string() == method)
    }

    /// One row per way.
    pub fn table(&self) -> Table {
        let mut table = Table::new([
            "method",
            "shadings_per_frame",
            "buffer_ratio",
            "frame_ms",
            "shading_ms",
            "fixed_ms",
            "frame_speedup",
            "shading_speedup",
            "shading_speedup_of_buffer_ratio",
            "shading_speedup_least",
            "shading_speedup_greatest",
            "noise_frame",
            "noise_shading",
        ]);
        for r in &self.rows {
            table.push(vec![
                r.method.to_string().into(),
                r.shadings.into(),
                r.buffer_ratio.into(),
                r.frame_ms.into(),
                r.shading_ms.into(),
                (r.frame_ms - r.shading_ms).into(),
                r.speedup.into(),
                r.shading_speedup.into(),
                (r.shading_speedup / r.buffer_ratio).into(),
                r.shading_range[0].into(),
                r.shading_range[1].into(),
                self.noise[0].into(),
                self.noise[1].into(),
            ]);
        }
        table
    }
}

/// Milliseconds of both eyes' frame, plans included, and how often something was shaded.
fn time(
    pair: &Pair,
    scene: &Scene,
    method: &Method,
    clock: &mut dyn FnMut() -> Duration,
) -> Result<(f64, u64), ReproduceError> {
    let began = clock();
    let [left, right] = pair.plans(method, Acuity::default())?;
    let views = [&pair.views[0], &pair.views[1]];
    let options = RenderOptions::default();
    let frame = render_stereo(scene, pair.head, views, [&left, &right], &options)?;
    let took = clock().saturating_sub(began);
    let shadings = frame.work.samples_shaded + frame.work.samples_sky;
    Ok((took.as_secs_f64() * 1e3, shadings))
}

/// The same scene in one colour, before a sky of one colour.
pub(crate) fn one_colour(scene: &Scene) -> Result<Scene, SceneError> {
    Scene::build(SceneParts {
        meshes: scene.meshes().to_vec(),
        lods: scene.lods().to_vec(),
        instances: scene.instances().to_vec(),
        materials: vec![Material::Unlit([0.5; 3]); scene.materials().len()],
        textures: scene.textures().to_vec(),
        motions: scene.motions().to_vec(),
        sky: Sky::Uniform([0.5; 3]),
        sun: *scene.sun(),
    })
}

/// In order.
fn total(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |sum, v| sum + v)
}

pub(crate) fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    quantile_sorted(&values, 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A clock that counts what was shaded would be exact; this one counts how often it was asked.
    #[test]
    fn every_way_is_timed_in_every_round() {
        let study = KernelTimes {
            size: UVec2::new(64, 72),
            moments: 1,
            rounds: 2,
            ..KernelTimes::quick()
        };
        let asked = std::cell::Cell::new(0u64);
        let mut clock = || {
            asked.set(asked.get() + 1);
            Duration::from_millis(asked.get() * asked.get())
        };
        let timings = study.run(&mut clock, &|_, _| ()).unwrap();
        assert_eq!(asked.get(), 2 * 2 * 2 * (METHODS.len() as u64 + 1));
        assert_eq!(timings.rows.len(), METHODS.len());
        let kernel = timings.row("kfr:2:4").unwrap();
        assert!((kernel.buffer_ratio - 4.0).abs() < 1e-9);
        let full = timings.row("full").unwrap();
        assert_eq!((full.speedup, full.shading_speedup), (1.0, 1.0));
        assert_eq!(full.shading_range, [1.0; 2]);
        assert!(full.shadings == 2.0 * 64.0 * 72.0 && kernel.shadings <= full.shadings / 4.0);
        let both = timings.row("efr:2:3").unwrap();
        assert!((both.buffer_ratio - 2.0 / (1.0 / 4.0 + 1.0 / 9.0)).abs() < 0.2);
        assert_eq!(timings.table().rows().len(), METHODS.len());
        let wrong = KernelTimes { rounds: 0, ..study };
        assert!(wrong.run(&mut clock, &|_, _| ()).is_err());
    }

    /// Moments weigh by what they take, not one like the other.
    #[test]
    fn speedups_are_of_sums_over_moments() {
        let sample = |frame: f64, bare: f64| Sample { frame, bare };
        // Two moments of three rounds: shading of 80 and 20 ms against 40 and 2; one round is an outlier.
        let full = vec![
            sample(90.0, 10.0),
            sample(90.0, 10.0),
            sample(500.0, 10.0),
            sample(30.0, 10.0),
            sample(30.0, 10.0),
            sample(30.0, 10.0),
        ];
        let way: Vec<_> = [50.0, 50.0, 50.0, 12.0, 12.0, 12.0]
            .map(|frame| sample(frame, 10.0))
            .into();
        let methods = ["full", "kfr:2:4"].map(|m| m.parse().unwrap());
        let samples = [full.clone(), way, full];
        let timings = KernelTimings::new(&methods, &samples, 3, &[1.0; 2], &[1.0, 4.0]);
        let row = timings.row("kfr:2:4").unwrap();
        assert_eq!(row.shading_speedup, 100.0 / 42.0);
        assert_eq!(row.speedup, 120.0 / 62.0);
        assert_eq!(row.shading_range, [2.0, 10.0]);
        assert_eq!((row.frame_ms, row.shading_ms), (31.0, 21.0));
        assert_eq!(timings.noise, [0.0; 2]);
    }
}
