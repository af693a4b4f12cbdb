use std::path::{Path, PathBuf};

use foveasim_reports::{Page, ReportError, Table};
use thiserror::Error;

use crate::ScenarioError;
use crate::scenario::read_text_up_to;

/// What other commands found of how good the predictions are, as they left it in a folder: `plan --verify` and `pareto`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Evidence {
    folder: PathBuf,
    parts: Vec<(&'static Part, Shown)>,
}

/// A file that may be there.
#[derive(Debug, PartialEq, Eq)]
struct Part {
    file: &'static str,
    subject: Subject,
    caption: &'static str,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Subject {
    Verification,
    TimeAndError,
}

#[derive(Debug, Clone, PartialEq)]
enum Shown {
    Chart(String),
    Table(Table),
}

/// Why a folder is no evidence.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum EvidenceError {
    /// A file cannot be read.
    #[error(transparent)]
    Read(#[from] ScenarioError),
    /// A table that is none.
    #[error(transparent)]
    Table(#[from] ReportError),
    /// A chart of other origin: the page takes none that may ask for what is outside of it.
    #[error("{}: not a chart that foveasim wrote", .0.display())]
    Chart(PathBuf),
    /// No file of those that are looked for.
    #[error("{}: no evidence there; want one of {}", .folder.display(), .files.join(", "))]
    Nothing {
        /// The folder.
        folder: PathBuf,
        /// What is looked for.
        files: Vec<&'static str>,
    },
}

const PARTS: [Part; 4] = [
    Part {
        file: "verify.svg",
        subject: Subject::Verification,
        caption: "Predicted over measured time, cell by cell",
    },
    Part {
        file: "verify-summary.csv",
        subject: Subject::Verification,
        caption: "How wrong predictions are",
    },
    Part {
        file: "pareto.svg",
        subject: Subject::TimeAndError,
        caption: "Time against error, all methods and settings",
    },
    Part {
        file: "pareto.csv",
        subject: Subject::TimeAndError,
        caption: "Every method and setting",
    },
];

/// Larger files are not ours.
const MOST_BYTES: u64 = 16 << 20;
/// More rows nobody reads on a page.
const MOST_ROWS: usize = 2000;

impl Evidence {
    /// What is in `folder`: at least one of `verify.svg`, `verify-summary.csv`, `pareto.svg` and `pareto.csv`.
    ///
    /// # Errors
    /// If there is none of them, or one cannot be read.
    pub fn read(folder: &Path) -> Result<Self, EvidenceError> {
        let mut parts = Vec::new();
        for part in &PARTS {
            let path = folder.join(part.file);
            if !path.is_file() {
                continue;
            }
            let text = read_text_up_to(&path, MOST_BYTES)?;
            parts.push((
                part,
                match part.file.ends_with(".svg") {
                    true if is_ours(&text) => Shown::Chart(text),
                    true => return Err(EvidenceError::Chart(path)),
                    false => {
                        let origin = path.display().to_string();
                        Shown::Table(Table::from_csv(&text, &origin, MOST_ROWS)?)
                    }
                },
            ));
        }
        if parts.is_empty() {
            return Err(EvidenceError::Nothing {
                folder: folder.to_owned(),
                files: PARTS.iter().map(|p| p.file).collect(),
            });
        }
        let folder = folder.to_owned();
        Ok(Self { folder, parts })
    }

    fn is_about(&self, subject: Subject) -> bool {
        self.parts.iter().any(|(part, _)| part.subject == subject)
    }

    fn add_to(&self, page: &mut Page, subject: Subject) {
        for (part, shown) in self.parts.iter().filter(|(p, _)| p.subject == subject) {
            match shown {
                Shown::Chart(svg) => page.svg(part.caption, svg),
                Shown::Table(table) => page.table(part.caption, table),
            }
        }
    }
}

/// Whether a chart is of this program, and asks for nothing outside of itself.
fn is_ours(svg: &str) -> bool {
    // A title may say anything.
    let unlabelled = match svg.split_once("aria-label=\"") {
        Some((before, rest)) => before.to_owned() + rest.split_once('"').map_or("", |(_, r)| r),
        None => svg.to_owned(),
    };
    let lower = unlabelled.to_ascii_lowercase();
    let begins = "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"fv\"";
    svg.starts_with(begins)
        && lower.trim_end().ends_with("</svg>")
        && lower.matches("</svg>").count() == 1
        && tags(&lower).all(is_harmless)
        && !["url(", "@import", "javascript:"]
            .iter()
            .any(|w| lower.contains(w))
}

/// What stands between angle brackets.
fn tags(svg: &str) -> impl Iterator<Item = &str> {
    let tags = svg.split('<').skip(1);
    tags.map(|s| s.split('>').next().unwrap_or(s))
}

/// Whether a tag is one of those that charts are drawn with, and neither links nor acts.
fn is_harmless(tag: &str) -> bool {
    const DRAWN: [&str; 9] = [
        "svg", "style", "text", "polyline", "polygon", "circle", "rect", "line", "path",
    ];
    let mut words = tag.trim_start_matches('/').split_ascii_whitespace();
    let name = words.next().unwrap_or_default().trim_end_matches('/');
    let acts = |word: &str| {
        word.split(['"', '\'', '/'])
            .any(|part| part.starts_with("on"))
    };
    DRAWN.contains(&name) && !words.any(|word| acts(word) || word.contains("href"))
}

/// Why predictions can be believed, or that nothing here says so.
pub(super) fn section(page: &mut Page, evidence: Option<&Evidence>) {
    page.heading("Why believe the predicted times");
    if let Some(found) = evidence {
        page.paragraph(&format!(
            "What was measured apart from this run, as it was found in {}.",
            found.folder.display()
        ));
    }
    for (subject, heading, absent) in [
        (
            Subject::Verification,
            "Predicted against measured",
            "No verification is shown: the times above are predictions of the cost profile that nothing in this report holds \
             against a measurement. foveasim plan --verify K --out DIR renders K cells and measures them; run --evidence DIR \
             shows here what it found.",
        ),
        (
            Subject::TimeAndError,
            "Time against error",
            "No front of time against error is shown: foveasim pareto --out DIR measures one, run --evidence DIR shows it here.",
        ),
    ] {
        match evidence.filter(|e| e.is_about(subject)) {
            Some(found) => {
                page.subheading(heading);
                found.add_to(page, subject);
            }
            None => page.note(absent),
        }
    }
}

#[cfg(test)]
mod tests {
    use foveasim_reports::{LineChart, LineSeries};

    use super::*;

    fn chart() -> String {
        LineChart {
            title: "time on \"this\" <script> & href".into(),
            series: vec![LineSeries {
                label: "a".into(),
                points: vec![[0.0, 1.0], [1.0, 2.0]],
            }],
            ..LineChart::default()
        }
        .svg()
    }

    fn html(evidence: Option<&Evidence>) -> String {
        let mut page = Page::new("p");
        section(&mut page, evidence);
        page.html()
    }

    #[test]
    fn what_is_there_is_shown_and_what_is_not_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let nothing = Evidence::read(folder.path()).unwrap_err().to_string();
        assert!(nothing.contains("want one of verify.svg"), "{nothing}");
        assert!(html(None).contains("No verification is shown"));
        std::fs::write(folder.path().join("verify.svg"), chart()).unwrap();
        std::fs::write(folder.path().join("pareto.csv"), "method,ms\nfull,3.5\n").unwrap();
        let found = Evidence::read(folder.path()).unwrap();
        let page = html(Some(&found));
        assert!(page.contains("<polyline") && page.contains("<td class=\"n\">3.5</td>"));
        assert!(!page.contains("No verification is shown"));
        std::fs::write(folder.path().join("pareto.csv"), "method,ms\nfull\n").unwrap();
        let error = Evidence::read(folder.path()).unwrap_err().to_string();
        assert!(error.contains("pareto.csv:2: 1 cells"), "{error}");
    }

    #[test]
    fn charts_of_others_are_refused() {
        let ours = chart();
        assert!(is_ours(&ours));
        for wrong in [
            "<svg></svg>".to_owned(),
            ours.replace("</svg>", "<script>alert(1)</script></svg>"),
            ours.replace("</svg>", "<image href=\"http://x.example\"/></svg>"),
            ours.replace("</svg>", "<rect onload=\"x()\"/></svg>"),
            ours.replace("</svg>", "<rect x=\"1\"onload=\"x()\"/></svg>"),
            ours.replace("</style>", "@import 'http://x.example';</style>"),
            ours.replace("</svg>", "</svg><p>"),
        ] {
            assert!(!is_ours(&wrong), "{wrong}");
        }
    }
}
