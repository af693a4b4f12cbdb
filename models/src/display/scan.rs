use serde::{Deserialize, Serialize};

use super::EyeOrder;
use crate::{Nanos, Rate};

/// In which direction rows (or columns) are scanned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ScanDirection {
    /// Rows, the top one first.
    #[default]
    Down,
    /// Rows, the bottom one first.
    Up,
    /// Columns, the left one first.
    Right,
    /// Columns, the right one first.
    Left,
}

impl ScanDirection {
    /// Whether columns are scanned, not rows.
    pub fn across(self) -> bool {
        matches!(self, Self::Right | Self::Left)
    }

    fn backwards(self) -> bool {
        matches!(self, Self::Up | Self::Left)
    }
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

/// When each row is scanned: row `r` of refresh `k` at
/// `tick(k) + (before + r/rows · active)/total · period`, counted from the edge where the scan begins.
///
/// Where columns are scanned, they are its rows.
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
    /// Lines before the first one that carries picture.
    pub lines_before: u32,
    /// Lines until the picture of all eyes is complete.
    pub lines_to_end: u32,
    /// From which edge to which.
    pub direction: ScanDirection,
    /// Whole frames that the display holds before it scans them.
    pub buffered_frames: u32,
}

/// When a scanned row becomes light.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PixelResponse {
    /// Time for a pixel to switch, to the fraction its source states.
    pub settle: Nanos,
    /// Rolling or global.
    pub emission: Emission,
    /// With global emission: from the end of the scan, pixels switched, until the light goes on.
    pub strobe_delay: Nanos,
    /// From the first light to the light that counts: 0, or half the persistence.
    pub to_counted_light: Nanos,
}

impl ScanClock {
    /// Rows from top to bottom without buffering, `lines` = \[active, total\], blanking after them.
    pub fn new(rate: Rate, rows: u32, [active_lines, total_lines]: [u32; 2]) -> Self {
        Self {
            rate,
            rows,
            active_lines,
            total_lines,
            lines_before: 0,
            lines_to_end: active_lines,
            direction: ScanDirection::Down,
            buffered_frames: 0,
        }
    }

    /// Time from the start of a refresh to boundary `row` (0 = top or left edge, `rows` = bottom or
    /// right edge), rounded down to a nanosecond.
    pub fn row_offset(&self, row: u32) -> Nanos {
        let scanned = match self.direction.backwards() {
            true => self.rows.saturating_sub(row),
            false => row,
        };
        // One rounding, of the exact rational, so that rows keep their order and their sum.
        self.rate.part_of_period(
            u64::from(self.rows) * u64::from(self.lines_before)
                + u64::from(scanned) * u64::from(self.active_lines),
            u64::from(self.rows) * u64::from(self.total_lines),
        )
    }

    /// Time from the start of a refresh to the end of the row scanned last.
    pub fn active(&self) -> Nanos {
        self.row_offset(match self.direction.backwards() {
            true => 0,
            false => self.rows,
        })
    }

    /// Time from the start of a refresh until the picture of all eyes has been scanned.
    pub fn picture_end(&self) -> Nanos {
        let (lines, total) = (self.lines_to_end.into(), self.total_lines.into());
        self.rate.part_of_period(lines, total)
    }

    /// From the start of a refresh of the panel until a row gives the light that counts, if it is
    /// scanned `offset` after that start.
    pub fn lit_after_blank(&self, response: &PixelResponse, offset: Nanos) -> Nanos {
        let switched = match response.emission {
            Emission::Rolling => offset + response.settle,
            Emission::Global => self.picture_end() + response.settle + response.strobe_delay,
        };
        switched + response.to_counted_light
    }

    /// The clock of the second eye, where the first one's is this.
    #[must_use]
    pub(super) fn of_eye(self, index: usize, order: EyeOrder) -> Self {
        match (order, index) {
            (EyeOrder::Sequence, 1) => Self {
                lines_before: self.lines_before + self.active_lines,
                ..self
            },
            _ => self,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_the_study_display() {
        let rate = Rate::from_hz("f", 120.0).unwrap();
        let clock = ScanClock::new(rate, 1080, [1, 1]);
        assert_eq!(clock.row_offset(640), Nanos(4_938_271));
        assert_eq!(clock.active(), rate.period());
    }

    #[test]
    fn rows_of_the_slowest_rate() {
        // 0.001 Hz: no display has it, but a clock can be made of it.
        let clock = ScanClock::new(Rate::from_hz("f", 0.001).unwrap(), 4, [9, 10]);
        let rows: Vec<_> = (0..=4).map(|row| clock.row_offset(row).as_secs()).collect();
        assert_eq!(rows, [0.0, 225.0, 450.0, 675.0, 900.0]);
    }

    #[test]
    fn rows_are_rounded_once() {
        // A third of a second in 10⁹ rows: row r begins r/3 ns after the blank. Of a period that was
        // rounded before, each third row would begin a nanosecond early.
        let clock = ScanClock::new(Rate::from_hz("f", 3.0).unwrap(), 1_000_000_000, [1, 1]);
        for row in [2, 3, 4, 9, 999_999_999, 1_000_000_000] {
            assert_eq!(clock.row_offset(row), Nanos(i64::from(row / 3)), "{row}");
        }
    }
}
