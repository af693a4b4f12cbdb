//! Smooth noise for generating shapes and skies; the renderer has its own, in lanes, for shading.

/// Value noise in [−1, 1] on the integer grid of the plane, with continuous second derivative.
pub(crate) fn value_2d(x: f64, y: f64, seed: u32) -> f64 {
    let ((ix, fx), (iy, fy)) = (cell(x), cell(y));
    let at = |dx: u32, dy: u32| f64::from(hash(ix.wrapping_add(dx), iy.wrapping_add(dy), seed));
    let low = at(0, 0) + fx * (at(1, 0) - at(0, 0));
    let high = at(0, 1) + fx * (at(1, 1) - at(0, 1));
    (low + fy * (high - low)) * (2.0 / f64::from(u32::MAX)) - 1.0
}

/// Octaves of [`value_2d`], each twice as fine and half as high.
pub(crate) fn fractal_2d(x: f64, y: f64, octaves: u32, seed: u32) -> f64 {
    filtered_2d(x, y, 0.0, octaves, seed)
}

/// As [`fractal_2d`], octaves faded out whose period spans fewer than four footprints, and left out
/// from two on, where they could only alias.
pub(crate) fn filtered_2d(x: f64, y: f64, footprint: f64, octaves: u32, seed: u32) -> f64 {
    filtered_above(f64::NEG_INFINITY, x, y, footprint, octaves, seed)
}

/// As [`filtered_2d`], but where that is below `least` perhaps some other number below it: octaves that
/// cannot lift the sum to `least` any more are left out.
pub(crate) fn filtered_above(
    least: f64,
    x: f64,
    y: f64,
    footprint: f64,
    octaves: u32,
    seed: u32,
) -> f64 {
    let (mut sum, mut amplitude, mut scale) = (0.0, 1.0, 1.0);
    for octave in 0..octaves {
        let visible = (2.0 - footprint * (4.0 * scale)).clamp(0.0, 1.0);
        // All octaves from here on add less than twice the amplitude of this one.
        if visible == 0.0 || sum + 2.0 * amplitude < least {
            break;
        }
        let seed = seed.wrapping_add(octave);
        sum += visible * amplitude * value_2d(x * scale, y * scale, seed);
        amplitude *= 0.5;
        scale *= 2.0;
    }
    sum
}

/// Value noise in [−1, 1] on the integer grid of space, with continuous second derivative.
pub(crate) fn value_3d(p: [f64; 3], seed: u32) -> f64 {
    let [(ix, fx), (iy, fy), (iz, fz)] = p.map(cell);
    let layer = |dz: u32| {
        let seed = hash(iz.wrapping_add(dz), seed, 0x5bd1_e995);
        let at = |dx: u32, dy: u32| f64::from(hash(ix.wrapping_add(dx), iy.wrapping_add(dy), seed));
        let low = at(0, 0) + fx * (at(1, 0) - at(0, 0));
        let high = at(0, 1) + fx * (at(1, 1) - at(0, 1));
        low + fy * (high - low)
    };
    let (front, back) = (layer(0), layer(1));
    (front + fz * (back - front)) * (2.0 / f64::from(u32::MAX)) - 1.0
}

/// Octaves of [`value_3d`], each twice as fine and half as high: within ±2.
pub(crate) fn fractal_3d(p: [f64; 3], octaves: u32, seed: u32) -> f64 {
    let (mut sum, mut amplitude, mut scale) = (0.0, 1.0, 1.0);
    for octave in 0..octaves {
        sum += amplitude * value_3d(p.map(|x| x * scale), seed.wrapping_add(octave));
        amplitude *= 0.5;
        scale *= 2.0;
    }
    sum
}

/// Cell index and smooth position in the cell, for |x| < 2⁶³. (`f64::floor` is a call where the target
/// has no instruction for it.)
fn cell(x: f64) -> (u32, f64) {
    let toward_zero = x as i64;
    let whole = toward_zero - i64::from(x < toward_zero as f64);
    (whole as u32, quintic(x - whole as f64))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_those_of_floor() {
        for x in [-2.5, -2.0, -1e-300, -0.0, 0.0, 0.3, 1.0, 7.999] {
            assert_eq!(
                cell(x),
                (f64::floor(x) as i64 as u32, quintic(x - x.floor()))
            );
        }
    }
}
