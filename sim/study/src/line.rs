use foveasim_models::math::{mean, sum};

/// A straight line through points, by least squares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Line {
    /// Its value at x = 0.
    pub(crate) at_zero: f64,
    /// Its rise with x.
    pub(crate) slope: f64,
    /// Coefficient of determination R², 1 if it goes through every point.
    pub(crate) r2: f64,
}

impl Line {
    /// The line through `points` (x, y); NaN where they do not have two different x.
    pub(crate) fn through(points: &[[f64; 2]]) -> Self {
        let column = |k: usize| points.iter().map(|p| p[k]).collect::<Vec<f64>>();
        let (mx, my) = (mean(&column(0)), mean(&column(1)));
        let of = |f: fn(f64, f64) -> f64| {
            let terms: Vec<f64> = points.iter().map(|p| f(p[0] - mx, p[1] - my)).collect();
            sum(&terms)
        };
        let (xx, xy, yy) = (of(|x, _| x * x), of(|x, y| x * y), of(|_, y| y * y));
        let slope = xy / xx;
        Self {
            at_zero: my - slope * mx,
            slope,
            r2: if yy > 0.0 { xy * xy / (xx * yy) } else { 1.0 },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_lines() {
        let exact = Line::through(&[[1.0, 5.0], [2.0, 7.0], [4.0, 11.0]]);
        assert!((exact.at_zero - 3.0).abs() < 1e-12 && (exact.slope - 2.0).abs() < 1e-12);
        assert!((exact.r2 - 1.0).abs() < 1e-12);
        // Symmetric about x: nothing of y follows it.
        let none = Line::through(&[[-1.0, 1.0], [0.0, 0.0], [1.0, 1.0]]);
        assert!(none.slope.abs() < 1e-12 && none.r2 < 1e-12);
        assert!((none.at_zero - 2.0 / 3.0).abs() < 1e-12);
        let flat = Line::through(&[[0.0, 4.0], [1.0, 4.0]]);
        assert_eq!((flat.at_zero, flat.slope, flat.r2), (4.0, 0.0, 1.0));
        assert!(Line::through(&[[3.0, 1.0], [3.0, 2.0]]).slope.is_nan());
    }
}
