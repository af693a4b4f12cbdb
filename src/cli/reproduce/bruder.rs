use std::path::{Path, PathBuf};

use anyhow::{Context as _, anyhow};
use foveasim_assets::{TransferFunction, load_volume, volume_named};
use foveasim_mask::{Interpolation, MaskSpec};
use foveasim_models::{Acuity, RayDensity, unknown_name};
use foveasim_study::{
    Bruder2019, Bruder2019Outcome, BruderMasks, BruderVolume, Clock, Paper, Progress,
};

use super::super::{Context, Failure, mask};

/// What is measured of Bruder 2019.
#[derive(Debug, clap::Args)]
pub(super) struct BruderArgs {
    /// bruder2019: cameras around each volume; the paper has 256 [default: 6]
    #[arg(long, value_name = "N", conflicts_with = "quick")]
    cameras: Option<u32>,
    /// bruder2019: gazes for each camera; the paper has 256 [default: 4]
    #[arg(long, value_name = "N", conflicts_with = "quick")]
    gazes: Option<u32>,
    /// bruder2019: volume to measure, a generated one (jet:256) or a file; may be repeated [default: all generated ones]
    #[arg(long, value_name = "NAME[:SIZE]|FILE", conflicts_with = "quick")]
    volume: Vec<String>,
    /// bruder2019: transfer function for all volumes (TOML) [default: of each one's histogram]
    #[arg(long, value_name = "FILE", requires = "volume")]
    transfer: Option<PathBuf>,
    /// bruder2019: density of rays, mar or gaussian [default: mar]
    #[arg(long, value_name = "KIND")]
    density: Option<String>,
    /// bruder2019: integral of that density over pixels of the image; masks have some 6 % more rays [default: 0.07]
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    fraction: Option<f64>,
    /// bruder2019: folder in which masks are kept
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
}

impl BruderArgs {
    /// What `reproduce all` can wait for: of every volume two views, looked at once.
    pub(super) const AFFORDABLE: Self = Self {
        cameras: Some(2),
        gazes: Some(1),
        volume: Vec::new(),
        transfer: None,
        density: None,
        fraction: None,
        cache: None,
    };

    /// Whether any of these flags is.
    pub(super) fn is_given(&self) -> bool {
        self.cameras.is_some()
            || self.gazes.is_some()
            || !self.volume.is_empty()
            || self.density.is_some()
            || self.fraction.is_some()
            || self.cache.is_some()
    }

    /// Refuses these flags for another paper.
    pub(super) fn refuse(&self, paper: Paper) -> Result<(), Failure> {
        if self.is_given() {
            let text = format!(
                "{paper} has no volumes: --cameras, --gazes, --volume, --transfer, --density, --fraction and --cache are \
                 for bruder2019"
            );
            return Err(Failure::bad_input(text));
        }
        Ok(())
    }

    /// Measures everything. `frames`, `size` and `quick` are the flags of that name.
    pub(super) fn run(
        &self,
        (frames, size, quick): (Option<u32>, Option<[u32; 2]>, bool),
        ctx: &Context,
        clock: &mut Clock<'_>,
        progress: &Progress<'_>,
    ) -> Result<Bruder2019Outcome, Failure> {
        let usual = match quick {
            true => Bruder2019::quick(),
            false => Bruder2019::default(),
        };
        let asked = Bruder2019 {
            cameras: self.cameras.unwrap_or(usual.cameras),
            gazes: self.gazes.unwrap_or(usual.gazes),
            frames: frames.unwrap_or(usual.frames),
            seed: ctx.seed,
            ..usual
        };
        let size = size.unwrap_or([if quick { 96 } else { 1024 }; 2]);
        let volumes = self.volumes(quick, ctx.seed)?;
        progress("masks", 0.0);
        let masks = self.masks(size, ctx)?;
        Ok(asked.run(&volumes, &masks, clock, progress)?)
    }

    fn volumes(&self, quick: bool, seed: u64) -> Result<Vec<BruderVolume>, Failure> {
        const ALL: [&str; 6] = [
            "jet",
            "filaments",
            "vortices",
            "porous",
            "shells",
            "marschner-lobb",
        ];
        let names: Vec<String> = match (quick, self.volume.is_empty()) {
            (true, _) => vec!["jet:32".into(), "shells:32".into()],
            (_, true) => ALL.map(String::from).into(),
            _ => self.volume.clone(),
        };
        let transfer = match &self.transfer {
            None => None,
            Some(path) => {
                let origin = path.display().to_string();
                let text = std::fs::read_to_string(path).with_context(|| origin.clone())?;
                Some(TransferFunction::from_toml(&origin, &text)?)
            }
        };
        let one = |name: String| {
            let path = Path::new(&name);
            let (volume, label) = if path.exists() {
                let label = path.file_name().map(|n| n.to_string_lossy().into_owned());
                (load_volume(path, 0)?.volume, label.unwrap_or(name.clone()))
            } else if path.extension().is_some() {
                return Err(anyhow!("{name}: there is no such file").into());
            } else {
                (volume_named(&name, seed)?, name.clone())
            };
            let transfer = transfer.clone();
            Ok(BruderVolume {
                name: label,
                transfer: transfer.unwrap_or_else(|| TransferFunction::of_volume(&volume)),
                volume,
            })
        };
        names.into_iter().map(one).collect()
    }

    fn masks(&self, size: [u32; 2], ctx: &Context) -> Result<BruderMasks, Failure> {
        let fraction = self.fraction.unwrap_or(0.07);
        let gaussian = RayDensity::gaussian_of_fraction(fraction, size.map(f64::from).into())?;
        let density = match self.density.as_deref() {
            None | Some("mar") => {
                let viewport = Bruder2019::viewport(size.into())?;
                RayDensity::mar_of_fraction(fraction, Acuity::default(), &viewport)?.0
            }
            Some("gaussian") => gaussian,
            Some(other) => return Err(unknown_name("density", other, &["gaussian", "mar"]).into()),
        };
        let build = |density: RayDensity, interpolation: Interpolation| {
            let spec = MaskSpec {
                interpolation,
                ..MaskSpec::new(size.into(), density, ctx.seed)
            };
            mask::get(self.cache.as_deref(), &spec, &|_| {}, ctx).map(|(mask, _)| mask)
        };
        let [nearest, barycentric, natural] = Interpolation::ALL;
        Ok(BruderMasks {
            masks: [
                build(density, nearest)?,
                build(density, barycentric)?,
                build(density, natural)?,
            ],
            gaussian: build(gaussian, natural)?,
        })
    }
}
