use serde::{Deserialize, Serialize};

use super::{Emission, PixelResponse, ScanClock, ScanDirection};
use crate::error::in_range;
use crate::{ModelError, Nanos, Rate};

/// How a picture gets from the buffer to light, as people write it (TOML).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScanSpec {
    /// Refreshes per second \[Hz\], from 1 to 10,000.
    pub refresh_hz: f64,
    /// Visible lines and lines in all, blanking included; without it there is no blanking.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lines: Option<[u32; 2]>,
    /// Lines of the blanking that come before the picture; the rest come after it.
    #[serde(default, skip_serializing_if = "is_default")]
    pub lines_before: u32,
    /// Time from one row to the next \[µs\]; given instead of `lines`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub row_us: Option<f64>,
    /// From which edge to which rows are scanned; columns, to the right or left.
    #[serde(default, skip_serializing_if = "is_default")]
    pub direction: ScanDirection,
    /// Whether the two eyes are scanned together or one after the other, the left one first.
    #[serde(default, skip_serializing_if = "is_default")]
    pub eyes: EyeOrder,
    /// Whole frames that the display holds before it scans them, from 0 to 4.
    #[serde(default, skip_serializing_if = "is_default")]
    pub buffered_frames: u32,
    /// Rolling or global.
    #[serde(default)]
    pub emission: Emission,
    /// With global emission: from the end of the scan, pixels switched, until the light goes on \[ms\].
    #[serde(default, skip_serializing_if = "is_default")]
    pub strobe_delay_ms: f64,
    /// How long a picture gives light \[ms\]; 0 until the next one does.
    #[serde(default, skip_serializing_if = "is_default")]
    pub persistence_ms: f64,
    /// Which light counts: the first, or the middle of its persistence.
    #[serde(default, skip_serializing_if = "is_default")]
    pub light: LightAt,
    /// Time for a pixel to switch, as its source defines switching \[ms\].
    #[serde(default)]
    pub response_ms: f64,
    /// How a pixel switches, instead of `response_ms`: points \[ms, fraction\] from \[0, 0\] on, both
    /// growing; linear in between.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub response_curve: Vec<[f64; 2]>,
    /// The fraction of the curve at which a pixel counts as switched, above 0.
    #[serde(default = "ninety_percent", skip_serializing_if = "is_ninety_percent")]
    pub response_fraction: f64,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

fn ninety_percent() -> f64 {
    0.9
}

fn is_ninety_percent(fraction: &f64) -> bool {
    *fraction == ninety_percent()
}

/// When the two eyes of a headset are scanned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EyeOrder {
    /// Both at once.
    #[default]
    Together,
    /// The left one in the first half of the picture's time, the right one in the second.
    Sequence,
}

/// Which light a latency is counted to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LightAt {
    /// The first.
    #[default]
    First,
    /// The middle of the time for which a picture gives light (its persistence, which must be given).
    Middle,
}

/// The most lines of a display, blanking included.
const MOST_LINES: u32 = 1_000_000;
/// The most frames that a display holds: Guenter 2012, footnote 6, knows of four.
const MOST_BUFFERED: u32 = 4;

/// Checks how many frames a display holds.
pub(super) fn buffered(frames: u32) -> Result<u32, ModelError> {
    match frames {
        0..=MOST_BUFFERED => Ok(frames),
        _ => {
            let valid = format!("0 to {MOST_BUFFERED} frames");
            Err(ModelError::range("buffered_frames", frames, valid))
        }
    }
}

impl ScanSpec {
    /// The clock of the first eye, when its rows give light, and how the eyes follow each other.
    pub(super) fn build(
        &self,
        panel_px: [u32; 2],
        eyes: usize,
    ) -> Result<(ScanClock, PixelResponse), ModelError> {
        in_range("scan.refresh_hz", self.refresh_hz, 1.0..=10_000.0)?;
        let rate = Rate::from_hz("scan.refresh_hz", self.refresh_hz)?;
        let rows = panel_px[usize::from(!self.direction.across())];
        let [active_lines, mut total_lines] = self.lines(rate, rows, eyes)?;
        let mut lines_before = self.lines_before;
        if lines_before > total_lines - active_lines {
            let valid = format!("at most {} lines of blanking", total_lines - active_lines);
            return Err(ModelError::range("scan.lines_before", lines_before, valid));
        }
        let mut lines_to_end = lines_before + active_lines;
        match (self.eyes, eyes) {
            (EyeOrder::Sequence, 2) => {
                lines_to_end *= 2;
                // Each eye has half of the picture's lines: counted in halves, they stay whole.
                (total_lines, lines_before) = (2 * total_lines, 2 * lines_before);
            }
            (EyeOrder::Sequence, _) => {
                let valid = "`together`: it shows both eyes one image";
                return Err(ModelError::range("scan.eyes", "sequence", valid));
            }
            (EyeOrder::Together, _) => {}
        }
        let clock = ScanClock {
            rate,
            rows,
            active_lines,
            total_lines,
            lines_before,
            lines_to_end,
            direction: self.direction,
            buffered_frames: buffered(self.buffered_frames)?,
        };
        Ok((clock, self.response()?))
    }

