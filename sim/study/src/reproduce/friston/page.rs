use foveasim_reports::{BarChart, BarSeries, Page, png, shrink, side_by_side};

use crate::reproduce::Reproduction;

use super::{
    Family, FoveatedRow, FoveatedWay, Friston2019Outcome, ReproduceError, RollingRow, RollingWay,
};

/// Between pictures side by side \[px\].
const GAP: u32 = 4;
/// Width of a picture on the page \[px\].
const PICTURE_PX: u32 = 420;

impl Friston2019Outcome {
    /// Tables, charts, pictures and the page.
    ///
    /// # Errors
    /// If a picture cannot be encoded.
    pub fn reproduction(&self) -> Result<Reproduction, ReproduceError> {
        let mut out = Reproduction {
            page: Some(self.page()?),
            summary: vec![("", self.foveated_table())],
            published: self.published(),
            ..Reproduction::default()
        };
        out.add_table("fig12-foveated.csv", self.foveated_table());
        out.add_table("fig12-rolling.csv", Self::table_of(&self.rolling));
        out.add_table("fig12-both.csv", Self::table_of(&self.both));
        out.add_table("fig12-shadow.csv", self.shadow_table());
        out.add_table("fig13-resolution.csv", self.resolution_table());
        out.add_table("fig13-turn.csv", Self::table_of(&self.turns));
        out.add_table("fig14.csv", self.strength_table());
        out.add_table("head.csv", self.head_table());
        for (name, _, svg) in self.charts() {
            out.add_chart(&format!("{name}.svg"), svg);
        }
        for (scene, [common, warped, rolling]) in self.asked.scenes.iter().zip(&self.pictures) {
            let picture = side_by_side(&[common, warped, rolling], GAP);
            out.add_picture(format!("fig8-{}.png", scene.name()), png(&picture)?);
        }
        for (bound, picture) in &self.efficiency {
            out.add_picture(format!("fig15-{}.png", bound.name()), png(picture)?);
        }
        Ok(out)
    }

    /// Every chart: name of its file, caption, picture.
    fn charts(&self) -> Vec<(&'static str, &'static str, String)> {
        let strength = |family| self.strength_chart(family).svg();
        vec![
            (
                "fig12-time",
                "Fig. 12: time of a frame over that of common rasterization",
                self.bars("Foveated: time over common rasterization", "ratio", |r| {
                    Some(r.over_common)
                }),
            ),
            (
                "fig12-ssim",
                "Fig. 12: likeness of the fovea",
                self.bars("SSIM of the fovea", "SSIM", |r| r.ssim),
            ),
            (
                "fig12-rolling-time",
                "Fig. 12: time on a rolling display over that of common rasterization",
                self.rolling_bars("Rolling: time over common rasterization", "ratio", |r| {
                    r.over_common
                }),
            ),
            (
                "fig12-rolling-ssim",
                "Fig. 12: likeness on a rolling display",
                self.rolling_bars("SSIM, disocclusions left out", "SSIM", |r| r.ssim),
            ),
            (
                "fig13-resolution",
                "Fig. 13, a: resolution",
                self.resolution_chart().svg(),
            ),
            (
                "fig13-turn-time",
                "Fig. 13, b: time over the turn",
                Self::turn_chart(
                    &self.turns,
                    "Time of a frame over the turn",
                    "time [ms]",
                    |r| r.raster_ms + r.shading_ms,
                )
                .svg(),
            ),
            (
                "fig13-turn-ssim",
                "Fig. 13, c: likeness over the turn",
                Self::turn_chart(&self.turns, "Likeness over the turn", "SSIM", |r| r.ssim).svg(),
            ),
            ("fig14-radial", "Fig. 14, radial", strength(Family::Radial)),
            (
                "fig14-lens-matched",
                "Fig. 14, lens-matched",
                strength(Family::LensMatched),
            ),
            (
                "fig14-log-polar",
                "Fig. 14, log-polar",
                strength(Family::LogPolar),
            ),
        ]
    }

    /// A bar for each way, of each scene.
    fn bars(
        &self,
        title: &str,
        value_label: &str,
        pick: impl Fn(&FoveatedRow) -> Option<f64>,
    ) -> String {
        let mut scenes: Vec<&str> = self.foveated.iter().map(|r| r.scene.as_str()).collect();
        scenes.dedup();
        // Rays take so much longer that nothing else would be seen.
        let shown = |way: &FoveatedWay| *way != FoveatedWay::Traced;
        let ways: Vec<FoveatedWay> = FoveatedWay::ALL.into_iter().filter(shown).collect();
        let series = |scene: &&str| {
            let value = |way: &FoveatedWay| {
                let row = self
                    .foveated
                    .iter()
                    .find(|r| r.scene == *scene && r.way == *way);
                row.and_then(&pick)
            };
            BarSeries {
                label: (*scene).to_owned(),
                values: ways.iter().map(value).collect(),
            }
        };
        BarChart {
            title: title.into(),
            value_label: value_label.into(),
            groups: ways.iter().map(|w| w.name()).collect(),
            series: scenes.iter().map(series).collect(),
        }
        .svg()
    }

