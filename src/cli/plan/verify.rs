use std::path::Path;

use anyhow::Context as _;
use foveasim_assets::framing;
use foveasim_models::Viewport;
use foveasim_render::RenderOptions;
use foveasim_study::{Verify, VerifyOutcome, VerifyScene};

use super::super::clock::{OF_PROCESSORS, on_one_thread, processor_time};
use super::super::context::Format;
use super::super::scene::{SceneArgs, at_frame};
use super::super::{Context, Failure};
use super::{Args, pick};

/// Cells of the grid drawn by this project's renderer.
#[derive(Debug, clap::Args)]
pub(super) struct VerifyArgs {
    /// Draw this many cells of the grid, spread over methods, sizes, fields of view and scenes, and put their measured time
    /// beside what is predicted before they are drawn
    #[arg(long, value_name = "CELLS", conflicts_with_all = ["solve", "spread", "resume", "shard"])]
    verify: Option<usize>,
    /// Scenes for --verify: study or study@FRAME, hairball[:STRANDS], machine, room[:BARS], or files [default: study,room,machine]
    #[arg(long, value_name = "SCENES", requires = "verify")]
    scene: Option<String>,
    /// How often --verify draws each cell [default: 5]
    #[arg(long, value_name = "N", requires = "verify")]
    rounds: Option<u32>,
}

impl VerifyArgs {
    pub(super) fn is_asked(&self) -> bool {
        self.verify.is_some()
    }
}

/// What people read on a terminal.
const READABLE: [&str; 8] = [
    "cells",
    "count",
    "median_error",
    "p90_error",
    "speedup_median_error",
    "covered_by_90_percent",
    "naive_median_error",
    "noise_floor",
];

pub(super) fn run(args: &Args, ctx: &Context) -> Result<(), Failure> {
    let sweep = args.sweep()?;
    let names = args.verify.scene.as_deref().unwrap_or("study,room,machine");
    let scenes = names.split(',').map(|name| scene(name.trim(), ctx));
    let scenes = scenes.collect::<Result<Vec<_>, _>>()?;
    let verify = Verify {
        sweep: &sweep,
        scenes: &scenes,
        cells: args.verify.verify.unwrap_or_default(),
        rounds: args.verify.rounds.unwrap_or(5),
        options: RenderOptions::default(),
        seed: ctx.seed,
    };
    // An unwritable folder is found before the work, not after.
    let outputs = ctx.out.is_some().then(|| ctx.outputs("out")).transpose()?;
    let bar = ctx.progress(1000, "starting");
    let found = on_one_thread(|| {
        verify.run(&mut processor_time, &|what, share| {
            bar.set_message(what.to_owned());
            bar.set_position((share * 1000.0) as u64);
        })
    })?;
    bar.finish_and_clear();
    let found = found.context("--verify")?;
    if !OF_PROCESSORS {
        ctx.warn("this system has no clock of processor time: times are those that passed");
    }
    show(&found, ctx)?;
    let Some(mut outputs) = outputs else {
        return Ok(());
    };
    outputs.add("verify.csv", found.table().csv());
    outputs.add("verify-summary.csv", found.summary().csv());
    outputs.add("verify-coefficients.csv", found.coefficients().csv());
    outputs.add("verify.svg", found.scatter().svg());
    for path in outputs.commit()? {
        ctx.note(&format!("wrote {}", path.display()));
    }
    Ok(())
}

fn show(found: &VerifyOutcome, ctx: &Context) -> Result<(), Failure> {
    if ctx.format != Format::Table {
        return ctx.print_table(&found.table());
    }
    ctx.print_table(&pick(&found.summary(), &READABLE))?;
    ctx.print(&format!("\n{}\n", found.sentence()))?;
    ctx.note(&format!(
        "Times are of this project's renderer on one thread of this machine's processor, not of a GPU. A probe takes {:.0} ms a view.",
        found.probe_ms
    ));
    Ok(())
}

/// A scene by name, as `name` or `study@FRAME`.
fn scene(name: &str, ctx: &Context) -> Result<VerifyScene, Failure> {
    let (base, frame) = at_frame(name)?;
    let args = SceneArgs::named(base, frame);
    if args.is_volume() {
        let text = format!("--scene {name}: --verify draws meshes, not volumes");
        return Err(Failure::bad_input(text));
    }
    // Any optics will do to load it; those of files are framed anew for each image.
    let optics = Viewport::symmetric([640, 360].into(), 1.0)?;
    let stage = args.stage(&optics, 1, [1.0, 0.0], ctx)?;
    let near_m = stage.near_m;
    let (scene, own) = stage.into_one();
    let bounds = match Path::new(base).exists() {
        true => scene.bounds(),
        false => None,
    };
    let short = Path::new(base)
        .file_name()
        .map_or(base.into(), |n| n.to_string_lossy());
    Ok(VerifyScene {
        name: match frame {
            Some(frame) => format!("{short}@{frame}"),
            None => short.into_owned(),
        },
        scene,
        eye: Box::new(move |optics| bounds.map_or(own, |bounds| framing(bounds, optics))),
        near_m,
    })
}
