use serde::{Deserialize, Serialize};

use crate::{GazeDirection, ModelError};

/// Systematic error of a tracker over the field of gaze, as people write it (TOML): a grid of gaze
/// positions, and at each the reported minus the true gaze.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BiasMapSpec {
    /// Columns of the grid, growing \[deg\].
    pub azimuth_deg: Vec<f64>,
    /// Rows of the grid, growing \[deg\].
    pub elevation_deg: Vec<f64>,
    /// Row by row: error to the right and upwards \[deg\].
    pub error_deg: Vec<Vec<[f64; 2]>>,
}

/// A valid [`BiasMapSpec`]: bilinear between the grid's points, constant beyond its edge.
#[derive(Debug, Clone, PartialEq)]
pub struct BiasMap(BiasMapSpec);

/// The most columns or rows.
const MOST: usize = 1000;

impl BiasMap {
    /// Reported minus true gaze \[deg\], to the right and upwards, where the eye looks at `gaze`.
    pub fn at(&self, gaze: GazeDirection) -> [f64; 2] {
        let (column, fx) = cell(&self.0.azimuth_deg, gaze.azimuth_deg);
        let (row, fy) = cell(&self.0.elevation_deg, gaze.elevation_deg);
        let point = |r: usize, c: usize| {
            let line = &self.0.error_deg[r.min(self.0.error_deg.len() - 1)];
            line[c.min(line.len() - 1)]
        };
        let mix = |a: [f64; 2], b: [f64; 2], f: f64| [0, 1].map(|i| a[i] + (b[i] - a[i]) * f);
        let upper = mix(point(row, column), point(row, column + 1), fx);
        let lower = mix(point(row + 1, column), point(row + 1, column + 1), fx);
        mix(upper, lower, fy)
    }
}

/// The knot at or before `x`, and how far from it to the next.
fn cell(knots: &[f64], x: f64) -> (usize, f64) {
    let after = knots.partition_point(|k| *k <= x);
    match (after.checked_sub(1), knots.get(after)) {
        (None, _) => (0, 0.0),
        (Some(last), None) => (last, 0.0),
        (Some(i), Some(next)) => (i, (x - knots[i]) / (next - knots[i])),
    }
}

impl TryFrom<BiasMapSpec> for BiasMap {
    type Error = ModelError;

    fn try_from(spec: BiasMapSpec) -> Result<Self, ModelError> {
        let knots = [
            ("bias_map.azimuth_deg", &spec.azimuth_deg),
            ("bias_map.elevation_deg", &spec.elevation_deg),
        ];
        for (field, knots) in knots {
            let within = knots.iter().all(|k| (-180.0..=180.0).contains(k));
            let growing = knots.windows(2).all(|w| w[0] < w[1]);
            if !(1..=MOST).contains(&knots.len()) || !within || !growing {
                let valid = format!("1 to {MOST} angles from -180 to 180, growing");
                let shown = knots.iter().take(8).collect::<Vec<_>>();
                return Err(ModelError::range(field, format!("{shown:?}"), valid));
            }
        }
        let (rows, columns) = (spec.elevation_deg.len(), spec.azimuth_deg.len());
        let shape =
            spec.error_deg.len() == rows && spec.error_deg.iter().all(|row| row.len() == columns);
        if !shape {
            let value = format!("{} rows", spec.error_deg.len());
            let valid = format!("{rows} rows of {columns} pairs [right, up]");
            return Err(ModelError::range("bias_map.error_deg", value, valid));
        }
        let errors = || spec.error_deg.iter().flatten().flatten();
        if let Some(bad) = errors().find(|e| !(-90.0..=90.0).contains(*e)) {
            let valid = "numbers from -90 to 90";
            return Err(ModelError::range("bias_map.error_deg", bad, valid));
        }
        Ok(Self(spec))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec() -> BiasMapSpec {
        BiasMapSpec {
            azimuth_deg: vec![-20.0, 0.0, 20.0],
            elevation_deg: vec![-10.0, 10.0],
            error_deg: vec![
                vec![[1.0, 0.0], [0.0, 0.0], [-1.0, 0.0]],
                vec![[1.0, 2.0], [0.0, 2.0], [-1.0, 2.0]],
            ],
        }
    }

    #[test]
    fn bilinear_inside_and_constant_outside() {
        let map = BiasMap::try_from(spec()).unwrap();
        let at = |az, el| map.at(GazeDirection::new(az, el));
        assert_eq!(at(-20.0, -10.0), [1.0, 0.0]);
        assert_eq!(at(-10.0, 0.0), [0.5, 1.0]);
        assert_eq!(at(5.0, 10.0), [-0.25, 2.0]);
        assert_eq!(at(99.0, -99.0), [-1.0, 0.0]);
        assert_eq!(at(-99.0, 99.0), [1.0, 2.0]);
    }

    #[test]
    fn a_grid_that_is_none() {
        let wrong = |change: &dyn Fn(&mut BiasMapSpec)| {
            let mut spec = spec();
            change(&mut spec);
            BiasMap::try_from(spec).unwrap_err().to_string()
        };
        assert!(wrong(&|s| s.azimuth_deg.reverse()).contains("growing"));
        assert!(wrong(&|s| s.azimuth_deg.clear()).contains("1 to 1000"));
        assert!(wrong(&|s| s.elevation_deg[0] = f64::NAN).contains("elevation"));
        assert!(wrong(&|s| s.error_deg[1].truncate(2)).contains("2 rows of 3 pairs"));
        assert!(wrong(&|s| s.error_deg[0][0][1] = f64::INFINITY).contains("inf"));
    }
}
