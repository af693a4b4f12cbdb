//! §4.2: what each part of the antialiasing does to flicker, on consecutive frames of the fly-through.

use foveasim_assets::Scene;
use foveasim_models::Acuity;
use foveasim_quality::Rings;
use foveasim_render::RenderOptions;

use super::shooter::{Antialiasing, Flight, Shooter};
use super::{ReproduceError, layers};
use crate::temporal::FrameSource;
use crate::{TemporalQuality, TemporalStudy, Tracks, supersampled};

/// Samples along each side of a pixel of the reference.
pub(super) const REFERENCE: u32 = 8;

/// The first judged frame: objects near and far, ground and sky are in view.
const FIRST: u64 = 1500;

/// Frames drawn before the judged ones: history has settled by then.
const WARM_UP: u64 = 16;

/// Every part on and off, in pictures that draw every layer in every frame; then all parts as the
/// study had them, middle and outer layer taking turns.
fn ways() -> [(&'static str, Antialiasing, bool); 7] {
    let parts = |msaa, jitter, reproject| Antialiasing {
        msaa,
        jitter,
        reproject,
    };
    [
        ("none", parts(false, false, false), false),
        ("MSAA", parts(true, false, false), false),
        ("jitter", parts(false, true, false), false),
        ("reprojection", parts(false, false, true), false),
        ("jitter + reprojection", parts(false, true, true), false),
        (
            "MSAA + jitter + reprojection",
            parts(true, true, true),
            false,
        ),
        ("all three, layers taking turns", Antialiasing::ALL, true),
    ]
}

/// Draws `frames` consecutive frames by layers at quality A with each part on and off, and judges them
/// against 8 × 8 samples to the pixel. `done` hears of every frame.
pub(super) fn antialiasing(
    flight: &Flight,
    scene: &Scene,
    frames: u32,
    done: &mut dyn FnMut(),
) -> Result<Vec<TemporalQuality>, ReproduceError> {
    let method = flight.prepare(layers()?, Acuity::default())?;
    let range = FIRST..FIRST + u64::from(frames);
    let middle_frame = (FIRST + u64::from(frames / 2)) as u32;
    let middle = flight.gaze(middle_frame);
    let study = TemporalStudy {
        viewport: flight.viewport,
        gaze: middle.vector(),
        rings: Rings::default(),
        frames: range,
        warm_up: WARM_UP,
    };
    let source = |(name, parts, turns): (&str, Antialiasing, bool)| {
        let shooter = Shooter::new(flight, scene, method.clone(), parts);
        let mut shooter = if turns {
            shooter
        } else {
            shooter.in_every_frame()
        };
        let draw: FrameSource<'_, ReproduceError> =
            Box::new(move |frame| Ok(shooter.draw(frame as u32)?.image));
        (name.to_owned(), draw)
    };
    let mut sources = ways().map(source);
    let options = RenderOptions::default();
    let mut reference = |frame: u64| {
        let view = flight.view(frame as u32);
        Ok(supersampled(scene, &view, REFERENCE, &options)?)
    };
    let tracks = Tracks::new(scene, &flight.view(middle_frame), &options)?;
    let mut places = |frame: u64| Ok(tracks.places(scene, &flight.view(frame as u32))?);
    study.run(&mut reference, &mut places, &mut sources, done)
}
