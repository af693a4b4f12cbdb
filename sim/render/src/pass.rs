mod count;
mod share;
mod surfel;

pub(crate) use count::count_tests;
pub(crate) use share::find_shared;
pub(crate) use surfel::check_position;
pub use surfel::{Surfel, visibility, visibility_at};

use foveasim_assets::Scene;
use foveasim_models::{
    Affine, Image, Map, Msaa, Pass, Resolve, SamplePlan, View, Visibility, Work,
};
use glam::UVec2;
use rayon::prelude::*;

use crate::fragments::{Collect, Fragments, Rates};
use crate::kernels::{
    Attributes, Details, EdgeSample, RasterizeMoving, RasterizePlaced, RasterizeTile, Rolling,
    ShadeContext, ShadeTile, TileBlocks, dispatch,
};
use crate::live::{Live, grid, live_box};
use crate::moving::{
    Counts, MovingAttributes, MovingSetUp, MovingTriangles, Outlines, Target, find_blocks,
    set_up_moving,
};
use crate::msaa::offsets;
use crate::occlusion::occlude;
use crate::placed::PlacedTile;
use crate::placement::Placement;
use crate::project::{Projection, SUBSAMPLES};
use crate::raster::{
    EyeVertex, Needs, PassTriangles, SetUp, SetUpTriangle, ViewGeometry, attributes, details,
    set_up, vertices, vertices_at_end,
};
use crate::shadow::Illumination;
use crate::shared::{LookUp, SharedVisibility};
use crate::tile::{
    BLOCK, LANES, LaneSet, SampleTile, TILE, TILE_SAMPLES, TileBuffers, position_of, sampled,
};
use crate::visible::PassObjects;
use crate::{FrameMemory, RenderOptions};

/// At how many positions of each sample visibility is found in pass `index`, or in the pass it shares.
pub(crate) fn msaa(plan: &SamplePlan, index: usize) -> Msaa {
    let finder = match plan.passes[index].visibility {
        Visibility::Shared(other) => other,
        _ => index,
    };
    match plan.passes[finder].visibility {
        Visibility::Own(msaa) => msaa,
        _ => unreachable!("only what its own pass finds passes the checks"),
    }
}

/// The drawn samples of a pass, row by row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PassSamples {
    /// Colours.
    pub(crate) image: Image,
    /// 1/w of what is seen [1/m], 0 for the sky, NaN where nothing is drawn; empty unless geometry is
    /// kept. With several positions of visibility, at the first.
    pub(crate) inverse_w: Vec<f32>,
    /// Index of the instance that is seen, `u32::MAX` for the sky; empty unless geometry is kept.
    pub(crate) instance: Vec<u32>,
    /// Whether there is no sample where nothing is drawn.
    pub(crate) all_drawn: bool,
}

impl PassSamples {
    /// Of a pass that is not shaded.
    pub(crate) const NONE: Self = Self {
        image: Image {
            size: UVec2::ZERO,
            rgb: Vec::new(),
        },
        inverse_w: Vec::new(),
        instance: Vec::new(),
        all_drawn: true,
    };
}

