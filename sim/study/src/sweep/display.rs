use foveasim_models::foveation::Screen;
use foveasim_models::math::to_rad;
use foveasim_models::{Acuity, Display, Eye, GazeDirection, ModelError, Pose, Rate, Viewport};
use glam::DVec3;

/// A display of a sweep: a preset, or one that does not exist yet and may have fractions of pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepDisplay {
    /// Its short name; `planar` for one made up from a field of view.
    pub name: String,
    /// Horizontal field of view that any eye sees \[deg\].
    pub fov_h_deg: f64,
    /// One image (planar), or left then right.
    pub eyes: Vec<SweepEye>,
    /// Refreshes per second, where known.
    pub refresh: Option<Rate>,
}

/// One eye's image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SweepEye {
    /// Whose image.
    pub eye: Eye,
    /// Where the eye sits in the head.
    pub head_from_eye: Pose,
    /// The image plane, as closed forms see it.
    pub screen: Screen,
    /// The same with whole pixels; `None` where it has none.
    pub viewport: Option<Viewport>,
    /// Fraction of the image that the optics never show.
    pub hidden_area_fraction: f64,
}

impl SweepDisplay {
    /// The same display at another rate.
    #[must_use]
    pub fn at(mut self, refresh: Rate) -> Self {
        self.refresh = Some(refresh);
        self
    }

    /// A display of one image as two, one for each eye.
    ///
    /// # Panics
    /// If it has two already.
    #[must_use]
    pub fn for_both_eyes(mut self) -> Self {
        assert_eq!(self.eyes.len(), 1, "{} has two images", self.name);
        let image = self.eyes[0];
        self.eyes = [Eye::Left, Eye::Right]
            .map(|eye| SweepEye { eye, ..image })
            .into();
        self
    }
}

impl SweepEye {
    /// Straight ahead of the head, in the eye's own frame.
    pub fn ahead(&self) -> GazeDirection {
        GazeDirection::from_vector(self.head_from_eye.inverse().direction(DVec3::NEG_Z))
    }
}

/// Where a number of pixels per degree holds: the same display has 40 at its centre and 66 on average
/// at 120 degrees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DensityAt {
    /// Straight ahead.
    Centre,
    /// Width over field of view.
    Mean,
    /// Where it is lowest. On a flat screen seen from in front of its centre that is the centre.
    Min,
}

/// How many pixels a planar display has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Resolution {
    /// Width and height.
    Pixels([u32; 2]),
    /// Pixels per degree, rounded to whole pixels.
    PerDegree(DensityAt, f64),
    /// ω₀/ω*: 1 is as sharp at the centre as the fovea. Not rounded.
    Sharpness(f64),
}

impl Resolution {
    /// A planar display that fills `fov_h_deg`, `aspect` times as high as wide ([`Self::Pixels`] has
    /// an aspect of its own).
    ///
    /// # Errors
    /// If the field of view is not above 0 and below 180 degrees, or pixels come out below 1 or above
    /// 65,536 on an axis (1e9 for [`Self::Sharpness`]).
    pub fn display(self, fov_h_deg: f64, aspect: f64) -> Result<SweepDisplay, ModelError> {
        let half = Screen::half_width_tan(fov_h_deg)?;
        let (screen, viewport) = match self {
            Self::Pixels(size) => whole(size, half)?,
            Self::PerDegree(at, ppd) => {
                let width = match at {
                    DensityAt::Centre | DensityAt::Min => 2.0 * half / to_rad(1.0 / ppd),
                    DensityAt::Mean => ppd * fov_h_deg,
                };
                whole(
                    [
                        round_px("width [px]", width)?,
                        round_px("height [px]", width * aspect)?,
                    ],
                    half,
                )?
            }
            Self::Sharpness(fraction) => {
                // ω₀ alone matters, and it is the same for every slope.
                let screen =
                    Screen::from_sharpness(fov_h_deg, Acuity::default(), fraction, aspect)?;
                (screen, None)
            }
        };
        let eye = SweepEye {
            eye: Eye::Cyclopean,
            head_from_eye: Pose::IDENTITY,
            screen,
            viewport,
            hidden_area_fraction: 0.0,
        };
        Ok(SweepDisplay {
            name: "planar".into(),
            fov_h_deg,
            eyes: vec![eye],
            refresh: None,
        })
    }
}

fn whole(size: [u32; 2], half: f64) -> Result<(Screen, Option<Viewport>), ModelError> {
    let viewport = Viewport::symmetric(size.into(), half)?;
    Ok((Screen::from(&viewport), Some(viewport)))
}

fn round_px(field: &str, px: f64) -> Result<u32, ModelError> {
    let rounded = px.round();
    if (1.0..=65_536.0).contains(&rounded) {
        Ok(rounded as u32)
    } else {
        Err(ModelError::range(field, px, "1 to 65536"))
    }
}

impl From<&Display> for SweepDisplay {
    fn from(display: &Display) -> Self {
        let eye = |panel: &foveasim_models::EyePanel| SweepEye {
            eye: panel.eye,
            head_from_eye: panel.head_from_eye,
            screen: Screen::from(&panel.viewport),
            viewport: Some(panel.viewport),
            hidden_area_fraction: panel.hidden_area_fraction,
        };
        Self {
            name: display.name.clone(),
            fov_h_deg: display.fov_h_deg(),
            eyes: display.eyes.iter().map(eye).collect(),
            refresh: Some(display.scan.rate),
        }
    }
}
