//! Rows of a sweep as they are kept while it runs: appended, each with the address of what it was made from and
//! a checksum, so that a sweep that was stopped goes on and the parts of one that was split are put together.
//!
//! ```text
//! # foveasim plan rows: sweep SHA-256, 1200 rows, 12 a group, shard 3/16
//! number,address,checksum,method,fov_h_deg,…
//! 24,5a0c…,91ee…,full,30,…
//! ```

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};

use anyhow::{Context as _, anyhow, bail};
use foveasim_reports::{TableDigest, csv_line};
use foveasim_study::{SWEEP_COLUMNS, Shard, Sweep, SweepRow};

/// Its name in a folder.
pub(super) const NAME: &str = "plan.rows";

const TITLE: &str = "# foveasim plan rows: sweep ";

/// Digits of an address or a checksum.
const DIGITS: usize = 16;

/// What a log is a part of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Header {
    /// Of all that the sweep is made from.
    sweep: String,
    rows: usize,
    /// Rows that are made together.
    group: usize,
    shard: Shard,
}

impl Header {
    pub(super) fn of(sweep: &Sweep, shard: Shard) -> Self {
        let addresses: Vec<String> = (0..sweep.groups()).map(|g| sweep.address(g)).collect();
        Self {
            sweep: TableDigest::new(&addresses).finish(),
            rows: sweep.len(),
            group: sweep.methods.len(),
            shard,
        }
    }

    /// The first two lines.
    fn text(&self) -> String {
        let Self {
            sweep,
            rows,
            group,
            shard,
        } = self;
        let columns = SWEEP_COLUMNS.join(",");
        format!(
            "{TITLE}{sweep}, {rows} rows, {group} a group, shard {shard}\nnumber,address,checksum,{columns}\n"
        )
    }

    fn parse(line: &str) -> Option<Self> {
        let mut parts = line.strip_prefix(TITLE)?.split(", ");
        let sweep = parts.next()?.to_owned();
        let rows = parts.next()?.strip_suffix(" rows")?.parse().ok()?;
        let group = parts.next()?.strip_suffix(" a group")?.parse().ok()?;
        let shard = parts.next()?.strip_prefix("shard ")?.parse().ok()?;
        let whole = parts.next().is_none() && group > 0;
        whole.then_some(Self {
            sweep,
            rows,
            group,
            shard,
        })
    }
}

/// A log that was read: which rows it holds.
#[derive(Debug)]
pub(super) struct Log {
    pub(super) header: Header,
    /// CSV lines by number, with the address of each.
    pub(super) rows: BTreeMap<usize, (String, String)>,
    /// Bytes of whole lines; what follows was cut off.
    length: u64,
}

fn checksum(number: usize, address: &str, line: &str) -> String {
    let mut digest = TableDigest::new(&[&number.to_string(), address, line]).finish();
    digest.truncate(DIGITS);
    digest
}

impl Log {
    /// Reads the log of a folder; `None` if it has none, or one that was cut off within its first lines.
    ///
    /// # Errors
    /// If it cannot be read, is none, or a whole line of it is damaged: the error names the line.
    pub(super) fn read(folder: &Path) -> anyhow::Result<Option<Self>> {
        let path = folder.join(NAME);
        let mut text = String::new();
        match File::open(&path) {
            Ok(mut file) => file.read_to_string(&mut text).map(drop),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(e) => Err(e),
        }
        .with_context(|| path.display().to_string())?;
        let at = |line: usize| format!("{}:{line}", path.display());
        // What follows the last line feed is half a line.
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let mut lines = text[..whole].lines();
        let Some(first) = lines.next() else {
            return Ok(None);
        };
        let header = Header::parse(first)
            .ok_or_else(|| anyhow!("{}: want a line that begins with `{TITLE}`", at(1)))?;
        let columns = lines.next();
        let Some(columns) = columns else {
            return Ok(None);
        };
        if !header.text().ends_with(&format!("\n{columns}\n")) {
            bail!("{}: columns of another version of foveasim", at(2));
        }
        let mut rows = BTreeMap::new();
        for (line, i) in lines.zip(3..) {
            let mut parts = line.splitn(4, ',');
            let mut next = || parts.next();
            let (number, address, sum, row) = (next(), next(), next(), next());
            let number = number.and_then(|n| n.parse::<usize>().ok());
            let (Some(number), Some(address), Some(sum), Some(row)) = (number, address, sum, row)
            else {
                bail!("{}: want number,address,checksum and a row", at(i));
            };
            if checksum(number, address, row) != sum || number >= header.rows {
                bail!("{}: row {number} is damaged: its checksum differs", at(i));
            }
            rows.insert(number, (address.to_owned(), format!("{row}\n")));
        }
        Ok(Some(Self {
            header,
            rows,
            length: whole as u64,
        }))
    }

