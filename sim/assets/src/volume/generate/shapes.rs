//! Contents that are a function of position, on the cube from −1 to 1.

use foveasim_models::math::{cos, exp, hypot, sin, smoothstep, sqrt};
use foveasim_models::{Role, Stream};

use crate::noise::{fractal_3d, value_3d};

const PI: f64 = std::f64::consts::PI;

/// Marschner and Lobb 1994, Eq. 3. Columns and slices are computed once.
pub(super) fn marschner_lobb(size: u32) -> impl Fn([f64; 3]) -> f64 + Sync {
    const ALPHA: f64 = 0.25;
    const FREQUENCY: f64 = 6.0;
    let n = size as usize;
    let place = |k: usize| 2.0 * k as f64 / (n - 1) as f64 - 1.0;
    let index = move |x: f64| ((x + 1.0) / 2.0 * (n - 1) as f64 + 0.5) as usize;
    let column = |k: usize| {
        let r = hypot(place(k % n), place(k / n));
        ALPHA * (1.0 + cos(2.0 * PI * FREQUENCY * cos(PI * r / 2.0)))
    };
    let columns: Vec<f64> = (0..n * n).map(column).collect();
    let slices: Vec<f64> = (0..n).map(|k| 1.0 - sin(PI * place(k) / 2.0)).collect();
    move |[x, y, z]| (slices[index(z)] + columns[index(y) * n + index(x)]) / (2.0 * (1.0 + ALPHA))
}

/// A number for noise, of a seed.
fn noise_seed(seed: u64) -> u32 {
    Stream::new(seed, Role::Scene, 0).next_u64() as u32
}

/// exp(−(x/width)²).
fn bell(x: f64, width: f64) -> f64 {
    let t = x / width;
    exp(-t * t)
}

/// A jet along +y: a core that widens, and the wrinkled sheet where fuel and air meet.
pub(super) fn jet(seed: u64) -> impl Fn([f64; 3]) -> f64 + Sync {
    let seed = noise_seed(seed);
    move |[x, y, z]| {
        let along = (y + 1.0) / 2.0;
        let width = 0.10 + 0.42 * along;
        if hypot(x, z) > 2.5 * width {
            return 0.0;
        }
        // Turbulence grows along the jet.
        let wrinkle = 0.35 * (0.15 + along);
        let at = [2.0 * x, 2.0 * y, 2.0 * z];
        let dx = wrinkle * fractal_3d(at, 4, seed) * 0.5;
        let dz = wrinkle * fractal_3d(at, 4, seed ^ 0x51) * 0.5;
        let radius = hypot(x + dx, z + dz) / width;
        let fuel = bell(radius, 0.9);
        let sheet = bell(fuel - 0.35, 0.09);
        let core = smoothstep((fuel - 0.6) / 0.4) * (1.0 - 0.6 * along);
        let breaks = 0.75 + 0.25 * value_3d([6.0 * x, 6.0 * y, 6.0 * z], seed ^ 0xa7);
        sheet * breaks + 0.7 * core
    }
}

/// A wrinkled shell of radius ⅔, filaments about it.
pub(super) fn filaments(seed: u64) -> impl Fn([f64; 3]) -> f64 + Sync {
    let seed = noise_seed(seed);
    move |[x, y, z]| {
        let r = sqrt(x * x + y * y + z * z);
        if r > 1.0 {
            return 0.0;
        }
        let wrinkle = 0.10 * fractal_3d([2.5 * x, 2.5 * y, 2.5 * z], 4, seed);
        let shell = bell(r - 0.66 - wrinkle, 0.05);
        // Where two noises are both near zero there are lines.
        let at = [3.0 * x, 3.0 * y, 3.0 * z];
        let a = fractal_3d(at, 3, seed ^ 0x33);
        let b = fractal_3d(at, 3, seed ^ 0x77);
        let line = bell(hypot(a, b), 0.13);
        let inside = smoothstep((1.0 - r) / 0.25) * smoothstep((r - 0.15) / 0.3);
        0.75 * shell + line * inside
    }
}

/// Grains in a round container along y, as a scanner sees them.
pub(super) fn porous(seed: u64) -> impl Fn([f64; 3]) -> f64 + Sync {
    let seed = noise_seed(seed);
    move |[x, y, z]| {
        let r = hypot(x, z);
        if r > 0.97 || y.abs() > 0.97 {
            return 0.0;
        }
        let grain = value_3d([137.0 * x, 137.0 * y, 137.0 * z], seed ^ 0xc1);
        if r > 0.90 {
            return 0.85 + 0.02 * grain;
        }
        let at = [5.0 * x, 5.0 * y, 5.0 * z];
        let solid = smoothstep((fractal_3d(at, 4, seed) + 0.02) / 0.16);
        // Two minerals.
        let mineral = 0.55 + 0.12 * smoothstep(4.0 * value_3d(at, seed ^ 0x99) + 0.5);
        0.10 + (mineral - 0.10) * solid + 0.03 * grain
    }
}

/// Skin, flesh and bone of an oblong body, with ribs and a spine.
pub(super) fn shells(seed: u64) -> impl Fn([f64; 3]) -> f64 + Sync {
    let seed = noise_seed(seed);
    move |[x, y, z]| {
        let bend = 0.05 * value_3d([1.5 * x, 1.5 * y, 1.5 * z], seed);
        let body = sqrt(x * x / 0.42 + y * y / 0.88 + z * z / 0.36) + bend;
        if body > 1.02 {
            return 0.0;
        }
        let inside = smoothstep((1.02 - body) / 0.03);
        let scales = 0.04 * value_3d([24.0 * x, 24.0 * y, 24.0 * z], seed ^ 0x1d);
        let skin = 0.28 + scales;
        let flesh = 0.45 + 0.05 * fractal_3d([6.0 * x, 6.0 * y, 6.0 * z], 3, seed ^ 0x2f);
        let depth = smoothstep((0.93 - body) / 0.03);
        let mut value = skin + (flesh - skin) * depth;
        // The cavity within the ribs.
        let cavity = smoothstep((0.58 - body) / 0.04);
        value += (0.12 - value) * cavity;
        // Ribs lie in the shell about the cavity; the spine behind it.
        let ring = bell(body - 0.63, 0.035) * smoothstep(2.0 * cos(9.0 * PI * y) - 0.4);
        let spine = bell(hypot(x, z + 0.36), 0.075) * (0.8 + 0.2 * cos(18.0 * PI * y));
        let bone = (1.2 * ring.max(spine)).min(1.0) * smoothstep((0.85 - y.abs()) / 0.1);
        inside * (value + (0.95 - value) * bone)
    }
}
