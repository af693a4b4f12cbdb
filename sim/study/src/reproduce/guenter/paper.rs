//! What Guenter et al. 2012 publish, as printed.

/// A column of Table 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Column {
    /// I: foveated at the settings of the informal study (in a supplement; its pixel count is the paper's).
    Informal,
    /// Q_A: foveated at quality A.
    QualityA,
    /// Q_B: foveated at quality B.
    QualityB,
    /// N₀: full resolution without any antialiasing.
    Plain,
    /// N₁: full resolution with MSAA.
    Msaa,
    /// N₂: full resolution with MSAA, jitter and reprojection: the reference of the user study.
    Reference,
}

/// The columns of Table 1, left to right.
pub(super) const COLUMNS: [Column; 6] = [
    Column::Informal,
    Column::QualityA,
    Column::QualityB,
    Column::Plain,
    Column::Msaa,
    Column::Reference,
];

impl Column {
    /// As printed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Informal => "I",
            Self::QualityA => "Q_A",
            Self::QualityB => "Q_B",
            Self::Plain => "N0",
            Self::Msaa => "N1",
            Self::Reference => "N2",
        }
    }
}

/// Times of Table 1 \[ms\]: rows of less and less content, in the order of
/// [`StudyContent::ALL`](foveasim_assets::StudyContent::ALL); columns as [`COLUMNS`].
pub(super) const TABLE_1_MS: [[f64; 6]; 6] = [
    [4.5, 4.9, 5.9, 23.6, 27.7, 27.9],
    [2.6, 2.8, 3.2, 6.6, 9.2, 9.6],
    [0.8, 0.8, 0.9, 1.0, 1.4, 1.6],
    [0.8, 0.8, 0.8, 0.4, 0.5, 0.7],
    [0.6, 0.5, 0.6, 0.3, 0.4, 0.5],
    [0.3, 0.3, 0.3, 0.3, 0.4, 0.3],
];

/// A marked point of Fig. 10, its values from the text of §6.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mark {
    /// The column of Table 1 that it stands in.
    pub(super) column: Column,
    /// Quality index j (§5); the informal study's is in a supplement.
    pub(super) j: Option<f64>,
    /// Display pixels over pixels rendered, middle and outer layer counted half.
    pub(super) pixels: f64,
    /// Time of N₂ over time of the column.
    pub(super) time: f64,
}

/// The marked points of Fig. 10 (§6).
pub(super) const MARKS: [Mark; 3] = [
    Mark {
        column: Column::Informal,
        j: None,
        pixels: INFORMAL_PIXELS,
        time: 6.2,
    },
    Mark {
        column: Column::QualityA,
        j: Some(12.0),
        pixels: 13.3,
        time: 5.7,
    },
    Mark {
        column: Column::QualityB,
        j: Some(15.0),
        pixels: 9.8,
        time: 4.8,
    },
];

/// "About 15" times fewer pixels at the settings of the informal study (§6). The settings are in a
/// supplement; here the column stands for the quality index at which the layers save this much.
pub(super) const INFORMAL_PIXELS: f64 = 15.0;

/// A bar of Fig. 5.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LatencyBar {
    /// What takes time.
    pub(super) name: &'static str,
    /// In the best case \[ms\].
    pub(super) best_ms: f64,
    /// In the worst case \[ms\].
    pub(super) worst_ms: f64,
}

/// Fig. 5: 7 + 8 + 2 + 6 = 23 ms and 10 + 16 + 8 + 6 = 40 ms (§4.1).
pub(super) const LATENCY: [LatencyBar; 4] = [
    LatencyBar {
        name: "eye tracker",
        best_ms: 7.0,
        worst_ms: 10.0,
    },
    LatencyBar {
        name: "render",
        best_ms: 8.0,
        worst_ms: 16.0,
    },
    LatencyBar {
        name: "scan-out",
        best_ms: 2.0,
        worst_ms: 8.0,
    },
    LatencyBar {
        name: "pixel switching",
        best_ms: 6.0,
        worst_ms: 6.0,
    },
];

/// Height over width of the displays of Figs 12 and 13.
pub(super) const PREDICTED_ASPECT: f64 = 0.75;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn printed_numbers_agree_with_each_other() {
        // §6 gives the speedups that Table 1's first row has; Q_B's to a rounding of its time.
        let row = TABLE_1_MS[0];
        for mark in MARKS {
            let at = |column| row[COLUMNS.iter().position(|c| *c == column).unwrap()];
            let ratio = at(Column::Reference) / at(mark.column);
            assert!((ratio - mark.time).abs() < 0.08, "{mark:?}: {ratio}");
        }
        let sum = |f: fn(&LatencyBar) -> f64| LATENCY.iter().map(f).sum::<f64>();
        assert_eq!((sum(|b| b.best_ms), sum(|b| b.worst_ms)), (23.0, 40.0));
    }
}
