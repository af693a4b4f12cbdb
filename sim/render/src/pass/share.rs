use foveasim_assets::Scene;
use foveasim_models::{SamplePlan, View, Work};
use rayon::prelude::*;

use super::{Drawing, Scratch, Source, tiles};
use crate::RenderOptions;
use crate::live::grid;
use crate::raster::ViewGeometry;
use crate::shared::SharedVisibility;
use crate::tile::{LANES, SampleTile, TILE, TILE_SAMPLES, position_of};
use crate::visible::PassObjects;

/// Finds what each sample of pass `index` sees and shades nothing: for a later pass that does.
pub(crate) fn find_shared(
    scene: &Scene,
    view: &View,
    plan: &SamplePlan,
    index: usize,
    geometry: &ViewGeometry,
    objects: &PassObjects,
    options: &RenderOptions,
) -> (SharedVisibility, Work) {
    let pass = &plan.passes[index];
    let size = grid(pass);
    let drawing = Drawing::new(scene, view, plan, index, geometry, objects, options, None);
    let positions = drawing.msaa.positions() as usize;
    let mut work = drawing.work;
    work.passes = 1;
    let count = size.x as usize * size.y as usize * positions;
    let (mut number, mut inverse_w) = (vec![0u32; count], vec![0f32; count]);

    // Each tile gets its own part of every row it crosses.
    let mut jobs: Vec<_> = tiles(size).map(|place| (place, Vec::new())).collect();
    let across = size.x.div_ceil(TILE) as usize;
    let rows = number
        .chunks_mut(size.x as usize * positions)
        .zip(inverse_w.chunks_mut(size.x as usize * positions));
    for (y, (numbers, depths)) in rows.enumerate() {
        let first = y / TILE as usize * across;
        let parts = numbers.chunks_mut(TILE as usize * positions);
        let depths = depths.chunks_mut(TILE as usize * positions);
        for (x, part) in parts.zip(depths).enumerate() {
            jobs[first + x].1.push(part);
        }
    }
    let works: Vec<Work> = jobs
        .into_par_iter()
        .map_init(
            || Scratch::new(&drawing),
            |scratch, ((x, y), mut rows)| {
                let mut work = Work::default();
                let tile = SampleTile::of(pass, x, y);
                if drawing.find_visible(&tile, scratch, &mut work) {
                    drawing.copy_numbers(&tile, scratch, &mut rows);
                }
                work
            },
        )
        .collect();
    for tile in works {
        work += tile;
    }
    let Source::Own(triangles) = drawing.source else {
        unreachable!("a pass of its own visibility")
    };
    let shared = SharedVisibility {
        size,
        positions,
        number,
        inverse_w,
        triangles,
    };
    (shared, work)
}

impl Drawing<'_> {
    /// Writes triangle and 1/w of a tile's samples to the rows it was given.
    fn copy_numbers(
        &self,
        tile: &SampleTile,
        scratch: &mut Scratch,
        rows: &mut [(&mut [u32], &mut [f32])],
    ) {
        let Source::Own(triangles) = &self.source else {
            unreachable!("a pass of its own visibility")
        };
        let positions = self.msaa.positions() as usize;
        let place = tile.origin / TILE;
        triangles.tile_numbers(place.x, place.y, &mut scratch.numbers);
        let buffers = &scratch.buffers;
        for index in 0..TILE_SAMPLES {
            if buffers.valid[index / LANES] >> (index % LANES) & 1 == 0 {
                continue;
            }
            let [x, y] = position_of(index);
            let (numbers, depths) = &mut rows[y as usize];
            for p in 0..positions {
                let (block, lane) = (index / LANES * positions + p, index % LANES);
                let slot = buffers.slot[block][lane] as usize;
                let to = x as usize * positions + p;
                numbers[to] = slot.checked_sub(1).map_or(0, |k| scratch.numbers[k] + 1);
                depths[to] = buffers.depth[block][lane];
            }
        }
    }
}
