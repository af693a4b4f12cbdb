//! What `render` draws, and from where: the study scene or a file.

use std::path::{Path, PathBuf};

use foveasim_assets::{
    GeneratedScene, LoadOptions, STUDY_FRAMES, Scene, Up, Volume, VolumeFormat, framing,
    load_scene, load_volume, look_at, study_camera, study_scene, volume_named,
};
use foveasim_models::{Pose, Viewport};
use glam::DAffine3;

use foveasim_study::{ScanMotion, Sight};

use super::{Context, Failure, options};

/// Scene and camera.
#[derive(Debug, clap::Args)]
pub(crate) struct SceneArgs {
    /// What to draw: study (the scene of Guenter et al. 2012), hairball[:STRANDS], machine[:TURNS PER MINUTE],
    /// room[:BARS], an OBJ, glTF, GLB, PLY or STL file, or a volume: a NIfTI, NRRD, MetaImage, VTI or TOML file, a
    /// vtk.js folder, or volume:KIND[:SIZE] with a KIND of marschner-lobb, jet, filaments, vortices, porous or shells
    #[arg(long, value_name = "NAME|FILE", default_value = "study")]
    scene: String,
    /// Frame of the study scene's fly-through, 0 to 5376; the last one with --frames [default: 500]
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u32).range(..i64::from(STUDY_FRAMES)),
        conflicts_with = "camera"
    )]
    frame: Option<u32>,
    /// Where the eye is, in metres [default: the scene's own, or so that it sees the whole file]
    #[arg(long, value_name = "X,Y,Z", value_parser = options::triple, allow_hyphen_values = true)]
    camera: Option<[f64; 3]>,
    /// What is in the middle of its view, in metres [default: the scene's own, or the middle of the file]
    #[arg(long, value_name = "X,Y,Z", value_parser = options::triple, allow_hyphen_values = true)]
    look_at: Option<[f64; 3]>,
    /// Time of what moves in the scene [s]; of the last frame with --frames [default: 0]
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true)]
    time: Option<f64>,
    /// Picture (PNG or JPEG) for all materials of the file that have none
    #[arg(long, value_name = "FILE")]
    texture: Option<PathBuf>,
    /// Which axis of the file points up [default: y]
    #[arg(long, value_name = "AXIS", value_enum)]
    up: Option<Axis>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Axis {
    /// As glTF has it, and most OBJ files
    Y,
    /// As in engineering
    Z,
}

/// Consecutive frames of a scene.
pub(crate) struct Stage {
    /// What there is to see in each frame: the one scene of all, or one for each.
    scenes: Vec<Scene>,
    /// The eye in each frame.
    world_from_eye: Vec<Pose>,
    /// The eye a scan later, by the scene's own camera.
    a_scan_later: Vec<Pose>,
    /// Number of the first frame.
    pub(crate) first_frame: u64,
    /// Nothing nearer than this is drawn \[m\].
    pub(crate) near_m: f64,
}

/// The study scene's near plane \[m\].
const STUDY_NEAR_M: f64 = 0.05;
/// The near plane of a file of unknown size, as a share of that size, but no farther.
const NEAR_SHARE: f64 = 0.005;

/// What names of generated volumes begin with.
const GENERATED: &str = "volume:";

/// Most instances of all frames together: each frame has a copy of them.
const MOST_PLACEMENTS: usize = 1 << 20;

impl Stage {
    /// The scene of a single frame, and the eye in it.
    pub(crate) fn into_one(mut self) -> (Scene, Pose) {
        let last = self.scenes.pop().expect("a stage has a scene");
        (last, self.world_from_eye[self.world_from_eye.len() - 1])
    }

    /// The frames, oldest first; `scan` says how each is scanned, of its eye a scan later.
    pub(crate) fn sights(&self, scan: impl Fn(Pose) -> Option<ScanMotion>) -> Vec<Sight<'_>> {
        let scenes = self.scenes.iter().cycle();
        let eyes = self.world_from_eye.iter().zip(&self.a_scan_later);
        let sight = |(scene, (&world_from_eye, &later))| Sight {
            scene,
            world_from_eye,
            scan: scan(later),
        };
        scenes.zip(eyes).map(sight).collect()
    }
}

/// A scene's name, and the frame of the study scene's fly-through where one is given: `study@1500`.
pub(crate) fn at_frame(name: &str) -> Result<(&str, Option<u32>), Failure> {
    let Some((base, frame)) = name.split_once('@') else {
        return Ok((name, None));
    };
    match frame.parse() {
        Ok(frame) if base == "study" && frame < STUDY_FRAMES => Ok((base, Some(frame))),
        _ => {
            let last = STUDY_FRAMES - 1;
            let text = format!("--scene {name}: want study@FRAME, a number from 0 to {last}");
            Err(Failure::bad_input(text))
        }
    }
}

