use libm::fma;

use crate::math::sqrt;

/// When the scan of a rolling display catches a moving point (Friston 2019, §3.1.2, Fig. 5): the scan is at
/// xs + ẋs·t, the point at (xp + ẋp·t)/(w + ẇ·t). Times w + ẇ·t that is a quadratic,
///
/// A·t² + B·t + C = 0, A = ẋs·ẇ, B = xs·ẇ + ẋs·w − ẋp, C = xs·w − xp.
///
/// The paper has a "unique positive solution", its Eq. 1; there can be two in \[0, 1\], where a point overtakes
/// the scan and falls back, one, none, or, for a point that rides on the scan, all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Zenon {
    quadratic: [f64; 3],
    scan: [f64; 2],
    point: [f64; 2],
    w: [f64; 2],
}

/// When a scan catches a point within \[0, 1\] and in front of the eye; earlier times first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Catches {
    /// At no time.
    Never,
    /// Once, or at a double root.
    Once(f64),
    /// Twice.
    Twice([f64; 2]),
    /// At all times at which it is in front of the eye: the point rides on the scan.
    Always,
}

/// Real roots of a quadratic.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Roots {
    None,
    /// The root that stays finite as A goes to 0, and the other if there is one.
    Some(f64, Option<f64>),
    All,
}

impl Zenon {
    /// Positions at t = 0 and speeds of scan, point and w.
    pub fn new(scan: [f64; 2], point: [f64; 2], w: [f64; 2]) -> Self {
        let ([xs, xs_dot], [xp, xp_dot], [w0, w_dot]) = (scan, point, w);
        Self {
            quadratic: [
                xs_dot * w_dot,
                xs * w_dot + xs_dot * w0 - xp_dot,
                xs * w0 - xp,
            ],
            scan,
            point,
            w,
        }
    }

    /// A, B and C.
    pub fn quadratic(&self) -> [f64; 3] {
        self.quadratic
    }

    /// What is left of the quadratic at `t`, over the sum of its terms' sizes: at a root that is as good as
    /// can be, a few ε.
    pub fn residual(&self, t: f64) -> f64 {
        let [a, b, c] = self.quadratic.map(|k| k.abs());
        let size = (a * t * t) + (b * t.abs()) + c;
        let [a, b, c] = self.quadratic;
        let rest = (a * t + b) * t + c;
        if size > 0.0 { rest.abs() / size } else { 0.0 }
    }

    /// The root that stays finite for a point whose w does not change (C/q), in \[0, 1\] or not, in front of
    /// the eye or not: for which the paper's Eq. 1 is meant. `None` if there is none, or all.
    pub fn catch(&self) -> Option<f64> {
        match self.roots() {
            Roots::Some(first, _) => Some(first),
            Roots::None | Roots::All => None,
        }
    }

    /// All that a viewer sees: roots in \[0, 1\] where w > 0. A root at which w is 0 has no place: there the
    /// point is in the eye's own plane.
    pub fn catches(&self) -> Catches {
        let is_seen = |t: &f64| (0.0..=1.0).contains(t) && self.w[0] + self.w[1] * t > 0.0;
        match self.roots() {
            Roots::None => Catches::Never,
            Roots::All if self.w[0] > 0.0 || self.w[0] + self.w[1] > 0.0 => Catches::Always,
            Roots::All => Catches::Never,
            Roots::Some(first, second) => {
                let (first, second) = (Some(first).filter(is_seen), second.filter(is_seen));
                match (first, second) {
                    (Some(a), Some(b)) if a != b => Catches::Twice([a.min(b), a.max(b)]),
                    (Some(a), _) | (None, Some(a)) => Catches::Once(a),
                    (None, None) => Catches::Never,
                }
            }
        }
    }

