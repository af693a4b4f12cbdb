use std::ops::Range;

use foveasim_assets::Scene;
use foveasim_lanes::wide::WIDTH;
use foveasim_models::raster::{MovingPoint, MovingTriangle, Outline, Sampling};
use foveasim_models::{Pass, View, Work};
use glam::{DVec2, DVec3, UVec2};
use rayon::prelude::*;

use super::bins::TileBins;
use super::{Dropped, Outlines, Seen, Target};
use crate::kernels::lanes::Simd;
use crate::kernels::{FindBlocks, Kernel, Sixteen, TileBlocks, dispatch};
use crate::live::{Live, grid};
use crate::placed::PlacedTile;
use crate::placement::Placement;
use crate::raster::{EyeVertex, Object, SetUpTriangle, ViewGeometry, segments};
use crate::tile::{LaneSet, SampleTile, TILE, TileBuffers};
use crate::{Bound, RenderOptions};

/// All moving triangles of a pass that may be visible, in jobs.
#[derive(Debug)]
pub(crate) struct MovingTriangles {
    jobs: Vec<Job>,
    across: u32,
    /// Nothing nearer is drawn: the largest 1/w.
    pub(crate) nearest: f32,
}

#[derive(Debug)]
struct Job {
    targets: Vec<Target>,
    /// What a published bound leaves for each; empty for ours.
    outlines: Vec<Outline>,
    bins: TileBins,
}

/// What set-up needs to know of the pass.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MovingSetUp<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) view: &'a View,
    pub(crate) pass: &'a Pass,
    pub(crate) geometry: &'a ViewGeometry,
    pub(crate) placement: &'a Placement,
    pub(crate) live: &'a Live<'a>,
    pub(crate) options: &'a RenderOptions,
}

/// Sets up all triangles of `objects` (places in the view's list) that may cover a sample.
pub(crate) fn set_up_moving(pass: &MovingSetUp<'_>, objects: &[u32]) -> (MovingTriangles, Work) {
    let size = grid(pass.pass);
    let across = size.x.div_ceil(TILE);
    let count = (across * size.y.div_ceil(TILE)) as usize;
    let tiles = pass.tiles(across, count);
    let outlined = pass.options.bound.filter(|bound| bound.is_outlined());
    let bounds: Vec<_> = tiles.iter().map(Sixteen::image_bounds).collect();
    let groups: Vec<_> = bounds.chunks(WIDTH).map(Sixteen::of_boxes).collect();
    let warp = pass.placement.warp();
    let seen = Seen {
        around: &around(&bounds),
        scan: warp.and_then(|warp| warp.image_scan(pass.view.optics.size)),
        // What published bounds test is counted as published.
        grid: warp
            .filter(|_| outlined.is_none())
            .and_then(|_| pass.placement.even()),
    };
    let sampling = outlined.map(|bound| {
        let sampling = Sampling {
            scan: pass.placement.warp().and_then(|w| w.scan),
            ..pass.view.sampling(pass.pass.map)
        };
        (bound, sampling)
    });
    let results: Vec<_> = segments(pass.scene, pass.geometry, objects)
        .into_par_iter()
        .map(|segments| {
            let mut kernel = SetUpJob {
                pass,
                sampling,
                tiles: &tiles,
                groups: &groups,
                seen,
                across,
                count,
                segments: segments.into_iter().map(|s| (s.object, s.range)).collect(),
                targets: Vec::new(),
                outlines: Vec::new(),
                pairs: Vec::new(),
                work: Work::default(),
            };
            dispatch(pass.options.simd, &mut kernel);
            let job = Job {
                bins: TileBins::new(&kernel.pairs, count),
                targets: kernel.targets,
                outlines: kernel.outlines,
            };
            (job, kernel.work)
        })
        .collect();
    let mut total = Work::default();
    let mut jobs = Vec::with_capacity(results.len());
    for (job, work) in results {
        total += work;
        jobs.push(job);
    }
    let triangles = MovingTriangles {
        jobs,
        across,
        nearest: (1.0 / pass.options.near_m) as f32,
    };
    (triangles, total)
}

