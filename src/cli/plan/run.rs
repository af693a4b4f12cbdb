//! Making the rows of a sweep, all at once or in parts.

use std::path::PathBuf;

use foveasim_models::foveation::PlanCache;
use foveasim_reports::{Heatmap, Outputs};
use foveasim_study::{
    SWEEP_TEXT_COLUMNS, SWEEP_WHOLE_COLUMNS, SavingsSpread, SavingsSpreadRow, Shard, Solve, Sweep,
    SweepRow,
};
use rayon::prelude::*;

use super::super::context::Format;
use super::super::parquet::{self, Columns};
use super::super::{Context, Failure};
use super::log::{self, Header, Log, Writer};
use super::{Args, READABLE, pick};

/// Put the shards of a sweep together to its table.
#[derive(Debug, clap::Args)]
pub(super) struct MergeArgs {
    /// Folders that `foveasim plan --shard` wrote to
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,
}

/// Groups of rows that are made before they are appended to the log.
const CHUNK: usize = 256;

pub(super) fn sweep(args: &Args, ctx: &Context) -> Result<(), Failure> {
    let sweep = args.sweep()?;
    let shard = match &args.shard {
        None => None,
        Some(text) => Some(text.parse::<Shard>()?),
    };
    if args.resume || shard.is_some() {
        return in_parts(&sweep, args, shard, ctx);
    }
    // An unwritable folder is found before the work, not after.
    let outputs = ctx.out.is_some().then(|| ctx.outputs("out")).transpose()?;
    if let Some(outputs) = &outputs
        && outputs.path(log::NAME).exists()
    {
        let path = outputs.path(log::NAME);
        let text = format!(
            "{} holds rows of a sweep that was not finished: --resume goes on with it",
            path.display()
        );
        return Err(Failure::bad_input(text));
    }
    let bar = ctx.progress(sweep.len() as u64, "planning");
    let rows = sweep.run(|n| bar.inc(n))?;
    bar.finish_and_clear();
    let table = SweepRow::table(&rows);
    let beyond = rows.iter().filter(|r| r.needs().beyond_fit.is_some());
    let beyond = beyond.count();
    if beyond > 0 {
        ctx.note(&format!(
            "frame_ms of {beyond} of {} rows is extrapolated: more, or less, work than cost profile {} rests on",
            rows.len(),
            sweep.terms.cost.name
        ));
    }
    let file = match ctx.format {
        Format::Parquet => Some(parquet::file(&table, Some(COLUMNS))?),
        _ => None,
    };
    match (ctx.format, &file) {
        (Format::Table, _) => {
            ctx.print_table(&pick(&table, &READABLE))?;
            ctx.note("All columns: --format csv");
        }
        // A folder gets it instead.
        (_, Some(_)) if outputs.is_some() => {}
        (_, Some(file)) => ctx.print_bytes(file)?,
        _ => ctx.print_table(&table)?,
    }
    if let Some(outputs) = outputs {
        let table = match file {
            Some(file) => ("plan.parquet", file),
            None => ("plan.csv", table.csv().into_bytes()),
        };
        write(outputs, table, args.heatmaps(&sweep, &rows)?, ctx)?;
    }
    Ok(())
}

const COLUMNS: Columns<'_> = Columns {
    text: &SWEEP_TEXT_COLUMNS,
    whole: &SWEEP_WHOLE_COLUMNS,
};

/// Everything a folder given with `--out` receives.
fn write(
    mut outputs: Outputs,
    (name, table): (&str, Vec<u8>),
    maps: Vec<(String, Heatmap)>,
    ctx: &Context,
) -> Result<(), Failure> {
    // The other form of an earlier run would be of other rows.
    outputs.retire(match name {
        "plan.csv" => "plan.parquet",
        _ => "plan.csv",
    });
    outputs.add(name, table);
    for (name, map) in maps {
        outputs.add(name, map.svg());
    }
    for path in outputs.commit()? {
        ctx.note(&format!("wrote {}", path.display()));
    }
    Ok(())
}

