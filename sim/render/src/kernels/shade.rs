use fearless_simd::prelude::*;
use foveasim_assets::{Material, Scene, Sky};
use foveasim_models::Pose;
use glam::{DMat3, DVec3};

use super::Kernel;
use super::lanes::{F, Simd, V3, max, min, saturate, splat};
use super::sky::{aerial, sky};
use super::surface::surface;
use super::terrain::terrain;
use super::textured::textured;
use crate::project::Projection;
use crate::tile::{SampleTile, position_of};

/// What shading needs of one triangle: each attribute as a start and its change towards the second
/// and the third corner, and the functions that give a sample's place in the triangle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Attributes(pub(crate) [f32; Attributes::COUNT]);

impl Attributes {
    /// Lattice position of the first corner of the set-up triangle [samples].
    pub(crate) const CORNER: usize = 0;
    /// Weight over w of the second and third corner: at CORNER, change along x, along y.
    pub(crate) const WEIGHTS: usize = 2;
    /// Normal in the world: at the first corner, towards the second, towards the third.
    pub(crate) const NORMAL: usize = 8;
    /// Position in the object.
    pub(crate) const OBJECT: usize = 17;
    /// Texture coordinates.
    pub(crate) const UV: usize = 26;
    /// Object units per metre; texture units per metre.
    pub(crate) const PER_METRE: usize = 32;
    pub(crate) const COUNT: usize = 34;
}

/// Light that reaches every surface alike.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Light {
    pub(super) sun_direction: [f32; 3],
    pub(super) sun_radiance: [f32; 3],
    pub(super) ambient_up: [f32; 3],
    pub(super) ambient_down: [f32; 3],
    pub(super) fog: [f32; 3],
    /// One over the distance at which a surface keeps half of its colour [1/m].
    pub(super) per_visibility_m: f32,
}

impl Light {
    fn new(scene: &Scene) -> Self {
        let sun = scene.sun();
        let d = sun.direction.normalize();
        let (ambient_up, ambient_down, fog, per_visibility_m) = match scene.sky() {
            Sky::Analytic(a) => {
                let up = std::array::from_fn(|i| 0.55 * a.zenith[i] + 0.30 * a.horizon[i]);
                (up, [0.075, 0.085, 0.045], a.horizon, 1.0 / a.visibility_m)
            }
            Sky::Uniform(c) => (*c, *c, *c, 0.0),
            _ => ([0.0; 3], [0.0; 3], [0.0; 3], 0.0),
        };
        Self {
            sun_direction: [d.x as f32, d.y as f32, d.z as f32],
            sun_radiance: sun.radiance,
            ambient_up,
            ambient_down,
            fog,
            per_visibility_m,
        }
    }

    /// Light from sky and ground that a surface of unit normal `n` gathers, times 1/π.
    #[inline(always)]
    pub(super) fn ambient<S: Simd>(&self, simd: S, n: V3<S>) -> V3<S> {
        let upward = n.y * 0.5 + 0.5;
        V3::splat(simd, self.ambient_down).mix(V3::splat(simd, self.ambient_up), upward)
    }
}

/// What is the same for all samples of a pass.
#[derive(Debug)]
pub(crate) struct ShadeContext<'a> {
    scene: &'a Scene,
    light: Light,
    eye: [f32; 3],
    /// Rows of world_from_eye's rotation, for directions (tx, ty, 1) with w = −z.
    world_from_direction: [[f32; 3]; 3],
    tan_origin: [f32; 2],
    tan_step: [f32; 2],
    /// Width of a sample as a tangent.
    sample_tan: f32,
}

