use foveasim_assets::{TransferFunction, Volume};
use foveasim_lanes::dispatch;
use foveasim_lanes::wide::WIDTH;
use foveasim_models::View;
use glam::DVec2;
use rayon::prelude::*;

use crate::cells::Cells;
use crate::corners::Corners;
use crate::gradients::{Gradients, MOST};
use crate::kernel::Follow;
use crate::levels::Levels;
use crate::packet::{Geometry, Packet, Sight};
use crate::table::Table;
use crate::{CastError, CastOptions, CastWork, Storage};

/// Packets that a thread takes at a time.
const PACKETS: usize = 16;

/// A volume and a transfer function, made ready to be looked at from anywhere.
#[derive(Debug)]
pub struct Caster {
    voxels: Stored,
    cells: Cells,
    table: Table,
    geometry: Geometry,
    options: CastOptions,
}

/// What is read at samples.
#[derive(Debug)]
enum Stored {
    Gradients(Gradients),
    Values(Levels),
}

/// What a [`Caster`] keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Prepared {
    /// What is read at samples: values if gradients were asked for but would take too much memory.
    pub storage: Storage,
    /// Memory of voxels \[bytes\].
    pub voxel_bytes: usize,
    /// Memory of all else \[bytes\].
    pub other_bytes: usize,
    /// Parts of 4 × 4 × 4 cells that the volume is cut into.
    pub parts: usize,
    /// … of which something may be seen in.
    pub parts_seen: usize,
}

/// A ray to cast.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it passes the display \[px\]; the middle of the first pixel is (½, ½).
    pub px: DVec2,
    /// Its step in base steps, 1/16 to 4096.
    pub step: f32,
}

impl Caster {
    /// Makes `volume` ready to be seen as `transfer` says. Gradients are computed here, of what may be seen.
    ///
    /// # Errors
    /// If an option cannot be used, or the volume's voxels are so much longer one way than another that
    /// rays would take more than 2¹⁸ steps.
    pub fn new(
        volume: &Volume,
        transfer: &TransferFunction,
        options: &CastOptions,
    ) -> Result<Self, CastError> {
        Self::within(volume, transfer, options, MOST)
    }

    /// [`new`](Self::new), with another limit for gradients.
    pub(crate) fn within(
        volume: &Volume,
        transfer: &TransferFunction,
        options: &CastOptions,
        most_records: usize,
    ) -> Result<Self, CastError> {
        options.check()?;
        let geometry = Geometry::new(volume, options)?;
        let levels = Levels::new(volume);
        let highest = levels.levels.par_iter().copied().max().unwrap_or(0);
        let units = options.step_voxels / options.unit_voxels;
        let table = Table::new(transfer, levels.lowest, levels.per_level, highest, units);
        let mut cells = Cells::new(&levels, &table, options.skip_empty);
        let gradients = match options.storage {
            Storage::Gradients => Gradients::new(&levels, &mut cells, most_records),
            Storage::Values => None,
        };
        let voxels = match gradients {
            Some(gradients) => Stored::Gradients(gradients),
            None => Stored::Values(levels),
        };
        Ok(Self {
            voxels,
            cells,
            table,
            geometry,
            options: *options,
        })
    }

    /// What is kept of the volume.
    pub fn prepared(&self) -> Prepared {
        Prepared {
            storage: match &self.voxels {
                Stored::Gradients(_) => Storage::Gradients,
                Stored::Values(_) => Storage::Values,
            },
            voxel_bytes: match &self.voxels {
                Stored::Gradients(g) => size_of_val(g.records.as_slice()),
                Stored::Values(l) => size_of_val(l.levels.as_slice()),
            },
            other_bytes: size_of_val(self.cells.states.as_slice())
                + size_of_val(&*self.table.entries)
                + size_of_val(&*self.table.shares),
            parts: self.cells.states.len(),
            parts_seen: self.cells.occupied(),
        }
    }

    /// How rays are cast.
    pub fn options(&self) -> &CastOptions {
        &self.options
    }

