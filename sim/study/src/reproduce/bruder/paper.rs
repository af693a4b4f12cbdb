//! What Bruder et al. 2019 publish, as printed.

/// A row of Table 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Printed {
    pub(super) name: &'static str,
    /// Its voxels, as Fig. 2 has them; the first has none there.
    pub(super) dims: Option<[u32; 3]>,
    /// Mean frames per second, regular and foveated.
    pub(super) fps: [f64; 2],
}

/// Table 1: a GeForce GTX 1070, 1024², 256 cameras with 256 gazes each.
pub(super) const TABLE_1: [Printed; 6] = [
    row("Combustion", None, [73.85, 154.20]),
    row("Supernova", Some([432; 3]), [37.60, 105.28]),
    row("Vortex cascade", Some([529; 3]), [33.27, 104.87]),
    row("Zeiss", Some([680; 3]), [98.50, 177.09]),
    row("Flower", Some([1024; 3]), [22.79, 74.08]),
    row("Chameleon", Some([1024, 1024, 1080]), [35.99, 99.78]),
];

const fn row(name: &'static str, dims: Option<[u32; 3]>, fps: [f64; 2]) -> Printed {
    Printed { name, dims, fps }
}

/// Half the width of 1024 pixels of 0.276725 mm (24 inches, 1920 × 1080; §5) over a distance of 60 cm, which the paper
/// does not state.
pub(super) const HALF_WIDTH_TAN: f64 = 512.0 * 0.276_725_233 / 600.0;

/// Reconstruction on that card, mean and standard deviation \[ms\] (§5).
pub(super) const RECONSTRUCTION_MS: [f64; 2] = [1.5, 0.157];

/// Least and most of the speedups (§5).
pub(super) const SPEEDUPS: [f64; 2] = [1.8, 3.2];

/// Rays over pixels are fewer than this (§5).
pub(super) const RAYS_SHARE: f64 = 0.08;
