use foveasim_models::{Nanos, Rate};

use crate::Setup;

/// One nanosecond of one micro-hertz.
pub(super) const PERIOD_OF_A_MICRO_HZ: i128 = 1_000_000_000_000_000;

/// Times in units of which a nanosecond, a refresh and a period of the host's clock have whole numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Unit {
    /// Units in a nanosecond.
    pub(super) ns: i128,
    /// Units in a refresh.
    pub(super) refresh: i128,
    /// Units in a period of the host's clock.
    pub(super) period: i128,
}

impl Unit {
    pub(super) fn of(setup: &Setup<'_>) -> Self {
        Self::of_rates(setup.host_rate, setup.scan.rate)
    }

    pub(super) fn of_rates(host: Rate, display: Rate) -> Self {
        let [host, display] = [host, display].map(|r| i128::from(r.micro_hz()));
        let common = greatest_common_divisor(host, display);
        Self {
            ns: host / common * display,
            refresh: PERIOD_OF_A_MICRO_HZ * (host / common),
            period: PERIOD_OF_A_MICRO_HZ * (display / common),
        }
    }

    pub(super) fn of_nanos(&self, t: Nanos) -> i128 {
        i128::from(t.0) * self.ns
    }

    /// Whether ticks of both clocks are whole numbers of nanoseconds: none is rounded.
    pub(super) fn is_whole(&self) -> bool {
        self.refresh % self.ns == 0 && self.period % self.ns == 0
    }

    pub(super) fn down(&self, t: i128) -> Nanos {
        Nanos(t.div_euclid(self.ns) as i64)
    }

    pub(super) fn up(&self, t: i128) -> Nanos {
        -self.down(-t)
    }
}

pub(super) fn greatest_common_divisor(a: i128, b: i128) -> i128 {
    match b {
        0 => a,
        _ => greatest_common_divisor(b, a % b),
    }
}
