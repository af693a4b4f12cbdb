use std::fmt;
use std::str::FromStr;

use super::{Estimate, LayersSettings, Screen, request};
use crate::{Acuity, GazeDirection, ModelError, unknown_name};

/// How an image is foveated, written `name:setting:setting`: `full`, or `layers:N` with the settings
/// of [`LayersSettings`] (`layers:3:strict:s2=2`).
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Method {
    /// Every display pixel, nothing foveated.
    Full,
    /// Nested layers around the gaze, each coarser (Guenter 2012).
    Layers(LayersSettings),
}

impl Method {
    /// How many samples are needed in closed form, with gaze anywhere (eye frame) and radii that are
    /// optimal for a gaze straight ahead.
    ///
    /// # Errors
    /// As [`Method::plan`].
    pub fn estimate(
        &self,
        screen: &Screen,
        acuity: Acuity,
        gaze: GazeDirection,
        margin_deg: f64,
    ) -> Result<Estimate, ModelError> {
        request::check(gaze, margin_deg)?;
        Ok(match self {
            Self::Full => Estimate::full(screen),
            Self::Layers(settings) => {
                let design = settings.design(screen, acuity, margin_deg)?;
                design.estimate(gaze.vector(), settings.coverage)
            }
        })
    }

    /// Reads methods separated by commas.
    ///
    /// # Errors
    /// If there is none, or one of them is not a method.
    pub fn parse_list(text: &str) -> Result<Vec<Self>, ModelError> {
        text.split(',').map(|part| part.trim().parse()).collect()
    }
}

impl FromStr for Method {
    type Err = ModelError;

    fn from_str(text: &str) -> Result<Self, ModelError> {
        let (name, settings) = match text.split_once(':') {
            Some((name, settings)) => (name, Some(settings)),
            None => (text, None),
        };
        match (name, settings) {
            ("full", None) => Ok(Self::Full),
            ("full", Some(given)) => {
                let valid = "left out: full has no settings";
                Err(ModelError::range("setting of full", given, valid))
            }
            ("layers", Some(settings)) => settings.parse().map(Self::Layers),
            ("layers", None) => "".parse().map(Self::Layers),
            _ => Err(unknown_name("method", name, &["full", "layers"])),
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Full => f.write_str("full"),
            Self::Layers(settings) => settings.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_and_methods() {
        for (text, canonical) in [
            ("full", "full"),
            ("layers:3", "layers:3"),
            ("layers:3:strict", "layers:3:blending=strict"),
            (
                "layers:3:paper:strict",
                "layers:3:coverage=paper:blending=strict",
            ),
            ("layers:3:s2=2", "layers:3:s2=2"),
            (
                "layers:4:blending=strict:coverage=paper:weights=half",
                "layers:4:coverage=paper:blending=strict:weights=half",
            ),
            ("layers:2:exact:blending=paper:weights=unit", "layers:2"),
        ] {
            let method: Method = text.parse().unwrap();
            assert_eq!(method.to_string(), canonical);
            assert_eq!(canonical.parse::<Method>().unwrap(), method);
        }
        assert_eq!(Method::parse_list("full, layers:3").unwrap().len(), 2);
    }

    #[test]
    fn an_estimate_needs_a_gaze_and_a_margin() {
        let display = crate::presets::display("lg-w2363d").unwrap();
        let screen = Screen::from(&display.primary().viewport);
        let estimate = |method: &str, az, el, margin| {
            let method: Method = method.parse().unwrap();
            method.estimate(
                &screen,
                Acuity::default(),
                GazeDirection::new(az, el),
                margin,
            )
        };
        for method in ["full", "layers:3"] {
            assert!(estimate(method, 0.0, 0.0, 0.0).unwrap().samples() > 0.0);
            for (az, el, margin, field) in [
                (f64::NAN, 0.0, 0.0, "gaze azimuth [deg] = NaN"),
                (f64::INFINITY, 0.0, 0.0, "gaze azimuth [deg] = inf"),
                (0.0, f64::NAN, 0.0, "gaze elevation [deg] = NaN"),
                (0.0, 91.0, 0.0, "gaze elevation [deg] = 91"),
                (0.0, 0.0, f64::NAN, "margin [deg] = NaN"),
            ] {
                let error = estimate(method, az, el, margin).unwrap_err().to_string();
                assert!(error.starts_with(field), "{method}: {error}");
            }
        }
    }

    #[test]
    fn errors_say_what_would_be_valid() {
        for (text, expect) in [
            ("layer:3", "did you mean `layers`?"),
            ("", "unknown method"),
            ("full:2", "full has no settings"),
            ("layers", "as in layers:3"),
            ("layers:0", "from 1 to 16"),
            ("layers:17", "from 1 to 16"),
            ("layers:-1", "from 1 to 16"),
            ("layers:3:strcit", "did you mean `strict`?"),
            ("layers:3:coverage=papr", "did you mean `paper`?"),
            ("layers:3:s2=nan", "from 1 to 1000000"),
            ("layers:3:s2=0.5", "from 1 to 1000000"),
            ("layers:1:s2=2", "no second layer"),
            ("layers:3:", "unknown setting"),
        ] {
            let error = text.parse::<Method>().unwrap_err().to_string();
            assert!(error.contains(expect), "{text}: {error}");
        }
        assert!(Method::parse_list("full,").is_err());
        assert!(Method::parse_list("").is_err());
    }
}
