use foveasim_assets::Scene;
use foveasim_models::{Image, Lattice, Map, Pass, SamplePlan, View, Work};
use glam::UVec2;
use rayon::prelude::*;

use crate::kernels::{Attributes, RasterizeTile, ShadeContext, ShadeTile, dispatch};
use crate::project::Projection;
use crate::raster::{Bins, Geometry, SetUpTriangle, TriangleRef, attributes, set_up, transform};
use crate::tile::{SampleTile, TILE, TILE_SAMPLES, TileBuffers, position_of};
use crate::{RenderError, RenderOptions};

/// What one sample sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surfel {
    /// Index of the instance in the scene.
    pub instance: u32,
    /// Index of the triangle in its mesh.
    pub triangle: u32,
    /// Distance along the view axis \[m\].
    pub depth_m: f32,
}

/// What each sample of pass `pass` of the plan sees, row by row; `None` is sky.
///
/// # Errors
/// As [`render`](crate::render); also if there is no such pass.
pub fn visibility(
    scene: &Scene,
    view: &View,
    plan: &SamplePlan,
    pass: usize,
    options: &RenderOptions,
) -> Result<Vec<Option<Surfel>>, RenderError> {
    crate::frame::check(view, plan, options)?;
    let Some(pass) = plan.passes.get(pass) else {
        let why = format!("there are {} passes, counted from 0", plan.passes.len());
        return Err(RenderError::Pass {
            method: plan.method.clone(),
            pass,
            why,
        });
    };
    let pass = &shifted(pass);
    let drawing = Drawing::new(scene, view, pass, options);
    let size = drawing.projection.size;
    let mut surfels = vec![None; size.x as usize * size.y as usize];
    let mut buffers = TileBuffers::new();
    for (x, y) in tiles(size) {
        let tile = SampleTile::of(pass, x, y);
        let bin = drawing.bins.tile(x, y);
        drawing.find_visible(&tile, bin, &mut buffers, &mut Work::default());
        for (index, &slot) in buffers
            .slot
            .iter()
            .enumerate()
            .filter(|(_, slot)| **slot != 0)
        {
            let t = bin[slot as usize - 1].get(&drawing.lists);
            let [px, py] = position_of(index);
            if px >= tile.size.x || py >= tile.size.y {
                continue;
            }
            let place =
                (tile.origin.y + py) as usize * size.x as usize + (tile.origin.x + px) as usize;
            surfels[place] = Some(Surfel {
                instance: drawing.geometry.drawn[t.drawn as usize].instance,
                triangle: t.triangle,
                depth_m: 1.0 / buffers.depth[index],
            });
        }
    }
    Ok(surfels)
}

/// The drawn samples of a pass, row by row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PassSamples {
    /// Colours.
    pub(crate) image: Image,
    /// 1/w of what is seen [1/m], 0 for the sky; empty unless geometry is kept.
    pub(crate) inverse_w: Vec<f32>,
    /// Index of the instance that is seen, `u32::MAX` for the sky; empty unless geometry is kept.
    pub(crate) instance: Vec<u32>,
}

