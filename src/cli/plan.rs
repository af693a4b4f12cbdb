mod kernel;
mod log;
mod resolution;
mod run;
mod verify;

use std::sync::Arc;

use anyhow::{Context as _, anyhow, bail};
use foveasim_models::foveation::{Method, Screen};
use foveasim_models::math::to_deg;
use foveasim_models::{Acuity, GazeMode, Rate};
use foveasim_reports::{Heatmap, Table};
use foveasim_study::{
    Buffers, GazeAt, Link, MapRatio, Resolution, Sweep, SweepDisplay, SweepRow, Terms,
    parse_numbers,
};

use super::{Context, Failure, options};

/// Savings across displays or fields of view, resolutions, methods, acuity and tracking error.
///
/// One row per combination. Without a display, a grid of flat displays is planned: fields of view
/// against sharpness. Lists are separated by commas; numbers may be ranges FROM..TO:STEP, both ends
/// included.
#[derive(Debug, clap::Args)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "Examples:
  foveasim plan
  foveasim plan --display lg-w2363d --slope 0.0275 --method layers:3 --format csv
  foveasim plan --fov 10..130:5 --sharpness foveal --aspect 0.75 --method layers:4 --format csv
  foveasim plan --display quest-pro,quest-3 --method full,layers:3:strict --margin-deg 0..5:1
  foveasim plan --fov 90 --ppd centre:40,mean:40 --slope guenter-a,guenter-b,j:22
  foveasim plan --fov 90 --pixels 3840x2160 --gaze 0,1080 --gaze-mode fixed
  foveasim plan --display quest-pro --method full,layers:3,vrs,fdm,rates,quad,quad:auto
  foveasim plan --display quest-pro --method vrs,vrs:fixed,vrs:fixed=25
  foveasim plan --fov 80..120:10 --ppd centre:20,centre:40 --refresh 72,90,120 --eyes 2
  foveasim plan --fov 100 --ppd centre:25 --refresh 90 --solve gpu --target 90hz
  foveasim plan --fov 100 --ppd centre:25 --method layers:3 --solve accuracy --target 5x
  foveasim plan --display quest-pro --method layers:3,vrs --spread
  foveasim plan --fov 10..130:1 --shard 3/16 --out part3
  foveasim plan --fov 40,80,120 --pixels 640x360,1280x720,1920x1080 --method full,layers:2,layers:3,vrs,fdm --verify 60 \
      --scene study,room,machine --out evidence
  foveasim plan merge part1 part2 part3 --out all
  foveasim plan --display quest-pro --method kfr:2:4,kfr:2:1,kfr:2:0.25,efr:2:3,lms:1:1

Methods, settings in brackets:
  full
  layers:N  eccentricity layers, N from 1 to 16 [strict or blending=paper; paper or coverage=exact;
            weights=half; s2=VALUE], as in layers:3:strict:s2=2
  vrs       variable-rate shading: visibility of every pixel [tile=8|16|32; max=1|2|4]
  fdm       fragment density map: visibility is coarse as well [tile=8|16|32; max=1|2|4]
  rates     a rate for each band of columns and of rows [bands=N, 1 to 256]
  quad      a sharp rectangle on a coarser whole [focus=SHARE or auto; peripheral=SCALE]
  kfr:SIGMA:ALPHA        kernel foveated rendering: W/SIGMA x H/SIGMA samples on a log-polar map with
            kernel exponent ALPHA (the paper: 4) [published: visibility at full resolution, else direct;
            filter=nearest; smooth; mips], as in kfr:2:4:published
  efr:SIGMA_D:SIGMA_ND   the same, coarser for the eye that is not dominant [dominant=left|right;
            alpha=ALPHA; those of kfr], as in efr:2:3:dominant=left
  lms:A:B   lens-matched shading: four quadrants with w' = w + A|x| + B|y|, as in lms:0.5:0.5
  radial:K  a buffer that magnifies the fovea, d_display = R*(d_buffer/R)^K, K from 1 to 16 [scale=S lattice
            steps per buffer pixel; R is reach=corner|boundary; filter=nearest], as in radial:2:scale=0.6
