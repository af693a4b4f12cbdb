use foveasim_mask::{Interpolation, Mask, StepLaw, TemporalMean};
use foveasim_models::math::{atan_deg, mean, pow, sqrt};
use foveasim_models::{Image, Role, Stream, Viewport};
use foveasim_quality::{PEAK, RingQuality, Rings, compare, psnr_db};
use foveasim_reports::Table;
use foveasim_volume::Caster;
use glam::{DVec2, UVec2};

use super::frame::Foveated;
use super::protocol::Camera;
use super::{Bruder2019, BruderMasks, ReproduceError};

/// Inner edges of the rings, as parts of half the image's width.
const EDGES: [f64; 4] = [0.0, 0.1, 0.3, 0.6];

/// How far the gaze wanders while frames are averaged, standard deviation \[px\]: about what an eye does that keeps still.
const WANDERS_PX: f64 = 3.0;

/// Error of one volume against its full image, gaze in the middle.
#[derive(Debug, Clone, PartialEq)]
pub struct BruderErrors {
    /// Every ring of every way to draw.
    pub rings: Vec<BruderRing>,
}

/// Error in one ring around the gaze, over all cameras.
#[derive(Debug, Clone, PartialEq)]
pub struct BruderRing {
    /// How it is drawn.
    pub way: &'static str,
    /// From and to, as parts of half the image's width; the last has no end.
    pub edges: (f64, Option<f64>),
    /// Of the mean squared error over all cameras \[dB\].
    pub psnr_db: f64,
    /// Mean.
    pub ssim: f64,
    /// Mean of the image's luma less the full one's \[grey levels of 255\].
    pub bias: f64,
    /// The bias farthest from 0 of any camera \[grey levels of 255\].
    pub worst_bias: f64,
    /// Light of the ring over that of the full image, of all cameras: 1 if none is lost or gained. Luma, of which the bias
    /// is, grows with the root of light: where fine detail is averaged, its mean rises although light stays.
    pub light: f64,
}

/// A way to draw.
struct Way {
    name: &'static str,
    /// Of the masks of the density that is measured; none: the paper's density.
    interpolation: Option<Interpolation>,
    step: StepLaw,
    /// Frames that are averaged.
    frames: u32,
}

fn ways(asked: &Bruder2019) -> [Way; 7] {
    let way = |name, interpolation, step, frames| Way {
        name,
        interpolation,
        step,
        frames,
    };
    let [nearest, barycentric, natural] = Interpolation::ALL.map(Some);
    [
        way("natural", natural, asked.step, 1),
        way("natural, equal steps", natural, StepLaw::Equal, 1),
        way("natural, authors' steps", natural, StepLaw::AUTHORS, 1),
        way(
            "natural, mean of 8 frames",
            natural,
            asked.step,
            TemporalMean::PUBLISHED_FRAMES,
        ),
        way("natural, Gaussian density", None, asked.step, 1),
        way("barycentric", barycentric, asked.step, 1),
        way("nearest", nearest, asked.step, 1),
    ]
}

impl BruderErrors {
    /// With the gaze in the middle of every camera's image; and the first camera's full image beside the foveated one.
    pub(super) fn measure(
        asked: &Bruder2019,
        caster: &Caster,
        masks: &BruderMasks,
        cameras: &[Camera],
        step: &mut dyn FnMut(),
    ) -> Result<(Self, [Image; 2]), ReproduceError> {
        let size = masks.natural().spec().display_px;
        let nothing = || Image::filled(UVec2::ONE, [0.0; 3]);
        let mut pictures = [nothing(), nothing()];
        // By way and camera.
        let mut found: Vec<Vec<OfCamera>> = vec![Vec::new(); ways(asked).len()];
        for (number, camera) in cameras.iter().enumerate() {
            let full = caster.full(&camera.view)?.image;
            let optics = &camera.view.optics;
            let middle = optics.direction(size.as_dvec2() / 2.0);
            let degrees = |part: &f64| atan_deg(part * optics.tan[1]);
            let rings = Rings::new(EDGES.iter().map(degrees).collect())?;
            for (way, rows) in ways(asked).iter().zip(&mut found) {
                let mask = match way.interpolation {
                    Some(interpolation) => &masks.masks[interpolation as usize],
                    None => &masks.gaussian,
                };
                let image = draw(caster, camera, mask, way, asked.seed)?;
                rows.push(OfCamera {
                    rings: compare(&image, &full)?.rings(optics, middle, &rings)?,
                    light: [light(&image, optics), light(&full, optics)],
                });
                if number == 0 && way.name == "natural" {
                    pictures[1] = image;
                }
            }
            if number == 0 {
                pictures[0] = full;
            }
            step();
        }
        let rings = ways(asked)
            .iter()
            .zip(&found)
            .flat_map(|(way, rows)| (0..EDGES.len()).map(move |ring| over_cameras(way, rows, ring)))
            .collect();
        Ok((Self { rings }, pictures))
    }

    /// One way's error in one ring.
    pub fn at(&self, way: &str, ring: usize) -> Option<&BruderRing> {
        self.rings.iter().filter(|r| r.way == way).nth(ring)
    }

