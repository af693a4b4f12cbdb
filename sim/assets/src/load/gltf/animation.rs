use std::collections::HashMap;

use foveasim_models::Pose;
use glam::{DQuat, DVec3};

use super::super::Warnings;
use super::super::error::Flaw;
use super::super::soup::coordinate;
use super::super::text::shown;
use super::accessor::Accessor;
use super::container::Document;
use super::get;
use super::json::AnimationSampler;
use super::nodes::Rest;
use crate::{Key, Repeat, Similarity, Track};

/// Steps by which a cubic spline between two keys is followed: straight ones miss it by 1/64 of what
/// one straight line would.
const SPLINE_STEPS: usize = 8;

/// Movements of nodes.
#[derive(Default)]
pub(super) struct Animation {
    nodes: HashMap<usize, Curves>,
    /// When it is over and begins again \[s\].
    end: f64,
}

/// What moves of one node; the rest stays as the node says.
#[derive(Default)]
struct Curves {
    translation: Option<Curve>,
    rotation: Option<Curve>,
    scale: Option<Curve>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Interpolation {
    Step,
    Linear,
    CubicSpline,
}

/// A value over time; of vectors, the last component is 0.
struct Curve {
    interpolation: Interpolation,
    is_rotation: bool,
    times: Vec<f64>,
    /// One per time; for splines the tangent before, the value and the tangent after.
    values: Vec<[f64; 4]>,
}

/// The first animation of the file; the others are named in a warning.
pub(super) fn read(document: &Document<'_>, warnings: &mut Warnings) -> Result<Animation, Flaw> {
    let mut animation = Animation::default();
    let animations = &document.root.animations;
    let Some(first) = animations.first() else {
        return Ok(animation);
    };
    if animations.len() > 1 {
        let count = animations.len();
        warnings.add(format_args!(
            "of {count} animations only the first one is played"
        ));
    }
    // Channels may share accessors: what they take must stay in proportion to the file.
    let mut keys_left = document.bytes().max(1 << 16);
    for (i, channel) in first.channels.iter().enumerate() {
        let place = format!("animations[0].channels[{i}]");
        let Some(node) = channel.target.node else {
            continue;
        };
        get(&document.root.nodes, node, "node", &place)?;
        let sampler = get(&first.samplers, channel.sampler, "sampler", &place)?;
        let path = channel.target.path.as_str();
        let is_rotation = match path {
            "rotation" => true,
            "translation" | "scale" => false,
            "weights" => {
                warnings.add("morph targets are not applied");
                continue;
            }
            path => {
                let valid = "translation, rotation, scale or weights";
                let problem = format!("path {}: must be {valid}", shown(path));
                return Err(Flaw::new(place, problem));
            }
        };
        let curve = Curve::read(document, sampler, is_rotation, &mut keys_left, &place)?;
        animation.end = animation.end.max(curve.times[curve.times.len() - 1]);
        let curves = animation.nodes.entry(node).or_default();
        let slot = match path {
            "rotation" => &mut curves.rotation,
            "translation" => &mut curves.translation,
            _ => &mut curves.scale,
        };
        if slot.replace(curve).is_some() {
            let problem = format!("moves the {path} of node {node} a second time");
            return Err(Flaw::new(place, problem));
        }
    }
    Ok(animation)
}

impl Animation {
    /// Whether `node` moves.
    pub(super) fn moves(&self, node: usize) -> bool {
        self.nodes.contains_key(&node)
    }

    /// Whether the scale of `node` changes.
    pub(super) fn scales(&self, node: usize) -> bool {
        self.nodes.get(&node).is_some_and(|c| c.scale.is_some())
    }