/// Draws pass `index` of a plan: what each of its samples sees, and the work it took.
pub(crate) fn draw(
    scene: &Scene,
    view: &View,
    plan: &SamplePlan,
    index: usize,
    geometry: &ViewGeometry,
    objects: &PassObjects,
    options: &RenderOptions,
    keep_geometry: bool,
    shared: Option<&SharedVisibility>,
    illumination: &Illumination,
    memory: &mut FrameMemory,
) -> (PassSamples, Work) {
    let pass = &plan.passes[index];
    let size = grid(pass);
    let count = size.x as usize * size.y as usize;
    if count == 0 {
        let nothing = PassSamples {
            image: Image {
                size,
                rgb: Vec::new(),
            },
            ..PassSamples::NONE
        };
        return (nothing, Work::default());
    }
    let drawing = Drawing::new(scene, view, plan, index, geometry, objects, options, shared);
    let all_drawn = drawing.live.is_all();
    let occlusion = options.lighting.occlusion;
    let kept = count * usize::from(keep_geometry || occlusion.is_some());
    // These look up nothing but what is live.
    let by_owner = matches!(plan.resolve, Resolve::Inverse(_) | Resolve::Mosaic);
    let dead_are_read = options.keep_passes || !by_owner;
    let mut samples = PassSamples {
        image: Image {
            size,
            rgb: match all_drawn || !dead_are_read {
                true => memory.rgb.any(count, [0.0; 3]),
                false => memory.rgb.filled(count, [0.0; 3]),
            },
        },
        inverse_w: match all_drawn {
            true => memory.reals.any(kept, f32::NAN),
            false => memory.reals.filled(kept, f32::NAN),
        },
        instance: match all_drawn {
            true => memory.names.any(kept, u32::MAX),
            false => memory.names.filled(kept, u32::MAX),
        },
        all_drawn,
    };
    let context = ShadeContext::new(scene, view.poses[0], &drawing.projection, options.footprint)
        .with_rolling(drawing.rolling(view))
        .with_illumination(illumination);
    let mut work = drawing.work;
    work.passes = 1;

    // Each tile gets its own part of every image row it crosses.
    let mut jobs: Vec<_> = tiles(size)
        .map(|place| (place, Vec::new(), Vec::new()))
        .collect();
    let across = size.x.div_ceil(TILE) as usize;
    for (y, row) in samples.image.rgb.chunks_mut(size.x as usize).enumerate() {
        let first = y / TILE as usize * across;
        for (x, part) in row.chunks_mut(TILE as usize).enumerate() {
            jobs[first + x].1.push(part);
        }
    }
    let geometry_rows = samples
        .inverse_w
        .chunks_mut(size.x as usize)
        .zip(samples.instance.chunks_mut(size.x as usize));
    for (y, (depths, instances)) in geometry_rows.enumerate() {
        let first = y / TILE as usize * across;
        let parts = depths.chunks_mut(TILE as usize);
        for (x, part) in parts.zip(instances.chunks_mut(TILE as usize)).enumerate() {
            jobs[first + x].2.push(part);
        }
    }
    let works: Vec<Work> = jobs
        .into_par_iter()
        .map_init(
            || Scratch::new(&drawing),
            |scratch, ((x, y), mut rows, mut geometry)| {
                let tile = SampleTile {
                    map: drawing.map,
                    ..SampleTile::of(pass, x, y)
                };
                let work = drawing.draw_tile(&context, &tile, &mut rows, scratch);
                drawing.copy_geometry(scratch, &mut geometry);
                work
            },
        )
        .collect();
    for tile in works {
        work += tile;
    }
    if let Some(occlusion) = occlusion {
        work += occlude(&mut samples, pass, view, occlusion);
        if !keep_geometry {
            memory.reals.give(std::mem::take(&mut samples.inverse_w));
            memory.names.give(std::mem::take(&mut samples.instance));
        }
    }
    (samples, work)
}

/// Column and row of each tile, row by row.
fn tiles(size: UVec2) -> impl Iterator<Item = (u32, u32)> {
    let across = size.x.div_ceil(TILE);
    (0..size.y.div_ceil(TILE)).flat_map(move |y| (0..across).map(move |x| (x, y)))
}

/// Everything about a pass that its tiles share.
struct Drawing<'a> {
    scene: &'a Scene,
    options: &'a RenderOptions,
    geometry: &'a ViewGeometry,
    projection: Projection,
    msaa: Msaa,
    rates: Rates<'a>,
    live: Live<'a>,
    source: Source<'a>,
    /// Where samples are, if they do not lie evenly.
    placement: Option<&'a Placement>,
    grid: UVec2,
    /// From what shading is told of samples' positions to the display.
    map: Map,
    /// For each material, what it reads of a triangle.
    needs: Vec<Needs>,
    /// Whether anything may read a triangle's details.
    has_details: bool,
    work: Work,
}

