//! Sums, codes and image metrics.

use foveasim_models::math::{quantile_sorted, sum};
use foveasim_models::{linear_from_srgb, srgb8_from_linear};
use foveasim_quality::{Plane, ssim, ssim_by_definition};
use glam::UVec2;

use super::big::Big;
use super::{Check, Draw, Trial};

pub(super) const CHECKS: &[Check] = &[
    Check {
        quantity: "sum",
        precision: "f64",
        against: "256 bits, over the sum of sizes",
        over: "to 3000 numbers of 1e-30 to 1e30 of either sign",
        unit: "relative",
        tolerance: 2e-15,
        costs: 200,
        trial: summed,
    },
    Check {
        quantity: "quantiles",
        precision: "f64",
        against: "order: none falls as q rises, none leaves the values",
        over: "1 to 100 numbers of 1e-30 to 1e30 of either sign",
        unit: "of the spread",
        tolerance: 3e-16,
        costs: 20,
        trial: quantiles,
    },
    Check {
        quantity: "8-bit sRGB of linear light",
        precision: "f32",
        against: "the code it came from; ends beyond 0 and 1",
        over: "all codes, NaN, infinities, 1e-30 to 1e30",
        unit: "codes",
        tolerance: 0.0,
        costs: 1,
        trial: codes,
    },
    Check {
        quantity: "SSIM",
        precision: "f64",
        against: "its definition, window by window",
        over: "noise of 1e-30 to 255 on 0 to 255",
        unit: "",
        tolerance: 1e-9,
        costs: 500,
        trial: similarity,
    },
    Check {
        quantity: "SSIM of an image with itself",
        precision: "f64",
        against: "1",
        over: "noise of 1e-30 to 255 on 0 to 255",
        unit: "",
        tolerance: 1e-12,
        costs: 500,
        trial: same,
    },
];

fn summed(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let count = draw.magnitude(1.0, 3000.0) as usize;
    let values: Vec<f64> = (0..count).map(|_| draw.signed(1e-30, 1e30)).collect();
    let add = |sum: Big, v: &f64| sum + Big::new(*v);
    let exact = values.iter().fold(Big::new(0.0), add);
    let sizes = sum(&values.iter().map(|v| v.abs()).collect::<Vec<_>>());
    Trial::of(exact.off(sum(&values)) / sizes, format!("{count} numbers"))
}

fn quantiles(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let count = draw.magnitude(1.0, 100.0) as usize;
    let mut values: Vec<f64> = (0..count).map(|_| draw.signed(1e-30, 1e30)).collect();
    values.sort_by(f64::total_cmp);
    let (low, high) = (values[0], values[values.len() - 1]);
    let mut at: Vec<f64> = (0..20).map(|_| draw.range(-0.1, 1.1)).collect();
    at.sort_by(f64::total_cmp);
    let found: Vec<f64> = at.iter().map(|q| quantile_sorted(&values, *q)).collect();
    let falls = found.windows(2).map(|pair| pair[0] - pair[1]);
    let leaves = found.iter().map(|v| (low - v).max(v - high));
    let worst = falls.chain(leaves).fold(0.0, f64::max);
    let spread = (high - low).max(high.abs()).max(low.abs());
    Trial::of(worst / spread, format!("{count} numbers"))
}

fn codes(draw: &mut Draw, step: u32) -> Vec<Trial> {
    let extremes = [
        (f32::NAN, 0),
        (f32::INFINITY, 255),
        (f32::NEG_INFINITY, 0),
        (-0.0, 0),
        (f32::MIN_POSITIVE, 0),
        (1.0, 255),
    ];
    let (linear, code) = match extremes.get(step as usize) {
        Some(extreme) => *extreme,
        None => match draw.below(4) {
            0 => (draw.magnitude(1.0, 1e30) as f32, 255),
            1 => (-draw.magnitude(1e-30, 1e30) as f32, 0),
            _ => {
                let code = (step % 256) as u8;
                (linear_from_srgb(f64::from(code) / 255.0) as f32, code)
            }
        },
    };
    let error = f64::from(srgb8_from_linear(linear).abs_diff(code));
    Trial::of(error, format!("{linear:e}"))
}

/// A small plane of one grey with noise of any size.
fn plane(draw: &mut Draw) -> (Plane, String) {
    let (grey, noise) = (draw.range(0.0, 255.0), draw.magnitude(1e-30, 255.0));
    let values = (0..20 * 17).map(|_| (grey + noise * draw.range(-1.0, 1.0)).clamp(0.0, 255.0));
    let values = values.collect();
    let plane = Plane::new(UVec2::new(20, 17), values).expect("finite values, as many as pixels");
    (plane, format!("noise {noise:e} on {grey}"))
}

fn similarity(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let ((a, input), (b, other)) = (plane(draw), plane(draw));
    let (Ok(fast), Ok(plain)) = (ssim(&a, &b), ssim_by_definition(&a, &b)) else {
        return Trial::of(f64::INFINITY, input);
    };
    let error = (fast.mean - plain.mean).abs();
    Trial::of(error, format!("{input}; {other}"))
}

fn same(draw: &mut Draw, _: u32) -> Vec<Trial> {
    let (a, input) = plane(draw);
    let error = ssim(&a, &a).map_or(f64::INFINITY, |s| (s.mean - 1.0).abs());
    Trial::of(error, input)
}
