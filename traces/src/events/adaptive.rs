use foveasim_models::math::{mean, quantile_sorted, sqrt};

use super::blinks::Blinks;
use super::chunks::Chunks;
use super::{EventOptions, GazeEvent, SpeedLimits};
use crate::EventKind;

/// No eye is faster \[deg/s\] (Nyström & Holmqvist 2010).
const FASTEST_DEG_PER_S: f64 = 1000.0;
/// Where the limit would be higher, saccades cannot be told from noise (they start it at 100 to 300).
const HIGHEST_DEG_PER_S: f64 = 300.0;
/// A saccade exceeds mean + 6 σ of the speeds that are none, and begins at mean + 3 σ (their eqs 1, 2).
const PEAK_SIGMAS: f64 = 6.0;
const ONSET_SIGMAS: f64 = 3.0;
/// It ends below this share of the limit at onset and the rest of the noise just before it (their eq. 3).
const OFFSET_GLOBAL: f64 = 0.7;
/// What is just before it \[ms\].
const BEFORE_MS: f64 = 40.0;
/// Standard deviation of a normal distribution over its median absolute deviation.
const NORMAL_PER_MEDIAN: f64 = 1.482_602_218_505_602;
/// The search ends when the limit moves by less \[deg/s\].
const CONVERGED_DEG_PER_S: f64 = 1.0;

/// The limits that the recording's own noise sets: from the start of the options, the middle and the
/// spread of all speeds below the limit give the next limit, until it stays (Nyström & Holmqvist 2010).
///
/// Middle and spread are median and scaled median deviation, as Engbert & Kliegl (2003) have them, and not
/// mean and standard deviation: those let the limit run away to speeds no eye has where the head moves and
/// the eyes turn against it.
pub(super) fn limits(speeds: &[f64], options: &EventOptions) -> SpeedLimits {
    let mut peak = options.initial_deg_per_s;
    let mut onset = peak;
    // A limit that went in circles would still end the search.
    for _ in 0..100 {
        let mut slow: Vec<f64> = speeds.iter().copied().filter(|v| *v < peak).collect();
        if slow.is_empty() {
            break;
        }
        slow.sort_unstable_by(f64::total_cmp);
        let centre = quantile_sorted(&slow, 0.5);
        let mut deviations: Vec<f64> = slow.iter().map(|v| (v - centre).abs()).collect();
        deviations.sort_unstable_by(f64::total_cmp);
        let sigma = NORMAL_PER_MEDIAN * quantile_sorted(&deviations, 0.5);
        let within = |v: f64, share: f64| {
            v.max(share * options.floor_deg_per_s)
                .min(share * HIGHEST_DEG_PER_S)
        };
        let next = within(centre + PEAK_SIGMAS * sigma, 1.0);
        onset = within(centre + ONSET_SIGMAS * sigma, 0.5);
        let step = (next - peak).abs();
        peak = next;
        if step < CONVERGED_DEG_PER_S {
            break;
        }
    }
    SpeedLimits {
        peak_deg_per_s: peak,
        onset_deg_per_s: onset,
    }
}

fn spread(values: &[f64]) -> (f64, f64) {
    let centre = mean(values);
    let squares: Vec<f64> = values.iter().map(|v| (v - centre) * (v - centre)).collect();
    (centre, sqrt(mean(&squares)))
}

/// Saccades and fixations of every chunk.
pub(super) fn events(
    chunks: &Chunks,
    speeds: &[f64],
    limits: SpeedLimits,
    options: &EventOptions,
    blinks: &mut Blinks,
) -> Vec<GazeEvent> {
    let mut events = Vec::new();
    for (index, range) in chunks.ranges.iter().enumerate() {
        // What moves next to a loss is the lid.
        let fast = |i: usize| speeds[i] >= limits.onset_deg_per_s;
        let (mut low, mut high) = (range.start, range.end);
        if blinks.before(index) {
            while low < high && fast(low) {
                low += 1;
            }
            blinks.ends_at(index, chunks.t[low.min(range.end - 1)]);
        }
        if blinks.after(index) {
            while high > low && fast(high - 1) {
                high -= 1;
            }
            blinks.begins_at(index, chunks.t[high.max(range.start + 1) - 1]);
        }
        if low < high {
            between(chunks, speeds, limits, options, low..high, &mut events);
        }
    }
    events
}

/// Saccades and fixations of samples without loss.
fn between(
    chunks: &Chunks,
    speeds: &[f64],
    limits: SpeedLimits,
    options: &EventOptions,
    range: std::ops::Range<usize>,
    events: &mut Vec<GazeEvent>,
) {
    let ms = |a: usize, b: usize| (chunks.t[b] - chunks.t[a]).as_ms();
    let mut free = range.start;
    let mut landed: Option<usize> = None;
    let mut i = range.start;
    while i < range.end {
        if speeds[i] <= limits.peak_deg_per_s {
            i += 1;
            continue;
        }
        let first = onset(speeds, limits, free, i);
        let last = offset(chunks, speeds, limits, first, i, range.end);
        let too_fast = speeds[first..=last].iter().any(|v| *v > FASTEST_DEG_PER_S);
        let settling = landed.is_some_and(|l| ms(l, i) < options.settle_ms);
        let long = ms(first, last) >= options.min_saccade_ms;
        if settling || long || too_fast {
            if first > free && !settling {
                fixation(chunks, speeds, options, free..=first, events);
            }
            if long && !too_fast && !settling {
                events.push(chunks.event(EventKind::Saccade, first..=last, speeds));
                landed = Some(last);
            }
            free = last;
        }
        i = last + 1;
    }
    if free + 1 < range.end {
        fixation(chunks, speeds, options, free..=range.end - 1, events);
    }
}

fn fixation(
    chunks: &Chunks,
    speeds: &[f64],
    options: &EventOptions,
    samples: std::ops::RangeInclusive<usize>,
    events: &mut Vec<GazeEvent>,
) {
    let event = chunks.event(EventKind::Fixation, samples, speeds);
    if event.duration().as_ms() >= options.min_fixation_ms {
        events.push(event);
    }
}

/// Backwards from a sample above the peak limit: the first that is below the onset's and lower than the
/// one before it.
fn onset(speeds: &[f64], limits: SpeedLimits, low: usize, peak: usize) -> usize {
    let mut i = peak;
    while i > low && (speeds[i] >= limits.onset_deg_per_s || speeds[i - 1] < speeds[i]) {
        i -= 1;
    }
    i
}

/// Forwards likewise, with the limit weighted by the noise just before the saccade.
fn offset(
    chunks: &Chunks,
    speeds: &[f64],
    limits: SpeedLimits,
    onset: usize,
    peak: usize,
    high: usize,
) -> usize {
    let begin = chunks.t[onset];
    let mut from = onset;
    while from > 0
        && from > onset.saturating_sub(4096)
        && (begin - chunks.t[from - 1]).as_ms() <= BEFORE_MS
    {
        from -= 1;
    }
    let before = &speeds[from..onset];
    let local = if before.is_empty() {
        limits.onset_deg_per_s
    } else {
        let (centre, sigma) = spread(before);
        (centre + ONSET_SIGMAS * sigma).min(limits.peak_deg_per_s)
    };
    let limit = OFFSET_GLOBAL * limits.onset_deg_per_s + (1.0 - OFFSET_GLOBAL) * local;
    let mut i = peak;
    while i + 1 < high && (speeds[i] >= limit || speeds[i + 1] < speeds[i]) {
        i += 1;
    }
    i
}
