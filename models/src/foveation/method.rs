use std::fmt;
use std::str::FromStr;

use super::need::Need;
use super::{
    Aim, DominanceSettings, Estimate, KernelSettings, LayersSettings, LensMatchedSettings,
    PlanCache, QuadSettings, RadialSettings, RatesSettings, Screen, TileSettings, fdm, kfr,
    request, vrs,
};
use crate::{Acuity, Eye, GazeDirection, ModelError, unknown_name};

/// How an image is foveated, written `name:setting:setting`: `full`; `layers:N` with the settings
/// of [`LayersSettings`] (`layers:3:strict:s2=2`); `vrs` and `fdm` with those of [`TileSettings`]
/// (`vrs:tile=8`); `rates` with those of [`RatesSettings`]; `quad` with those of [`QuadSettings`]
/// (`quad:auto`); `kfr:SIGMA:ALPHA` with those of [`KernelSettings`] (`kfr:2:4:published`),
/// `efr:SIGMA_D:SIGMA_ND` with those of [`DominanceSettings`], `lms:A:B` with those of
/// [`LensMatchedSettings`] and `radial:K` with those of [`RadialSettings`]. All but `full` can be `fixed` (see [`Aim`]).
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Method {
    /// Every display pixel, nothing foveated.
    Full,
    /// Nested layers around the gaze, each coarser (Guenter 2012).
    Layers(LayersSettings),
    /// Variable-rate shading: visibility at every pixel, shading coarser tile by tile.
    Vrs(TileSettings),
    /// A fragment density map: visibility and shading coarser tile by tile.
    Fdm(TileSettings),
    /// Separable rate maps: a rate for each band of columns and each band of rows.
    Rates(RatesSettings),
    /// Quad views: a sharp rectangle on a coarser whole.
    Quad(QuadSettings),
    /// Kernel foveated rendering: samples on a log-polar map about the gaze (Meng 2018).
    Kfr(KernelSettings),
    /// The same, coarser for the eye that is not dominant (Meng 2020).
    Efr(DominanceSettings),
    /// Lens-matched shading: four quadrants that shrink outwards.
    Lms(LensMatchedSettings),
    /// A buffer that magnifies the fovea (Friston 2019).
    Radial(RadialSettings),
}

/// The methods' names.
const NAMES: [&str; 10] = [
    "full", "layers", "vrs", "fdm", "rates", "quad", "kfr", "efr", "lms", "radial",
];

impl Method {
    /// Whether it follows the gaze.
    pub fn aim(&self) -> Aim {
        match self {
            Self::Full => Aim::Tracked,
            Self::Layers(settings) => settings.aim,
            Self::Vrs(settings) | Self::Fdm(settings) => settings.aim(),
            Self::Rates(settings) => settings.aim(),
            Self::Quad(settings) => settings.aim(),
            Self::Kfr(settings) => settings.aim(),
            Self::Efr(settings) => settings.aim(),
            Self::Lms(settings) => settings.aim(),
            Self::Radial(settings) => settings.aim(),
        }
    }

    /// The same method, following the gaze or not; `full` has nothing to aim.
    #[must_use]
    pub fn with_aim(self, aim: Aim) -> Self {
        match self {
            Self::Full => Self::Full,
            Self::Layers(settings) => Self::Layers(LayersSettings { aim, ..settings }),
            Self::Vrs(settings) => Self::Vrs(settings.with_aim(aim)),
            Self::Fdm(settings) => Self::Fdm(settings.with_aim(aim)),
            Self::Rates(settings) => Self::Rates(settings.with_aim(aim)),
            Self::Quad(settings) => Self::Quad(settings.with_aim(aim)),
            Self::Kfr(settings) => Self::Kfr(settings.with_aim(aim)),
            Self::Efr(settings) => Self::Efr(settings.with_aim(aim)),
            Self::Lms(settings) => Self::Lms(settings.with_aim(aim)),
            Self::Radial(settings) => Self::Radial(settings.with_aim(aim)),
        }
    }

    /// What `eye` gets: for [`Method::Efr`] its own kernel, the method itself otherwise.
    #[must_use]
    pub fn of_eye(self, eye: Eye) -> Self {
        match self {
            Self::Efr(settings) => Self::Kfr(settings.of_eye(eye)),
            other => other,
        }
    }

    /// Whether samples lie where its settings say, whatever the acuity line and the margin: then it is
    /// neither made finer where the eye would see the difference nor, if fixed, for an eye that turns.
    pub fn is_given(&self) -> bool {
        match self {
            Self::Kfr(_) | Self::Efr(_) | Self::Lms(_) | Self::Radial(_) => true,
            Self::Full
            | Self::Layers(_)
            | Self::Vrs(_)
            | Self::Fdm(_)
            | Self::Rates(_)
            | Self::Quad(_) => false,
        }
    }