/// Where visibility comes from.
enum Source<'a> {
    /// These triangles.
    Own(PassTriangles),
    /// These, which move, or are seen through a lens.
    Moving(MovingTriangles),
    /// A pass drawn before.
    Shared(&'a SharedVisibility),
}

/// Memory that a worker uses for one tile after the other.
struct Scratch {
    buffers: TileBuffers,
    placed: Option<PlacedTile>,
    look_up: LookUp,
    /// Numbers of the triangles, where a later pass shares what is visible.
    numbers: Vec<u32>,
    /// Those that meet the tile.
    triangles: Vec<SetUpTriangle>,
    fragments: Fragments,
    /// Vertices of those that are visible.
    corners: Vec<[EyeVertex; 3]>,
    attributes: Vec<Attributes>,
    details: Vec<Details>,
    edges: Vec<EdgeSample>,
    /// For each slot, the instance that is seen.
    instances: Vec<u32>,
    /// Of passes in which triangles move.
    moving: Option<Box<MovingScratch>>,
}

/// What a worker needs besides where triangles move.
struct MovingScratch {
    blocks: TileBlocks,
    /// The names of those that meet the tile.
    targets: Vec<[u32; 2]>,
    outlines: Outlines,
    /// Of the visible.
    attributes: Vec<MovingAttributes>,
    /// Where tests are counted one by one.
    counts: Option<Counts>,
}

impl Scratch {
    fn new(drawing: &Drawing<'_>) -> Self {
        Self {
            buffers: TileBuffers::new(drawing.msaa.positions() as usize),
            placed: drawing.placement.map(Placement::room),
            look_up: LookUp::default(),
            numbers: Vec::new(),
            triangles: Vec::new(),
            fragments: Fragments::new(drawing.scene.materials().len()),
            corners: Vec::new(),
            attributes: Vec::new(),
            details: Vec::new(),
            edges: Vec::new(),
            instances: Vec::new(),
            moving: match drawing.source {
                Source::Moving(_) => Some(Box::new(MovingScratch {
                    blocks: TileBlocks::NONE,
                    targets: Vec::new(),
                    outlines: Outlines::default(),
                    attributes: Vec::new(),
                    counts: None,
                })),
                _ => None,
            },
        }
    }
}

/// The projection of a pass: onto the positions where its samples are taken, if these lie evenly; else onto
/// the display's own grid, on which they are then placed.
pub(crate) fn projection(view: &View, pass: &Pass, options: &RenderOptions) -> Projection {
    let (map, size) = match sampled(pass) {
        Map::Affine(map) => (map, grid(pass)),
        _ => (Affine::IDENTITY, view.optics.size),
    };
    Projection::new(&view.optics, &map, size, options.near_m)
}

/// How far from the middle of a sample of its [`projection`] visibility may be asked for in a pass
/// [sub-samples].
pub(crate) fn reach(pass: &Pass, msaa: Msaa) -> i32 {
    match pass.map {
        Map::Affine(_) => offsets::reach(msaa),
        _ => SUBSAMPLES / 2,
    }
}

