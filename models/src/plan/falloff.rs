use crate::ModelError;
use crate::error::in_range;
use crate::math::pow;

/// How a radial map's distances grow outwards: a monotone function p from distances in the buffer to
/// distances on the display, both as shares of a reach on which they agree, so p(0) = 0 and p(1) = 1.
///
/// Its ratio p(s)/s, which is the length of a step around, never falls outwards: samples are
/// nowhere sparser than farther out. So the foveated part of a display is a run of each row.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Falloff {
    /// p(s) = s^k with k ≥ 1; 1 magnifies nothing (Friston 2019, §5.1, has k = 2).
    Power(f64),
    /// Straight lines between given points.
    Table(FalloffTable),
}

/// A monotone function given by points, straight in between and beyond the last two; its inverse is exact
/// to rounding. Of a smooth p with points h apart it differs by at most h²·max|p″|/8.
///
/// Maps are plain data that is copied, so points are few and kept in single precision: as rounded they are
/// the function.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FalloffTable {
    points: [[f32; 2]; FalloffTable::MOST],
    count: u32,
}

impl Falloff {
    /// A power.
    ///
    /// # Errors
    /// If the exponent is not from 1 to 16.
    pub fn power(exponent: f64) -> Result<Self, ModelError> {
        in_range("exponent of a radial map", exponent, 1.0..=16.0).map(Self::Power)
    }

    /// Whether distances stay what they are.
    pub fn is_identity(&self) -> bool {
        match self {
            Self::Power(k) => *k == 1.0,
            Self::Table(table) => table.points().all(|[from, to]| from == to),
        }
    }

    /// p(s)/s, at 0 its limit: display pixels per step around.
    pub fn ratio(&self, s: f64) -> f64 {
        match self {
            Self::Power(k) => pow(s, k - 1.0),
            Self::Table(table) => table.ratio(s, [0, 1]),
        }
    }

    /// p⁻¹(s)/s for s > 0.
    pub fn inverse_ratio(&self, s: f64) -> f64 {
        match self {
            Self::Power(k) => pow(s, 1.0 / k - 1.0),
            Self::Table(table) => table.ratio(s, [1, 0]),
        }
    }

    /// p′(s): display pixels per step outwards; at a table's point, those of the step beyond it.
    pub fn slope(&self, s: f64) -> f64 {
        match self {
            Self::Power(k) => k * pow(s, k - 1.0),
            Self::Table(table) => table.line(s, 0).slope(),
        }
    }
}

/// A table's piece between two points.
#[derive(Clone, Copy)]
struct Line([[f64; 2]; 2]);

impl Line {
    fn slope(self) -> f64 {
        let Self([a, b]) = self;
        (b[1] - a[1]) / (b[0] - a[0])
    }
}

impl FalloffTable {
    /// The most points.
    pub const MOST: usize = 16;

    /// Through `points`, \[distance in the buffer, distance on the display\] as shares of the reach, from
    /// \[0, 0\] to \[1, 1\].
    ///
    /// # Errors
    /// If there are not 2 to [`FalloffTable::MOST`] points, they do not begin and end so, do not grow in
    /// both, or if display over buffer falls from a point to the next.
    pub fn new(points: &[[f64; 2]]) -> Result<Self, ModelError> {
        const FIELD: &str = "table of a radial map";
        let (count, most) = (points.len(), Self::MOST);
        if !(2..=most).contains(&count) {
            let valid = format!("2 to {most} points");
            return Err(ModelError::range(FIELD, format!("{count} points"), valid));
        }
        if points[0] != [0.0, 0.0] || points[count - 1] != [1.0, 1.0] {
            let value = format!("{:?} to {:?}", points[0], points[count - 1]);
            return Err(ModelError::range(FIELD, value, "from [0, 0] to [1, 1]"));
        }
        let mut kept = [[0.0; 2]; Self::MOST];
        for (kept, given) in kept.iter_mut().zip(points) {
            *kept = given.map(|x| x as f32);
        }
        for (i, pair) in kept[..count].windows(2).enumerate() {
            let [a, b] = [pair[0], pair[1]].map(|p| p.map(f64::from));
            // NaN fails.
            let grows = b[0] > a[0] && b[1] > a[1];
            if !(grows && b[1] * a[0] >= a[1] * b[0]) {
                let (a, b) = (points[i], points[i + 1]);
                let value = format!("{a:?}, {b:?} (points {i} and {})", i + 1);
                let valid = "growing in both, with display over buffer nowhere falling";
                return Err(ModelError::range(FIELD, value, valid));
            }
        }
        Ok(Self {
            points: kept,
            count: count as u32,
        })
    }