    /// How many samples are needed where pixel counts may be fractions, with the sharpest part
    /// anywhere (eye frame); radii of layers are optimal for a gaze straight ahead.
    ///
    /// `gaze` is where the method is aimed: for a fixed one straight ahead of the head, which the
    /// caller knows ([`Aim::gaze`]). `margin_deg` is the tracker's; the reach of a fixed method comes
    /// on top. [`Method::Efr`] is the dominant eye's; for the other's see [`Method::of_eye`].
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
        self.estimate_from(None, screen, acuity, gaze, margin_deg)
    }

    /// As [`Method::estimate`], with what a cache has kept.
    pub(super) fn estimate_from(
        &self,
        cache: Option<&PlanCache>,
        screen: &Screen,
        acuity: Acuity,
        gaze: GazeDirection,
        margin_deg: f64,
    ) -> Result<Estimate, ModelError> {
        request::check(gaze, margin_deg)?;
        let gaze = gaze.vector();
        let margin_deg = self.aim().margin_deg(margin_deg);
        let need = Need {
            screen,
            acuity,
            gaze,
            margin_deg,
            cache,
        };
        Ok(match self {
            Self::Full => Estimate::full(screen),
            Self::Layers(settings) => {
                let design = match cache {
                    Some(cache) => cache.design(settings, screen, acuity, margin_deg)?,
                    None => settings.design(screen, acuity, margin_deg)?,
                };
                design.estimate(gaze, settings.coverage)
            }
            Self::Vrs(settings) => vrs::estimate(settings, &need),
            Self::Fdm(settings) => fdm::estimate(settings, &need),
            Self::Rates(settings) => settings.estimate(&need),
            Self::Quad(settings) => settings.estimate(&need),
            Self::Kfr(settings) => kfr::estimate(settings, screen, gaze)?,
            Self::Efr(settings) => kfr::estimate(&settings.of_eye(Eye::Cyclopean), screen, gaze)?,
            Self::Lms(settings) => settings.estimate(screen, gaze)?,
            Self::Radial(settings) => settings.estimate(screen, gaze)?,
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
            ("vrs", None) => Ok(Self::Vrs(TileSettings::default())),
            ("vrs", Some(settings)) => settings.parse().map(Self::Vrs),
            ("fdm", None) => Ok(Self::Fdm(TileSettings::default())),
            ("fdm", Some(settings)) => settings.parse().map(Self::Fdm),
            ("rates", None) => Ok(Self::Rates(RatesSettings::default())),
            ("rates", Some(settings)) => settings.parse().map(Self::Rates),
            ("quad", None) => Ok(Self::Quad(QuadSettings::default())),
            ("quad", Some(settings)) => settings.parse().map(Self::Quad),
            ("kfr", settings) => settings.unwrap_or_default().parse().map(Self::Kfr),
            ("efr", settings) => settings.unwrap_or_default().parse().map(Self::Efr),
            ("lms", settings) => settings.unwrap_or_default().parse().map(Self::Lms),
            ("radial", settings) => settings.unwrap_or_default().parse().map(Self::Radial),
            _ => Err(unknown_name("method", name, &NAMES)),
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Full => f.write_str("full"),
            Self::Layers(settings) => settings.fmt(f),
            Self::Vrs(settings) => write!(f, "vrs{settings}"),
            Self::Fdm(settings) => write!(f, "fdm{settings}"),
            Self::Rates(settings) => write!(f, "rates{settings}"),
            Self::Quad(settings) => write!(f, "quad{settings}"),
            Self::Kfr(settings) => write!(f, "kfr{settings}"),
            Self::Efr(settings) => write!(f, "efr{settings}"),
            Self::Lms(settings) => write!(f, "lms{settings}"),
            Self::Radial(settings) => write!(f, "radial{settings}"),
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
            ("layers:3:fixed:strict", "layers:3:blending=strict:fixed"),
            ("layers:3:fixed=15:s2=2", "layers:3:s2=2:fixed"),
            ("layers:3:fixed:tracked", "layers:3"),
            ("vrs", "vrs"),
            ("vrs:tile=16:max=4:tracked", "vrs"),
            ("vrs:max=2:tile=8:fixed", "vrs:tile=8:max=2:fixed"),
            ("fdm:tile=32", "fdm:tile=32"),
            ("rates:bands=12:fixed=20.5", "rates:bands=12:fixed=20.5"),
            ("rates:fixed", "rates:fixed"),
            ("quad:focus=0.35:peripheral=0.5", "quad"),
            (
                "quad:peripheral=0.4:focus=0.5",
                "quad:focus=0.5:peripheral=0.4",
            ),
            ("quad:auto:fixed=0", "quad:focus=auto:fixed=0"),
            ("kfr:2:4", "kfr:2:4"),
            ("kfr:1.80:0.25:direct:filter=bilinear", "kfr:1.8:0.25"),
            (
                "kfr:2:4:mips:form=published:fixed:smooth:filter=nearest",
                "kfr:2:4:published:filter=nearest:smooth:mips:fixed",
            ),
            ("efr:2:3", "efr:2:3"),
            ("efr:2:3:dominant=right:alpha=4", "efr:2:3"),
            (
                "efr:2:3:published:alpha=0.25:dominant=left",
                "efr:2:3:dominant=left:alpha=0.25:published",
            ),
            ("lms:0.5:0.4:fixed", "lms:0.5:0.4:fixed"),
            ("radial:2", "radial:2"),
            ("radial:2:mips:filter=cubic", "radial:2:filter=cubic:mips"),
            (
                "radial:2.0:scale=1:reach=corner:filter=bilinear",
                "radial:2",
            ),
            (
                "radial:1.5:fixed:filter=nearest:reach=boundary:scale=0.7",
                "radial:1.5:scale=0.7:boundary:filter=nearest:fixed",
            ),
            (
                "lms:0.5:0.4:mips:fixed:filter=cubic:scale=2.50",
                "lms:0.5:0.4:scale=2.5:filter=cubic:mips:fixed",
            ),
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
        for method in [
            "full",
            "layers:3",
            "vrs",
            "fdm:fixed",
            "rates",
            "quad",
            "quad:auto",
            "kfr:2:4",
            "kfr:2:0.25:published",
            "efr:2:3",
            "lms:1:0.5",
            "radial:2:scale=0.5",
        ] {
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
            ("layers:3:fixd", "did you mean `fixed`?"),
            (
                "layers:3:fixed=-1",
                "fixed = -1: must be degrees from 0 to 90",
            ),
            ("full:fixed", "full has no settings"),
            ("rate", "did you mean `rates`?"),
            ("vrs:", "unknown setting"),
            ("vrs:tile", "did you mean `tile=`?"),
            ("vrs:tile=12", "tile = 12: must be 8, 16 or 32 pixels"),
            ("vrs:tile=16.0", "tile = 16.0: must be 8, 16 or 32 pixels"),
            ("vrs:max=3", "max = 3: must be 1, 2 or 4 pixels"),
            ("fdm:max=8", "max = 8: must be 1, 2 or 4 pixels"),
            ("fdm:fixed=nan", "fixed = nan: must be degrees"),
            ("fdm:fixed=90.1", "fixed = 90.1"),
            ("fdm:tracked=1", "unknown setting of tiles `tracked=1`"),
            (
                "rates:bands=0",
                "bands = 0: must be a whole number from 1 to 256",
            ),
            ("rates:bands=257", "from 1 to 256"),
            ("rates:band=3", "did you mean `bands=`?"),
            (
                "quad:focus=0",
                "focus = 0: must be auto, or a number above 0",
            ),
            ("quad:focus=nan", "focus = NaN"),
            ("quad:focus=wide", "focus = wide: must be auto"),
            (
                "quad:peripheral=2",
                "peripheral = 2: must be a number from 0.01 to 1",
            ),
            ("quad:peripheral=", "peripheral = : must be a number"),
            (
                "kfr",
                "sigma of kfr = : must be a number from 0.25 to 100, as in kfr:2:4",
            ),
            (
                "kfr:2",
                "alpha of kfr = : must be a number from 0.01 to 100",
            ),
            ("kfr:0:4", "sigma of kfr = 0: must be"),
            ("kfr:nan:4", "sigma of kfr = nan"),
            ("kfr:2:-4", "alpha of kfr = -4"),
            ("kfr:2:4:", "unknown setting of kfr ``"),
            ("kfr:2:4:publshed", "did you mean `published`?"),
            ("kfr:2:4:form=other", "unknown form `other`"),
            ("kfr:2:4:filter=quintic", "unknown filter `quintic`"),
            ("lms:2:4:filter=gathr", "did you mean `gather`?"),
            ("kfr:2:4:smooth=1", "unknown setting of kfr `smooth=1`"),
            (
                "efr:2",
                "sigma of the other eye = : must be a number from 2",
            ),
            (
                "efr:3:2",
                "sigma of the other eye = 2: must be a number from 3 to 100, as in efr:2:3",
            ),
            ("efr:2:3:dominant=both", "valid: left, right"),
            ("efr:2:3:alpha=", "alpha = : must be a number"),
            ("efr:2:3:alpha=0", "alpha = 0: must be a number from 0.01"),
            ("lms:1", "B of lms = : must be a number from 0 to 20"),
            ("lms:-1:0", "A of lms = -1"),
            (
                "lms:1:1:scale=0",
                "scale of lms = 0: must be a number from 0.05",
            ),
            ("lms:1:1:smooth", "unknown setting of lms `smooth`"),
            (
                "radial",
                "exponent of radial = : must be a number from 1 to 16, as in radial:2",
            ),
            ("radial:0.5", "exponent of radial = 0.5: must be"),
            ("radial:nan", "exponent of radial = nan"),
            ("radial:2:scale=0", "scale = 0: must be a number from 0.05"),
            ("radial:2:scale", "scale = : must be a number"),
            ("radial:2:reach=edge", "unknown reach `edge`"),
            ("radial:2:bounary", "did you mean `boundary`?"),
        ] {
            let error = text.parse::<Method>().unwrap_err().to_string();
            assert!(error.contains(expect), "{text}: {error}");
        }
        assert!(Method::parse_list("full,").is_err());
        assert!(Method::parse_list("").is_err());
    }
}
