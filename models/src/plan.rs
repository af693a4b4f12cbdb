use std::num::NonZeroU32;
use std::sync::Arc;

use glam::{DVec2, DVec3, UVec2};

use crate::{Eye, ModelError, Rect};

/// Where a foveation method puts its samples: data, not code in a renderer. The same plan is counted
/// and drawn, so prediction and picture cannot drift apart.
#[derive(Debug, Clone, PartialEq)]
pub struct SamplePlan {
    /// The method that made it, as users write it (`layers:3`).
    pub method: String,
    /// The image it is for.
    pub display_px: UVec2,
    /// What is sampled, innermost first.
    pub passes: Vec<Pass>,
    /// How the passes become the displayed image.
    pub resolve: Resolve,
}

/// One set of samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Pass {
    /// Whose image.
    pub eye: Eye,
    /// How many samples, and how they are ordered.
    pub lattice: Lattice,
    /// Where they lie on the display.
    pub map: Map,
    /// Which of the lattice's samples are drawn.
    pub region: Region,
    /// Where in its cell each sample is taken: a shift from the middle, in lattice steps, each part from
    /// −½ to ½. It stands for the whole cell all the same, so reconstruction takes it to be in the
    /// middle. Jitter is a shift that changes from frame to frame (Guenter 2012, §4.2).
    pub offset: DVec2,
    /// How visibility is found for them.
    pub visibility: Visibility,
    /// Where shading is evaluated.
    pub shading: Shading,
    /// In which frames.
    pub cadence: Cadence,
}

/// The index space of a pass's samples. Sample (i, j) sits at (i + ½, j + ½).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Lattice {
    /// A regular grid, width × height.
    Grid(UVec2),
}

/// From lattice to display pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Map {
    /// Scale and shift.
    Affine(Affine),
}

/// display = origin + scale · lattice, per axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Affine {
    /// Display pixel of lattice position (0, 0).
    pub origin: DVec2,
    /// Display pixels per lattice step.
    pub scale: DVec2,
}

/// Which samples of a lattice are drawn.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Region {
    /// All.
    All,
    /// Those in live cells.
    Cells(CellMask),
}

/// A lattice cut into equal cells (the last of a row or column may be cut short), each live or not.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CellMask {
    lattice: UVec2,
    cell: UVec2,
    live: Arc<[bool]>,
}

/// How visibility is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Visibility {
    /// For each sample of the pass, at one or more positions in its cell.
    Own(Msaa),
}

/// Multisample antialiasing: at how many positions of a sample's cell visibility is found. Shading is
/// evaluated once for each triangle that is visible at any of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Msaa {
    /// In the middle.
    #[default]
    One,
    /// At four, on a rotated grid.
    Four,
}

/// Where shading is evaluated.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Shading {
    /// Once for each sample and each triangle visible in it.
    PerSample,
    /// Once for each block of samples and each triangle visible in it (variable-rate shading).
    Coarse(TileRates),
}

/// Shading rates of square tiles of samples.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TileRates {
    lattice: UVec2,
    tile: u32,
    rates: Arc<[ShadingRate]>,
}

/// Samples across and down that share an evaluation of shading: each 1, 2 or 4.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ShadingRate {
    /// Across.
    pub x: u32,
    /// Down.
    pub y: u32,
}

/// In which frames a pass is drawn: those with `frame % every == phase` (a phase from `every` on is
/// never due).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cadence {
    /// One frame in this many.
    pub every: NonZeroU32,
    /// Which one.
    pub phase: u32,
}

/// How passes become the displayed image.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Resolve {
    /// The only pass is the image, sample for pixel.
    Direct,
    /// Passes are interpolated bilinearly and blended by eccentricity.
    Feather(Feather),
    /// Each pixel comes from the first pass that has a live sample whose cell holds it, interpolated
    /// bilinearly; where a neighbour is not live, the sample that holds the pixel stands for it.
    Mosaic,
}

/// Circular blending masks about the gaze (Guenter 2012, Fig. 3), measured by the tangent of
/// eccentricity so that no inverse trigonometry is needed per pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Feather {
    /// Unit gaze direction, eye frame.
    pub gaze: DVec3,
    /// For each pass but the last: tangents of the eccentricity where its weight begins to fall from
    /// one, and where it reaches zero (smoothstep between).
    pub edges_tan: Vec<[f64; 2]>,
}