impl<'a> Drawing<'a> {
    fn new(
        scene: &'a Scene,
        view: &'a View,
        plan: &'a SamplePlan,
        index: usize,
        geometry: &'a ViewGeometry,
        objects: &'a PassObjects,
        options: &'a RenderOptions,
        shared: Option<&'a SharedVisibility>,
    ) -> Self {
        let pass = &plan.passes[index];
        let finder = match pass.visibility {
            Visibility::Shared(other) => &plan.passes[other],
            _ => pass,
        };
        let warped = objects.placement.as_ref().filter(|p| p.warp().is_some());
        let projection = match warped {
            // Samples are where their placement says, in display pixels.
            Some(_) => Projection::new(
                &view.optics,
                &Affine::IDENTITY,
                view.optics.size,
                options.near_m,
            ),
            None => projection(view, finder, options),
        };
        let msaa = msaa(plan, index);
        let live = Live::new(plan, index, &view.optics, options.skip.hidden);
        let (source, work) = match (shared, warped) {
            (Some(shared), _) => (Source::Shared(shared), Work::default()),
            (None, Some(placement)) => {
                let pass_set_up = MovingSetUp {
                    scene,
                    view,
                    pass,
                    geometry,
                    placement,
                    live: &live,
                    options,
                };
                let order = objects.in_geometry(geometry);
                let (triangles, mut work) = set_up_moving(&pass_set_up, &order);
                work += objects.work;
                (Source::Moving(triangles), work)
            }
            (None, None) => {
                let pass_set_up = SetUp {
                    scene,
                    geometry,
                    projection: &projection,
                    options,
                    reach: reach(pass, msaa),
                    drawn: live_box(pass, projection.size, options),
                };
                let order = objects.in_geometry(geometry);
                let (triangles, mut work) = set_up(&pass_set_up, &order);
                work += objects.work;
                (Source::Own(triangles), work)
            }
        };
        let needs: Vec<_> = scene.materials().iter().map(Needs::of).collect();
        let rates = Rates::of(&pass.shading);
        Self {
            scene,
            options,
            geometry,
            projection,
            msaa,
            has_details: msaa != Msaa::One
                || rates.0.is_some()
                || needs.iter().any(|n| n.object || n.uv),
            rates,
            live,
            source,
            placement: objects.placement.as_ref(),
            grid: grid(pass),
            // Samples of another pass are where that one took them.
            map: match warped {
                Some(_) => Map::Affine(Affine::IDENTITY),
                None => sampled(finder),
            },
            needs,
            work,
        }
    }

    /// How the eye moves while its samples look, if they do so at times of their own.
    fn rolling(&self, view: &View) -> Option<Rolling> {
        let scan = self.placement.and_then(|p| p.warp()).and_then(|w| w.scan);
        scan.map(|_| Rolling::new(view.poses, self.options.rolling_shading))
    }

    /// What moving triangles show of a tile that was placed.
    fn find_moving(
        &self,
        tile: &SampleTile,
        source: &MovingTriangles,
        scratch: &mut Scratch,
        work: &mut Work,
    ) {
        let (Some(placed), Some(moving)) = (&scratch.placed, &mut scratch.moving) else {
            unreachable!("passes with moving triangles are placed")
        };
        let valid = &scratch.buffers.valid;
        source.tile(
            tile,
            valid,
            &mut moving.targets,
            &mut scratch.triangles,
            &mut moving.outlines,
        );
        if moving.targets.is_empty() {
            return;
        }
        let outlined = self.options.bound.is_some_and(|bound| bound.is_outlined());
        match self.placement.and_then(Placement::even) {
            _ if outlined => {}
            Some(places) => moving.blocks.find_even(&places, tile.origin, valid),
            None => find_blocks(placed, valid, &mut moving.blocks, self.options.simd),
        }
        if let Some(counts) = &mut moving.counts {
            counts.clear(valid.len(), moving.targets.len());
        }
        let targets: Vec<&Target> = moving.targets.iter().map(|t| source.target(*t)).collect();
        let kernel = RasterizeMoving {
            placed,
            blocks: &moving.blocks,
            triangles: &targets,
            outlines: outlined.then_some(&moving.outlines),
            objects: &self.geometry.objects,
            nearest: source.nearest,
            skip_occluded: self.options.skip.occluded,
            buffers: &mut scratch.buffers,
            counts: moving.counts.as_mut(),
            work,
        };
        dispatch(self.options.simd, kernel);
    }

