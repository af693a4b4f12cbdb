use foveasim_models::Nanos;
use foveasim_pipeline::{BoundKind, Interval};
use foveasim_reports::{Cell, Table};

use super::{Histogram, LatencyError, LatencySample, QUANTITIES, Quantity};

/// The distributions found by a study.
#[derive(Debug, Clone, PartialEq)]
pub struct LatencyResult {
    /// One for each of [`QUANTITIES`].
    pub histograms: Vec<Histogram>,
    /// Bounds, in the same order.
    pub bounds: Vec<Interval>,
    /// Whether they are reached, or only hold.
    pub bound_kinds: Vec<BoundKind>,
    /// The fastest and the slowest run to the row gazed at: of gaze, and of motion.
    pub extremes: [[LatencySample; 2]; 2],
    /// How many events were simulated.
    pub events: u64,
}

/// Columns of latency tables.
pub(super) const COLUMNS: [&str; 11] = [
    "stage",
    "min_ms",
    "p5_ms",
    "p50_ms",
    "mean_ms",
    "p95_ms",
    "p99_ms",
    "max_ms",
    "bound_min_ms",
    "bound_max_ms",
    "bound",
];

/// The numbers of one row of such a table.
pub(super) fn columns(h: &Histogram, bound: Interval) -> [f64; 9] {
    [
        h.min().as_ms(),
        h.quantile_ms(0.05),
        h.quantile_ms(0.5),
        h.mean_ms(),
        h.quantile_ms(0.95),
        h.quantile_ms(0.99),
        h.max().as_ms(),
        bound.min.as_ms(),
        bound.max.as_ms(),
    ]
}

impl LatencyResult {
    /// The distribution of one quantity.
    pub fn histogram(&self, quantity: Quantity) -> &Histogram {
        &self.histograms[quantity.index()]
    }

    /// The first quantity, if any, that was measured outside its bounds: then one of the two is wrong.
    pub fn outside_bounds(&self) -> Option<Quantity> {
        QUANTITIES.into_iter().find(|q| {
            let (h, b) = (self.histogram(*q), self.bounds[q.index()]);
            !(b.contains(h.min()) && b.contains(h.max()))
        })
    }

    /// Checks that nothing was measured outside its bounds.
    ///
    /// # Errors
    /// Names the first quantity that was.
    pub(super) fn check(&self) -> Result<(), LatencyError> {
        let Some(quantity) = self.outside_bounds() else {
            return Ok(());
        };
        let (h, bound) = (self.histogram(quantity), self.bounds[quantity.index()]);
        let span = |from: Nanos, to: Nanos| format!("{:.6} to {:.6}", from.as_ms(), to.as_ms());
        Err(LatencyError::OutsideBounds {
            quantity: quantity.name(),
            found: span(h.min(), h.max()),
            bound: span(bound.min, bound.max),
        })
    }

    /// Whether a quantity belongs in tables: stages of parts that are off do not.
    pub(super) fn is_told(&self, quantity: Quantity) -> bool {
        let present = self.bounds[quantity.index()].max > Nanos::ZERO;
        match quantity {
            Quantity::Stage(stage) => stage.is_basic() || present,
            Quantity::MotionStage(_) => present,
            Quantity::Gaze(_) | Quantity::Motion(_) => true,
        }
    }

    /// One row per quantity of gaze: quantiles and mean of the simulation, then the bounds and whether they
    /// are `exact` or `outer`.
    pub fn table(&self) -> Table {
        self.table_of(|q| !q.is_motion())
    }

    /// The same for gaze and motion.
    pub fn full_table(&self) -> Table {
        self.table_of(|_| true)
    }

    fn table_of(&self, chosen: impl Fn(Quantity) -> bool) -> Table {
        let mut table = Table::new(COLUMNS);
        for (quantity, bound) in QUANTITIES.into_iter().zip(&self.bounds) {
            if !(chosen(quantity) && self.is_told(quantity)) {
                continue;
            }
            let mut row: Vec<Cell> = vec![quantity.name().into()];
            row.extend(columns(self.histogram(quantity), *bound).map(Cell::from));
            row.push(self.bound_kinds[quantity.index()].name().into());
            table.push(row);
        }
        table
    }

    /// All histograms, for drawing: `bins` equal bins over each quantity's bounds, with the fraction
    /// of the runs in each.
    pub fn histogram_table(&self, bins: usize) -> Table {
        let mut table = Table::new(["stage", "from_ms", "to_ms", "fraction"]);
        for quantity in QUANTITIES.into_iter().filter(|q| self.is_told(*q)) {
            for (from, to, fraction) in self.histogram(quantity).coarse(bins) {
                table.push(vec![
                    quantity.name().into(),
                    from.into(),
                    to.into(),
                    fraction.into(),
                ]);
            }
        }
        table
    }
}
