use foveasim_models::math::{exp, sqrt};

use super::GazeEvents;
use crate::EventKind;

/// Fewest saccades that a fit is made to.
const FEWEST: usize = 8;

/// A fitted number and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// Its standard error.
    pub error: f64,
}

/// The main sequence of saccades: how peak speed and duration grow with amplitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MainSequence {
    /// Saccades it was fitted to.
    pub saccades: usize,
    /// V of `peak = V·(1 − exp(−A/C))` (Bahill et al. 1975) \[deg/s\].
    pub peak_deg_per_s: Estimate,
    /// C of the same \[deg\].
    pub scale_deg: Estimate,
    /// Root mean square of what the fit leaves of the peak speeds \[deg/s\].
    pub peak_residual_deg_per_s: f64,
    /// D₀ of `duration = D₀ + d·A` \[ms\]; 21 is usual (Carpenter 1988).
    pub duration_ms: Estimate,
    /// d of the same \[ms/deg\]; 2.2 is usual.
    pub duration_ms_per_deg: Estimate,
    /// Root mean square of what the fit leaves of the durations \[ms\].
    pub duration_residual_ms: f64,
}

impl MainSequence {
    /// The peak speed of a saccade of this amplitude \[deg/s\].
    pub fn peak(&self, amplitude_deg: f64) -> f64 {
        self.peak_deg_per_s.value * (1.0 - exp(-amplitude_deg / self.scale_deg.value))
    }

    /// Its duration \[ms\].
    pub fn duration(&self, amplitude_deg: f64) -> f64 {
        self.duration_ms.value + self.duration_ms_per_deg.value * amplitude_deg
    }
}

/// Fits the main sequence by least squares; `None` for fewer than eight saccades, all of one amplitude, or peak
/// speeds that do not saturate within a hundred times the amplitudes.
pub fn main_sequence(events: &GazeEvents) -> Option<MainSequence> {
    let saccades: Vec<_> = events
        .of(EventKind::Saccade)
        .map(|e| (e.amplitude_deg, e.peak_deg_per_s, e.duration().as_ms()))
        .collect();
    if saccades.len() < FEWEST {
        return None;
    }
    let peaks: Vec<_> = saccades.iter().map(|s| (s.0, s.1)).collect();
    let durations: Vec<_> = saccades.iter().map(|s| (s.0, s.2)).collect();
    let (duration_ms, duration_ms_per_deg, duration_residual_ms) = line(&durations)?;
    let (peak_deg_per_s, scale_deg, peak_residual_deg_per_s) = saturating(&peaks)?;
    Some(MainSequence {
        saccades: saccades.len(),
        peak_deg_per_s,
        scale_deg,
        peak_residual_deg_per_s,
        duration_ms,
        duration_ms_per_deg,
        duration_residual_ms,
    })
}

/// Normal equations of two parameters.
#[derive(Default)]
struct Normal {
    aa: f64,
    ab: f64,
    bb: f64,
    ay: f64,
    by: f64,
}

impl Normal {
    /// Takes a row of derivatives and what it should give.
    fn push(&mut self, a: f64, b: f64, y: f64) {
        self.aa += a * a;
        self.ab += a * b;
        self.bb += b * b;
        self.ay += a * y;
        self.by += b * y;
    }

    /// The parameters, and the diagonal of the inverse; `None` where the rows tell them not apart.
    fn solve(&self) -> Option<([f64; 2], [f64; 2])> {
        let det = self.aa * self.bb - self.ab * self.ab;
        if det <= 1e-12 * self.aa * self.bb || !det.is_finite() {
            return None;
        }
        let x = (self.ay * self.bb - self.by * self.ab) / det;
        let y = (self.by * self.aa - self.ay * self.ab) / det;
        Some(([x, y], [self.bb / det, self.aa / det]))
    }
}

