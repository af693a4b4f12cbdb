use foveasim_models::{linear_from_srgb, toml_error};
use serde::Deserialize;
use thiserror::Error;

use super::{ValueHistogram, Volume};

/// Most points of a transfer function.
const MOST_POINTS: usize = 4096;
/// Bins from which a default is found.
const BINS: usize = 256;

/// How a value looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransferPoint {
    /// The value.
    pub value: f64,
    /// Its colour, linear light, each part 0 to 1.
    pub colour: [f64; 3],
    /// The share of light that a unit of length holds back, 0 to 1. The unit is that of the ray caster: by
    /// default one voxel.
    pub opacity: f64,
}

/// Colour and opacity for each value: straight lines between points, in linear light; beyond the outermost
/// points as at them.
#[derive(Debug, Clone, PartialEq)]
pub struct TransferFunction {
    points: Vec<TransferPoint>,
}

/// Why points do not make a transfer function.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum TransferError {
    /// Too few or too many.
    #[error("{count} points: must be 1 to {MOST_POINTS}")]
    Count {
        /// How many.
        count: usize,
    },
    /// A number that none can be.
    #[error("point {point}: {field} = {value}: must be {valid}")]
    OutOfRange {
        /// From 1.
        point: usize,
        /// Which number.
        field: &'static str,
        /// What it is.
        value: f64,
        /// What it may be.
        valid: &'static str,
    },
    /// A text that is no transfer function.
    #[error("{0}")]
    Syntax(String),
}

/// The file: `[[point]]` tables.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileSpec {
    point: Vec<PointSpec>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PointSpec {
    value: f64,
    /// sRGB, 0 to 1.
    srgb: [f64; 3],
    opacity: f64,
}

impl TransferFunction {
    /// The function through `points`, whose values do not fall; two of the same value make a step.
    ///
    /// # Errors
    /// If there is none, a number is out of range, or values fall.
    pub fn new(points: Vec<TransferPoint>) -> Result<Self, TransferError> {
        let count = points.len();
        if !(1..=MOST_POINTS).contains(&count) {
            return Err(TransferError::Count { count });
        }
        let mut before = f64::NEG_INFINITY;
        for (k, p) in points.iter().enumerate() {
            let refuse = |field, value, valid| TransferError::OutOfRange {
                point: k + 1,
                field,
                value,
                valid,
            };
            if !p.value.is_finite() || p.value < before {
                let valid = "a finite number, not below the point before";
                return Err(refuse("value", p.value, valid));
            }
            before = p.value;
            let unit = |v: f64| (0.0..=1.0).contains(&v);
            if let Some(part) = p.colour.into_iter().find(|v| !unit(*v)) {
                return Err(refuse("colour", part, "0 to 1"));
            }
            if !unit(p.opacity) {
                return Err(refuse("opacity", p.opacity, "0 to 1"));
            }
        }
        Ok(Self { points })
    }

    /// The function in a TOML text: a table `[[point]]` for each point, with `value`, `srgb` (three numbers
    /// from 0 to 1) and `opacity`.
    ///
    /// # Errors
    /// If the text is not TOML of that form, or its points make no function; the error names `origin` and the
    /// line or point.
    pub fn from_toml(origin: &str, text: &str) -> Result<Self, TransferError> {
        let spec: FileSpec = toml::from_str(text)
            .map_err(|e| TransferError::Syntax(toml_error(origin, text, &e).to_string()))?;
        let point = |p: PointSpec| TransferPoint {
            value: p.value,
            // Out of range stays out of range, to be refused by the number that was given.
            colour: p.srgb.map(|v| {
                if (0.0..=1.0).contains(&v) {
                    linear_from_srgb(v)
                } else {
                    v
                }
            }),
            opacity: p.opacity,
        };
        Self::new(spec.point.into_iter().map(point).collect()).map_err(|e| match e {
            TransferError::Syntax(text) => TransferError::Syntax(text),
            other => TransferError::Syntax(format!("{origin}: {other}")),
        })
    }

    /// The points, values rising.
    pub fn points(&self) -> &[TransferPoint] {
        &self.points
    }

