use fearless_simd::prelude::*;
use foveasim_assets::{MipLevel, Texture, Wrap};

use super::wide::{F, Simd, V3, WIDTH, saturate, splat};

/// Linear red, green and blue of `texture` at `uv`, averaged over `footprint` [texture widths]:
/// trilinear, each lane from the two mip levels whose texels are next to its footprint in size.
///
/// Only wrapping is done in lanes. The rest is loads from many places, so it is one function for all
/// vector widths, and what it computes on is the four channels of a texel.
#[inline(always)]
pub(super) fn sample<S: Simd>(simd: S, texture: &Texture, uv: [F<S>; 2], footprint: F<S>) -> V3<S> {
    let [wrap_u, wrap_v] = texture.wrap();
    let u = wrapped(simd, uv[0], wrap_u).to_array();
    let v = wrapped(simd, uv[1], wrap_v).to_array();
    let [x, y, z] = trilinear(texture, &u, &v, &footprint.to_array());
    V3 {
        x: F::from_slice(simd, &x),
        y: F::from_slice(simd, &y),
        z: F::from_slice(simd, &z),
    }
}

/// `coordinate` in 0..=1, whatever came in.
#[inline(always)]
fn wrapped<S: Simd>(simd: S, coordinate: F<S>, wrap: Wrap) -> F<S> {
    let one = splat(simd, 1.0);
    saturate(match wrap {
        Wrap::Repeat => coordinate - coordinate.floor(),
        Wrap::Mirror => {
            let half = coordinate * 0.5;
            one - ((half - half.floor()) * 2.0 - 1.0).abs()
        }
        Wrap::Clamp => coordinate,
    })
}

/// A texel's channels; the fourth fills a vector register.
type Texel = [f32; 4];

fn mix(a: Texel, b: Texel, t: f32) -> Texel {
    std::array::from_fn(|k| a[k] + t * (b[k] - a[k]))
}

#[inline(never)]
fn trilinear(
    texture: &Texture,
    u: &[f32; WIDTH],
    v: &[f32; WIDTH],
    footprint: &[f32; WIDTH],
) -> [[f32; WIDTH]; 3] {
    let levels = texture.levels();
    let [width, height] = levels[0].size;
    let side = width.max(height) as f32;
    let last = levels.len() - 1;
    let widest = (1u32 << last) as f32;
    let mut rgb = [[0.0; WIDTH]; 3];
    for i in 0..WIDTH {
        let texels = footprint[i] * side;
        // NaN counts as one texel, infinity as the whole texture.
        let texels = if texels > 1.0 { texels } else { 1.0 };
        let texels = if texels < widest { texels } else { widest };
        // Between powers of two the share of the smaller level grows linearly with the footprint
        // rather than with its logarithm (at most 0.086 levels apart): a float's own bits give it.
        let level = ((texels.to_bits() >> 23) as usize - 127).min(last);
        let share = (texels.to_bits() & 0x7f_ffff) as f32 / 8_388_608.0;
        let mut texel = bilinear(texture, level, u[i], v[i]);
        if share > 0.0 {
            texel = mix(texel, bilinear(texture, level + 1, u[i], v[i]), share);
        }
        for k in 0..3 {
            rgb[k][i] = texel[k];
        }
    }
    rgb
}

fn bilinear(texture: &Texture, level: usize, u: f32, v: f32) -> Texel {
    let MipLevel { size, first } = texture.levels()[level];
    let [wrap_u, wrap_v] = texture.wrap();
    let (columns, share_x) = neighbours(u, size[0], wrap_u);
    let (rows, share_y) = neighbours(v, size[1], wrap_v);
    let table = texture.encoding().table();
    let at = |row: u32, column: u32| {
        let place = first + row * size[0] + column;
        let [r, g, b, _] = texture.texels()[place as usize];
        let value = |code: u8| table[usize::from(code)];
        [value(r), value(g), value(b), 0.0]
    };
    let row = |row| mix(at(row, columns[0]), at(row, columns[1]), share_x);
    mix(row(rows[0]), row(rows[1]), share_y)
}

/// The two texels on either side of `coordinate` (0 to 1), and the share of the second.
fn neighbours(coordinate: f32, size: u32, wrap: Wrap) -> ([u32; 2], f32) {
    // From half a texel before the first one to half of one past the last.
    let x = coordinate * size as f32 + 0.5;
    // Position 1 is the first texel, so that nothing is negative.
    let whole = x as u32;
    let share = x - whole as f32;
    let (before, after) = match wrap {
        Wrap::Repeat => (size - 1, 0),
        Wrap::Mirror | Wrap::Clamp => (0, size - 1),
    };
    let low = if whole == 0 { before } else { whole - 1 };
    let high = if whole >= size { after } else { whole };
    ([low, high], share)
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
        at: [[f32; WIDTH]; 3],
    }

    impl Kernel for Probe<'_> {
        type Output = [[f32; WIDTH]; 3];

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Self::Output {
            let [u, v, foot] = self.at.map(|a| F::from_slice(simd, &a));
            let c = sample(simd, self.texture, [u, v], foot);
            [c.x.to_array(), c.y.to_array(), c.z.to_array()]
        }
    }

    /// Both ways, which must agree to the bit; eight places, asked for twice.
    fn probe(texture: &Texture, at: [[f32; 8]; 3]) -> [[f32; 8]; 3] {
        let at = at.map(|row| std::array::from_fn(|lane| row[lane % 8]));
        let a = dispatch(Choice::Auto, Probe { texture, at });
        let b = dispatch(Choice::Scalar, Probe { texture, at });
        let bits = |c: [[f32; WIDTH]; 3]| c.map(|row| row.map(f32::to_bits));
        assert_eq!(bits(a), bits(b));
        let halves = a.map(|row| [0, 8].map(|first| std::array::from_fn(|i| row[first + i])));
        assert!(
            halves
                .iter()
                .all(|[a, b]| a == b || a.iter().any(|v: &f32| v.is_nan()))
        );
        halves.map(|[first, _]| first)
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
