use foveasim_models::{ModelError, RayDensity};
use glam::UVec2;
use sha2::{Digest, Sha256};

/// Sites are kept to this part of a pixel, so that distances between them and pixels are exact in double precision.
pub(crate) const SUBPIXELS: f64 = 1024.0;

/// Changes whenever the same specification would give another mask.
pub(crate) const ALGORITHM: u32 = 1;

/// All that a mask follows from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaskSpec {
    /// The display \[px\]. The mask has twice as many in each axis, so that the display lies within it for any gaze.
    pub display_px: UVec2,
    /// Rays per pixel around the gaze.
    pub density: RayDensity,
    /// How far cells may be off their share.
    pub hysteresis: Hysteresis,
    /// How pixels come from sites.
    pub interpolation: Interpolation,
    /// Seed of where sites begin.
    pub seed: u64,
}

/// By how much a cell's share of density may differ from one ray in the i-th iteration before the cell is split or
/// merged: within 1 ± (start + i·step)/2 it stays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hysteresis {
    /// In the first iteration.
    pub start: f64,
    /// More in each further one.
    pub step: f64,
}

/// How a pixel's value comes from those of the sites around it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Interpolation {
    /// The nearest site's.
    Nearest,
    /// Linear in the triangle of sites around it.
    Barycentric,
    /// By the areas that the pixel would take of the sites' cells (Sibson 1980).
    #[default]
    Natural,
}

impl Hysteresis {
    /// The paper's: 0.5 + 0.1·i (Bruder 2019, §4.1).
    pub const PUBLISHED: Self = Self {
        start: 0.5,
        step: 0.1,
    };
    /// The authors' program's: 0.5 + 0.01·i. More iterations, and cells closer to their share.
    pub const AUTHORS: Self = Self {
        start: 0.5,
        step: 0.01,
    };

    /// The width h of iteration `i`.
    pub fn width(self, i: u32) -> f64 {
        self.start + f64::from(i) * self.step
    }
}

impl Interpolation {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Nearest, Self::Barycentric, Self::Natural];

    /// `nearest`, `barycentric` or `natural`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nearest => "nearest",
            Self::Barycentric => "barycentric",
            Self::Natural => "natural",
        }
    }
}

impl MaskSpec {
    /// Most pixels of a display that masks are built for (a mask has four times as many).
    pub const MOST_PIXELS: u64 = 1 << 23;
    /// Most rays of a mask.
    pub const MOST_RAYS: f64 = (1u32 << 22) as f64;

    /// With the paper's hysteresis and natural neighbours.
    pub fn new(display_px: UVec2, density: RayDensity, seed: u64) -> Self {
        Self {
            display_px,
            density,
            hysteresis: Hysteresis::PUBLISHED,
            interpolation: Interpolation::Natural,
            seed,
        }
    }

    /// Pixels of the mask.
    pub fn mask_px(&self) -> UVec2 {
        self.display_px * 2
    }

    /// ∫Φ over the mask: how many rays it should have.
    pub fn rays(&self) -> f64 {
        self.density.on_display(self.mask_px().as_dvec2())
    }

    /// Refuses what no mask can be built for.
    pub(crate) fn check(&self) -> Result<(), ModelError> {
        let UVec2 { x, y } = self.display_px;
        let sides = (8..=8192).contains(&x) && (8..=8192).contains(&y);
        if !sides || u64::from(x) * u64::from(y) > Self::MOST_PIXELS {
            let valid = "sides from 8 to 8192 and at most 8388608 pixels";
            return Err(ModelError::range(
                "display of a mask",
                format!("{x} x {y}"),
                valid,
            ));
        }
        let Hysteresis { start, step } = self.hysteresis;
        if !((0.1..=1.9).contains(&start) && (1e-3..=1.0).contains(&step)) {
            let valid = "a start from 0.1 to 1.9 and a step from 0.001 to 1";
            return Err(ModelError::range(
                "hysteresis",
                format!("{start} + {step} i"),
                valid,
            ));
        }
        let rays = self.rays();
        if !(8.0..=Self::MOST_RAYS).contains(&rays) {
            let valid = "a density with 8 to 4194304 on the mask";
            return Err(ModelError::range(
                "rays of a mask",
                format!("{rays:.1}"),
                valid,
            ));
        }
        Ok(())
    }

    /// What identifies the mask of this specification, as hexadecimal digits: SHA-256 of all its numbers and of
    /// what this version of the program makes of them.
    pub fn key(&self) -> String {
        let mut hash = Sha256::new();
        hash.update(b"foveasim mask");
        hash.update(ALGORITHM.to_le_bytes());
        hash.update(self.display_px.x.to_le_bytes());
        hash.update(self.display_px.y.to_le_bytes());
        hash.update(self.seed.to_le_bytes());
        hash.update(self.density.name());
        for number in self.density.parameters() {
            hash.update(number.to_bits().to_le_bytes());
        }
        for number in [self.hysteresis.start, self.hysteresis.step] {
            hash.update(number.to_bits().to_le_bytes());
        }
        hash.update(self.interpolation.name());
        hash.finalize()
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect()
    }
}
