//! The reference renderer: any sample plan of any scene on the CPU, with exact counts of the work.
//!
//! ```text
//! scene + view + plan ─► levels of detail ─► vertices ─► set-up ─► bins ─► tile: visibility ─► tile: shading ─► pass
//!                        (by the pass's      (once for   (clip,    (64×64   (blocks of 4×2,     (each surface    │
//!                         own samples)        a view)     cull)     samples) hierarchical z)     seen, once)     │
//!                        image ◄── resolve ◄── history (in a [`Sequence`]) ◄──────────────────────────────────────┘
//! ```
//!
//! * [`render`] draws a frame; [`Frame`] holds the image, the passes it was made of and their [`Work`].
//! * Coverage is decided in integers on vertices snapped to 1/256 of a sample, with the top-left rule:
//!   triangles that share an edge cover each sample along it exactly once.
//! * Depth is 1/w in single precision, larger is nearer; of equal depths the triangle that comes
//!   first in the scene wins.
//! * [`trace`] finds the same by casting rays, sample for sample.
//! * Shading comes after visibility: each surface seen in a sample is shaded once, where several positions
//!   of it see the same triangle ([`Msaa`]) or several samples share a shading ([`Shading::Coarse`]) too.
//! * Samples outside a pass's [`Region`] are neither tested nor shaded.
//! * A [`Map`] may put samples anywhere on the display: their positions are rounded to the grid that vertices are
//!   snapped to, and coverage is as exact as elsewhere.
//! * A [`View`] may be scanned while eye, instances and vertices move, and be seen through a lens: each sample then looks at
//!   its own place and time, and triangles move ([`Bound`] says which samples are tested against them).
//! * [`render_stereo`] draws both eyes of a head, and does once what is the same for both.
//! * A [`Sequence`] draws frame after frame: samples move within their cells, are blended with what was
//!   seen of the same surface before, and passes are drawn in the frames of their cadence.
//! * What the picture does not need is left out, and can be done all the same to see what that saves:
//!   [`Skip`].
//! * The same input gives the same bytes for any number of threads and any vector width: kernels use
//!   only + − × ÷ √, comparison and selection, and the scalar level runs the same source.
//!
//! The project's `docs/renderer.md` says what is exact, what is bounded and what every counter means.
//!
//! # Simplifications
//!
//! * While a display is scanned, vertices move on straight lines.
//! * Passes whose samples do not lie evenly have no history in a [`Sequence`].
//! * [`render`] draws every pass afresh, whatever its cadence; a [`Sequence`] knows what the frames before
//!   have drawn.
//! * One sun and a sky, no transparency or normal maps; shadows where [`Lighting`] asks for them.
//! * [`GridWarp`] moves a drawn image instead of drawing it anew: a baseline.
//! * With MSAA, a surface is shaded in the middle of its sample even where it is seen only beside it.
//! * Motion is that of cameras and rigid instances. What a material shows is taken not to move on it, so
//!   reflections are found again where the surface is, not where they are.
//!
//! [`View`]: foveasim_models::View
//! [`Work`]: foveasim_models::Work
//! [`Msaa`]: foveasim_models::Msaa
//! [`Shading::Coarse`]: foveasim_models::Shading::Coarse
//! [`Region`]: foveasim_models::Region
//! [`Map`]: foveasim_models::Map

mod bvh;
mod check;
mod chromatic;
mod error;
mod feather;
mod fragments;
mod frame;
mod gather;
mod group;
mod inverse;
mod kernels;
mod lighting;
mod live;
mod memory;
mod mosaic;
mod moving;
mod msaa;
mod occlusion;
mod options;
mod pass;
mod passes;
mod placed;
mod placement;
mod project;
mod raster;
mod resolve;
mod shadow;
mod shared;
mod stereo;
mod temporal;
mod texels;
mod tile;
mod trace;
mod visible;
mod warp;

pub use check::LARGEST_SIDE;
pub use chromatic::separate_colours;
pub use error::RenderError;
pub use frame::{Frame, assemble, render, render_into};
pub use lighting::{Focus, Lighting, Occlusion, Shadows};
pub use memory::FrameMemory;
pub use moving::{Bound, BoundCounts, TriangleCount, bound_counts, sample_looks};
pub use options::{RenderOptions, Simd, Skip};
pub use pass::{Surfel, visibility, visibility_at};
pub use stereo::{StereoFrame, StereoShared, render_stereo};
pub use temporal::{Clamp, Interpolation, Sequence, TemporalOptions, jitter};
pub use trace::trace;
pub use warp::{GridWarp, Seen, Warped, inverse_depths};
