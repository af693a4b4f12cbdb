//! Pictures beside what they are defined to be: everything in double precision, value and gradient without rounding, the
//! transfer function itself instead of its table, one sample after another to the end of the ray.

use foveasim_assets::{GeneratedVolume, TransferFunction, Volume};
use foveasim_models::{Eye, View, Viewport};
use glam::{DVec2, DVec3, UVec2};

use crate::{CastOptions, Caster, orbit};

/// Voxels as they are, to be looked at in base steps with the light of [`CastOptions::default`].
struct Exact<'a> {
    volume: &'a Volume,
    transfer: &'a TransferFunction,
    values: Vec<f64>,
}

impl<'a> Exact<'a> {
    fn new(volume: &'a Volume, transfer: &'a TransferFunction) -> Self {
        let [slope, intercept] = volume.scale();
        let value = |k| slope * volume.voxels().get(k) + intercept;
        Self {
            volume,
            transfer,
            values: (0..volume.voxels().len()).map(value).collect(),
        }
    }

    fn voxel(&self, place: [i64; 3]) -> f64 {
        let dims = self.volume.dims().to_array().map(i64::from);
        let [x, y, z] = std::array::from_fn(|a| place[a].clamp(0, dims[a] - 1));
        self.values[((z * dims[1] + y) * dims[0] + x) as usize]
    }

    /// What corners of a cell have, at a place in it.
    fn trilinear(place: DVec3, corner: impl Fn([i64; 3]) -> DVec3) -> DVec3 {
        let cell = place.floor();
        let inside = place - cell;
        let at = |k: i64| {
            let on = [0, 1, 2].map(|a| k >> a & 1);
            let weight = |a| {
                if on[a] == 1 {
                    inside[a]
                } else {
                    1.0 - inside[a]
                }
            };
            let place = std::array::from_fn(|a| cell[a] as i64 + on[a]);
            weight(0) * weight(1) * weight(2) * corner(place)
        };
        (0..8).map(at).sum()
    }

    fn value(&self, place: DVec3) -> f64 {
        Self::trilinear(place, |at| DVec3::splat(self.voxel(at))).x
    }

    /// Differences between the neighbours of voxels.
    fn differences(&self, place: DVec3) -> DVec3 {
        Self::trilinear(place, |[x, y, z]| {
            let along = |dx, dy, dz| {
                self.voxel([x + dx, y + dy, z + dz]) - self.voxel([x - dx, y - dy, z - dz])
            };
            DVec3::new(along(1, 0, 0), along(0, 1, 0), along(0, 0, 1))
        })
    }

    /// Linear light.
    fn seen(&self, view: &View, px: DVec2) -> DVec3 {
        let (own, pose) = (CastOptions::default(), view.poses[0]);
        let index_from_world = self.volume.world_from_index().inverse();
        let along = (pose.orientation * view.optics.direction(px)).normalize();
        let eye = index_from_world.transform_point3(pose.position);
        let step = own.step_voxels * self.volume.spacing();
        let step_index = index_from_world.transform_vector3(along * step);
        let low = DVec3::splat(1.0 / 512.0);
        let high = self.volume.dims().as_dvec3() - 1.0 - low;
        let ends = [(low - eye) / step_index, (high - eye) / step_index];
        let first = ends[0].min(ends[1]).max_element().max(0.0).ceil();
        let last = ends[0].max(ends[1]).min_element().floor();
        let (mut light, mut through, mut k) = (DVec3::ZERO, 1.0, first);
        while k <= last {
            let place = eye + step_index * k;
            k += 1.0;
            let (colour, opacity) = self.transfer.at(self.value(place));
            if opacity == 0.0 {
                continue;
            }
            let normal = index_from_world.matrix3.transpose() * self.differences(place);
            let cosine = normal.normalize_or_zero().dot(along).abs();
            let phong = own.phong.unwrap();
            let highlight = (2.0 * cosine * cosine - 1.0)
                .max(0.0)
                .powi(phong.shininess as i32);
            let lit = f64::from(phong.ambient) + f64::from(phong.diffuse) * cosine;
            let shown = DVec3::from(colour) * lit + f64::from(phong.specular) * highlight;
            let left = through * (1.0 - opacity).powf(own.step_voxels / own.unit_voxels);
            light += shown * (through - left);
            through = left;
        }
        light
    }
}

/// A channel as it is shown \[grey levels of 255\].
fn grey(linear: f64) -> f64 {
    let l = linear.clamp(0.0, 1.0);
    255.0
        * if l <= 0.003_130_8 {
            12.92 * l
        } else {
            1.055 * l.powf(1.0 / 2.4) - 0.055
        }
}

/// Root mean square and greatest difference from the definition \[grey levels\].
fn off(volume: &Volume, view: &View) -> [f64; 2] {
    let transfer = TransferFunction::of_volume(volume);
    let exact = Exact::new(volume, &transfer);
    let options = CastOptions {
        terminate: 0.0,
        ..CastOptions::default()
    };
    let caster = Caster::new(volume, &transfer, &options).unwrap();
    let drawn = caster.full(view).unwrap().image;
    let (mut squares, mut worst) = (0.0, 0.0f64);
    for (k, rgb) in drawn.rgb.iter().enumerate() {
        let at = UVec2::new(k as u32 % drawn.size.x, k as u32 / drawn.size.x);
        let seen = exact.seen(view, at.as_dvec2() + 0.5);
        for c in 0..3 {
            let off = (grey(f64::from(rgb[c])) - grey(seen[c])).abs();
            squares += off * off;
            worst = worst.max(off);
        }
    }
    [(squares / (3 * drawn.rgb.len()) as f64).sqrt(), worst]
}

#[test]
fn pictures_are_as_they_are_defined() {
    let optics = Viewport::symmetric(UVec2::splat(96), 0.3).unwrap();
    for kind in GeneratedVolume::ALL {
        let volume = kind.build(48, 1).unwrap();
        let eye = orbit(volume.bounds(), &optics, 35.0, 20.0, 0.8).unwrap();
        let view = View::still(Eye::Cyclopean, optics, eye);
        let [rms, worst] = off(&volume, &view);
        // Thin shells are a few of the table's 4096 entries wide.
        let [most_rms, most] = match kind {
            GeneratedVolume::Shells => [0.1, 2.0],
            _ => [0.015, 0.25],
        };
        assert!(rms < most_rms && worst < most, "{kind}: {rms} {worst}");
    }
}