All but full may be fixed or fixed=DEG: straight ahead whatever the gaze, and as sharp as the eye
wherever that looks within so many degrees (15). layers:N without strict and quad without auto do not
promise to meet the acuity line everywhere. kfr, efr, lms and radial put their samples where their settings
say: `foveasim plan kernel` finds the ones that meet it.

Columns: method_samples is the closed form and may be a fraction; plan_samples is the whole number
that is drawn. sample_ratio counts every layer, sample_ratio_staggered those drawn in every second
frame half. shading_ratio counts evaluations of shading, which vrs has fewer of than samples.
ideal_ratio is a density that falls off continuously: no method with the same acuity and margin
saves more. tracked_over_fixed: how many times more samples the method shades if fixed (fixed=15
unless it says) than if tracked, of the same quality; empty for kfr, efr, lms and radial. extrapolated: the screen reaches farther from
the gaze than slopes were measured. frame_ms is the time that the cost profile predicts, each layer at
its own cadence, frame_all_ms with every layer; fits_refresh compares both with the refresh;
beyond_fit names the work that is beyond what the profile rests on. framebuffer_mb is of all layers and
of the image put together from them. link_gbps carries layers as often as they are drawn. energy_mj and
power_w are empty where the cost profile has no [energy].
--solve latency: the eye goes on at --eye-speed while the picture is late, and the margin must cover
that besides --margin-deg. --spread: percentiles over viewers (a normal law of 15 subjects' quality
index), the tracker's error, the cost profile's error where it states one, and all of them.
Where a display has two eyes, samples are those of both, pixels and layers those of one."
)]
pub(crate) struct Args {
    #[command(subcommand)]
    find: Option<Find>,
    /// Presets or TOML files [default: a grid of flat displays]
    #[arg(long, value_name = "NAMES")]
    display: Option<String>,
    /// Horizontal fields of view of flat displays in degrees [default: 30..130:20]
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    fov: Option<String>,
    /// Pixels per degree, and where: centre:40, mean:40 or min:40
    #[arg(long, value_name = "WHERE:PPD")]
    ppd: Option<String>,
    /// Pixels of flat displays, as in 3840x2160
    #[arg(long, value_name = "WxH")]
    pixels: Option<String>,
    /// Sharpness at the centre: foveal, or a fraction of it [default: 0.25,0.5,foveal]
    #[arg(long, value_name = "FRACTION", allow_hyphen_values = true)]
    sharpness: Option<String>,
    /// Height over width of flat displays [default: 0.5625]
    #[arg(long, value_name = "RATIO", allow_hyphen_values = true)]
    aspect: Option<f64>,
    /// Acuity slopes: guenter-a, guenter-b, a quality index j:12, or numbers
    #[arg(
        long,
        value_name = "SLOPES",
        default_value = "guenter-a",
        allow_hyphen_values = true
    )]
    slope: String,
    /// Methods
    #[arg(
        long,
        value_name = "METHODS",
        default_value = "layers:2,layers:3,layers:4"
    )]
    method: String,
    /// Where the eye looks: centre, or pixels from the top left of the (first eye's) image
    #[arg(
        long,
        value_name = "X,Y",
        default_value = "centre",
        allow_hyphen_values = true
    )]
    gaze: String,
    /// Whether tracked methods follow the gaze: tracked, or fixed at the centre as they are
    #[arg(long, value_name = "MODE", default_value = "tracked")]
    gaze_mode: String,
    /// How far gaze may be off without being noticed, in degrees
    #[arg(
        long = "margin-deg",
        visible_alias = "margin",
        value_name = "DEGREES",
        default_value = "0",
        allow_hyphen_values = true
    )]
    margin: String,
    /// Refreshes a second of flat displays [default: none; displays have their own]
    #[arg(long, value_name = "HZ")]
    refresh: Option<String>,
    /// Images of flat displays: 1, 2 or 1,2
    #[arg(long, value_name = "N", default_value = "1")]
    eyes: String,
    /// Cost profile: name or TOML file, as `foveasim calibrate` writes it
    #[arg(
        long,
        visible_alias = "profile",
        value_name = "PROFILE",
        default_value = "guenter2012"
    )]
    cost: String,
    /// Framebuffer bytes of a sample and of a displayed pixel
    #[arg(long, value_name = "SAMPLE,PIXEL", default_value = "8,4")]
    bytes: String,
    /// Bits of a sample on the link to the display
    #[arg(long, value_name = "BITS", default_value_t = 24.0)]
    link_bits: f64,
    /// The part of the time in which samples are on the link
    #[arg(long, value_name = "FRACTION", default_value_t = 1.0)]
    link_active: f64,
    /// How many times the link compresses
    #[arg(long, value_name = "RATIO", default_value_t = 1.0)]
    compression: f64,
    /// Go on with the rows that an earlier run left in the folder
    #[arg(long, requires = "out")]
    resume: bool,
    /// Make one part of the rows, which `plan merge` puts together
    #[arg(long, value_name = "K/N", requires = "out")]
    shard: Option<String>,
    /// Find what just meets --target: latency, accuracy, ppd or gpu
    #[arg(long, value_name = "UNKNOWN", requires = "target", conflicts_with_all = ["resume", "shard", "spread"])]
    solve: Option<String>,
    /// What is to be met, with its unit: a speedup 5x, a frame time 11ms, a refresh rate 90hz, an energy
    /// 12mJ or a power 1.5W
    #[arg(long, value_name = "TARGET", requires = "solve")]
    target: Option<String>,
    /// How fast the eye goes on while the picture is late [deg/s], for --solve latency
    #[arg(long, value_name = "SPEED", default_value_t = 30.0)]
    eye_speed: f64,
    /// How savings spread over viewers, the tracker's error and the cost profile's
    #[arg(long, conflicts_with_all = ["resume", "shard"])]
    spread: bool,
    /// Standard deviation of the tracker's error along one axis [deg], for --spread
    #[arg(long, value_name = "DEG", default_value_t = 0.5)]
    tracker_sd_deg: f64,
    #[command(flatten)]
    verify: verify::VerifyArgs,
    /// Draws of --spread for each row
    #[arg(long, value_name = "N", default_value_t = 99)]
    draws: u32,
}

