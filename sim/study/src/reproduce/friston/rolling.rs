use std::time::Duration;

use foveasim_models::foveation::Method;
use foveasim_models::{Image, Pose, SamplePlan, ScanSkew, View};
use foveasim_quality::compare;
use foveasim_render::{
    Bound, GridWarp, RenderOptions, Seen, Skip, Warped, bound_counts, inverse_depths, visibility,
};
use foveasim_reports::{Cell, LineChart, LineSeries, Table};
use glam::{DQuat, DVec2, DVec3};

use super::place::Place;
use super::timing::{FrameTime, pair};
use super::{Friston2019Outcome, ReproduceError};
use crate::kernel::median;

/// How alike an image is to what it should be, but for the pixels that are marked.
type Judge<'a> = dyn Fn(&Image, Option<&[bool]>) -> Result<f64, ReproduceError> + 'a;

/// One way to show a frame on a display that scans from left to right while the head moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum RollingWay {
    /// Drawn as it is when the scan begins.
    Common,
    /// The same, moved by its depths to where the head is in the middle of the scan.
    WarpedToMiddle,
    /// The same, moved by its depths to where the head is when each place lights.
    Warped,
    /// Drawn as each place lights, with a bound of moving triangles.
    Rolling(Bound),
    /// The same with the conservative bound, shaded as when the scan begins.
    WithoutRollingShading,
}

/// One way on one scene.
#[derive(Debug, Clone, PartialEq)]
pub struct RollingRow {
    /// The scene.
    pub scene: String,
    /// The way.
    pub way: RollingWay,
    /// The method as drawn: full resolution, or magnified.
    pub method: Method,
    /// By how much the head turns during the scan \[deg\].
    pub turn_deg: f64,
    /// Time of visibility, reconstruction and warping \[ms\].
    pub raster_ms: f64,
    /// Time of shading \[ms\].
    pub shading_ms: f64,
    /// Time of a frame over that of common rasterization at full resolution, the median of paired rounds.
    pub over_common: f64,
    /// Samples covered over samples tested, nothing hidden left out.
    pub efficiency: f64,
    /// Samples that triangles cover and the bound leaves out.
    pub missed: Option<u64>,
    /// SSIM against what the display should show: over what is not disoccluded of the whole image, or, of magnified
    /// ones, of the fovea against many samples to the pixel.
    pub ssim: f64,
    /// Share of the pixels that a warp knows nothing of.
    pub disoccluded: Option<f64>,
}

/// How long the scan takes \[s\].
const SCAN_S: f64 = 1.0 / 90.0;
/// How far the head moves to the right meanwhile \[m\].
const SWAY_M: f64 = 0.02;

impl RollingWay {
    /// All of them, in the order of the figure; the first is what times are compared with.
    pub const ALL: [Self; 8] = [
        Self::Common,
        Self::WarpedToMiddle,
        Self::Warped,
        Self::Rolling(Bound::Box),
        Self::Rolling(Bound::Simple),
        Self::Rolling(Bound::Adaptive),
        Self::Rolling(Bound::Conservative),
        Self::WithoutRollingShading,
    ];

    /// Those of Fig. 13.
    pub const FEW: [Self; 3] = [
        Self::Common,
        Self::Warped,
        Self::Rolling(Bound::Conservative),
    ];

    /// Its name.
    pub fn name(self) -> String {
        match self {
            Self::Common => "common".into(),
            Self::WarpedToMiddle => "warped to the middle".into(),
            Self::Warped => "warped".into(),
            Self::Rolling(bound) => format!("rolling, {}", bound.name()),
            Self::WithoutRollingShading => "rolling, shading not".into(),
        }
    }

    fn options(self) -> RenderOptions {
        RenderOptions {
            bound: match self {
                Self::Rolling(bound) => Some(bound),
                _ => None,
            },
            rolling_shading: self != Self::WithoutRollingShading,
            ..RenderOptions::default()
        }
    }

    fn is_rolling(self) -> bool {
        matches!(self, Self::Rolling(_) | Self::WithoutRollingShading)
    }
}

/// A place on a rolling display while the head turns.
pub(super) struct Scanned<'a> {
    place: &'a Place,
    scan: ScanSkew,
    turn_deg: f64,
    poses: [Pose; 2],
    rolling: View,
}

