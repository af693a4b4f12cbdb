//! Numerical integration with a stated error.

use std::f64::consts::TAU;

use glam::DVec2;

use crate::math::{atan2, cos, sin};

/// Nodes in (0, 1] and weights of the 8-point Gauss–Legendre rule on [−1, 1] (Abramowitz & Stegun,
/// table 25.4); each node stands for ±.
const GAUSS_8: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// Nodes and weights of the 15-point Kronrod rule, and the weights of the 7-point Gauss rule it
/// extends (QUADPACK, Piessens et al. 1983); each node but 0 stands for ±.
const KRONROD_15: [(f64, f64, f64); 8] = [
    (0.0, 0.209_482_141_084_727_83, 0.417_959_183_673_469_4),
    (0.207_784_955_007_898_47, 0.204_432_940_075_298_9, 0.0),
    (
        0.405_845_151_377_397_2,
        0.190_350_578_064_785_4,
        0.381_830_050_505_118_9,
    ),
    (0.586_087_235_467_691_1, 0.169_004_726_639_267_9, 0.0),
    (
        0.741_531_185_599_394_5,
        0.140_653_259_715_525_92,
        0.279_705_391_489_276_67,
    ),
    (0.864_864_423_359_769_1, 0.104_790_010_322_250_18, 0.0),
    (
        0.949_107_912_342_758_5,
        0.063_092_092_629_978_56,
        0.129_484_966_168_869_7,
    ),
    (0.991_455_371_120_812_6, 0.022_935_322_010_529_224, 0.0),
];

/// ∫ f over [a, b] by 8 points: exact for polynomials up to degree 15.
pub(crate) fn gauss(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (mid, half) = ((a + b) / 2.0, (b - a) / 2.0);
    let pair = |(x, w): (f64, f64)| w * (f(mid - half * x) + f(mid + half * x));
    half * GAUSS_8.into_iter().map(pair).sum::<f64>()
}

/// ∫ f over consecutive `pieces` ([a, b, c] stands for [a, b] and [b, c]), bisected until the
/// Gauss–Kronrod error estimate, which is far larger than the true error where f is smooth, is within
/// `relative` of the whole.
pub(crate) fn adaptive(pieces: &[f64], relative: f64, f: impl Fn(f64) -> f64) -> f64 {
    // Bisection stops here at a jump; 2⁻⁴⁰ of the range is below any tolerance used.
    const MAX_DEPTH: u32 = 40;
    let rule = |a: f64, b: f64| {
        let (mid, half) = ((a + b) / 2.0, (b - a) / 2.0);
        let mut kronrod = 0.0;
        let mut gauss = 0.0;
        for (i, (x, k, g)) in KRONROD_15.into_iter().enumerate() {
            let y = if i == 0 {
                f(mid)
            } else {
                f(mid - half * x) + f(mid + half * x)
            };
            kronrod += k * y;
            gauss += g * y;
        }
        (half * kronrod, (half * (kronrod - gauss)).abs())
    };
    let first: Vec<_> = pieces
        .windows(2)
        .filter(|p| p[0] < p[1])
        .map(|p| (p[0], p[1], rule(p[0], p[1]), 0))
        .collect();
    let whole: f64 = first.iter().map(|piece| piece.2.0.abs()).sum();
    let length: f64 = first.iter().map(|piece| piece.1 - piece.0).sum();
    let mut stack: Vec<_> = first.into_iter().rev().collect();
    let mut total = 0.0;
    while let Some((a, b, (value, error), depth)) = stack.pop() {
        // Each piece may err by its share; a short one at a kink by a fixed small part.
        let share = ((b - a) / length).max(1e-2);
        if error <= relative * whole * share || depth >= MAX_DEPTH {
            total += value;
        } else {
            let mid = (a + b) / 2.0;
            stack.push((mid, b, rule(mid, b), depth + 1));
            stack.push((a, mid, rule(a, mid), depth + 1));
        }
    }
    total
}

