//! Flags that several subcommands share, and how their texts become valid values.

use foveasim_models::{Acuity, Display, Durations, Nanos, Rate, Tracker};
use foveasim_study::render_law;

use super::Failure;

/// A display preset's name, or a path to a TOML file that describes one.
pub(crate) fn display(text: &str) -> Result<Display, Failure> {
    Ok(foveasim_study::display(text)?)
}

/// A tracker preset's name, or a path to a TOML file that describes one.
pub(crate) fn tracker(text: &str) -> Result<Tracker, Failure> {
    Ok(foveasim_study::tracker(text)?)
}

/// How long frames render: `--render-ms`, `--render LAW`, or one refresh period, rounded down to the
/// nanosecond so that a blocked host meets every vertical blank.
pub(crate) fn render(
    ms: Option<f64>,
    law: Option<&str>,
    display: &Display,
) -> Result<Durations, Failure> {
    Ok(match (ms, law) {
        (Some(ms), _) => Durations::fixed(milliseconds("--render-ms", ms)?),
        (None, Some(law)) => render_law(law)?,
        (None, None) => Durations::fixed(display.scan.rate.period()),
    })
}

/// An acuity slope by name, quality index or number.
pub(crate) fn acuity(text: &str) -> Result<Acuity, Failure> {
    Ok(Acuity::parse(text)?)
}

/// `WxH` in pixels.
pub(crate) fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text
        .split_once('x')
        .and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    match sides {
        Some(size @ [1..=65_536, 1..=65_536]) => Ok(size),
        _ => Err("want WIDTHxHEIGHT in pixels, each from 1 to 65536, as in 1920x1080".into()),
    }
}

/// `X,Y`: two finite numbers.
pub(crate) fn pair(text: &str) -> Result<[f64; 2], String> {
    let numbers = text
        .split_once(',')
        .and_then(|(x, y)| Some([x.trim().parse::<f64>().ok()?, y.trim().parse::<f64>().ok()?]));
    match numbers {
        Some(pair) if pair.iter().all(|v| v.is_finite()) => Ok(pair),
        _ => Err("want two finite numbers X,Y, as in 960,540".into()),
    }
}

/// `X,Y,Z`: three numbers within a million of 0.
pub(crate) fn triple(text: &str) -> Result<[f64; 3], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|v| v.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if [x, y, z].iter().all(|v| v.abs() <= 1e6) => Ok([x, y, z]),
        _ => Err("want three numbers X,Y,Z within ±1000000, as in 1.5,2,-3".into()),
    }
}

/// A duration in milliseconds, from 0 to 10,000.
pub(crate) fn milliseconds(flag: &str, ms: f64) -> Result<Nanos, Failure> {
    const MAX_MS: f64 = 10_000.0;
    if !(0.0..=MAX_MS).contains(&ms) {
        let text = format!("{flag} = {ms}: must be from 0 to {MAX_MS} ms");
        return Err(Failure::bad_input(text));
    }
    Ok(Nanos::from_ms(ms))
}

/// `10s`, `250ms`, or a number of seconds.
pub(crate) fn duration(text: &str) -> Result<Nanos, String> {
    const DAY_S: f64 = 86_400.0;
    let (number, unit_s) = match text.strip_suffix("ms") {
        Some(number) => (number, 1e-3),
        None => (text.strip_suffix('s').unwrap_or(text), 1.0),
    };
    match number.trim().parse::<f64>().map(|n| n * unit_s) {
        Ok(s) if (0.0..=DAY_S).contains(&s) => Ok(Nanos::from_secs(s)),
        _ => Err(format!(
            "want a time from 0 to {DAY_S} s, as in 10s, 250ms or 2.5"
        )),
    }
}

pub(crate) fn seconds_range(text: &str) -> Result<(Nanos, Nanos), String> {
    let error = || "want START..END in seconds, START before END, as in 2..5.5".to_owned();
    let (from, to) = text
        .trim_end_matches('s')
        .split_once("..")
        .ok_or_else(error)?;
    let (from, to) = (duration(from)?, duration(to)?);
    if from < to {
        Ok((from, to))
    } else {
        Err(error())
    }
}

pub(crate) fn rate(text: &str) -> Result<Rate, String> {
    let hz = text
        .parse()
        .map_err(|_| "want a number of hertz, as in 300".to_owned())?;
    Rate::from_hz("resample", hz).map_err(|e| e.to_string())
}

/// `WxH`: two numbers, range checked where they are used.
pub(crate) fn sides(text: &str) -> Result<[f64; 2], String> {
    text.split_once('x')
        .and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]))
        .ok_or_else(|| "want WIDTHxHEIGHT, as in 528x297".to_owned())
}
