use fearless_simd::{Level, dispatch};
use foveasim_models::math;
use glam::UVec2;
use rayon::prelude::*;

use crate::{PEAK, Plane, QualityError};

/// Width of SSIM's Gaussian window \[px\] (Wang et al. 2004, §III-B).
pub const WINDOW: usize = 11;
const RADIUS: usize = WINDOW / 2;
/// Standard deviation of the window \[px\].
const SIGMA: f64 = 1.5;
/// (K₁·L)² and (K₂·L)² with K₁ = 0.01, K₂ = 0.03 and L = 255 (Wang et al. 2004, Eqs 7 and 9).
const C1: f64 = (0.01 * PEAK) * (0.01 * PEAK);
const C2: f64 = (0.03 * PEAK) * (0.03 * PEAK);
/// Output rows that one task makes. A task filters `WINDOW − 1` rows more than it makes, so larger
/// is less work and smaller is better balanced.
const BAND: usize = 64;

/// Structural similarity of two images.
#[derive(Debug, Clone, PartialEq)]
pub struct Ssim {
    /// Mean over the pixels whose whole window lies in the image (a border of 5 is left out), as
    /// Wang et al. and scikit-image report it.
    pub mean: f64,
    /// SSIM of every pixel; at the border the image is mirrored about its edge.
    pub map: Plane,
}

/// SSIM (Wang, Bovik, Sheikh & Simoncelli 2004, *Image quality assessment: from error visibility to
/// structural similarity*, Eq. 13) of planes with values 0 to 255: 11×11 Gaussian window of σ = 1.5,
/// K₁ = 0.01, K₂ = 0.03, moments divided by the window's sum (not the sample covariance).
///
/// Equal to scikit-image's `structural_similarity(a, b, data_range=255, gaussian_weights=True,
/// sigma=1.5, use_sample_covariance=False)`.
///
/// # Errors
/// If the sizes differ or a side is shorter than [`WINDOW`].
///
/// # Method
/// The Gaussian is separable, and with s = a + b and d = a − b four filtered planes do instead of
/// five: from E\[s\], E\[d\], E\[s²\], E\[d²\] follow μaμb = (E\[s\]² − E\[d\]²)/4,
/// μa² + μb² = (E\[s\]² + E\[d\]²)/2, and likewise 2σab and σa² + σb². Rows are filtered once into a
/// ring of [`WINDOW`] rows that stays in cache. No pixel's value depends on the band it is made in, or
/// on the machine's vector width.
pub fn ssim(a: &Plane, b: &Plane) -> Result<Ssim, QualityError> {
    check(a, b)?;
    let size = a.size();
    let (width, height) = (size.x as usize, size.y as usize);
    let (weights, level) = (half_window(), Level::new());
    let mut map = vec![0.0; width * height];
    map.par_chunks_mut(width * BAND)
        .enumerate()
        .for_each(|(band, rows)| filter_band(level, a, b, &weights, band * BAND, rows));
    let map = Plane::from_finite(size, map);
    Ok(Ssim {
        mean: interior_mean(&map),
        map,
    })
}

/// SSIM as its definition reads: for each pixel, weighted means, then weighted squares of deviations
/// from them, over all 121 pixels of the window. The specification that [`ssim`] is tested against;
/// about a hundred times slower.
///
/// # Errors
/// As [`ssim`].
pub fn ssim_by_definition(a: &Plane, b: &Plane) -> Result<Ssim, QualityError> {
    check(a, b)?;
    let size = a.size();
    let (width, height) = (size.x as usize, size.y as usize);
    let half = half_window();
    let weight = |k: usize| half[k.abs_diff(RADIUS)];
    let mut map = Vec::with_capacity(width * height);
    for y in 0..height {
        for x in 0..width {
            let window = || {
                (0..WINDOW * WINDOW).map(|k| {
                    let (i, j) = (k % WINDOW, k / WINDOW);
                    let at = mirrored(y, j, height) * width + mirrored(x, i, width);
                    (weight(i) * weight(j), a.values()[at], b.values()[at])
                })
            };
            let mean_a: f64 = window().map(|(w, a, _)| w * a).sum();
            let mean_b: f64 = window().map(|(w, _, b)| w * b).sum();
            let [mut var_a, mut var_b, mut cov] = [0.0; 3];
            for (w, a, b) in window() {
                var_a += w * (a - mean_a) * (a - mean_a);
                var_b += w * (b - mean_b) * (b - mean_b);
                cov += w * (a - mean_a) * (b - mean_b);
            }
            map.push(
                (2.0 * mean_a * mean_b + C1) * (2.0 * cov + C2)
                    / ((mean_a * mean_a + mean_b * mean_b + C1) * (var_a + var_b + C2)),
            );
        }
    }
    let map = Plane::from_finite(size, map);
    Ok(Ssim {
        mean: interior_mean(&map),
        map,
    })
}

