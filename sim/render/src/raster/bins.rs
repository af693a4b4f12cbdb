use glam::UVec2;

use super::SetUpTriangle;
use crate::tile::TILE;

/// For each tile, the triangles of one list whose bounds meet it, in the list's order.
#[derive(Debug)]
pub(crate) struct Bins {
    across: u32,
    first: Vec<u32>,
    entries: Vec<u32>,
}

impl Bins {
    /// Sorts by tile (a stable counting sort).
    pub(crate) fn new(triangles: &[SetUpTriangle], size: UVec2) -> Self {
        let tiles = UVec2::new(size.x.div_ceil(TILE), size.y.div_ceil(TILE));
        let count = (tiles.x * tiles.y) as usize;
        let mut first = vec![0u32; count + 1];
        for triangle in triangles {
            for_each_tile(triangle, tiles, |tile| first[tile + 1] += 1);
        }
        for i in 0..count {
            first[i + 1] += first[i];
        }
        let mut next = first.clone();
        let mut entries = vec![0; first[count] as usize];
        for (place, triangle) in triangles.iter().enumerate() {
            for_each_tile(triangle, tiles, |tile| {
                entries[next[tile] as usize] = place as u32;
                next[tile] += 1;
            });
        }
        Self {
            across: tiles.x,
            first,
            entries,
        }
    }

    /// The places in the list of the triangles of tile (x, y).
    pub(crate) fn tile(&self, x: u32, y: u32) -> &[u32] {
        let tile = (y * self.across + x) as usize;
        &self.entries[self.first[tile] as usize..self.first[tile + 1] as usize]
    }
}

#[inline(always)]
fn for_each_tile(triangle: &SetUpTriangle, tiles: UVec2, mut visit: impl FnMut(usize)) {
    let [[x0, x1], [y0, y1]] = triangle.bounds.map(|b| b.map(|s| u32::from(s) / TILE));
    for ty in y0..=y1 {
        for tx in x0..=x1 {
            visit((ty * tiles.x + tx) as usize);
        }
    }
}