/// What is found instead of counted.
#[derive(Debug, clap::Subcommand)]
enum Find {
    Kernel(kernel::Args),
    Merge(run::MergeArgs),
}

/// The most rows of one run.
const MOST_ROWS: usize = 1_000_000;
const DEFAULT_FOV: &str = "30..130:20";
const DEFAULT_SHARPNESS: &str = "0.25,0.5,foveal";
/// 16:9.
const DEFAULT_ASPECT: f64 = 0.5625;

/// What people read on a terminal; CSV and JSON have all columns.
const READABLE: [&str; 17] = [
    "method",
    "display",
    "fov_h_deg",
    "width_px",
    "height_px",
    "ppd_centre",
    "slope",
    "margin_deg",
    "sample_ratio",
    "sample_ratio_staggered",
    "shading_ratio",
    "ideal_ratio",
    "tracked_over_fixed",
    "frame_ms",
    "fits_refresh",
    "layer_radii_deg",
    "extrapolated",
];

pub(crate) fn run(args: &Args, ctx: &Context) -> Result<(), Failure> {
    match &args.find {
        Some(Find::Kernel(args)) => kernel::run(args, ctx),
        Some(Find::Merge(args)) => run::merge(args, ctx),
        None if args.solve.is_some() => run::solve(args, ctx),
        None if args.spread => run::spread(args, ctx),
        None if args.verify.is_asked() => verify::run(args, ctx),
        None => run::sweep(args, ctx),
    }
}

/// Some of a table's columns.
fn pick(table: &Table, columns: &[&str]) -> Table {
    let places: Vec<usize> = columns
        .iter()
        .filter_map(|name| table.columns().iter().position(|c| c == name))
        .collect();
    let mut picked = Table::new(places.iter().map(|&i| table.columns()[i].as_str()));
    for row in table.rows() {
        picked.push(places.iter().map(|&i| row[i].clone()).collect());
    }
    picked
}

