use fearless_simd::prelude::*;
use foveasim_assets::{Irradiance, Material, Scene, Sky};
use foveasim_models::{Msaa, Pose};
use glam::{DMat3, DVec3};

use super::Kernel;
use super::attributes::{Attributes, Details};
use super::batch::Batch;
use super::phong::phong;
use super::rolling::Rolling;
use super::sky::{aerial, sky};
use super::surface::surface;
use super::terrain::terrain;
use super::textured::textured;
use super::wide::{F, I, M, Simd, V3, WIDTH, apart, max, piece, splat};
use crate::fragments::Fragments;
use crate::group::Group;
use crate::moving::MovingAttributes;
use crate::placed::PlacedTile;
use crate::project::{Projection, SUBSAMPLES};
use crate::raster::Needs;
use crate::shadow::{Illumination, ShadowMap, sunlight};
use crate::tile::{BLOCK, LANES, SampleTile, TileBuffers, index_of, position_of};

/// Light that reaches every surface alike.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Light<'a> {
    pub(super) sun_direction: [f32; 3],
    pub(super) sun_radiance: [f32; 3],
    pub(super) ambient_up: [f32; 3],
    pub(super) ambient_down: [f32; 3],
    pub(super) fog: [f32; 3],
    /// One over the distance at which a surface keeps half of its colour [1/m].
    pub(super) per_visibility_m: f32,
    /// What stands between surfaces and the sun; none of it if there are no maps.
    pub(super) shadows: &'a [ShadowMap],
    /// Light from sky and ground by normal, instead of between two colours.
    pub(super) irradiance: Option<Irradiance>,
}

impl Light<'_> {
    fn new(scene: &Scene) -> Self {
        let sun = scene.sun();
        let d = sun.direction.normalize();
        let sky = scene.sky().light();
        Self {
            sun_direction: [d.x as f32, d.y as f32, d.z as f32],
            sun_radiance: sun.radiance,
            ambient_up: sky.ambient_up,
            ambient_down: sky.ambient_down,
            fog: sky.haze,
            per_visibility_m: sky.per_visibility_m,
            shadows: &[],
            irradiance: None,
        }
    }

    /// Light from sky and ground that a surface of unit normal `n` gathers, times 1/π.
    #[inline(always)]
    pub(super) fn ambient<S: Simd>(&self, simd: S, n: V3<S>) -> V3<S> {
        piece(
            simd,
            #[inline(always)]
            || {
                if let Some(irradiance) = &self.irradiance {
                    return gathered(simd, irradiance, n);
                }
                let upward = n.y * 0.5 + 0.5;
                V3::splat(simd, self.ambient_down).mix(V3::splat(simd, self.ambient_up), upward)
            },
        )
    }

    /// Light of the sun on a surface that faces it, times 1/π, as far as it reaches there.
    #[inline(always)]
    pub(super) fn sun<S: Simd>(&self, simd: S, hit: &Hit<S>) -> V3<S> {
        let sun = V3::splat(simd, self.sun_radiance);
        if self.shadows.is_empty() {
            return sun;
        }
        sun.scale(self.sunlight(simd, hit))
    }

    /// How much of the sun's light reaches a place, 0 to 1.
    #[inline(always)]
    pub(super) fn sunlight<S: Simd>(&self, simd: S, hit: &Hit<S>) -> F<S> {
        let p = [
            hit.world.x.to_array(),
            hit.world.y.to_array(),
            hit.world.z.to_array(),
        ];
        let n = [
            hit.normal.x.to_array(),
            hit.normal.y.to_array(),
            hit.normal.z.to_array(),
        ];
        F::from_slice(simd, &sunlight(self.shadows, p, n))
    }
}

/// Light from all directions on a surface of unit normal `n`, times 1/π.
#[inline(always)]
fn gathered<S: Simd>(simd: S, irradiance: &Irradiance, n: V3<S>) -> V3<S> {
    let V3 { x, y, z } = n;
    let basis = [
        splat(simd, 1.0),
        y,
        z,
        x,
        x * y,
        y * z,
        z * z * 3.0 - 1.0,
        x * z,
        x * x - y * y,
    ];
    let mut sum = V3::splat(simd, [0.0; 3]);
    for (c, b) in irradiance.coefficients.iter().zip(basis) {
        sum = sum.add(V3::splat(simd, *c).scale(b));
    }
    // A series that is cut swings below nothing.
    let zero = splat(simd, 0.0);
    V3 {
        x: max(sum.x, zero),
        y: max(sum.y, zero),
        z: max(sum.z, zero),
    }
}