/// Standard errors from the squares left over.
fn errors(left: f64, n: usize, inverse: [f64; 2]) -> [f64; 2] {
    let variance = left / (n.saturating_sub(2).max(1)) as f64;
    inverse.map(|v| sqrt(variance * v))
}

fn line(points: &[(f64, f64)]) -> Option<(Estimate, Estimate, f64)> {
    let mut normal = Normal::default();
    for &(x, y) in points {
        normal.push(1.0, x, y);
    }
    let ([a, b], inverse) = normal.solve()?;
    let left: f64 = points
        .iter()
        .map(|(x, y)| (y - a - b * x) * (y - a - b * x))
        .sum();
    let [ea, eb] = errors(left, points.len(), inverse);
    let estimate = |value, error| Estimate { value, error };
    let rms = sqrt(left / points.len() as f64);
    Some((estimate(a, ea), estimate(b, eb), rms))
}

/// V and C of V·(1 − exp(−A/C)): Gauss-Newton from the largest speed and the mean amplitude, each step
/// halved until it improves.
fn saturating(points: &[(f64, f64)]) -> Option<(Estimate, Estimate, f64)> {
    let n = points.len() as f64;
    let left = |v: f64, c: f64| -> f64 {
        points
            .iter()
            .map(|(a, p)| {
                let r = p - v * (1.0 - exp(-a / c));
                r * r
            })
            .sum()
    };
    let widest = points.iter().map(|p| p.0).fold(0.0, f64::max);
    let mut v = points.iter().map(|p| p.1).fold(0.0, f64::max);
    let mut c = (points.iter().map(|p| p.0).sum::<f64>() / n).max(1e-3);
    let mut best = left(v, c);
    let mut inverse = [0.0; 2];
    for _ in 0..200 {
        let mut normal = Normal::default();
        for &(a, p) in points {
            let e = exp(-a / c);
            normal.push(1.0 - e, -v * e * a / (c * c), p - v * (1.0 - e));
        }
        let ([dv, dc], diagonal) = normal.solve()?;
        inverse = diagonal;
        let mut step = 1.0;
        let mut improved = false;
        while step > 1e-6 {
            let (nv, nc) = (v + step * dv, c + step * dc);
            if nv > 0.0 && nc > 1e-6 && left(nv, nc) < best {
                improved = best - left(nv, nc) > 1e-12 * best;
                (v, c, best) = (nv, nc, left(nv, nc));
                break;
            }
            step *= 0.5;
        }
        if !improved {
            break;
        }
    }
    let [ev, ec] = errors(best, points.len(), inverse);
    if c > 100.0 * widest || ec > c {
        return None;
    }
    let estimate = |value, error| Estimate { value, error };
    Some((estimate(v, ev), estimate(c, ec), sqrt(best / n)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_put_in_comes_out() {
        let noise = |k: usize| [1.0, -1.0, -1.0, 1.0][k % 4];
        let points = |f: fn(f64) -> f64, n: f64| -> Vec<(f64, f64)> {
            let point = |k| {
                let a = 0.5 + 0.25 * k as f64;
                (a, f(a) + n * noise(k))
            };
            (0..80).map(point).collect()
        };
        let (v, c, rms) = saturating(&points(|a| 500.0 * (1.0 - (-a / 6.0).exp()), 5.0)).unwrap();
        assert!(
            (v.value - 500.0).abs() < 3.0 * v.error && v.error < 5.0,
            "{v:?}"
        );
        assert!(
            (c.value - 6.0).abs() < 3.0 * c.error && c.error < 0.2,
            "{c:?}"
        );
        assert!((rms - 5.0).abs() < 0.1, "{rms}");
        let (a, b, _) = line(&points(|a| 21.0 + 2.2 * a, 0.0)).unwrap();
        assert!((a.value - 21.0).abs() < 1e-9 && (b.value - 2.2).abs() < 1e-10 && b.error < 1e-9);
        assert!(line(&[(1.0, 2.0); 9]).is_none(), "one amplitude");
    }
}
