//! Clocks, which libraries do not read.

use std::time::Duration;

/// Whether [`processor_time`] is the processor's; else it is the time that passes.
pub(crate) const OF_PROCESSORS: bool = cfg!(unix);

/// Time that the processor has spent on this program, all its threads together: what other programs do meanwhile
/// is not in it.
#[cfg(unix)]
pub(crate) fn processor_time() -> Duration {
    use rustix::time::{ClockId, clock_gettime};
    let time = clock_gettime(ClockId::ProcessCPUTime);
    // Neither is negative.
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// Time that passes, where no other is to be had.
#[cfg(not(unix))]
pub(crate) fn processor_time() -> Duration {
    use std::sync::OnceLock;
    use std::time::Instant;
    static BEGAN: OnceLock<Instant> = OnceLock::new();
    BEGAN.get_or_init(Instant::now).elapsed()
}

/// Runs `work` on a pool of one thread, so that processor time is that of the work alone: no thread waits for another.
pub(crate) fn on_one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> anyhow::Result<T> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    Ok(pool.install(work))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_takes_time() {
        let began = processor_time();
        let mut sum = 0_u64;
        while processor_time() < began + Duration::from_millis(2) {
            sum = std::hint::black_box(sum + 1);
        }
        assert!(sum > 0);
        assert_eq!(on_one_thread(rayon::current_num_threads).unwrap(), 1);
    }
}
