use foveasim_models::foveation::Method;
use foveasim_models::math::sqrt;
use foveasim_quality::psnr_db;
use foveasim_reports::Cell;

/// One method on one clip.
#[derive(Debug, Clone, PartialEq)]
pub struct ParetoRow {
    /// The clip; `all` for the mean over them.
    pub clip: String,
    /// The method.
    pub method: Method,
    /// Time of a frame \[ms\].
    pub time_ms: f64,
    /// Samples for which visibility is found, per frame.
    pub samples: f64,
    /// Evaluations of shading, per frame.
    pub shadings: f64,
    /// Framebuffers of a frame \[MB\].
    pub memory_mb: f64,
    /// How far its frames are from the reference.
    pub errors: Errors,
    /// Quality by another program, in just-objectionable differences (FovVideoVDP), where such was imported: 10 is
    /// no difference.
    pub jod: Option<f64>,
}

/// How far the frames of a method are from the reference: means over the frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Errors {
    /// SSIM of luma.
    pub ssim: f64,
    /// Mean squared error of luma \[grey levels²\].
    pub mse: f64,
    /// Mean difference of luma \[grey levels\].
    pub bias: f64,
    /// Flicker of the error at each pixel \[grey levels\]; `None` of a single frame.
    pub flicker: Option<f64>,
    /// … followed along the motion.
    pub followed: Option<f64>,
    /// By ring of eccentricity about where the eye looks in each frame.
    pub rings: Vec<ParetoRing>,
}

/// One ring of eccentricity, all frames together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParetoRing {
    /// Inner edge \[deg\].
    pub from_deg: f64,
    /// Outer edge \[deg\]; `None` for the last ring, which is open.
    pub to_deg: Option<f64>,
    /// Pixels of all frames in it; the values below are `None` if there is none.
    pub pixels: u64,
    /// Mean SSIM.
    pub ssim: Option<f64>,
    /// Mean squared error of luma \[grey levels²\].
    pub mse: Option<f64>,
    /// Mean difference of luma \[grey levels\].
    pub bias: Option<f64>,
}

impl Errors {
    /// Root of the mean squared error of luma \[grey levels of 255\].
    pub fn rmse(&self) -> f64 {
        sqrt(self.mse)
    }

    /// PSNR of luma \[dB\]; infinite where the images are equal.
    pub fn psnr_db(&self) -> f64 {
        psnr_db(self.mse)
    }

    /// Means over several clips; of rings by their pixels.
    pub(super) fn mean(all: &[&Self]) -> Option<Self> {
        let first = all.first()?;
        let n = all.len() as f64;
        let of = |f: &dyn Fn(&Self) -> f64| all.iter().fold(0.0, |sum, e| sum + f(e)) / n;
        let where_all = |f: fn(&Self) -> Option<f64>| {
            let there = all.iter().all(|e| f(e).is_some());
            there.then(|| of(&|e| f(e).unwrap_or(0.0)))
        };
        let ring = |k: usize| {
            let rings = all.iter().map(|e| &e.rings[k]);
            let pixels: u64 = rings.clone().map(|r| r.pixels).sum();
            let weighted = |f: fn(&ParetoRing) -> Option<f64>| {
                let sum = rings.clone().fold(0.0, |sum, r| {
                    sum + f(r).map_or(0.0, |v| v * r.pixels as f64)
                });
                (pixels > 0).then(|| sum / pixels as f64)
            };
            ParetoRing {
                pixels,
                ssim: weighted(|r| r.ssim),
                mse: weighted(|r| r.mse),
                bias: weighted(|r| r.bias),
                ..first.rings[k]
            }
        };
        Some(Self {
            ssim: of(&|e| e.ssim),
            mse: of(&|e| e.mse),
            bias: of(&|e| e.bias),
            flicker: where_all(|e| e.flicker),
            followed: where_all(|e| e.followed),
            rings: (0..first.rings.len()).map(ring).collect(),
        })
    }
}

impl ParetoRow {
    pub(super) const COLUMNS: [&'static str; 15] = [
        "clip",
        "method",
        "time_ms",
        "time_from",
        "speedup",
        "samples",
        "shadings",
        "memory_mb",
        "ssim",
        "psnr_luma_db",
        "rmse_grey_levels",
        "bias_grey_levels",
        "flicker_grey_levels",
        "followed_flicker_grey_levels",
        "jod",
    ];

    /// As [`Self::COLUMNS`] has them; `full_ms` is full resolution's time.
    pub(super) fn cells(&self, full_ms: f64, time_from: &str) -> Vec<Cell> {
        let e = &self.errors;
        vec![
            self.clip.as_str().into(),
            self.method.to_string().into(),
            self.time_ms.into(),
            time_from.into(),
            (full_ms / self.time_ms).into(),
            self.samples.into(),
            self.shadings.into(),
            self.memory_mb.into(),
            e.ssim.into(),
            e.psnr_db().into(),
            e.rmse().into(),
            e.bias.into(),
            e.flicker.into(),
            e.followed.into(),
            self.jod.into(),
        ]
    }
}
