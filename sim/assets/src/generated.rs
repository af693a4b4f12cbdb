mod hairball;
mod machine;
mod room;
mod solids;

use std::fmt;
use std::str::FromStr;

use foveasim_models::math::{cos, sin};
use foveasim_models::{ModelError, Pose, unknown_name};
use glam::DVec3;

use crate::{
    EnvironmentMap, Material, Pattern, STUDY_SUN, Scene, Sky, Surface, look_at, study_camera,
    study_scene, study_sky,
};

/// Scenes that are generated, each in one size or speed that can be chosen. The same seed gives the same scene.
///
/// Written as a name, or as a name and a number: `hairball`, `hairball:20000`, `machine:1200`, `room:400`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum GeneratedScene {
    /// The scene of Guenter et al. 2012 ([`study_scene`]): ground, and 20 × 20 objects above it; 8 million triangles at
    /// their finest.
    Study,
    /// Fine strands on a ball, as the hair ball of Friston et al. 2019: closed tubes of three sides that taper to a
    /// point, of 142, 70, 34 or 16 triangles by level of detail, 3.5 mm in radius at their roots, on a sphere of 3,968.
    Hairball {
        /// How many strands, 1 to 20,000: 142 triangles each.
        strands: u32,
    },
    /// A fan in a housing: a rotor of seven twisted blades behind a guard of thin wires; 12,780 triangles, all
    /// parts closed. The rotor is an instance that turns rigidly.
    Machine {
        /// Turns of the rotor per minute, −60,000 to 60,000; positive is counter-clockwise seen from the front.
        rpm: f64,
    },
    /// A hall with columns, a fence, bars before its windows and a grille like a car's: many thin parallel bars. All parts
    /// closed; 50,884 triangles with 160 bars, and 81 for each more.
    Room {
        /// Bars of the fence and of the windows, 1 to 2,000; the grille has a quarter as many slats.
        bars: u32,
    },
}

/// Texels along each side of the environment maps.
const SKY_TEXELS: u32 = 512;

impl GeneratedScene {
    /// Names, as they are written.
    pub const NAMES: [&str; 4] = ["study", "hairball", "machine", "room"];

    /// All of them as they are without a number.
    pub const ALL: [Self; 4] = [
        Self::Study,
        Self::Hairball { strands: 4000 },
        Self::Machine { rpm: 600.0 },
        Self::Room { bars: 160 },
    ];

    /// Its name, without the number.
    pub fn name(self) -> &'static str {
        match self {
            Self::Study => "study",
            Self::Hairball { .. } => "hairball",
            Self::Machine { .. } => "machine",
            Self::Room { .. } => "room",
        }
    }

    /// The scene at time 0.
    pub fn build(self, seed: u64) -> Scene {
        match self {
            Self::Study => study_scene(seed),
            Self::Hairball { strands } => hairball::scene(seed, strands.clamp(1, 20_000)),
            Self::Machine { rpm } => machine::scene(seed, rpm),
            Self::Room { bars } => room::scene(seed, bars.clamp(1, 2000)),
        }
    }

    /// Where the eye is at `t` (0 to 1; values beyond are clamped) of a way that shows the scene.
    pub fn camera(self, t: f64, seed: u64) -> Pose {
        let t = if t > 0.0 { t.min(1.0) } else { 0.0 };
        match self {
            Self::Study => study_camera(t, seed),
            Self::Hairball { .. } => hairball::camera(t),
            Self::Machine { .. } => machine::camera(t),
            Self::Room { .. } => room::camera(t),
        }
    }
}

impl fmt::Display for GeneratedScene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.name();
        match self {
            Self::Study => write!(f, "{name}"),
            Self::Hairball { strands: n } | Self::Room { bars: n } => write!(f, "{name}:{n}"),
            Self::Machine { rpm } => write!(f, "{name}:{rpm}"),
        }
    }
}

impl FromStr for GeneratedScene {
    type Err = ModelError;