/// Samples of one pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PassCount {
    /// Samples each time it is drawn: live ones.
    pub samples: u64,
    /// At most how often shading is evaluated each time, if no sample shows two triangles: once for
    /// each sample, or for each block of coarse shading that has a live sample.
    pub shadings: u64,
    /// One frame in this many.
    pub every: u32,
}

/// Exact sample counts of a plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlanCount {
    /// Per pass, in the plan's order.
    pub passes: Vec<PassCount>,
    /// Pixels of the image the plan is for.
    pub display_pixels: u64,
}

impl Cadence {
    /// Every frame.
    pub const EVERY_FRAME: Self = Self {
        every: NonZeroU32::MIN,
        phase: 0,
    };

    /// Whether the pass is drawn in `frame`.
    pub fn is_due(self, frame: u64) -> bool {
        frame % u64::from(self.every.get()) == u64::from(self.phase)
    }
}

impl Lattice {
    /// How many samples.
    pub fn samples(self) -> u64 {
        match self {
            Self::Grid(size) => u64::from(size.x) * u64::from(size.y),
        }
    }
}

impl CellMask {
    /// Cuts `lattice` into cells of `cell` samples (each side at least 1; clamped) and asks for each,
    /// by column and row, whether it is live.
    pub fn new(lattice: UVec2, cell: UVec2, mut is_live: impl FnMut(UVec2) -> bool) -> Self {
        let cell = cell.max(UVec2::ONE);
        let cells = cells(lattice, cell);
        let live = (0..cells.y)
            .flat_map(|y| (0..cells.x).map(move |x| UVec2::new(x, y)))
            .map(&mut is_live)
            .collect();
        Self {
            lattice,
            cell,
            live,
        }
    }

    /// The lattice that it is for.
    pub fn lattice(&self) -> UVec2 {
        self.lattice
    }

    /// Samples across and down of a cell.
    pub fn cell(&self) -> UVec2 {
        self.cell
    }

    /// Whether a sample of the lattice is live.
    ///
    /// # Panics
    /// If there is no such sample.
    pub fn is_live(&self, sample: UVec2) -> bool {
        assert!(sample.cmplt(self.lattice).all(), "no sample {sample}");
        let place = sample / self.cell;
        self.live[(place.y * cells(self.lattice, self.cell).x + place.x) as usize]
    }

    /// How many samples are live.
    pub fn samples(&self) -> u64 {
        let across = cells(self.lattice, self.cell).x as usize;
        let size = |index: usize| {
            let first = UVec2::new((index % across) as u32, (index / across) as u32) * self.cell;
            let size = (self.lattice - first).min(self.cell);
            u64::from(size.x) * u64::from(size.y)
        };
        let live = self.live.iter().enumerate().filter(|(_, live)| **live);
        live.map(|(index, _)| size(index)).sum()
    }
}

fn cells(lattice: UVec2, cell: UVec2) -> UVec2 {
    UVec2::new(lattice.x.div_ceil(cell.x), lattice.y.div_ceil(cell.y))
}

impl Msaa {
    /// Positions of visibility per sample.
    pub fn positions(self) -> u32 {
        match self {
            Self::One => 1,
            Self::Four => 4,
        }
    }
}

impl ShadingRate {
    /// Every sample by itself.
    pub const FULL: Self = Self { x: 1, y: 1 };

    /// A rate.
    ///
    /// # Errors
    /// If a side is not 1, 2 or 4.
    pub fn new(x: u32, y: u32) -> Result<Self, ModelError> {
        if [x, y].iter().all(|side| matches!(side, 1 | 2 | 4)) {
            return Ok(Self { x, y });
        }
        let value = format!("{x}x{y}");
        Err(ModelError::range(
            "shading rate",
            value,
            "1, 2 or 4 samples a side",
        ))
    }
}

impl TileRates {
    /// Cuts `lattice` into tiles of `tile` samples and asks for the rate of each, by column and row.
    ///
    /// # Errors
    /// If a tile is not 4, 8, 16, 32 or 64 samples (all rates divide them).
    pub fn new(
        lattice: UVec2,
        tile: u32,
        mut rate: impl FnMut(UVec2) -> ShadingRate,
    ) -> Result<Self, ModelError> {
        if !matches!(tile, 4 | 8 | 16 | 32 | 64) {
            let valid = "4, 8, 16, 32 or 64 samples";
            return Err(ModelError::range(
                "shading-rate tile",
                tile.to_string(),
                valid,
            ));
        }
        let tiles = cells(lattice, UVec2::splat(tile));
        let rates = (0..tiles.y)
            .flat_map(|y| (0..tiles.x).map(move |x| UVec2::new(x, y)))
            .map(&mut rate)
            .collect();
        Ok(Self {
            lattice,
            tile,
            rates,
        })
    }