    /// Leaves groups that are not complete out, and checks that the others are of `sweep`.
    ///
    /// # Errors
    /// If the log is of another sweep, or another part of it.
    pub(super) fn check(&mut self, sweep: &Sweep, header: &Header) -> anyhow::Result<()> {
        if self.header.shard != header.shard {
            bail!(
                "{NAME} holds shard {} of a sweep, not {}: use another folder",
                self.header.shard,
                header.shard
            );
        }
        if self.header != *header {
            bail!("{NAME} holds rows of another sweep: use another folder, or delete it");
        }
        for group in header.shard.groups(sweep.groups()) {
            let numbers = group * header.group..(group + 1) * header.group;
            let address = &sweep.address(group)[..DIGITS];
            let whole = numbers
                .clone()
                .all(|n| self.rows.get(&n).is_some_and(|(a, _)| a == address));
            if !whole {
                numbers.for_each(|n| {
                    self.rows.remove(&n);
                });
            }
        }
        Ok(())
    }
}

/// A log that grows.
#[derive(Debug)]
pub(super) struct Writer {
    file: File,
    path: PathBuf,
    group: usize,
}

impl Writer {
    /// A new log, or one that goes on after the whole lines of `from`.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub(super) fn new(folder: &Path, header: &Header, from: Option<&Log>) -> anyhow::Result<Self> {
        let path = folder.join(NAME);
        let open = || -> std::io::Result<File> {
            let mut file = OpenOptions::new().create(true).append(true).open(&path)?;
            match from {
                Some(log) => file.set_len(log.length)?,
                None => {
                    file.set_len(0)?;
                    file.write_all(header.text().as_bytes())?;
                }
            }
            Ok(file)
        };
        let file = open().with_context(|| path.display().to_string())?;
        Ok(Self {
            file,
            path,
            group: header.group,
        })
    }

    /// Appends the rows of a group, and returns their CSV lines with their numbers.
    ///
    /// # Errors
    /// If they cannot be written.
    pub(super) fn append(
        &mut self,
        sweep: &Sweep,
        group: usize,
        rows: &[SweepRow],
    ) -> anyhow::Result<Vec<(usize, String)>> {
        let address = &sweep.address(group)[..DIGITS];
        let mut text = String::new();
        let mut lines = Vec::with_capacity(rows.len());
        for (row, number) in SweepRow::table(rows)
            .rows()
            .iter()
            .zip(group * self.group..)
        {
            let line = csv_line(row);
            let sum = checksum(number, address, line.trim_end_matches('\n'));
            text += &format!("{number},{address},{sum},{line}");
            lines.push((number, line));
        }
        let written = self.file.write_all(text.as_bytes());
        written.with_context(|| self.path.display().to_string())?;
        Ok(lines)
    }

    /// Takes the log away: the table is written.
    ///
    /// # Errors
    /// If it cannot be removed.
    pub(super) fn finish(self) -> anyhow::Result<()> {
        drop(self.file);
        std::fs::remove_file(&self.path).with_context(|| self.path.display().to_string())
    }
}

/// The table that lines by number make, if all are there.
pub(super) fn table(lines: impl IntoIterator<Item = String>) -> String {
    let mut text = SWEEP_COLUMNS.join(",") + "\n";
    text.extend(lines);
    text
}

/// The whole table of a sweep whose shards are in `folders`.
///
/// # Errors
/// If a folder has no log, logs are of different sweeps or contradict each other, or rows are missing: the error
/// names the shards that are not complete.
pub(super) fn merge(folders: &[PathBuf]) -> anyhow::Result<String> {
    let mut all: BTreeMap<usize, (String, String)> = BTreeMap::new();
    let mut first: Option<(Header, &Path)> = None;
    for folder in folders {
        let missing = || anyhow!("{}: has no {NAME}", folder.display());
        let log = Log::read(folder)?.ok_or_else(missing)?;
        let (header, origin) = first.get_or_insert((log.header.clone(), folder));
        let alike = Header {
            shard: log.header.shard,
            ..header.clone()
        };
        if log.header != alike || log.header.shard.of() != header.shard.of() {
            let (a, b) = (origin.display(), folder.display());
            bail!("{a} and {b} hold parts of different sweeps, or of one split differently");
        }
        for (number, row) in log.rows {
            if let Some(other) = all.get(&number)
                && *other != row
            {
                bail!(
                    "{}: row {number} differs from another folder's",
                    folder.display()
                );
            }
            all.insert(number, row);
        }
    }
    let Some((header, _)) = first else {
        bail!("want the folders that `--shard` wrote to");
    };
    if all.len() < header.rows {
        let of = header.shard.of();
        let mut shards: Vec<usize> = (0..header.rows)
            .filter(|n| !all.contains_key(n))
            .map(|n| (n / header.group) % of + 1)
            .collect();
        shards.sort_unstable();
        shards.dedup();
        let names: Vec<String> = shards.iter().map(|k| format!("{k}/{of}")).collect();
        bail!(
            "{} of {} rows are missing: not complete: shard {}",
            header.rows - all.len(),
            header.rows,
            names.join(", ")
        );
    }
    Ok(table(all.into_values().map(|(_, line)| line)))
}
