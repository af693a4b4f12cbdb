use crate::tile::LANES;

/// As many evaluations of shading as there are lanes, from anywhere in a tile, side by side. Each is of a triangle (or
/// the sky) in a sample, or in a block of coarse shading.
#[derive(Debug, Clone)]
pub(crate) struct Group {
    /// How many lanes are in use; the others repeat the last.
    pub(crate) count: usize,
    /// Which of the tile's visible triangles; of the sky, whatever.
    pub(crate) names: [u32; LANES],
    /// Middles, across and down, from the tile's first corner [samples].
    pub(crate) middle: [[f32; LANES]; 2],
    /// Along the longer side, how many samples share the evaluation.
    pub(crate) coarseness: [f32; LANES],
    /// Lanes whose middle may lie outside of their triangle.
    pub(crate) beside: u32,
    /// First sample in the tile.
    pub(crate) first: [[u8; 2]; LANES],
    /// Samples across and down.
    pub(crate) size: [[u8; 2]; LANES],
    /// For each sample, row by row, at which positions of visibility it is seen.
    pub(crate) seen: [u64; LANES],
}

/// One evaluation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fragment {
    pub(crate) name: u32,
    pub(crate) first: [u8; 2],
    pub(crate) size: [u8; 2],
    pub(crate) seen: u64,
    /// Whether its middle may lie outside of its triangle.
    pub(crate) beside: bool,
}

impl Group {
    const EMPTY: Self = Self {
        count: 0,
        names: [0; LANES],
        middle: [[0.0; LANES]; 2],
        coarseness: [1.0; LANES],
        beside: 0,
        first: [[0; 2]; LANES],
        size: [[1; 2]; LANES],
        seen: [0; LANES],
    };

    #[inline(always)]
    fn put(&mut self, lane: usize, fragment: Fragment) {
        let Fragment {
            name,
            first: [x, y],
            size: [width, height],
            seen,
            beside,
        } = fragment;
        let lane = lane % LANES;
        self.names[lane] = name;
        self.middle[0][lane] = f32::from(x) + 0.5 * f32::from(width);
        self.middle[1][lane] = f32::from(y) + 0.5 * f32::from(height);
        self.coarseness[lane] = f32::from(width.max(height));
        self.beside |= u32::from(beside) << lane;
        self.first[lane] = fragment.first;
        self.size[lane] = fragment.size;
        self.seen[lane] = seen;
    }
}

/// Evaluations of shading in groups, all of them full but the last.
#[derive(Debug, Default)]
pub(crate) struct Groups {
    /// More than are in use: their memory is used again.
    groups: Vec<Group>,
    count: usize,
}

impl Groups {
    /// How many evaluations there are.
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// The groups.
    pub(crate) fn all(&self) -> &[Group] {
        &self.groups[..self.count.div_ceil(LANES)]
    }

    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    #[inline(always)]
    pub(crate) fn push(&mut self, fragment: Fragment) {
        let (group, lane) = (self.count / LANES, self.count % LANES);
        if group == self.groups.len() {
            self.groups.push(Group::EMPTY);
        }
        let group = &mut self.groups[group];
        if lane == 0 {
            group.beside = 0;
        }
        group.put(lane, fragment);
        group.count = lane + 1;
        self.count += 1;
    }

    /// Fills the lanes of the last group that are not in use.
    pub(crate) fn fill(&mut self) {
        let Some(group) = self.count.checked_sub(1).map(|last| last / LANES) else {
            return;
        };
        let group = &mut self.groups[group];
        let last = group.count - 1;
        for lane in group.count..LANES {
            group.names[lane] = group.names[last];
            group.coarseness[lane] = group.coarseness[last];
            for middle in &mut group.middle {
                middle[lane] = middle[last];
            }
            group.first[lane] = group.first[last];
            group.beside |= (group.beside >> last & 1) << lane;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_hold_what_was_pushed_and_repeat_the_last() {
        let mut groups = Groups::default();
        assert!(groups.all().is_empty());
        groups.fill();
        // The second time, memory holds the first time's.
        for count in [2 * LANES + 3, LANES + 1, LANES] {
            groups.clear();
            for k in 0..count {
                groups.push(Fragment {
                    name: k as u32,
                    first: [k as u8, 2],
                    size: [2, 1],
                    seen: 1 << k,
                    beside: k.is_multiple_of(2),
                });
            }
            groups.fill();
            assert_eq!(groups.len(), count);
            assert_eq!(groups.all().len(), count.div_ceil(LANES));
            for (g, group) in groups.all().iter().enumerate() {
                for lane in 0..LANES {
                    let k = (g * LANES + lane).min(count - 1);
                    assert_eq!(lane < group.count, g * LANES + lane < count);
                    assert_eq!(group.names[lane], k as u32);
                    assert_eq!(group.middle[0][lane], k as f32 + 1.0);
                    assert_eq!((group.middle[1][lane], group.coarseness[lane]), (2.5, 2.0));
                    assert_eq!(group.beside >> lane & 1, u32::from(k.is_multiple_of(2)));
                    assert_eq!(group.first[lane], [k as u8, 2]);
                    if lane < group.count {
                        assert_eq!((group.size[lane], group.seen[lane]), ([2, 1], 1 << k));
                    }
                }
            }
        }
    }
}
