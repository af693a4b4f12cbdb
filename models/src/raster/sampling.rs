use glam::DVec2;

use crate::{Lens, Map, ScanSkew};

/// Where and when a sample of a lattice looks, in the order of Friston 2019, §3.1.4: buffer → unfoveate →
/// display → lens → ray, and the time of where the pixel finally lights.
///
/// ```text
/// lattice ──map──▶ display ──lens──▶ ray (image position)
///                     └────scan────▶ time
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    /// From lattice to display.
    pub map: Map,
    /// Through which the display is seen.
    pub lens: Option<Lens>,
    /// When display pixels light; all at t = 0 without it.
    pub scan: Option<ScanSkew>,
    /// The display's size \[px\].
    pub display_px: DVec2,
}

/// Where and when a sample looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RaySample {
    /// Where it lights \[display px\].
    pub display: DVec2,
    /// Where the light is seen: the position of its ray in the image \[px\].
    pub ray: DVec2,
    /// When, from 0 at the frame's start to 1 at its end.
    pub time: f64,
}

impl Sampling {
    /// Of lattice position `p`.
    pub fn at(&self, p: DVec2) -> RaySample {
        self.of_display(self.map.display_from_lattice(p))
    }

    /// Of the same, no farther out than the display's edge, as samples at the edge are taken (see
    /// [`SamplePlan::position`](crate::SamplePlan::position)).
    pub fn at_clamped(&self, p: DVec2) -> RaySample {
        let display = self.map.display_from_lattice(p);
        self.of_display(display.clamp(DVec2::ZERO, self.display_px))
    }

    /// Of a display position.
    pub fn of_display(&self, display: DVec2) -> RaySample {
        let ray = match &self.lens {
            Some(lens) => lens.ray_from_display(display),
            None => display,
        };
        RaySample {
            display,
            ray,
            time: self.time(display),
        }
    }

    /// When a display position lights, within 0 to 1.
    pub fn time(&self, display: DVec2) -> f64 {
        match &self.scan {
            Some(scan) => scan.time(display, self.display_px).clamp(0.0, 1.0),
            None => 0.0,
        }
    }

    /// The lattice position that shows image position `ray`; `None` where the lens shows nothing.
    pub fn lattice_from_ray(&self, ray: DVec2) -> Option<DVec2> {
        let display = match &self.lens {
            Some(lens) => lens.display_from_ray(ray)?,
            None => ray,
        };
        Some(self.map.lattice_from_display(display))
    }
}