/// Draws a pass: what each of its samples sees, and the work it took.
pub(crate) fn draw(
    scene: &Scene,
    view: &View,
    pass: &Pass,
    options: &RenderOptions,
    keep_geometry: bool,
) -> (PassSamples, Work) {
    let Lattice::Grid(size) = pass.lattice else {
        unreachable!("only grids pass the checks")
    };
    let pass = &shifted(pass);
    let mut image = Image::filled(size, [0.0; 3]);
    let kept = image.rgb.len() * usize::from(keep_geometry);
    let (mut inverse_w, mut instance) = (vec![0.0; kept], vec![u32::MAX; kept]);
    if size.x == 0 || size.y == 0 {
        let samples = PassSamples {
            image,
            inverse_w,
            instance,
        };
        return (samples, Work::default());
    }
    let drawing = Drawing::new(scene, view, pass, options);
    let context = ShadeContext::new(scene, view.poses[0], &drawing.projection);
    let mut work = drawing.work;
    work.passes = 1;

    // Each tile gets its own part of every image row it crosses.
    let mut jobs: Vec<_> = tiles(size)
        .map(|place| (place, Vec::new(), Vec::new()))
        .collect();
    let across = size.x.div_ceil(TILE) as usize;
    for (y, row) in image.rgb.chunks_mut(size.x as usize).enumerate() {
        let first = y / TILE as usize * across;
        for (x, part) in row.chunks_mut(TILE as usize).enumerate() {
            jobs[first + x].1.push(part);
        }
    }
    let geometry_rows = inverse_w
        .chunks_mut(size.x as usize)
        .zip(instance.chunks_mut(size.x as usize));
    for (y, (depths, instances)) in geometry_rows.enumerate() {
        let first = y / TILE as usize * across;
        let parts = depths.chunks_mut(TILE as usize);
        for (x, part) in parts.zip(instances.chunks_mut(TILE as usize)).enumerate() {
            jobs[first + x].2.push(part);
        }
    }
    let works: Vec<Work> = jobs
        .into_par_iter()
        .map_init(Scratch::new, |scratch, ((x, y), mut rows, mut geometry)| {
            let tile = SampleTile::of(pass, x, y);
            let bin = drawing.bins.tile(x, y);
            let work = drawing.draw_tile(&context, &tile, bin, &mut rows, scratch);
            drawing.copy_geometry(bin, &scratch.buffers, &mut geometry);
            work
        })
        .collect();
    for tile in works {
        work += tile;
    }
    let samples = PassSamples {
        image,
        inverse_w,
        instance,
    };
    (samples, work)
}

/// The pass with its offset taken into its map.
fn shifted(pass: &Pass) -> Pass {
    let Map::Affine(mut map) = pass.map else {
        unreachable!("only affine grids pass the checks")
    };
    map.origin += map.scale * pass.offset;
    Pass {
        map: Map::Affine(map),
        offset: glam::DVec2::ZERO,
        ..pass.clone()
    }
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
    projection: Projection,
    geometry: Geometry,
    lists: Vec<Vec<SetUpTriangle>>,
    bins: Bins,
    work: Work,
}

/// Memory that a worker uses for one tile after the other.
struct Scratch {
    buffers: TileBuffers,
    /// Samples in the order of their materials, sky first.
    order: Vec<u16>,
    /// First sample of each material in `order`.
    first: Vec<u32>,
    triangles: Vec<Attributes>,
    triangle_of_slot: Vec<u32>,
}

impl Scratch {
    fn new() -> Self {
        Self {
            buffers: TileBuffers::new(),
            order: vec![0; TILE_SAMPLES],
            first: Vec::new(),
            triangles: Vec::new(),
            triangle_of_slot: Vec::new(),
        }
    }
}

impl<'a> Drawing<'a> {
    fn new(scene: &'a Scene, view: &View, pass: &Pass, options: &'a RenderOptions) -> Self {
        let (Lattice::Grid(size), Map::Affine(map)) = (pass.lattice, pass.map) else {
            unreachable!("only affine grids pass the checks")
        };
        let projection = Projection::new(&view.optics, &map, size, options.near_m);
        let geometry = transform(scene, view.poses[0], &projection, options.simd);
        let (lists, setup_work) = set_up(scene, &geometry, &projection);
        let bins = Bins::new(&lists, size);
        let mut work = geometry.work;
        work += setup_work;
        Self {
            scene,
            options,
            projection,
            geometry,
            lists,
            bins,
            work,
        }
    }

    fn find_visible(
        &self,
        tile: &SampleTile,
        bin: &[TriangleRef],
        buffers: &mut TileBuffers,
        work: &mut Work,
    ) {
        let lists = &self.lists;
        dispatch(
            self.options.simd,
            RasterizeTile {
                tile,
                bin,
                lists,
                buffers,
                work,
            },
        );
    }

