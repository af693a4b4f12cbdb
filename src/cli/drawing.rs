//! How `render` draws: what the renderer is told, and what frames take from those before them.

use foveasim_assets::{Detail, LodRule, STUDY_FRAMES};
use foveasim_models::Msaa;
use foveasim_render::{Lighting, RenderOptions, Simd, Skip, TemporalOptions};
use foveasim_study::Drawing;

use super::Failure;

/// Drawing flags.
#[derive(Debug, clap::Args)]
pub(crate) struct DrawingArgs {
    /// Positions of visibility in each sample: 1, or 4 for multisample antialiasing
    #[arg(long, value_name = "1|4", default_value = "1", value_parser = msaa)]
    msaa: Msaa,
    /// Which mesh is drawn of an object that has several
    #[arg(long, value_enum, default_value_t = Lod::Footprint)]
    lod: Lod,
    /// By how many samples a mesh chosen by footprint may be off its shape, 1/64 to 16
    #[arg(long, value_name = "SAMPLES", default_value_t = Detail::ERROR_SAMPLES, value_parser = lod_error)]
    lod_error: f64,
    /// Work to leave out because the picture does not need it: all, none, or some of back-faces,
    /// outside, occluded, hidden, repeated-vertices, whole-samples, repeated-for-eyes, with commas
    #[arg(long, value_name = "LIST", default_value = "all", value_parser = str::parse::<Skip>)]
    skip: Skip,
    /// Samples along each side of a pixel of the reference, 1 to 16; above 1, the reference shows what
    /// antialiasing aims at
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        value_parser = clap::value_parser!(u32).range(1..=16)
    )]
    supersample: u32,
    /// Consecutive frames to draw, the last of them being --frame (or --time, one refresh apart)
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        value_parser = clap::value_parser!(u32).range(1..=i64::from(STUDY_FRAMES))
    )]
    pub(crate) frames: u32,
    /// What a frame takes from those before it [default: all, with --frames 2 or more]
    #[arg(long, value_enum)]
    temporal: Option<Temporal>,
    /// Draw outer layers in turns, as their cadence says (with --frames 2 or more)
    #[arg(long)]
    staggered: bool,
    /// Write every frame, frame-0001.png and so on (with --frames 2 or more)
    #[arg(long)]
    pub(crate) all_frames: bool,
    /// Light beyond a sun and an even sky: all, none, or some of shadows[=TEXELS A SIDE], image (light of the
    /// sky from an image of it), occlusion[=RADIUS IN METRES], with commas
    #[arg(long, value_name = "LIST", default_value = "none", value_parser = str::parse::<Lighting>)]
    shading: Lighting,
    /// Instructions to use; the pictures are the same
    #[arg(long, value_enum, default_value_t = SimdChoice::Auto)]
    simd: SimdChoice,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum SimdChoice {
    /// The widest that this machine has
    Auto,
    /// One lane at a time
    Scalar,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Lod {
    /// Always the finest
    Finest,
    /// By squared distance, as in Guenter et al. 2012
    Distance,
    /// By distance, and never finer than the samples can show
    Footprint,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Temporal {
    /// Nothing: each frame by itself
    Off,
    /// Samples move within their cells
    Jitter,
    /// Samples are blended with what was seen before
    Reproject,
    /// Both
    All,
}

fn msaa(text: &str) -> Result<Msaa, String> {
    match text {
        "1" => Ok(Msaa::One),
        "4" => Ok(Msaa::Four),
        _ => Err("want 1 or 4".into()),
    }
}

fn lod_error(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|samples| (0.015625..=16.0).contains(samples))
        .ok_or_else(|| "want samples from 1/64 (0.015625) to 16".into())
}

/// Most pictures of one run: each is kept until all are written.
const MOST_PICTURES: u32 = 600;

impl DrawingArgs {
    /// How to draw, with nothing nearer than `near_m` \[m\].
    pub(crate) fn drawing(&self, near_m: f64) -> Drawing {
        Drawing {
            options: RenderOptions {
                simd: match self.simd {
                    SimdChoice::Auto => Simd::Auto,
                    SimdChoice::Scalar => Simd::Scalar,
                },
                near_m,
                lod: match self.lod {
                    Lod::Finest => LodRule::Finest,
                    Lod::Distance => LodRule::Distance,
                    Lod::Footprint => LodRule::Footprint,
                },
                lod_error: self.lod_error,
                skip: self.skip,
                lighting: self.shading,
                ..RenderOptions::default()
            },
            msaa: self.msaa,
            temporal: self.temporal(),
            reference_samples: self.supersample,
            lens: None,
        }
    }

    fn temporal(&self) -> TemporalOptions {
        let default = if self.frames > 1 {
            Temporal::All
        } else {
            Temporal::Off
        };
        let parts = self.temporal.unwrap_or(default);
        let jitter = matches!(parts, Temporal::Jitter | Temporal::All);
        let reproject = matches!(parts, Temporal::Reproject | Temporal::All);
        TemporalOptions {
            jitter,
            reproject,
            staggered: self.staggered,
            ..TemporalOptions::default()
        }
    }

    /// Instructions, and whether what is empty is left out, for a volume; refuses flags that say nothing
    /// about one.
    pub(crate) fn of_volume(&self) -> Result<(Simd, bool), Failure> {
        let of_meshes = [
            ("--msaa", self.msaa != Msaa::One),
            ("--lod", self.lod != Lod::Footprint),
            (
                "--lod-error",
                self.lod_error.to_bits() != Detail::ERROR_SAMPLES.to_bits(),
            ),
            ("--supersample", self.supersample != 1),
            ("--frames", self.frames != 1),
            ("--temporal", self.temporal.is_some()),
            ("--staggered", self.staggered),
            ("--all-frames", self.all_frames),
            ("--shading", self.shading != Lighting::default()),
        ];
        if let Some((flag, _)) = of_meshes.iter().find(|(_, given)| *given) {
            return Err(Failure::bad_input(format!("{flag}: not with a volume")));
        }
        let skip_empty = match self.skip {
            Skip::ALL => true,
            Skip::NONE => false,
            _ => {
                let text = "--skip: must be all or none with a volume";
                return Err(Failure::bad_input(text));
            }
        };
        let simd = match self.simd {
            SimdChoice::Auto => Simd::Auto,
            SimdChoice::Scalar => Simd::Scalar,
        };
        Ok((simd, skip_empty))
    }

    /// Refuses flags that would do nothing.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        let refuse = |text: String| Err(Failure::bad_input(text));
        let of_many = [
            (
                "--temporal",
                self.temporal.is_some_and(|t| t != Temporal::Off),
            ),
            ("--staggered", self.staggered),
            ("--all-frames", self.all_frames),
        ];
        if let Some((flag, _)) = of_many.iter().find(|(_, given)| *given && self.frames == 1) {
            return refuse(format!("{flag}: needs --frames N with 2 or more frames"));
        }
        if self.all_frames && self.frames > MOST_PICTURES {
            let frames = self.frames;
            return refuse(format!(
                "--frames {frames} with --all-frames: at most {MOST_PICTURES} pictures are written at once"
            ));
        }
        Ok(())
    }
}
