use foveasim_reports::{
    BarChart, BarSeries, LineChart, LineSeries, Page, Table, png, side_by_side,
};

use crate::reproduce::Reproduction;

use super::paper::{RECONSTRUCTION_MS, TABLE_1};
use super::{Bruder2019Outcome, BruderErrors, BruderFound, BruderRow, BruderTimes, ReproduceError};

impl Bruder2019Outcome {
    /// Table 1's quantities of every volume: mean frame rates, speedups, rays, samples per ray, reconstruction.
    pub fn table_1(&self) -> Table {
        let mut table = Table::new([
            "volume",
            "voxels",
            "full_fps",
            "foveated_fps",
            "speedup_mean",
            "speedup_median",
            "speedup_equal_steps",
            "rays_share",
            "full_samples_per_ray",
            "foveated_samples_per_ray",
            "reconstruct_ms",
            "prepare_ms",
            "prepared_MiB",
        ]);
        let pixels = f64::from(self.size.element_product());
        for found in &self.volumes {
            let t = &found.times;
            let [x, y, z] = found.dims;
            let per_ray = |k: usize| {
                let of = |f: fn(&foveasim_volume::CastWork) -> u64| {
                    t.rows.iter().map(|r| f(&r.work[k])).sum::<u64>() as f64
                };
                of(|w| w.steps) / of(|w| w.rays).max(1.0)
            };
            let bytes = found.prepared.voxel_bytes + found.prepared.other_bytes;
            table.push(vec![
                found.name.as_str().into(),
                format!("{x}x{y}x{z}").into(),
                t.mean(|r| 1e3 / r.full_ms).into(),
                t.mean(|r| 1e3 / r.foveated_ms()).into(),
                t.mean(|r| r.full_ms / r.foveated_ms()).into(),
                t.median(|r| r.full_ms / r.foveated_ms()).into(),
                t.median(|r| r.full_ms / r.equal_ms()).into(),
                t.mean(|r| r.work[1].rays as f64 / pixels).into(),
                per_ray(0).into(),
                per_ray(1).into(),
                t.median(|r| r.reconstruct_ms).into(),
                found.prepare_ms.into(),
                (bytes as f64 / f64::from(1 << 20)).into(),
            ]);
        }
        table
    }

    /// Table 1 as printed.
    pub fn printed() -> Table {
        let mut table = Table::new(["data_set", "voxels", "full_fps", "foveated_fps", "ratio"]);
        for row in TABLE_1 {
            let voxels = row.dims.map(|[x, y, z]| format!("{x}x{y}x{z}"));
            let [full, foveated] = row.fps;
            table.push(vec![
                row.name.into(),
                voxels.into(),
                full.into(),
                foveated.into(),
                (foveated / full).into(),
            ]);
        }
        table
    }

    /// Every gaze of every camera and volume.
    pub fn gazes(&self) -> Table {
        let mut table = Table::new(BruderTimes::columns());
        for found in &self.volumes {
            found.times.add_to(&found.name, &mut table);
        }
        table
    }

    /// Error by ring.
    pub fn errors(&self) -> Table {
        let mut table = Table::new(BruderErrors::columns());
        for found in &self.volumes {
            found.errors.add_to(&found.name, &mut table);
        }
        table
    }

    /// Speedups of all volumes.
    pub fn speedup_chart(&self) -> BarChart {
        let of = |label: &str, speedup: fn(&BruderRow) -> f64| BarSeries {
            label: label.into(),
            values: self
                .volumes
                .iter()
                .map(|v| Some(v.times.median(speedup)))
                .collect(),
        };
        BarChart {
            title: "Speedup of foveated volume rendering".into(),
            value_label: "times as fast as full, median (the paper has 1.8 to 3.25)".into(),
            groups: self.volumes.iter().map(|v| v.name.clone()).collect(),
            series: vec![
                of("steps follow the mask", |r| r.full_ms / r.foveated_ms()),
                of("equal steps", |r| r.full_ms / r.equal_ms()),
            ],
        }
    }

    /// PSNR over the rings, a line for each volume.
    pub fn error_chart(&self) -> LineChart {
        let line = |found: &BruderFound| LineSeries {
            label: found.name.clone(),
            points: (0..4)
                .filter_map(|k| found.errors.at("natural", k))
                .map(|r| [(r.edges.0 + r.edges.1.unwrap_or(1.2)) / 2.0, r.psnr_db])
                .collect(),
        };
        LineChart {
            title: "Foveated against full, by ring around the gaze".into(),
            x_label: "distance from the gaze [half widths of the image]".into(),
            y_label: "PSNR of luma [dB]".into(),
            series: self.volumes.iter().map(line).collect(),
            ..LineChart::default()
        }
    }

    /// Tables, charts, pictures and the page.
    ///
    /// # Errors
    /// If a picture cannot be encoded.
    pub fn reproduction(&self) -> Result<Reproduction, ReproduceError> {
        let mut out = Reproduction {
            page: Some(self.page()?.html()),
            summary: vec![("", self.table_1()), ("", Self::printed())],
            published: self.published(),
            ..Reproduction::default()
        };
        out.add_table("table1.csv", self.table_1());
        out.add_table("table1-printed.csv", Self::printed());
        out.add_table("gazes.csv", self.gazes());
        out.add_table("errors.csv", self.errors());
        out.add_chart("speedup.svg", self.speedup_chart().svg());
        out.add_chart("errors.svg", self.error_chart().svg());
        for (k, found) in self.volumes.iter().enumerate() {
            let [full, foveated] = &found.pictures;
            let picture = side_by_side(&[full, foveated], 8);
            out.add_picture(format!("volume-{}.png", k + 1), png(&picture)?);
        }
        Ok(out)
    }

    fn page(&self) -> Result<Page, ReproduceError> {
        let mut page = Page::new("Foveated volume rendering: Bruder et al. 2019");
        let asked = &self.asked;
        page.paragraph(&format!(
            "{} cameras with {} gazes each, the median of {} frames of {} × {} pixels, full and foveated in turn; the \
             paper has 256 × 256 and five. A mask of {} rays. Half-voxel steps, in the foveated image as many at once as \
             rays are apart there, up to a limit; opacity is corrected for each. Volumes are ours or given as files: the \
             paper's data sets and transfer functions are not published with it.",
            asked.cameras, asked.gazes, asked.frames, self.size.x, self.size.y, self.mask_rays,
        ));
        page.heading("Table 1");
        page.table("Ours, on this machine's processor", &self.table_1());
        page.table("As printed, on a GeForce GTX 1070", &Self::printed());
        page.svg("", &self.speedup_chart().svg());
        let [mean, deviation] = RECONSTRUCTION_MS;
        page.paragraph(&format!(
            "Frames per second are means over all gazes, as in the paper; its printed speedups are ratios of those means. \
             Reconstruction took {mean} ± {deviation} ms on its card.",
        ));
        page.heading("Error, which the paper does not measure");
        page.paragraph(
            "Foveated against full images, gaze in the middle, by rings around it in half widths of the image: PSNR of luma \
             (of the mean squared error over all cameras), SSIM, and brightness bias (positive: brighter than full).",
        );
        page.svg("", &self.error_chart().svg());
        page.table("Error by ring", &self.errors());
        for found in &self.volumes {
            page.subheading(&found.name);
            page.row(|page| {
                let [full, foveated] = &found.pictures;
                page.picture("full", full)?;
                page.picture("foveated, gaze in the middle", foveated)
            })?;
        }
        Ok(page)
    }
}