    /// Colour (linear light) and opacity of a value. Of two points with the same value the second counts at
    /// it.
    pub fn at(&self, value: f64) -> ([f64; 3], f64) {
        let after = self.points.partition_point(|p| p.value <= value);
        let low = &self.points[after.saturating_sub(1)];
        let high = self.points.get(after).unwrap_or(low);
        let width = high.value - low.value;
        let t = if width > 0.0 {
            ((value - low.value) / width).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let mix = |a: f64, b: f64| a + t * (b - a);
        let colour = std::array::from_fn(|c| mix(low.colour[c], high.colour[c]));
        (colour, mix(low.opacity, high.opacity))
    }

    /// A function that shows what is not background. Where half of all voxels have the same value (a 256th of
    /// the range), that value is the background, and what lies on either side of it is shown, blue below and
    /// red above; else the background is the lower of two classes by Otsu's rule. Opacity rises with value
    /// over the quantiles of what is shown.
    pub fn of_volume(volume: &Volume) -> Self {
        Self::of_histogram(&ValueHistogram::new(volume, BINS))
    }

    /// As [`of_volume`](Self::of_volume), from a histogram.
    pub fn of_histogram(h: &ValueHistogram) -> Self {
        const WARM: [[f64; 3]; 4] = [
            [0.55, 0.12, 0.05],
            [0.80, 0.35, 0.10],
            [0.95, 0.75, 0.45],
            [1.0, 0.97, 0.88],
        ];
        const COLD: [[f64; 3]; 4] = [
            [0.05, 0.15, 0.55],
            [0.10, 0.40, 0.80],
            [0.40, 0.70, 0.95],
            [0.85, 0.95, 1.0],
        ];
        let bins = h.counts.len();
        let (mode, share) = h.mode();
        let [mut low, mut high] = [0, bins];
        if share < 0.5 {
            high = h.otsu();
        } else {
            low = mode;
            high = high.min(mode + 1);
        }
        let points = if share >= 0.5 && mode > bins / 10 && mode < bins - bins / 10 {
            let mut points = side(h, 0, low, COLD);
            points.reverse();
            points.extend(side(h, high, bins, WARM));
            points
        } else if share >= 0.5 && mode >= bins - bins / 10 {
            let mut points = side(h, 0, low, COLD);
            points.reverse();
            points
        } else {
            side(h, high, bins, WARM)
        };
        Self::new(points).unwrap_or_else(|_| Self {
            // A volume of one value: seen as it is.
            points: vec![TransferPoint {
                value: h.range[0],
                colour: WARM[1],
                opacity: 0.05,
            }],
        })
    }
}

/// Points from the background outwards over bins `from..to`, which lie all above it, or all below where
/// `from` is 0 and the last bin is nearest to it.
fn side(h: &ValueHistogram, from: usize, to: usize, colours: [[f64; 3]; 4]) -> Vec<TransferPoint> {
    if from >= to {
        return Vec::new();
    }
    let down = from == 0;
    let at = |q: f64| {
        if down {
            h.quantile(from, to, 1.0 - q)
        } else {
            h.quantile(from, to, q)
        }
    };
    let edge = h.edge(if down { to } else { from } as f64);
    let mut points = vec![TransferPoint {
        value: edge,
        colour: colours[0],
        opacity: 0.0,
    }];
    for (k, (q, opacity)) in [(0.3, 0.02), (0.7, 0.10), (0.97, 0.45)]
        .into_iter()
        .enumerate()
    {
        let value = at(q);
        let last = points[points.len() - 1].value;
        points.push(TransferPoint {
            // Never back towards the background.
            value: if down {
                value.min(last)
            } else {
                value.max(last)
            },
            colour: colours[k + 1],
            opacity,
        });
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(value: f64, opacity: f64) -> TransferPoint {
        TransferPoint {
            value,
            colour: [value.clamp(0.0, 1.0); 3],
            opacity,
        }
    }

    #[test]
    fn between_points_lines_are_straight() {
        let points = vec![
            point(0.0, 0.0),
            point(0.5, 0.2),
            point(0.5, 0.6),
            point(1.0, 1.0),
        ];
        let f = TransferFunction::new(points).unwrap();
        assert_eq!(f.at(-3.0), ([0.0; 3], 0.0));
        assert_eq!(f.at(0.25).1, 0.1);
        assert_eq!(f.at(0.5).1, 0.6);
        assert_eq!(f.at(0.75), ([0.75; 3], 0.8));
        assert_eq!(f.at(9.0).1, 1.0);
    }

    #[test]
    fn files_say_what_is_wrong() {
        let read = |text: &str| TransferFunction::from_toml("a.toml", text);
        let good = "[[point]]\nvalue = -2\nsrgb = [1, 0.5, 0]\nopacity = 0\n";
        let f = read(good).unwrap();
        assert!((f.points()[0].colour[1] - 0.214_041_14).abs() < 1e-7);
        let error = |text: &str| read(text).unwrap_err().to_string();
        assert!(error(&good.replace("opacity", "opacty")).contains("did you mean `opacity`?"));
        let text = error(&good.replace("0.5", "1.5"));
        assert!(text.contains("a.toml: point 1: colour = 1.5"), "{text}");
        assert!(error("point = []").contains("0 points"));
        assert!(error("").contains("a.toml: line 1"));
        let fall = format!("{good}{}", good.replace("-2", "-3"));
        assert!(error(&fall).contains("point 2: value = -3"));
        assert!(error(&good.replace("-2", "nan")).contains("value = NaN"));
    }

    #[test]
    fn a_default_shows_what_is_not_background() {
        let mut counts = vec![0; 256];
        counts[10] = 700;
        counts[100..200].fill(3);
        let h = ValueHistogram {
            range: [0.0, 256.0],
            counts,
        };
        let f = TransferFunction::of_histogram(&h);
        assert_eq!(f.at(10.5).1, 0.0);
        assert!(f.at(150.0).1 > 0.02 && f.at(199.0).1 > 0.4);
        // Two-sided: zero in the middle.
        let mut counts = vec![1; 256];
        counts[128] = 10_000;
        let h = ValueHistogram {
            range: [-8.0, 8.0],
            counts,
        };
        let f = TransferFunction::of_histogram(&h);
        assert_eq!(f.at(0.02).1, 0.0);
        assert!(f.at(-6.0).1 > 0.05 && f.at(6.0).1 > 0.05);
        assert!(f.at(-6.0).0[2] > f.at(-6.0).0[0] && f.at(6.0).0[0] > f.at(6.0).0[2]);
        // One value alone.
        let h = ValueHistogram {
            range: [3.0, 3.0],
            counts: vec![64],
        };
        assert!(TransferFunction::of_histogram(&h).at(3.0).1 > 0.0);
    }
}
