use foveasim_models::math::{mean, quantile_sorted};
use foveasim_models::{Eye, Nanos};

use super::GazeEvents;
use crate::{EventKind, LabelledEvent, Labels};

/// How well events agree with those of somebody else.
#[derive(Debug, Clone, PartialEq)]
pub struct Agreement {
    /// The kind of event.
    pub kind: EventKind,
    /// Whose events they are compared with.
    pub reference_name: String,
    /// Events of the reference.
    pub reference: usize,
    /// Events found.
    pub found: usize,
    /// Pairs of one and the other.
    pub matched: usize,
    /// How far onsets lie apart.
    pub onset: OnsetError,
    /// How far ends lie apart.
    pub offset: OnsetError,
}

/// Differences in time, found minus reference \[ms\]; NaN where nothing was matched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OnsetError {
    /// Mean, with its sign.
    pub mean_ms: f64,
    /// Median of the absolute differences.
    pub median_ms: f64,
    /// 95 % of the absolute differences are smaller.
    pub p95_ms: f64,
}

impl OnsetError {
    /// Nothing was compared.
    pub const NONE: Self = Self {
        mean_ms: f64::NAN,
        median_ms: f64::NAN,
        p95_ms: f64::NAN,
    };

    fn new(differences: &[f64]) -> Self {
        let mut sizes: Vec<f64> = differences.iter().map(|d| d.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        Self {
            mean_ms: mean(differences),
            median_ms: quantile_sorted(&sizes, 0.5),
            p95_ms: quantile_sorted(&sizes, 0.95),
        }
    }
}

impl Agreement {
    /// Share of the events found that the reference has too.
    pub fn precision(&self) -> f64 {
        self.matched as f64 / self.found as f64
    }

    /// Share of the reference's events that were found.
    pub fn recall(&self) -> f64 {
        self.matched as f64 / self.reference as f64
    }

    /// Harmonic mean of precision and recall: 2·matched / (found + reference).
    pub fn f1(&self) -> f64 {
        2.0 * self.matched as f64 / (self.found + self.reference) as f64
    }
}

/// First and last time of an event.
type Span = (Nanos, Nanos);

/// Compares spans of one kind, both in order of start: pairs overlap, each is in one pair at most, and
/// pairs that overlap longer are made first (as Startsev et al. 2019 match events).
pub fn agreement(
    kind: EventKind,
    reference_name: impl Into<String>,
    found: &[(Nanos, Nanos)],
    reference: &[(Nanos, Nanos)],
) -> Agreement {
    let pairs = matches(found, reference);
    let differences = |pick: fn(Span) -> Nanos| -> Vec<f64> {
        let difference = |&(f, r): &(usize, usize)| (pick(found[f]) - pick(reference[r])).as_ms();
        pairs.iter().map(difference).collect()
    };
    Agreement {
        kind,
        reference_name: reference_name.into(),
        reference: reference.len(),
        found: found.len(),
        matched: pairs.len(),
        onset: OnsetError::new(&differences(|s| s.0)),
        offset: OnsetError::new(&differences(|s| s.1)),
    }
}

/// Pairs of indices of found and reference spans.
fn matches(found: &[Span], reference: &[Span]) -> Vec<(usize, usize)> {
    let mut candidates = Vec::new();
    let mut begin = 0;
    for (r, &(start, end)) in reference.iter().enumerate() {
        // Spans of a kind do not overlap one another, so those that ended are done with.
        while begin < found.len() && found[begin].1 < start {
            begin += 1;
        }
        for (f, &(from, to)) in found.iter().enumerate().skip(begin) {
            if from > end {
                break;
            }
            if to >= start {
                candidates.push((to.min(end) - from.max(start), f, r));
            }
        }
    }
    candidates.sort_by_key(|&(overlap, f, r)| (std::cmp::Reverse(overlap), f, r));
    let (mut taken, mut known) = (vec![false; found.len()], vec![false; reference.len()]);
    let mut pairs = Vec::new();
    for (_, f, r) in candidates {
        if !taken[f] && !known[r] {
            (taken[f], known[r]) = (true, true);
            pairs.push((f, r));
        }
    }
    pairs.sort_unstable();
    pairs
}

/// Agreement with the events that a file has, of each kind and eye that it labels.
///
/// A labelled saccade that holds a blink of the same eye is the lid, for so EyeLink marks blinks: it is no
/// saccade, and the blink is as long as it.
pub fn vendor_agreement(events: &GazeEvents, labels: &Labels) -> Vec<Agreement> {
    let mut all = Vec::new();
    for kind in EventKind::ALL {
        let found: Vec<Span> = events.of(kind).map(|e| (e.start, e.end)).collect();
        for eye in [None, Some(Eye::Left), Some(Eye::Right)] {
            let of = |kind: EventKind| {
                let matching = move |e: &&LabelledEvent| e.kind == kind && e.eye == eye;
                labels.events.iter().filter(matching)
            };
            let inside = |inner: &LabelledEvent, outer: &LabelledEvent| {
                inner.start >= outer.start && inner.end <= outer.end
            };
            let span = |e: &LabelledEvent| -> Option<Span> {
                let lid = match kind {
                    EventKind::Fixation => None,
                    EventKind::Saccade if of(EventKind::Blink).any(|b| inside(b, e)) => {
                        return None;
                    }
                    EventKind::Saccade => None,
                    EventKind::Blink => of(EventKind::Saccade).find(|s| inside(e, s)),
                };
                let whole = lid.unwrap_or(e);
                Some((whole.start, whole.end))
            };
            let mut reference: Vec<Span> = of(kind).filter_map(span).collect();
            reference.sort_unstable();
            reference.dedup();
            if reference.is_empty() {
                continue;
            }
            let name = match eye {
                None | Some(Eye::Cyclopean) => "labels",
                Some(Eye::Left) => "labels, left eye",
                Some(Eye::Right) => "labels, right eye",
            };
            all.push(agreement(kind, name, &found, &reference));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_is_matched_once_and_the_longest_overlap_first() {
        let span = |a, b| (Nanos(a), Nanos(b));
        let found = [span(0, 10), span(12, 20), span(30, 40), span(90, 95)];
        let reference = [span(8, 20), span(32, 50), span(60, 70)];
        assert_eq!(matches(&found, &reference), [(1, 0), (2, 1)]);
        let a = agreement(EventKind::Saccade, "r", &found, &reference);
        assert_eq!((a.found, a.reference, a.matched), (4, 3, 2));
        assert!((a.f1() - 4.0 / 7.0).abs() < 1e-15);
        assert!((a.onset.mean_ms - 1e-6).abs() < 1e-18, "{:?}", a.onset);
        let none = agreement(EventKind::Blink, "r", &[], &reference);
        assert!(none.onset.median_ms.is_nan() && none.f1() == 0.0);
    }
}
