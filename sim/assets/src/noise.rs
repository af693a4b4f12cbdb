//! Smooth noise for generating shapes; the renderer has its own, in lanes, for shading them.

/// Value noise in [−1, 1] on the integer grid of the plane, with continuous second derivative.
pub(crate) fn value_2d(x: f64, y: f64, seed: u32) -> f64 {
    let (xf, yf) = (x.floor(), y.floor());
    let (fx, fy) = (quintic(x - xf), quintic(y - yf));
    let (ix, iy) = (xf as i64 as u32, yf as i64 as u32);
    let at = |dx: u32, dy: u32| {
        let h = hash(ix.wrapping_add(dx), iy.wrapping_add(dy), seed);
        f64::from(h) / f64::from(u32::MAX) * 2.0 - 1.0
    };
    let low = at(0, 0) + fx * (at(1, 0) - at(0, 0));
    let high = at(0, 1) + fx * (at(1, 1) - at(0, 1));
    low + fy * (high - low)
}

/// Octaves of [`value_2d`], each twice as fine and half as high.
pub(crate) fn fractal_2d(x: f64, y: f64, octaves: u32, seed: u32) -> f64 {
    let (mut sum, mut amplitude, mut scale) = (0.0, 1.0, 1.0);
    for octave in 0..octaves {
        sum += amplitude * value_2d(x * scale, y * scale, seed.wrapping_add(octave));
        amplitude *= 0.5;
        scale *= 2.0;
    }
    sum
}

/// 6t⁵ − 15t⁴ + 10t³ (Perlin 2002).
fn quintic(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

/// Mixes two coordinates and a seed; the finalizer is lowbias32 (Wellons 2018).
fn hash(x: u32, y: u32, seed: u32) -> u32 {
    let mut h = x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77) ^ seed;
    h ^= h >> 16;
    h = h.wrapping_mul(0x7feb_352d);
    h ^= h >> 15;
    h = h.wrapping_mul(0x846c_a68b);
    h ^ (h >> 16)
}
