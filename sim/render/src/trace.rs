use foveasim_assets::Scene;
use foveasim_models::{Msaa, SamplePlan, View, Visibility, Work};
use glam::{DVec2, DVec3, UVec2};
use rayon::prelude::*;

use crate::bvh::{Aabb, Bvh};
use crate::live::{Live, grid, live_box};
use crate::moving::{Warp, trace_moving};
use crate::msaa::offsets;
use crate::pass::{check_position, projection, reach};
use crate::placed::PlacedTile;
use crate::project::{GUARD_SAMPLES, Projection, SUBSAMPLES};
use crate::raster::{SetUp, SetUpTriangle, ViewGeometry, set_up};
use crate::tile::{LANES, LaneSet, SampleTile, TILE, TILE_SAMPLES, position_of};
use crate::visible::{PassObjects, geometry};
use crate::{RenderError, RenderOptions, Skip, Surfel};

/// As [`visibility_at`](crate::visibility_at), by casting a ray for each sample: no tiles, no lanes,
/// nothing culled but back faces. The result is the same, bit for bit.
///
/// A tree of boxes in eye space names the triangles that a ray may meet. Their boxes are enlarged by
/// all that snapping may move a triangle, so none is missed; which of them covers the sample, and how
/// near, is then decided by the rasterizer's own arithmetic on snapped corners, of which there is one
/// scalar function. An independent tracer can only agree up to rounding; this one must agree exactly,
/// and shows that binning, traversal of blocks, lanes and hidden-surface culling lose nothing.
///
/// Of views that roll while something moves, through a lens, or with a bound asked for, each sample casts its ray at its own
/// time. The boxes hold all places that a triangle takes during the scan, and published bounds play no part.
///
/// # Errors
/// As [`visibility_at`](crate::visibility_at).
pub fn trace(
    scene: &Scene,
    view: &View,
    plan: &SamplePlan,
    pass: usize,
    position: usize,
    options: &RenderOptions,
) -> Result<Vec<Option<Surfel>>, RenderError> {
    check_position(scene, view, plan, pass, position, options)?;
    let size = grid(&plan.passes[pass]);
    if size.min_element() == 0 {
        return Ok(Vec::new());
    }
    if Warp::of(scene, view, options).is_some() {
        return Ok(trace_moving(scene, view, plan, pass, options));
    }
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
    let projection = projection(view, &plan.passes[pass], &options);
    let Visibility::Own(msaa) = plan.passes[pass].visibility else {
        unreachable!("only visibility of its own passes the checks")
    };
    let pass_set_up = SetUp {
        scene,
        geometry: &geometry,
        projection: &projection,
        options: &options,
        reach: reach(&plan.passes[pass], msaa),
        drawn: live_box(&plan.passes[pass], projection.size, &options),
    };
    let (triangles, _) = set_up(&pass_set_up, &objects.in_geometry(&geometry));
    let triangles: Vec<SetUpTriangle> = triangles.iter().copied().collect();
    let margin = margin_tan(&projection);
    let boxes: Vec<Aabb> = triangles
        .iter()
        .map(|t| bounds(t, scene, &geometry, margin))
        .collect();
    let tracer = Tracer {
        bvh: Bvh::new(&boxes),
        boxes,
        triangles,
        geometry: &geometry,
        projection: &projection,
    };
    let offset = match msaa {
        Msaa::One => [0, 0],
        Msaa::Four => offsets::FOUR[position],
    };
    let live = Live::new(plan, pass, &view.optics, options.skip.hidden);
    let (across, down) = (size.x.div_ceil(TILE), size.y.div_ceil(TILE));
    let tiles: Vec<_> = (0..across * down)
        .into_par_iter()
        .map(|index| {
            let (x, y) = (index % across, index / across);
            let tile = SampleTile::of(&plan.passes[pass], x, y);
            let placed = objects.placement.as_ref().map(|placement| {
                let mut placed = PlacedTile::new(placement.positions());
                placement.place(&tile, options.simd, &mut placed);
                placed
            });
            let at = |sample: UVec2| match &placed {
                None => middle(sample, offset),
                Some(placed) => placed.position(sample - tile.origin, position),
            };
            let drawn = drawn(&tile, &live);
            drawn
                .map(|s| (s, tracer.nearest(at(s))))
                .collect::<Vec<_>>()
        })
        .collect();
    let mut seen = vec![None; size.x as usize * size.y as usize];
    for (sample, surfel) in tiles.into_iter().flatten() {
        seen[(sample.y * size.x + sample.x) as usize] = surfel;
    }
    Ok(seen)
}

/// The samples of a tile that are drawn.
fn drawn(tile: &SampleTile, live: &Live<'_>) -> impl Iterator<Item = UVec2> + use<> {
    let mut valid = vec![0; TILE_SAMPLES / LANES];
    let at = |index| UVec2::from(position_of(index));
    for index in 0..TILE_SAMPLES {
        let inside = at(index).cmplt(tile.size).all();
        valid[index / LANES] |= LaneSet::from(inside) << (index % LANES);
    }
    live.clear(tile, &mut valid, &mut Work::default());
    let origin = tile.origin;
    (0..TILE_SAMPLES)
        .filter(move |index| valid[index / LANES] >> (index % LANES) & 1 != 0)
        .map(move |index| origin + at(index))
}

