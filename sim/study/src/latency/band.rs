use foveasim_models::{Display, Emission, Nanos, PixelResponse};

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
        if gaze > rows {
            return error("gaze row", gaze.to_string(), format!("from 0 to {rows}"));
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

    pub(super) fn edges(self, display: &Display) -> Edges {
        let at = |row| display.scan.row_offset(row);
        Edges {
            top: at(self.top),
            gaze: at(self.gaze),
            bottom: at(self.bottom),
            active: display.scan.active(),
            response: display.response,
        }
    }
}

/// A [`Band`] in time: when after the vertical blank each boundary is scanned.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edges {
    pub(super) top: Nanos,
    pub(super) gaze: Nanos,
    pub(super) bottom: Nanos,
    pub(super) active: Nanos,
    pub(super) response: PixelResponse,
}

impl Edges {
    /// When what is scanned `offset` after the vertical blank is lit, from the vertical blank on.
    pub(super) fn lit(&self, offset: Nanos) -> Nanos {
        self.response.settle
            + match self.response.emission {
                Emission::Rolling => offset,
                Emission::Global => self.active,
            }
    }
}
