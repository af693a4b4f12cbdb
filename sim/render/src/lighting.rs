use std::str::FromStr;

use foveasim_models::{ModelError, unknown_name};
use glam::DVec3;

use crate::RenderError;

/// Light beyond a sun and an even sky, each part of which can be switched on: what differs where foveation differs.
/// By default nothing is, and nothing of it costs anything.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Lighting {
    /// Whether the sun casts shadows.
    pub shadows: Option<Shadows>,
    /// Light of the sky by the surface's normal from an image of all of it, instead of between two colours
    /// (see [`Irradiance`](foveasim_assets::Irradiance)).
    pub image_based: bool,
    /// Whether near surfaces darken one another.
    pub occlusion: Option<Occlusion>,
}

/// Shadows of the sun from a map of what it sees (Williams 1978), with percentage-closer filtering (Reeves et al. 1987)
/// over the four texels around a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shadows {
    /// Texels along each side of a map, 16 to 8192.
    pub size: u32,
    /// Where a second map of as many texels looks more closely.
    pub focus: Option<Focus>,
}

/// A part of the world that is seen from the sun with more texels than the rest: foveation of the shadows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Focus {
    /// Its middle, world \[m\]: what the eye looks at.
    pub centre: DVec3,
    /// How far around it \[m\], 0.001 to 1e5.
    pub radius_m: f64,
}

/// Darkening by what is near, from the depths of a pass alone (screen-space ambient occlusion, Mittring 2007), as
/// a factor on the shaded colour. Distances in the lattice follow the density of its samples, so that what is near in the world is looked at
/// wherever samples lie (Friston 2019, §7: "multiplying all image distances by the pixel density").
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Occlusion {
    /// How far away what darkens may be \[m\], 0.001 to 1e3.
    pub radius_m: f64,
}

impl Default for Shadows {
    /// 2048 × 2048 texels over the whole scene.
    fn default() -> Self {
        Self {
            size: 2048,
            focus: None,
        }
    }
}

impl Default for Occlusion {
    /// Within 25 cm.
    fn default() -> Self {
        Self { radius_m: 0.25 }
    }
}

impl Lighting {
    /// Everything, as it is by default.
    pub fn all() -> Self {
        Self {
            shadows: Some(Shadows::default()),
            image_based: true,
            occlusion: Some(Occlusion::default()),
        }
    }

    pub(crate) fn check(&self) -> Result<(), RenderError> {
        let refuse = |field, value: String, valid: &str| {
            Err(RenderError::OutOfRange {
                field,
                value,
                valid: valid.into(),
            })
        };
        if let Some(shadows) = &self.shadows {
            if !(16..=8192).contains(&shadows.size) {
                let valid = "from 16 to 8192 texels a side";
                return refuse("shadow map", shadows.size.to_string(), valid);
            }
            if let Some(focus) = &shadows.focus {
                let there = focus.centre.is_finite() && focus.centre.abs().max_element() <= 1e6;
                if !there || !(1e-3..=1e5).contains(&focus.radius_m) {
                    let valid = "a place within ±1e6 m and a radius from 0.001 to 1e5 m";
                    return refuse("focus of shadows", format!("{focus:?}"), valid);
                }
            }
        }
        match self.occlusion {
            Some(Occlusion { radius_m }) if !(1e-3..=1e3).contains(&radius_m) => {
                let valid = "from 0.001 to 1000 m";
                refuse("radius of occlusion", radius_m.to_string(), valid)
            }
            _ => Ok(()),
        }
    }
}

/// Parts, as users write them.
const NAMES: [&str; 5] = ["none", "all", "shadows", "image", "occlusion"];

impl FromStr for Lighting {
    type Err = ModelError;

    /// Reads `none`, `all`, or parts with commas: `shadows` or `shadows=SIZE`, `image`, `occlusion` or
    /// `occlusion=RADIUS_M`.
    fn from_str(text: &str) -> Result<Self, ModelError> {
        match text {
            "none" => return Ok(Self::default()),
            "all" => return Ok(Self::all()),
            _ => {}
        }
        let mut lighting = Self::default();
        for part in text.split(',').map(str::trim) {
            let (name, value) = match part.split_once('=') {
                Some((name, value)) => (name, Some(value)),
                None => (part, None),
            };
            match (name, value) {
                ("image", None) => lighting.image_based = true,
                ("shadows", value) => {
                    let mut shadows = Shadows::default();
                    if let Some(value) = value {
                        let size = value.parse().ok().filter(|n| (16..=8192).contains(n));
                        let valid = "a whole number of texels from 16 to 8192";
                        let wrong = || ModelError::range("shadows", value, valid);
                        shadows.size = size.ok_or_else(wrong)?;
                    }
                    lighting.shadows = Some(shadows);
                }
                ("occlusion", value) => {
                    let mut occlusion = Occlusion::default();
                    if let Some(value) = value {
                        let radius = value.parse().ok().filter(|r| (1e-3..=1e3).contains(r));
                        let wrong =
                            || ModelError::range("occlusion", value, "from 0.001 to 1000 m");
                        occlusion.radius_m = radius.ok_or_else(wrong)?;
                    }
                    lighting.occlusion = Some(occlusion);
                }
                _ => return Err(unknown_name("part of lighting", part, &NAMES)),
            }
        }
        Ok(lighting)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_read_by_name() {
        assert_eq!("none".parse(), Ok(Lighting::default()));
        assert_eq!("all".parse(), Ok(Lighting::all()));
        assert_eq!("shadows,image,occlusion".parse(), Ok(Lighting::all()));
        let some: Lighting = "occlusion=0.5, shadows=512".parse().unwrap();
        assert_eq!(some.shadows.map(|s| s.size), Some(512));
        assert_eq!(some.occlusion, Some(Occlusion { radius_m: 0.5 }));
        assert!(!some.image_based && some.check().is_ok());
        for (wrong, part) in [
            ("", "unknown part"),
            ("shadow", "did you mean `shadows`?"),
            ("image=3", "unknown part"),
            ("shadows=0", "16 to 8192"),
            ("occlusion=nan", "0.001 to 1000"),
            ("all,image", "unknown part"),
        ] {
            let error = wrong.parse::<Lighting>().unwrap_err().to_string();
            assert!(error.contains(part), "{wrong}: {error}");
        }
    }
}