impl MovingSetUp<'_> {
    /// What the samples of each tile look at, sixteen tiles at a time.
    fn tiles(&self, across: u32, count: usize) -> Vec<Sixteen> {
        let simd = self.options.simd;
        let scratch = || (TileBuffers::new(1), self.placement.room(), TileBlocks::NONE);
        let found: Vec<Sixteen> = (0..count as u32)
            .into_par_iter()
            .map_init(scratch, |(buffers, placed, blocks), index| {
                let tile = SampleTile::of(self.pass, index % across, index / across);
                if !buffers.clear(&tile, self.live, &mut Work::default()) {
                    return Sixteen::NONE;
                }
                if let Some(places) = self.placement.even() {
                    return Sixteen::even_tile(&places, tile.origin);
                }
                self.placement.place(&tile, simd, placed);
                find_blocks(placed, &buffers.valid, blocks, simd);
                blocks.tile.clone()
            })
            .collect();
        let mut tiles = vec![Sixteen::NONE; count.div_ceil(WIDTH)];
        for (index, tile) in found.iter().enumerate() {
            if tile.is_live() {
                tiles[index / WIDTH].put(index % WIDTH, tile, 0);
            }
        }
        tiles
    }
}

/// The bounds around others, least and greatest along x and y; an empty range if there are none.
fn around(all: &[[[f32; 2]; 2]]) -> [[f32; 2]; 2] {
    let mut bounds = [[f32::MAX, f32::MIN]; 2];
    for one in all {
        for (bounds, [low, high]) in bounds.iter_mut().zip(one) {
            *bounds = [bounds[0].min(*low), bounds[1].max(*high)];
        }
    }
    bounds
}

/// Finds the blocks of a tile that was placed.
pub(crate) fn find_blocks(
    placed: &PlacedTile,
    valid: &[LaneSet],
    out: &mut TileBlocks,
    simd: crate::Simd,
) {
    let kernel = FindBlocks {
        at: &placed.at,
        time: &placed.time,
        valid,
        out,
    };
    dispatch(simd, kernel);
}

impl MovingTriangles {
    /// A triangle by its name.
    pub(crate) fn target(&self, [job, place]: [u32; 2]) -> &Target {
        &self.jobs[job as usize].targets[place as usize]
    }

    /// The names of triangles that may cover a sample of the tile, in the order they were set up, and for the rest of the
    /// renderer what stands for them; what a published bound leaves of it, if one is used.
    pub(crate) fn tile(
        &self,
        tile: &SampleTile,
        valid: &[LaneSet],
        targets: &mut Vec<[u32; 2]>,
        named: &mut Vec<SetUpTriangle>,
        outlines: &mut Outlines,
    ) {
        let place = tile.origin / TILE;
        let index = (place.y * self.across + place.x) as usize;
        targets.clear();
        outlines.clear();
        for (number, job) in self.jobs.iter().enumerate() {
            for &place in job.bins.tile(index) {
                targets.push([number as u32, place]);
                if let Some(outline) = job.outlines.get(place as usize) {
                    outlines.push(outline, tile.origin, valid);
                }
            }
        }
        named.clear();
        named.extend(targets.iter().map(|name| {
            let t = self.target(*name);
            SetUpTriangle {
                // Only names are read.
                corners: [[0, 0], [0, 256], [256, 0]],
                depth: [0.0; 3],
                depth_range: [0.0; 2],
                bounds: [[0; 2]; 2],
                is_small: true,
                is_whole: true,
                object: t.object,
                triangle: t.triangle,
            }
        }));
    }
}

/// Sets up the triangles of one job and finds the tiles that they may meet.
struct SetUpJob<'a> {
    pass: &'a MovingSetUp<'a>,
    sampling: Option<(Bound, Sampling)>,
    tiles: &'a [Sixteen],
    /// Where any sample of sixteen tiles looks, sixteen times.
    groups: &'a [Sixteen],
    seen: Seen<'a>,
    across: u32,
    count: usize,
    segments: Vec<(u32, Range<usize>)>,
    targets: Vec<Target>,
    outlines: Vec<Outline>,
    /// Tile and triangle.
    pairs: Vec<[u32; 2]>,
    work: Work,
}

