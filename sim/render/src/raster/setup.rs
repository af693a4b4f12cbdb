use std::ops::Range;

use foveasim_assets::Scene;
use foveasim_models::Work;
use glam::UVec2;
use rayon::prelude::*;

use super::clip::{SnappedCorner, clip};
use super::plane::Plane;
use super::{Bins, EyeVertex, Object, ViewGeometry};
use crate::RenderOptions;
use crate::kernels::{SetUpEight, dispatch};
use crate::project::{Projection, SUBSAMPLES};

/// A triangle ready for rasterization.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SetUpTriangle {
    /// Corners in sub-samples, positive area with y down. The first is the mesh triangle's first; seen
    /// from the front the other two have changed places.
    pub(crate) corners: [[i32; 2]; 3],
    /// 1/w at the first corner, and its change per sample along x and y [1/m].
    pub(crate) depth: [f32; 3],
    /// Least and greatest 1/w of the triangle [1/m].
    pub(crate) depth_range: [f32; 2],
    /// First and last sample that it may cover, along x and y: inside the lattice.
    pub(crate) bounds: [[u16; 2]; 2],
    /// Whether its edge functions fit 31 bits near it.
    pub(crate) is_small: bool,
    /// Whether its corners are those of the mesh triangle (not of a part that clipping left), with an
    /// area of 31 bits.
    pub(crate) is_whole: bool,
    /// Which object of the view.
    pub(crate) object: u32,
    /// Which triangle of its mesh; the highest bit is set where it is seen from behind.
    pub(crate) triangle: u32,
}

/// Marks a triangle that is seen from behind.
pub(crate) const BEHIND: u32 = 1 << 31;

/// All triangles of a pass that may be visible, in jobs.
#[derive(Debug)]
pub(crate) struct PassTriangles {
    pub(super) jobs: Vec<Job>,
}

/// What one worker set up: triangles, and which of them meet which tile.
#[derive(Debug)]
pub(super) struct Job {
    pub(super) triangles: Vec<SetUpTriangle>,
    pub(super) bins: Bins,
}

/// Triangles per parallel job.
const JOB: usize = 4096;

/// Part of an object's triangles.
#[derive(Debug, Clone)]
pub(crate) struct Segment {
    pub(crate) object: u32,
    pub(crate) range: Range<usize>,
}

/// What set-up needs to know of the pass.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SetUp<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) geometry: &'a ViewGeometry,
    pub(crate) projection: &'a Projection,
    pub(crate) options: &'a RenderOptions,
    /// How far from its middle a sample's visibility may be asked for [sub-samples].
    pub(crate) reach: i32,
    /// First sample of the box that is drawn, and one past its last.
    pub(crate) drawn: [UVec2; 2],
}

/// Sets up all triangles of `objects` (places in the view's list) that may cover a sample.
pub(crate) fn set_up(pass: &SetUp<'_>, objects: &[u32]) -> (PassTriangles, Work) {
    let size = pass.projection.size;
    let results: Vec<_> = segments(pass.scene, pass.geometry, objects)
        .into_par_iter()
        .map(|segments| {
            let mut emitter = Emitter::new(pass);
            for segment in segments {
                emitter.segment(&segment);
            }
            let bins = Bins::new(&emitter.out, size);
            let job = Job {
                triangles: emitter.out,
                bins,
            };
            (job, emitter.work)
        })
        .collect();
    let mut total = Work::default();
    let mut jobs = Vec::with_capacity(results.len());
    for (job, work) in results {
        total += work;
        jobs.push(job);
    }
    (PassTriangles { jobs }, total)
}

/// Cuts the triangles of all objects into jobs of about equal size.
pub(crate) fn segments(
    scene: &Scene,
    geometry: &ViewGeometry,
    objects: &[u32],
) -> Vec<Vec<Segment>> {
    let mut jobs = vec![Vec::new()];
    let mut room = JOB;
    for &object in objects {
        let mesh = geometry.objects[object as usize].mesh;
        let count = scene.meshes()[mesh as usize].triangles().len();
        let mut start = 0;
        while start < count {
            if room == 0 {
                jobs.push(Vec::new());
                room = JOB;
            }
            let end = count.min(start + room);
            let segment = Segment {
                object,
                range: start..end,
            };
            if let Some(job) = jobs.last_mut() {
                job.push(segment);
            }
            room -= end - start;
            start = end;
        }
    }
    jobs
}

impl PassTriangles {
    /// The triangles that meet tile (x, y), in the order they were set up. Copied, so that what a tile
    /// reads again and again lies together, and is fetched from far memory with all reads in flight.
    pub(crate) fn tile(&self, x: u32, y: u32, out: &mut Vec<SetUpTriangle>) {
        out.clear();
        for job in &self.jobs {
            let bin = job.bins.tile(x, y);
            out.extend(bin.iter().map(|&place| job.triangles[place as usize]));
        }
    }

    /// All triangles, in the order they were set up.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &SetUpTriangle> {
        self.jobs.iter().flat_map(|job| &job.triangles)
    }
}

/// Sets up triangles one by one: what comes of those that the kernel accepted, and of those that it
/// leaves to exact arithmetic.
pub(crate) struct Emitter<'a> {
    pub(crate) pass: &'a SetUp<'a>,
    pub(crate) out: Vec<SetUpTriangle>,
    pub(crate) work: Work,
}

impl<'a> Emitter<'a> {
    fn new(pass: &'a SetUp<'a>) -> Self {
        Self {
            pass,
            out: Vec::new(),
            work: Work::default(),
        }
    }

