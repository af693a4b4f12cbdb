use foveasim_assets::TransferFunction;
use foveasim_lanes::prelude::*;
use foveasim_lanes::transcendental::times_exp2;
use foveasim_lanes::wide::{F, Simd, WIDTH, splat};
use foveasim_lanes::{Instructions, Kernel, dispatch};
use foveasim_models::math::log;

/// Entries of a table.
pub(crate) const ENTRIES: usize = 4096;
/// log₂(1 − α) where nothing shines through: any step of 1/16 or more leaves less than 2⁻¹²⁶.
const OPAQUE: f32 = -4096.0;

/// A transfer function over levels: each sample takes the nearest entry.
#[derive(Debug)]
pub(crate) struct Table {
    /// Red, green, blue (linear light), and log₂ of the light that a base step lets through.
    pub(crate) entries: Box<[[f32; 4]; ENTRIES]>,
    /// The same, but for the share of light itself that a base step lets through.
    pub(crate) shares: Box<[[f32; 4]; ENTRIES]>,
    /// Entries per level.
    pub(crate) per_level: f32,
    /// For each entry, how many before it show something.
    seen_before: Vec<u32>,
    /// The greatest part of any colour that shows.
    pub(crate) brightest: f32,
}

impl Table {
    /// The table over `levels` from 0 to `highest`, whose values are `lowest` and so on every `per_level`,
    /// for steps of `units` lengths that opacities are of.
    pub(crate) fn new(
        transfer: &TransferFunction,
        lowest: f64,
        per_level: f64,
        highest: i16,
        units: f64,
    ) -> Self {
        let last = (ENTRIES - 1) as f64;
        let top = f64::from(highest.max(1));
        let mut entries = Box::new([[0.0; 4]; ENTRIES]);
        let mut seen_before = Vec::with_capacity(ENTRIES + 1);
        let (mut seen, mut brightest) = (0, 0.0f32);
        for (k, entry) in entries.iter_mut().enumerate() {
            let (colour, opacity) = transfer.at(lowest + per_level * top * k as f64 / last);
            let passes = if opacity >= 1.0 {
                OPAQUE
            } else {
                ((log(1.0 - opacity) / std::f64::consts::LN_2 * units) as f32).max(OPAQUE)
            };
            *entry = [colour[0] as f32, colour[1] as f32, colour[2] as f32, passes];
            seen_before.push(seen);
            if passes < 0.0 {
                seen += 1;
                brightest = entry[..3].iter().fold(brightest, |m, v| m.max(*v));
            }
        }
        seen_before.push(seen);
        let shares = dispatch(Instructions::Auto, Shares(&entries));
        Self {
            entries,
            shares,
            per_level: (last / top) as f32,
            seen_before,
            brightest,
        }
    }

    /// Whether the function shows anything of what is interpolated between levels from `low` to `high`.
    /// Exactly: it asks for all entries that such levels can take, with one more on either side, where
    /// rounding may lead.
    pub(crate) fn shows(&self, low: i16, high: i16) -> bool {
        let entry = |level: i16| (f32::from(level) * self.per_level + 0.5) as usize;
        let from = entry(low).saturating_sub(1);
        let to = (entry(high) + 2).min(ENTRIES);
        self.seen_before[to] > self.seen_before[from]
    }
}

/// Computes [`Table::shares`] as rays do that have steps of their own: to the same bits.
struct Shares<'a>(&'a [[f32; 4]; ENTRIES]);

impl Kernel for Shares<'_> {
    type Output = Box<[[f32; 4]; ENTRIES]>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let mut shares = Box::new(*self.0);
        for entries in shares.chunks_exact_mut(WIDTH) {
            let mut passes = [0.0; WIDTH];
            for (lane, entry) in entries.iter().enumerate() {
                passes[lane] = entry[3];
            }
            let share = times_exp2(splat(simd, 1.0), F::from_slice(simd, &passes)).to_array();
            for (lane, entry) in entries.iter_mut().enumerate() {
                entry[3] = share[lane];
            }
        }
        shares
    }
}

#[cfg(test)]
mod tests {
    use foveasim_assets::TransferPoint;

    use super::*;

    fn table() -> Table {
        let point = |value, opacity| TransferPoint {
            value,
            colour: [0.25, 0.5, 1.0],
            opacity,
        };
        let points = vec![
            point(10.0, 0.0),
            point(20.0, 0.5),
            point(30.0, 0.0),
            point(90.0, 0.0),
            point(90.0, 1.0),
        ];
        let transfer = TransferFunction::new(points).unwrap();
        Table::new(&transfer, 0.0, 1.0, 100, 0.5)
    }

    #[test]
    fn ranges_are_asked_exactly() {
        let table = table();
        assert!(!table.shows(0, 9) && !table.shows(31, 89) && !table.shows(50, 50));
        assert!(table.shows(0, 11) && table.shows(25, 25) && table.shows(28, 60));
        assert!(table.shows(89, 91) && table.shows(100, 100) && table.shows(0, 100));
    }

    #[test]
    fn a_step_of_half_a_unit_lets_the_root_through() {
        let table = table();
        let entry = table.entries[(20.0 * table.per_level + 0.5) as usize];
        assert!((entry[3] - 0.5 * 0.5f32.log2()).abs() < 1e-3);
        assert_eq!(entry[..3], [0.25, 0.5, 1.0]);
        assert_eq!(table.entries[ENTRIES - 1][3], OPAQUE);
        assert_eq!(table.brightest, 1.0);
    }
}