impl<'a> Scanned<'a> {
    pub(super) fn new(place: &'a Place, turn_deg: f64) -> Result<Self, ReproduceError> {
        let start = place.view.poses[0];
        let turn = DQuat::from_axis_angle(DVec3::Y, -foveasim_models::math::to_rad(turn_deg));
        let end = Pose::new(
            start.position + start.direction(DVec3::X) * SWAY_M,
            (turn * start.orientation).normalize(),
        );
        let scan = ScanSkew::new(DVec2::X)?;
        Ok(Self {
            place,
            scan,
            turn_deg,
            poses: [start, end],
            rolling: View::rolling(place.view.eye, place.view.optics, [start, end], scan),
        })
    }

    /// The scene as a scan takes it, and the same with nothing to shade.
    fn scenes(&self) -> [foveasim_assets::Scene; 2] {
        [&self.place.world, &self.place.bare].map(|scene| scene.over([0.0, SCAN_S]))
    }

    /// What is drawn at the start of the scan, moved to where it is seen.
    fn warp(&self, image: &Image, way: RollingWay) -> Result<Warped, ReproduceError> {
        let plan = SamplePlan::full(self.place.view.eye, self.place.view.optics.size);
        let options = RenderOptions::default();
        let seen = visibility(&self.place.world, &self.place.view, &plan, 0, &options)?;
        Ok(self.grid(way).apply(image, &inverse_depths(&seen))?)
    }