/// Appends rows to a log as they are made. Without `shard`, the whole table is written at the end, and the log
/// removed.
fn in_parts(
    sweep: &Sweep,
    args: &Args,
    shard: Option<Shard>,
    ctx: &Context,
) -> Result<(), Failure> {
    if ctx.format == Format::Parquet {
        let text = "--format parquet: not with --resume or --shard, whose rows are kept as CSV";
        return Err(Failure::bad_input(text));
    }
    let mut outputs = ctx.outputs("out")?;
    let header = Header::of(sweep, shard.unwrap_or(Shard::WHOLE));
    let mut found = Log::read(outputs.dir())?;
    if found.is_some() && !args.resume {
        let text = format!(
            "{} has rows already: --resume goes on with them",
            outputs.path(log::NAME).display()
        );
        return Err(Failure::bad_input(text));
    }
    if let Some(log) = &mut found {
        log.check(sweep, &header)?;
    }
    let mut writer = Writer::new(outputs.dir(), &header, found.as_ref())?;
    let mut lines = found.map_or_else(Default::default, |log| log.rows);
    let kept = lines.len();
    let methods = sweep.methods.len();
    let groups: Vec<usize> = shard
        .unwrap_or(Shard::WHOLE)
        .groups(sweep.groups())
        .filter(|g| !lines.contains_key(&(g * methods)))
        .collect();
    let bar = ctx.progress((groups.len() * methods) as u64, "planning");
    for some in groups.chunks(CHUNK) {
        let made: Vec<_> = some
            .par_iter()
            .map_init(PlanCache::default, |cache, g| sweep.rows_from(cache, *g))
            .collect();
        for (group, rows) in some.iter().zip(made) {
            let added = writer.append(sweep, *group, &rows?)?;
            bar.inc(added.len() as u64);
            lines.extend(
                added
                    .into_iter()
                    .map(|(n, line)| (n, (String::new(), line))),
            );
        }
    }
    bar.finish_and_clear();
    let made = lines.len() - kept;
    if let Some(shard) = shard {
        let place = outputs.path(log::NAME);
        ctx.note(&format!(
            "shard {shard}: {made} rows made, {kept} were there, in {}",
            place.display()
        ));
        return Ok(());
    }
    outputs.add(
        "plan.csv",
        log::table(lines.into_values().map(|(_, line)| line)),
    );
    for path in outputs.commit()? {
        ctx.note(&format!(
            "wrote {}: {made} rows made, {kept} were there",
            path.display()
        ));
    }
    Ok(writer.finish()?)
}

/// Inverse questions to the same forward model.
pub(super) fn solve(args: &Args, ctx: &Context) -> Result<(), Failure> {
    let sweep = args.sweep()?;
    let (unknown, target) = (args.solve.as_deref(), args.target.as_deref());
    let solve = Solve {
        unknown: unknown.unwrap_or_default().parse()?,
        target: target.unwrap_or_default().parse()?,
        eye_deg_per_s: args.eye_speed,
    };
    let table = solve.table(&solve.run(&sweep)?);
    ctx.deliver_table(&table, "solve.csv")
}

/// Percentiles of savings.
pub(super) fn spread(args: &Args, ctx: &Context) -> Result<(), Failure> {
    let sweep = args.sweep()?;
    let spread = SavingsSpread {
        tracker_sd_deg: args.tracker_sd_deg,
        draws: args.draws,
        seed: ctx.seed,
    };
    let rows = spread.run(&sweep)?;
    ctx.deliver_table(&SavingsSpreadRow::table(&rows), "spread.csv")?;
    if sweep.terms.cost.error.is_none() {
        ctx.note("The cost profile states no error: `cost` does not spread.");
    }
    Ok(())
}

pub(super) fn merge(args: &MergeArgs, ctx: &Context) -> Result<(), Failure> {
    if ctx.format == Format::Parquet {
        let text = "--format parquet: `plan merge` puts CSV together";
        return Err(Failure::bad_input(text));
    }
    let text = log::merge(&args.folders)?;
    let Some(folder) = &ctx.out else {
        return ctx.print(&text);
    };
    let mut outputs = Outputs::new(folder)?;
    outputs.add("plan.csv", text);
    for path in outputs.commit()? {
        ctx.note(&format!("wrote {}", path.display()));
    }
    Ok(())
}