/// How far from where its vertices are a triangle may be rasterized, as tangents: half a sub-sample of
/// snapping, and rounding. A position of up to R pixels is a quotient, a product and a sum in single
/// precision, then scaled to sub-samples by a product and two sums, by numbers that were themselves
/// rounded: less than eight roundings of 2⁻²⁴·R. Twice that is allowed for.
fn margin_tan(projection: &Projection) -> DVec2 {
    let [sub, axis] = [projection.sub_per_px, projection.optics.axis_px].map(|v| v.map(f64::from));
    let margin = |k: usize| {
        let px_per_sample = f64::from(SUBSAMPLES) / sub[k];
        let origin = f64::from(projection.origin_whole[k]) / sub[k];
        let far = GUARD_SAMPLES + f64::from(projection.size[k]);
        let reach = far * px_per_sample + origin.abs() + 2.0 * axis[k].abs();
        px_per_sample / 512.0 + reach * 16.0 / f64::from(1 << 24)
    };
    let step = projection.tan_per_px.map(|t| f64::from(t.abs()));
    DVec2::new(margin(0) * step[0], margin(1) * step[1])
}

/// A box in eye space (x, y, w) around all that is drawn of a triangle.
fn bounds(t: &SetUpTriangle, scene: &Scene, geometry: &ViewGeometry, margin: DVec2) -> Aabb {
    let object = &geometry.objects[t.object as usize];
    let names = scene.meshes()[object.mesh as usize].triangles()[t.index()];
    let vertices = geometry.of(object, scene);
    let [a, b, c] = names.map(|i| DVec3::from_array(vertices[i as usize].eye.map(f64::from)));
    let (min, max) = (a.min(b).min(c), a.max(b).max(c));
    // What is moved by a tangent is moved by so much times w, and w stays.
    let moved = (margin * max.z).extend(0.0);
    Aabb {
        min: min - moved,
        max: max + moved,
    }
}

/// The position `offset` sub-samples from the middle of a sample.
fn middle(sample: UVec2, offset: [i32; 2]) -> [i32; 2] {
    [0, 1].map(|k| sample[k] as i32 * SUBSAMPLES + SUBSAMPLES / 2 + offset[k])
}

struct Tracer<'a> {
    bvh: Bvh,
    boxes: Vec<Aabb>,
    triangles: Vec<SetUpTriangle>,
    geometry: &'a ViewGeometry,
    projection: &'a Projection,
}

/// The nearest triangle so far, and its 1/w; 0 where there is none.
#[derive(Default)]
struct Nearest {
    triangle: Option<u32>,
    inverse_w: f32,
}

impl Tracer<'_> {
    /// What is seen at a position of the projection's lattice [sub-samples].
    fn nearest(&self, at: [i32; 2]) -> Option<Surfel> {
        let lattice = DVec2::new(at[0].into(), at[1].into()) / f64::from(SUBSAMPLES);
        let tangent = self.projection.tangent(lattice);
        let mut nearest = Nearest::default();
        let enters = |nearest: &Nearest, bounds: &Aabb| {
            // Least and greatest 1/w are rounded to single precision.
            let is_nearer = bounds.min.z * f64::from(nearest.inverse_w) <= 1.0 + 1e-6;
            is_nearer && meets(tangent, bounds, self.projection.near)
        };
        self.bvh.traverse(&mut nearest, enters, |nearest, name| {
            if enters(nearest, &self.boxes[name as usize]) {
                self.test(nearest, name, at);
            }
        });
        nearest.triangle.map(|name| {
            let t = &self.triangles[name as usize];
            let object = &self.geometry.objects[t.object as usize];
            Surfel {
                instance: object.instance,
                mesh: object.mesh,
                triangle: t.index() as u32,
                depth_m: 1.0 / nearest.inverse_w,
            }
        })
    }

    /// Keeps a triangle that covers the position if it is nearer than what is there; of equal depths,
    /// the first in the scene.
    fn test(&self, nearest: &mut Nearest, name: u32, at: [i32; 2]) {
        let t = &self.triangles[name as usize];
        if !t.covers(at) {
            return;
        }
        let inverse_w = t.inverse_w(at);
        let place = |name: u32| {
            let t = &self.triangles[name as usize];
            (self.geometry.objects[t.object as usize].instance, t.index())
        };
        let is_first = |old| inverse_w == nearest.inverse_w && place(name) < place(old);
        if inverse_w > nearest.inverse_w || nearest.triangle.is_some_and(is_first) {
            *nearest = Nearest {
                triangle: Some(name),
                inverse_w,
            };
        }
    }
}

/// Whether the ray (x, y, 1)·w meets a box where w is not below `near`.
fn meets(tangent: DVec2, bounds: &Aabb, near: f64) -> bool {
    // The near plane is compared in single precision.
    let (mut low, mut high) = (bounds.min.z.max(near * (1.0 - 1e-6)), bounds.max.z);
    for axis in 0..2 {
        let (from, to) = (bounds.min[axis], bounds.max[axis]);
        if tangent[axis] == 0.0 {
            if from > 0.0 || to < 0.0 {
                return false;
            }
            continue;
        }
        let (a, b) = (from / tangent[axis], to / tangent[axis]);
        low = low.max(a.min(b));
        high = high.min(a.max(b));
    }
    low <= high
}