    fn grid(&self, way: RollingWay) -> GridWarp<'_> {
        let [start, end] = self.poses;
        GridWarp {
            optics: &self.place.view.optics,
            drawn: start,
            seen: match way {
                RollingWay::WarpedToMiddle => Seen::At(start.interpolate(end, 0.5)),
                _ => Seen::Rolling(self.poses, &self.scan),
            },
            longest_px: GridWarp::LONGEST_PX,
        }
    }

    /// What the display should show.
    fn reference(&self) -> Result<Image, ReproduceError> {
        let plan = SamplePlan::full(self.rolling.eye, self.rolling.optics.size);
        let [world, _] = self.scenes();
        let options = RollingWay::Rolling(Bound::Conservative).options();
        Ok(foveasim_render::render(&world, &self.rolling, &plan, &options)?.image)
    }

    /// Three images beside each other: drawn at the start, warped with gaps in grey squares, rolling.
    pub(super) fn pictures(&self) -> Result<[Image; 3], ReproduceError> {
        let plan = SamplePlan::full(self.rolling.eye, self.rolling.optics.size);
        let options = RenderOptions::default();
        let common =
            foveasim_render::render(&self.place.world, &self.place.view, &plan, &options)?.image;
        let Warped {
            mut image,
            disoccluded,
            ..
        } = self.warp(&common, RollingWay::Warped)?;
        let width = image.size.x as usize;
        for (k, (rgb, gone)) in image.rgb.iter_mut().zip(&disoccluded).enumerate() {
            if *gone {
                let light = (k % width / 8 + k / width / 8).is_multiple_of(2);
                *rgb = [if light { 0.3 } else { 0.1 }; 3];
            }
        }
        Ok([common, image, self.reference()?])
    }

    /// Of each sample, the share of its tests that hit, bound by bound: dark is wasteful (Fig. 15).
    pub(super) fn efficiency(&self) -> Result<Vec<(Bound, Image)>, ReproduceError> {
        let plan = SamplePlan::full(self.rolling.eye, self.rolling.optics.size);
        let [world, _] = self.scenes();
        let bounds = [
            Bound::Box,
            Bound::Simple,
            Bound::Adaptive,
            Bound::Conservative,
        ];
        let picture = |bound: Bound| -> Result<(Bound, Image), ReproduceError> {
            let options = RenderOptions {
                skip: Skip {
                    occluded: false,
                    ..Skip::ALL
                },
                ..RenderOptions::default()
            };
            let counts = bound_counts(&world, &self.rolling, &plan, 0, bound, &options)?;
            let mut image = Image::filled(counts.lattice, [0.0; 3]);
            let samples = counts.covered.iter().zip(&counts.tested);
            for (rgb, (covered, tested)) in image.rgb.iter_mut().zip(samples) {
                // What nothing was tested for is blue.
                *rgb = match *tested {
                    0 => [0.02, 0.04, 0.15],
                    _ => [*covered as f32 / *tested as f32; 3],
                };
            }
            Ok((bound, image))
        };
        bounds.into_iter().map(picture).collect()
    }

    /// Every one of `ways` at full resolution.
    pub(super) fn measure(
        &self,
        ways: &[RollingWay],
        rounds: u32,
        clock: &mut dyn FnMut() -> Duration,
    ) -> Result<Vec<RollingRow>, ReproduceError> {
        let reference = self.reference()?;
        let judge = |image: &Image, gone: Option<&[bool]>| likeness(image, &reference, gone);
        self.rows(ways, Method::Full, rounds, clock, &judge)
    }

    /// The ways that foveate, too, by `method`; common rasterization stays what times are compared with.
    pub(super) fn measure_magnified(
        &self,
        method: Method,
        rounds: u32,
        clock: &mut dyn FnMut() -> Duration,
        reference_samples: u32,
    ) -> Result<Vec<RollingRow>, ReproduceError> {
        let [world, _] = self.scenes();
        let reference = self
            .place
            .foveal_rolling(&world, &self.rolling, reference_samples)?;
        let judge = |image: &Image, _: Option<&[bool]>| {
            Ok(compare(&self.place.fovea_of(image), &reference)?.whole.ssim)
        };
        let ways = [
            RollingWay::Common,
            RollingWay::Rolling(Bound::Box),
            RollingWay::Rolling(Bound::Simple),
            RollingWay::Rolling(Bound::Adaptive),
            RollingWay::Rolling(Bound::Conservative),
        ];
        self.rows(&ways, method, rounds, clock, &judge)
    }

    fn rows(
        &self,
        ways: &[RollingWay],
        method: Method,
        rounds: u32,
        clock: &mut dyn FnMut() -> Duration,
        judge: &Judge<'_>,
    ) -> Result<Vec<RollingRow>, ReproduceError> {
        let scenes = self.scenes();
        let mut all: Vec<Found> = Vec::new();
        for way in ways {
            let method = if way.is_rolling() {
                method
            } else {
                Method::Full
            };
            all.push(Found {
                plan: self.place.plan(method)?,
                method,
                times: Vec::new(),
                ssim: f64::NAN,
                disoccluded: None,
            });
        }
        for _ in 0..rounds {
            for (way, found) in ways.iter().zip(&mut all) {
                found.round(*way, self, &scenes, clock, judge)?;
            }
        }
        let common = all[0].times.clone();
        let counted = ways.iter().zip(&all);
        let counts = counted
            .map(|(way, found)| self.counts(*way, &found.plan, &scenes[0]))
            .collect::<Result<Vec<_>, _>>()?;
        let whole = ways
            .iter()
            .position(|way| *way == RollingWay::Rolling(Bound::Conservative))
            .map(|k| counts[k][1]);
        let row =
            |((way, found), [tested, covered]): ((&RollingWay, &Found), &[u64; 2])| RollingRow {
                scene: self.place.scene.to_string(),
                way: *way,
                method: found.method,
                turn_deg: self.turn_deg,
                raster_ms: median(found.times.iter().map(|t| t.bare)),
                shading_ms: median(found.times.iter().map(|t| t.shading())),
                over_common: median(
                    found
                        .times
                        .iter()
                        .zip(&common)
                        .map(|(t, c)| t.frame / c.frame),
                ),
                efficiency: *covered as f64 / (*tested).max(1) as f64,
                missed: match way {
                    RollingWay::Rolling(_) => whole.map(|all| all.saturating_sub(*covered)),
                    _ => None,
                },
                ssim: found.ssim,
                disoccluded: found.disoccluded,
            };
        Ok(ways.iter().zip(&all).zip(&counts).map(row).collect())
    }

    /// Samples tested and covered with nothing left out for being hidden.
    fn counts(
        &self,
        way: RollingWay,
        plan: &SamplePlan,
        world: &foveasim_assets::Scene,
    ) -> Result<[u64; 2], ReproduceError> {
        let options = RenderOptions {
            skip: Skip {
                occluded: false,
                ..Skip::ALL
            },
            ..way.options()
        };
        let work = match way.is_rolling() {
            true => foveasim_render::render(world, &self.rolling, plan, &options)?.work,
            false => {
                foveasim_render::render(&self.place.world, &self.place.view, plan, &options)?.work
            }
        };
        Ok([work.samples_tested, work.samples_covered])
    }
}

