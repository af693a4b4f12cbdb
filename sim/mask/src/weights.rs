use glam::{DVec2, UVec2};
use rayon::prelude::*;

use crate::natural::{NaturalNeighbours, Neighbour};
use crate::{Delaunay, Interpolation};

/// Stored weights are multiples of this, within it of the exact ones, and sum up to one exactly.
pub const WEIGHT_STEP: f64 = 1.0 / PARTS as f64;

const PARTS: u32 = 1 << 16;

/// Side of the tiles whose pixels name sites by a number of their own \[px\].
pub(crate) const TILE: u32 = 16;

/// For every pixel of a mask the sites that it is interpolated from, and with which weights.
///
/// Pixels are held tile by tile. A tile lists its sites; a pixel's entries are 16 bits of a number in that list, and
/// above them 16 bits of weight, less one, in parts of 2¹⁶. The first entry of each pixel is the one with the greatest
/// weight.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Weights {
    pub(crate) size: UVec2,
    /// Where each tile's sites and entries begin, with one more at the end.
    pub(crate) begins: Vec<[u32; 2]>,
    /// Sites of the tiles.
    pub(crate) sites: Vec<u32>,
    /// How many entries each pixel has; tile by tile, row by row, without those beyond the mask.
    pub(crate) counts: Vec<u8>,
    pub(crate) entries: Vec<u32>,
}

/// One tile of [`Weights`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tile<'a> {
    /// Its first pixel.
    pub(crate) min: UVec2,
    /// Its pixels, fewer at the mask's right and lower edge.
    pub(crate) size: UVec2,
    pub(crate) sites: &'a [u32],
    pub(crate) counts: &'a [u8],
    pub(crate) entries: &'a [u32],
}

/// The number in its tile's list, and the weight in parts of 2¹⁶.
pub(crate) fn unpack(entry: u32) -> (usize, u32) {
    ((entry & 0xffff) as usize, (entry >> 16) + 1)
}

impl Weights {
    /// Of every pixel's middle. `stands_for` names the site of each vertex of `delaunay`, and `nearest` the nearest
    /// vertex of each pixel.
    pub(crate) fn build(
        size: UVec2,
        delaunay: &Delaunay,
        stands_for: &[u32],
        nearest: &[u32],
        interpolation: Interpolation,
    ) -> Self {
        let tiles = tiles(size);
        let sites = delaunay.sites().len();
        let parts: Vec<Part> = (0..tiles.y)
            .into_par_iter()
            .flat_map_iter(|row| {
                let mut maker = Maker {
                    neighbours: NaturalNeighbours::new(delaunay),
                    stands_for,
                    interpolation,
                    found: Vec::new(),
                    quantised: Vec::new(),
                    local: vec![(u32::MAX, 0); sites],
                };
                (0..tiles.x)
                    .map(|column| {
                        let tile = UVec2::new(column, row);
                        maker.tile(size, tile, nearest)
                    })
                    .collect::<Vec<_>>()
            })
            .collect();
        let mut weights = Self {
            size,
            begins: vec![[0, 0]],
            sites: Vec::with_capacity(parts.iter().map(|p| p.sites.len()).sum()),
            counts: Vec::with_capacity(nearest.len()),
            entries: Vec::with_capacity(parts.iter().map(|p| p.entries.len()).sum()),
        };
        for part in parts {
            weights.sites.extend(part.sites);
            weights.counts.extend(part.counts);
            weights.entries.extend(part.entries);
            let ends = [weights.sites.len() as u32, weights.entries.len() as u32];
            weights.begins.push(ends);
        }
        weights
    }

    /// Pixels.
    pub fn size(&self) -> UVec2 {
        self.size
    }

    /// All weights that are held.
    pub fn entries(&self) -> u64 {
        self.entries.len() as u64
    }

    /// Memory that they take \[bytes\].
    pub fn bytes(&self) -> u64 {
        (8 * self.begins.len() + 4 * (self.sites.len() + self.entries.len()) + self.counts.len())
            as u64
    }

    /// Sites and weights of pixel (x, y), the greatest weight first; they sum up to one.
    ///
    /// # Panics
    /// If there is no such pixel.
    pub fn at(&self, pixel: UVec2) -> Vec<Neighbour> {
        assert!(
            pixel.x < self.size.x && pixel.y < self.size.y,
            "pixel {pixel}"
        );
        let tile = self.tile(pixel / TILE);
        let within = pixel - tile.min;
        let index = (within.y * tile.size.x + within.x) as usize;
        let before: usize = tile.counts[..index].iter().map(|&n| usize::from(n)).sum();
        let entries = &tile.entries[before..][..usize::from(tile.counts[index])];
        let neighbour = |&entry: &u32| {
            let (local, parts) = unpack(entry);
            Neighbour {
                site: tile.sites[local],
                weight: f64::from(parts) * WEIGHT_STEP,
            }
        };
        entries.iter().map(neighbour).collect()
    }

