use std::cell::Cell;

use foveasim_models::math::quantile_sorted;
use foveasim_models::{FrameCost, FrameInput, ModelError, Nanos};
use foveasim_reports::Table;

use super::{PlanCost, RunError, recording};
use crate::{GazeState, Part, RenderTime, Scenario, ScenarioSpec, replay_each};

/// The margin that a latency calls for, and the latency that this margin makes: a wider sharp region
/// takes more samples, which take longer, during which the eye gets further.
#[derive(Debug, Clone, PartialEq)]
pub struct MarginLoop {
    /// From no margin on; each takes the margin that the one before needed.
    pub steps: Vec<MarginStep>,
    /// Whether the last margin is what it needs itself, to [`MARGIN_TOLERANCE_DEG`].
    pub closed: bool,
}

/// One turn of a [`MarginLoop`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MarginStep {
    /// How much wider the sharp region is \[deg\].
    pub margin_deg: f64,
    /// Mean samples shaded in a frame, all eyes together.
    pub samples: f64,
    /// Mean time that a frame renders \[ms\].
    pub render_ms: f64,
    /// Mean age of the gaze when its light comes out \[ms\].
    pub gaze_age_ms: f64,
    /// The margin that would have covered the gaze error in the fraction of displayed frames asked
    /// for \[deg\].
    pub needed_deg: f64,
}

/// How near the margin needed must be to the margin there is \[deg\].
pub const MARGIN_TOLERANCE_DEG: f64 = 0.01;

/// A loop that has not closed by then does not.
const MOST_STEPS: usize = 20;

/// The widest margin that methods are planned for \[deg\].
const WIDEST_DEG: f64 = 90.0;

/// Closes the loop for the scenario's featured method: the recording is replayed with frames that take
/// what the cost profile says of their own samples, until the margin covers the angle between eye and
/// drawn fovea in `fraction` of the displayed frames that the tracker follows. Frames whose gaze is
/// held or lost, or whose true gaze is not known, do not count.
///
/// # Errors
/// If `fraction` is not above 0 and below 1, or rendering is off, or the recording cannot be read or replayed, or has no
/// frame that counts.
pub fn close_margin(scenario: &Scenario, fraction: f64) -> Result<MarginLoop, RunError> {
    if !(fraction > 0.0 && fraction < 1.0) {
        let valid = "above 0 and below 1";
        return Err(ModelError::range("fraction of frames", fraction, valid).into());
    }
    if scenario.chain.is_off(Part::Render) {
        let valid = "absent: what a wider margin costs is the time its frames take";
        return Err(ModelError::range("chain.off", Part::Render, valid).into());
    }
    let recording = recording(scenario)?;
    let mut turn = Scenario {
        render_time: RenderTime::Cost,
        ..scenario.clone()
    };
    let mut steps: Vec<MarginStep> = Vec::new();
    let mut margin_deg = 0.0;
    while steps.len() < MOST_STEPS && margin_deg <= WIDEST_DEG {
        turn.spec = ScenarioSpec {
            margin_deg,
            ..turn.spec
        };
        let meter = Meter::new(PlanCost::new(&turn, turn.featured())?);
        let (mut errors, mut ages) = (Vec::new(), Vec::new());
        replay_each(
            &recording,
            &turn.display,
            &turn.tracker,
            &meter,
            &turn.replay,
            |frame| {
                if frame.state == GazeState::Tracked {
                    errors.extend(frame.gaze_error_deg());
                    ages.extend(frame.gaze_age().map(Nanos::as_ms));
                }
            },
        )?;
        if errors.is_empty() {
            let valid = "some that the tracker follows and whose true gaze is known";
            return Err(ModelError::range("displayed frames", "none", valid).into());
        }
        errors.sort_by(f64::total_cmp);
        let needed_deg = quantile_sorted(&errors, fraction);
        steps.push(MarginStep {
            margin_deg,
            samples: meter.samples.get() as f64 / meter.frames.get() as f64,
            render_ms: meter.time.get().as_ms() / meter.frames.get() as f64,
            gaze_age_ms: foveasim_models::math::mean(&ages),
            needed_deg,
        });
        if (needed_deg - margin_deg).abs() <= MARGIN_TOLERANCE_DEG {
            return Ok(MarginLoop {
                steps,
                closed: true,
            });
        }
        margin_deg = needed_deg;
    }
    Ok(MarginLoop {
        steps,
        closed: false,
    })
}

impl MarginLoop {
    /// One row per turn.
    pub fn table(&self) -> Table {
        let mut table = Table::new([
            "margin_deg",
            "samples_per_frame",
            "render_ms",
            "gaze_age_ms",
            "needed_margin_deg",
        ]);
        for s in &self.steps {
            table.push(vec![
                s.margin_deg.into(),
                s.samples.into(),
                s.render_ms.into(),
                s.gaze_age_ms.into(),
                s.needed_deg.into(),
            ]);
        }
        table
    }
}

/// Adds up what frames cost.
struct Meter {
    cost: PlanCost,
    frames: Cell<u64>,
    samples: Cell<u64>,
    time: Cell<Nanos>,
}

impl Meter {
    fn new(cost: PlanCost) -> Self {
        Self {
            cost,
            frames: Cell::new(0),
            samples: Cell::new(0),
            time: Cell::new(Nanos::ZERO),
        }
    }
}

impl FrameCost for Meter {
    fn duration(&self, frame: &FrameInput) -> Nanos {
        let work = self.cost.work(frame);
        let time = self.cost.time(&work);
        self.frames.set(self.frames.get() + 1);
        self.samples
            .set(self.samples.get() + work.samples_shaded as u64);
        self.time.set(self.time.get() + time);
        time
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scenario(fraction_render: &str) -> Scenario {
        ScenarioSpec {
            method: "layers:3".into(),
            sync: "vsync-free".into(),
            render_time: fraction_render.into(),
            ..ScenarioSpec::default()
        }
        .resolve()
        .unwrap()
    }

    #[test]
    fn the_loop_closes_and_every_turn_costs_more() {
        let found = close_margin(&scenario("refresh"), 0.95).unwrap();
        assert!(found.closed, "{found:?}");
        let (first, last) = (found.steps[0], *found.steps.last().unwrap());
        assert_eq!(first.margin_deg, 0.0);
        assert!((last.needed_deg - last.margin_deg).abs() <= MARGIN_TOLERANCE_DEG);
        assert!(last.margin_deg > 0.1 && last.samples > first.samples);
        assert!(last.render_ms > first.render_ms);
        assert_eq!(found.table().rows().len(), found.steps.len());
        // What a frame costs does not depend on the render time that the scenario asks of others.
        assert_eq!(close_margin(&scenario("3"), 0.95).unwrap(), found);
    }

    #[test]
    fn fractions_that_are_none() {
        for fraction in [0.0, 1.0, -0.5, f64::NAN] {
            assert!(close_margin(&scenario("refresh"), fraction).is_err());
        }
    }

    #[test]
    fn no_loop_without_rendering() {
        let mut off = scenario("refresh");
        off.chain = off.chain.without(Part::Render);
        let error = close_margin(&off, 0.95).unwrap_err().to_string();
        assert!(error.contains("chain.off = render"), "{error}");
    }
}
