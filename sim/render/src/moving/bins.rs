/// For each tile, the triangles of one list that may cover a sample of it, in the list's order.
#[derive(Debug)]
pub(crate) struct TileBins {
    first: Vec<u32>,
    entries: Vec<u32>,
}

impl TileBins {
    /// Sorts pairs of tile and triangle by tile (a stable counting sort).
    pub(crate) fn new(pairs: &[[u32; 2]], tiles: usize) -> Self {
        let mut first = vec![0u32; tiles + 1];
        for [tile, _] in pairs {
            first[*tile as usize + 1] += 1;
        }
        for i in 0..tiles {
            first[i + 1] += first[i];
        }
        let mut next = first.clone();
        let mut entries = vec![0; pairs.len()];
        for [tile, triangle] in pairs {
            let place = &mut next[*tile as usize];
            entries[*place as usize] = *triangle;
            *place += 1;
        }
        Self { first, entries }
    }

    /// The triangles of a tile.
    pub(crate) fn tile(&self, tile: usize) -> &[u32] {
        &self.entries[self.first[tile] as usize..self.first[tile + 1] as usize]
    }
}
