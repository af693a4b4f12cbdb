//! What there is to say of a sampling mask: how it came to rest, how its rays lie, what it costs.

mod charts;

use foveasim_mask::{
    Interpolation, Mask, MaskSpec, SpacingStatistics, cells_picture, order_picture,
};
use foveasim_models::Image;
use foveasim_models::math::quantile_sorted;
use foveasim_reports::{Cell, LineChart, Table};
use glam::UVec2;

/// A mask described.
#[derive(Debug)]
pub struct MaskReport<'a> {
    mask: &'a Mask,
    statistics: SpacingStatistics,
}

/// Rays within a range of distances from the gaze.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SpacingBin {
    /// Middle of the range \[px\].
    pub(crate) distance_px: f64,
    /// Rays.
    pub(crate) rays: u64,
    /// 5 %, half and 95 % of their cells are at most so wide \[px\].
    pub(crate) spacing_px: [f64; 3],
    /// 1/√Φ \[px\].
    pub(crate) wanted_px: f64,
}

impl<'a> MaskReport<'a> {
    /// Measures `mask`.
    pub fn new(mask: &'a Mask) -> Self {
        Self {
            mask,
            statistics: SpacingStatistics::of(mask),
        }
    }

    /// What is asked for and what came of it.
    pub fn summary(&self) -> Table {
        let spec = self.mask.spec();
        let found = self.mask.convergence();
        let display = f64::from(spec.display_px.element_product());
        let mut table = Table::new(["quantity", "value"]);
        let mut row = |name: &str, value: Cell| table.push(vec![name.into(), value]);
        row("display_px", size(spec.display_px));
        row("mask_px", size(spec.mask_px()));
        for (name, value) in density(spec) {
            row(name, value);
        }
        row("interpolation", spec.interpolation.name().into());
        row("rays", self.mask.sites().len().into());
        row("integral_of_density", found.integral.into());
        if let Some((width, ratio, [low, high])) = found.ratio() {
            row("iterations", found.iterations.len().into());
            row("last_hysteresis", width.into());
            row("rays_over_integral", ratio.into());
            row("… at_least", low.into());
            row("… at_most", high.into());
        }
        row("rays_gaze_in_the_middle", self.rays_in_the_middle().into());
        row(
            "… over_pixels",
            (self.rays_in_the_middle() as f64 / display).into(),
        );
        row("weights", self.mask.weights().entries().into());
        let bytes = self.mask.weights().bytes() as f64 / f64::from(1 << 20);
        row("weights_MiB", bytes.into());
        table
    }

    fn rays_in_the_middle(&self) -> usize {
        let middle = self.mask.spec().display_px.as_dvec2() / 2.0;
        foveasim_mask::PlacedMask::new(self.mask, middle).rays()
    }

    /// Every iteration of Linde-Buzo-Gray.
    pub fn convergence(&self) -> Table {
        let mut table = Table::new([
            "iteration",
            "hysteresis",
            "sites",
            "sites_over_integral",
            "split",
            "merged",
            "least_share_rays",
            "greatest_share_rays",
            "moved_rms_px",
            "sum_of_shares_rays",
        ]);
        let found = self.mask.convergence();
        for row in &found.iterations {
            let [least, greatest] = row.share;
            table.push(vec![
                row.iteration.into(),
                row.width.into(),
                row.sites.into(),
                (row.sites as f64 / found.integral).into(),
                row.split.into(),
                row.merged.into(),
                least.into(),
                greatest.into(),
                row.moved_px.into(),
                row.total.into(),
            ]);
        }
        table
    }

    /// How rays lie to one another, by how far apart they are.
    pub fn spacing(&self) -> Table {
        let mut table = Table::new([
            "spacing_from_px",
            "spacing_to_px",
            "rays_looked_at",
            "nearest_over_spacing_p5",
            "nearest_over_spacing_p50",
            "aligned_4",
            "aligned_6",
            "aligned_by_chance",
        ]);
        for ring in &self.statistics.rings {
            table.push(vec![
                ring.from_px.into(),
                ring.to_px.into(),
                ring.sites.into(),
                ring.nearest[0].into(),
                ring.nearest[1].into(),
                ring.aligned[0].into(),
                ring.aligned[1].into(),
                (1.0 / (ring.sites as f64).sqrt()).into(),
            ]);
        }
        table
    }

    /// How far apart rays are at each distance from the gaze.
    pub fn distances(&self) -> Table {
        let mut table = Table::new([
            "distance_px",
            "rays",
            "spacing_p5_px",
            "spacing_p50_px",
            "spacing_p95_px",
            "wanted_px",
        ]);
        for bin in self.bins() {
            table.push(vec![
                bin.distance_px.into(),
                bin.rays.into(),
                bin.spacing_px[0].into(),
                bin.spacing_px[1].into(),
                bin.spacing_px[2].into(),
                bin.wanted_px.into(),
            ]);
        }
        table
    }

    /// In fiftieths of the way to the display's corner.
    fn bins(&self) -> Vec<SpacingBin> {
        const BINS: usize = 50;
        let middle = self.mask.size().as_dvec2() / 2.0;
        let step = (middle.length() / BINS as f64).max(1.0);
        let mut bins = vec![Vec::new(); BINS];
        for (site, spacing) in self.mask.sites().iter().zip(self.mask.spacing()) {
            let at = (site.distance(middle) / step) as usize;
            bins[at.min(BINS - 1)].push(f64::from(*spacing));
        }
        let mut found = Vec::new();
        for (k, mut these) in bins.into_iter().enumerate() {
            if these.is_empty() {
                continue;
            }
            these.sort_by(f64::total_cmp);
            let distance_px = (k as f64 + 0.5) * step;
            found.push(SpacingBin {
                distance_px,
                rays: these.len() as u64,
                spacing_px: [0.05, 0.5, 0.95].map(|q| quantile_sorted(&these, q)),
                wanted_px: self.mask.spec().density.spacing_px(distance_px),
            });
        }
        found
    }

    /// Every chart by the name of its file.
    pub fn charts(&self) -> [(&'static str, LineChart); 4] {
        charts::all(self.mask, &self.statistics, &self.bins())
    }

    /// Cells and order of rays around the gaze, by the name of their files: the whole fovea, and near.
    pub fn pictures(&self) -> [(&'static str, Image); 4] {
        let whole = self.mask.size().min(UVec2::splat(1024));
        let near = UVec2::splat(1024);
        [
            ("cells", cells_picture(self.mask, whole, 1)),
            ("cells-near", cells_picture(self.mask, near, 3)),
            ("order", order_picture(self.mask, whole, 1)),
            ("order-near", order_picture(self.mask, near, 3)),
        ]
    }
}

/// How pixels come from rays, by name.
///
/// # Errors
/// If there is none of that name.
pub fn interpolation(name: &str) -> Result<Interpolation, foveasim_models::ModelError> {
    let all = Interpolation::ALL;
    let found = all.into_iter().find(|i| i.name() == name);
    found.ok_or_else(|| {
        foveasim_models::unknown_name("interpolation", name, &all.map(Interpolation::name))
    })
}

fn size(px: UVec2) -> Cell {
    format!("{}x{}", px.x, px.y).into()
}

fn density(spec: &MaskSpec) -> Vec<(&'static str, Cell)> {
    let names = match spec.density.name() {
        "gaussian" => ["sigma_px", "floor_rays_per_px"],
        _ => ["peak", "half_px"],
    };
    let parameters = names.into_iter().zip(spec.density.parameters());
    std::iter::once(("density", spec.density.name().into()))
        .chain(parameters.map(|(name, value)| (name, value.into())))
        .collect()
}
