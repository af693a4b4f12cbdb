//! The test that a team keeps in its own CI: a recording replayed through display and tracker must give
//! the same frames as the day its result was accepted. As a test, put the body of `main` in a `#[test]`
//! and your recording and digest in the repository.

#![expect(clippy::print_stdout, reason = "an example talks to its reader")]

use foveasim::models::{FixedCost, presets};
use foveasim::study::{ReplayOptions, replay};
use foveasim::traces::{SynthSpec, synth};

/// Accepted on purpose, after looking at what changed; never updated by a script.
const ACCEPTED: &str = "6cf9839c44b17688db8a0535dd2ffa54e07163ab0d7a104226c99d69b7e12bb3";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // In your repository: traces::read_path("recording.csv", &ReadOptions::default()).
    let recording = synth(&SynthSpec {
        seed: 7,
        ..SynthSpec::default()
    })?;
    let (display, tracker) = (
        presets::display("quest-pro")?,
        presets::tracker("quest-pro")?,
    );
    let cost = FixedCost(display.scan.rate.period());
    let replayed = replay(
        &recording,
        &display,
        &tracker,
        &cost,
        &ReplayOptions::default(),
    )?;

    let table = replayed.table();
    println!(
        "{} displayed frames, digest {}",
        replayed.frames.len(),
        table.digest()
    );
    assert_eq!(
        table.digest(),
        ACCEPTED,
        "what is displayed has changed:\n{}",
        table.csv()
    );

    // Digests say that something changed; limits say whether it matters.
    let error = replayed
        .summary()
        .gaze_error_deg
        .ok_or("the recording has no gaze")?;
    assert!(error.p50 < 2.0, "median gaze error {} degrees", error.p50);
    Ok(())
}
