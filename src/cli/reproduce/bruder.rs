use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context as _, anyhow};
use foveasim_assets::{TransferFunction, load_volume, volume_named};
use foveasim_mask::{Interpolation, MaskSpec};
use foveasim_models::{Acuity, RayDensity, unknown_name};
use foveasim_study::{Bruder2019, Bruder2019Outcome, BruderMasks, BruderVolume};

use super::super::context::Format;
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
    /// Refuses these flags for another paper.
    pub(super) fn refuse(&self, paper: &str) -> Result<(), Failure> {
        let given = self.cameras.is_some()
            || self.gazes.is_some()
            || !self.volume.is_empty()
            || self.density.is_some()
            || self.fraction.is_some()
            || self.cache.is_some();
        if given {
            let text = format!(
                "{paper} has no volumes: --cameras, --gazes, --volume, --transfer, --density, --fraction and --cache are \
                 for bruder2019"
            );
            return Err(Failure::bad_input(text));
        }
        Ok(())
    }

    /// Measures and writes everything. `frames` and `size` are the flags of that name.
    pub(super) fn run(
        &self,
        frames: Option<u32>,
        size: Option<[u32; 2]>,
        quick: bool,
        ctx: &Context,
    ) -> Result<(), Failure> {
        let usual = if quick {
            Bruder2019::quick()
        } else {
            Bruder2019::default()
        };
        let asked = Bruder2019 {
            cameras: self.cameras.unwrap_or(usual.cameras),
            gazes: self.gazes.unwrap_or(usual.gazes),
            frames: frames.unwrap_or(usual.frames),
            seed: ctx.seed,
            ..usual
        };
        let size = size.unwrap_or([if quick { 96 } else { 1024 }; 2]);
        // An unwritable folder is found before the work, not after.
        let mut outputs = ctx.outputs("out")?;
        let volumes = self.volumes(quick, ctx.seed)?;
        let bar = ctx.progress(1000, "masks");
        let masks = self.masks(size, ctx)?;
        let began = Instant::now();
        let found = asked.run(&volumes, &masks, &mut || began.elapsed(), &|what, done| {
            bar.set_message(what.to_owned());
            bar.set_position((done * 1000.0) as u64);
        })?;
        bar.finish_and_clear();
        for (name, bytes) in found.files()? {
            outputs.add(name, bytes);
        }
        let report = outputs.path("report.html");
        outputs.commit()?;
        ctx.print_table(&found.table_1())?;
        if ctx.format == Format::Table {
            ctx.print("\n")?;
            ctx.print_table(&Bruder2019Outcome::printed())?;
            ctx.print(&format!("\nreport  {}\n", report.display()))?;
        }
        Ok(())
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