    /// Lines with picture, and in all.
    fn lines(&self, rate: Rate, rows: u32, eyes: usize) -> Result<[u32; 2], ModelError> {
        if let Some(row_us) = self.row_us {
            let at_once = match (self.eyes, eyes) {
                (EyeOrder::Sequence, 2) => 2,
                _ => 1,
            };
            let longest = rate.period().0 as f64 / 1e3 / f64::from(rows) / f64::from(at_once);
            if self.lines.is_some() || !(row_us > 0.0 && row_us <= longest) {
                let valid = format!("above 0, at most {longest} (a refresh), and without `lines`");
                return Err(ModelError::range("scan.row_us", row_us, valid));
            }
            // Lines of a nanosecond each.
            let active = libm::round(row_us * 1e3 * f64::from(rows) * f64::from(at_once));
            return Ok([(active as u32).max(1), rate.period().0 as u32]);
        }
        let [active, total] = self.lines.unwrap_or([1, 1]);
        if active == 0 || total < active || total > MOST_LINES {
            let value = format!("[{active}, {total}]");
            let valid = "[active, total], 0 < active ≤ total";
            return Err(ModelError::range("scan.lines", value, valid));
        }
        Ok([active, total])
    }

    fn response(&self) -> Result<PixelResponse, ModelError> {
        in_range("scan.response_ms", self.response_ms, 0.0..=10_000.0)?;
        in_range("scan.persistence_ms", self.persistence_ms, 0.0..=1_000.0)?;
        in_range("scan.strobe_delay_ms", self.strobe_delay_ms, 0.0..=1_000.0)?;
        if self.light == LightAt::Middle && self.persistence_ms == 0.0 {
            let valid = "`first`, or a `persistence_ms` above 0 to take the middle of";
            return Err(ModelError::range("scan.light", "middle", valid));
        }
        if self.strobe_delay_ms > 0.0 && self.emission == Emission::Rolling {
            let (value, valid) = (self.strobe_delay_ms, "0 with rolling emission");
            return Err(ModelError::range("scan.strobe_delay_ms", value, valid));
        }
        let middle = match self.light {
            LightAt::First => 0.0,
            LightAt::Middle => self.persistence_ms / 2.0,
        };
        Ok(PixelResponse {
            settle: Nanos::from_ms(self.settle_ms()?),
            emission: self.emission,
            strobe_delay: Nanos::from_ms(self.strobe_delay_ms),
            to_counted_light: Nanos::from_ms(middle),
        })
    }

    /// When a pixel has switched: of a curve, where it first reaches the fraction.
    fn settle_ms(&self) -> Result<f64, ModelError> {
        let (curve, fraction) = (&self.response_curve, self.response_fraction);
        if curve.is_empty() {
            if !is_ninety_percent(&fraction) {
                let valid = "absent without a `response_curve`, which it is a fraction of";
                return Err(ModelError::range("scan.response_fraction", fraction, valid));
            }
            return Ok(self.response_ms);
        }
        let growing = curve
            .windows(2)
            .all(|w| w[0][0] < w[1][0] && w[0][1] <= w[1][1]);
        let within = curve
            .iter()
            .all(|[t, f]| (0.0..=10_000.0).contains(t) && (0.0..=1.0).contains(f));
        if curve[0] != [0.0, 0.0] || !growing || !within || self.response_ms != 0.0 {
            let valid = "points [ms, fraction] from [0, 0] on, both growing, and no `response_ms`";
            let shown = curve.iter().take(8).collect::<Vec<_>>();
            return Err(ModelError::range(
                "scan.response_curve",
                format!("{shown:?}"),
                valid,
            ));
        }
        let reached = curve[curve.len() - 1][1];
        let crossed = curve.windows(2).find(|w| w[1][1] >= fraction);
        match crossed {
            Some([[t0, f0], [t1, f1]]) if fraction > 0.0 => {
                Ok(t0 + (t1 - t0) * (fraction - f0).max(0.0) / (f1 - f0))
            }
            _ => {
                let valid = format!("above 0, at most {reached}, which the curve reaches");
                Err(ModelError::range("scan.response_fraction", fraction, valid))
            }
        }
    }
}

#[cfg(test)]
mod tests;
