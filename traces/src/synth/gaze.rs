use foveasim_models::math::{cos, exp, hypot, log, sin};
use foveasim_models::{GazeDirection, Nanos, Role, Stream};

use super::SynthSpec;
use super::head::Head;

/// Standard deviation of the logarithm of fixation durations; with it a tenth last over twice the
/// median, the skew that free viewing has (lognormal as in, e.g., Nuthmann 2017).
const FIXATION_LOG_SD: f64 = 0.45;
/// Shortest and longest fixation, relative to the mean.
const FIXATION_LIMITS: [f64; 2] = [0.3, 5.0];
/// Standard deviation of slow drift, each axis \[deg/s\] (Rolfs 2009: below 0.5 °/s for most).
const DRIFT_DEG_PER_S: f64 = 0.25;
/// Tremor's amplitude \[deg\] and frequencies per axis \[Hz\] (Martinez-Conde et al. 2004: about the
/// width of a cone, 0.008°, near 90 Hz).
const TREMOR_DEG: f64 = 0.004;
const TREMOR_HZ: [f64; 2] = [83.0, 91.0];
/// Smallest saccade \[deg\].
const MIN_SACCADE_DEG: f64 = 0.5;
/// Shortest and longest blink \[ms\].
const BLINK_MS: [f64; 2] = [100.0, 200.0];
/// How far the eyes follow a target beyond the field, while the head turns, before they let go.
const HOLD: f64 = 1.25;

/// Duration of a saccade of `amplitude_deg`: the main sequence, 2.2 ms/° · A + 21 ms (Carpenter 1988).
///
/// With the minimum-jerk profile used here the peak velocity is 1.875 · A / duration: 436 °/s at 10°.
pub(crate) fn saccade_ms(amplitude_deg: f64) -> f64 {
    2.2 * amplitude_deg + 21.0
}

/// Share of a minimum-jerk movement done at share `s` of its time (Flash & Hogan 1985, Eq. 5):
/// velocity and acceleration are zero at both ends.
fn minimum_jerk(s: f64) -> f64 {
    s * s * s * (10.0 + s * (6.0 * s - 15.0))
}

/// Gaze as fixations and saccades, relative to a moving head.
///
/// During a fixation the target stands still in the world (a vestibulo-ocular reflex of gain one and
/// no delay) apart from slow drift, so the eyes turn against the head. Saccades go straight in azimuth
/// and elevation. Out of scope: smooth pursuit, microsaccades, glissades, vergence, head movement that
/// helps large gaze shifts.
#[derive(Debug, Clone)]
pub(crate) struct GazePath {
    stream: Stream,
    blinks: Blinks,
    field: [f64; 2],
    fixation_log_mean: f64,
    fixation_ms: f64,
    amplitude_deg: f64,
    tremor_phase: [f64; 2],
    fixation: Fixation,
    /// The saccade before `fixation`.
    saccade: Saccade,
}

#[derive(Debug, Clone, Copy)]
struct Fixation {
    start: Nanos,
    end: Nanos,
    target: GazeDirection,
    drift_deg_per_s: [f64; 2],
}

#[derive(Debug, Clone, Copy)]
struct Saccade {
    start: Nanos,
    from: GazeDirection,
}

impl GazePath {
    pub(crate) fn new(spec: &SynthSpec, head: &Head<'_>) -> Self {
        let mut stream = Stream::new(spec.seed, Role::SynthGaze, 0);
        let turn = 2.0 * std::f64::consts::PI;
        let tremor_phase = [turn * stream.uniform(), turn * stream.uniform()];
        // The mean of a lognormal distribution is exp(μ + σ²/2).
        let fixation_log_mean = log(spec.fixation_ms) - 0.5 * FIXATION_LOG_SD * FIXATION_LOG_SD;
        let none = Fixation {
            start: Nanos::ZERO,
            end: Nanos::ZERO,
            target: GazeDirection::AHEAD,
            drift_deg_per_s: [0.0; 2],
        };
        let mut path = Self {
            stream,
            blinks: Blinks::new(spec),
            field: spec.field_deg,
            fixation_log_mean,
            fixation_ms: spec.fixation_ms,
            amplitude_deg: spec.amplitude_deg,
            tremor_phase,
            fixation: none,
            saccade: Saccade {
                start: Nanos::ZERO,
                from: GazeDirection::AHEAD,
            },
        };
        path.fixation = path.fixate(Nanos::ZERO, GazeDirection::AHEAD, head);
        path
    }

