use glam::UVec2;

use super::node::Sides;
use super::{Facing, Forms, Node, Real, SampleTable};

/// The blocks of a sample table at three sizes, each in the next. They are made once for a plan and view
/// and serve every triangle.
#[derive(Debug, Clone, PartialEq)]
pub struct Nodes<T> {
    lattice: UVec2,
    /// By level, row by row; `None` where no sample is live.
    levels: [Vec<Option<Node<T>>>; 3],
}

/// What a visit did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Visits {
    /// Blocks for which the bound was evaluated, by size.
    pub nodes: [u64; 3],
    /// The smallest blocks that were left: their samples are to be tested one by one.
    pub blocks: u64,
}

impl<T: Real> Nodes<T> {
    /// Samples each way of the blocks: tiles, parts of a tile, and what a kernel tests at once.
    pub const SIZES: [u32; 3] = [64, 16, 4];

    /// Of all samples of a table.
    pub fn new(table: &SampleTable<T>) -> Self {
        let lattice = table.lattice();
        let levels = Self::SIZES.map(|size| {
            let blocks = (lattice + (size - 1)) / size;
            let all = (0..blocks.y).flat_map(|y| (0..blocks.x).map(move |x| UVec2::new(x, y)));
            all.map(|block| Node::of(table, block * size, size))
                .collect()
        });
        Self { lattice, levels }
    }

    /// Calls `visit` with the first sample of every smallest block that the triangle may cover, by tile and
    /// in rows.
    pub fn visit(&self, forms: &Forms<T>, mut visit: impl FnMut(UVec2)) -> Visits {
        let mut visits = Visits::default();
        let sides = Sides {
            front: true,
            back: forms.facing() == Facing::Both,
        };
        self.descend(
            0,
            UVec2::ZERO,
            self.lattice,
            forms,
            sides,
            &mut visits,
            &mut visit,
        );
        visits
    }

    /// Blocks of a level within `first..end`, whose samples see at most `sides`.
    fn descend(
        &self,
        level: usize,
        first: UVec2,
        end: UVec2,
        forms: &Forms<T>,
        sides: Sides,
        visits: &mut Visits,
        visit: &mut impl FnMut(UVec2),
    ) {
        let size = Self::SIZES[level];
        let across = self.lattice.x.div_ceil(size);
        for y in first.y / size..end.y.div_ceil(size) {
            for x in first.x / size..end.x.div_ceil(size) {
                let Some(node) = &self.levels[level][(y * across + x) as usize] else {
                    continue;
                };
                visits.nodes[level] += 1;
                let seen = node.sides(forms);
                let seen = Sides {
                    front: seen.front && sides.front,
                    back: seen.back && sides.back,
                };
                if !(seen.front || seen.back) {
                    continue;
                }
                let at = UVec2::new(x, y) * size;
                if level + 1 == Self::SIZES.len() {
                    visits.blocks += 1;
                    visit(at);
                } else {
                    let end = (at + size).min(self.lattice);
                    self.descend(level + 1, at, end, forms, seen, visits, visit);
                }
            }
        }
    }
}