    /// The paper's Eq. 1, for comparison: with + before the root, as printed, and with −,
    ///
    /// t = (±√(−4·xs·ẇ + ẋs² − 2·ẋs·w + w²) − ẋs + w)/(2·ẇ).
    ///
    /// That solves the case of a scan at 0 + 1·t, with the point's position and speed written as xs and ẋs, and
    /// with ẇ of the opposite sign; it is read so here. Even so the printed + gives the root that runs off to
    /// infinity for a point whose w hardly changes, and the − is then 0/0, or has lost all digits (oracle s4: a
    /// relative error of 1 in f64). NaN where there is no value.
    pub fn roots_as_printed(&self) -> [f64; 2] {
        let ([x, x_dot], [w, w_dot]) = (self.point, [self.w[0], -self.w[1]]);
        let root = sqrt(-4.0 * x * w_dot + x_dot * x_dot - 2.0 * x_dot * w + w * w);
        [root, -root].map(|root| (root - x_dot + w) / (2.0 * w_dot))
    }

    /// Whether the printed equation is meant for this scan: one at 0 + 1·t.
    pub fn is_as_printed(&self) -> bool {
        self.scan == [0.0, 1.0]
    }

    /// q = −(B + sgn(B)·√(B² − 4AC))/2 does not cancel; the roots are C/q and q/A (Press et al. 2007, Eq. 5.6.4).
    fn roots(&self) -> Roots {
        let [a, b, c] = self.quadratic;
        let square = discriminant(a, b, c);
        // Within the rounding of A, B and C a double root it is.
        let noise = 8.0 * f64::EPSILON * (b * b + (4.0 * a * c).abs());
        if !square.is_finite() || square < -noise {
            return Roots::None;
        }
        let q = -(b + sqrt(square.max(0.0)).copysign(b)) / 2.0;
        if q == 0.0 {
            // B = 0 and A·C = 0.
            return match (a == 0.0, c == 0.0) {
                (true, true) => Roots::All,
                (true, false) => Roots::None,
                (false, _) => Roots::Some(0.0, None),
            };
        }
        let other = q / a;
        Roots::Some(c / q, other.is_finite().then_some(other))
    }
}

/// B² − 4AC with an error of 2 ε of the result (Kahan 2004: the products' own rounding errors are added back).
fn discriminant(a: f64, b: f64, c: f64) -> f64 {
    let (p, q) = (b * b, 4.0 * a * c);
    let whole = p - q;
    // Where they do not cancel, it is exact enough.
    if 3.0 * whole.abs() >= p + q.abs() {
        return whole;
    }
    let (dp, dq) = (fma(b, b, -p), fma(4.0 * a, c, -q));
    whole + (dp - dq)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_still_point_is_met_where_it_is() {
        let zenon = Zenon::new([0.0, 1.0], [0.9, 0.0], [3.0, 0.0]);
        assert_eq!(zenon.catches(), Catches::Once(0.9 / 3.0));
        let printed = zenon.roots_as_printed();
        assert!(printed[0].is_infinite() && printed[1].is_nan());
    }

    #[test]
    fn degenerate_cases() {
        let catches = |xs, xp, w| Zenon::new(xs, xp, w).catches();
        assert_eq!(catches([0.0, 1.0], [0.0, 1.0], [1.0, 0.0]), Catches::Always);
        assert_eq!(
            catches([0.0, 1.0], [0.0, -1.0], [-1.0, 0.0]),
            Catches::Never
        );
        assert_eq!(catches([0.0, 1.0], [0.5, 1.0], [1.0, 0.0]), Catches::Never);
        // t·(1 + t) = t: a double root at 0.
        assert_eq!(
            catches([0.0, 1.0], [0.0, 1.0], [1.0, 1.0]),
            Catches::Once(0.0)
        );
        // (t − ½)² from t·(1 + t) = −¼ + 2t.
        assert_eq!(
            catches([0.0, 1.0], [-0.25, 2.0], [1.0, 1.0]),
            Catches::Once(0.5)
        );
        // Behind the eye all along, and from t = ½ on.
        assert_eq!(
            catches([0.0, 1.0], [-0.2, 0.0], [-1.0, 0.0]),
            Catches::Never
        );
        assert_eq!(
            catches([0.0, 1.0], [-0.2, 0.0], [1.0, -2.0]),
            Catches::Never
        );
        for bad in [f64::NAN, f64::INFINITY] {
            assert_eq!(catches([0.0, 1.0], [bad, 0.0], [1.0, 0.1]), Catches::Never);
        }
    }
}