    /// The lattice that they are for.
    pub fn lattice(&self) -> UVec2 {
        self.lattice
    }

    /// Samples along each side of a tile.
    pub fn tile(&self) -> u32 {
        self.tile
    }

    /// The rate at a sample of the lattice.
    ///
    /// # Panics
    /// If there is no such sample.
    pub fn rate(&self, sample: UVec2) -> ShadingRate {
        assert!(sample.cmplt(self.lattice).all(), "no sample {sample}");
        let place = sample / self.tile;
        self.rates[(place.y * self.lattice.x.div_ceil(self.tile) + place.x) as usize]
    }

    /// Blocks of shading that hold a sample for which `is_live` holds.
    fn blocks(&self, is_live: impl Fn(UVec2) -> bool) -> u64 {
        let mut blocks = 0;
        for y in (0..self.lattice.y).step_by(self.tile as usize) {
            for x in (0..self.lattice.x).step_by(self.tile as usize) {
                let tile = UVec2::new(x, y);
                let end = (tile + self.tile).min(self.lattice);
                let rate = self.rate(tile);
                for by in (y..end.y).step_by(rate.y as usize) {
                    for bx in (x..end.x).step_by(rate.x as usize) {
                        let live = (by..(by + rate.y).min(end.y)).any(|sy| {
                            (bx..(bx + rate.x).min(end.x)).any(|sx| is_live(UVec2::new(sx, sy)))
                        });
                        blocks += u64::from(live);
                    }
                }
            }
        }
        blocks
    }
}

impl Pass {
    /// How many samples are drawn: the live ones.
    pub fn samples(&self) -> u64 {
        match &self.region {
            Region::All => self.lattice.samples(),
            Region::Cells(mask) => mask.samples(),
        }
    }

    /// At most how often shading is evaluated where no sample shows two triangles.
    pub fn shadings(&self) -> u64 {
        match (&self.shading, &self.region) {
            (Shading::PerSample, _) => self.samples(),
            (Shading::Coarse(rates), Region::All) => rates.blocks(|_| true),
            (Shading::Coarse(rates), Region::Cells(mask)) => rates.blocks(|s| mask.is_live(s)),
        }
    }
}

impl Affine {
    /// One sample per display pixel.
    pub const IDENTITY: Self = Self {
        origin: DVec2::ZERO,
        scale: DVec2::ONE,
    };

    /// Lattice position to display pixels.
    pub fn display_from_lattice(&self, p: DVec2) -> DVec2 {
        self.origin + self.scale * p
    }

    /// Display pixels to lattice position.
    pub fn lattice_from_display(&self, p: DVec2) -> DVec2 {
        (p - self.origin) / self.scale
    }

    /// The part of the display that a grid of `size` covers.
    pub fn covers(&self, size: UVec2) -> Rect {
        let max = self.display_from_lattice(size.as_dvec2());
        Rect {
            min: self.origin,
            max,
        }
    }
}

impl SamplePlan {
    /// Every display pixel sampled once.
    pub fn full(eye: Eye, display_px: UVec2) -> Self {
        let pass = Pass {
            eye,
            lattice: Lattice::Grid(display_px),
            map: Map::Affine(Affine::IDENTITY),
            region: Region::All,
            offset: DVec2::ZERO,
            visibility: Visibility::Own(Msaa::One),
            shading: Shading::PerSample,
            cadence: Cadence::EVERY_FRAME,
        };
        Self {
            method: "full".into(),
            display_px,
            passes: vec![pass],
            resolve: Resolve::Direct,
        }
    }

    /// Exact counts.
    pub fn count(&self) -> PlanCount {
        let count = |p: &Pass| PassCount {
            samples: p.samples(),
            shadings: p.shadings(),
            every: p.cadence.every.get(),
        };
        PlanCount {
            passes: self.passes.iter().map(count).collect(),
            display_pixels: u64::from(self.display_px.x) * u64::from(self.display_px.y),
        }
    }