    /// The points that it goes through.
    pub fn points(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.kept().iter().map(|p| p.map(f64::from))
    }

    fn kept(&self) -> &[[f32; 2]] {
        &self.points[..self.count as usize]
    }

    /// The piece that holds `s` along `axis` (0 buffer, 1 display).
    fn line(&self, s: f64, axis: usize) -> Line {
        let points = self.kept();
        let beyond = points.partition_point(|p| f64::from(p[axis]) <= s);
        let end = beyond.clamp(1, points.len() - 1);
        Line([points[end - 1], points[end]].map(|p| p.map(f64::from)))
    }

    /// The function or its inverse at `s`, over `s`.
    fn ratio(&self, s: f64, [from, to]: [usize; 2]) -> f64 {
        let Line([a, b]) = self.line(s, from);
        let slope = (b[to] - a[to]) / (b[from] - a[from]);
        // The first piece goes through 0, where there is nothing to divide by.
        if a[from] == 0.0 {
            return slope;
        }
        (a[to] + (s - a[from]) * slope) / s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_invert_and_extend() {
        let table = FalloffTable::new(&[[0.0, 0.0], [0.5, 0.1], [0.75, 0.4], [1.0, 1.0]]).unwrap();
        let p = Falloff::Table(table);
        for s in [1e-12, 0.1, 0.3, 0.5, 0.6, 0.75, 0.9, 1.0, 1.7] {
            let on = s * p.ratio(s);
            assert!(
                (on * p.inverse_ratio(on) - s).abs() < 4.0 * f64::EPSILON,
                "{s}"
            );
        }
        assert!((p.ratio(0.0) - 0.2).abs() < 1e-7);
        assert!((p.slope(0.5) - 1.2).abs() < 1e-6);
        assert!(!p.is_identity());
        let straight = FalloffTable::new(&[[0.0, 0.0], [0.5, 0.5], [1.0, 1.0]]).unwrap();
        assert!(Falloff::Table(straight).is_identity());
    }

    #[test]
    fn bad_falloffs_are_refused() {
        for bad in [0.0, 0.99, 16.1, f64::NAN, f64::INFINITY] {
            assert!(Falloff::power(bad).is_err(), "{bad}");
        }
        let bad: [&[[f64; 2]]; 8] = [
            &[],
            &[[0.0, 0.0]],
            &[[0.0, 0.0], [1.0, 0.9]],
            &[[0.1, 0.0], [1.0, 1.0]],
            &[[0.0, 0.0], [0.5, 0.4], [0.5, 0.5], [1.0, 1.0]],
            &[[0.0, 0.0], [0.5, 0.4], [0.6, 0.3], [1.0, 1.0]],
            &[[0.0, 0.0], [0.5, 0.6], [1.0, 1.0]],
            &[[0.0, 0.0], [f64::NAN, 0.5], [1.0, 1.0]],
        ];
        for points in bad {
            assert!(FalloffTable::new(points).is_err(), "{points:?}");
        }
        assert!(FalloffTable::new(&[[0.0; 2]; 33]).is_err());
        let error = FalloffTable::new(bad[6]).unwrap_err().to_string();
        assert!(error.contains("[0.5, 0.6]"), "{error}");
    }
}
