/// Collects warnings about one file: each once, and not without end.
#[derive(Debug)]
pub(crate) struct Warnings {
    file: String,
    lines: Vec<String>,
    unsaid: usize,
}

/// Most warnings about one file.
const MOST: usize = 16;

impl Warnings {
    pub(crate) fn new(file: &str) -> Self {
        Self {
            file: file.into(),
            lines: Vec::new(),
            unsaid: 0,
        }
    }

    pub(crate) fn add(&mut self, text: impl std::fmt::Display) {
        let line = format!("{}: {text}", self.file);
        if self.lines.contains(&line) {
            return;
        }
        if self.lines.len() < MOST {
            self.lines.push(line);
        } else {
            self.unsaid += 1;
        }
    }

    pub(crate) fn finish(mut self) -> Vec<String> {
        if self.unsaid > 0 {
            let file = &self.file;
            self.lines
                .push(format!("{file}: and {} more warnings", self.unsaid));
        }
        self.lines
    }
}