    fn from_str(text: &str) -> Result<Self, ModelError> {
        let (name, number) = match text.split_once(':') {
            Some((name, number)) => (name, Some(number)),
            None => (text, None),
        };
        let known = Self::ALL.into_iter().find(|s| s.name() == name);
        let scene = known.ok_or_else(|| unknown_name("scene", name, &Self::NAMES))?;
        let Some(number) = number else {
            return Ok(scene);
        };
        let out_of = |field: &str, valid: &str| ModelError::range(field, number, valid);
        let whole = |field: &str, most: u32| {
            let n = number.parse().ok().filter(|n| (1..=most).contains(n));
            n.ok_or_else(|| out_of(field, &format!("a whole number from 1 to {most}")))
        };
        Ok(match scene {
            Self::Study => return Err(out_of("scene study", "without a number")),
            Self::Hairball { .. } => Self::Hairball {
                strands: whole("strands of scene hairball", 20_000)?,
            },
            Self::Room { .. } => Self::Room {
                bars: whole("bars of scene room", 2000)?,
            },
            Self::Machine { .. } => Self::Machine {
                rpm: number
                    .parse()
                    .ok()
                    .filter(|rpm: &f64| *rpm == 0.0 || (1e-3..=6e4).contains(&rpm.abs()))
                    .ok_or_else(|| {
                        let valid = "0, or a number from 0.001 to 60000, or one of these below 0";
                        out_of("turns per minute of scene machine", valid)
                    })?,
            },
        })
    }
}

/// The sky of scenes that fit into a hall: the study's in clear air.
fn environment(seed: u64) -> Sky {
    let sky = crate::AnalyticSky {
        visibility_m: f32::INFINITY,
        ..study_sky(seed)
    };
    Sky::Map(EnvironmentMap::of_sky(&sky, &STUDY_SUN, SKY_TEXELS))
}

/// An eye `away` metres from `centre`, `above` radians over the horizon, `around` turns from the front.
fn orbit(centre: DVec3, away: f64, above: f64, around: f64) -> Pose {
    let turn = std::f64::consts::TAU * around;
    let out = DVec3::new(sin(turn) * cos(above), sin(above), cos(turn) * cos(above));
    look_at(centre + out * away, centre).expect("the eye is off the centre")
}

/// A surface of two colours; `finish` is roughness, reflectance head on and the share of the mirrored sky.
fn surface(
    albedo: [[f32; 3]; 2],
    pattern: Pattern,
    frequency: f32,
    finish: [f32; 3],
    seed: u32,
) -> Material {
    let [roughness, f0, environment] = finish;
    Material::Surface(Surface {
        albedo,
        pattern,
        frequency,
        roughness,
        f0,
        environment,
        seed,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_back() {
        for scene in GeneratedScene::ALL {
            assert_eq!(scene.to_string().parse(), Ok(scene));
            assert_eq!(scene.name().parse(), Ok(scene));
        }
        assert_eq!(
            "machine:-90".parse(),
            Ok(GeneratedScene::Machine { rpm: -90.0 })
        );
        assert_eq!("room:7".parse(), Ok(GeneratedScene::Room { bars: 7 }));
    }

    #[test]
    fn wrong_names_and_numbers_are_refused() {
        for (text, part) in [
            ("harball", "did you mean `hairball`?"),
            ("hairball:0", "1 to 20000"),
            ("hairball:99999999999", "1 to 20000"),
            ("room:1.5", "1 to 2000"),
            ("machine:nan", "0.001 to 60000"),
            ("machine:1e9", "0.001 to 60000"),
            ("study:2", "without a number"),
            ("", "valid: study, hairball"),
        ] {
            let error = text.parse::<GeneratedScene>().unwrap_err().to_string();
            assert!(error.contains(part), "{text}: {error}");
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_scene_and_counts_are_as_documented() {
        for scene in &GeneratedScene::ALL[1..] {
            let built = scene.build(1);
            assert_eq!(built, scene.build(1));
            assert_ne!(built, scene.build(2), "{scene}");
            let triangles = built.triangle_count();
            let valid = match scene {
                GeneratedScene::Hairball { strands } => {
                    let all = 3968 + u64::from(*strands) * 142;
                    all..=all
                }
                GeneratedScene::Machine { .. } => 12_780..=12_780,
                _ => 50_884..=50_884,
            };
            assert!(valid.contains(&triangles), "{scene}: {triangles}");
        }
    }
}