/// What is the same for all samples of a pass.
#[derive(Debug)]
pub(crate) struct ShadeContext<'a> {
    scene: &'a Scene,
    light: Light<'a>,
    pub(super) eye: [f32; 3],
    /// Rows of world_from_eye's rotation, for directions (tx, ty, 1) with w = −z.
    pub(super) world_from_direction: [[f32; 3]; 3],
    pub(super) tan_origin: [f32; 2],
    pub(super) tan_step: [f32; 2],
    /// Width that a sample averages over, as a tangent.
    pub(super) sample_tan: f32,
    /// How the eye moves during a scan.
    pub(super) rolling: Option<Rolling>,
}

impl<'a> ShadeContext<'a> {
    /// Shading averages over `footprint` times the width of a sample.
    pub(crate) fn new(
        scene: &'a Scene,
        world_from_eye: Pose,
        projection: &Projection,
        footprint: f64,
    ) -> Self {
        let rotation = DMat3::from_quat(world_from_eye.orientation);
        let row = |r: DVec3| [r.x as f32, r.y as f32, -r.z as f32];
        let p = world_from_eye.position;
        let (tan_origin, tan_step) = projection.display_tangents();
        let single = |v: glam::DVec2| [v.x as f32, v.y as f32];
        Self {
            scene,
            light: Light::new(scene),
            eye: [p.x as f32, p.y as f32, p.z as f32],
            world_from_direction: [0, 1, 2].map(|i| row(rotation.row(i))),
            tan_origin: single(tan_origin),
            tan_step: single(tan_step),
            sample_tan: (projection.tangent_step().abs().max_element() * footprint) as f32,
            rolling: None,
        }
    }

    /// The same for an eye that moves during a scan.
    pub(crate) fn with_rolling(self, rolling: Option<Rolling>) -> Self {
        Self { rolling, ..self }
    }
}

impl<'a> ShadeContext<'a> {
    /// The same with light of other kinds.
    pub(crate) fn with_illumination(self, illumination: &'a Illumination) -> Self {
        Self {
            light: Light {
                shadows: &illumination.shadows,
                irradiance: illumination.irradiance,
                ..self.light
            },
            ..self
        }
    }
}

/// A visible point, in lanes.
pub(super) struct Hit<S: Simd> {
    /// Position in the world \[m\].
    pub(super) world: V3<S>,
    /// Position in the object.
    pub(super) object: V3<S>,
    /// Unit normal, world frame.
    pub(super) normal: V3<S>,
    /// Unit vector towards the eye.
    pub(super) view: V3<S>,
    pub(super) uv: [F<S>; 2],
    /// Length on the surface that the sample stands for \[m\], in object units, in texture units.
    pub(super) footprint: F<S>,
    pub(super) object_footprint: F<S>,
    pub(super) uv_footprint: F<S>,
    /// Angle that the sample stands for [rad].
    pub(super) angle: F<S>,
}

/// Shades what one tile shows of one material, or of the sky.
pub(crate) struct ShadeTile<'a, 'b> {
    pub(crate) context: &'a ShadeContext<'a>,
    pub(crate) tile: &'a SampleTile,
    /// Where its samples are, if they do not lie evenly.
    pub(crate) placed: Option<&'a PlacedTile>,
    /// Which of the fragments' buckets: 0 is the sky, then each material of the scene.
    pub(crate) bucket: usize,
    pub(crate) needs: Needs,
    pub(crate) fragments: &'a Fragments,
    /// The triangles that are visible in the tile.
    pub(crate) triangles: &'a [Attributes],
    /// Of the same, if they move.
    pub(crate) moving: Option<&'a [MovingAttributes]>,
    /// Of the same; may be empty where no material needs more and each fragment is one sample.
    pub(crate) details: &'a [Details],
    pub(crate) buffers: &'a TileBuffers,
    pub(crate) msaa: Msaa,
    /// Rows of the tile in the pass's image.
    pub(crate) out: &'a mut [&'b mut [[f32; 3]]],
    /// Colours at the positions of visibility of samples that an edge crosses.
    pub(crate) edges: &'a mut [EdgeSample],
}