    /// How `node` moves within its parent. Where no curve says else it is as at `rest`, but scaled
    /// evenly by `scale`.
    pub(super) fn track(
        &self,
        node: usize,
        rest: &Rest,
        scale: f64,
        place: &str,
    ) -> Result<Track, Flaw> {
        let none = Curves::default();
        let curves = self.nodes.get(&node).unwrap_or(&none);
        let all = [&curves.translation, &curves.rotation, &curves.scale];
        let mut times: Vec<f64> = all
            .iter()
            .copied()
            .flatten()
            .flat_map(Curve::stops)
            .collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        let jumps = all
            .iter()
            .copied()
            .flatten()
            .any(|c| c.interpolation == Interpolation::Step);
        let mut keys = Vec::new();
        for seconds in times {
            let sides: &[bool] = if jumps { &[true, false] } else { &[false] };
            for &before in sides {
                let at = |curve: &Option<Curve>| curve.as_ref().map(|c| c.at(seconds, before));
                let vector = |v: [f64; 4]| DVec3::new(v[0], v[1], v[2]);
                let position = at(&curves.translation).map_or(rest.translation, vector);
                let orientation = at(&curves.rotation).map_or(rest.rotation, DQuat::from_array);
                let scale = match at(&curves.scale).map(vector) {
                    None => scale,
                    Some(s) if even(s) => s.x,
                    Some(s) => {
                        let problem = format!("moves to a scale of {s}: must be even and above 0");
                        return Err(Flaw::new(place, problem));
                    }
                };
                keys.push(Key {
                    seconds,
                    placement: Similarity {
                        pose: Pose::new(position, orientation),
                        scale,
                    },
                });
            }
        }
        let repeat = if self.end > 0.0 {
            Repeat::Every(self.end)
        } else {
            Repeat::Hold
        };
        Track::new(keys, repeat).map_err(|e| Flaw::new(place, e))
    }
}

/// Whether a scale is above 0 and the same along all axes, to single precision.
pub(super) fn even(s: DVec3) -> bool {
    s.min_element() > 0.0 && s.max_element() - s.min_element() <= 1e-5 * s.max_element()
}

impl Curve {
    fn read(
        document: &Document<'_>,
        sampler: &AnimationSampler,
        is_rotation: bool,
        keys_left: &mut usize,
        place: &str,
    ) -> Result<Self, Flaw> {
        let wrong = |problem: String| Err(Flaw::new(place, problem));
        let interpolation = match sampler.interpolation.as_deref() {
            None | Some("LINEAR") => Interpolation::Linear,
            Some("STEP") => Interpolation::Step,
            Some("CUBICSPLINE") => Interpolation::CubicSpline,
            Some(other) => {
                let valid = "LINEAR, STEP or CUBICSPLINE";
                return wrong(format!("interpolation {}: must be {valid}", shown(other)));
            }
        };
        let input = Accessor::new(document, sampler.input, "SCALAR", place)?;
        let shape = if is_rotation { "VEC4" } else { "VEC3" };
        let output = Accessor::new(document, sampler.output, shape, place)?;
        let per_key = if interpolation == Interpolation::CubicSpline {
            3
        } else {
            1
        };
        let (keys, values) = (input.count, output.count);
        if keys == 0 || keys.checked_mul(per_key) != Some(values) {
            return wrong(format!(
                "{keys} times and {values} values: {per_key} for each is needed"
            ));
        }
        let Some(left) = keys_left.checked_sub(values) else {
            let bytes = document.bytes();
            return wrong(format!(
                "{keys} keys: with those before, more than {bytes} bytes can mean"
            ));
        };
        *keys_left = left;
        let mut times: Vec<f64> = Vec::with_capacity(keys);
        for i in 0..keys {
            let [time] = input.element(i);
            let before = times.last().copied().unwrap_or(0.0);
            if !(time.is_finite() && time >= before) {
                return wrong(format!(
                    "key {i} at {time} s: must be finite and not before {before} s"
                ));
            }
            times.push(time);
        }
        let mut read = Vec::with_capacity(values);
        for i in 0..values {
            let is_tangent = per_key == 3 && i % 3 != 1;
            let value = if is_rotation {
                output.element::<4>(i)
            } else {
                let [x, y, z] = output.element::<3>(i);
                [x, y, z, 0.0]
            };
            let what = if is_tangent { "tangent" } else { "value" };
            for v in value {
                coordinate(v, what)
                    .map_err(|p| Flaw::new(place, format_args!("key {}: {p}", i / per_key)))?;
            }
            if is_rotation && !is_tangent {
                let Some(unit) = unit(value) else {
                    return wrong(format!("key {}: a rotation of length 0", i / per_key));
                };
                read.push(unit.to_array());
            } else {
                read.push(value);
            }
        }
        Ok(Self {
            interpolation,
            is_rotation,
            times,
            values: read,
        })
    }

    /// Times between which a straight line will do.
    fn stops(&self) -> Vec<f64> {
        if self.interpolation != Interpolation::CubicSpline {
            return self.times.clone();
        }
        let between = self.times.windows(2).flat_map(|w| {
            (0..SPLINE_STEPS).map(move |k| w[0] + (w[1] - w[0]) * k as f64 / SPLINE_STEPS as f64)
        });
        between.chain(self.times.last().copied()).collect()
    }

    /// The value at time `t`, or just `before` it.
    fn at(&self, t: f64, before: bool) -> [f64; 4] {
        let after = self
            .times
            .partition_point(|&time| if before { time < t } else { time <= t });
        let last = self.times.len() - 1;
        if after == 0 || after > last {
            return self.value(if after == 0 { 0 } else { last });
        }
        let (a, b) = (self.value(after - 1), self.value(after));
        let [from, to] = [self.times[after - 1], self.times[after]];
        let f = (t - from) / (to - from);
        match self.interpolation {
            Interpolation::Step => a,
            Interpolation::Linear if self.is_rotation => {
                let turned = DQuat::from_array(a).slerp(DQuat::from_array(b), f);
                turned.normalize().to_array()
            }
            Interpolation::Linear => std::array::from_fn(|k| a[k] + (b[k] - a[k]) * f),
            Interpolation::CubicSpline => {
                let leaving = self.values[3 * (after - 1) + 2];
                let arriving = self.values[3 * after];
                let (f2, f3) = (f * f, f * f * f);
                let step = to - from;
                // Hermite's form (glTF 2.0, appendix C.5).
                let value = std::array::from_fn(|k| {
                    (2.0 * f3 - 3.0 * f2 + 1.0) * a[k]
                        + step * (f3 - 2.0 * f2 + f) * leaving[k]
                        + (3.0 * f2 - 2.0 * f3) * b[k]
                        + step * (f3 - f2) * arriving[k]
                });
                match unit(value) {
                    Some(q) if self.is_rotation => q.to_array(),
                    // A spline through 0 has no direction there.
                    None if self.is_rotation => a,
                    _ => value,
                }
            }
        }
    }

    fn value(&self, key: usize) -> [f64; 4] {
        match self.interpolation {
            Interpolation::CubicSpline => self.values[3 * key + 1],
            _ => self.values[key],
        }
    }
}

/// A quaternion of length 1 in the direction of `q`.
pub(super) fn unit(q: [f64; 4]) -> Option<DQuat> {
    let q = DQuat::from_array(q);
    let length = q.length();
    (length.is_finite() && length > 1e-6).then(|| q / length)
}
