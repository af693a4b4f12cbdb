use std::f64::consts::TAU;

use glam::{DVec2, UVec2};

use super::estimate::{Estimate, PassEstimate};
use super::quadrature::around;
use super::{KernelForm, KernelSettings, Request, Screen};
use crate::{
    Cadence, Filter, Lattice, LogPolar, Map, ModelError, Msaa, Pass, Region, Resolve, SamplePlan,
    Shading, Visibility,
};

/// Kernel foveated rendering (Meng 2018) as a drawable plan: W/σ × H/σ samples, each rounded up, on the
/// log-polar map about the gaze, or about the place of the image nearest to it. Samples beyond the image
/// are not drawn.
///
/// The direct form is one pass. As published, a first pass finds visibility at every pixel and shades
/// nothing, and the log-polar one shades what that sees.
pub(super) fn plan(
    method: String,
    settings: &KernelSettings,
    request: &Request,
) -> Result<SamplePlan, ModelError> {
    let display = request.viewport.size;
    let lattice = buffer(display, settings.sigma());
    let gaze = Screen::from(&request.viewport).nearest_px(request.gaze.vector());
    let map = LogPolar::new(gaze, display, settings.alpha(), lattice.as_dvec2())?;
    let full = SamplePlan::full(request.eye, display);
    let visibility = match settings.form {
        KernelForm::Direct => None,
        KernelForm::Published => Some(Pass {
            shading: Shading::Nowhere,
            ..full.passes[0].clone()
        }),
    };
    let texels = Pass {
        eye: request.eye,
        lattice: Lattice::Grid(lattice),
        region: Region::on_display(&Map::LogPolar(map), lattice, display),
        map: Map::LogPolar(map),
        offset: DVec2::ZERO,
        visibility: match settings.form {
            KernelForm::Direct => Visibility::Own(Msaa::One),
            KernelForm::Published => Visibility::Shared(0),
        },
        shading: Shading::PerSample,
        cadence: Cadence::EVERY_FRAME,
    };
    Ok(SamplePlan {
        method,
        passes: visibility.into_iter().chain([texels]).collect(),
        resolve: Resolve::Inverse(Filter {
            interpolation: settings.interpolation,
            smooth_from: settings.smooth.then(|| periphery(&map, lattice.x)),
            mips: settings.mips,
        }),
        ..full
    })
}

/// Samples outwards and around: the display's pixels over σ, no fewer.
fn buffer(display: UVec2, sigma: f64) -> UVec2 {
    // Whole but for rounding is whole.
    let side = |pixels: u32| (f64::from(pixels) / sigma * (1.0 - 1e-12)).ceil().max(1.0);
    UVec2::new(side(display.x) as u32, side(display.y) as u32)
}

/// The first column from which on every sample is longer than a pixel, outwards or around.
fn periphery(map: &LogPolar, columns: u32) -> u32 {
    let is_large = |x: &u32| {
        let [outwards, around] = map.step_lengths(f64::from(*x) + 0.5);
        outwards.max(around) > 1.0
    };
    let large = (0..columns).rev().take_while(is_large).count();
    columns - large as u32
}

/// The relative error of the estimate's integral.
const RELATIVE_ERROR: f64 = 1e-6;

/// The same with fractions of samples: W·H/σ² times the mean over directions of how much of the way
/// outwards lies on the screen.
pub(super) fn estimate(
    settings: &KernelSettings,
    screen: &Screen,
    gaze: glam::DVec3,
) -> Result<Estimate, ModelError> {
    let (size, gaze) = (screen.size_px(), screen.nearest_px(gaze));
    let samples = size / settings.sigma();
    let map = LogPolar::over(gaze, size, settings.alpha(), samples)?;
    let texels = on_screen(&map, size);
    let corner = DVec2::from(map.step_lengths(samples.x));
    let shaded = PassEstimate::new(texels, corner);
    let passes = match settings.form {
        KernelForm::Direct => vec![shaded],
        KernelForm::Published => vec![
            PassEstimate {
                shadings: 0.0,
                ..PassEstimate::new(screen.pixels(), DVec2::ONE)
            },
            PassEstimate {
                samples: 0.0,
                ..shaded
            },
        ],
    };
    Ok(Estimate {
        passes,
        display_pixels: screen.pixels(),
    })
}

/// Samples of a map about a place on a screen of `size` pixels that lie on it.
pub(super) fn on_screen(map: &LogPolar, size: DVec2) -> f64 {
    let outwards = |_, to_edge| map.x_at(to_edge);
    map.samples().y / TAU * around(map.gaze_px(), size, RELATIVE_ERROR, outwards)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// oracle s3 buffer_utilisation: the share of the buffer that lies on the screen.
    #[test]
    fn utilisation() {
        for (size, gaze, alpha, share) in [
            ([1280, 1440], [640.0, 720.0], 1.0, 0.964_748_382_568_359_4),
            ([1280, 1440], [640.0, 720.0], 4.0, 0.991_020_202_636_718_8),
            ([1920, 1080], [960.0, 540.0], 1.0, 0.947_696_685_791_015_6),
            ([1920, 1080], [960.0, 540.0], 4.0, 0.986_515_045_166_015_6),
            ([1280, 1440], [320.0, 1000.0], 1.0, 0.890_654_563_903_808_6),
            ([1280, 1440], [320.0, 1000.0], 4.0, 0.971_005_439_758_300_8),
            ([1920, 1080], [1500.5, 200.25], 1.0, 0.842_744_827_270_507_8),
            ([1920, 1080], [1500.5, 200.25], 4.0, 0.957_060_813_903_808_6),
        ] {
            let display = UVec2::from(size);
            let (gaze, samples) = (DVec2::from(gaze), display.as_dvec2() / 2.0);
            let map = LogPolar::new(gaze, display, alpha, samples).unwrap();
            let found = on_screen(&map, display.as_dvec2()) / samples.element_product();
            // The oracle counts a 1024² grid of texels.
            assert!((found - share).abs() < 1e-4, "{found}, {share}");
        }
    }

    #[test]
    fn buffers_are_no_smaller_than_asked() {
        let display = UVec2::new(1280, 1440);
        for (sigma, wanted) in [
            (1.0, [1280, 1440]),
            (1.2, [1067, 1200]),
            (1.8, [712, 800]),
            (2.0, [640, 720]),
            (3.0, [427, 480]),
            (2.4, [534, 600]),
            (100.0, [13, 15]),
        ] {
            assert_eq!(buffer(display, sigma).to_array(), wanted);
        }
        assert_eq!(buffer(UVec2::ONE, 100.0), UVec2::ONE);
    }

    #[test]
    fn the_periphery_is_where_samples_are_large() {
        let map = |alpha| {
            let display = UVec2::new(1280, 1440);
            LogPolar::new(
                DVec2::new(640.0, 720.0),
                display,
                alpha,
                DVec2::new(640.0, 720.0),
            )
            .unwrap()
        };
        for alpha in [0.25, 1.0, 4.0] {
            let from = periphery(&map(alpha), 640);
            let larger = |x: u32| {
                let [a, b] = map(alpha).step_lengths(f64::from(x) + 0.5);
                a.max(b)
            };
            assert!((from..640).all(|x| larger(x) > 1.0));
            assert!(from == 0 || larger(from - 1) <= 1.0, "{alpha}: {from}");
        }
    }
}
