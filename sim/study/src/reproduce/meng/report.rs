use foveasim_reports::{Page, Table};

use super::Meng2020;
use crate::KernelMeasured;
use crate::reproduce::Reproduction;

impl Meng2020 {
    /// Every table by the name of its file.
    pub(super) fn tables(&self) -> [(&'static str, Table); 5] {
        [
            ("fig7.csv", self.fig_7()),
            ("fig7-caption.csv", self.caption()),
            ("fig7-fits.csv", self.fits_table()),
            ("buffers.csv", self.buffers()),
            ("equation9.csv", self.dominance()),
        ]
    }

    /// Tables, charts and the page, of the theory and of what was measured.
    pub fn reproduction(&self, measured: &KernelMeasured) -> Reproduction {
        let mut out = Reproduction {
            summary: vec![("", self.caption()), ("", measured.timings.table())],
            published: self.published(measured),
            ..Reproduction::default()
        };
        for (name, table) in self.tables().into_iter().chain(measured.tables()) {
            out.add_table(name, table);
        }
        out.add_chart("equation9.svg", self.dominance_chart().svg());
        for (name, svg) in measured.charts() {
            out.add_chart(name, svg);
        }
        let mut page = self.page();
        measured.add_to(&mut page);
        out.page = Some(page.html());
        out
    }

    /// The page as far as theory goes; what is measured is added to it.
    pub(super) fn page(&self) -> Page {
        let mut page = Page::new(
            "Eye-dominance-guided Foveated Rendering (Meng, Du & Varshney 2020), reproduced",
        );
        page.heading("What the equations say");
        page.paragraph(
            "With time in proportion to the buffer of W/σ × H/σ samples, kernel foveated rendering is σ² times \
             as fast as full resolution, and eye dominance gains S = 2/(1 + (σ_d/σ_nd)²) on top (Eqs 6 to 9): \
             1.3846 for (2, 3). Samples that fall beyond the display are not drawn, so that σ² is a little less \
             than what is saved.",
        );
        page.table(
            "Samples of one eye, 1280 × 1440 pixels, gaze in the middle",
            &self.buffers(),
        );
        page.table("Eq. 9", &self.dominance());
        page.svg("", &self.dominance_chart().svg());
        page.heading("Fig. 7 against its caption");
        page.paragraph(
            "The caption's averages are not those of the rows. Rates are printed as whole frames per second; \
             the table gives how far that can move an average.",
        );
        page.table("Averages of Fig. 7", &self.caption());
        page.heading("What is fixed in Fig. 7");
        page.paragraph(&format!(
            "If t₀ + k/σ² for each eye is to explain all users with σ_nd up to 4, at most {:.2} ms of a \
             frame are fixed. The fits below assume σ = (2, 3) for every user; the last two take one average \
             each, and give KFR four to five frames per second too many. The users' own σ follow from their rates for any t₀.",
            self.most_fixed_ms
        ));
        page.table("Fits of t₀ and k", &self.fits_table());
        page.table(
            "Users, with σ for t₀ = 0 and for the most that can be fixed",
            &self.fig_7(),
        );
        page
    }
}
