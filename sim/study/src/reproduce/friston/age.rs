//! §7, Fig. 16: how old a picture becomes while it is scanned, if it does not roll.

use foveasim_models::{Durations, Nanos, PixelResponse, Rate, presets};
use foveasim_pipeline::{FrameStart, Runtime, SyncMode};

use super::ReproduceError;
use crate::{Band, Chain, LatencyStudy, Quantity, Rows};

/// Time of the paper's frame, and of its scan \[ms\].
pub(super) const RENDER_MS: f64 = 1.0;
const SCAN_MS: f64 = 16.0;

/// From the head's pose to the light of the last row, in the best case \[ms\]: a frame that is started just in time for its
/// scan, without blanking, pixels that switch at once.
///
/// # Errors
/// None that the embedded presets can cause.
pub(super) fn of_last_row_ms() -> Result<f64, ReproduceError> {
    let mut display = presets::display("lg-w2363d")?;
    display.scan.rate = Rate::from_hz("refresh_hz", 1e3 / SCAN_MS)?;
    display.response = PixelResponse::default();
    let rows = display.scan.rows;
    let render = Nanos::from_ms(RENDER_MS);
    let chain = Chain {
        render: Durations::fixed(render),
        runtime: Runtime {
            start: FrameStart::JustInTime { reserve: render },
            ..Runtime::default()
        },
        ..Chain::new(display, presets::tracker("tx300")?, SyncMode::Vsync)
    };
    let whole = Band {
        top: 0,
        gaze: rows - 1,
        bottom: rows,
    };
    let bounds = LatencyStudy::of(chain, Some(whole))?.bounds();
    Ok(bounds[Quantity::Motion(Rows::Last).index()].min.as_ms())
}
