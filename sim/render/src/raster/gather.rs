use super::{PassTriangles, SetUpTriangle};
use crate::placed::PlacedTile;
use crate::tile::TILE;

impl PassTriangles {
    /// The triangles that may cover a sample of a tile whose samples lie anywhere, of triangles set up and
    /// binned on the display's own grid with half a sample of reach: in the order they were set up.
    ///
    /// None is missed. A sample at a position lies in some pixel; a triangle that covers the position has
    /// this pixel within its bounds (half a sample of reach makes them hold every pixel that the triangle's
    /// own bounds touch), so it is in the bin of this pixel's tile, and that is among the tiles that
    /// the box around all samples meets. Each triangle is taken from the first of these.
    pub(crate) fn around(&self, placed: &PlacedTile, out: &mut Vec<SetUpTriangle>) {
        out.clear();
        let Some([[x0, x1], [y0, y1]]) = placed.tiles(TILE) else {
            return;
        };
        let mut places: Vec<u32> = Vec::new();
        for job in &self.jobs {
            places.clear();
            for y in y0..=y1 {
                for x in x0..=x1 {
                    let bin = job.bins.tile(x, y).iter();
                    places.extend(bin.filter(|&&place| {
                        let t = &job.triangles[place as usize];
                        let [first_x, first_y] = t.bounds.map(|b| u32::from(b[0]) / TILE);
                        let is_first = first_x.max(x0) == x && first_y.max(y0) == y;
                        is_first && placed.all.meets(0, t.extent())
                    }));
                }
            }
            places.sort_unstable();
            out.extend(places.iter().map(|&place| job.triangles[place as usize]));
        }
    }

    /// As [`tile`](Self::tile), the number of each triangle among all of the pass, from 0.
    pub(crate) fn tile_numbers(&self, x: u32, y: u32, out: &mut Vec<u32>) {
        out.clear();
        let mut before = 0;
        for job in &self.jobs {
            out.extend(job.bins.tile(x, y).iter().map(|&place| before + place));
            before += job.triangles.len() as u32;
        }
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.jobs.iter().map(|job| job.triangles.len()).sum()
    }

    /// The triangle of a number.
    pub(crate) fn number(&self, mut number: usize) -> &SetUpTriangle {
        for job in &self.jobs {
            match job.triangles.get(number) {
                Some(t) => return t,
                None => number -= job.triangles.len(),
            }
        }
        unreachable!("numbers are those of triangles")
    }
}

impl SetUpTriangle {
    /// Bounds of the corners along x and y \[sub-samples\].
    #[inline(always)]
    pub(crate) fn extent(&self) -> [[i32; 2]; 2] {
        let [a, b, c] = self.corners;
        [0, 1].map(|k| [a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k])])
    }
}
