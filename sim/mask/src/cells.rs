use glam::{DVec2, UVec2};
use rayon::prelude::*;

/// Side of the blocks that threads take in turn \[px\].
const BLOCK: u32 = 64;
/// Blocks no larger than this, or with few candidates, are not divided further \[px\].
const LEAF: u32 = 4;

/// Which site is nearest to the middle of each pixel, row by row: of two at the same distance the first.
///
/// Blocks of pixels are divided in four while several sites may be nearest somewhere in them. A site is out of a
/// block if another is nearer to all of its four corners, since the difference of two squared distances varies
/// linearly. Coordinates of sites have at most 24 bits, so distances are exact, and so is this.
///
/// # Panics
/// If there is no site.
pub(crate) fn nearest_sites(size: UVec2, sites: &[DVec2]) -> Vec<u32> {
    assert!(!sites.is_empty(), "cells of no sites");
    let whole = Block {
        min: UVec2::ZERO,
        side: size.max_element().next_power_of_two().max(BLOCK),
    };
    let mut blocks = vec![(whole, (0..sites.len() as u32).collect::<Vec<u32>>())];
    while blocks[0].0.side > BLOCK {
        blocks = blocks
            .into_par_iter()
            .flat_map_iter(|(block, candidates)| {
                let parts = block
                    .quarters()
                    .filter(|b| b.meets(size))
                    .collect::<Vec<_>>();
                parts.into_iter().map(move |part| {
                    let left = part.contenders(size, sites, &candidates);
                    (part, left)
                })
            })
            .collect();
    }
    // Blocks of one row of them write to rows of pixels of their own.
    blocks.sort_by_key(|(block, _)| (block.min.y, block.min.x));
    let width = size.x as usize;
    let mut owner = vec![0; width * size.y as usize];
    let per_row = size.x.div_ceil(BLOCK) as usize;
    owner
        .par_chunks_mut(width * BLOCK as usize)
        .zip(blocks.par_chunks(per_row))
        .for_each(|(rows, blocks)| {
            for (block, candidates) in blocks {
                let mut out = Rows {
                    rows,
                    size,
                    first: block.min.y,
                };
                block.assign(&mut out, sites, candidates);
            }
        });
    owner
}

/// A square of pixels, of which some may lie beyond the picture.
#[derive(Debug, Clone, Copy)]
struct Block {
    min: UVec2,
    side: u32,
}

/// Some rows of the picture, from `first` on.
struct Rows<'a> {
    rows: &'a mut [u32],
    size: UVec2,
    first: u32,
}

impl Block {
    fn quarters(self) -> impl Iterator<Item = Self> {
        let side = self.side / 2;
        (0..4).map(move |k| Self {
            min: self.min + UVec2::new(k & 1, k >> 1) * side,
            side,
        })
    }

    fn meets(self, size: UVec2) -> bool {
        self.min.x < size.x && self.min.y < size.y
    }

    /// Its last pixels within the picture.
    fn last(self, size: UVec2) -> UVec2 {
        (self.min + self.side).min(size) - 1
    }

    /// Those of `candidates` that may be nearest to one of its pixels; their order is kept.
    fn contenders(self, size: UVec2, sites: &[DVec2], candidates: &[u32]) -> Vec<u32> {
        let (a, b) = (self.min.as_dvec2() + 0.5, self.last(size).as_dvec2() + 0.5);
        let corners = [a, DVec2::new(b.x, a.y), DVec2::new(a.x, b.y), b];
        let middle = 0.5 * (a + b);
        let to = |site: u32, place: DVec2| sites[site as usize].distance_squared(place);
        let mut best = (f64::INFINITY, 0);
        for &site in candidates {
            let distance = to(site, middle);
            if distance < best.0 {
                best = (distance, site);
            }
        }
        let limits = corners.map(|c| to(best.1, c));
        let remains = |&site: &u32| {
            let at = sites[site as usize];
            corners
                .iter()
                .zip(limits)
                .any(|(&corner, limit)| at.distance_squared(corner) <= limit)
        };
        candidates.iter().copied().filter(remains).collect()
    }

    fn assign(self, out: &mut Rows<'_>, sites: &[DVec2], candidates: &[u32]) {
        if let [site] = candidates {
            for y in self.min.y..=self.last(out.size).y {
                out.row(self, y).fill(*site);
            }
        } else if self.side <= LEAF {
            for y in self.min.y..=self.last(out.size).y {
                for (x, owner) in (self.min.x..).zip(out.row(self, y)) {
                    let middle = UVec2::new(x, y).as_dvec2() + 0.5;
                    let mut least = f64::INFINITY;
                    for &site in candidates {
                        let distance = sites[site as usize].distance_squared(middle);
                        if distance < least {
                            (least, *owner) = (distance, site);
                        }
                    }
                }
            }
        } else {
            let size = out.size;
            for part in self.quarters().filter(|b| b.meets(size)) {
                let left = part.contenders(size, sites, candidates);
                part.assign(out, sites, &left);
            }
        }
    }
}

impl Rows<'_> {
    /// The pixels of row `y` that lie in `block`.
    fn row(&mut self, block: Block, y: u32) -> &mut [u32] {
        let begin = (y - self.first) as usize * self.size.x as usize;
        let last = block.last(self.size).x as usize;
        &mut self.rows[begin + block.min.x as usize..=begin + last]
    }
}

#[cfg(test)]
mod tests {
    use foveasim_models::{Role, Stream};

    use super::*;
    use crate::spec::SUBPIXELS;

    #[test]
    fn the_nearest_of_all_is_found() {
        for (k, (size, count)) in [
            (UVec2::new(100, 70), 1),
            (UVec2::new(130, 64), 7),
            (UVec2::new(64, 200), 300),
            (UVec2::new(96, 80), 9000),
        ]
        .into_iter()
        .enumerate()
        {
            let random = &mut Stream::new(3, Role::Mask, k as u64);
            let place = |random: &mut Stream| {
                let p = DVec2::new(random.uniform(), random.uniform()) * size.as_dvec2();
                (p * SUBPIXELS).floor() / SUBPIXELS
            };
            let mut sites: Vec<DVec2> = (0..count).map(|_| place(random)).collect();
            if count > 5 {
                // Ties: a site twice, and two at the same distance.
                sites[5] = sites[2];
                sites[3] = DVec2::new(10.0, 10.5);
                sites[4] = DVec2::new(13.0, 10.5);
            }
            let owner = nearest_sites(size, &sites);
            for y in 0..size.y {
                for x in 0..size.x {
                    let middle = UVec2::new(x, y).as_dvec2() + 0.5;
                    let mut least = (f64::INFINITY, 0);
                    for (s, at) in sites.iter().enumerate() {
                        let distance = at.distance_squared(middle);
                        if distance < least.0 {
                            least = (distance, s as u32);
                        }
                    }
                    assert_eq!(owner[(y * size.x + x) as usize], least.1, "{x} {y}");
                }
            }
        }
    }
}
