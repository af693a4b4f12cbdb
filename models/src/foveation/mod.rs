//! Foveation methods, one file each: (display, acuity, gaze, settings) → [`SamplePlan`](crate::SamplePlan).
//!
//! Every method answers two questions. [`Method::plan`] says exactly which samples are drawn for one
//! image, in whole numbers; [`Method::estimate`] says how many it needs in closed form, where pixel
//! counts may be fractions, which is what papers print and what a display that does not exist yet
//! can be planned with. [`ideal_samples`] is the floor both are compared with.
//!
//! ```
//! use foveasim_models::foveation::{Method, Request};
//! use foveasim_models::presets;
//!
//! let display = presets::display("lg-w2363d")?;
//! let method: Method = "layers:3".parse()?;
//! let plan = method.plan(&Request::ahead(display.primary()))?;
//! assert!(plan.count().ratio() > 8.0);
//! # Ok::<(), foveasim_models::ModelError>(())
//! ```

mod aim;
mod cells;
mod cover;
mod design;
mod dominance;
mod estimate;
mod fdm;
mod floor;
mod kernel;
mod kernel_search;
mod kfr;
mod lattice;
mod layers;
mod lens_search;
mod lms;
mod method;
mod mosaic;
mod need;
mod optimise;
mod place;
mod plan_cache;
mod prepared;
mod quad;
mod quadrature;
mod radial;
mod rates;
mod request;
mod screen;
mod settings;
mod text;
mod tiles;
mod vrs;

pub use aim::Aim;
pub use cover::Coverage;
pub use design::{LayerDesign, LayerSpec};
pub use dominance::{DominanceSettings, dominance_speedup};
pub use estimate::{Estimate, PassEstimate};
pub use floor::{FloorDensity, IDEAL_RELATIVE_ERROR, ideal_samples};
pub use kernel::{KernelForm, KernelSettings};
pub use kernel_search::{FoundKernel, KernelSearch};
pub use lens_search::{FoundLens, LensSearch};
pub use lms::LensMatchedSettings;
pub use method::Method;
pub use place::Place;
pub use plan_cache::PlanCache;
pub use prepared::Prepared;
pub use quad::{Focus, QuadSettings};
pub(crate) use quadrature::{adaptive, gauss};
pub use radial::RadialSettings;
pub use rates::RatesSettings;
pub use request::Request;
pub use screen::Screen;
pub use settings::{Blending, LayersSettings, MAX_LAYERS, Weights};
pub use tiles::TileSettings;
