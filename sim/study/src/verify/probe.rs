use std::f64::consts::LN_2;

use foveasim_assets::Scene;
use foveasim_models::math::log;
use foveasim_models::{Eye, ModelError, Pose, SamplePlan, View, Viewport};
use foveasim_render::RenderOptions;
use glam::{DVec2, DVec3, UVec2};

use super::zones::ZONES;
use crate::measure::{Job, JobFrame, Measured};

/// What small pictures of a scene say of what its samples take, as seen from one place on one image: each with the
/// scene's materials, and again in one colour.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Probe {
    /// Shading of a sample \[ms\], by zone from the inside, at each of [`FINER`].
    shading: [[f64; FINENESSES]; ZONES],
    /// Visibility of a sample \[ms\] at each of [`FINER`].
    visibility: [f64; FINENESSES],
    /// Geometry of a pass \[ms\] over a quarter, half and all of the image, at each of [`FINER`].
    geometry: [[f64; FINENESSES]; ZONES],
    /// Width of the pictures' pixels, in shares of the image.
    pixel: f64,
}

/// Pixels across a probe's pictures.
const WIDTH: u32 = 160;
/// How many times as fine as those of a probe's pictures samples are taken to be: what they average over when
/// shaded, and of which meshes.
const FINER: [f64; FINENESSES] = [1.0, 4.0, 16.0];
const FINENESSES: usize = 3;
/// How many times narrower the pictures are that show the inner zones.
const NARROWER: [f64; ZONES] = [4.0, 2.0, 1.0];

/// In which window, and at which fineness, visibility is told from geometry, by place in [`NARROWER`] and [`FINER`]: where
/// samples lie as close as their meshes are made for. Beyond the last, a sample costs no less.
const VISIBILITY: [(usize, usize); 2] = [(2, 0), (0, 1)];

/// The pictures of one probe.
pub(super) struct Pictures {
    size: UVec2,
    rows: usize,
}

impl Pictures {
    /// Jobs that draw the `world`, and the `bare` same, as a display with these optics shows it.
    pub(super) fn new<'a>(
        [world, bare]: [&'a Scene; 2],
        optics: &Viewport,
        pose: Pose,
        gaze: DVec3,
        options: &RenderOptions,
    ) -> Result<(Self, Vec<Job<'a>>), ModelError> {
        let aspect = f64::from(optics.size.y) / f64::from(optics.size.x);
        let size = UVec2::new(WIDTH, ((f64::from(WIDTH) * aspect).round() as u32).max(1));
        let mut jobs = Vec::new();
        let mut add = |scene, narrower: f64, larger: u32, finer: f64| -> Result<(), ModelError> {
            let viewport = Viewport::new(size * larger, narrowed(optics, gaze, narrower))?;
            // By how much finer the pictures' own samples are than those of the plainest one.
            let own = narrower * f64::from(larger) / finer;
            let options = RenderOptions {
                footprint: (options.footprint * own).clamp(0.0625, 4.0),
                lod_error: (options.lod_error * own).clamp(0.015_625, 16.0),
                ..*options
            };
            let frame = JobFrame {
                scene,
                view: View::still(Eye::Cyclopean, viewport, pose),
                plan: SamplePlan::full(Eye::Cyclopean, viewport.size),
            };
            jobs.push(Job::still(frame, options));
            Ok(())
        };
        for narrower in NARROWER {
            for finer in FINER {
                add(world, narrower, 1, finer)?;
                add(bare, narrower, 1, finer)?;
            }
        }
        for (narrower, finer) in VISIBILITY.map(|(zone, f)| (NARROWER[zone], FINER[f])) {
            add(bare, narrower, 2, finer)?;
        }
        let rows = jobs.len();
        Ok((Self { size, rows }, jobs))
    }

    /// How many jobs there are.
    pub(super) fn len(&self) -> usize {
        self.rows
    }

    /// What their times say.
    pub(super) fn read(&self, times: &[Measured]) -> Probe {
        let ms: Vec<f64> = times.iter().map(Measured::frame_ms).collect();
        let samples = f64::from(self.size.x) * f64::from(self.size.y);
        let (pairs, large) = ms.split_at(2 * ZONES * FINENESSES);
        let at = |window: usize, fineness: usize| {
            let first = 2 * (window * FINENESSES + fineness);
            [pairs[first], pairs[first + 1]]
        };
        let per_sample = |window: usize, fineness: usize| {
            let [world, bare] = at(window, fineness);
            (world - bare) / samples
        };
        // Four times the samples of the same meshes: what is beyond is theirs.
        let per_sample_found = |k: usize| {
            let (zone, f) = VISIBILITY[k];
            let bare = at(zone, f)[1];
            ((large[k] - bare) / (3.0 * samples)).max(1e-9 * bare / samples)
        };
        let visibility = [0, 1, 1].map(per_sample_found);
        let geometry = std::array::from_fn(|window| {
            std::array::from_fn(|f| {
                let bare = at(window, f)[1];
                (bare - samples * visibility[f]).max(0.05 * bare)
            })
        });
        let shading = std::array::from_fn(|zone| {
            std::array::from_fn(|f| {
                let own = per_sample(zone, f);
                let found = match zone {
                    0 => own,
                    // A quarter of a window is the next one within.
                    _ => (4.0 * own - per_sample(zone - 1, f)) / 3.0,
                };
                // What differences of times cannot tell is no less than a part of the mean.
                found.max(0.2 * own).max(1e-6 * at(zone, f)[0] / samples)
            })
        });
        Probe {
            shading,
            visibility,
            geometry,
            pixel: 1.0 / f64::from(self.size.x),
        }
    }
}

