/// A chain of nested layers to be placed: minimise
///
/// Σ_{i<n} w_i · area(e_i) / s(e_{i−1})² + w_n · whole / s(e_{n−1})², with w_1 = 1 and s(e_0) = 1.
///
/// Each term joins neighbours only, so dynamic programming finds the best radii on any grid in
/// O(n·N²) where trying all is O(N^{n−1}).
pub(super) struct Chain<'a> {
    /// Display pixels inside radius e.
    pub(super) area: &'a dyn Fn(f64) -> f64,
    /// 1/s² of the layer outside radius e.
    pub(super) density: &'a dyn Fn(f64) -> f64,
    /// Display pixels of the whole screen.
    pub(super) whole: f64,
    /// Weight of all layers but the first.
    pub(super) outer_weight: f64,
    /// The radii allowed \[deg\].
    pub(super) range: [f64; 2],
    /// The first radius, if it is given \[deg\].
    pub(super) first: Option<f64>,
}

/// Radii and what they cost.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Placement {
    pub(super) cost: f64,
    pub(super) radii: Vec<f64>,
}

/// Points of the first, global grid. They are denser near the fovea, where ω changes most relative
/// to itself.
const GLOBAL_POINTS: usize = 96;
/// A coarse result this much above the best may still win once refined: several times what the
/// global grid costs against the continuum (0.4 % at 50 even points).
const COARSE_SLACK: f64 = 1.02;
/// Refinement stops at windows this small relative to the radius. The cost is flat there: its own
/// relative error is about the square of this.
const RADIUS_TOLERANCE: f64 = 1e-7;
const MAX_ROUNDS: usize = 200;

impl Chain<'_> {
    /// The best placement of at most `max_layers` layers, on the continuum.
    pub(super) fn optimise(&self, max_layers: usize) -> Placement {
        let [low, high] = self.range;
        let single = Placement {
            cost: self.whole,
            radii: Vec::new(),
        };
        let first = self.first.unwrap_or(low);
        if max_layers < 2 || !(low < high && first >= low && first < high) {
            return single;
        }
        let grid: Vec<f64> = (0..GLOBAL_POINTS)
            .map(|k| {
                let x = (k as f64 + 0.5) / GLOBAL_POINTS as f64;
                low + (high - low) * x * x
            })
            .collect();
        let stages = self.stages(max_layers, &grid);
        let coarse = self.best_per_count(&stages);
        let least = coarse.iter().map(|p| p.cost).fold(single.cost, f64::min);
        let refined = coarse
            .into_iter()
            .filter(|p| p.cost <= least * COARSE_SLACK);
        // Fewer layers win ties: a layer that saves nothing is not made.
        refined
            .map(|p| self.refine(p))
            .fold(single, |best, p| if p.cost < best.cost { p } else { best })
    }

    /// The best placement of exactly `layers` layers with radii among `grid` (ascending); `None` if
    /// there are not enough of them. This is what trying every combination finds.
    pub(super) fn optimise_on(&self, layers: usize, grid: &[f64]) -> Option<Placement> {
        let [low, high] = self.range;
        let allowed: Vec<f64> = grid
            .iter()
            .copied()
            .filter(|e| (low..=high).contains(e))
            .collect();
        if layers == 1 {
            return Some(Placement {
                cost: self.whole,
                radii: Vec::new(),
            });
        }
        let stages = self.stages(layers, &allowed);
        self.best_per_count(&stages)
            .into_iter()
            .find(|p| p.radii.len() + 1 == layers)
    }

    /// Candidates for each radius: `grid`, or the one that is given.
    fn stages(&self, layers: usize, grid: &[f64]) -> Vec<Vec<f64>> {
        let mut stages = vec![grid.to_vec(); layers - 1];
        if let (Some(first), Some(stage)) = (self.first, stages.first_mut()) {
            *stage = vec![first];
        }
        stages
    }

    /// For each number of layers from 2 up, the best placement on the candidates, where there is any.
    fn best_per_count(&self, stages: &[Vec<f64>]) -> Vec<Placement> {
        let mut found = Vec::with_capacity(stages.len());
        let mut cost: Vec<f64> = stages[0].iter().map(|&e| (self.area)(e)).collect();
        let mut density: Vec<f64> = stages[0].iter().map(|&e| (self.density)(e)).collect();
        let mut came_from: Vec<Vec<usize>> = Vec::new();
        for i in 0..stages.len() {
            if i > 0 {
                let (inner, outer) = (&stages[i - 1], &stages[i]);
                let mut next_cost = Vec::with_capacity(outer.len());
                let mut origin = Vec::with_capacity(outer.len());
                for &e in outer {
                    let area = self.outer_weight * (self.area)(e);
                    let mut best = (f64::INFINITY, 0);
                    for k in 0..inner.len() {
                        let total = cost[k] + area * density[k];
                        if inner[k] < e && total < best.0 {
                            best = (total, k);
                        }
                    }
                    next_cost.push(best.0);
                    origin.push(best.1);
                }
                cost = next_cost;
                density = outer.iter().map(|&e| (self.density)(e)).collect();
                came_from.push(origin);
            }
            let rest = self.outer_weight * self.whole;
            let totals = cost
                .iter()
                .zip(&density)
                .map(|(c, d)| c + rest * d)
                .enumerate();
            let best = totals.fold((0, f64::INFINITY), |b, t| if t.1 < b.1 { t } else { b });
            if best.1.is_finite() {
                let mut index = best.0;
                let mut radii = vec![stages[i][index]];
                for stage in (0..i).rev() {
                    index = came_from[stage][index];
                    radii.push(stages[stage][index]);
                }
                radii.reverse();
                found.push(Placement {
                    cost: best.1,
                    radii,
                });
            }
        }
        found
    }

    /// Follows a placement to its continuous optimum: the same dynamic programming over a small
    /// window about each radius, moved while the best lies at a window's end and shrunk when it lies
    /// inside. Unlike Newton steps this needs no derivatives, which do not exist where a layer meets
    /// the edge of the screen, and cannot leave the basin upwards.
    fn refine(&self, mut at: Placement) -> Placement {
        const HALF: i32 = 4;
        let [low, high] = self.range;
        let layers = at.radii.len() + 1;
        let mut relative = 1.0 / GLOBAL_POINTS as f64;
        for _ in 0..MAX_ROUNDS {
            if relative < RADIUS_TOLERANCE {
                break;
            }
            let window = |&e: &f64| -> Vec<f64> {
                let step = relative * e;
                (-HALF..=HALF)
                    .map(|j| (e + f64::from(j) * step).clamp(low, high))
                    .collect()
            };
            let mut stages: Vec<Vec<f64>> = at.radii.iter().map(window).collect();
            if let Some(first) = self.first {
                stages[0] = vec![first];
            }
            let next = self
                .best_per_count(&stages)
                .into_iter()
                .find(|p| p.radii.len() + 1 == layers);
            let Some(next) = next.filter(|p| p.cost <= at.cost) else {
                relative *= 0.25;
                continue;
            };
            let moved = next.radii.iter().zip(&at.radii);
            let steps = moved
                .map(|(a, b)| (a - b).abs() / (relative * b))
                .fold(0.0, f64::max);
            relative *= if steps < 1.5 {
                0.3
            } else if steps < f64::from(HALF) - 0.5 {
                0.6
            } else {
                1.0
            };
            at = next;
        }
        at
    }
}
