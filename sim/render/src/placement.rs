use foveasim_models::raster::Sampling;
use foveasim_models::{LogPolar, Map, Msaa, SamplePlan, Visibility};
use glam::{DVec2, UVec2};

use crate::Simd;
use crate::kernels::{PlacePolar, PlaceWarped, Plain, PolarTable, Seen, dispatch, sub_sample};
use crate::live::grid;
use crate::moving::{EvenPlaces, Warp};
use crate::msaa::offsets;
use crate::pass::msaa;
use crate::placed::PlacedTile;
use crate::project::SUBSAMPLES;
use crate::tile::{LANES, SampleTile, TILE_SAMPLES, position_of};

/// Where the samples of a pass lie on the display, for maps that do not spread them evenly.
///
/// A map is asked in double precision, once for each column and each row where it is a product of the two,
/// else for each sample. Positions are then rounded to sub-samples of the display's own grid, on which
/// triangles are set up (see [`PlacedTile`]). Another map needs nothing but the positions it gives.
#[derive(Debug)]
pub(crate) struct Placement {
    grid: UVec2,
    display: UVec2,
    positions: usize,
    kind: Kind,
    /// Whether samples are shaded where visibility is asked for.
    centred: bool,
    warp: Option<Warp>,
    /// Of passes with a warp, whether samples lie evenly all the same.
    even: Option<EvenPlaces>,
    /// Whether positions off the display are moved onto its edge.
    onto_display: bool,
}

#[derive(Debug)]
enum Kind {
    Polar {
        centre: DVec2,
        /// Where samples are shaded, then the positions of visibility, if they are others.
        tables: Vec<PolarTable>,
        /// For each column, over how many pixels its samples average.
        widths: Vec<f32>,
        /// For each column, the shortest step there or farther out, at least a pixel.
        least: Vec<f32>,
    },
    /// Sums, products and one power.
    Plain {
        plain: Plain,
        seen: Seen,
        shift: DVec2,
    },
    Any {
        map: Map,
        /// As the tables: shifts from the middle of a cell, in lattice steps.
        shifts: Vec<DVec2>,
    },
}

impl Placement {
    /// For pass `index` of a plan, as bent by `warp`; `None` if its samples lie evenly and look at once.
    pub(crate) fn of(plan: &SamplePlan, index: usize, warp: Option<Warp>) -> Option<Self> {
        let pass = &plan.passes[index];
        let grid = grid(pass);
        let msaa = msaa(plan, index);
        let shares = matches!(pass.visibility, Visibility::Shared(_));
        let mut shifts = vec![pass.offset];
        if msaa == Msaa::Four && !shares {
            let sub = offsets::FOUR.map(|o| DVec2::new(o[0].into(), o[1].into()));
            shifts.extend(sub.map(|o| pass.offset + o / f64::from(SUBSAMPLES)));
        }
        let centred = shifts.len() == 1;
        let (scan, lens) = match &warp {
            Some(warp) => (warp.scan.as_ref(), warp.lens.as_ref()),
            None => (None, None),
        };
        let plain = match &pass.map {
            Map::Affine(_) if warp.is_none() => return None,
            Map::Affine(map) => Some(Plain::affine(map)),
            Map::Radial(map) if centred => Plain::radial(map, plan.display_px),
            _ => None,
        };
        let kind = match (plain, pass.map) {
            (Some(plain), _) => Kind::Plain {
                plain,
                seen: Seen::new(scan, lens, plan.display_px),
                shift: pass.offset,
            },
            (None, Map::LogPolar(map)) if warp.is_none() => {
                let steps = (0..grid.x).map(|x| map.step_lengths(f64::from(x) + 0.5));
                let (widths, mut least): (Vec<f32>, Vec<f32>) = steps
                    .map(|[a, b]| (a.max(b).max(1.0) as f32, a.min(b).max(1.0) as f32))
                    .unzip();
                for x in (1..least.len()).rev() {
                    least[x - 1] = least[x - 1].min(least[x]);
                }
                Kind::Polar {
                    centre: map.gaze_px(),
                    tables: shifts.iter().map(|s| table(&map, grid, *s)).collect(),
                    widths,
                    least,
                }
            }
            (None, map) => Kind::Any { map, shifts },
        };
        Some(Self {
            grid,
            display: plan.display_px,
            positions: if shares { 1 } else { msaa.positions() as usize },
            kind,
            centred,
            even: warp.and_then(|w| w.even_places(pass, plan.display_px)),
            warp,
            onto_display: !matches!(pass.map, Map::Affine(_)),
        })
    }

    /// What bends or spreads over time what its samples look at.
    pub(crate) fn warp(&self) -> Option<&Warp> {
        self.warp.as_ref()
    }

    /// Where and when its samples look, if they lie evenly and triangles move.
    pub(crate) fn even(&self) -> Option<EvenPlaces> {
        self.even
    }

    /// Room for a tile of its samples.
    pub(crate) fn room(&self) -> PlacedTile {
        match &self.warp {
            Some(warp) if warp.scan.is_some() => PlacedTile::at_times(),
            _ => PlacedTile::new(self.positions),
        }
    }

    /// Positions per sample at which it asks for visibility; one, where another pass finds it.
    pub(crate) fn positions(&self) -> usize {
        self.positions
    }