fn check(a: &Plane, b: &Plane) -> Result<(), QualityError> {
    a.same_size(b)?;
    if (a.size().min_element() as usize) < WINDOW {
        return Err(QualityError::TooSmall {
            size: a.size(),
            valid: WINDOW as u32,
        });
    }
    Ok(())
}

/// Weights at distance 0 to 5 of the normalised one-dimensional window.
fn half_window() -> [f64; RADIUS + 1] {
    let raw: [f64; RADIUS + 1] =
        std::array::from_fn(|k| math::exp(-0.5 * (k * k) as f64 / (SIGMA * SIGMA)));
    let total = raw[0] + 2.0 * raw[1..].iter().sum::<f64>();
    raw.map(|w| w / total)
}

/// Index `centre + tap − RADIUS`, mirrored about the edges: … 1 0 | 0 1 2 … n−1 | n−1 n−2 …
fn mirrored(centre: usize, tap: usize, n: usize) -> usize {
    let i = centre + tap;
    if i < RADIUS {
        RADIUS - 1 - i
    } else if i - RADIUS < n {
        i - RADIUS
    } else {
        2 * n - 1 - (i - RADIUS)
    }
}

/// How many filtered planes there are: of s, d, s² and d².
const MOMENTS: usize = 4;

/// SSIM of the rows from `first` on that `out` holds, in the widest vectors of this machine.
///
/// The loops are plain arithmetic that the compiler vectorises; no sum is reordered and nothing is
/// fused, so the width changes no bit.
fn filter_band(
    level: Level,
    a: &Plane,
    b: &Plane,
    weights: &[f64; RADIUS + 1],
    first: usize,
    out: &mut [f64],
) {
    dispatch!(level, _simd => filter_rows(a, b, weights, first, out));
}

#[inline(always)]
fn filter_rows(a: &Plane, b: &Plane, weights: &[f64; RADIUS + 1], first: usize, out: &mut [f64]) {
    let (width, height) = (a.size().x as usize, a.size().y as usize);
    // Slot r of the ring holds the image row that tap r (mod WINDOW) of the current window reads.
    let mut ring = vec![0.0; WINDOW * MOMENTS * width];
    let mut padded = vec![0.0; width + 2 * RADIUS];
    let mut filtered = vec![0.0; MOMENTS * width];
    for tap in 0..WINDOW - 1 + out.len() / width {
        let y = mirrored(first, tap, height);
        let slot = &mut ring[tap % WINDOW * MOMENTS * width..][..MOMENTS * width];
        moment_rows(a.row(y), b.row(y), weights, &mut padded, slot);
        let Some(k) = (tap + 1).checked_sub(WINDOW) else {
            continue;
        };
        for (m, plane) in filtered.chunks_exact_mut(width).enumerate() {
            let tap = |t: usize| &ring[((k + t) % WINDOW * MOMENTS + m) * width..][..width];
            convolve(std::array::from_fn(tap), weights, plane);
        }
        similarity(&filtered, &mut out[k * width..][..width]);
    }
}