/// The most cells of a picture: more cannot be told apart.
const MOST_CELLS: usize = 10_000;

impl Args {
    /// A savings map for each method, where the rows are a grid of fields of view and resolutions.
    fn heatmaps(&self, sweep: &Sweep, rows: &[SweepRow]) -> anyhow::Result<Vec<(String, Heatmap)>> {
        let methods = sweep.methods.len();
        let cells = sweep.displays.len();
        let same = |d: &SweepDisplay| (d.refresh, d.eyes.len());
        let differ = sweep
            .displays
            .iter()
            .any(|d| same(d) != same(&sweep.displays[0]));
        let grid = self.display.is_none() && rows.len() == cells * methods && !differ;
        if !grid || cells > MOST_CELLS {
            return Ok(Vec::new());
        }
        let fovs = list("--fov", self.fov.as_deref().unwrap_or(DEFAULT_FOV))?;
        let heights = cells / fovs.len();
        // Rows run through fields of view, then resolutions, then methods.
        let row = |fov: usize, height: usize, method: usize| {
            &rows[(fov * heights + height) * methods + method]
        };
        let density = |row: &SweepRow| 1.0 / to_deg(row.display.eyes[0].screen.pixel_tan().x);
        let (label, of): (_, fn(&SweepRow) -> f64) = match &self.pixels {
            Some(_) => ("width [px]", |row| row.display.eyes[0].screen.size_px().x),
            None => ("pixels per degree at the centre", density),
        };
        let map = |method: usize| {
            let order = (0..heights).flat_map(|h| (0..fovs.len()).map(move |f| (f, h)));
            let name = sweep.methods[method].to_string();
            let y = (0..heights)
                .map(|h| (of(row(0, h, 0)) * 10.0).round() / 10.0)
                .collect();
            let map = SweepRow::heatmap(
                order.map(|(f, h)| row(f, h, method)),
                MapRatio::Shading,
                format!("Times fewer shaded samples with {name}"),
                fovs.clone(),
                (label, y),
            );
            (format!("plan-{}.svg", name.replace([':', '='], "-")), map)
        };
        Ok((0..methods).map(map).collect())
    }

    fn sweep(&self) -> Result<Sweep, Failure> {
        let slopes = self.slope.split(',').map(|s| Acuity::parse(s.trim()));
        let margins = list("--margin-deg", &self.margin)?;
        if let Some(bad) = margins.iter().find(|m| !(0.0..=90.0).contains(*m)) {
            return Err(anyhow!("--margin-deg {bad}: must be from 0 to 90 degrees").into());
        }
        let mut sweep = Sweep {
            displays: Vec::new(),
            acuities: slopes.collect::<Result<_, _>>().context("--slope")?,
            gazes: vec![self.gaze()?],
            gaze_mode: self.gaze_mode.parse::<GazeMode>().context("--gaze-mode")?,
            margins_deg: margins,
            methods: Method::parse_list(&self.method).context("--method")?,
            terms: Arc::new(self.terms()?),
        };
        let others = sweep.acuities.len() * sweep.margins_deg.len();
        let others = others.saturating_mul(sweep.methods.len());
        sweep.displays = match &self.display {
            Some(names) => self.presets(names)?,
            None => self.grid(others)?,
        };
        check_rows(sweep.len())?;
        Ok(sweep)
    }

    fn terms(&self) -> anyhow::Result<Terms> {
        let [sample_bytes, pixel_bytes] =
            options::pair(&self.bytes).map_err(|e| anyhow!("--bytes {}: {e}", self.bytes))?;
        let terms = Terms {
            cost: foveasim_study::cost(&self.cost).context("--cost")?,
            buffers: Buffers {
                sample_bytes,
                pixel_bytes,
            },
            link: Link {
                bits_per_pixel: self.link_bits,
                active_fraction: self.link_active,
                compression: self.compression,
            },
        };
        terms.check()?;
        Ok(terms)
    }