impl Kernel for ShadeTile<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let context = self.context;
        let needs = self.needs;
        let scene = context.scene;
        let material = self.bucket.checked_sub(1).map(|m| &scene.materials()[m]);
        let flat = match (material, scene.sky()) {
            (Some(Material::Unlit(colour)), _) | (None, Sky::Uniform(colour)) => Some(*colour),
            _ => None,
        };
        if let Some(colour) = flat {
            return self.each_batch(
                simd,
                #[inline(always)]
                |_| V3::splat(simd, colour),
            );
        }
        match material {
            None => self.each_batch(
                simd,
                #[inline(always)]
                |batch| {
                    let (direction, angle) = batch.ray(context);
                    let direction = direction.normalize();
                    sky(simd, scene.sky(), &context.light, direction, angle)
                },
            ),
            Some(Material::Terrain(t)) => self.each_batch(
                simd,
                #[inline(always)]
                |batch| {
                    let hit = batch.hit(context, simd, needs);
                    let colour = piece(
                        simd,
                        #[inline(always)]
                        || terrain(simd, t, &context.light, &hit),
                    );
                    aerial(simd, &context.light, colour, batch.distance(context, &hit))
                },
            ),
            Some(Material::Surface(s)) => self.each_batch(
                simd,
                #[inline(always)]
                |batch| {
                    let hit = batch.hit(context, simd, needs);
                    let colour = piece(
                        simd,
                        #[inline(always)]
                        || surface(simd, s, scene.sky(), &context.light, &hit),
                    );
                    aerial(simd, &context.light, colour, batch.distance(context, &hit))
                },
            ),
            Some(Material::Phong(p)) => self.each_batch(
                simd,
                #[inline(always)]
                |batch| {
                    // In its caller, so that what it does not read is not worked out.
                    let hit = piece(
                        simd,
                        #[inline(always)]
                        || batch.hit_inline(context, simd, needs),
                    );
                    piece(
                        simd,
                        #[inline(always)]
                        || phong(simd, p, &context.light, &hit),
                    )
                },
            ),
            Some(Material::Textured(t)) => self.each_batch(
                simd,
                #[inline(always)]
                |batch| {
                    let hit = batch.hit(context, simd, needs);
                    let colour = piece(
                        simd,
                        #[inline(always)]
                        || textured(simd, t, scene, &context.light, &hit),
                    );
                    aerial(simd, &context.light, colour, batch.distance(context, &hit))
                },
            ),
            Some(other) => unreachable!("no kernel for {other:?}"),
        }
    }
}