/// The four moments of one image row, each filtered along the row, one after another.
#[inline(always)]
fn moment_rows(
    a: &[f64],
    b: &[f64],
    weights: &[f64; RADIUS + 1],
    padded: &mut [f64],
    out: &mut [f64],
) {
    let width = a.len();
    for (m, out) in out.chunks_exact_mut(width).enumerate() {
        let middle = &mut padded[RADIUS..][..width];
        match m {
            0 => combine(a, b, middle, |a, b| a + b),
            1 => combine(a, b, middle, |a, b| a - b),
            2 => combine(a, b, middle, |a, b| (a + b) * (a + b)),
            _ => combine(a, b, middle, |a, b| (a - b) * (a - b)),
        }
        for k in 0..RADIUS {
            padded[k] = padded[2 * RADIUS - 1 - k];
            padded[RADIUS + width + k] = padded[RADIUS + width - 1 - k];
        }
        convolve(
            std::array::from_fn(|tap| &padded[tap..][..width]),
            weights,
            out,
        );
    }
}

#[inline(always)]
fn combine(a: &[f64], b: &[f64], out: &mut [f64], f: impl Fn(f64, f64) -> f64) {
    for ((out, &a), &b) in out.iter_mut().zip(a).zip(b) {
        *out = f(a, b);
    }
}

/// out\[i\] = Σ weight · tap\[i\], outermost pair first.
#[inline(always)]
fn convolve(taps: [&[f64]; WINDOW], weights: &[f64; RADIUS + 1], out: &mut [f64]) {
    let n = out.len();
    // Equal lengths, said once, spare the loop its bounds checks.
    let [t0, t1, t2, t3, t4, t5, t6, t7, t8, t9, t10] = taps.map(|t| &t[..n]);
    let [w0, w1, w2, w3, w4, w5] = *weights;
    for i in 0..n {
        out[i] = w5 * (t0[i] + t10[i])
            + w4 * (t1[i] + t9[i])
            + w3 * (t2[i] + t8[i])
            + w2 * (t3[i] + t7[i])
            + w1 * (t4[i] + t6[i])
            + w0 * t5[i];
    }
}

/// SSIM of a row from its four filtered moments.
#[inline(always)]
fn similarity(filtered: &[f64], out: &mut [f64]) {
    let n = out.len();
    let [s, d, ss, dd] = std::array::from_fn(|m| &filtered[m * n..][..n]);
    for i in 0..n {
        let (s2, d2) = (s[i] * s[i], d[i] * d[i]);
        let (var_s, var_d) = (ss[i] - s2, dd[i] - d2);
        out[i] = (0.5 * (s2 - d2) + C1) * (0.5 * (var_s - var_d) + C2)
            / ((0.5 * (s2 + d2) + C1) * (0.5 * (var_s + var_d) + C2));
    }
}

/// Mean over the pixels whose whole window lies in the image: rows first, then the rows' sums.
fn interior_mean(map: &Plane) -> f64 {
    let UVec2 { x, y } = map.size();
    let (width, height) = (x as usize, y as usize);
    let row = |y: usize| math::sum(&map.row(y)[RADIUS..width - RADIUS]);
    let rows: Vec<f64> = (RADIUS..height - RADIUS).into_par_iter().map(row).collect();
    math::sum(&rows) / ((width - 2 * RADIUS) * (height - 2 * RADIUS)) as f64
}

#[cfg(test)]
mod tests {
    use foveasim_models::{Role, Stream};

    use super::*;

    #[test]
    fn vector_width_changes_no_bit() {
        let size = UVec2::new(77, 40);
        let mut random = Stream::new(5, Role::Jitter, 0);
        let mut plane = || {
            let values = (0..size.x * size.y)
                .map(|_| random.range(0.0, 255.0))
                .collect();
            Plane::new(size, values).unwrap()
        };
        let (a, b) = (plane(), plane());
        let with = |level| {
            let mut out = vec![0.0; 77 * 40];
            filter_band(level, &a, &b, &half_window(), 0, &mut out);
            out
        };
        assert_eq!(with(Level::new()), with(Level::fallback()));
    }
}
