use glam::{DVec2, UVec2};

use crate::cells::nearest_sites;
use crate::ghosts::mirrored;
use crate::lbg::{Convergence, LbgIteration, settle};
use crate::morton::morton_order;
use crate::phi::Phi;
use crate::{Delaunay, MaskError, MaskSpec, Weights};

/// A sampling mask: sites in Morton order, and what every pixel takes of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Mask {
    pub(crate) spec: MaskSpec,
    /// Mask pixels, multiples of 2⁻¹⁰.
    pub(crate) sites: Vec<DVec2>,
    /// Square root of each cell's area \[px\].
    pub(crate) spacing: Vec<f32>,
    pub(crate) weights: Weights,
    pub(crate) convergence: Convergence,
}

impl Mask {
    /// Builds the mask of `spec`, and tells `progress` of every iteration.
    ///
    /// # Errors
    /// If `spec` is out of range, or so sparse that its sites have no triangle.
    pub fn build(spec: &MaskSpec, progress: &dyn Fn(&LbgIteration)) -> Result<Self, MaskError> {
        spec.check()?;
        let phi = Phi::new(spec);
        let settled = settle(spec, &phi, progress);
        let order = morton_order(&settled.sites);
        let sites: Vec<DVec2> = order.iter().map(|&k| settled.sites[k as usize]).collect();
        let spacing = order.iter().map(|&k| settled.spacing[k as usize]).collect();
        let owner = nearest_sites(spec.mask_px(), &sites);
        let mirrored = mirrored(spec.mask_px(), &sites, &owner);
        let delaunay = Delaunay::new(&mirrored.places)?;
        let weights = Weights::build(
            spec.mask_px(),
            &delaunay,
            &mirrored.site,
            &owner,
            spec.interpolation,
        );
        Ok(Self {
            spec: *spec,
            sites,
            spacing,
            weights,
            convergence: settled.convergence,
        })
    }

    /// What it was built from.
    pub fn spec(&self) -> &MaskSpec {
        &self.spec
    }

    /// Pixels: twice the display's in each axis.
    pub fn size(&self) -> UVec2 {
        self.spec.mask_px()
    }

    /// Where the sites are \[mask px\], in Morton order; the gaze is at the mask's middle.
    pub fn sites(&self) -> &[DVec2] {
        &self.sites
    }

    /// Square root of the area of each site's cell \[px\]: how far rays are apart there.
    pub fn spacing(&self) -> &[f32] {
        &self.spacing
    }

    /// What pixels take of sites.
    pub fn weights(&self) -> &Weights {
        &self.weights
    }

    /// How the sites came to rest.
    pub fn convergence(&self) -> &Convergence {
        &self.convergence
    }
}
