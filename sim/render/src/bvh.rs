use glam::DVec3;

/// A box along the axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Aabb {
    pub(crate) min: DVec3,
    pub(crate) max: DVec3,
}

/// Boxes within boxes, for finding those that a ray meets.
///
/// Splitting at the median is enough here: it is asked for the truth, not for the last half of its
/// speed. Boxes are in double precision, so that what a ray may meet needs no argument about rounding.
#[derive(Debug)]
pub(crate) struct Bvh {
    /// The root first; the first child of a node comes right after it.
    nodes: Vec<Node>,
    /// Names of boxes, in the order of leaves.
    order: Vec<u32>,
}

#[derive(Debug)]
struct Node {
    bounds: Aabb,
    kind: Kind,
}

#[derive(Debug)]
enum Kind {
    /// Where its names begin and end.
    Leaf(u32, u32),
    /// Index of its second child.
    Inner(u32),
}

/// Most boxes of a leaf.
const LEAF: usize = 4;

/// Depth of the tree at most: each level halves up to 2³² boxes.
const DEPTH: usize = 33;

impl Aabb {
    fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    fn centre(self) -> DVec3 {
        (self.min + self.max) * 0.5
    }
}

impl Bvh {
    /// Sorts boxes, whose names are their places in the list.
    pub(crate) fn new(boxes: &[Aabb]) -> Self {
        let mut bvh = Self {
            nodes: Vec::new(),
            order: (0..boxes.len() as u32).collect(),
        };
        if !boxes.is_empty() {
            bvh.build(boxes, 0, boxes.len());
        }
        bvh
    }

    fn build(&mut self, boxes: &[Aabb], first: usize, end: usize) {
        let names = &mut self.order[first..end];
        let all = names.iter().map(|&name| boxes[name as usize]);
        let Some(bounds) = all.reduce(Aabb::union) else {
            return;
        };
        let node = self.nodes.len();
        if names.len() <= LEAF {
            let kind = Kind::Leaf(first as u32, end as u32);
            self.nodes.push(Node { bounds, kind });
            return;
        }
        let centres = names.iter().map(|&name| boxes[name as usize].centre());
        let (low, high) = centres.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), c| {
            (low.min(c), high.max(c))
        });
        let axis = (high - low).max_position();
        let middle = names.len() / 2;
        names.select_nth_unstable_by(middle, |&a, &b| {
            let at = |name: u32| boxes[name as usize].centre()[axis];
            at(a).total_cmp(&at(b)).then(a.cmp(&b))
        });
        let kind = Kind::Inner(0);
        self.nodes.push(Node { bounds, kind });
        self.build(boxes, first, first + middle);
        self.nodes[node].kind = Kind::Inner(self.nodes.len() as u32);
        self.build(boxes, first + middle, end);
    }

    /// Goes through the boxes inside all that `enters` lets it into, and names them to `visit`.
    pub(crate) fn traverse<State>(
        &self,
        state: &mut State,
        enters: impl Fn(&State, &Aabb) -> bool,
        mut visit: impl FnMut(&mut State, u32),
    ) {
        let mut rest = Vec::with_capacity(DEPTH);
        rest.extend((!self.nodes.is_empty()).then_some(0));
        while let Some(place) = rest.pop() {
            let node = &self.nodes[place as usize];
            if !enters(state, &node.bounds) {
                continue;
            }
            match node.kind {
                Kind::Leaf(first, end) => {
                    for &name in &self.order[first as usize..end as usize] {
                        visit(state, name);
                    }
                }
                Kind::Inner(second) => rest.extend([second, place + 1]),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use foveasim_models::{Role, Stream};

    use super::*;

    #[test]
    fn it_finds_all_boxes_that_hold_a_point_and_no_name_twice() {
        let random = &mut Stream::new(1, Role::Scene, 0);
        for count in [0, 1, 4, 5, 9, 1000] {
            let boxes: Vec<_> = (0..count)
                .map(|_| {
                    let mut point =
                        |low, high| DVec3::from_array([0; 3].map(|_| random.range(low, high)));
                    // Many have the same place.
                    let min = point(-4.0, 4.0).floor();
                    let max = min + point(0.0, 3.0);
                    Aabb { min, max }
                })
                .collect();
            let bvh = Bvh::new(&boxes);
            for _ in 0..50 {
                let p = DVec3::from_array([0; 3].map(|_| random.range(-5.0, 5.0)));
                let holds = |b: &Aabb| p.cmpge(b.min).all() && p.cmple(b.max).all();
                let mut found = Vec::new();
                bvh.traverse(&mut found, |_, b| holds(b), |found, name| found.push(name));
                found.retain(|&name| holds(&boxes[name as usize]));
                found.sort_unstable();
                let wanted: Vec<u32> = (0..count as u32)
                    .filter(|&name| holds(&boxes[name as usize]))
                    .collect();
                assert_eq!(found, wanted);
            }
        }
    }
}
