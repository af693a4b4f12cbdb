use glam::UVec2;

use super::SetUpTriangle;
use crate::tile::TILE;

/// Names a set-up triangle: its list and its place in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TriangleRef(u32);

/// A job of 512 triangles sets up at most 6 for each (a triangle cut by five planes has 8 corners).
const PLACE_BITS: u32 = 12;

impl TriangleRef {
    pub(crate) fn get(self, lists: &[Vec<SetUpTriangle>]) -> &SetUpTriangle {
        &lists[(self.0 >> PLACE_BITS) as usize][(self.0 & ((1 << PLACE_BITS) - 1)) as usize]
    }
}

/// For each tile, the triangles whose bounds meet it, in the order of the scene.
#[derive(Debug)]
pub(crate) struct Bins {
    tiles: UVec2,
    first: Vec<u32>,
    entries: Vec<TriangleRef>,
}

impl Bins {
    /// Sorts by tile (a stable counting sort).
    pub(crate) fn new(lists: &[Vec<SetUpTriangle>], size: UVec2) -> Self {
        let tiles = UVec2::new(size.x.div_ceil(TILE), size.y.div_ceil(TILE));
        let count = (tiles.x * tiles.y) as usize;
        let mut first = vec![0u32; count + 1];
        for triangle in lists.iter().flatten() {
            for_each_tile(triangle, tiles, |tile| first[tile + 1] += 1);
        }
        for i in 0..count {
            first[i + 1] += first[i];
        }
        let mut next = first.clone();
        let mut entries = vec![TriangleRef(0); first[count] as usize];
        for (list, triangles) in lists.iter().enumerate() {
            for (place, triangle) in triangles.iter().enumerate() {
                let name = TriangleRef((list as u32) << PLACE_BITS | place as u32);
                for_each_tile(triangle, tiles, |tile| {
                    entries[next[tile] as usize] = name;
                    next[tile] += 1;
                });
            }
        }
        Self {
            tiles,
            first,
            entries,
        }
    }

    /// The triangles of tile (x, y).
    pub(crate) fn tile(&self, x: u32, y: u32) -> &[TriangleRef] {
        let tile = (y * self.tiles.x + x) as usize;
        &self.entries[self.first[tile] as usize..self.first[tile + 1] as usize]
    }
}

fn for_each_tile(triangle: &SetUpTriangle, tiles: UVec2, mut visit: impl FnMut(usize)) {
    let tile = TILE as i32;
    let [x, y] = triangle.sample_bounds();
    let range = |[low, high]: [i32; 2], count: u32| {
        (low.max(0) / tile) as u32..((high.max(0) / tile) as u32 + 1).min(count)
    };
    for ty in range(y, tiles.y) {
        for tx in range(x, tiles.x) {
            visit((ty * tiles.x + tx) as usize);
        }
    }
}
