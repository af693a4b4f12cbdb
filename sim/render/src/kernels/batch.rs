use fearless_simd::prelude::*;

use super::attributes::{Attributes, Details};
use super::shade::{Hit, ShadeContext};
use super::wide::{F, M, Simd, U, V3, WIDTH, apart, max, min, piece, saturate, splat};
use crate::moving::MovingAttributes;
use crate::raster::Needs;

/// [`WIDTH`] places to be shaded.
pub(super) struct Batch<'a, S: Simd> {
    pub(super) lattice: [F<S>; 2],
    /// Scale and shift from lattice to display pixels, for x and y.
    pub(super) display: &'a [[f32; 2]; 2],
    /// 1/w, as the depth test has it, where that is known for the middles of samples.
    pub(super) inverse_w: Option<F<S>>,
    pub(super) triangles: &'a [Attributes],
    pub(super) details: &'a [Details],
    /// Lanes whose place may lie outside of their triangle.
    pub(super) beside: u32,
    /// Which triangle each lane sees: its slot, or its place among the visible.
    pub(super) slots: &'a [u32; WIDTH],
    /// Place among the visible of each slot.
    pub(super) of_slot: Option<&'a [u32]>,
    /// Along the longer side, how many samples share the evaluation.
    pub(super) coarseness: F<S>,
    /// Of triangles that move, and when each lane looks.
    pub(super) moving: Option<(&'a [MovingAttributes], F<S>)>,
}

/// Attributes that the lanes of a batch see.
struct Found<S: Simd> {
    /// As the depth test has it, to the bit.
    inverse_w: F<S>,
    /// Normal in the world, of any length.
    normal: V3<S>,
    /// Position in the object.
    object: V3<S>,
    uv: [F<S>; 2],
    /// Object units and texture units per metre.
    per_metre: [F<S>; 2],
}

