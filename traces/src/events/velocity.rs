use foveasim_models::GazeDirection;
use foveasim_models::math::{cos, hypot, to_rad};

use super::chunks::Chunks;

/// The speed of gaze at each sample \[deg/s\]: of parabolas fitted by least squares to the samples within
/// `half_window_ms`, at least one on either side (a Savitzky-Golay filter of order 2 that takes times as
/// they are). Of Fick angles it is √((ȧz·cos el)² + ėl²), exactly.
pub(super) fn speeds(chunks: &Chunks, half_window_ms: f64) -> Vec<f64> {
    let half = half_window_ms * 1e-3;
    let mut speeds = vec![0.0; chunks.samples()];
    for range in &chunks.ranges {
        let (mut first, mut last) = (range.start, range.start);
        for i in range.clone() {
            let t = chunks.t[i];
            while (t - chunks.t[first]).as_secs() > half {
                first += 1;
            }
            while last + 1 < range.end && (chunks.t[last + 1] - t).as_secs() <= half {
                last += 1;
            }
            let mut from = first.min(i.saturating_sub(1)).max(range.start);
            let to = last.max(i + 1).max(from + 2).min(range.end - 1);
            // At an end of the stretch both others are on one side.
            from = from.min(to.saturating_sub(2)).max(range.start);
            speeds[i] = speed(chunks, from..=to, i);
        }
    }
    speeds
}

fn speed(chunks: &Chunks, window: std::ops::RangeInclusive<usize>, i: usize) -> f64 {
    let (t0, here) = (chunks.t[i], chunks.gaze[i]);
    let span = (chunks.t[*window.end()] - chunks.t[*window.start()]).as_secs();
    if span <= 0.0 {
        return 0.0;
    }
    // Times in units of the window, so that the sums are of like size.
    let mut s = [0.0; 5];
    let mut az = [0.0; 3];
    let mut el = [0.0; 3];
    for j in window {
        let x = (chunks.t[j] - t0).as_secs() / span;
        let [a, e] = difference(chunks.gaze[j], here);
        let mut power = 1.0;
        for (k, s) in s.iter_mut().enumerate() {
            *s += power;
            if k < 3 {
                az[k] += a * power;
                el[k] += e * power;
            }
            power *= x;
        }
    }
    let [a, e] = [slope(&s, az), slope(&s, el)].map(|v| v / span);
    hypot(a * cos(to_rad(here.elevation_deg)), e)
}

/// Azimuth and elevation of one direction from another \[deg\], the short way round.
fn difference(a: GazeDirection, b: GazeDirection) -> [f64; 2] {
    let mut azimuth = a.azimuth_deg - b.azimuth_deg;
    if azimuth > 180.0 {
        azimuth -= 360.0;
    } else if azimuth < -180.0 {
        azimuth += 360.0;
    }
    [azimuth, a.elevation_deg - b.elevation_deg]
}

/// The slope at zero of the parabola with these sums Σxᵏ and Σyxᵏ; of the straight line where there
/// are not three different times.
fn slope(s: &[f64; 5], y: [f64; 3]) -> f64 {
    let det = s[0] * (s[2] * s[4] - s[3] * s[3]) - s[1] * (s[1] * s[4] - s[2] * s[3])
        + s[2] * (s[1] * s[3] - s[2] * s[2]);
    if det.abs() > 1e-9 {
        let b = s[0] * (y[1] * s[4] - y[2] * s[3]) - y[0] * (s[1] * s[4] - s[2] * s[3])
            + s[2] * (s[1] * y[2] - s[2] * y[1]);
        return b / det;
    }
    let line = s[0] * s[2] - s[1] * s[1];
    if line.abs() > 1e-12 {
        (s[0] * y[1] - s[1] * y[0]) / line
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use foveasim_models::{Nanos, Provenance, Sample, Series};

    use super::*;

    #[test]
    fn parabolas_are_exact_on_any_times() {
        let times = [0.0, 3.0, 4.0, 9.0, 11.0, 12.5, 20.0];
        let gaze = |ms: f64| GazeDirection::new(179.0 + 0.3 * ms + 0.01 * ms * ms, 0.2 * ms);
        let wrapped = |g: GazeDirection| GazeDirection {
            azimuth_deg: if g.azimuth_deg > 180.0 {
                g.azimuth_deg - 360.0
            } else {
                g.azimuth_deg
            },
            ..g
        };
        let samples = times.map(|ms| Sample {
            t: Nanos::from_ms(ms),
            value: Some(wrapped(gaze(ms))),
        });
        let series = Series::new(samples.to_vec(), Provenance::Truth).unwrap();
        let speeds = speeds(&Chunks::new(&series, None), 8.0);
        for (ms, speed) in times.iter().zip(speeds) {
            let az = 1e3 * (0.3 + 0.02 * ms) * (0.2 * ms).to_radians().cos();
            let want = az.hypot(200.0);
            assert!((speed - want).abs() < 1e-6 * want, "{ms}: {speed} {want}");
        }
    }
}
