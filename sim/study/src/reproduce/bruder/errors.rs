use foveasim_mask::{Interpolation, Mask, StepLaw, TemporalMean};
use foveasim_models::math::{atan_deg, mean, pow};
use foveasim_models::{Image, Role, Stream};
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
        let mut found: Vec<Vec<Vec<RingQuality>>> = vec![Vec::new(); ways(asked).len()];
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
                rows.push(compare(&image, &full)?.rings(optics, middle, &rings)?);
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

    pub(super) fn columns() -> [&'static str; 8] {
        [
            "volume",
            "way",
            "from_half_widths",
            "to_half_widths",
            "psnr_db",
            "ssim",
            "bias_grey_levels",
            "worst_bias_grey_levels",
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
fn over_cameras(way: &Way, rows: &[Vec<RingQuality>], ring: usize) -> BruderRing {
    let of = |f: fn(&RingQuality) -> Option<f64>| {
        let values: Vec<f64> = rows.iter().filter_map(|r| f(&r[ring])).collect();
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
    }
}