impl<S: Simd> Batch<'_, S> {
    /// Direction (not unit length: w = 1) in the world, and the angle a sample spans.
    #[inline(always)]
    pub(super) fn ray(&self, c: &ShadeContext<'_>) -> (V3<S>, F<S>) {
        piece(
            self.coarseness.simd,
            #[inline(always)]
            || {
                // By way of display pixels, so that passes on the display's own grid agree to the bit.
                let [x, y] = self.display;
                let px = self.lattice[0] * x[0] + x[1];
                let py = self.lattice[1] * y[0] + y[1];
                let tx = px * c.tan_step[0] + c.tan_origin[0];
                let ty = py * c.tan_step[1] + c.tan_origin[1];
                let [x, y, z] = c.world_from_direction;
                let direction = match (&c.rolling, self.moving) {
                    (Some(rolling), Some((_, t))) => rolling.direction(t.simd, t, [tx, ty]),
                    _ => V3 {
                        x: tx * x[0] + ty * x[1] + x[2],
                        y: tx * y[0] + ty * y[1] + y[2],
                        z: tx * z[0] + ty * z[1] + z[2],
                    },
                };
                // dα ≤ d tan α; towards the edge of the image a sample spans less.
                let secant2 = tx * tx + ty * ty + 1.0;
                (direction, self.coarseness * c.sample_tan / secant2)
            },
        )
    }

    /// What the samples see; a function of its own, shared by all materials.
    #[inline(always)]
    pub(super) fn hit(&self, c: &ShadeContext<'_>, simd: S, needs: Needs) -> Hit<S> {
        apart(
            simd,
            #[inline(always)]
            || self.hit_inline(c, simd, needs),
        )
    }

    #[inline(always)]
    pub(super) fn hit_inline(&self, c: &ShadeContext<'_>, simd: S, needs: Needs) -> Hit<S> {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let mut found = Found {
            inverse_w: self.inverse_w.unwrap_or(one),
            normal: V3::splat(simd, [0.0; 3]),
            object: V3::splat(simd, [0.0; 3]),
            uv: [zero; 2],
            per_metre: [zero; 2],
        };
        // Neighbours mostly see the same triangle: one round for each that the lanes see.
        let slots = U::from_slice(simd, self.slots);
        let known = self.inverse_w.map(
            #[inline(always)]
            |inverse_w| one / inverse_w,
        );
        let mut rest = (1u32 << WIDTH) - 1;
        while rest != 0 {
            let slot = self.slots[rest.trailing_zeros() as usize % WIDTH];
            let here = slots.simd_eq(slot);
            rest &= !(here.to_bitmask() as u32);
            piece(
                simd,
                #[inline(always)]
                || self.triangle(c, simd, slot, here, known, needs, &mut found),
            );
        }
        let Found {
            inverse_w,
            normal,
            object,
            uv,
            per_metre,
        } = found;
        let w = known.unwrap_or(one / inverse_w);
        let (direction, angle) = self.ray(c);
        let world = self.eye(c, simd).add(direction.scale(w));
        let normal = normal.normalize();
        let towards = match &c.rolling {
            Some(rolling) if !rolling.shading => V3::splat(simd, c.eye).add(world.scale(-one)),
            _ => direction.scale(-one),
        };
        let view = towards.normalize();
        // A slanted surface shows more per sample. One number stands for the ellipse: between its
        // short and its long axis, lest grazing ground blur away altogether.
        let facing = max(normal.dot(view), splat(simd, 0.08));
        let footprint = w * (self.coarseness * c.sample_tan) / facing.sqrt();
        Hit {
            world,
            object,
            normal,
            view,
            uv,
            footprint,
            object_footprint: footprint * per_metre[0],
            uv_footprint: footprint * per_metre[1],
            angle,
        }
    }

    /// Where the eye is when the lanes look \[m\].
    #[inline(always)]
    fn eye(&self, c: &ShadeContext<'_>, simd: S) -> V3<S> {
        match (&c.rolling, self.moving) {
            (Some(rolling), Some((_, t))) => rolling.eye(simd, t),
            _ => V3::splat(simd, c.eye),
        }
    }

    /// What the lanes `here`, at distances `w` if these are known, see of a triangle.
    #[inline(always)]
    fn triangle(
        &self,
        c: &ShadeContext<'_>,
        simd: S,
        slot: u32,
        here: M<S>,
        w: Option<F<S>>,
        needs: Needs,
        found: &mut Found<S>,
    ) {
        let name = self.of_slot.map_or(slot, |places| places[slot as usize]) as usize;
        if let Some((moving, t)) = self.moving {
            let normal_at = match &c.rolling {
                Some(rolling) if !rolling.shading => splat(simd, 0.0),
                _ => t,
            };
            let within = moving[name].within(simd, self.lattice, t, normal_at);
            found.normal = select(here, within.normal, found.normal);
            if needs.object || needs.uv {
                self.details(simd, name, here, within.weights, needs, found);
            }
            return;
        }
        let a = &self.triangles[name].0;
        let dx = self.lattice[0] - a[Attributes::CORNER];
        let dy = self.lattice[1] - a[Attributes::CORNER + 1];
        let over_w = V3 {
            x: plane(a, Attributes::NORMAL, 3, dx, dy),
            y: plane(a, Attributes::NORMAL + 1, 3, dx, dy),
            z: plane(a, Attributes::NORMAL + 2, 3, dx, dy),
        };
        found.normal = select(here, over_w, found.normal);
        if w.is_none() {
            let depth = plane(a, Attributes::DEPTH, 1, dx, dy);
            let low = splat(simd, a[Attributes::DEPTH + 3]);
            let high = splat(simd, a[Attributes::DEPTH + 4]);
            let depth = max(min(depth, high), low);
            found.inverse_w = here.select(depth, found.inverse_w);
        }
        if !(needs.object || needs.uv || self.beside != 0) {
            return;
        }
        let w = w.unwrap_or(splat(simd, 1.0) / found.inverse_w);
        let beside = M::from_bitmask(simd, self.beside.into());
        let a = &self.details[name].0;
        let weight = Details::WEIGHTS;
        let second = plane(a, weight, 1, dx, dy) * w;
        let third = plane(a, weight + 3, 1, dx, dy) * w;
        // A place beside its triangle has the attributes of one within.
        let second = saturate(second);
        let third = min(saturate(third), splat(simd, 1.0) - second);
        let within = triple(a, Details::NORMAL, second, third);
        found.normal = select(here & beside, within, found.normal);
        self.details(simd, name, here, [second, third], needs, found);
    }

    /// What some materials need, at weights of a triangle's second and third corner.
    #[inline(always)]
    fn details(
        &self,
        simd: S,
        name: usize,
        here: M<S>,
        [second, third]: [F<S>; 2],
        needs: Needs,
        found: &mut Found<S>,
    ) {
        let a = &self.details[name].0;
        if needs.object {
            let place = triple(a, Details::OBJECT, second, third);
            found.object = select(here, place, found.object);
            let scale = splat(simd, a[Details::PER_METRE]);
            found.per_metre[0] = here.select(scale, found.per_metre[0]);
        }
        if needs.uv {
            for (k, uv) in found.uv.iter_mut().enumerate() {
                let value = blend(a, Details::UV + k, 2, second, third);
                *uv = here.select(value, *uv);
            }
            let scale = splat(simd, a[Details::PER_METRE + 1]);
            found.per_metre[1] = here.select(scale, found.per_metre[1]);
        }
    }

    /// From the eye \[m\].
    #[inline(always)]
    pub(super) fn distance(&self, c: &ShadeContext<'_>, hit: &Hit<S>) -> F<S> {
        piece(
            hit.angle.simd,
            #[inline(always)]
            || {
                let to = match (&c.rolling, self.moving) {
                    (Some(_), Some(_)) => {
                        let simd = hit.angle.simd;
                        hit.world.add(self.eye(c, simd).scale(splat(simd, -1.0)))
                    }
                    _ => hit
                        .world
                        .add(V3::splat(hit.angle.simd, [-c.eye[0], -c.eye[1], -c.eye[2]])),
                };
                to.dot(to).sqrt()
            },
        )
    }
}

