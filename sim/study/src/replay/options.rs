use foveasim_models::{GazeMode, HeadPredictor, Nanos, Rate};
use foveasim_pipeline::{HeadSampling, Runtime, SyncMode};

/// How a recording is replayed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReplayOptions {
    /// How host and display are coupled.
    pub sync: SyncMode,
    /// Whether the fovea follows the eye, or stays at the centre.
    pub gaze_mode: GazeMode,
    /// How the head pose is predicted.
    pub predictor: HeadPredictor,
    /// How head poses reach the host.
    pub head: HeadSampling,
    /// Gaze older than this when a frame starts is given up, and the fovea goes to the centre.
    /// `None`: the pipeline's default.
    pub gaze_max_age: Option<Nanos>,
    /// How frames are paced, latched and composed.
    pub runtime: Runtime,
    /// How often a free-running host starts a frame; `None`: at the display's rate.
    pub host_rate: Option<Rate>,
    /// Seed of the clocks' phases, the tracker's processing times and its noise.
    pub seed: u64,
}

impl Default for ReplayOptions {
    fn default() -> Self {
        Self {
            sync: SyncMode::Vsync,
            gaze_mode: GazeMode::Tracked,
            predictor: HeadPredictor::AngularVelocity,
            head: HeadSampling::default(),
            gaze_max_age: None,
            runtime: Runtime::default(),
            host_rate: None,
            seed: 1,
        }
    }
}
