//! What eyes, displays, trackers and foveation methods *are*: data and closed-form maths.
//!
//! Nothing here knows what time it is, reads a file, starts a thread or touches a pixel; the other
//! crates do that with the types defined here. The central ones:
//!
//! * [`Display`] and [`Viewport`]: a planar or head-mounted display, and one eye's image plane;
//! * [`Acuity`]: the minimum angle of resolution against eccentricity (Guenter 2012, Eq. 1);
//! * [`SamplePlan`]: where a foveation method puts its samples, as data that can be counted and drawn;
//! * [`View`]: everything a renderer must know about one image;
//! * [`Series`]: gaze and head pose over time, with explicit missing samples;
//! * [`Work`], [`FrameCost`]: what a frame did, and how long that takes.
//!
//! # Conventions
//!
//! World and head frames are right-handed, metres, +X right, +Y up, −Z forward (as in OpenXR).
//! A pose `world_from_head` maps head coordinates to world coordinates, so names compose like
//! matrices. Pixels are counted from the top-left corner, x right, y down, centres at +0.5.
//! Angles are degrees where the name says `_deg`; times are [`Nanos`].
//!
//! # Simplifications
//!
//! Eyes rotate about the point they see from (no centre-of-rotation offset); acuity depends on
//! eccentricity alone (no meridian asymmetry, contrast or motion); lenses are ideal unless a display
//! says otherwise.

mod acuity;
mod color;
mod cost;
mod density;
mod display;
mod durations;
mod energy;
mod error;
pub mod foveation;
mod gaze;
mod geometry;
pub mod math;
mod outline;
mod plan;
mod predict;
pub mod presets;
pub mod raster;
mod rng;
mod series;
mod tracker;
mod units;
mod view;
mod work;

pub use acuity::{Acuity, OMEGA_0_DEG, QUALITY_INDEX_DEG, SLOPE_A, SLOPE_B};
pub use color::{Image, linear_from_srgb, srgb8_from_linear};
pub use cost::{
    CostForm, CostProfile, DrawnCost, FixedCost, FrameCost, FrameInput, FrameWork, MeasuredCost,
};
pub use density::{FitTarget, FitWeight, GaussianFit, RayDensity};
pub use display::{
    Display, DisplaySpec, Emission, EyeOrder, EyePanel, Geometry, HmdSpec, Lens, LensSpec, LightAt,
    PixelDensity, PixelResponse, PlanarSpec, ScanClock, ScanDirection, ScanSkew, ScanSpec,
};
pub use durations::Durations;
pub use energy::EnergyProfile;
pub use error::{ModelError, closest, toml_error, unknown_name};
pub use gaze::{GazeDirection, GazeMode};
pub use geometry::{Pose, Rect, exp_so3, log_so3};
pub use outline::{OutlineSketch, SeriesOutline};
pub use plan::{
    Affine, Cadence, CellMask, Falloff, FalloffTable, Feather, Filter, Interpolation, Lattice,
    LensMatched, LogPolar, Map, Msaa, Pass, PassCount, PlanCount, Radial, Reach, Region, Resolve,
    SamplePlan, Shading, ShadingRate, Spacing, Spans, TileRates, Visibility,
};
pub use predict::{HeadPredictor, HeadTracker, KalmanNoise, Motion, Twist};
pub use rng::{Role, Stream};
pub use series::{
    GazeSeries, Interpolate, PoseSeries, Provenance, Recording, Sample, Series, SeriesError,
};
pub use tracker::{BiasMap, BiasMapSpec, Loss, LossSpec, Losses, Tracker, TrackerSpec};
pub use units::{Nanos, Rate, Ticks};
pub use view::{Eye, View, Viewport};
pub use work::Work;