/// What the rounds of one way have found.
struct Found {
    method: Method,
    plan: SamplePlan,
    times: Vec<FrameTime>,
    ssim: f64,
    disoccluded: Option<f64>,
}

impl Found {
    fn round(
        &mut self,
        way: RollingWay,
        scanned: &Scanned<'_>,
        scenes: &[foveasim_assets::Scene; 2],
        clock: &mut dyn FnMut() -> Duration,
        judge: &Judge<'_>,
    ) -> Result<(), ReproduceError> {
        let place = scanned.place;
        let still = [&place.world, &place.bare];
        let rolling = scenes.each_ref();
        let (view, scenes) = match way.is_rolling() {
            true => (&scanned.rolling, rolling),
            false => (&place.view, still),
        };
        let (frame, mut time) = pair(scenes, view, &self.plan, &way.options(), clock)?;
        let first = self.times.is_empty();
        if matches!(way, RollingWay::Warped | RollingWay::WarpedToMiddle) {
            // Depths come with a frame; that they are asked for again here is not its time.
            let seen = visibility(&place.world, &place.view, &self.plan, 0, &way.options())?;
            let depths = inverse_depths(&seen);
            let began = clock();
            let warped = scanned.grid(way).apply(&frame.image, &depths)?;
            let took = clock().saturating_sub(began).as_secs_f64() * 1e3;
            time = FrameTime {
                frame: time.frame + took,
                bare: time.bare + took,
            };
            if first {
                let gone = warped.disoccluded.iter().filter(|gone| **gone).count();
                self.disoccluded = Some(gone as f64 / warped.disoccluded.len() as f64);
                self.ssim = judge(&warped.image, Some(&warped.disoccluded))?;
            }
        } else if first {
            self.ssim = judge(&frame.image, None)?;
        }
        self.times.push(time);
        Ok(())
    }
}

/// SSIM over the pixels that are known. What is not known is taken from the reference, so that it tells nothing of those
/// around: no hole filling could do better (Friston 2019, §5.2).
fn likeness(
    image: &Image,
    reference: &Image,
    gone: Option<&[bool]>,
) -> Result<f64, ReproduceError> {
    let Some(gone) = gone else {
        return Ok(compare(image, reference)?.whole.ssim);
    };
    let mut filled = image.clone();
    for (k, rgb) in filled.rgb.iter_mut().enumerate() {
        if gone[k] {
            *rgb = reference.rgb[k];
        }
    }
    let found = compare(&filled, reference)?;
    let known = found.ssim_map.values().iter().zip(gone);
    let values: Vec<f64> = known.filter(|(_, gone)| !**gone).map(|(v, _)| *v).collect();
    Ok(foveasim_models::math::mean(&values))
}

impl Friston2019Outcome {
    /// Rows of rolling displays as a table.
    pub(super) fn table_of(rows: &[RollingRow]) -> Table {
        let mut table = Table::new([
            "scene",
            "turn_deg",
            "way",
            "method",
            "raster_ms",
            "shading_ms",
            "total_ms",
            "over_common",
            "sample_test_efficiency",
            "missed_samples",
            "ssim",
            "disoccluded_share",
        ]);
        for r in rows {
            table.push(vec![
                r.scene.as_str().into(),
                r.turn_deg.into(),
                r.way.name().into(),
                r.method.to_string().into(),
                r.raster_ms.into(),
                r.shading_ms.into(),
                (r.raster_ms + r.shading_ms).into(),
                r.over_common.into(),
                r.efficiency.into(),
                r.missed.map_or(Cell::Empty, Cell::from),
                r.ssim.into(),
                r.disoccluded.map_or(Cell::Empty, Cell::from),
            ]);
        }
        table
    }

    /// Fig. 13 over the head's turn: of one scene, a line for each way.
    pub(super) fn turn_chart(
        rows: &[RollingRow],
        title: &str,
        y_label: &str,
        pick: impl Fn(&RollingRow) -> f64,
    ) -> LineChart {
        let line = |way: &RollingWay| LineSeries {
            label: way.name(),
            points: rows
                .iter()
                .filter(|r| r.way == *way)
                .map(|r| [r.turn_deg, pick(r)])
                .collect(),
        };
        LineChart {
            title: title.into(),
            x_label: "turn of the head during the scan [deg]".into(),
            y_label: y_label.into(),
            series: RollingWay::FEW.iter().map(line).collect(),
            ..LineChart::default()
        }
    }
}
