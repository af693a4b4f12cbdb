use fearless_simd::prelude::*;
use foveasim_assets::{MipLevel, Texture, Wrap};

use super::lanes::{F, Simd, V3, max, min, saturate, splat};

/// Linear red, green and blue of `texture` at `uv`, averaged over `footprint` [texture widths]:
/// trilinear, each lane from the two mip levels whose texels are next to its footprint in size.
///
/// Between powers of two the share of the smaller level grows linearly with the footprint rather than
/// with its logarithm (at most 0.086 levels apart), which a float's own bits give exactly.
#[inline(always)]
pub(super) fn sample<S: Simd>(simd: S, texture: &Texture, uv: [F<S>; 2], footprint: F<S>) -> V3<S> {
    // A function of its own: each material may call it several times.
    simd.vectorize(
        #[inline(always)]
        || trilinear(simd, texture, uv, footprint),
    )
}

#[inline(always)]
fn trilinear<S: Simd>(simd: S, texture: &Texture, uv: [F<S>; 2], footprint: F<S>) -> V3<S> {
    let levels = texture.levels();
    let [width, height] = levels[0].size;
    let last = levels.len() - 1;
    // NaN counts as one texel, infinity as the whole texture.
    let texels = max(footprint * (width.max(height) as f32), splat(simd, 1.0));
    let texels = min(texels, splat(simd, (1u32 << last) as f32)).to_array();
    let level = texels.map(|t| ((t.to_bits() >> 23) as usize - 127).min(last));
    let fine = bilinear(simd, texture, uv, level);
    let fraction = texels.map(|t| (t.to_bits() & 0x7f_ffff) as f32 / 8_388_608.0);
    if fraction == [0.0; 8] {
        return fine;
    }
    let coarse = bilinear(simd, texture, uv, level.map(|l| (l + 1).min(last)));
    fine.mix(coarse, F::from_slice(simd, &fraction))
}

/// Of each lane's own level.
#[inline(always)]
fn bilinear<S: Simd>(simd: S, texture: &Texture, uv: [F<S>; 2], level: [usize; 8]) -> V3<S> {
    let levels = level.map(|l| texture.levels()[l]);
    let wrap = texture.wrap();
    let [u, v] = uv;
    let (columns, fraction_x) = neighbours(simd, u, levels.map(|l| l.size[0]), wrap[0]);
    let (rows, fraction_y) = neighbours(simd, v, levels.map(|l| l.size[1]), wrap[1]);
    let corner = |row: usize, column: usize| {
        let [x, y, z] = fetch(texture, &levels, &rows[row], &columns[column]);
        V3 {
            x: F::from_slice(simd, &x),
            y: F::from_slice(simd, &y),
            z: F::from_slice(simd, &z),
        }
    };
    let upper = corner(0, 0).mix(corner(0, 1), fraction_x);
    let lower = corner(1, 0).mix(corner(1, 1), fraction_x);
    upper.mix(lower, fraction_y)
}

/// Linear red, green and blue of a texel for each lane. Nothing here is gained by vectors, so it is
/// one function for all of their widths.
#[inline(never)]
fn fetch(
    texture: &Texture,
    levels: &[MipLevel; 8],
    row: &[u32; 8],
    column: &[u32; 8],
) -> [[f32; 8]; 3] {
    let table = texture.encoding().table();
    let mut rgb = [[0.0; 8]; 3];
    for i in 0..8 {
        let place = levels[i].first + row[i] * levels[i].size[0] + column[i];
        let texel = texture.texels()[place as usize];
        for k in 0..3 {
            rgb[k][i] = table[usize::from(texel[k])];
        }
    }
    rgb
}

/// The two texels on either side of `coordinate`, and the share of the second.
#[inline(always)]
fn neighbours<S: Simd>(
    simd: S,
    coordinate: F<S>,
    size: [u32; 8],
    wrap: Wrap,
) -> ([[u32; 8]; 2], F<S>) {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let within = match wrap {
        Wrap::Repeat => coordinate - coordinate.floor(),
        Wrap::Mirror => {
            let half = coordinate * 0.5;
            one - ((half - half.floor()) * 2.0 - 1.0).abs()
        }
        Wrap::Clamp => coordinate,
    };
    // From here on in 0..=1, whatever came in.
    let within = saturate(within);
    let size = F::from_slice(simd, &size.map(|s| s as f32));
    let x = within * size - 0.5;
    let low = x.floor();
    let high = low + 1.0;
    let end = size - 1.0;
    let (below, above) = match wrap {
        Wrap::Repeat => (end, zero),
        Wrap::Mirror | Wrap::Clamp => (zero, end),
    };
    let first = low.simd_lt(zero).select(below, low);
    let second = high.simd_gt(end).select(above, high);
    let whole = |f: F<S>| f.to_array().map(|v| v as u32);
    ([whole(first), whole(second)], x - low)
}