    /// How often a flat display is refreshed, and how many images it has: every combination.
    fn variants(&self) -> anyhow::Result<Vec<(Option<Rate>, bool)>> {
        let refreshes: Vec<Option<Rate>> = match &self.refresh {
            None => vec![None],
            Some(text) => list("--refresh", text)?
                .into_iter()
                .map(|hz| Ok(Some(Rate::from_hz("--refresh", hz)?)))
                .collect::<anyhow::Result<_>>()?,
        };
        let eyes = self.eyes.split(',').map(|text| match text.trim() {
            "1" => Ok(false),
            "2" => Ok(true),
            other => Err(anyhow!("--eyes {other}: want 1, 2 or 1,2")),
        });
        let eyes: Vec<bool> = eyes.collect::<anyhow::Result<_>>()?;
        let each = |refresh| eyes.iter().map(move |both| (refresh, *both));
        Ok(refreshes.into_iter().flat_map(each).collect())
    }

    fn gaze(&self) -> anyhow::Result<GazeAt> {
        gaze(&self.gaze, "centre")
    }

    fn presets(&self, names: &str) -> Result<Vec<SweepDisplay>, Failure> {
        let planar = [
            ("--fov", self.fov.is_some()),
            ("--ppd", self.ppd.is_some()),
            ("--pixels", self.pixels.is_some()),
            ("--sharpness", self.sharpness.is_some()),
            ("--aspect", self.aspect.is_some()),
            ("--refresh", self.refresh.is_some()),
            ("--eyes", self.eyes != "1"),
        ];
        if let Some((flag, _)) = planar.iter().find(|(_, given)| *given) {
            let text = format!("--display and {flag}: a display has its own; give one of them");
            return Err(Failure::bad_input(text));
        }
        let display = |name: &str| Ok(SweepDisplay::from(&options::display(name.trim())?));
        names.split(',').map(display).collect()
    }

    /// Flat displays, every field of view at every resolution; each becomes `rows` rows.
    fn grid(&self, rows: usize) -> Result<Vec<SweepDisplay>, Failure> {
        let fovs = list("--fov", self.fov.as_deref().unwrap_or(DEFAULT_FOV))?;
        for &fov in &fovs {
            Screen::half_width_tan(fov).context("--fov")?;
        }
        let resolutions = self.resolutions(fovs[0])?;
        let variants = self.variants()?;
        check_rows(
            fovs.len()
                .saturating_mul(resolutions.len())
                .saturating_mul(variants.len())
                .saturating_mul(rows),
        )?;
        let aspect = self.aspect.unwrap_or(DEFAULT_ASPECT);
        if !(1e-3..=1e3).contains(&aspect) {
            return Err(anyhow!("--aspect {aspect}: must be from 0.001 to 1000").into());
        }
        let mut displays = Vec::with_capacity(fovs.len() * resolutions.len());
        for &fov in &fovs {
            for resolution in &resolutions {
                let at = || format!("display of {fov} degrees");
                let display = resolution.display(fov, aspect).with_context(at)?;
                displays.extend(variants.iter().map(|(refresh, both)| {
                    let mut display = display.clone();
                    if *both {
                        display = display.for_both_eyes();
                    }
                    match refresh {
                        Some(rate) => display.at(*rate),
                        None => display,
                    }
                }));
            }
        }
        Ok(displays)
    }

    fn resolutions(&self, fov: f64) -> anyhow::Result<Vec<Resolution>> {
        match (&self.ppd, &self.pixels, &self.sharpness) {
            (Some(ppd), None, None) => ppd
                .split(',')
                .map(|p| resolution::per_degree(p.trim(), fov))
                .collect(),
            (None, Some(sizes), None) => {
                if self.aspect.is_some() {
                    bail!("--pixels and --aspect: pixels are square, so WxH says the aspect");
                }
                let size = |text: &str| options::size(text.trim()).map(Resolution::Pixels);
                let sizes = sizes
                    .split(',')
                    .map(|t| size(t).map_err(|e| anyhow!("--pixels {t}: {e}")));
                sizes.collect()
            }
            (None, None, given) => {
                let texts = given.as_deref().unwrap_or(DEFAULT_SHARPNESS);
                texts
                    .split(',')
                    .map(|t| resolution::sharpness(t.trim()))
                    .collect()
            }
            _ => bail!("--ppd, --pixels and --sharpness all say how many pixels; give one of them"),
        }
    }
}