    /// Tile `at`.
    pub(crate) fn tile(&self, at: UVec2) -> Tile<'_> {
        let tiles = tiles(self.size);
        let min = at * TILE;
        let size = (min + TILE).min(self.size) - min;
        let index = (at.y * tiles.x + at.x) as usize;
        let ([site, entry], [site_end, entry_end]) = (self.begins[index], self.begins[index + 1]);
        // Rows of tiles above are as wide as the mask, tiles to the left as high as this.
        let pixels = min.y as usize * self.size.x as usize + min.x as usize * size.y as usize;
        Tile {
            min,
            size,
            sites: &self.sites[site as usize..site_end as usize],
            counts: &self.counts[pixels..][..(size.x * size.y) as usize],
            entries: &self.entries[entry as usize..entry_end as usize],
        }
    }

    /// Whether all that is held fits together, for masks of `sites` sites.
    pub(crate) fn is_sound(&self, sites: usize) -> bool {
        let tiles = tiles(self.size);
        let pixels = self.size.x as usize * self.size.y as usize;
        let ends = [self.sites.len() as u32, self.entries.len() as u32];
        let ordered = self.begins.len() == tiles.x as usize * tiles.y as usize + 1
            && self.begins.first() == Some(&[0, 0])
            && self.begins.last() == Some(&ends)
            && self
                .begins
                .windows(2)
                .all(|w| w[0][0] <= w[1][0] && w[0][1] <= w[1][1]);
        ordered
            && self.counts.len() == pixels
            && self.sites.par_iter().all(|&s| (s as usize) < sites)
            && (0..tiles.y).into_par_iter().all(|y| {
                (0..tiles.x).all(|x| {
                    let tile = self.tile(UVec2::new(x, y));
                    let named: usize = tile.counts.iter().map(|&n| usize::from(n)).sum();
                    let last = tile.entries.iter().map(|e| e & 0xffff).max();
                    named == tile.entries.len()
                        && !tile.counts.contains(&0)
                        && last.is_some_and(|l| (l as usize) < tile.sites.len())
                })
            })
    }
}

/// Columns and rows of tiles.
pub(crate) fn tiles(size: UVec2) -> UVec2 {
    UVec2::new(size.x.div_ceil(TILE), size.y.div_ceil(TILE))
}

/// A tile's part of [`Weights`].
struct Part {
    sites: Vec<u32>,
    counts: Vec<u8>,
    entries: Vec<u32>,
}

struct Maker<'a> {
    neighbours: NaturalNeighbours<'a>,
    stands_for: &'a [u32],
    interpolation: Interpolation,
    found: Vec<Neighbour>,
    quantised: Vec<(u32, u32)>,
    /// For every site the tile in which it was last seen, and its number there.
    local: Vec<(u32, u16)>,
}

impl Maker<'_> {
    fn tile(&mut self, size: UVec2, tile: UVec2, nearest: &[u32]) -> Part {
        let min = tile * TILE;
        let end = (min + TILE).min(size);
        let mut part = Part {
            sites: Vec::new(),
            counts: Vec::new(),
            entries: Vec::new(),
        };
        for y in min.y..end.y {
            for x in min.x..end.x {
                let nearest = nearest[(y * size.x + x) as usize];
                self.pixel(UVec2::new(x, y).as_dvec2() + 0.5, nearest);
                part.counts.push(self.quantised.len() as u8);
                for &(site, parts) in &self.quantised {
                    let local = &mut self.local[site as usize];
                    if local.0 != tile.x {
                        // At most 256 pixels with 255 sites each: 16 bits suffice.
                        *local = (tile.x, part.sites.len() as u16);
                        part.sites.push(site);
                    }
                    part.entries.push(u32::from(local.1) | (parts - 1) << 16);
                }
            }
        }
        part
    }

    /// The sites and whole parts of the pixel with this middle.
    fn pixel(&mut self, middle: DVec2, nearest: u32) {
        let found = match self.interpolation {
            Interpolation::Natural => self.neighbours.sibson(middle, nearest, &mut self.found),
            Interpolation::Barycentric => {
                self.neighbours
                    .barycentric(middle, nearest, &mut self.found)
            }
            Interpolation::Nearest => false,
        };
        if !found {
            self.found.clear();
            self.found.push(Neighbour {
                site: nearest,
                weight: 1.0,
            });
        }
        for neighbour in &mut self.found {
            neighbour.site = self.stands_for[neighbour.site as usize];
        }
        quantise(&mut self.found, &mut self.quantised);
    }
}

/// Most sites of a pixel that are kept: those with the greatest weights.
const MOST: usize = 255;

/// Weights as whole parts of [`PARTS`] that sum up to it: rounded down, and what is then missing given to those that
/// lost most. Sites that come several times count once, those without a part do not count; the greatest comes first.
fn quantise(found: &mut Vec<Neighbour>, out: &mut Vec<(u32, u32)>) {
    found.sort_by_key(|n| n.site);
    found.dedup_by(|a, b| {
        let same = a.site == b.site;
        if same {
            b.weight += a.weight;
        }
        same
    });
    if found.len() > MOST {
        found.sort_by(|a, b| b.weight.total_cmp(&a.weight).then(a.site.cmp(&b.site)));
        found.truncate(MOST);
        let sum: f64 = found.iter().map(|n| n.weight).sum();
        found.iter_mut().for_each(|n| n.weight /= sum);
    }
    out.clear();
    let parts = |n: &Neighbour| n.weight * f64::from(PARTS);
    out.extend(found.iter().map(|n| (n.site, parts(n) as u32)));
    let missing = PARTS.saturating_sub(out.iter().map(|(_, p)| p).sum());
    for _ in 0..missing {
        let lost = |k: &usize| parts(&found[*k]) - f64::from(out[*k].1);
        let most = (0..out.len()).max_by(|a, b| lost(a).total_cmp(&lost(b)).then(b.cmp(a)));
        out[most.expect("a pixel has a site")].1 += 1;
    }
    out.retain(|(_, parts)| *parts > 0);
    let first = (0..out.len()).max_by_key(|&k| (out[k].1, std::cmp::Reverse(k)));
    out.swap(0, first.expect("the whole is more than no part"));
}
