//! §4.2: what each part of the antialiasing does to flicker, on consecutive frames of the fly-through.

use foveasim_assets::Scene;
use foveasim_models::Acuity;
use foveasim_quality::Rings;
use foveasim_render::RenderOptions;

use super::shooter::{Antialiasing, Flight, Shooter};
use super::{ReproduceError, layers};
use crate::temporal::FrameSource;
use crate::{TemporalQuality, TemporalStudy, supersampled};

/// Samples along each side of a pixel of the reference.
pub(super) const REFERENCE: u32 = 8;

/// The first judged frame: objects near and far, ground and sky are in view.
const FIRST: u64 = 1500;

/// Frames drawn before the judged ones: history has settled by then.
const WARM_UP: u64 = 16;

/// Every part on and off.
const PARTS: [(&str, Antialiasing); 6] = {
    let none = Antialiasing {
        msaa: false,
        jitter: false,
        reproject: false,
    };
    [
        ("none", none),
        ("MSAA", Antialiasing::MSAA),
        (
            "jitter",
            Antialiasing {
                jitter: true,
                ..none
            },
        ),
        (
            "reprojection",
            Antialiasing {
                reproject: true,
                ..none
            },
        ),
        (
            "jitter + reprojection",
            Antialiasing {
                msaa: false,
                ..Antialiasing::ALL
            },
        ),
        ("MSAA + jitter + reprojection", Antialiasing::ALL),
    ]
};

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
    let middle = flight.gaze((FIRST + u64::from(frames / 2)) as u32);
    let study = TemporalStudy {
        viewport: flight.viewport,
        gaze: middle.vector(),
        rings: Rings::default(),
        frames: range,
        warm_up: WARM_UP,
    };
    let source = |(name, parts): (&str, Antialiasing)| {
        let mut shooter = Shooter::new(flight, scene, method.clone(), parts);
        let draw: FrameSource<'_, ReproduceError> =
            Box::new(move |frame| Ok(shooter.draw(frame as u32)?.image));
        (name.to_owned(), draw)
    };
    let mut sources = PARTS.map(source);
    let options = RenderOptions::default();
    let mut reference = |frame: u64| {
        let view = flight.view(frame as u32);
        Ok(supersampled(scene, &view, REFERENCE, &options)?)
    };
    study.run(&mut reference, &mut sources, done)
}
