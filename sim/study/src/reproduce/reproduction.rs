use foveasim_reports::Table;

use super::Published;

/// Hears what is being done, and how much of all is done (0 to 1).
pub type Progress<'a> = dyn Fn(&str, f64) + 'a;

/// What a paper's reproduction leaves: the same of every paper, so that one way to write and print it
/// serves all.
#[derive(Debug, Clone, Default)]
pub struct Reproduction {
    /// Tables by the name of their CSV files.
    pub tables: Vec<(String, Table)>,
    /// Charts as SVG by the name of their files.
    pub charts: Vec<(String, String)>,
    /// Pictures as PNG by the name of their files.
    pub pictures: Vec<(String, Vec<u8>)>,
    /// All of it in one page; none of a paper whose tables say everything.
    pub page: Option<String>,
    /// Files that another run of the same paper may have left and this one has not.
    pub retired: Vec<&'static str>,
    /// What is worth seeing at once: tables, each with a line above it that may be empty. The first one is the answer.
    pub summary: Vec<(&'static str, Table)>,
    /// Every number that the paper prints and that is reproduced, beside ours.
    pub published: Vec<Published>,
}

impl Reproduction {
    /// Name of the page's file.
    pub const PAGE: &'static str = "report.html";

    /// Every file: its name, its bytes.
    pub fn files(&self) -> Vec<(String, Vec<u8>)> {
        let tables = self.tables.iter();
        let tables = tables.map(|(name, table)| (name.clone(), table.csv().into_bytes()));
        let charts = self.charts.iter();
        let charts = charts.map(|(name, svg)| (name.clone(), svg.clone().into_bytes()));
        let page = self.page.iter();
        let page = page.map(|html| (Self::PAGE.to_owned(), html.clone().into_bytes()));
        let all = tables.chain(charts).chain(self.pictures.iter().cloned());
        all.chain(page).collect()
    }

    pub(crate) fn add_table(&mut self, name: &str, table: Table) {
        self.tables.push((name.to_owned(), table));
    }

    pub(crate) fn add_chart(&mut self, name: &str, svg: String) {
        self.charts.push((name.to_owned(), svg));
    }

    pub(crate) fn add_picture(&mut self, name: String, png: Vec<u8>) {
        self.pictures.push((name, png));
    }
}