    /// A bar for each way of rolling displays, of each scene.
    fn rolling_bars(
        &self,
        title: &str,
        value_label: &str,
        pick: impl Fn(&RollingRow) -> f64,
    ) -> String {
        let mut scenes: Vec<&str> = self.rolling.iter().map(|r| r.scene.as_str()).collect();
        scenes.dedup();
        let series = |scene: &&str| {
            let value = |way: &RollingWay| {
                let row = self
                    .rolling
                    .iter()
                    .find(|r| r.scene == *scene && r.way == *way);
                row.map(&pick)
            };
            BarSeries {
                label: (*scene).to_owned(),
                values: RollingWay::ALL.iter().map(value).collect(),
            }
        };
        BarChart {
            title: title.into(),
            value_label: value_label.into(),
            groups: RollingWay::ALL.iter().map(|w| w.name()).collect(),
            series: scenes.iter().map(series).collect(),
        }
        .svg()
    }

    /// Everything in one page that needs nothing else.
    fn page(&self) -> Result<String, ReproduceError> {
        let asked = &self.asked;
        let mut page =
            Page::new("Perceptual Rasterization (Friston, Ritschel & Steed 2019), reproduced");
        page.paragraph(&format!(
            "The comparisons of the paper on this machine's processor, {} × {} pixels, 90° across, {} rounds. The paper's \
             Figs 12 to 15 are bars and curves without numbers, of a Quadro K6000; what can be compared is their order. \
             All that has a strength is drawn with as many samples as there are pixels.",
            asked.size.x, asked.size.y, asked.rounds
        ));
        page.heading("Fig. 12: foveated frames");
        page.paragraph(&format!(
            "Likeness is SSIM of 64 × 64 pixels about the gaze against {n} × {n} samples to the pixel. Shading is what is \
             saved when the same frame is drawn in one colour. The efficiency of sample tests counts all lanes of the blocks that \
             were dispatched. Lens-matched and log-polar lattices have their best strengths of Fig. 14, over all \
             scenes; the paper has times of lens-matched shading four times as long, for its four passes, where ours is one lattice.",
            n = asked.reference_samples
        ));
        page.table("Foveated frames", &self.foveated_table());
        for (name, caption, svg) in self.charts() {
            match name {
                "fig12-rolling-time" => {
                    page.heading("Fig. 12: rolling displays");
                    page.paragraph(&format!(
                        "The display scans from left to right within 1/90 s, the head turns by {}° and moves by 2 cm. \
                         Likeness is to what each place should show as it lights, by the conservative bound, which tests show \
                         to be what rays find sample for sample; the fill of disoccluded pixels is the reference's, and they do \
                         not count. Efficiency and missed samples are counted with nothing left out for being hidden.",
                        asked.turn_deg
                    ));
                    page.table("Rolling", &Self::table_of(&self.rolling));
                    page.table(
                        "Rolling and foveated: likeness of the fovea against up to as many samples to the pixel as above",
                        &Self::table_of(&self.both),
                    );
                    page.table(
                        "Shadows: one map, and as many texels in two, the second about what the eye looks at",
                        &self.shadow_table(),
                    );
                    for (scene, images) in asked.scenes.iter().zip(&self.pictures) {
                        let [a, b, c] = images.each_ref().map(|i| shrink(i, PICTURE_PX));
                        let caption = format!(
                            "Fig. 8, {}: drawn at the start; warped, unknown places in squares; rolling",
                            scene.name()
                        );
                        page.picture(&caption, &side_by_side(&[&a, &b, &c], GAP))?;
                    }
                }
                "fig13-resolution" => {
                    page.heading("Fig. 13: resolution and turn");
                    page.table("Resolution", &self.resolution_table());
                    page.table("Turn", &Self::table_of(&self.turns));
                }
                "fig14-radial" => page.heading("Fig. 14: strength of foveation"),
                _ => {}
            }
            page.svg(caption, &svg);
        }
        page.table("Strengths", &self.strength_table());
        page.heading("Fig. 15: efficiency of sample tests");
        page.paragraph("Of each sample, the share of triangles tested that cover it, on the rolling display of the first scene: white is all of \
             them, black none; where no triangle was tested it is blue.");
        for (bound, picture) in &self.efficiency {
            page.picture(bound.name(), &shrink(picture, PICTURE_PX))?;
        }
        page.heading("Head poses");
        page.paragraph(
            "The paper's recording is not published. A turn whose errors are known in closed form shows that predictors do what \
             they should; as many frames of synthetic movement stand beside the paper's numbers. Its constant pose is off by \
             0.05 m within one frame, which would be a head at 3.75 m/s: more likely centimetres over seconds than \
             an error of one frame, while its linear prediction is within a millimetre.",
        );
        page.table("One frame ahead", &self.head_table());
        Ok(page.html())
    }
}