/// Value of a plane whose start and changes along x and y are `stride` apart.
#[inline(always)]
fn plane<S: Simd>(a: &[f32], first: usize, stride: usize, dx: F<S>, dy: F<S>) -> F<S> {
    piece(
        dx.simd,
        #[inline(always)]
        || dx * a[first + stride] + a[first] + dy * a[first + 2 * stride],
    )
}

/// Attribute `first` of a triangle, whose changes follow in steps of `stride`.
#[inline(always)]
fn blend<S: Simd>(
    a: &[f32; Details::COUNT],
    first: usize,
    stride: usize,
    second: F<S>,
    third: F<S>,
) -> F<S> {
    piece(
        second.simd,
        #[inline(always)]
        || second * a[first + stride] + a[first] + third * a[first + 2 * stride],
    )
}

#[inline(always)]
fn triple<S: Simd>(a: &[f32; Details::COUNT], first: usize, second: F<S>, third: F<S>) -> V3<S> {
    V3 {
        x: blend(a, first, 3, second, third),
        y: blend(a, first + 1, 3, second, third),
        z: blend(a, first + 2, 3, second, third),
    }
}

/// `a` where `here`, else `b`.
#[inline(always)]
fn select<S: Simd>(here: M<S>, a: V3<S>, b: V3<S>) -> V3<S> {
    piece(
        a.x.simd,
        #[inline(always)]
        || V3 {
            x: here.select(a.x, b.x),
            y: here.select(a.y, b.y),
            z: here.select(a.z, b.z),
        },
    )
}