impl ShadeTile<'_, '_> {
    /// Shades all fragments, [`WIDTH`] at a time; a function of its own for each material.
    #[inline(always)]
    fn each_batch<S: Simd>(self, simd: S, shade: impl Fn(&Batch<'_, S>) -> V3<S>) {
        apart(
            simd,
            #[inline(always)]
            || self.each_batch_inline(simd, shade),
        );
    }

    #[inline(always)]
    fn each_batch_inline<S: Simd>(mut self, simd: S, shade: impl Fn(&Batch<'_, S>) -> V3<S>) {
        let map = self.tile.affine();
        let display = [0, 1].map(|k| [map.scale[k] as f32, map.origin[k] as f32]);
        // Blocks first, then groups, in one loop: shading is compiled once.
        let fragments = self.fragments;
        let bucket = &fragments.buckets[self.bucket];
        let (blocks, groups) = (&bucket.blocks, bucket.groups.all());
        for step in 0..blocks.len() + groups.len() {
            let block = blocks.get(step).copied();
            let batch = match block {
                Some(block) => self.block(simd, block, &display),
                None => self.group(simd, &groups[step - blocks.len()], &display),
            };
            let colour = shade(&batch);
            let zero = splat(simd, 0.0);
            let r = max(colour.x, zero).to_array();
            let g = max(colour.y, zero).to_array();
            let b = max(colour.z, zero).to_array();
            match block {
                Some(block) => {
                    let [x, y] = position_of(block as usize * LANES).map(|c| c as usize);
                    for (k, row) in (0..).step_by(4).zip(&mut self.out[y..y + 4]) {
                        row[x..x + 4].copy_from_slice(&[
                            [r[k], g[k], b[k]],
                            [r[k + 1], g[k + 1], b[k + 1]],
                            [r[k + 2], g[k + 2], b[k + 2]],
                            [r[k + 3], g[k + 3], b[k + 3]],
                        ]);
                    }
                }
                None => apart(
                    simd,
                    #[inline(always)]
                    || self.write(simd, &groups[step - blocks.len()], [&r, &g, &b]),
                ),
            }
        }
    }

    /// The samples of a block.
    #[inline(always)]
    fn block<'e, S: Simd>(
        &'e self,
        simd: S,
        block: u16,
        display: &'e [[f32; 2]; 2],
    ) -> Batch<'e, S> {
        let [px, py] = position_of(block as usize * LANES);
        let x = (self.tile.origin.x + px) as f32;
        let y = (self.tile.origin.y + py) as f32;
        let one = splat(simd, 1.0);
        let (lattice, coarseness) = match self.placed {
            None => {
                let x = F::from_slice(simd, &MIDDLES[0]) + x;
                ([x, F::from_slice(simd, &MIDDLES[1]) + y], one)
            }
            Some(placed) => piece(
                simd,
                #[inline(always)]
                || {
                    let [x, y] = &placed.middle[block as usize];
                    // Exact: less than 2²⁴ sub-samples.
                    let x = I::from_slice(simd, x).to_float::<F<S>>();
                    let y = I::from_slice(simd, y).to_float::<F<S>>();
                    let width = F::from_slice(simd, &placed.width[block as usize]);
                    ([x * PER_SAMPLE, y * PER_SAMPLE], width)
                },
            ),
        };
        let first = block as usize * self.msaa.positions() as usize;
        let depth = &self.buffers.depth[first];
        let time = self
            .placed
            .and_then(|placed| placed.time.get(block as usize));
        let moving = match (self.moving, time) {
            (Some(moving), Some(time)) => Some((moving, F::from_slice(simd, time))),
            (Some(moving), None) => Some((moving, splat(simd, 0.0))),
            (None, _) => None,
        };
        Batch {
            moving,
            lattice,
            display,
            // Several positions have depths of their own; none is the middle's.
            inverse_w: (self.msaa == Msaa::One).then(
                #[inline(always)]
                || F::from_slice(simd, depth),
            ),
            triangles: self.triangles,
            details: self.details,
            // The middle of a sample all of whose positions are covered is covered.
            beside: 0,
            slots: &self.buffers.slot[first],
            of_slot: Some(&self.fragments.of_slot),
            coarseness,
        }
    }

    /// Evaluations from anywhere in the tile.
    #[inline(always)]
    fn group<'e, S: Simd>(
        &'e self,
        simd: S,
        group: &'e Group,
        display: &'e [[f32; 2]; 2],
    ) -> Batch<'e, S> {
        let Some(placed) = self.placed else {
            // Exact: halves of whole samples.
            let [x, y] = &group.middle;
            let x = F::from_slice(simd, x) + self.tile.origin.x as f32;
            let y = F::from_slice(simd, y) + self.tile.origin.y as f32;
            let coarseness = F::from_slice(simd, &group.coarseness);
            return self.loose(group, display, [x, y], coarseness);
        };
        let found = Found::new(placed, group, self.buffers);
        let [x, y] = &found.at;
        let at = [F::from_slice(simd, x), F::from_slice(simd, y)];
        let width = F::from_slice(simd, &found.width);
        let batch = self.loose(group, display, at, width);
        match self.moving {
            None => batch,
            Some(moving) => Batch {
                moving: Some((moving, F::from_slice(simd, &found.time))),
                inverse_w: Some(F::from_slice(simd, &found.inverse_w)),
                ..batch
            },
        }
    }

    /// Evaluations at these places.
    #[inline(always)]
    fn loose<'e, S: Simd>(
        &'e self,
        group: &'e Group,
        display: &'e [[f32; 2]; 2],
        lattice: [F<S>; 2],
        coarseness: F<S>,
    ) -> Batch<'e, S> {
        Batch {
            moving: None,
            lattice,
            display,
            inverse_w: None,
            triangles: self.triangles,
            details: self.details,
            beside: group.beside,
            slots: &group.names,
            of_slot: None,
            coarseness,
        }
    }

    /// Puts colours wherever what they are of is seen.
    #[inline(always)]
    fn write<S: Simd>(&mut self, simd: S, group: &Group, [r, g, b]: [&[f32; WIDTH]; 3]) {
        let positions = self.msaa.positions();
        let every = (1u64 << positions) - 1;
        for lane in 0..group.count.min(WIDTH) {
            let colour = [r[lane], g[lane], b[lane]];
            let [x, y] = group.first[lane];
            if group.size[lane] == [1, 1] {
                self.put(simd, [x, y], group.seen[lane] & every, colour);
                continue;
            }
            let [width, height] = group.size[lane];
            for dy in 0..height {
                for dx in 0..width {
                    let sample = u32::from(dy) * u32::from(width) + u32::from(dx);
                    let seen = group.seen[lane] >> (sample * positions) & every;
                    if seen != 0 {
                        self.put(simd, [x + dx, y + dy], seen, colour);
                    }
                }
            }
        }
    }

    /// Puts a colour at the positions of a sample where it is seen.
    #[inline(always)]
    fn put<S: Simd>(&mut self, simd: S, [x, y]: [u8; 2], seen: u64, [r, g, b]: [f32; 3]) {
        let Some(edge) = self.fragments.edge(x.into(), y.into()) else {
            self.out[y as usize][x as usize] = [r, g, b];
            return;
        };
        // All four positions at once: which of them is hard to foresee.
        let colour = F::from_slice(
            simd,
            &[r, g, b, 0.0, r, g, b, 0.0, r, g, b, 0.0, r, g, b, 0.0],
        );
        let here = M::from_bitmask(simd, POSITIONS[seen as usize % POSITIONS.len()].into());
        let edge = self.edges[edge].0.as_flattened_mut();
        let old = F::from_slice(simd, edge);
        here.select(colour, old).store_slice(edge);
    }
}

