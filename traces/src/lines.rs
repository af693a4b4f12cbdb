use std::io::BufRead;

use crate::TraceError;

/// The longest line read \[bytes\]; the widest known row has some 400.
const MAX_LINE: usize = 64 * 1024;

/// Lines of a text file, one buffer for all, with a limit on their length.
///
/// Takes away a byte order mark, LF or CRLF, and trailing spaces; refuses NUL and invalid UTF-8.
#[derive(Debug)]
pub(crate) struct Lines<'n, R> {
    reader: R,
    file: &'n str,
    buffer: Vec<u8>,
    number: usize,
    complete: bool,
    /// The last line that was not blank had no end.
    cut: bool,
    again: bool,
}

impl<'n, R: BufRead> Lines<'n, R> {
    pub(crate) fn new(reader: R, file: &'n str) -> Self {
        Self {
            reader,
            file,
            buffer: Vec::new(),
            number: 0,
            complete: true,
            cut: false,
            again: false,
        }
    }

    pub(crate) fn file(&self) -> &'n str {
        self.file
    }

    /// What is to be said of the text when all of it has been read: files of all known formats end with a line
    /// feed.
    pub(crate) fn note(&self) -> Option<String> {
        let note = "the last line has no end: it may have been cut";
        self.cut.then(|| note.to_owned())
    }

    /// Makes the next call of [`Lines::next`] return the present line again.
    pub(crate) fn push_back(&mut self) {
        self.again = true;
    }

    /// The next line that is not blank.
    pub(crate) fn next(&mut self) -> Result<Option<Line<'_>>, TraceError> {
        if !std::mem::take(&mut self.again) {
            loop {
                if !self.fill()? {
                    return Ok(None);
                }
                if !self.buffer.iter().all(u8::is_ascii_whitespace) {
                    break;
                }
            }
        }
        self.cut = !self.complete;
        let text = std::str::from_utf8(&self.buffer)
            .map_err(|_| self.not_text("it is not valid UTF-8"))?;
        Ok(Some(Line {
            text,
            number: self.number,
            complete: self.complete,
        }))
    }

    fn fill(&mut self) -> Result<bool, TraceError> {
        self.buffer.clear();
        self.read_line().map_err(|reason| TraceError::Io {
            file: self.file.to_owned(),
            reason,
        })?;
        if self.buffer.is_empty() {
            return Ok(false);
        }
        self.number += 1;
        if memchr::memchr(0, &self.buffer).is_some() {
            return Err(self.not_text("it has a NUL byte"));
        }
        if self.buffer.len() > MAX_LINE + 1 {
            let (file, line) = (self.file.to_owned(), self.number);
            return Err(TraceError::LineTooLong {
                file,
                line,
                limit: MAX_LINE,
            });
        }
        self.complete = self.buffer.last() == Some(&b'\n');
        // Not tabs: at the end of a tab-separated row they stand for empty fields.
        while self
            .buffer
            .last()
            .is_some_and(|b| matches!(b, b'\n' | b'\r' | b' '))
        {
            self.buffer.pop();
        }
        if self.number == 1 && self.buffer.starts_with(b"\xef\xbb\xbf") {
            self.buffer.drain(..3);
        }
        Ok(true)
    }

    /// Appends the next line to the buffer, with its line feed; no more than tells a line of just the limit
    /// from a longer one.
    fn read_line(&mut self) -> std::io::Result<()> {
        const LIMIT: usize = MAX_LINE + 2;
        while self.buffer.len() < LIMIT {
            let ready = match self.reader.fill_buf() {
                Ok(ready) => ready,
                Err(e) if e.kind() == std::io::ErrorKind::Interrupted => continue,
                Err(e) => return Err(e),
            };
            let end = memchr::memchr(b'\n', ready).map_or(ready.len(), |at| at + 1);
            let taken = end.min(LIMIT - self.buffer.len());
            self.buffer.extend_from_slice(&ready[..taken]);
            self.reader.consume(taken);
            if taken == 0 || self.buffer.last() == Some(&b'\n') {
                break;
            }
        }
        Ok(())
    }

    fn not_text(&self, what: &'static str) -> TraceError {
        TraceError::NotText {
            file: self.file.to_owned(),
            line: self.number,
            what,
        }
    }
}

/// One line, without its end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line<'a> {
    pub(crate) text: &'a str,
    /// From 1.
    pub(crate) number: usize,
    /// Whether a line feed ended it; without one the file may have been cut off here.
    pub(crate) complete: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(bytes: &[u8]) -> Result<Vec<String>, TraceError> {
        let mut lines = Lines::new(bytes, "f");
        let mut out = Vec::new();
        while let Some(line) = lines.next()? {
            out.push(format!(
                "{}:{}{}",
                line.number,
                line.text,
                if line.complete { "" } else { "!" }
            ));
        }
        Ok(out)
    }

    #[test]
    fn ends_marks_and_blanks() {
        assert_eq!(
            all(b"\xef\xbb\xbfa,b \r\n\r\n \t\nc\t\nd").unwrap(),
            ["1:a,b", "4:c\t", "5:d!"]
        );
        assert!(all(b"").unwrap().is_empty());
    }

    #[test]
    fn what_is_not_text_is_refused() {
        assert!(matches!(
            all(b"a\nb\0c\n"),
            Err(TraceError::NotText { line: 2, .. })
        ));
        assert!(matches!(
            all(b"a\nb\xffc\n"),
            Err(TraceError::NotText { line: 2, .. })
        ));
        assert_eq!(all(&vec![b'x'; MAX_LINE]).unwrap()[0].len(), MAX_LINE + 3);
        assert!(matches!(
            all(&vec![b'x'; 10 * MAX_LINE]),
            Err(TraceError::LineTooLong { line: 1, .. })
        ));
    }
}