    /// Samples drawn in `frame`.
    pub fn samples_in_frame(&self, frame: u64) -> u64 {
        let due = self.passes.iter().filter(|p| p.cadence.is_due(frame));
        due.map(Pass::samples).sum()
    }
}

impl PlanCount {
    /// Samples when every pass is drawn.
    pub fn samples(&self) -> u64 {
        self.passes.iter().map(|p| p.samples).sum()
    }

    /// Evaluations of shading when every pass is drawn (see [`PassCount::shadings`]).
    pub fn shadings(&self) -> u64 {
        self.passes.iter().map(|p| p.shadings).sum()
    }

    /// Samples per frame on average, each pass at its own cadence.
    pub fn samples_staggered(&self) -> f64 {
        self.passes
            .iter()
            .map(|p| p.samples as f64 / f64::from(p.every))
            .sum()
    }

    /// Display pixels per sample: how many times fewer samples than full resolution.
    pub fn ratio(&self) -> f64 {
        self.display_pixels as f64 / self.samples() as f64
    }

    /// Display pixels per sample drawn, each pass at its own cadence.
    pub fn ratio_staggered(&self) -> f64 {
        self.display_pixels as f64 / self.samples_staggered()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_counts_every_pixel() {
        let plan = SamplePlan::full(Eye::Cyclopean, UVec2::new(1920, 1080));
        assert_eq!(plan.count().samples(), 1920 * 1080);
        assert_eq!(plan.count().ratio(), 1.0);
        assert_eq!(plan.samples_in_frame(3), 1920 * 1080);
    }

    #[test]
    fn frames_in_which_a_pass_is_due() {
        let due = |every, phase| {
            let cadence = Cadence {
                every: NonZeroU32::new(every).unwrap(),
                phase,
            };
            (0..6).filter(|f| cadence.is_due(*f)).collect::<Vec<_>>()
        };
        assert_eq!(due(1, 0), [0, 1, 2, 3, 4, 5]);
        assert_eq!(due(3, 1), [1, 4]);
        assert_eq!(due(2, 2), [0; 0]);
    }

    #[test]
    fn live_samples_are_counted_cell_by_cell() {
        let lattice = UVec2::new(10, 7);
        let mask = CellMask::new(lattice, UVec2::new(4, 3), |c| (c.x + c.y) % 2 == 0);
        let live = (0..7)
            .flat_map(|y| (0..10).map(move |x| UVec2::new(x, y)))
            .filter(|s| mask.is_live(*s))
            .count();
        assert_eq!(mask.samples(), live as u64);
        assert!(mask.is_live(UVec2::new(9, 6)) && !mask.is_live(UVec2::new(4, 0)));
        assert_eq!(CellMask::new(UVec2::ZERO, lattice, |_| true).samples(), 0);
    }

    #[test]
    fn blocks_of_shading_are_counted() {
        let lattice = UVec2::new(20, 9);
        let rate = |tile: UVec2| match tile.x {
            0 => ShadingRate::FULL,
            1 => ShadingRate { x: 2, y: 4 },
            _ => ShadingRate { x: 4, y: 4 },
        };
        let rates = TileRates::new(lattice, 8, rate).unwrap();
        // Rows 0-7 and row 8: 64 + 8, then 4 × 2 + 4 × 1, then 1 × 2 + 1.
        let mut pass = SamplePlan::full(Eye::Cyclopean, lattice).passes.remove(0);
        pass.shading = Shading::Coarse(rates);
        assert_eq!(pass.shadings(), 72 + 12 + 3);
        assert_eq!(pass.samples(), 180);
        let mask = CellMask::new(lattice, UVec2::splat(16), |c| c == UVec2::ZERO);
        pass.region = Region::Cells(mask);
        assert_eq!(pass.shadings(), 72 + 12);
        assert!(TileRates::new(lattice, 12, rate).is_err());
        assert!(ShadingRate::new(3, 1).is_err() && ShadingRate::new(4, 2).is_ok());
    }

    #[test]
    fn affine_inverts() {
        let map = Affine {
            origin: DVec2::new(-3.0, 7.5),
            scale: DVec2::new(2.5, 4.0),
        };
        let p = DVec2::new(11.0, -2.0);
        assert_eq!(map.lattice_from_display(map.display_from_lattice(p)), p);
    }
}