    /// Gaze at `t`, which must not decrease from call to call; `None` during a blink.
    pub(crate) fn at(&mut self, t: Nanos, head: &Head<'_>) -> Option<GazeDirection> {
        while t >= self.fixation.end {
            self.advance(head);
        }
        let place = if t < self.fixation.start {
            let length = self.fixation.start - self.saccade.start;
            let share = (t - self.saccade.start).0 as f64 / length.0 as f64;
            self.saccade
                .from
                .interpolate(self.fixation.target, minimum_jerk(share))
        } else {
            held(&self.fixation, t, head)
        };
        let tremor = |axis: usize| {
            let turns = TREMOR_HZ[axis] * t.as_secs();
            TREMOR_DEG * sin(2.0 * std::f64::consts::PI * turns + self.tremor_phase[axis])
        };
        let gaze = GazeDirection::new(
            place.azimuth_deg + tremor(0),
            place.elevation_deg + tremor(1),
        );
        (!self.blinks.closed(t)).then_some(gaze)
    }

    /// The next saccade and the fixation after it.
    fn advance(&mut self, head: &Head<'_>) {
        let start = self.fixation.end;
        let from = held(&self.fixation, start, head);
        let to = self.next_target(from);
        let amplitude = hypot(
            to.azimuth_deg - from.azimuth_deg,
            to.elevation_deg - from.elevation_deg,
        );
        self.saccade = Saccade { start, from };
        self.fixation = self.fixate(start + Nanos::from_ms(saccade_ms(amplitude)), to, head);
    }

    fn fixate(&mut self, start: Nanos, target: GazeDirection, head: &Head<'_>) -> Fixation {
        let [low, high] = FIXATION_LIMITS.map(|x| x * self.fixation_ms);
        let ms =
            exp(self.fixation_log_mean + FIXATION_LOG_SD * self.stream.normal()).clamp(low, high);
        let drift = [
            DRIFT_DEG_PER_S * self.stream.normal(),
            DRIFT_DEG_PER_S * self.stream.normal(),
        ];
        let mut fixation = Fixation {
            start,
            end: start + Nanos::from_ms(ms),
            target,
            drift_deg_per_s: drift,
        };
        // A head that turns far carries the target out of reach: the fixation ends there.
        let step = Nanos::from_ms(10.0);
        let mut t = start + Nanos::from_ms(low);
        while t < fixation.end {
            if !inside(held(&fixation, t, head), self.field.map(|half| HOLD * half)) {
                fixation.end = t;
            }
            t += step;
        }
        fixation
    }

    /// A target inside the field: exponential amplitude, any direction, horizontal ones preferred.
    fn next_target(&mut self, from: GazeDirection) -> GazeDirection {
        const TRIES: usize = 64;
        for _ in 0..TRIES {
            let amplitude = MIN_SACCADE_DEG - self.amplitude_deg * log(1.0 - self.stream.uniform());
            let angle = 2.0 * std::f64::consts::PI * self.stream.uniform();
            // Squeezing the circle of directions by half prefers horizontal saccades two to one.
            let (x, y) = (cos(angle), 0.5 * sin(angle));
            let scale = amplitude / hypot(x, y);
            let to =
                GazeDirection::new(from.azimuth_deg + scale * x, from.elevation_deg + scale * y);
            if inside(to, self.field) {
                return to;
            }
        }
        // From outside the field no small saccade may reach it; the way back is straight ahead.
        GazeDirection::AHEAD
    }
}

fn inside(gaze: GazeDirection, [half_width, half_height]: [f64; 2]) -> bool {
    gaze.azimuth_deg.abs() <= half_width && gaze.elevation_deg.abs() <= half_height
}

/// Where the eye points at `t` of a fixation: at what was its target in the world, plus drift.
fn held(fixation: &Fixation, t: Nanos, head: &Head<'_>) -> GazeDirection {
    let target = head.at(fixation.start).direction(fixation.target.vector());
    let gaze = GazeDirection::from_vector(head.at(t).orientation.conjugate() * target);
    let age = (t - fixation.start).as_secs();
    let [x, y] = fixation.drift_deg_per_s;
    GazeDirection::new(gaze.azimuth_deg + x * age, gaze.elevation_deg + y * age)
}

/// Blinks at exponential intervals.
#[derive(Debug, Clone)]
struct Blinks {
    stream: Stream,
    per_second: f64,
    start: Nanos,
    end: Nanos,
}

impl Blinks {
    fn new(spec: &SynthSpec) -> Self {
        let stream = Stream::new(spec.seed, Role::SynthGaze, 1);
        let per_second = spec.blinks_per_minute / 60.0;
        let mut blinks = Self {
            stream,
            per_second,
            start: Nanos::MAX,
            end: Nanos::ZERO,
        };
        if per_second > 0.0 {
            blinks.next();
        }
        blinks
    }

    fn next(&mut self) {
        let wait = -log(1.0 - self.stream.uniform()) / self.per_second;
        self.start = self.end + Nanos::from_secs(wait.min(1e6));
        self.end = self.start + Nanos::from_ms(self.stream.range(BLINK_MS[0], BLINK_MS[1]));
    }

    fn closed(&mut self, t: Nanos) -> bool {
        while self.per_second > 0.0 && t >= self.end {
            self.next();
        }
        t >= self.start
    }
}