    fn draw_tile(
        &self,
        context: &ShadeContext<'_>,
        tile: &SampleTile,
        bin: &[TriangleRef],
        rows: &mut [&mut [[f32; 3]]],
        scratch: &mut Scratch,
    ) -> Work {
        let mut work = Work::default();
        self.find_visible(tile, bin, &mut scratch.buffers, &mut work);
        self.sort_by_material(bin, scratch);
        let sky = scratch.first[1];
        work.samples_sky = sky.into();
        let total = scratch.first[scratch.first.len() - 1];
        work.samples_shaded = (total - sky).into();
        for bucket in 0..scratch.first.len() - 1 {
            let range = scratch.first[bucket] as usize..scratch.first[bucket + 1] as usize;
            if range.is_empty() {
                continue;
            }
            let kernel = ShadeTile {
                context,
                tile,
                material: bucket.checked_sub(1).map(|m| m as u32),
                samples: &scratch.order[range],
                triangles: &scratch.triangles,
                triangle_of_slot: &scratch.triangle_of_slot,
                slot: &scratch.buffers.slot,
                depth: &scratch.buffers.depth,
                out: rows,
            };
            dispatch(self.options.simd, kernel);
        }
        work
    }

    /// Writes 1/w and instance of a tile's samples to the rows it was given.
    fn copy_geometry(
        &self,
        bin: &[TriangleRef],
        buffers: &TileBuffers,
        rows: &mut [(&mut [f32], &mut [u32])],
    ) {
        for index in 0..if rows.is_empty() { 0 } else { TILE_SAMPLES } {
            let ([x, y], slot) = (position_of(index), buffers.slot[index]);
            let Some((depths, instances)) = rows.get_mut(y as usize) else {
                continue;
            };
            if slot != 0 && (x as usize) < depths.len() {
                let drawn = bin[slot as usize - 1].get(&self.lists).drawn;
                depths[x as usize] = buffers.depth[index];
                instances[x as usize] = self.geometry.drawn[drawn as usize].instance;
            }
        }
    }

    /// Orders the tile's samples by material (a stable counting sort), and prepares the attributes of
    /// each visible triangle once.
    fn sort_by_material(&self, bin: &[TriangleRef], scratch: &mut Scratch) {
        const UNSEEN: u32 = u32::MAX;
        let Scratch {
            buffers,
            order,
            first,
            triangles,
            triangle_of_slot,
        } = scratch;
        triangles.clear();
        triangle_of_slot.clear();
        triangle_of_slot.resize(bin.len() + 1, UNSEEN);
        let buckets = self.scene.materials().len() + 1;
        first.clear();
        first.resize(buckets + 1, 0);
        let valid = |i: usize| buffers.valid[i / 8] & (1 << (i % 8)) != 0;
        let bucket = |slot: u32| match slot {
            0 => 0,
            _ => bin[slot as usize - 1].get(&self.lists).material as usize + 1,
        };
        for (_, &slot) in buffers.slot.iter().enumerate().filter(|(i, _)| valid(*i)) {
            first[bucket(slot) + 1] += 1;
            if slot != 0 && triangle_of_slot[slot as usize] == UNSEEN {
                triangle_of_slot[slot as usize] = triangles.len() as u32;
                let triangle = bin[slot as usize - 1].get(&self.lists);
                triangles.push(attributes(
                    self.scene,
                    &self.geometry,
                    triangle,
                    &self.projection,
                ));
            }
        }
        for i in 0..buckets {
            first[i + 1] += first[i];
        }
        let mut next = first.clone();
        for (i, &slot) in buffers.slot.iter().enumerate().filter(|(i, _)| valid(*i)) {
            let place = &mut next[bucket(slot)];
            order[*place as usize] = i as u16;
            *place += 1;
        }
    }
}