impl Probe {
    /// How many times as fine samples are that lie so far apart \[ln of a share of the image's width\], as a power of four.
    fn fineness(&self, log_share: f64) -> f64 {
        (log(self.pixel) - log_share) / (2.0 * LN_2)
    }

    /// Shading of a sample of a zone \[ms\], `log_share` from the next one \[ln of a share of the image's width\].
    pub(super) fn shading(&self, zone: usize, log_share: f64) -> f64 {
        between(&self.shading[zone], self.fineness(log_share))
    }

    /// Visibility of a sample \[ms\].
    pub(super) fn visibility(&self, log_share: f64) -> f64 {
        between(&self.visibility, self.fineness(log_share))
    }

    /// Geometry of a pass \[ms\] that reaches over this share of the image.
    pub(super) fn geometry(&self, reach: f64, log_share: f64) -> f64 {
        let fineness = self.fineness(log_share);
        let windows = self.geometry.map(|g| between(&g, fineness));
        between(&windows, 2.0 + log(reach.max(1e-3)) / LN_2)
    }
}

/// Linear between values at 0, 1, 2 …, and constant beyond them.
fn between(values: &[f64; 3], at: f64) -> f64 {
    let at = at.clamp(0.0, 2.0);
    let first = usize::from(at >= 1.0);
    let share = at - first as f64;
    values[first] * (1.0 - share) + values[first + 1] * share
}

/// Edges of a part of an image about the gaze, so many times narrower; it stays within the image.
fn narrowed(optics: &Viewport, gaze: DVec3, narrower: f64) -> [f64; 4] {
    let size = optics.size.as_dvec2();
    let half = size / (2.0 * narrower);
    let centre = optics.project(gaze).unwrap_or(size / 2.0);
    let centre = centre.clamp(half, size - half);
    let corner = |px: DVec2| {
        let d = optics.direction(px);
        [d.x, d.y]
    };
    let ([left, up], [right, down]) = (corner(centre - half), corner(centre + half));
    [left, right, up, down]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unit_costs_come_out_of_times() {
        let pictures = Pictures {
            size: UVec2::new(160, 90),
            rows: 20,
        };
        let n = 14_400.0;
        // 2 ms of geometry, 10 ns of visibility; shading 20, 30, 40 ns by zone from the inside, at every fineness.
        let window = |zone: usize| match zone {
            0 => 20.0,
            1 => 0.25 * 20.0 + 0.75 * 30.0,
            _ => 0.25 * (0.25 * 20.0 + 0.75 * 30.0) + 0.75 * 40.0,
        };
        let mut ms = Vec::new();
        for zone in 0..3 {
            for _ in FINER {
                let bare = 2.0 + 10e-6 * n;
                ms.extend([bare + window(zone) * 1e-6 * n, bare]);
            }
        }
        ms.extend(VISIBILITY.map(|_| 2.0 + 4.0 * 10e-6 * n));
        let times: Vec<Measured> = ms
            .into_iter()
            .map(|ms| Measured {
                times_ms: vec![vec![ms]],
                ..Measured::default()
            })
            .collect();
        let probe = pictures.read(&times);
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
        let log_share = log(1.0 / 640.0);
        for (zone, ns) in [20.0, 30.0, 40.0].into_iter().enumerate() {
            close(probe.shading(zone, log_share), ns * 1e-6);
        }
        close(probe.visibility(log_share), 10e-6);
        close(probe.geometry(0.3, log_share), 2.0);
        close(probe.fineness(log_share), 1.0);
    }

    #[test]
    fn parts_of_an_image_stay_within_it() {
        let optics = Viewport::symmetric(UVec2::new(640, 360), 1.0).unwrap();
        let middle = narrowed(&optics, DVec3::NEG_Z, 2.0);
        assert!((middle[0] + 0.5).abs() < 1e-12 && (middle[1] - 0.5).abs() < 1e-12);
        let corner = narrowed(&optics, DVec3::new(-5.0, 3.0, -1.0), 4.0);
        assert!((corner[0] + 1.0).abs() < 1e-12 && (corner[1] + 0.5).abs() < 1e-12);
        assert!((corner[2] - 0.5625).abs() < 1e-12);
    }
}