    fn segment(&mut self, segment: &Segment) {
        let SetUp {
            scene, geometry, ..
        } = *self.pass;
        let object = geometry.objects[segment.object as usize];
        let mesh = &scene.meshes()[object.mesh as usize];
        self.work.triangles += segment.range.len() as u64;
        let kernel = SetUpEight {
            vertices: geometry.of(&object, scene),
            triangles: &mesh.triangles()[segment.range.clone()],
            first: segment.range.start as u32,
            object: segment.object,
            both_faces: self.shows_both_faces(&object),
            emitter: self,
        };
        let simd = kernel.emitter.pass.options.simd;
        dispatch(simd, kernel);
    }

    fn shows_both_faces(&self, object: &Object) -> bool {
        !self.pass.options.skip.back_faces
            || self.pass.scene.instances()[object.instance as usize].two_sided
    }

    /// Sets up a triangle that the kernel leaves over: too large for 32 bits, or reaching behind the
    /// near plane or beyond the guard.
    pub(crate) fn exact(&mut self, v: [&EyeVertex; 3], object: u32, triangle: u32, both: bool) {
        let projection = self.pass.projection;
        if projection.all_beyond_one_side(v) {
            self.work.triangles_outside += 1;
            return;
        }
        let plane = Plane::new(v);
        if !plane.det.is_finite() {
            // A vertex that is nowhere.
            self.work.triangles_outside += 1;
            return;
        }
        let snapped = v.map(|v| {
            projection
                .snap_vertex(v)
                .map(|s| (s, 1.0 / f64::from(v.eye[2])))
        });
        let polygon = match snapped {
            [Some(a), Some(b), Some(c)] => vec![a, b, c],
            _ => clip(v, projection),
        };
        let (mut any, mut away) = (false, false);
        for i in 2..polygon.len() {
            let fan = [polygon[0], polygon[i - 1], polygon[i]];
            match area_sign(fan.map(|c| c.0)) {
                0 => {}
                sign => {
                    let behind = sign > 0;
                    if behind && !both {
                        away = true;
                    } else {
                        any |= self.emit(fan, plane, object, triangle, behind);
                    }
                }
            }
        }
        if away && !any {
            self.work.triangles_back_facing += 1;
        } else if !any {
            self.work.triangles_outside += 1;
        }
    }

    /// Adds a triangle, unless its bounds hold no sample.
    fn emit(
        &mut self,
        corners: [SnappedCorner; 3],
        plane: Plane,
        object: u32,
        triangle: u32,
        behind: bool,
    ) -> bool {
        let projection = self.pass.projection;
        let [a, b, c] = corners.map(|c| c.0);
        let mut set_up = SetUpTriangle {
            // Seen from outside they run counter-clockwise with y up: turn them for y down.
            corners: if behind { [a, b, c] } else { [a, c, b] },
            depth: [0.0; 3],
            depth_range: [0.0; 2],
            bounds: [[0; 2]; 2],
            is_small: false,
            is_whole: false,
            object,
            triangle: triangle | if behind { BEHIND } else { 0 },
        };
        let Some(bounds) = bounds(&set_up.corners, self.pass.drawn, self.pass.reach) else {
            return false;
        };
        set_up.bounds = bounds;
        let inverse_w = corners.map(|c| c.1);
        let low = inverse_w.iter().fold(f64::INFINITY, |a, &b| a.min(b));
        let high = inverse_w.iter().fold(0.0, |a: f64, &b| a.max(b));
        let depth = plane.depth(a, projection);
        // Seen edge-on there may be no usable slope; such a sliver is as far as its farthest corner.
        set_up.depth = if depth.iter().all(|d| d.is_finite()) {
            depth
        } else {
            [low as f32, 0.0, 0.0]
        };
        set_up.depth_range = [low as f32, high as f32];
        self.out.push(set_up);
        self.work.triangles_set_up += 1;
        true
    }
}

impl SetUpTriangle {
    /// Which triangle of the mesh.
    pub(crate) fn index(&self) -> usize {
        (self.triangle & !BEHIND) as usize
    }

    /// Whether it is seen from behind.
    pub(crate) fn is_behind(&self) -> bool {
        self.triangle & BEHIND != 0
    }
}

/// First and last sample of those `drawn` (the first, and one past the last) of which a position up to `reach`
/// sub-samples from the centre lies within the bounds of a triangle, along x and y; `None` if there is none.
fn bounds(corners: &[[i32; 2]; 3], drawn: [UVec2; 2], reach: i32) -> Option<[[u16; 2]; 2]> {
    let mut bounds = [[0; 2]; 2];
    for axis in 0..2 {
        let c = corners.map(|c| c[axis]);
        let (low, high) = (c[0].min(c[1]).min(c[2]), c[0].max(c[1]).max(c[2]));
        let half = SUBSAMPLES / 2;
        // Shifting right rounds down, for negative numbers too.
        let first = (low - half - reach + SUBSAMPLES - 1) >> SUBSAMPLES.ilog2();
        let last = (high - half + reach) >> SUBSAMPLES.ilog2();
        let [begin, end] = drawn.map(|d| d[axis] as i32);
        let (first, last) = (first.max(begin), last.min(end - 1));
        if first > last {
            return None;
        }
        bounds[axis] = [first as u16, last as u16];
    }
    Some(bounds)
}

/// Sign of the area with y down: negative faces the eye.
fn area_sign(c: [[i32; 2]; 3]) -> i64 {
    let [ax, ay] = [0, 1].map(|k| i64::from(c[1][k]) - i64::from(c[0][k]));
    let [bx, by] = [0, 1].map(|k| i64::from(c[2][k]) - i64::from(c[0][k]));
    (ax * by - bx * ay).signum()
}
