use foveasim_reports::{BarChart, BarSeries, Page};

use super::{Family, FoveatedRow, FoveatedWay, Friston2019Outcome};

impl Friston2019Outcome {
    /// All files of the reproduction: tables as CSV, charts as SVG, and one page with both.
    pub fn files(&self) -> Vec<(String, Vec<u8>)> {
        let mut files: Vec<(String, Vec<u8>)> = Vec::new();
        let mut add = |name: &str, text: String| files.push((name.to_owned(), text.into_bytes()));
        add("fig12-foveated.csv", self.foveated_table().csv());
        add("fig14.csv", self.strength_table().csv());
        add("head.csv", self.head_table().csv());
        for (name, _, svg) in self.charts() {
            add(&format!("{name}.svg"), svg);
        }
        add("report.html", self.page());
        files
    }

    /// Every chart: name of its file, caption, picture.
    fn charts(&self) -> Vec<(&'static str, &'static str, String)> {
        let strength = |family| self.strength_chart(family).svg();
        vec![
            (
                "fig12-time",
                "Fig. 12: time of a frame over that of common rasterization",
                self.bars("Time over common rasterization", "ratio", |r| {
                    Some(r.over_common)
                }),
            ),
            (
                "fig12-ssim",
                "Fig. 12: likeness of the fovea",
                self.bars("SSIM of the fovea", "SSIM", |r| r.ssim),
            ),
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
            groups: ways.iter().map(|w| w.name().to_owned()).collect(),
            series: scenes.iter().map(series).collect(),
        }
        .svg()
    }

    /// Everything in one page that needs nothing else.
    fn page(&self) -> String {
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
            if name == "fig14-lens-matched" {
                page.heading("Fig. 14: strength of foveation");
            }
            page.svg(caption, &svg);
        }
        page.table("Strengths", &self.strength_table());
        page.heading("Head poses");
        page.paragraph(
            "The paper's recording is not published. A turn whose errors are known in closed form shows that predictors do what \
             they should; as many frames of synthetic movement stand beside the paper's numbers. Its constant pose is off by \
             0.05 m within one frame, which would be a head at 3.75 m/s: more likely centimetres over seconds than \
             an error of one frame, while its linear prediction is within a millimetre.",
        );
        page.table("One frame ahead", &self.head_table());
        page.html()
    }
}
