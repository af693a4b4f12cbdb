use glam::DVec2;
use rayon::prelude::*;

use crate::phi::{ONE, Phi};

/// What a cell holds, in whole numbers: the sums do not depend on their order.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Moments {
    /// Parts of pixels.
    pub(crate) parts: u32,
    /// Σ Φ \[1/[`ONE`] rays\].
    pub(crate) density: u64,
    /// Σ Φ·d, where d is from the part of a pixel with the site to this one: below 2²²·2²⁴·2¹⁵, as there are at
    /// most 2²² rays.
    first: [i64; 2],
    /// Σ Φ·dx², Σ Φ·dx·dy, Σ Φ·dy².
    second: [i128; 3],
}

impl Moments {
    /// T, in rays.
    pub(crate) fn rays(&self) -> f64 {
        self.density as f64 / ONE as f64
    }

    /// Middle of the cell, weighted by density.
    pub(crate) fn centroid(&self, site: DVec2) -> DVec2 {
        self.mean() + site.floor() + 0.5
    }

    fn mean(&self) -> DVec2 {
        DVec2::from(self.first.map(|v| v as f64)) / self.density.max(1) as f64
    }

    /// The direction in which the cell is longest; `None` if all are alike.
    pub(crate) fn long_axis(&self) -> Option<DVec2> {
        let mean = self.mean();
        let [xx, xy, yy] = self.second.map(|v| v as f64 / self.density.max(1) as f64);
        let difference = (xx - mean.x * mean.x) - (yy - mean.y * mean.y);
        let mixed = 2.0 * (xy - mean.x * mean.y);
        // Half the angle of (difference, mixed), by the half-angle formulas.
        let length = foveasim_models::math::hypot(difference, mixed);
        if length <= 1e-9 {
            return None;
        }
        let axis = if difference >= 0.0 {
            DVec2::new(length + difference, mixed)
        } else {
            DVec2::new(mixed, length - difference)
        };
        axis.try_normalize()
    }

    fn add(&mut self, other: &Self) {
        self.parts += other.parts;
        self.density += other.density;
        for (a, b) in self.first.iter_mut().zip(other.first) {
            *a += b;
        }
        for (a, b) in self.second.iter_mut().zip(other.second) {
            *a += b;
        }
    }
}

/// What the cell of each site holds; places are in parts of pixels.
pub(crate) fn moments(phi: &Phi, owner: &[u32], sites: &[DVec2]) -> Vec<Moments> {
    let size = phi.size();
    let pixel_of: Vec<[i32; 2]> = sites.iter().map(|s| [s.x as i32, s.y as i32]).collect();
    let bands = rayon::current_num_threads().clamp(1, 16) as u32;
    let of_band = |band: u32| {
        let mut all = vec![Moments::default(); sites.len()];
        for y in size.y * band / bands..size.y * (band + 1) / bands {
            let owners = &owner[y as usize * size.x as usize..][..size.x as usize];
            for ((x, &site), density) in (0i32..).zip(owners).zip(phi.row(y)) {
                let [sx, sy] = pixel_of[site as usize];
                let weight = i64::from(density);
                let (dx, dy) = (i64::from(x - sx), i64::from(y as i32 - sy));
                let m = &mut all[site as usize];
                m.parts += 1;
                m.density += u64::from(density);
                m.first[0] += weight * dx;
                m.first[1] += weight * dy;
                m.second[0] += i128::from(weight * (dx * dx));
                m.second[1] += i128::from(weight * (dx * dy));
                m.second[2] += i128::from(weight * (dy * dy));
            }
        }
        all
    };
    let mut parts: Vec<Vec<Moments>> = (0..bands).into_par_iter().map(of_band).collect();
    let mut whole = parts.swap_remove(0);
    for part in &parts {
        for (a, b) in whole.iter_mut().zip(part) {
            a.add(b);
        }
    }
    whole
}