impl SceneArgs {
    /// A scene by name or file, as it stands, seen by its own camera.
    pub(crate) fn named(scene: &str, frame: Option<u32>) -> Self {
        Self {
            scene: scene.to_owned(),
            frame,
            camera: None,
            look_at: None,
            time: None,
            texture: None,
            up: None,
        }
    }

    /// Builds or loads the scene as it is in so many consecutive frames (one or more), `period_s`
    /// apart \[s\], and what moves moves on for `scan_s` \[s\] in each; `optics` are what its camera must fit it into.
    pub(crate) fn stage(
        &self,
        optics: &Viewport,
        frames: u32,
        [period_s, scan_s]: [f64; 2],
        ctx: &Context,
    ) -> Result<Stage, Failure> {
        if self.scene == "study" {
            return self.study(frames, scan_s / period_s, ctx);
        }
        let path = Path::new(&self.scene);
        if path.exists() {
            return self.file(path, optics, frames, [period_s, scan_s], ctx);
        }
        match self.scene.parse::<GeneratedScene>() {
            Ok(scene) => self.generated(scene, frames, [period_s, scan_s], ctx),
            // What has an extension was meant as a file.
            Err(_) if path.extension().is_some() && !self.scene.contains(':') => {
                self.file(path, optics, frames, [period_s, scan_s], ctx)
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Refuses flags that only files have.
    fn not_a_file(&self) -> Result<(), Failure> {
        let of_files = [
            ("--texture", self.texture.is_some()),
            ("--up", self.up.is_some()),
        ];
        match of_files.iter().find(|(_, given)| *given) {
            Some((flag, _)) => {
                let text = format!("{flag}: only with a file (--scene FILE)");
                Err(Failure::bad_input(text))
            }
            None => Ok(()),
        }
    }

    /// Time of what moves \[s\].
    fn seconds(&self) -> Result<f64, Failure> {
        let seconds = self.time.unwrap_or(0.0);
        if self.frame.is_some() {
            return Err(Failure::bad_input("--frame: only with --scene study"));
        }
        if !(0.0..=1e6).contains(&seconds) {
            let text = format!("--time {seconds}: must be from 0 to 1000000 seconds");
            return Err(Failure::bad_input(text));
        }
        Ok(seconds)
    }

    fn generated(
        &self,
        scene: GeneratedScene,
        frames: u32,
        periods: [f64; 2],
        ctx: &Context,
    ) -> Result<Stage, Failure> {
        self.not_a_file()?;
        let own = scene.camera(0.0, ctx.seed);
        let ahead = own.position + own.direction([0.0, 0.0, -1.0].into());
        let eye = self.eye(own, Some(ahead.to_array()))?;
        let scenes = in_frames(&scene.build(ctx.seed), self.seconds()?, frames, periods)?;
        Ok(Stage {
            scenes,
            world_from_eye: vec![eye; frames as usize],
            a_scan_later: vec![eye; frames as usize],
            first_frame: 0,
            near_m: STUDY_NEAR_M,
        })
    }

    /// In each frame the camera flies on for `scan` of the way to the next.
    fn study(&self, frames: u32, scan: f64, ctx: &Context) -> Result<Stage, Failure> {
        self.not_a_file()?;
        if self.time.is_some() {
            let text = "--time: only with a scene in which something may move, not study";
            return Err(Failure::bad_input(text));
        }
        if self.camera.is_some() && self.look_at.is_none() {
            let text = "--camera: needs --look-at X,Y,Z in the study scene";
            return Err(Failure::bad_input(text));
        }
        // With a camera of one's own there is no place on the way to end at.
        let last = match self.camera {
            Some(_) => frames - 1,
            None => self.frame.unwrap_or(500),
        };
        let Some(first) = (last + 1).checked_sub(frames) else {
            let text = format!(
                "--frames {frames}: the fly-through has {} up to --frame {last}",
                last + 1
            );
            return Err(Failure::bad_input(text));
        };
        let eye = |frame: f64| {
            let along = frame / f64::from(STUDY_FRAMES);
            self.eye(study_camera(along, ctx.seed), None)
        };
        let eyes = |later: f64| {
            let each = (first..=last).map(|frame| eye(f64::from(frame) + later));
            each.collect::<Result<Vec<_>, _>>()
        };
        Ok(Stage {
            scenes: vec![study_scene(ctx.seed)],
            world_from_eye: eyes(0.0)?,
            a_scan_later: eyes(scan)?,
            first_frame: first.into(),
            near_m: STUDY_NEAR_M,
        })
    }

    fn file(
        &self,
        path: &Path,
        optics: &Viewport,
        frames: u32,
        [period_s, scan_s]: [f64; 2],
        ctx: &Context,
    ) -> Result<Stage, Failure> {
        let seconds = self.seconds()?;
        let up = match self.up {
            None | Some(Axis::Y) => Up::Y,
            Some(Axis::Z) => Up::Z,
        };
        let loaded = load_scene(
            path,
            &LoadOptions {
                texture: self.texture.clone(),
                up,
                ..LoadOptions::default()
            },
        )?;
        for warning in &loaded.warnings {
            ctx.warn(warning);
        }
        let scenes = in_frames(&loaded.scene, seconds, frames, [period_s, scan_s])?;
        let last = &scenes[scenes.len() - 1];
        let bounds = last.bounds().unwrap_or_default();
        let middle = (bounds[0] + bounds[1]) / 2.0;
        let size = (bounds[1] - bounds[0]).length();
        let eye = self.eye(framing(bounds, optics), Some(middle.to_array()))?;
        Ok(Stage {
            scenes,
            world_from_eye: vec![eye; frames as usize],
            a_scan_later: vec![eye; frames as usize],
            first_frame: 0,
            near_m: (NEAR_SHARE * size).clamp(1e-4, STUDY_NEAR_M),
        })
    }

    /// Whether a volume is to be drawn.
    pub(crate) fn is_volume(&self) -> bool {
        let path = Path::new(&self.scene);
        self.scene.starts_with(GENERATED) || VolumeFormat::is_named(path)
    }

    /// The volume that is to be drawn, number `frame` of those that its file has, as it stands before the
    /// viewer.
    pub(crate) fn volume(&self, frame: usize, ctx: &Context) -> Result<Volume, Failure> {
        let of_others = [
            ("--frame", self.frame.is_some()),
            ("--time", self.time.is_some()),
            ("--texture", self.texture.is_some()),
        ];
        if let Some((flag, _)) = of_others.iter().find(|(_, given)| *given) {
            return Err(Failure::bad_input(format!("{flag}: not with a volume")));
        }
        let volume = match self.scene.strip_prefix(GENERATED) {
            Some(name) => volume_named(name, ctx.seed)?,
            None => {
                let loaded = load_volume(Path::new(&self.scene), frame)?;
                for warning in &loaded.warnings {
                    ctx.warn(warning);
                }
                loaded.volume
            }
        };
        Ok(match self.up {
            None => volume.facing_viewer(),
            Some(Axis::Y) => volume,
            Some(Axis::Z) => {
                let turn = DAffine3::from_rotation_x(-std::f64::consts::FRAC_PI_2);
                volume.placed(turn)?
            }
        })
    }

    /// The camera that the flags ask for, or else `own`; if only moved, it looks at `middle`.
    pub(crate) fn eye(&self, own: Pose, middle: Option<[f64; 3]>) -> Result<Pose, Failure> {
        if self.camera.is_none() && self.look_at.is_none() {
            return Ok(own);
        }
        let position = self.camera.map_or(own.position, Into::into);
        let target = self.look_at.or(middle).unwrap_or_default();
        look_at(position, target.into()).ok_or_else(|| {
            let at = position.to_array();
            Failure::bad_input(format!(
                "--camera {at:?} is where --look-at is: must be elsewhere"
            ))
        })
    }
}

/// A scene in frames `period_s` apart, the last of them at `seconds`: one for all if nothing moves.
fn in_frames(
    scene: &Scene,
    seconds: f64,
    frames: u32,
    [period_s, scan_s]: [f64; 2],
) -> Result<Vec<Scene>, Failure> {
    if scene.motions().is_empty() {
        return Ok(vec![scene.at(seconds)]);
    }
    let instances = scene.instances().len().max(1);
    let most = (MOST_PLACEMENTS / instances).max(1);
    if frames as usize > most {
        return Err(Failure::bad_input(format!(
            "--frames {frames}: at most {most} of a scene that moves and has {instances} instances"
        )));
    }
    let at = |before: u32| {
        let start = (seconds - f64::from(before) * period_s).max(0.0);
        match scan_s > 0.0 {
            true => scene.over([start, start + scan_s]),
            false => scene.at(start),
        }
    };
    Ok((0..frames).rev().map(at).collect())
}