/// `centre`, or pixels; `names` says which words are valid.
fn gaze(text: &str, names: &str) -> anyhow::Result<GazeAt> {
    // Beyond this the direction is the same to the last bit of interest.
    const FARTHEST_PX: f64 = 1e7;
    if text == "centre" {
        return Ok(GazeAt::Centre);
    }
    match options::pair(text) {
        Ok(px) if px.iter().all(|v| v.abs() <= FARTHEST_PX) => Ok(GazeAt::Pixel(px)),
        _ => bail!(
            "--gaze {text}: want {names}, or two numbers X,Y within {FARTHEST_PX} pixels, as in 960,540"
        ),
    }
}

fn list(flag: &str, text: &str) -> anyhow::Result<Vec<f64>> {
    parse_numbers(text).map_err(|e| anyhow!("{flag}: {e}"))
}

fn check_rows(rows: usize) -> anyhow::Result<()> {
    if rows > MOST_ROWS {
        bail!("this would be {rows} rows; at most {MOST_ROWS}: use larger steps");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Cli {
        #[command(flatten)]
        _global: super::super::Global,
        #[command(flatten)]
        args: Args,
    }

    fn sweep(line: &str) -> Result<Sweep, Failure> {
        let words = std::iter::once("plan").chain(line.split_whitespace());
        Cli::try_parse_from(words).unwrap().args.sweep()
    }

    #[test]
    fn lists_multiply() {
        for (line, rows) in [
            ("", 6 * 3 * 3),
            ("--display lg-w2363d --slope 0.0275 --method layers:3", 1),
            (
                "--fov 10..130:5 --sharpness foveal --aspect 0.75 --method layers:4",
                25,
            ),
            (
                "--fov 90 --ppd centre:40,mean:40,min:40 --slope guenter-a,j:22 --method full",
                6,
            ),
            (
                "--fov 90 --pixels 3840x2160 --margin-deg 0..5:1 --gaze -10,2000",
                6 * 3,
            ),
            (
                "--display quest-pro,dk2 --gaze-mode fixed --method full,layers:3:strict",
                4,
            ),
        ] {
            assert_eq!(sweep(line).unwrap().len(), rows, "{line}");
        }
    }

    #[test]
    fn bad_flags_are_one_clear_line() {
        for (line, expect) in [
            (
                "--fov 120 --ppd 40",
                "7939 pixels if meant at the centre, 4800 if meant on average",
            ),
            ("--fov 180", "--fov: field of view [deg] = 180"),
            ("--fov 0", "above 0 and below 180"),
            ("--fov -5", "above 0 and below 180"),
            ("--fov 130..10:5", "runs backwards"),
            ("--fov 10..130:0", "above 0"),
            ("--fov 1..179:1 --margin 0..89:0.01", "at most 1000000"),
            ("--slope nan", "--slope"),
            ("--aspect nan", "--aspect NaN"),
            ("--display quest-por", "did you mean `quest-pro`?"),
            ("--display dk2 --fov 10", "--display and --fov"),
            ("--pixels 0x5", "--pixels 0x5"),
            ("--pixels 1920x1080 --aspect 1", "--pixels and --aspect"),
            ("--sharpness 0", "--sharpness 0"),
            ("--ppd mean:nan", "--ppd nan"),
            ("--ppd mid:40", "valid: centre, mean, min"),
            ("--ppd mean:40 --sharpness 1", "give one of them"),
            ("--ppd mean:99999", "65536"),
            ("--margin -1", "--margin-deg -1"),
            ("--gaze 1e300,0", "--gaze 1e300,0"),
            ("--gaze-mode fixd", "did you mean `fixed`?"),
            ("--method layer:3", "did you mean `layers`?"),
        ] {
            let Err(Failure::BadInput(error)) = sweep(line) else {
                panic!("{line} is accepted")
            };
            let text = format!("{error:#}");
            assert!(
                text.contains(expect) && !text.contains('\n'),
                "{line}: {text}"
            );
        }
    }
}
