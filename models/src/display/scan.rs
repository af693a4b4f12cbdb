use serde::{Deserialize, Serialize};

use crate::error::in_range;
use crate::{ModelError, Nanos, Rate};

/// How a picture gets from the buffer to light, as people write it (TOML).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScanSpec {
    /// Refreshes per second \[Hz\], from 1 to 10,000.
    pub refresh_hz: f64,
    /// Visible lines and lines in all, blanking included; without it there is no blanking.
    pub lines: Option<[u32; 2]>,
    /// Rolling or global.
    #[serde(default)]
    pub emission: Emission,
    /// Time for a pixel to switch, as its source defines switching \[ms\].
    #[serde(default)]
    pub response_ms: f64,
}

/// When rows give light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Emission {
    /// Each row as it is scanned.
    #[default]
    Rolling,
    /// All rows together, once the last one has been scanned and has switched.
    Global,
}

/// When each row is scanned: row `r` of refresh `k` at `tick(k) + r/rows · active/total · period`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanClock {
    /// Refresh rate.
    pub rate: Rate,
    /// Rows of the panel.
    pub rows: u32,
    /// Lines that carry picture.
    pub active_lines: u32,
    /// Lines in all, blanking included.
    pub total_lines: u32,
}

/// When a scanned row becomes light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelResponse {
    /// Time for a pixel to switch, to the fraction its source states.
    pub settle: Nanos,
    /// Rolling or global.
    pub emission: Emission,
}

impl ScanClock {
    /// Time from the start of a refresh to boundary `row` (0 = top edge, `rows` = bottom edge),
    /// rounded down to a nanosecond.
    pub fn row_offset(&self, row: u32) -> Nanos {
        // One rounding, of the exact rational, so that rows keep their order and their sum.
        self.rate.part_of_period(
            u64::from(row) * u64::from(self.active_lines),
            u64::from(self.rows) * u64::from(self.total_lines),
        )
    }

    /// Time from the first row's start to the last row's end.
    pub fn active(&self) -> Nanos {
        self.row_offset(self.rows)
    }
}

impl ScanSpec {
    pub(super) fn build(&self, rows: u32) -> Result<(ScanClock, PixelResponse), ModelError> {
        let [active_lines, total_lines] = self.lines.unwrap_or([1, 1]);
        if active_lines == 0 || total_lines < active_lines || total_lines > 1_000_000 {
            let value = format!("[{active_lines}, {total_lines}]");
            return Err(ModelError::range(
                "scan.lines",
                value,
                "[active, total], 0 < active ≤ total",
            ));
        }
        in_range("scan.response_ms", self.response_ms, 0.0..=10_000.0)?;
        in_range("scan.refresh_hz", self.refresh_hz, 1.0..=10_000.0)?;
        let rate = Rate::from_hz("scan.refresh_hz", self.refresh_hz)?;
        let clock = ScanClock {
            rate,
            rows,
            active_lines,
            total_lines,
        };
        let settle = Nanos::from_ms(self.response_ms);
        Ok((
            clock,
            PixelResponse {
                settle,
                emission: self.emission,
            },
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_the_study_display() {
        let rate = Rate::from_hz("f", 120.0).unwrap();
        let clock = ScanClock {
            rate,
            rows: 1080,
            active_lines: 1,
            total_lines: 1,
        };
        assert_eq!(clock.row_offset(640), Nanos(4_938_271));
        assert_eq!(clock.active(), rate.period());
    }

    #[test]
    fn rows_of_the_slowest_rate() {
        // 0.001 Hz: no display has it, but a clock can be made of it.
        let clock = ScanClock {
            rate: Rate::from_hz("f", 0.001).unwrap(),
            rows: 4,
            active_lines: 9,
            total_lines: 10,
        };
        let rows: Vec<_> = (0..=4).map(|row| clock.row_offset(row).as_secs()).collect();
        assert_eq!(rows, [0.0, 225.0, 450.0, 675.0, 900.0]);
    }

    #[test]
    fn rows_are_rounded_once() {
        // A third of a second in 10⁹ rows: row r begins r/3 ns after the blank. Of a period that was
        // rounded before, each third row would begin a nanosecond early.
        let clock = ScanClock {
            rate: Rate::from_hz("f", 3.0).unwrap(),
            rows: 1_000_000_000,
            active_lines: 1,
            total_lines: 1,
        };
        for row in [2, 3, 4, 9, 999_999_999, 1_000_000_000] {
            assert_eq!(clock.row_offset(row), Nanos(i64::from(row / 3)), "{row}");
        }
    }

    #[test]
    fn refresh_rates_that_no_display_has() {
        let spec = |refresh_hz| ScanSpec {
            refresh_hz,
            lines: None,
            emission: Emission::Rolling,
            response_ms: 0.0,
        };
        for hz in [1.0, 10_000.0] {
            assert!(spec(hz).build(1080).is_ok(), "{hz}");
        }
        for hz in [0.0, 0.001, 0.999, 10_000.1, -60.0, f64::NAN, f64::INFINITY] {
            let error = spec(hz).build(1080).unwrap_err().to_string();
            let want = format!("scan.refresh_hz = {hz}: must be a number from 1 to 10000");
            assert_eq!(error, want);
        }
    }
}
