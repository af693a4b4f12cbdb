use foveasim_models::math::sqrt;
use foveasim_models::{Image, Lens};
use glam::{DVec2, UVec2};
use rayon::prelude::*;

use crate::FrameMemory;

/// Moves red, green and blue apart, each so much that the lens brings them together again: a pixel shows of each colour what the
/// image has where [`Lens::source_of`] says, interpolated bilinearly; beyond the image's edge, what its edge has.
///
/// How far from the axis that is depends on the pixel's own distance alone. It is tabulated in steps of an eighth of a pixel or less;
/// straight lines between are off by less than 10⁻⁴ pixels.
///
/// [`render`](crate::render) does so by itself, of the whole image.
pub fn separate_colours(image: Image, lens: &Lens) -> Image {
    separate(image, lens, &mut FrameMemory::default())
}

/// The same in the memory of earlier frames.
pub(crate) fn separate(image: Image, lens: &Lens, memory: &mut FrameMemory) -> Image {
    if lens.chromatic() == [1.0; 3] {
        return image;
    }
    let tables = [0, 1, 2].map(|colour| Factors::new(lens, colour, image.size));
    let size = image.size;
    let mut out = Image {
        size,
        rgb: memory.rgb.any(image.rgb.len(), [0.0; 3]),
    };
    out.rgb
        .par_chunks_mut(size.x.max(1) as usize)
        .enumerate()
        .for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                let px = DVec2::new(x as f64, y as f64) + 0.5;
                let away = px - lens.centre_px();
                for (colour, out) in pixel.iter_mut().enumerate() {
                    let factor = tables[colour].at(away.length_squared());
                    // Added to the pixel, nothing is to the bit nothing.
                    let source = px + away * (factor - 1.0);
                    *out = bilinear(&image, colour, source);
                }
            }
        });
    memory.give(image);
    out
}

/// How much farther out the source of one colour lies, by distance from the axis.
struct Factors {
    per_px: f64,
    factors: Vec<f64>,
}

impl Factors {
    fn new(lens: &Lens, colour: usize, size: UVec2) -> Self {
        let centre = lens.centre_px();
        let far = centre.abs().max((size.as_dvec2() - centre).abs()).length();
        let steps = (far * 8.0).ceil().clamp(8.0, 262_144.0);
        let per_px = steps / far.max(1e-3);
        let mut last = 1.0;
        let factors = (0..steps as usize + 2).map(|k| {
            let r = k as f64 / per_px;
            let source = lens.source_of(colour, centre + DVec2::X * r);
            if let Some(source) = source.filter(|_| k > 0) {
                last = (source.x - centre.x) / r;
            }
            last
        });
        let mut factors: Vec<f64> = factors.collect();
        factors[0] = factors[1];
        Self { per_px, factors }
    }

    fn at(&self, square: f64) -> f64 {
        let at = sqrt(square) * self.per_px;
        let k = (at as usize).min(self.factors.len() - 2);
        let [a, b] = [self.factors[k], self.factors[k + 1]];
        a + (b - a) * (at - k as f64)
    }
}

fn bilinear(image: &Image, colour: usize, px: DVec2) -> f32 {
    let last = (image.size - 1).as_dvec2();
    let at = (px - 0.5).clamp(DVec2::ZERO, last);
    let low = at.floor();
    let f = at - low;
    let fetch = |dx: u32, dy: u32| {
        let p = (low.as_uvec2() + UVec2::new(dx, dy)).min(image.size - 1);
        f64::from(image.rgb[(p.y * image.size.x + p.x) as usize][colour])
    };
    let top = fetch(0, 0) + (fetch(1, 0) - fetch(0, 0)) * f.x;
    let bottom = fetch(0, 1) + (fetch(1, 1) - fetch(0, 1)) * f.x;
    (top + (bottom - top) * f.y) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_come_from_where_the_lens_says() {
        let size = UVec2::new(160, 120);
        let lens = Lens::new(
            DVec2::new(70.0, 64.0),
            80.0,
            [0.2, 0.05],
            [0.99, 1.0, 1.02],
            size,
        )
        .unwrap();
        // A ramp, of which bilinear interpolation is exact: what is read is where it was read.
        let mut image = Image::filled(size, [0.0; 3]);
        for y in 0..size.y {
            for x in 0..size.x {
                let value = x as f32 + 0.5 + 1000.0 * (y as f32 + 0.5);
                image.rgb[(y * size.x + x) as usize] = [value; 3];
            }
        }
        let out = separate_colours(image.clone(), &lens);
        for y in (10..110).step_by(9) {
            for x in (10..150).step_by(7) {
                let px = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
                let pixel = out.rgb[(y * size.x + x) as usize];
                for (colour, found) in pixel.into_iter().enumerate() {
                    let source = lens.source_of(colour, px).unwrap();
                    let want = source.x + 1000.0 * source.y;
                    assert!(
                        (f64::from(found) - want).abs() < 0.12,
                        "{px}: {found}, {want}"
                    );
                }
                assert_eq!(pixel[1], image.rgb[(y * size.x + x) as usize][1]);
            }
        }
    }
}