    /// Place in the pass and in the buffers (first position) of each sample of a tile that is drawn.
    fn samples(
        &self,
        tile: &SampleTile,
        buffers: &TileBuffers,
    ) -> impl Iterator<Item = (usize, usize)> {
        let (origin, across) = (tile.origin, self.grid.x as usize);
        let positions = self.msaa.positions() as usize;
        (0..TILE_SAMPLES)
            .filter(|i| buffers.valid[i / LANES] >> (i % LANES) & 1 != 0)
            .map(move |i| {
                let [x, y] = position_of(i);
                let place = (origin.y + y) as usize * across + (origin.x + x) as usize;
                (place, i / LANES * LANES * positions + i % LANES)
            })
    }

    /// Whether anything of the tile is drawn.
    fn find_visible(&self, tile: &SampleTile, scratch: &mut Scratch, work: &mut Work) -> bool {
        if !scratch.buffers.clear(tile, &self.live, work) {
            scratch.triangles.clear();
            return false;
        }
        let simd = self.options.simd;
        if let (Some(placement), Some(placed)) = (self.placement, &mut scratch.placed) {
            placement.place(tile, simd, placed);
            let triangles = match &self.source {
                Source::Own(triangles) => triangles,
                Source::Moving(moving) => {
                    self.find_moving(tile, moving, scratch, work);
                    return true;
                }
                Source::Shared(shared) => {
                    let (triangles, look_up) = (&mut scratch.triangles, &mut scratch.look_up);
                    shared.look_up(placed, &mut scratch.buffers, triangles, look_up);
                    return true;
                }
            };
            placed.find_boxes(&scratch.buffers.valid);
            triangles.around(placed, &mut scratch.triangles);
            let kernel = RasterizePlaced {
                placed,
                triangles: &scratch.triangles,
                objects: &self.geometry.objects,
                skip_occluded: self.options.skip.occluded,
                buffers: &mut scratch.buffers,
                work,
            };
            dispatch(simd, kernel);
            return true;
        }
        let Source::Own(triangles) = &self.source else {
            unreachable!("only passes with a placement share visibility")
        };
        let place = tile.origin / TILE;
        triangles.tile(place.x, place.y, &mut scratch.triangles);
        let kernel = RasterizeTile {
            tile,
            triangles: &scratch.triangles,
            objects: &self.geometry.objects,
            msaa: self.msaa,
            skip_occluded: self.options.skip.occluded,
            buffers: &mut scratch.buffers,
            work,
        };
        dispatch(simd, kernel);
        true
    }

    fn material(&self, t: &SetUpTriangle) -> usize {
        let instance = self.geometry.objects[t.object as usize].instance;
        self.scene.instances()[instance as usize].material
    }

