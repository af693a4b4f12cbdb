//! What `render` draws, and from where: the study scene or a file.

use std::path::{Path, PathBuf};

use foveasim_assets::{
    LoadOptions, STUDY_FRAMES, Scene, Up, framing, load_scene, look_at, study_camera, study_scene,
};
use foveasim_models::{Pose, Viewport, unknown_name};

use super::{Context, Failure, options};

/// Scene and camera.
#[derive(Debug, clap::Args)]
pub(crate) struct SceneArgs {
    /// What to draw: study (the scene of Guenter et al. 2012), or an OBJ, glTF, GLB, PLY or STL file
    #[arg(long, value_name = "NAME|FILE", default_value = "study")]
    scene: String,
    /// Frame of the study scene's fly-through, 0 to 5376 [default: 500]
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u32).range(..i64::from(STUDY_FRAMES)),
        conflicts_with = "camera"
    )]
    frame: Option<u32>,
    /// Where the eye is, in metres [default: so that it sees the whole file]
    #[arg(long, value_name = "X,Y,Z", value_parser = options::triple, allow_hyphen_values = true)]
    camera: Option<[f64; 3]>,
    /// What is in the middle of its view, in metres [default: the middle of the file]
    #[arg(long, value_name = "X,Y,Z", value_parser = options::triple, allow_hyphen_values = true)]
    look_at: Option<[f64; 3]>,
    /// Time of the file's animation [s] [default: 0]
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

/// A scene as seen at one moment.
pub(crate) struct Stage {
    pub(crate) scene: Scene,
    pub(crate) world_from_eye: Pose,
    /// Nothing nearer than this is drawn \[m\].
    pub(crate) near_m: f64,
}

/// The study scene's near plane \[m\].
const STUDY_NEAR_M: f64 = 0.05;
/// The near plane of a file of unknown size, as a share of that size, but no farther.
const NEAR_SHARE: f64 = 0.005;

impl SceneArgs {
    /// Builds or loads the scene; `optics` are what its camera must fit it into.
    pub(crate) fn stage(&self, optics: &Viewport, ctx: &Context) -> Result<Stage, Failure> {
        if self.scene == "study" {
            return self.study(ctx);
        }
        let path = Path::new(&self.scene);
        // A name without an extension that is no file was meant as a scene's.
        if !path.exists() && path.extension().is_none() {
            return Err(unknown_name("scene", &self.scene, &["study"]).into());
        }
        self.file(path, optics, ctx)
    }

    fn study(&self, ctx: &Context) -> Result<Stage, Failure> {
        let of_files = [
            ("--time", self.time.is_some()),
            ("--texture", self.texture.is_some()),
            ("--up", self.up.is_some()),
        ];
        if let Some((flag, _)) = of_files.iter().find(|(_, given)| *given) {
            let text = format!("{flag}: only with a file (--scene FILE)");
            return Err(Failure::bad_input(text));
        }
        if self.camera.is_some() && self.look_at.is_none() {
            let text = "--camera: needs --look-at X,Y,Z in the study scene";
            return Err(Failure::bad_input(text));
        }
        let frame = f64::from(self.frame.unwrap_or(500));
        let flight = study_camera(frame / f64::from(STUDY_FRAMES), ctx.seed);
        Ok(Stage {
            scene: study_scene(ctx.seed),
            world_from_eye: self.eye(flight, None)?,
            near_m: STUDY_NEAR_M,
        })
    }

    fn file(&self, path: &Path, optics: &Viewport, ctx: &Context) -> Result<Stage, Failure> {
        if self.frame.is_some() {
            return Err(Failure::bad_input("--frame: only with --scene study"));
        }
        let seconds = self.time.unwrap_or(0.0);
        if !(0.0..=1e6).contains(&seconds) {
            let text = format!("--time {seconds}: must be from 0 to 1000000 seconds");
            return Err(Failure::bad_input(text));
        }
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
        let scene = loaded.scene.at(seconds);
        let bounds = scene.bounds().unwrap_or_default();
        let middle = (bounds[0] + bounds[1]) / 2.0;
        let size = (bounds[1] - bounds[0]).length();
        Ok(Stage {
            scene,
            world_from_eye: self.eye(framing(bounds, optics), Some(middle.to_array()))?,
            near_m: (NEAR_SHARE * size).clamp(1e-4, STUDY_NEAR_M),
        })
    }

    /// The camera that the flags ask for, or else `own`; if only moved, it looks at `middle`.
    fn eye(&self, own: Pose, middle: Option<[f64; 3]>) -> Result<Pose, Failure> {
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
