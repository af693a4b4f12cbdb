//! What kernels compute in lanes of f32.

use foveasim_lanes::lanes::Simd;
use foveasim_lanes::prelude::*;
use foveasim_lanes::wide::{F, WIDTH, splat};
use foveasim_lanes::{Instructions, Kernel, dispatch, transcendental};
use foveasim_models::math::{atan2, log, pow};

use super::{Check, Draw, Trial};

pub(super) const CHECKS: &[Check] = &[
    Check {
        quantity: "binary logarithm in lanes",
        precision: "f32",
        against: "f64, over 3e-7 + 1e-7·|log2 x|",
        over: "1e-37 to 3e38",
        unit: "of its bound",
        tolerance: 1.0,
        costs: WIDTH as u32,
        trial: log2,
    },
    Check {
        quantity: "power of two in lanes",
        precision: "f32",
        against: "f64",
        over: "exponents -126 to 126",
        unit: "relative",
        tolerance: 1.5e-7,
        costs: WIDTH as u32,
        trial: exp2,
    },
    Check {
        quantity: "angle in lanes",
        precision: "f32",
        against: "f64",
        over: "both coordinates 1e-18 to 1e18 of either sign, and the axes",
        unit: "turns",
        tolerance: 1e-7,
        costs: WIDTH as u32,
        trial: turns,
    },
    Check {
        quantity: "vector and scalar instructions",
        precision: "f32",
        against: "each other, bit for bit",
        over: "all three, any bits but NaN",
        unit: "lanes that differ",
        tolerance: 0.0,
        costs: WIDTH as u32,
        trial: levels,
    },
];

type Lanes = [f32; WIDTH];

/// The three functions at lanes of x, of exponents, and of (x, y).
struct All {
    x: Lanes,
    y: Lanes,
}

impl Kernel for All {
    type Output = [Lanes; 3];

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> [Lanes; 3] {
        let (x, y) = (F::from_slice(simd, &self.x), F::from_slice(simd, &self.y));
        [
            transcendental::log2(x.abs()).to_array(),
            transcendental::times_exp2(splat(simd, 1.0), x).to_array(),
            transcendental::turns(x, y).to_array(),
        ]
    }
}

fn lanes(mut one: impl FnMut() -> f64) -> Lanes {
    std::array::from_fn(|_| one() as f32)
}

/// A trial for each lane.
fn trials(x: Lanes, y: Lanes, function: usize, error: impl Fn(f64, f64, f64) -> f64) -> Vec<Trial> {
    let found = dispatch(Instructions::Auto, All { x, y })[function];
    let trial = |lane: usize| Trial {
        error: error(x[lane].into(), y[lane].into(), found[lane].into()),
        input: format!("{:e}, {:e}", x[lane], y[lane]),
    };
    (0..WIDTH).map(trial).collect()
}

fn log2(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let x = lanes(|| draw.magnitude(1e-37, 3e38));
    trials(x, x, 0, |x, _, found| {
        let exact = log(x) / std::f64::consts::LN_2;
        (found - exact).abs() / (3e-7 + 1e-7 * exact.abs())
    })
}

fn exp2(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let x = lanes(|| draw.range(-126.0, 126.0));
    trials(x, x, 1, |x, _, found| (found / pow(2.0, x) - 1.0).abs())
}

fn turns(draw: &mut Draw, step: u32) -> Vec<Trial> {
    let mut one = || match step % 4 {
        0 => [0.0, 1.0, -1.0][draw.below(3) as usize],
        1 => draw.range(-1.0, 1.0),
        _ => draw.signed(1e-18, 1e18),
    };
    let (x, y) = (lanes(&mut one), lanes(&mut one));
    trials(x, y, 2, |x, y, found| {
        let off = found - atan2(y, x) / std::f64::consts::TAU;
        if (0.0..1.0).contains(&found) {
            (off - off.round()).abs()
        } else {
            f64::INFINITY
        }
    })
}

fn levels(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let mut any = || {
        std::array::from_fn(|_| {
            let value = f32::from_bits(draw.below(1 << 32) as u32);
            if value.is_nan() { 0.0 } else { value }
        })
    };
    let (x, y): (Lanes, Lanes) = (any(), any());
    let run = |level| dispatch(level, All { x, y }).map(|row| row.map(f32::to_bits));
    let (auto, scalar) = (run(Instructions::Auto), run(Instructions::Scalar));
    let trial = |lane: usize| Trial {
        error: (0..3)
            .filter(|f| auto[*f][lane] != scalar[*f][lane])
            .count() as f64,
        input: format!("{:e}, {:e}", x[lane], y[lane]),
    };
    (0..WIDTH).map(trial).collect()
}