    /// Finds where the samples of a tile lie, and over how many pixels their shading averages: the longer step
    /// between samples, at least a pixel. Not the boxes around them.
    pub(crate) fn place(&self, tile: &SampleTile, simd: Simd, out: &mut PlacedTile) {
        match &self.kind {
            Kind::Polar {
                centre,
                tables,
                widths,
                ..
            } => {
                let place = |table, to: &mut [[[i32; LANES]; 2]], first, stride| {
                    let kernel = PlacePolar {
                        table,
                        centre: *centre,
                        origin: tile.origin,
                        display: self.display,
                        out: to,
                        first,
                        stride,
                    };
                    dispatch(simd, kernel);
                };
                for (p, table) in tables[usize::from(!self.centred)..].iter().enumerate() {
                    place(table, &mut out.at, p, self.positions);
                }
                if !self.centred {
                    place(&tables[0], &mut out.middle, 0, 1);
                }
                for (index, out) in out.width.as_flattened_mut().iter_mut().enumerate() {
                    let x = tile.origin.x + position_of(index)[0];
                    *out = widths[x.min(self.grid.x - 1) as usize];
                }
            }
            Kind::Plain { plain, seen, shift } => {
                let first = tile.origin.as_dvec2() + 0.5 + *shift;
                let last = (self.grid - 1 - tile.origin).as_dvec2();
                let size = self.display.as_dvec2();
                // As far as sub-samples are on the display.
                let onto = size - 1.0 / f64::from(SUBSAMPLES);
                let onto = match self.warp {
                    Some(_) => size,
                    None => onto,
                };
                let single = |v: DVec2| [v.x as f32, v.y as f32];
                let kernel = PlaceWarped {
                    plain: *plain,
                    seen: *seen,
                    first: single(first),
                    last: single(last),
                    onto: self.onto_display.then(|| single(onto)),
                    at: &mut out.at,
                    time: &mut out.time,
                    width: &mut out.width,
                };
                dispatch(simd, kernel);
            }
            Kind::Any { map, .. } if self.warp.is_some() => self.place_any(map, tile, out),
            Kind::Any { map, shifts } => {
                for index in 0..TILE_SAMPLES {
                    let sample = tile.origin + UVec2::from(position_of(index));
                    let middle = sample.min(self.grid - 1).as_dvec2() + 0.5;
                    let (block, lane) = (index / LANES, index % LANES);
                    let at = |shift: &DVec2| {
                        let px = map.display_from_lattice(middle + *shift);
                        [0, 1].map(|k| sub_sample(px[k], self.display[k]))
                    };
                    for (p, shift) in shifts[usize::from(!self.centred)..].iter().enumerate() {
                        let [x, y] = at(shift);
                        let place = &mut out.at[block * self.positions + p];
                        (place[0][lane], place[1][lane]) = (x, y);
                    }
                    if !self.centred {
                        let [x, y] = at(&shifts[0]);
                        let place = &mut out.middle[block];
                        (place[0][lane], place[1][lane]) = (x, y);
                    }
                    let steps = map.steps(middle);
                    let longer = steps.x_axis.length().max(steps.y_axis.length());
                    out.width[block][lane] = longer.max(1.0) as f32;
                }
            }
        }
        if self.centred {
            out.middle.copy_from_slice(&out.at);
        }
    }

    /// The least step between samples \[px\], of those up to `distance` from display position `from`; at least
    /// a pixel, for what lies closer together is seen through pixels all the same.
    pub(crate) fn least_step(&self, from: DVec2, distance: f64) -> f64 {
        match &self.kind {
            Kind::Polar {
                centre,
                tables,
                least,
                ..
            } => {
                let nearest = from.distance(*centre) - distance;
                // Columns in which such places lie, and one more for what lies between two.
                let first = tables[0].radius.partition_point(|r| *r < nearest);
                let column = first.saturating_sub(1).min(least.len().max(1) - 1);
                least.get(column).map_or(1.0, |width| f64::from(*width))
            }
            // Steps of other maps are not known to be long anywhere.
            Kind::Plain { .. } | Kind::Any { .. } => 1.0,
        }
    }

    /// Where and when the samples of any map look, one by one in double precision.
    fn place_any(&self, map: &Map, tile: &SampleTile, out: &mut PlacedTile) {
        let Some(warp) = self.warp else { return };
        let sampling = Sampling {
            map: *map,
            lens: warp.lens,
            scan: warp.scan,
            display_px: self.display.as_dvec2(),
        };
        for index in 0..TILE_SAMPLES {
            let sample = tile.origin + UVec2::from(position_of(index));
            let middle = sample.min(self.grid - 1).as_dvec2() + 0.5;
            let (block, lane) = (index / LANES, index % LANES);
            let looks = match self.onto_display {
                true => sampling.at_clamped(middle),
                false => sampling.at(middle),
            };
            for (axis, px) in looks.ray.to_array().into_iter().enumerate() {
                out.at[block][axis][lane] = far_sub_sample(px);
            }
            if let Some(time) = out.time.get_mut(block) {
                time[lane] = looks.time as f32;
            }
            let mut steps = map.steps(middle);
            if let Some(lens) = &warp.lens {
                steps = lens.steps(looks.display) * steps;
            }
            let longer = steps.x_axis.length().max(steps.y_axis.length());
            out.width[block][lane] = longer.max(1.0) as f32;
        }
    }
}

/// The sub-sample nearest to an image position that may lie off the display \[px\], within ±65,535 pixels. The cast makes 0
/// of NaN.
fn far_sub_sample(px: f64) -> i32 {
    let far = 65_535 * SUBSAMPLES;
    ((px * f64::from(SUBSAMPLES) + 0.5).floor() as i32).clamp(-far, far)
}

/// Radii of a map's columns and directions of its rows, at `shift` from the middles of the cells.
fn table(map: &LogPolar, grid: UVec2, shift: DVec2) -> PolarTable {
    PolarTable {
        radius: (0..grid.x)
            .map(|x| map.radius(f64::from(x) + 0.5 + shift.x))
            .collect(),
        direction: (0..grid.y)
            .map(|y| map.direction(f64::from(y) + 0.5 + shift.y))
            .collect(),
    }
}
