use std::collections::{BTreeMap, BTreeSet};

use foveasim_models::foveation::Method;
use foveasim_models::{Map, Role, SamplePlan, Shading, Stream};

/// One cell of scenes × displays × methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Pick {
    pub(super) scene: usize,
    pub(super) group: usize,
    /// Place of the method in the sweep's list.
    pub(super) method: usize,
}

/// What is spread evenly: of each pick its scene, image size, field of view and method.
pub(super) type Strata = [u64; 4];

/// The most cells that are looked at for each pick.
const LOOKED_AT: usize = 20_000;

/// `count` of the candidates, spread over their strata: each pick is of those so far least seen; of equals the
/// first in an order drawn by `seed`.
pub(super) fn spread(candidates: &[(Pick, Strata)], count: usize, seed: u64) -> Vec<Pick> {
    let mut order: Vec<usize> = (0..candidates.len()).collect();
    let mut stream = Stream::new(seed, Role::Population, 0);
    for i in (1..order.len()).rev() {
        order.swap(i, stream.below(i as u64 + 1) as usize);
    }
    order.truncate(LOOKED_AT.max(count));
    let mut seen: [BTreeMap<u64, u64>; 4] = Default::default();
    let mut pairs: BTreeMap<(usize, u64, u64), u64> = BTreeMap::new();
    let mut picked = Vec::new();
    while picked.len() < count && !order.is_empty() {
        let cost = |&i: &usize| {
            let strata = &candidates[i].1;
            let alone = (0..4).map(|k| seen[k].get(&strata[k]).copied().unwrap_or(0));
            let method = strata[3];
            let with = (0..3).map(|k| pairs.get(&(k, strata[k], method)).copied().unwrap_or(0));
            (alone.sum::<u64>(), with.sum::<u64>())
        };
        let best = (0..order.len()).min_by_key(|&place| (cost(&order[place]), place));
        let Some(place) = best else { break };
        let chosen = order.remove(place);
        let (pick, strata) = candidates[chosen];
        for (k, value) in strata.iter().enumerate() {
            *seen[k].entry(*value).or_default() += 1;
            if k < 3 {
                *pairs.entry((k, *value, strata[3])).or_default() += 1;
            }
        }
        picked.push(pick);
    }
    picked
}

/// What kind of passes a plan has and how they are put together: plans of one kind cost by the same terms.
pub(super) fn kind(plan: &SamplePlan) -> String {
    let passes = plan.passes.iter().map(|p| {
        let placed = !matches!(p.map, Map::Affine(_));
        let coarse = matches!(p.shading, Shading::Coarse(_));
        (placed, coarse)
    });
    let passes: BTreeSet<(bool, bool)> = passes.collect();
    format!("{passes:?} {:?}", std::mem::discriminant(&plan.resolve))
}

/// What is kept from a fit: whole scenes, whole methods, and the largest image.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct HeldOut {
    pub(super) scenes: BTreeSet<usize>,
    pub(super) methods: BTreeSet<usize>,
    /// Pixels of the largest image, where there are several sizes.
    pub(super) pixels: Option<u64>,
}

impl HeldOut {
    /// A third of the scenes and a quarter of the methods, drawn by `seed`; of methods only such whose kind others
    /// have, and never full resolution.
    pub(super) fn draw(
        scenes: usize,
        methods: &[(Method, String)],
        pixels: &BTreeSet<u64>,
        seed: u64,
    ) -> Self {
        let mut stream = Stream::new(seed, Role::Population, 1);
        let mut held = Self {
            pixels: pixels.last().copied().filter(|_| pixels.len() > 1),
            ..Self::default()
        };
        while held.scenes.len() < scenes / 3 {
            held.scenes.insert(stream.below(scenes as u64) as usize);
        }
        let mut stream = Stream::new(seed, Role::Population, 2);
        let mut order: Vec<usize> = (0..methods.len()).collect();
        for i in (1..order.len()).rev() {
            order.swap(i, stream.below(i as u64 + 1) as usize);
        }
        for place in order {
            if held.methods.len() == methods.len() / 4 {
                break;
            }
            let (method, kind) = &methods[place];
            let others = methods.iter().enumerate().filter(|(k, (_, other))| {
                *k != place && other == kind && !held.methods.contains(k)
            });
            if *method != Method::Full && others.count() > 0 {
                held.methods.insert(place);
            }
        }
        held
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidates() -> Vec<(Pick, Strata)> {
        let mut all = Vec::new();
        for scene in 0..3 {
            for group in 0..12 {
                for method in 0..4 {
                    let pick = Pick {
                        scene,
                        group,
                        method,
                    };
                    let [size, fov] = [group as u64 % 4, group as u64 / 4];
                    all.push((pick, [scene as u64, size, fov, method as u64]));
                }
            }
        }
        all
    }

    #[test]
    fn picks_are_spread_and_drawn_by_the_seed() {
        let all = candidates();
        let some = spread(&all, 24, 7);
        assert_eq!(some, spread(&all, 24, 7));
        assert_ne!(some, spread(&all, 24, 8));
        let mut once = some.clone();
        once.sort();
        once.dedup();
        assert_eq!(once.len(), 24);
        for method in 0..4 {
            assert_eq!(some.iter().filter(|p| p.method == method).count(), 6);
        }
        for scene in 0..3 {
            assert_eq!(some.iter().filter(|p| p.scene == scene).count(), 8);
        }
        assert_eq!(spread(&all, 10_000, 1).len(), all.len());
    }

    #[test]
    fn whole_scenes_methods_and_the_largest_size_are_held_out() {
        let methods = [
            "full", "layers:2", "layers:3", "layers:4", "vrs", "fdm", "quad", "rates",
        ];
        let methods: Vec<(Method, String)> = methods
            .iter()
            .map(|m| (m.parse().unwrap(), m.split(':').next().unwrap().to_owned()))
            .collect();
        for seed in 0..20 {
            let held = HeldOut::draw(7, &methods, &BTreeSet::from([10, 20, 30]), seed);
            assert_eq!((held.scenes.len(), held.methods.len()), (2, 2));
            assert_eq!(held.pixels, Some(30));
            // Only layers have others of their kind, and one of them stays.
            assert!(held.methods.iter().all(|k| (1..4).contains(k)));
        }
        let one = HeldOut::draw(1, &methods[..1], &BTreeSet::from([10]), 1);
        assert_eq!(one, HeldOut::default());
    }
}