impl<'a> ShadeContext<'a> {
    pub(crate) fn new(scene: &'a Scene, world_from_eye: Pose, projection: &Projection) -> Self {
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
            sample_tan: projection.tangent_step().abs().max_element() as f32,
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

/// Shades samples of one tile that see the same material, or the sky.
pub(crate) struct ShadeTile<'a, 'b> {
    pub(crate) context: &'a ShadeContext<'a>,
    pub(crate) tile: &'a SampleTile,
    /// Index of the material; `None` for the sky.
    pub(crate) material: Option<u32>,
    /// Places of the samples in the tile's buffers.
    pub(crate) samples: &'a [u16],
    /// The triangles that are visible in the tile.
    pub(crate) triangles: &'a [Attributes],
    /// Which of `triangles` each slot of the tile's buffers is.
    pub(crate) triangle_of_slot: &'a [u32],
    pub(crate) slot: &'a [u32],
    pub(crate) depth: &'a [f32],
    /// Rows of the tile in the pass's image.
    pub(crate) out: &'a mut [&'b mut [[f32; 3]]],
}

impl Kernel for ShadeTile<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let context = self.context;
        match self
            .material
            .map(|m| &context.scene.materials()[m as usize])
        {
            None => self.each_block(
                simd,
                #[inline(always)]
                |block| {
                    let (direction, angle) = block.ray(context, simd);
                    sky(
                        simd,
                        context.scene.sky(),
                        &context.light,
                        direction.normalize(),
                        angle,
                    )
                },
            ),
            Some(Material::Terrain(t)) => self.each_block(
                simd,
                #[inline(always)]
                |block| {
                    let hit = block.hit(context, simd);
                    let colour = terrain(simd, t, &context.light, &hit);
                    aerial(simd, &context.light, colour, block.distance(context, &hit))
                },
            ),
            Some(Material::Surface(s)) => self.each_block(
                simd,
                #[inline(always)]
                |block| {
                    let hit = block.hit(context, simd);
                    let colour = surface(simd, s, context.scene.sky(), &context.light, &hit);
                    aerial(simd, &context.light, colour, block.distance(context, &hit))
                },
            ),
            Some(Material::Textured(t)) => self.each_block(
                simd,
                #[inline(always)]
                |block| {
                    let hit = block.hit(context, simd);
                    let colour = textured(simd, t, context.scene, &context.light, &hit);
                    aerial(simd, &context.light, colour, block.distance(context, &hit))
                },
            ),
            Some(Material::Unlit(colour)) => {
                self.each_block(
                    simd,
                    #[inline(always)]
                    |_| V3::splat(simd, *colour),
                );
            }
            Some(other) => unreachable!("no kernel for {other:?}"),
        }
    }
}

impl ShadeTile<'_, '_> {
    #[inline(always)]
    fn each_block<S: Simd>(self, simd: S, shade: impl Fn(&Block<'_, S>) -> V3<S>) {
        let map = self.tile.affine();
        let display = [0, 1].map(|k| [map.scale[k] as f32, map.origin[k] as f32]);
        for samples in self.samples.chunks(8) {
            // A block that is not full repeats its last sample.
            let mut places = [samples[samples.len() - 1] as usize; 8];
            let (mut x, mut y, mut inverse_w) = ([0.0; 8], [0.0; 8], [0.0; 8]);
            for i in 0..8 {
                if let Some(&sample) = samples.get(i) {
                    places[i] = sample as usize;
                }
                let [px, py] = position_of(places[i]);
                x[i] = (self.tile.origin.x + px) as f32 + 0.5;
                y[i] = (self.tile.origin.y + py) as f32 + 0.5;
                inverse_w[i] = self.depth[places[i]];
            }
            let lattice = [F::from_slice(simd, &x), F::from_slice(simd, &y)];
            let inverse_w = F::from_slice(simd, &inverse_w);
            let none = Attributes([0.0; Attributes::COUNT]);
            let mut triangles = [&none; 8];
            if self.material.is_some() {
                for (triangle, place) in triangles.iter_mut().zip(places) {
                    let slot = self.slot[place] as usize;
                    *triangle = &self.triangles[self.triangle_of_slot[slot] as usize];
                }
            }
            let colour = shade(&Block {
                lattice,
                display: &display,
                inverse_w,
                triangles,
            });
            let zero = splat(simd, 0.0);
            let r = max(colour.x, zero).to_array();
            let g = max(colour.y, zero).to_array();
            let b = max(colour.z, zero).to_array();
            for (i, &sample) in samples.iter().enumerate() {
                let [x, y] = position_of(sample as usize);
                self.out[y as usize][x as usize] = [r[i], g[i], b[i]];
            }
        }
    }
}

/// Eight samples.
struct Block<'a, S: Simd> {
    lattice: [F<S>; 2],
    /// Scale and shift from lattice to display pixels, for x and y.
    display: &'a [[f32; 2]; 2],
    inverse_w: F<S>,
    triangles: [&'a Attributes; 8],
}

impl<S: Simd> Block<'_, S> {
    /// Direction (not unit length: w = 1) in the world, and the angle a sample spans.
    #[inline(always)]
    fn ray(&self, c: &ShadeContext<'_>, simd: S) -> (V3<S>, F<S>) {
        // By way of display pixels, so that passes on the display's own grid agree to the bit.
        let [x, y] = self.display;
        let px = self.lattice[0] * x[0] + x[1];
        let py = self.lattice[1] * y[0] + y[1];
        let tx = px * c.tan_step[0] + c.tan_origin[0];
        let ty = py * c.tan_step[1] + c.tan_origin[1];
        let [x, y, z] = c.world_from_direction;
        let direction = V3 {
            x: tx * x[0] + ty * x[1] + x[2],
            y: tx * y[0] + ty * y[1] + y[2],
            z: tx * z[0] + ty * z[1] + z[2],
        };
        // dα ≤ d tan α; towards the edge of the image a sample spans less.
        let secant2 = tx * tx + ty * ty + 1.0;
        (direction, splat(simd, c.sample_tan) / secant2)
    }

