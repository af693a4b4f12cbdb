//! Plans a display that does not exist yet: how many samples does three-layer foveation need on it?

#![expect(clippy::print_stdout, reason = "an example talks to its reader")]

use foveasim::models::foveation::{Method, Request};
use foveasim::models::{Display, ModelError, presets};

fn main() -> Result<(), ModelError> {
    let text = "name = 'wide'\nhmd = { fov_deg = [60, 45, 50, 50], panel_px = [2800, 2800] }\n\
                scan = { refresh_hz = 90 }";
    let display = Display::try_from(presets::parse_display(text, "wide")?)?;
    let method: Method = "layers:3".parse()?;
    for panel in &display.eyes {
        let count = method.plan(&Request::ahead(panel))?.count();
        println!(
            "{:?}: {} samples, {:.1} times fewer",
            panel.eye,
            count.samples(),
            count.ratio()
        );
    }
    Ok(())
}
