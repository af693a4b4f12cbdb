//! What Meng et al. 2020 publish, as printed.

/// A column of Fig. 7: frames per second for one user.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fig7User {
    /// Full resolution ("regular rendering").
    pub rr_fps: u32,
    /// Kernel foveated rendering with the user's σ for both eyes.
    pub kfr_fps: u32,
    /// With the user's σ for the dominant and for the other eye.
    pub efr_fps: u32,
}

/// Averages that the caption of Fig. 7 and §5.4 state.
pub(super) struct Caption {
    pub(super) efr_over_rr: f64,
    pub(super) efr_over_kfr: f64,
}

pub(super) const CAPTION: Caption = Caption {
    efr_over_rr: 2.38,
    efr_over_kfr: 1.35,
};

/// The lower rows of Fig. 7, user by user: speedups of KFR over RR, EFR over RR and EFR over KFR.
pub(super) const FIG_7_SPEEDUPS: [[f64; 3]; 11] = [
    [1.76, 2.48, 1.41],
    [2.24, 2.52, 1.13],
    [2.24, 2.52, 1.13],
    [2.24, 2.38, 1.06],
    [2.43, 2.71, 1.12],
    [1.71, 2.52, 1.47],
    [1.71, 2.52, 1.47],
    [1.67, 2.24, 1.34],
    [1.76, 2.29, 1.30],
    [1.71, 2.19, 1.28],
    [1.71, 2.29, 1.33],
];

/// Least and most of EFR over RR, and of EFR over KFR, as the caption has them.
pub(super) const FIG_7_RANGES: [[f64; 2]; 2] = [[2.19, 2.71], [1.06, 1.47]];

const fn user(kfr_fps: u32, efr_fps: u32) -> Fig7User {
    Fig7User {
        rr_fps: 21,
        kfr_fps,
        efr_fps,
    }
}

/// Fig. 7, users 1 to 11: GTX 1080, Lumberyard Bistro, 1280 × 1440 pixels for each eye (§5.4).
pub(super) const FIG_7: [Fig7User; 11] = [
    user(37, 52),
    user(47, 53),
    user(47, 53),
    user(47, 50),
    user(51, 57),
    user(36, 53),
    user(36, 53),
    user(35, 47),
    user(37, 48),
    user(36, 46),
    user(36, 48),
];

impl Fig7User {
    pub(super) fn rates(&self) -> [f64; 3] {
        [self.rr_fps, self.kfr_fps, self.efr_fps].map(f64::from)
    }

    /// Frame times of RR, KFR and EFR \[ms\].
    pub fn times_ms(&self) -> [f64; 3] {
        self.rates().map(|fps| 1e3 / fps)
    }

    /// Speedup of KFR over RR.
    pub fn kfr_over_rr(&self) -> f64 {
        f64::from(self.kfr_fps) / f64::from(self.rr_fps)
    }

    /// Speedup of EFR over RR.
    pub fn efr_over_rr(&self) -> f64 {
        f64::from(self.efr_fps) / f64::from(self.rr_fps)
    }

    /// Speedup of EFR over KFR.
    pub fn efr_over_kfr(&self) -> f64 {
        f64::from(self.efr_fps) / f64::from(self.kfr_fps)
    }
}
