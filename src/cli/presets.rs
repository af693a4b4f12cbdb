use foveasim_models::{Display, Tracker, presets};
use foveasim_reports::{Cell, Table};

use super::{Context, Failure};

/// List displays, trackers and cost profiles, or show one with the source of each number.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  foveasim presets
  foveasim presets lg-w2363d
  foveasim presets quest-pro --format json")]
pub(crate) struct Args {
    /// Show only this display or tracker, every number with its source
    name: Option<String>,
}

pub(crate) fn run(args: &Args, ctx: &Context) -> Result<(), Failure> {
    match &args.name {
        None => list(ctx),
        Some(name) => show(name, ctx),
    }
}

fn list(ctx: &Context) -> Result<(), Failure> {
    let mut table = Table::new([
        "kind",
        "name",
        "title",
        "fov_h_deg",
        "fov_v_deg",
        "width_px",
        "height_px",
        "eyes",
        "ppd_centre",
        "ppd_mean",
        "ppd_min",
        "rate_hz",
    ]);
    for name in presets::display_names() {
        let d = presets::display(name)?;
        let viewport = &d.primary().viewport;
        let density = viewport.pixel_density();
        table.push(vec![
            "display".into(),
            name.into(),
            d.title.as_str().into(),
            d.fov_h_deg().into(),
            viewport.fov_deg().y.into(),
            viewport.size.x.into(),
            viewport.size.y.into(),
            d.eyes.len().into(),
            density.centre.into(),
            density.mean.into(),
            density.min.into(),
            d.scan.rate.hz().into(),
        ]);
    }
    for name in presets::tracker_names() {
        let t = presets::tracker(name)?;
        let mut row = vec!["tracker".into(), name.into(), t.title.as_str().into()];
        row.resize(table.columns().len() - 1, Cell::Empty);
        row.push(t.rate.hz().into());
        table.push(row);
    }
    for name in presets::cost_names() {
        let profile = presets::cost(name)?;
        let mut row = vec!["cost".into(), name.into(), profile.title.into()];
        row.resize(table.columns().len(), Cell::Empty);
        table.push(row);
    }
    ctx.deliver_table(&table, "presets.csv")
}

fn show(name: &str, ctx: &Context) -> Result<(), Failure> {
    let display = presets::display_spec(name);
    let tracker = presets::tracker_spec(name);
    let cost = presets::cost(name);
    if display.is_err() && tracker.is_err() && cost.is_err() {
        let mut names = presets::display_names();
        names.extend(presets::tracker_names());
        names.extend(presets::cost_names());
        names.sort_unstable();
        names.dedup();
        return Err(foveasim_models::unknown_name("preset", name, &names).into());
    }
    let mut table = Table::new(["kind", "field", "value", "unverified", "source"]);
    if let Ok(spec) = display {
        Display::try_from(spec.clone())?;
        add(&mut table, "display", presets::facts(&spec, &spec.sources));
    }
    if let Ok(spec) = tracker {
        Tracker::try_from(spec.clone())?;
        add(&mut table, "tracker", presets::facts(&spec, &spec.sources));
    }
    if let Ok(profile) = cost {
        add(
            &mut table,
            "cost",
            presets::facts(&profile, &profile.sources),
        );
    }
    ctx.deliver_table(&table, "presets.csv")
}

fn add(table: &mut Table, kind: &str, facts: Vec<presets::Fact>) {
    for fact in facts {
        let source = fact.source.as_ref();
        table.push(vec![
            kind.into(),
            fact.field.into(),
            fact.value.into(),
            source
                .map(|s| if s.unverified { "yes" } else { "no" })
                .into(),
            source.map(|s| s.source.as_str()).into(),
        ]);
    }
}
