use glam::{DVec2, UVec2};

use super::cover::TanBox;
use crate::{Affine, Lattice, Map, Viewport};

/// A grid over the part of the screen inside `area`, with `scale` display pixels per sample.
///
/// * It lies on the screen: no sample is spent outside.
/// * Bilinear reconstruction at any pixel of `area` finds all four samples around it inside the grid,
///   except within half a sample of the screen's own edge, where reading clamps. So the grid reaches
///   half a sample beyond `area` wherever the screen goes on.
/// * At scale 1 it is the display's own grid: whole-pixel origin, nothing to interpolate, no padding.
pub(super) fn covering(viewport: &Viewport, area: TanBox, scale: f64) -> (Lattice, Map) {
    let step = viewport.pixel_tan();
    let low = DVec2::new(area.min.x - viewport.tan[0], viewport.tan[2] - area.max.y) / step;
    let high = DVec2::new(area.max.x - viewport.tan[0], viewport.tan[2] - area.min.y) / step;
    let x = axis(viewport.size.x, low.x, high.x, scale);
    let y = axis(viewport.size.y, low.y, high.y, scale);
    let map = Affine {
        origin: DVec2::new(x.origin, y.origin),
        scale: DVec2::new(x.scale, y.scale),
    };
    (
        Lattice::Grid(UVec2::new(x.samples, y.samples)),
        Map::Affine(map),
    )
}

/// A grid over the whole screen, at least as fine as `scale`.
pub(super) fn whole(viewport: &Viewport, scale: f64) -> (Lattice, Map) {
    let x = whole_axis(viewport.size.x, scale);
    let y = whole_axis(viewport.size.y, scale);
    let map = Affine {
        origin: DVec2::ZERO,
        scale: DVec2::new(x.scale, y.scale),
    };
    (
        Lattice::Grid(UVec2::new(x.samples, y.samples)),
        Map::Affine(map),
    )
}

struct Axis {
    origin: f64,
    scale: f64,
    samples: u32,
}

/// As many samples as needed, stretched evenly so that the last one ends at the edge.
fn whole_axis(pixels: u32, scale: f64) -> Axis {
    let samples = (f64::from(pixels) / scale).ceil().max(1.0);
    Axis {
        origin: 0.0,
        scale: f64::from(pixels) / samples,
        samples: samples as u32,
    }
}

fn axis(pixels: u32, low: f64, high: f64, scale: f64) -> Axis {
    let edge = f64::from(pixels);
    let (low, high) = (low.clamp(0.0, edge), high.clamp(0.0, edge));
    #[expect(
        clippy::float_cmp,
        reason = "the inner layer's scale is exactly 1 by construction"
    )]
    if scale == 1.0 {
        let first = low.floor().min(edge - 1.0);
        let samples = (high.ceil() - first).max(1.0);
        return Axis {
            origin: first,
            scale: 1.0,
            samples: samples as u32,
        };
    }
    let (padded_low, padded_high) = (low - scale / 2.0, high + scale / 2.0);
    let (from, to) = (padded_low.max(0.0), padded_high.min(edge));
    let samples = ((to - from) / scale).ceil().max(1.0);
    let extent = samples * scale;
    if extent >= edge {
        return whole_axis(pixels, scale);
    }
    // What rounding up adds goes to both sides alike, as far as the screen allows.
    let origin = (from - (extent - (to - from)) / 2.0).clamp(0.0, edge - extent);
    Axis {
        origin,
        scale,
        samples: samples as u32,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// The promises of [`covering`], axis by axis.
        #[test]
        fn reads_stay_inside(
            pixels in 1u32..3000, a in -500.0f64..3500.0, width in 0.01f64..4000.0, s in 1.0f64..60.0,
        ) {
            let edge = f64::from(pixels);
            let (low, high) = (a.clamp(0.0, edge), (a + width).clamp(0.0, edge));
            prop_assume!(low < high);
            let g = axis(pixels, a, a + width, s);
            let end = g.origin + g.scale * f64::from(g.samples);
            prop_assert!(g.samples >= 1 && g.scale <= s);
            prop_assert!(g.origin >= 0.0 && end <= edge + 1e-9);
            prop_assert!(g.origin <= low && end >= high - 1e-9);
            // First and last sample centres bracket the area, or sit at the screen's edge.
            let (first, last) = (g.origin + g.scale / 2.0, end - g.scale / 2.0);
            prop_assert!(s == 1.0 || first <= low + 1e-9 || g.origin == 0.0);
            prop_assert!(s == 1.0 || last >= high - 1e-9 || end >= edge - 1e-9);
            // No more than rounding and padding ask for.
            prop_assert!(f64::from(g.samples) <= (high - low) / s + 2.0 + 1e-9);
        }

        #[test]
        fn the_display_grid_is_kept(pixels in 1u32..3000, a in -500.0f64..3500.0, w in 0.01f64..999.0) {
            prop_assume!(a < f64::from(pixels) && a + w > 0.0);
            let g = axis(pixels, a, a + w, 1.0);
            prop_assert!(g.origin.fract() == 0.0 && g.scale == 1.0 && g.samples >= 1);
            prop_assert!(g.origin + f64::from(g.samples) <= f64::from(pixels));
            prop_assert!(g.origin <= a.max(0.0));
            prop_assert!(g.origin + f64::from(g.samples) >= (a + w).min(f64::from(pixels)));
        }
    }
}