/// ∫ f over the directions about a place on a rectangle of `size`, within `relative` of the whole. `f` is given the
/// direction and how far away the rectangle's edge lies in it.
pub(super) fn around(
    centre: DVec2,
    size: DVec2,
    relative: f64,
    f: impl Fn(DVec2, f64) -> f64,
) -> f64 {
    let room = size - centre;
    let corners = [
        -centre,
        DVec2::new(room.x, -centre.y),
        room,
        DVec2::new(-centre.x, room.y),
    ];
    // Between the directions of corners nothing has a kink.
    let mut turns = corners.map(|to| atan2(to.y, to.x)).to_vec();
    turns.sort_by(f64::total_cmp);
    turns.push(turns[0] + TAU);
    adaptive(&turns, relative, |turn| {
        let towards = DVec2::new(cos(turn), sin(turn));
        // As far as the nearer of the two edges that lie ahead.
        let edge = DVec2::select(towards.cmplt(DVec2::ZERO), centre, room);
        f(towards, (edge / towards.abs()).min_element())
    })
}

/// Where `f`, positive at one end of [a, b] and negative at the other, crosses zero: false position
/// with the Illinois weighting (Dowell & Jarratt 1971), until |f| ≤ `tolerance`.
pub(super) fn root(a: f64, b: f64, tolerance: f64, f: impl Fn(f64) -> f64) -> f64 {
    // Superlinear: ten steps suffice; the bound only guards against values that are not finite.
    const MAX_STEPS: usize = 60;
    let (mut x0, mut y0, mut x1, mut y1) = (a, f(a), b, f(b));
    let mut x = (a + b) / 2.0;
    for _ in 0..MAX_STEPS {
        if y1 == y0 {
            break;
        }
        x = x1 - y1 * (x1 - x0) / (y1 - y0);
        let y = f(x);
        if y.abs() <= tolerance {
            break;
        }
        if (y > 0.0) == (y1 > 0.0) {
            y0 *= 0.5;
        } else {
            (x0, y0) = (x1, y1);
        }
        (x1, y1) = (x, y);
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_exact_for_their_degree() {
        assert!((gauss(0.0, 2.0, |x| x.powi(15)) - 2f64.powi(16) / 16.0).abs() < 1e-9);
        let cubic = adaptive(&[-1.0, 0.5, 2.0], 1e-12, |x| x * x * x);
        assert!((cubic - (16.0 - 1.0) / 4.0).abs() < 1e-14);
        let peak = adaptive(&[-1.0, 1.0], 1e-9, |x| 1.0 / (x * x + 1e-6));
        assert!((peak / (2.0 * 1e3 * 1e3f64.atan()) - 1.0).abs() < 1e-8);
    }

    #[test]
    fn roots_are_found() {
        for k in 1..10 {
            let at = 0.1 * f64::from(k);
            assert!((root(1e-3, 1.0, 1e-9, |x| (x / at).ln()) - at).abs() < 1e-8);
            assert!((root(0.0, 1.0, 1e-9, |x| x.exp() - at.exp()) - at).abs() < 1e-8);
            assert!((root(0.0, 1.0, 1e-9, |x| at - x) - at).abs() < 1e-12);
        }
    }

    #[test]
    fn directions_cover_a_rectangle_from_anywhere_in_it() {
        // Half the squared distance to the edge, over all directions, is the area.
        for centre in [[50.0, 30.0], [1.0, 59.0], [99.9, 0.1], [0.0, 0.0]] {
            let size = DVec2::new(100.0, 60.0);
            let area = around(centre.into(), size, 1e-9, |_, edge| edge * edge / 2.0);
            assert!((area / 6000.0 - 1.0).abs() < 1e-9, "{centre:?}: {area}");
        }
    }

    #[test]
    fn kinks_and_jumps_end() {
        assert!((adaptive(&[0.0, 1.0], 1e-8, |x| (x - 0.3).abs()) - 0.29).abs() < 1e-8);
        let step = adaptive(&[0.0, 1.0], 1e-8, |x| f64::from(u8::from(x > 1.0 / 3.0)));
        assert!((step - 2.0 / 3.0).abs() < 1e-7);
    }
}
