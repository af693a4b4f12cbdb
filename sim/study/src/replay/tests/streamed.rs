//! What is read as it is needed, beside what is kept.

use foveasim_models::Rate;
use foveasim_pipeline::HeadSampling;
use foveasim_traces::{ReadOptions, SynthSpec};

use super::*;

/// A recording written to a file, replayed from memory and from the file.
fn both_ways(name: &str, text: &str, options: &ReplayOptions, display: &str) -> [Replay; 2] {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    let display = presets::display(display).unwrap();
    let tracker = presets::tracker("quest-pro").unwrap();
    let cost = FixedCost(Nanos::from_ms(6.0));
    let reading = ReadOptions::default();
    let whole = foveasim_traces::read_path(&path, &reading).unwrap();
    let passing = StreamedRecording::open(&path, &reading).unwrap().unwrap();
    assert_eq!(passing.span(), whole.span());
    assert_eq!(passing.notes, whole.notes);
    let kept = replay(&whole, &display, &tracker, &cost, options).unwrap();
    let mut frames = Vec::new();
    let run = replay_streamed(&passing, &display, &tracker, &cost, options, |f| {
        frames.push(f);
    });
    let run = run.unwrap();
    let streamed = Replay {
        frames,
        dark_scans: run.dark_scans,
        start: run.start,
        counts: run.counts,
        notes: run.notes,
    };
    [kept, streamed]
}

#[test]
fn what_passes_by_is_replayed_as_what_is_kept() {
    let spec = SynthSpec {
        duration: Nanos(6_000 * MS),
        blinks_per_minute: 60.0,
        ..SynthSpec::default()
    };
    let mut truth = Vec::new();
    foveasim_traces::write(&foveasim_traces::synth(&spec).unwrap(), &mut truth).unwrap();
    let truth = String::from_utf8(truth).unwrap();
    let late = "tracker_output delay_ns=20000000";
    let reported = truth.replace("_provenance: truth", &format!("_provenance: {late}"));
    // Half a minute in which nothing was recorded.
    let mut hole = truth.clone();
    for line in truth.lines().filter(|line| !line.starts_with(['#', 't'])) {
        let (t, rest) = line.split_once(',').unwrap();
        hole += &format!("{},{rest}\n", t.parse::<i64>().unwrap() + 36_000 * MS);
    }
    let sampled = HeadSampling {
        rate: Some(Rate::from_hz("head", 40.0).unwrap()),
        delay: Nanos(30 * MS),
    };
    for text in [&truth, &reported, &hole] {
        for display in ["lg-w2363d", "quest-pro"] {
            for sync in SyncMode::ALL {
                for (gaze_mode, head) in [
                    (GazeMode::Tracked, HeadSampling::default()),
                    (GazeMode::Fixed, sampled),
                ] {
                    let options = ReplayOptions {
                        sync,
                        gaze_mode,
                        head,
                        ..Default::default()
                    };
                    let [kept, streamed] = both_ways("t.csv", text, &options, display);
                    assert!(kept.frames.len() > 300);
                    assert_eq!(kept, streamed, "{display} {sync} {gaze_mode:?}");
                }
            }
        }
    }
}

#[test]
fn the_session_that_is_read_passes_by() {
    // GazeBase has one session; JuDo1000 several in one file, of which the longest is read.
    let mut judo = String::from("time\tx_left\ty_left\tx_right\ty_right\ttrialId\n");
    for (session, rows) in [(1, 200), (2, 600), (3, 300)] {
        for k in 0..rows {
            let x = 600 + session * 10 + k / 10;
            judo += &format!("{k}\t{x}\t500\t{x}\t500\t{session}\n");
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("judo.csv");
    std::fs::write(&path, judo).unwrap();
    let reading = ReadOptions::default();
    let Ok(whole) = foveasim_traces::read_path(&path, &reading) else {
        panic!("{:?}", foveasim_traces::read_path(&path, &reading));
    };
    let passing = StreamedRecording::open(&path, &reading).unwrap().unwrap();
    assert_eq!(passing.notes, whole.notes);
    let gaze = whole.gaze.unwrap();
    assert_eq!(gaze.samples().len(), 600);
    let mut reader = passing.reader().unwrap();
    for sample in gaze.samples() {
        assert_eq!(
            reader.next_row().unwrap().unwrap().gaze.as_ref(),
            Some(sample)
        );
    }
    assert_eq!(reader.next_row().unwrap(), None);
    assert_eq!(passing.gaze.unwrap(), (&gaze).into());
}
