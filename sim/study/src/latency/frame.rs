use foveasim_models::Nanos;
use foveasim_pipeline::{BoundKind, Interval, Movement, Runtime, StageBounds, SyncMode};

use super::band::Edges;
use super::{LatencyStudy, QUANTITIES, Quantity};

/// What all runs of a study share.
pub(super) struct Frame {
    /// Of gaze and of motion.
    pub(super) bounds: [StageBounds; 2],
    /// Of every quantity, and whether they are reached.
    pub(super) all: Vec<Interval>,
    pub(super) kinds: Vec<BoundKind>,
    pub(super) edges: Edges,
    /// Longest time between exposures, and between ticks of the host's clock.
    pub(super) exposures: Nanos,
    pub(super) host_period: Nanos,
    /// What the loop needs, from its start, to run as it always does.
    pub(super) settling: Nanos,
    /// What it does in turns lasts this long; 0 if it does not.
    pub(super) turn: Nanos,
    /// By then every quantity has been seen.
    pub(super) end: Nanos,
}

/// The most frames for which a loop is given time to settle: a queue that frames fill more slowly
/// than that is as good as empty.
const MOST_SETTLING: i64 = 64;

/// Of a longer turn that frames in flight take, runs begin anywhere in so many refreshes.
const LONGEST_TURN: i64 = 256;

impl Frame {
    pub(super) fn new(study: &LatencyStudy) -> Self {
        let chain = &study.chain;
        let gaze = study.stage_bounds(Movement::Gaze);
        let head = study.stage_bounds(chain.head_movement());
        let edges = study.edges();
        let longest = gaze.total().max.max(head.total().max);
        let of = |q: &Quantity| if q.is_motion() { &head } else { &gaze };
        let all = QUANTITIES
            .iter()
            .map(|q| q.bounds(of(q), &edges, chain.sync));
        let kinds = QUANTITIES.iter().map(|q| q.bound_kind(of(q), &edges));
        let (render, period) = (chain.render.max(), -chain.host_rate.tick(-1));
        // Reading input later moves no frame: runs with and without a latch begin alike.
        let at_once = Runtime {
            gaze_latch: Nanos::ZERO,
            pose_latch: Nanos::ZERO,
            ..chain.runtime
        };
        let settling = match at_once == Runtime::default() {
            true => Nanos::ZERO,
            // A free host fills its queue by what each frame takes too long.
            false if chain.sync != SyncMode::Vsync && render > period => {
                let ahead = i64::from(chain.runtime.in_flight);
                let frames = ahead * render.0 / (render - period).0 + ahead;
                render * frames.min(MOST_SETTLING)
            }
            false => gaze.host_cycle * 4 + gaze.refresh * 4 + gaze.settling,
        };
        Self {
            all: all.collect(),
            kinds: kinds.collect(),
            turn: gaze.turn.min(gaze.refresh * LONGEST_TURN),
            edges,
            exposures: -chain.tracker.rate.tick(-1),
            // A host at the display's rate may be given the display's own rounding.
            host_period: match chain.host_rate == chain.display.scan.rate {
                true => gaze.refresh,
                false => period,
            },
            settling,
            // The last answer comes at most two scans after the first flip, plus the end of its scan.
            end: longest + gaze.refresh * 4,
            bounds: [gaze, head],
        }
    }
}