impl Kernel for &mut SetUpJob<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        for (object, range) in std::mem::take(&mut self.segments) {
            let MovingSetUp {
                scene,
                geometry,
                options,
                ..
            } = *self.pass;
            let place = geometry.objects[object as usize];
            let corners = Corners::new(self.pass, &place);
            let both_faces =
                !options.skip.back_faces || scene.instances()[place.instance as usize].two_sided;
            let triangles = scene.meshes()[place.mesh as usize].triangles();
            self.work.triangles += range.len() as u64;
            for index in range {
                let moving = corners.triangle(triangles[index]);
                let names = [object, index as u32];
                match Target::set_up(&moving, options.near_m, &self.seen, both_faces, names) {
                    Err(Dropped::Outside) => self.work.triangles_outside += 1,
                    Err(Dropped::BackFacing) => self.work.triangles_back_facing += 1,
                    Ok(target) => self.keep(simd, target, &moving),
                }
            }
        }
    }
}

impl SetUpJob<'_> {
    #[inline(always)]
    fn keep<S: Simd>(&mut self, simd: S, target: Target, moving: &MovingTriangle) {
        let (place, before) = (self.targets.len() as u32, self.pairs.len());
        match &self.sampling {
            None => {
                for (sixteen, groups) in self.groups.iter().enumerate() {
                    let mut of_sixteen = groups.meets(simd, &target);
                    while of_sixteen != 0 {
                        let group = sixteen * WIDTH + of_sixteen.trailing_zeros() as usize;
                        of_sixteen &= of_sixteen - 1;
                        let mut met = self.tiles[group].may_cover(simd, &target);
                        while met != 0 {
                            let tile = group * WIDTH + met.trailing_zeros() as usize;
                            met &= met - 1;
                            self.pairs.push([tile as u32, place]);
                        }
                    }
                }
            }
            Some((bound, sampling)) => {
                let outline = bound.outline(moving, sampling);
                self.tiles_of(&outline, place);
                if self.pairs.len() > before {
                    self.outlines.push(outline);
                }
            }
        }
        if self.pairs.len() == before {
            self.work.triangles_outside += 1;
            return;
        }
        self.work.triangles_set_up += 1;
        self.targets.push(target);
    }

    /// The tiles that the box around an outline meets.
    #[inline(never)]
    fn tiles_of(&mut self, outline: &Outline, place: u32) {
        let tiles = UVec2::new(self.across, self.count as u32 / self.across);
        let (first, end) = match outline {
            Outline::Nothing => return,
            Outline::Polygon(corners) => {
                let side = f64::from(TILE);
                let low = corners.iter().fold(DVec2::INFINITY, |m, p| m.min(*p)) / side;
                let high = corners.iter().fold(DVec2::NEG_INFINITY, |m, p| m.max(*p)) / side;
                let within = |p: DVec2| p.clamp(DVec2::ZERO, tiles.as_dvec2());
                (
                    within(low).floor().as_uvec2(),
                    within(high).ceil().as_uvec2(),
                )
            }
            _ => (UVec2::ZERO, tiles),
        };
        for y in first.y..end.y {
            for x in first.x..end.x {
                self.pairs.push([y * self.across + x, place]);
            }
        }
    }
}

/// The corners of an object's triangles in homogeneous pixels.
pub(crate) struct Corners<'a> {
    vertices: [&'a [EyeVertex]; 2],
    px_per_tan: DVec2,
    axis: DVec2,
}

impl<'a> Corners<'a> {
    pub(crate) fn new(pass: &MovingSetUp<'a>, object: &Object) -> Self {
        let vertices = pass.geometry.of(object, pass.scene);
        let step = pass.view.optics.pixel_tan();
        Self {
            vertices: [vertices, pass.geometry.at_end(object, pass.scene)],
            px_per_tan: DVec2::new(1.0 / step.x, -1.0 / step.y),
            axis: pass.view.optics.axis_px(),
        }
    }

    fn point(&self, v: &EyeVertex) -> DVec3 {
        let [x, y, w] = v.eye.map(f64::from);
        let px = DVec2::new(x, y) * self.px_per_tan + self.axis * w;
        px.extend(w)
    }

    /// A triangle from the scan's start to its end.
    pub(crate) fn triangle(&self, corners: [u32; 3]) -> MovingTriangle {
        MovingTriangle(corners.map(|i| {
            let [start, end] = self.vertices.map(|v| self.point(&v[i as usize]));
            MovingPoint { start, end }
        }))
    }
}
