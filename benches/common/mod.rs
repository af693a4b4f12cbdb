//! What benches that are programs of their own have in common: arguments and clocks.

#![allow(dead_code, reason = "each bench uses some of it")]

use std::str::FromStr;
use std::time::{Duration, Instant};

use glam::UVec2;

/// Arguments: `--flag` or `--flag value`; others (`cargo` passes some) are passed over.
pub(crate) struct Args(Vec<String>);

impl Args {
    /// This process's.
    pub(crate) fn new() -> Self {
        Self(std::env::args().collect())
    }

    /// Whether `flag` is there.
    pub(crate) fn has(&self, flag: &str) -> bool {
        self.0.iter().any(|a| a == flag)
    }

    /// What follows `flag`.
    pub(crate) fn text(&self, flag: &str) -> Option<&str> {
        let at = self.0.iter().position(|a| a == flag)?;
        self.0.get(at + 1).map(String::as_str)
    }

    /// What follows `flag`, understood.
    pub(crate) fn value<T: FromStr>(&self, flag: &str) -> Option<T> {
        self.text(flag)?.parse().ok()
    }

    /// `--size 1920x1080`.
    pub(crate) fn size(&self) -> Option<UVec2> {
        let (width, height) = self.text("--size")?.split_once('x')?;
        Some(UVec2::new(width.parse().ok()?, height.parse().ok()?))
    }

    /// Time that passes; with `--cpu-time` (Linux), the processor time of all threads: on a machine that does other
    /// things, too, it is far less noisy. With one thread (`RAYON_NUM_THREADS=1`) the two mean the same.
    pub(crate) fn clock(&self) -> Clock {
        Clock {
            began: Instant::now(),
            of_processors: self.has("--cpu-time"),
        }
    }
}

/// What `--cpu-time` chooses.
pub(crate) struct Clock {
    began: Instant,
    of_processors: bool,
}

impl Clock {
    /// Since some fixed moment.
    pub(crate) fn now(&self) -> Duration {
        match self.of_processors {
            true => processor_time(),
            false => self.passed(),
        }
    }

    /// Since the clock was made, whatever it measures.
    pub(crate) fn passed(&self) -> Duration {
        self.began.elapsed()
    }
}

/// Time that this process's threads have run (the first number of each `schedstat`, in nanoseconds).
fn processor_time() -> Duration {
    let threads = std::fs::read_dir("/proc/self/task").expect("--cpu-time needs Linux");
    let of_thread = |entry: std::io::Result<std::fs::DirEntry>| {
        // A thread may end meanwhile.
        let text = std::fs::read_to_string(entry.ok()?.path().join("schedstat")).ok()?;
        text.split(' ').next()?.parse::<u64>().ok()
    };
    Duration::from_nanos(threads.filter_map(of_thread).sum())
}

/// The middle one of `values`, the upper one of two.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