    pub(super) fn columns() -> [&'static str; 9] {
        [
            "volume",
            "way",
            "from_half_widths",
            "to_half_widths",
            "psnr_db",
            "ssim",
            "bias_grey_levels",
            "worst_bias_grey_levels",
            "light_over_full",
        ]
    }

    pub(super) fn add_to(&self, volume: &str, table: &mut Table) {
        for ring in &self.rings {
            table.push(vec![
                volume.into(),
                ring.way.into(),
                ring.edges.0.into(),
                ring.edges.1.into(),
                ring.psnr_db.into(),
                ring.ssim.into(),
                ring.bias.into(),
                ring.worst_bias.into(),
                ring.light.into(),
            ]);
        }
    }
}

fn draw(
    caster: &Caster,
    camera: &Camera,
    mask: &Mask,
    way: &Way,
    seed: u64,
) -> Result<Image, ReproduceError> {
    let size = mask.spec().display_px;
    let random = &mut Stream::new(seed, Role::Jitter, 0);
    let mut mean = TemporalMean::new(way.frames);
    let mut last = None;
    for frame in 0..way.frames {
        // The last frame looks at the middle, as the others' only one does.
        let away = DVec2::new(random.normal(), random.normal()) * WANDERS_PX;
        let away = if frame + 1 < way.frames {
            away
        } else {
            DVec2::ZERO
        };
        let gaze = size.as_dvec2() / 2.0 + away;
        let image = Foveated::cast(caster, &camera.view, mask, gaze, way.step)?
            .reconstruct(caster.options().background)?;
        last = Some(mean.push(image, frame == 0));
    }
    Ok(last.expect("at least one frame"))
}

/// Rings of several cameras as one: all have the same pixels in it.
fn over_cameras(way: &Way, rows: &[OfCamera], ring: usize) -> BruderRing {
    let of = |f: fn(&RingQuality) -> Option<f64>| {
        let values: Vec<f64> = rows.iter().filter_map(|r| f(&r.rings[ring])).collect();
        values
    };
    let squares: Vec<f64> = of(|r| r.psnr_db)
        .into_iter()
        .map(|db| PEAK * PEAK * pow(10.0, -db / 10.0))
        .collect();
    let biases = of(|r| r.bias);
    let worst = biases
        .iter()
        .copied()
        .max_by(|a, b| a.abs().total_cmp(&b.abs()));
    BruderRing {
        way: way.name,
        edges: (EDGES[ring], EDGES.get(ring + 1).copied()),
        psnr_db: psnr_db(mean(&squares)),
        ssim: mean(&of(|r| r.ssim)),
        bias: mean(&biases),
        worst_bias: worst.unwrap_or(f64::NAN),
        light: {
            let of = |k: usize| rows.iter().map(|r| r.light[k][ring]).sum::<f64>();
            of(0) / of(1)
        },
    }
}

/// Luminance (Rec. 709) of all pixels of each ring, in linear light.
fn light(image: &Image, optics: &Viewport) -> [f64; EDGES.len()] {
    let mut found = [0.0; EDGES.len()];
    for (k, rgb) in image.rgb.iter().enumerate() {
        let px = DVec2::new(
            (k as u32 % image.size.x) as f64 + 0.5,
            (k as u32 / image.size.x) as f64 + 0.5,
        );
        let direction = optics.direction(px);
        let away = sqrt(direction.x * direction.x + direction.y * direction.y);
        let ring = EDGES.partition_point(|part| part * optics.tan[1] <= away);
        let [r, g, b] = rgb.map(f64::from);
        found[ring.saturating_sub(1)] += 0.2126 * r + 0.7152 * g + 0.0722 * b;
    }
    found
}

/// A way's image from one camera against the full one.
#[derive(Debug, Clone)]
struct OfCamera {
    rings: Vec<RingQuality>,
    /// Light of each ring, of the image and of the full one.
    light: [[f64; EDGES.len()]; 2],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_is_summed_by_ring() {
        let size = UVec2::new(100, 80);
        let optics = Viewport::symmetric(size, 0.5).unwrap();
        let mut image = Image::filled(size, [1.0; 3]);
        let all = light(&image, &optics);
        assert!((all.iter().sum::<f64>() - 8000.0).abs() < 1e-6);
        // Discs of 5, 15 and 30 pixels about the middle.
        for (k, pixels) in [78.5, 628.3, 2120.6].into_iter().enumerate() {
            assert!((all[k] / pixels - 1.0).abs() < 0.05, "{all:?}");
        }
        // The pixel at the middle twice as bright, one in the corner dark.
        image.rgb[40 * 100 + 50] = [2.0; 3];
        image.rgb[0] = [0.0; 3];
        let changed = light(&image, &optics);
        let differences: Vec<f64> = changed
            .iter()
            .zip(&all)
            .map(|(a, b)| (a - b).round())
            .collect();
        assert_eq!(differences, [1.0, 0.0, 0.0, -1.0]);
    }
}