/// Colours at the four positions of visibility of a sample that an edge crosses; the fourth number of each is of no
/// use.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct EdgeSample(pub(crate) [[f32; 4]; 4]);

impl EdgeSample {
    /// No light.
    pub(crate) const DARK: Self = Self([[0.0; 4]; 4]);

    /// The mean of the four: in pairs, so that four equal colours give that colour, bit for bit.
    pub(crate) fn mean(&self) -> [f32; 3] {
        let [a, b, c, d] = self.0;
        std::array::from_fn(|k| ((a[k] + b[k]) + (c[k] + d[k])) * 0.25)
    }
}

/// The numbers of an edge sample that a set of its positions holds.
const POSITIONS: [u16; 16] = {
    let mut lanes = [0; 16];
    let mut set = 0;
    while set < 16 {
        let mut p = 0;
        while p < 4 {
            if set >> p & 1 != 0 {
                lanes[set] |= 0xf << (4 * p);
            }
            p += 1;
        }
        set += 1;
    }
    lanes
};

/// Of a group's samples that a map has put anywhere.
struct Found {
    /// Display pixels.
    at: [[f32; WIDTH]; 2],
    /// What each stands for.
    width: [f32; WIDTH],
    /// When each looks, on rolling displays.
    time: [f32; WIDTH],
    /// 1/w as the depth test found it at samples that are shaded one by one; of the sky, 1.
    inverse_w: [f32; WIDTH],
}

impl Found {
    /// No lanes, so it is one function for all materials.
    #[inline(never)]
    fn new(placed: &PlacedTile, group: &Group, buffers: &TileBuffers) -> Self {
        let mut found = Self {
            at: [[0.0; WIDTH]; 2],
            width: [0.0; WIDTH],
            time: [0.0; WIDTH],
            inverse_w: [0.0; WIDTH],
        };
        for (lane, &[x, y]) in group.first.iter().enumerate() {
            let index = index_of(x.into(), y.into());
            let (block, at) = (index / LANES, index % LANES);
            let [x, y] = &placed.middle[block];
            found.at[0][lane] = x[at] as f32 * PER_SAMPLE;
            found.at[1][lane] = y[at] as f32 * PER_SAMPLE;
            found.width[lane] = placed.width[block][at];
            found.time[lane] = placed.time.get(block).map_or(0.0, |t| t[at]);
            let seen = buffers.depth[block][at];
            found.inverse_w[lane] = if seen > 0.0 { seen } else { 1.0 };
        }
        found
    }
}

/// Samples per sub-sample.
const PER_SAMPLE: f32 = 1.0 / SUBSAMPLES as f32;

/// Middles of a block's samples from its first corner, across and down.
const MIDDLES: [[f32; WIDTH]; 2] = {
    let mut middles = [[0.0; WIDTH]; 2];
    let mut lane = 0;
    while lane < WIDTH {
        middles[0][lane] = (lane % BLOCK[0] as usize) as f32 + 0.5;
        middles[1][lane] = (lane / BLOCK[0] as usize) as f32 + 0.5;
        lane += 1;
    }
    middles
};