    /// Casts as many rays as `out` has places: `out[i]` is what `ray(i)` sees, red, green and blue (linear light,
    /// weighted by opacity, nothing behind) and opacity; zero for rays off the display.
    ///
    /// Rays go in packets of sixteen in their order, so near ones should follow each other. What a ray sees
    /// does not depend on the others.
    ///
    /// # Errors
    /// If the view moves or is not finite, or a ray's step is not 1/16 to 4096.
    pub fn cast(
        &self,
        view: &View,
        ray: impl Fn(usize) -> Ray + Sync,
        out: &mut [[f32; 4]],
    ) -> Result<CastWork, CastError> {
        let sight = self.sight(view)?;
        let works: Vec<Result<CastWork, CastError>> = out
            .par_chunks_mut(PACKETS * WIDTH)
            .enumerate()
            .with_max_len(1)
            .map(|(chunk, out)| {
                let mut work = CastWork::default();
                for (number, out) in out.chunks_mut(WIDTH).enumerate() {
                    let first = (chunk * PACKETS + number) * WIDTH;
                    let mut packet = Packet::EMPTY;
                    for lane in 0..out.len() {
                        let index = first + lane;
                        sight.aim(&mut packet, lane, ray(index), index, &mut work)?;
                    }
                    let seen = self.follow(&packet, &mut work);
                    out.copy_from_slice(&seen[..out.len()]);
                }
                Ok(work)
            })
            .collect();
        total(works)
    }

    pub(crate) fn sight(&self, view: &View) -> Result<Sight, CastError> {
        Sight::new(&self.geometry, view, &self.options)
    }

    /// What the rays of a packet see.
    pub(crate) fn follow(&self, packet: &Packet, work: &mut CastWork) -> [[f32; 4]; WIDTH] {
        match &self.voxels {
            Stored::Gradients(voxels) => self.follow_in(voxels, packet, work),
            Stored::Values(voxels) => self.follow_in(voxels, packet, work),
        }
    }

    fn follow_in(
        &self,
        voxels: &impl Corners,
        packet: &Packet,
        work: &mut CastWork,
    ) -> [[f32; 4]; WIDTH] {
        let steps = work.steps;
        let kernel = Follow {
            voxels,
            cells: &self.cells,
            table: &self.table,
            geometry: &self.geometry,
            options: &self.options,
            packet,
            work,
        };
        let seen = dispatch(self.options.instructions, kernel);
        work.voxels_fetched += 8 * (work.steps - steps);
        seen
    }
}

/// The sum, or the first error.
fn total(works: Vec<Result<CastWork, CastError>>) -> Result<CastWork, CastError> {
    let mut all = CastWork::default();
    for work in works {
        all += work?;
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use foveasim_assets::GeneratedVolume;
    use foveasim_models::{Eye, Viewport};
    use glam::UVec2;

    use super::*;

    #[test]
    fn too_much_for_gradients_is_kept_as_values() {
        let volume = GeneratedVolume::Porous.build(20, 1).unwrap();
        let transfer = TransferFunction::of_volume(&volume);
        let options = CastOptions::default();
        let own = Caster::new(&volume, &transfer, &options).unwrap();
        let kept = own.prepared();
        let most = kept.voxel_bytes / size_of::<[i16; 8]>();
        assert_eq!(kept.storage, Storage::Gradients);
        let optics = Viewport::symmetric(UVec2::splat(16), 0.4).unwrap();
        let eye = crate::orbit(volume.bounds(), &optics, 10.0, 25.0, 0.8).unwrap();
        let view = View::still(Eye::Cyclopean, optics, eye);
        let drawn = own.full(&view).unwrap();
        for (most, storage) in [(most, Storage::Gradients), (most - 1, Storage::Values)] {
            let other = Caster::within(&volume, &transfer, &options, most).unwrap();
            assert_eq!(other.prepared().storage, storage);
            assert_eq!(other.prepared().parts_seen, kept.parts_seen);
            assert_eq!(other.full(&view).unwrap(), drawn);
        }
        let values = Caster::within(&volume, &transfer, &options, 0).unwrap();
        assert_eq!(values.prepared().voxel_bytes, 2 * 20 * 20 * 20);
    }
}
