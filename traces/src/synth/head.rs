use foveasim_models::math::{sin, sqrt, to_rad};
use foveasim_models::{Nanos, Pose, PoseSeries, Role, Stream};
use glam::{DQuat, DVec3};

use super::SynthSpec;

/// Sines per axis.
const SINES: usize = 5;
/// Slowest and fastest of them \[Hz\]; voluntary head movement lies mostly below 1 Hz.
const BAND_HZ: [f64; 2] = [0.05, 0.8];

/// The head that the eyes hold their targets against.
#[derive(Debug)]
pub(crate) enum Head<'a> {
    /// A synthetic one.
    Path(&'a HeadPath),
    /// A recording; times count from its start.
    Recorded(&'a PoseSeries),
}

impl Head<'_> {
    pub(crate) fn at(&self, t: Nanos) -> Pose {
        match self {
            Self::Path(path) => path.at(t),
            Self::Recorded(series) => super::recorded(series, t).unwrap_or(Pose::IDENTITY),
        }
    }
}

/// Head motion as a sum of sines per axis: smooth in every derivative, and known at any time.
///
/// Frequencies are spread evenly in the logarithm over [`BAND_HZ`] with a random shift inside each
/// share; amplitudes fall as 1/f, so that each sine has the same peak velocity. Yaw, pitch and roll
/// apply in this order (about +Y, then +X, then +Z of the turned frame).
#[derive(Debug, Clone)]
pub(crate) struct HeadPath {
    /// Yaw, pitch, roll \[deg\], then x, y, z \[m\].
    axes: [[Sine; SINES]; 6],
}

#[derive(Debug, Clone, Copy, Default)]
struct Sine {
    amplitude: f64,
    radians_per_second: f64,
    phase: f64,
}

impl HeadPath {
    pub(crate) fn new(spec: &SynthSpec) -> Self {
        let (yaw, sway) = (spec.head_yaw_deg, spec.head_sway_m);
        let rms = [yaw, 0.4 * yaw, 0.2 * yaw, sway, 0.5 * sway, sway];
        let mut stream = Stream::new(spec.seed, Role::SynthHead, 0);
        Self {
            axes: rms.map(|rms| sines(rms, &mut stream)),
        }
    }

    pub(crate) fn at(&self, t: Nanos) -> Pose {
        let t = t.as_secs();
        let value = |axis: usize| -> f64 {
            self.axes[axis]
                .iter()
                .map(|s| s.amplitude * sin(s.radians_per_second * t + s.phase))
                .sum()
        };
        let turn = |axis: DVec3, deg: f64| {
            let half = 0.5 * to_rad(deg);
            let (s, c) = (sin(half), foveasim_models::math::cos(half));
            DQuat::from_xyzw(axis.x * s, axis.y * s, axis.z * s, c)
        };
        let orientation =
            turn(DVec3::Y, value(0)) * turn(DVec3::X, value(1)) * turn(DVec3::Z, value(2));
        Pose::new(
            DVec3::new(value(3), value(4), value(5)),
            orientation.normalize(),
        )
    }
}

fn sines(rms: f64, stream: &mut Stream) -> [Sine; SINES] {
    use foveasim_models::math::{log, pow};
    let octaves = log(BAND_HZ[1] / BAND_HZ[0]);
    let mut sines = [Sine::default(); SINES];
    for (i, sine) in sines.iter_mut().enumerate() {
        let share = (i as f64 + stream.uniform()) / SINES as f64;
        let hz = BAND_HZ[0] * pow(std::f64::consts::E, octaves * share);
        let radians_per_second = 2.0 * std::f64::consts::PI * hz;
        let phase = 2.0 * std::f64::consts::PI * stream.uniform();
        *sine = Sine {
            amplitude: 1.0 / hz,
            radians_per_second,
            phase,
        };
    }
    // The mean square of a sum of sines of different frequencies is half the sum of their squares.
    let power: f64 = sines.iter().map(|s| 0.5 * s.amplitude * s.amplitude).sum();
    for sine in &mut sines {
        sine.amplitude *= rms / sqrt(power);
    }
    sines
}
