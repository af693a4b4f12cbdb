use foveasim_assets::Scene;
use foveasim_models::{SamplePlan, View, Work};

use super::{Drawing, Scratch, Source, check_position, tiles};
use crate::live::grid;
use crate::moving::Counts;
use crate::tile::SampleTile;
use crate::visible::{PassObjects, geometry};
use crate::{BoundCounts, RenderError, RenderOptions};

/// Finds what is visible in pass `index`, whose options ask for a bound, and counts tests and hits into `out`.
pub(crate) fn count_tests(
    scene: &Scene,
    view: &View,
    plan: &SamplePlan,
    index: usize,
    options: &RenderOptions,
    out: &mut BoundCounts,
) -> Result<(), RenderError> {
    check_position(scene, view, plan, index, 0, options)?;
    let pass = &plan.passes[index];
    let size = grid(pass);
    let samples = size.x as usize * size.y as usize;
    out.lattice = size;
    out.tested = vec![0; samples];
    out.covered = vec![0; samples];
    if samples == 0 {
        return Ok(());
    }
    let objects = PassObjects::of(scene, view, plan, index, options);
    let geometry = geometry(scene, view, &objects.named, options);
    let drawing = Drawing::new(scene, view, plan, index, &geometry, &objects, options, None);
    let mut scratch = Scratch::new(&drawing);
    let mut work = Work {
        passes: 1,
        ..drawing.work
    };
    for (x, y) in tiles(size) {
        let tile = SampleTile::of(pass, x, y);
        if let Some(moving) = &mut scratch.moving {
            moving.counts = Some(Counts::default());
        }
        drawing.find_visible(&tile, &mut scratch, &mut work);
        let (Some(moving), Source::Moving(source)) = (&scratch.moving, &drawing.source) else {
            continue;
        };
        let Some(counts) = &moving.counts else {
            continue;
        };
        out.add_tile(tile.origin, tile.size, counts);
        let targets = moving.targets.iter().map(|t| source.target(*t));
        let of_tile = targets.zip(&counts.triangles);
        let tested = of_tile.filter(|(_, [tested, _])| *tested > 0);
        out.triangles
            .extend(tested.map(|(t, [tested, covered])| crate::TriangleCount {
                instance: geometry.objects[t.object as usize].instance,
                triangle: t.triangle,
                tested: *tested,
                covered: *covered,
            }));
    }
    out.work = work;
    Ok(())
}
