use foveasim_models::{Nanos, PixelResponse, ScanClock};

use super::LatencyError;

/// The rows a study looks at: the inner layer, and the row gazed at. Rows are boundaries: 0 is the top
/// edge of the picture, `rows` its bottom edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Band {
    /// Upper edge of the inner layer.
    pub top: u32,
    /// The row gazed at.
    pub gaze: u32,
    /// Lower edge of the inner layer.
    pub bottom: u32,
}

/// Height of the inner layer over the height of the picture: 200 of 1080 lines (Guenter 2012, Fig. 5).
const INNER_LAYER: f64 = 200.0 / 1080.0;

impl Band {
    /// The study's inner layer about row `gaze` of a display with `rows` rows, cut off at its edges.
    pub fn about(gaze: u32, rows: u32) -> Self {
        let half = ((f64::from(rows) * INNER_LAYER / 2.0).round() as u32).max(1);
        let bottom = gaze.saturating_add(half).min(rows);
        Self {
            top: gaze.saturating_sub(half),
            gaze,
            bottom,
        }
    }

    /// Checks that the band is not empty, on a display of `rows` rows, and holds the gaze.
    ///
    /// # Errors
    /// Names the edge that is wrong.
    pub(super) fn check(self, rows: u32) -> Result<(), LatencyError> {
        let Self { top, gaze, bottom } = self;
        let error = |field, value: String, valid| {
            Err(LatencyError::OutOfRange {
                field,
                value,
                valid,
            })
        };
        if gaze >= rows {
            let valid = format!("from 0 to {}", rows.saturating_sub(1));
            return error("gaze row", gaze.to_string(), valid);
        }
        if top >= bottom || bottom > rows {
            let valid = format!("FIRST..END with 0 ≤ FIRST < END ≤ {rows}");
            return error("band of rows", format!("{top}..{bottom}"), valid);
        }
        if !(top..=bottom).contains(&gaze) {
            return error(
                "gaze row",
                gaze.to_string(),
                format!("in the band {top}..{bottom}"),
            );
        }
        Ok(())
    }

    /// When the band's boundaries are scanned by `clock`.
    pub(super) fn edges(self, clock: ScanClock, response: PixelResponse) -> Edges {
        let at = |row| clock.row_offset(row);
        let (top, bottom) = (at(self.top), at(self.bottom));
        Edges {
            first: top.min(bottom),
            gaze: at(self.gaze),
            last: top.max(bottom),
            row: self.gaze,
            clock,
            response,
        }
    }
}

/// A [`Band`] in time: when after the vertical blank each boundary is scanned, from the edge that is
/// scanned first.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edges {
    pub(super) first: Nanos,
    pub(super) gaze: Nanos,
    pub(super) last: Nanos,
    /// The row gazed at.
    pub(super) row: u32,
    clock: ScanClock,
    pub(super) response: PixelResponse,
}

impl Edges {
    /// When what is scanned `offset` after the vertical blank is lit, from the vertical blank on.
    pub(super) fn lit(&self, offset: Nanos) -> Nanos {
        self.clock.lit_after_blank(&self.response, offset)
    }
}
