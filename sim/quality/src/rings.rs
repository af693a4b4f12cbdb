use foveasim_models::{Viewport, math};
use glam::{DVec2, DVec3, UVec2};
use rayon::prelude::*;

use crate::{Comparison, QualityError, psnr_db};

/// Rings of eccentricity about the gaze, by their edges; the last ring is open to the outside.
#[derive(Debug, Clone, PartialEq)]
pub struct Rings {
    edges_deg: Vec<f64>,
}

/// What is true of one ring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingQuality {
    /// Inner edge \[deg\].
    pub from_deg: f64,
    /// Outer edge \[deg\]; `None` for the last ring, which is open.
    pub to_deg: Option<f64>,
    /// Pixels whose centre lies in it; the values below are `None` if there is none.
    pub pixels: u64,
    /// PSNR of luma \[dB\]; infinite where the images are equal.
    pub psnr_db: Option<f64>,
    /// Mean of the SSIM map.
    pub ssim: Option<f64>,
    /// Mean luma of the image minus that of the reference \[grey levels of 255\]: brighter is positive.
    pub bias: Option<f64>,
}

/// The rings on an image plane.
pub(crate) struct Places {
    viewport: Viewport,
    gaze: DVec3,
    cosines: Vec<f64>,
}

/// Sums over some pixels of a ring.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    pixels: u64,
    squares: f64,
    ssim: f64,
    bias: f64,
}

impl Default for Rings {
    /// 0, 2, 5, 10, 20 and 30 degrees.
    fn default() -> Self {
        Self {
            edges_deg: vec![0.0, 2.0, 5.0, 10.0, 20.0, 30.0],
        }
    }
}

impl Rings {
    /// Rings between these edges \[deg\], and one more from the last edge outwards.
    ///
    /// # Errors
    /// If there is no edge, or they are not increasing numbers from 0 to below 90.
    pub fn new(edges_deg: Vec<f64>) -> Result<Self, QualityError> {
        let valid = edges_deg.iter().all(|e| (0.0..90.0).contains(e))
            && edges_deg.windows(2).all(|w| w[0] < w[1])
            && !edges_deg.is_empty();
        if valid {
            Ok(Self { edges_deg })
        } else {
            Err(QualityError::RingEdges { edges: edges_deg })
        }
    }

    /// Inner edges of the rings \[deg\].
    pub fn edges_deg(&self) -> &[f64] {
        &self.edges_deg
    }

    /// Where the rings lie in images of `size` pixels seen on `viewport`.
    ///
    /// # Errors
    /// If the viewport does not have the images' pixels, or the gaze is no direction.
    pub(crate) fn places(
        &self,
        viewport: &Viewport,
        gaze: DVec3,
        size: UVec2,
    ) -> Result<Places, QualityError> {
        if viewport.size != size {
            return Err(QualityError::ViewportDiffers {
                viewport: viewport.size,
                images: size,
            });
        }
        let length = gaze.length();
        if !(length.is_finite() && length > 0.0) {
            return Err(QualityError::Gaze {
                gaze: gaze.to_array(),
            });
        }
        let cosine = |&e: &f64| math::cos(math::to_rad(e));
        Ok(Places {
            viewport: *viewport,
            gaze: gaze / length,
            cosines: self.edges_deg.iter().map(cosine).collect(),
        })
    }
}

impl Places {
    /// How many rings.
    pub(crate) fn count(&self) -> usize {
        self.cosines.len()
    }

    /// The ring of each pixel of row `y`, by its centre; `None` inside the innermost edge.
    pub(crate) fn of_row(&self, y: u32) -> impl Iterator<Item = Option<usize>> + '_ {
        (0..self.viewport.size.x).map(move |x| {
            let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let d = self.viewport.direction(centre);
            // Rounding may lift the cosine of the pixel straight ahead above one.
            let cosine = (d.dot(self.gaze) / math::sqrt(d.dot(d))).min(1.0);
            // A pixel is at or outside an edge exactly when its cosine is at or below the edge's.
            let inside = self.cosines.iter().take_while(|&&c| cosine <= c).count();
            inside.checked_sub(1)
        })
    }
}

impl Comparison {
    /// The same measures by ring of eccentricity: `gaze` is the direction of gaze in the eye's frame
    /// (of any length), `viewport` the image plane both images were seen on.
    ///
    /// # Errors
    /// If the viewport does not have the images' pixels, or the gaze is no direction.
    pub fn rings(
        &self,
        viewport: &Viewport,
        gaze: DVec3,
        rings: &Rings,
    ) -> Result<Vec<RingQuality>, QualityError> {
        let size = self.image.size();
        let places = rings.places(viewport, gaze, size)?;
        let row_sums = |y: u32| {
            let mut sums = vec![Sums::default(); places.count()];
            let at = y as usize;
            let (image, reference) = (self.image.row(at), self.reference.row(at));
            for (ring, (&ssim, (&i, &r))) in places.of_row(y).zip(
                self.ssim_map
                    .row(at)
                    .iter()
                    .zip(image.iter().zip(reference)),
            ) {
                if let Some(ring) = ring {
                    let s = &mut sums[ring];
                    s.pixels += 1;
                    s.squares += (i - r) * (i - r);
                    s.ssim += ssim;
                    s.bias += i - r;
                }
            }
            sums
        };
        let rows: Vec<Vec<Sums>> = (0..size.y).into_par_iter().map(row_sums).collect();
        let ring = |k: usize| {
            let sum = |field: fn(&Sums) -> f64| {
                math::sum(&rows.iter().map(|row| field(&row[k])).collect::<Vec<_>>())
            };
            let pixels: u64 = rows.iter().map(|row| row[k].pixels).sum();
            let mean = |field| (pixels > 0).then(|| sum(field) / pixels as f64);
            RingQuality {
                from_deg: rings.edges_deg[k],
                to_deg: rings.edges_deg.get(k + 1).copied(),
                pixels,
                psnr_db: mean(|s| s.squares).map(psnr_db),
                ssim: mean(|s| s.ssim),
                bias: mean(|s| s.bias),
            }
        };
        Ok((0..places.count()).map(ring).collect())
    }
}
