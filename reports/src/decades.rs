use std::ops::Range;

use foveasim_models::math::{log10, pow};
use plotters::coord::ranged1d::{BoldPoints, Ranged};
use plotters::coord::types::RangedCoordf64;

use crate::axes::{exactly, tick};
use crate::ticked::Ticked;

/// Where values lie along an axis that may be logarithmic: places run evenly.
#[derive(Debug, Clone)]
pub(crate) struct Scale {
    logarithmic: bool,
    places: Range<f64>,
    ticks: Vec<f64>,
}

impl Scale {
    /// An axis over `span`, with some room at both ends and about `count` numbers. Of a logarithmic one, `span` is above 0.
    pub(crate) fn over([low, high]: [f64; 2], logarithmic: bool, count: usize) -> Self {
        if !logarithmic {
            let Range { start, end } = exactly(low, high);
            let room = 0.05 * (end - start);
            let places = start - room..end + room;
            let ticks = RangedCoordf64::from(places.clone()).key_points(BoldPoints(count));
            return Self {
                logarithmic,
                places,
                ticks,
            };
        }
        let (start, end) = (log10(low), log10(high));
        // Below a fifth of a decade, there would be no two numbers to read by.
        let half = (0.5 * (end - start)).max(0.1);
        let middle = 0.5 * (start + end);
        let room = 0.06 * half;
        let places = middle - half - room..middle + half + room;
        let within = |steps: &[f64]| -> Vec<f64> {
            let decades = places.start.floor() as i32..=places.end.ceil() as i32;
            let all = decades.flat_map(|d| steps.iter().map(move |s| f64::from(d) + log10(*s)));
            all.filter(|p| places.contains(p)).collect()
        };
        let steps: [&[f64]; 4] = [
            &[1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0],
            &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0],
            &[1.0, 2.0, 5.0],
            &[1.0],
        ];
        let found = steps.into_iter().map(within).find(|t| t.len() <= count);
        let ticks = found.unwrap_or_else(|| {
            let decades = within(&[1.0]);
            let every = decades.len().div_ceil(count).max(1);
            decades.into_iter().step_by(every).collect()
        });
        Self {
            logarithmic,
            places,
            ticks,
        }
    }

    /// Where a value lies.
    pub(crate) fn place(&self, value: f64) -> f64 {
        match self.logarithmic {
            true => log10(value),
            false => value,
        }
    }

    /// The number at a place.
    pub(crate) fn text(&self, place: f64) -> String {
        match self.logarithmic {
            true => {
                let value = pow(10.0, place);
                // Three digits: no tick has more, and logarithms come back with noise.
                let scale = pow(10.0, 2.0 - log10(value).floor());
                tick((value * scale).round() / scale)
            }
            false => tick(place),
        }
    }

    /// All numbers along the axis.
    pub(crate) fn texts(&self) -> Vec<String> {
        self.ticks.iter().map(|t| self.text(*t)).collect()
    }

    /// For a chart.
    pub(crate) fn ticked(&self) -> Ticked {
        Ticked::new(self.places.clone(), self.ticks.clone())
    }

    /// The first place.
    pub(crate) fn start(&self) -> f64 {
        self.places.start
    }

    /// The last place.
    pub(crate) fn end(&self) -> f64 {
        self.places.end
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_along_a_logarithmic_axis() {
        let texts = |low, high| Scale::over([low, high], true, 8).texts();
        assert_eq!(texts(1.0, 100.0), ["1", "2", "5", "10", "20", "50", "100"]);
        assert_eq!(
            texts(0.001, 1000.0),
            ["0.001", "0.01", "0.1", "1", "10", "100", "1000"]
        );
        assert_eq!(texts(3.0, 3.0), ["2.5", "3"]);
        for (low, high) in [
            (1e-300, 1e300),
            (1.0, 1.0 + 1e-12),
            (5e-7, 6e-7),
            (1e90, 1e99),
        ] {
            let texts = texts(low, high);
            assert!((2..=9).contains(&texts.len()), "{low} {high}: {texts:?}");
        }
    }
}