    /// Attribute `index` of each lane's triangle.
    #[inline(always)]
    fn at(&self, simd: S, index: usize) -> F<S> {
        let t = &self.triangles;
        let values = [
            t[0].0[index],
            t[1].0[index],
            t[2].0[index],
            t[3].0[index],
            t[4].0[index],
            t[5].0[index],
            t[6].0[index],
            t[7].0[index],
        ];
        F::from_slice(simd, &values)
    }

    /// A corner's share of the sample, over w.
    #[inline(always)]
    fn weight(&self, simd: S, first: usize, dx: F<S>, dy: F<S>) -> F<S> {
        self.at(simd, first) + self.at(simd, first + 1) * dx + self.at(simd, first + 2) * dy
    }

    /// Attribute `first`, whose changes follow in steps of `stride`.
    #[inline(always)]
    fn blend(&self, simd: S, first: usize, stride: usize, second: F<S>, third: F<S>) -> F<S> {
        self.at(simd, first)
            + self.at(simd, first + stride) * second
            + self.at(simd, first + 2 * stride) * third
    }

    #[inline(always)]
    fn triple(&self, simd: S, first: usize, second: F<S>, third: F<S>) -> V3<S> {
        V3 {
            x: self.blend(simd, first, 3, second, third),
            y: self.blend(simd, first + 1, 3, second, third),
            z: self.blend(simd, first + 2, 3, second, third),
        }
    }

    /// What the samples see; a function of its own, shared by all materials.
    #[inline(always)]
    fn hit(&self, c: &ShadeContext<'_>, simd: S) -> Hit<S> {
        simd.vectorize(
            #[inline(always)]
            || self.hit_inline(c, simd),
        )
    }

    #[inline(always)]
    fn hit_inline(&self, c: &ShadeContext<'_>, simd: S) -> Hit<S> {
        let one = splat(simd, 1.0);
        let w = one / self.inverse_w;
        let (direction, angle) = self.ray(c, simd);
        let world = V3::splat(simd, c.eye).add(direction.scale(w));

        let dx = self.lattice[0] - self.at(simd, Attributes::CORNER);
        let dy = self.lattice[1] - self.at(simd, Attributes::CORNER + 1);
        // Snapping may put a sample just outside its triangle: its attributes stay within.
        let second = saturate(self.weight(simd, Attributes::WEIGHTS, dx, dy) * w);
        let third = saturate(self.weight(simd, Attributes::WEIGHTS + 3, dx, dy) * w);
        let third = min(third, one - second);
        let normal = self
            .triple(simd, Attributes::NORMAL, second, third)
            .normalize();
        let object = self.triple(simd, Attributes::OBJECT, second, third);
        let uv = [
            self.blend(simd, Attributes::UV, 2, second, third),
            self.blend(simd, Attributes::UV + 1, 2, second, third),
        ];
        let view = direction.scale(-one).normalize();
        // A slanted surface shows more per sample. One number stands for the ellipse: between its
        // short and its long axis, lest grazing ground blur away altogether.
        let facing = max(normal.dot(view), splat(simd, 0.08));
        let footprint = w * c.sample_tan / facing.sqrt();
        Hit {
            world,
            object,
            normal,
            view,
            uv,
            footprint,
            object_footprint: footprint * self.at(simd, Attributes::PER_METRE),
            uv_footprint: footprint * self.at(simd, Attributes::PER_METRE + 1),
            angle,
        }
    }

    /// From the eye \[m\].
    #[inline(always)]
    fn distance(&self, c: &ShadeContext<'_>, hit: &Hit<S>) -> F<S> {
        let to = hit
            .world
            .add(V3::splat(hit.angle.simd, [-c.eye[0], -c.eye[1], -c.eye[2]]));
        to.dot(to).sqrt()
    }
}
