use foveasim_assets::Scene;
use foveasim_models::{SamplePlan, View, Work};
use glam::{DVec3, UVec2};
use rayon::prelude::*;

use super::setup::Corners;
use super::{ANYWHERE, MovingSetUp, Seen, Target, px};
use crate::bvh::{Aabb, Bvh};
use crate::live::{Live, grid};
use crate::pass::check_position;
use crate::placement::Placement;
use crate::tile::{LANES, SampleTile, TILE, TILE_SAMPLES, TileBuffers, position_of};
use crate::visible::{PassObjects, geometry};
use crate::{RenderError, RenderOptions, Skip, Surfel};

/// What each sample of a pass with moving triangles sees, by asking every triangle in whose box of places it looks: no tiles, no
/// lanes, no bound. A tree of boxes around all places that triangles take names them.
pub(crate) fn trace_moving(
    scene: &Scene,
    view: &View,
    plan: &SamplePlan,
    pass: usize,
    options: &RenderOptions,
) -> Vec<Option<Surfel>> {
    let options = RenderOptions {
        skip: Skip {
            back_faces: options.skip.back_faces,
            hidden: options.skip.hidden,
            ..Skip::NONE
        },
        ..*options
    };
    let objects = PassObjects::of(scene, view, plan, pass, &options);
    let geometry = geometry(scene, view, &objects.named, &options);
    let Some(placement) = &objects.placement else {
        unreachable!("bent passes are placed")
    };
    let live = Live::new(plan, pass, &view.optics, options.skip.hidden);
    let set_up = MovingSetUp {
        scene,
        view,
        pass: &plan.passes[pass],
        geometry: &geometry,
        placement,
        live: &live,
        options: &options,
    };
    let targets = targets(&set_up, &objects.in_geometry(&geometry));
    let boxes: Vec<Aabb> = targets.iter().map(bounds).collect();
    let bvh = Bvh::new(&boxes);
    let nearest = (1.0 / options.near_m) as f32;
    let name = |t: &Target| (geometry.objects[t.object as usize].instance, t.triangle);
    let looks = looks(&plan.passes[pass], placement, &live, &options);
    looks
        .into_par_iter()
        .map(|looks| {
            let looks = looks?;
            let at = DVec3::new(looks[0].into(), looks[1].into(), 0.0);
            let mut found: Option<(f32, &Target)> = None;
            let enters = |found: &Option<(f32, &Target)>, b: &Aabb| {
                let holds = (0..2).all(|k| at[k] >= b.min[k] && at[k] <= b.max[k]);
                // Along z lies 1/w.
                holds && found.is_none_or(|(depth, _)| b.max.z >= f64::from(depth))
            };
            bvh.traverse(&mut found, enters, |found, index| {
                let t = &targets[index as usize];
                let Some(depth) = t.sees(looks, nearest) else {
                    return;
                };
                let wins = match found {
                    None => true,
                    Some((d, other)) => depth > *d || (depth == *d && name(t) < name(other)),
                };
                if wins {
                    *found = Some((depth, t));
                }
            });
            let (depth, t) = found?;
            let object = &geometry.objects[t.object as usize];
            Some(Surfel {
                instance: object.instance,
                mesh: object.mesh,
                triangle: t.triangle,
                depth_m: 1.0 / depth,
            })
        })
        .collect()
}

/// All triangles that are not behind the near plane or show their backs at all times.
fn targets(pass: &MovingSetUp<'_>, objects: &[u32]) -> Vec<Target> {
    let warp = pass.placement.warp();
    let seen = Seen {
        around: &ANYWHERE,
        scan: warp.and_then(|warp| warp.image_scan(pass.view.optics.size)),
        grid: None,
    };
    let mut targets = Vec::new();
    for &object in objects {
        let place = pass.geometry.objects[object as usize];
        let corners = Corners::new(pass, &place);
        let instance = &pass.scene.instances()[place.instance as usize];
        let both_faces = !pass.options.skip.back_faces || instance.two_sided;
        let mesh = &pass.scene.meshes()[place.mesh as usize];
        for (index, names) in mesh.triangles().iter().enumerate() {
            let moving = corners.triangle(*names);
            let named = [object, index as u32];
            let near = pass.options.near_m;
            targets.extend(Target::set_up(&moving, near, &seen, both_faces, named));
        }
    }
    targets
}

/// All places of a triangle in the image, and along z its 1/w.
fn bounds(t: &Target) -> Aabb {
    let [[x0, x1], [y0, y1]] = t.bounds.map(|b| b.map(f64::from));
    let [low, high] = t.depth_range.map(f64::from);
    Aabb {
        min: DVec3::new(x0, y0, low),
        max: DVec3::new(x1, y1, high),
    }
}

/// Where and when each sample of a pass looks, row by row; `None` if it is not drawn.
fn looks(
    pass: &foveasim_models::Pass,
    placement: &Placement,
    live: &Live<'_>,
    options: &RenderOptions,
) -> Vec<Option<[f32; 3]>> {
    let size = grid(pass);
    let mut looks = vec![None; size.x as usize * size.y as usize];
    let mut buffers = TileBuffers::new(1);
    let mut placed = placement.room();
    for y in 0..size.y.div_ceil(TILE) {
        for x in 0..size.x.div_ceil(TILE) {
            let tile = SampleTile::of(pass, x, y);
            if !buffers.clear(&tile, live, &mut Work::default()) {
                continue;
            }
            placement.place(&tile, options.simd, &mut placed);
            for index in 0..TILE_SAMPLES {
                let (block, lane) = (index / LANES, index % LANES);
                if buffers.valid[block] >> lane & 1 == 0 {
                    continue;
                }
                let [u, v] = placed.position(UVec2::from(position_of(index)), 0);
                let t = placed.time.get(block).map_or(0.0, |t| t[lane]);
                let sample = tile.origin + UVec2::from(position_of(index));
                looks[(sample.y * size.x + sample.x) as usize] = Some([px(u), px(v), t]);
            }
        }
    }
    looks
}

/// Where and when each sample of a pass looks, row by row: its position in the image \[px\], off the display too where
/// a lens takes it there, and its time from 0 to 1. `None` if it is not drawn, and for passes whose samples lie evenly and look
/// at once: those are where the plan says ([`SamplePlan::position`]).
///
/// # Errors
/// As [`visibility`](crate::visibility).
pub fn sample_looks(
    scene: &Scene,
    view: &View,
    plan: &SamplePlan,
    pass: usize,
    options: &RenderOptions,
) -> Result<Vec<Option<[f32; 3]>>, RenderError> {
    check_position(scene, view, plan, pass, 0, options)?;
    let live = Live::new(plan, pass, &view.optics, options.skip.hidden);
    let warp = super::Warp::of(scene, view, options);
    let Some(placement) = Placement::of(plan, pass, warp) else {
        let size = grid(&plan.passes[pass]);
        return Ok(vec![None; size.x as usize * size.y as usize]);
    };
    Ok(looks(&plan.passes[pass], &placement, &live, options))
}