#[cfg(test)]
mod tests {
    use foveasim_assets::Encoding;

    use super::super::{Kernel, dispatch};
    use super::*;
    use crate::Simd as Choice;

    struct Probe<'a> {
        texture: &'a Texture,
        /// u, v, footprint.
        at: [[f32; 8]; 3],
    }

    impl Kernel for Probe<'_> {
        type Output = [[f32; 8]; 3];

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Self::Output {
            let [u, v, foot] = self.at.map(|a| F::from_slice(simd, &a));
            let c = sample(simd, self.texture, [u, v], foot);
            [c.x.to_array(), c.y.to_array(), c.z.to_array()]
        }
    }

    /// Both ways, which must agree to the bit.
    fn probe(texture: &Texture, at: [[f32; 8]; 3]) -> [[f32; 8]; 3] {
        let a = dispatch(Choice::Auto, Probe { texture, at });
        let b = dispatch(Choice::Scalar, Probe { texture, at });
        let bits = |c: [[f32; 8]; 3]| c.map(|row| row.map(f32::to_bits));
        assert_eq!(bits(a), bits(b));
        a
    }

    fn texture(size: [u32; 2], wrap: Wrap) -> Texture {
        let texels =
            (0..size[0] * size[1]).map(|i| [(i * 37 % 256) as u8, (i * 11 % 256) as u8, 9, 255]);
        Texture::new(size, texels.collect(), Encoding::Linear, [wrap; 2]).unwrap()
    }

    /// Textbook bilinear lookup of one level in double precision.
    fn reference(t: &Texture, level: usize, u: f64, v: f64) -> f64 {
        let l = t.levels()[level];
        let fold = |i: i64, n: u32, wrap| {
            let n = i64::from(n);
            match wrap {
                Wrap::Repeat => i.rem_euclid(n),
                Wrap::Clamp => i.clamp(0, n - 1),
                Wrap::Mirror => {
                    let j = i.rem_euclid(2 * n);
                    j.min(2 * n - 1 - j)
                }
            }
        };
        let (x, y) = (
            u * f64::from(l.size[0]) - 0.5,
            v * f64::from(l.size[1]) - 0.5,
        );
        let at = |dx: i64, dy: i64| {
            let i = fold(x.floor() as i64 + dx, l.size[0], t.wrap()[0]);
            let j = fold(y.floor() as i64 + dy, l.size[1], t.wrap()[1]);
            let place = l.first as usize + (j * i64::from(l.size[0]) + i) as usize;
            f64::from(t.texels()[place][0]) / 255.0
        };
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let row = |dy| at(0, dy) * (1.0 - fx) + at(1, dy) * fx;
        row(0) * (1.0 - fy) + row(1) * fy
    }

    #[test]
    fn it_is_the_bilinear_lookup_of_each_level_and_way_of_wrapping() {
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            let t = texture([16, 8], wrap);
            let u = [-1.3, -0.01, 0.0, 0.02, 0.47, 0.99, 1.0, 2.61];
            let v = [0.3, -0.7, 1.0, 0.99, 0.01, 1.4, 0.0, -2.2];
            for level in 0..5 {
                let foot = [(1 << level) as f32 / 16.0; 8];
                let got = probe(&t, [u, v, foot])[0];
                for i in 0..8 {
                    let want = reference(&t, level, u[i].into(), v[i].into());
                    // |u|·16 texels rounded to f32, times the steepest difference of texels, 1.
                    assert!(
                        (f64::from(got[i]) - want).abs() < 1e-5,
                        "{wrap:?} {level} {i}: {} {want}",
                        got[i]
                    );
                }
            }
        }
    }

    #[test]
    fn between_levels_it_blends_and_beyond_them_it_rests() {
        let t = texture([8, 8], Wrap::Repeat);
        let uv = [[0.3; 8], [0.6; 8]];
        let foot = [0.0, 0.125, 0.1875, 0.25, 1.0, 9.0, f32::INFINITY, f32::NAN];
        let got = probe(&t, [uv[0], uv[1], foot])[0];
        assert_eq!(got[0].to_bits(), got[1].to_bits());
        assert!((got[2] - (got[1] + got[3]) / 2.0).abs() < 1e-6);
        assert_eq!([got[4]; 2], [got[5], got[6]]);
        assert_eq!(got[7], got[0]);
    }

    #[test]
    fn coordinates_that_are_nowhere_stay_within_the_texture() {
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            let odd = [
                f32::NAN,
                f32::INFINITY,
                f32::NEG_INFINITY,
                1e30,
                -1e30,
                1e6,
                -0.0,
                1.0,
            ];
            let t = texture([3, 5], wrap);
            for foot in [0.0, 0.3, 5.0] {
                let got = probe(&t, [odd, odd, [foot; 8]]);
                assert!(got.iter().flatten().all(|v| (0.0..=1.0).contains(v)));
            }
        }
    }
}