    fn draw_tile(
        &self,
        context: &ShadeContext<'_>,
        tile: &SampleTile,
        rows: &mut [&mut [[f32; 3]]],
        scratch: &mut Scratch,
    ) -> Work {
        let mut work = Work::default();
        if !self.find_visible(tile, scratch, &mut work) {
            return work;
        }
        let Scratch {
            buffers,
            placed,
            triangles,
            fragments,
            corners,
            attributes: prepared,
            details: detailed,
            edges,
            moving,
            ..
        } = scratch;
        let collect = Collect {
            fragments,
            tile,
            buffers,
            msaa: self.msaa,
            rates: self.rates,
            all_edges: !self.options.skip.whole_samples,
            slots: triangles.len(),
            material: |slot| self.material(&triangles[slot as usize - 1]) as u32,
            work: &mut work,
        };
        dispatch(self.options.simd, collect);
        let visible = fragments.visible.iter();
        let visible = visible.map(|&slot| &triangles[slot as usize - 1]);
        corners.clear();
        corners.extend(
            visible
                .clone()
                .map(|t| vertices(self.scene, self.geometry, t)),
        );
        if let (Some(moving), Source::Moving(source)) = (moving.as_mut(), &self.source) {
            moving.attributes.clear();
            let found = fragments.visible.iter().zip(corners.iter());
            moving.attributes.extend(found.map(|(&slot, start)| {
                let slot = slot as usize - 1;
                let end = vertices_at_end(self.scene, self.geometry, &triangles[slot]);
                MovingAttributes::new(source.target(moving.targets[slot]), start, &end)
            }));
        }
        let visible = visible.zip(corners.iter());
        prepared.clear();
        prepared.extend(
            visible
                .clone()
                .map(|(t, vertices)| attributes(t, vertices, &self.projection)),
        );
        detailed.clear();
        if self.has_details {
            // A place beside its triangle reads them whatever the material.
            let all_read = self.msaa != Msaa::One || self.rates.0.is_some();
            detailed.extend(visible.map(|(t, vertices)| {
                let needs = self.needs[self.material(t)];
                if !(all_read || needs.object || needs.uv) {
                    return Details::UNREAD;
                }
                details(
                    self.scene,
                    self.geometry,
                    t,
                    vertices,
                    &self.projection,
                    needs,
                )
            }));
        }
        edges.clear();
        edges.resize(fragments.edges.len(), EdgeSample::DARK);
        for bucket in 0..fragments.buckets.len() {
            let work = &fragments.buckets[bucket];
            if work.blocks.is_empty() && work.groups.len() == 0 {
                continue;
            }
            let nothing = Needs {
                object: false,
                uv: false,
            };
            let kernel = ShadeTile {
                context,
                tile,
                placed: placed.as_ref(),
                bucket,
                needs: bucket.checked_sub(1).map_or(nothing, |m| self.needs[m]),
                fragments,
                triangles: prepared,
                moving: moving.as_ref().map(|m| m.attributes.as_slice()),
                details: detailed,
                buffers,
                msaa: self.msaa,
                out: rows,
                edges,
            };
            dispatch(self.options.simd, kernel);
        }
        for (&[x, y], edge) in fragments.edges.iter().zip(edges.iter()) {
            rows[y as usize][x as usize] = edge.mean();
        }
        work
    }

    /// Writes 1/w and instance of a tile's samples to the rows it was given.
    fn copy_geometry(&self, scratch: &mut Scratch, rows: &mut [(&mut [f32], &mut [u32])]) {
        if rows.is_empty() {
            return;
        }
        let positions = self.msaa.positions() as usize;
        let Scratch {
            buffers,
            triangles,
            instances,
            ..
        } = scratch;
        instances.clear();
        instances.push(u32::MAX);
        let instance = |t: &SetUpTriangle| self.geometry.objects[t.object as usize].instance;
        instances.extend(triangles.iter().map(instance));
        for (block, valid) in buffers.valid.iter().enumerate() {
            let depth = &buffers.depth[block * positions];
            let slot = &buffers.slot[block * positions];
            let [x, y] = position_of(block * LANES).map(|c| c as usize);
            for row in 0..BLOCK[1] as usize {
                let lanes = row * BLOCK[0] as usize..(row + 1) * BLOCK[0] as usize;
                let drawn = valid >> lanes.start & ROW;
                if drawn == 0 {
                    continue;
                }
                let (depths, found) = &mut rows[y + row];
                if drawn == ROW {
                    let there = x..x + BLOCK[0] as usize;
                    depths[there.clone()].copy_from_slice(&depth[lanes.clone()]);
                    for (found, slot) in found[there].iter_mut().zip(&slot[lanes]) {
                        *found = instances[*slot as usize];
                    }
                    continue;
                }
                for lane in lanes.filter(|lane| valid >> lane & 1 != 0) {
                    let x = x + lane % BLOCK[0] as usize;
                    depths[x] = depth[lane];
                    found[x] = instances[slot[lane] as usize];
                }
            }
        }
    }
}

/// The lanes of a row of a block.
const ROW: LaneSet = (1 << BLOCK[0]) - 1;
