//! How many pixels a flat display has, as people write it.

use anyhow::{anyhow, bail};
use foveasim_models::foveation::Screen;
use foveasim_models::math::to_rad;
use foveasim_study::{DensityAt, Resolution};

/// `foveal`, or a fraction of it.
pub(super) fn sharpness(text: &str) -> anyhow::Result<Resolution> {
    let fraction = if text == "foveal" {
        1.0
    } else {
        text.parse().unwrap_or(f64::NAN)
    };
    if !(1e-3..=1e3).contains(&fraction) {
        bail!("--sharpness {text}: want foveal, or a fraction of it from 0.001 to 1000, as in 0.4");
    }
    Ok(Resolution::Sharpness(fraction))
}

/// `centre:40` and the like. A bare number is refused with what it could mean at `fov` degrees.
pub(super) fn per_degree(text: &str, fov: f64) -> anyhow::Result<Resolution> {
    let ppd = |text: &str| {
        let value = text
            .parse::<f64>()
            .ok()
            .filter(|v| (1e-3..=1e5).contains(v));
        value.ok_or_else(|| anyhow!("--ppd {text}: want pixels per degree from 0.001 to 100000"))
    };
    let Some((place, value)) = text.split_once(':') else {
        let value = ppd(text)?;
        let centre = 2.0 * Screen::half_width_tan(fov)? / to_rad(1.0 / value);
        bail!(
            "--ppd {text} is ambiguous: {fov} degrees are {centre:.0} pixels if meant at the centre, \
             {:.0} if meant on average; write centre:{text}, mean:{text} or min:{text}",
            value * fov
        );
    };
    let at = match place {
        "centre" => DensityAt::Centre,
        "mean" => DensityAt::Mean,
        "min" => DensityAt::Min,
        _ => {
            let names = ["centre", "mean", "min"];
            return Err(foveasim_models::unknown_name("place of --ppd", place, &names).into());
        }
    };
    Ok(Resolution::PerDegree(at, ppd(value)?))
}
