use std::io::BufRead;

use foveasim_models::math::{mean, to_deg};
use foveasim_models::{Eye, Nanos, Provenance, Rate, Recording, Sample};
use glam::DVec3;

use super::eyes::EyePair;
use super::number::Row;
use super::{GAZE_ASSUMED, Parsed, count, in_order, no_rows, series};
use crate::lines::Lines;
use crate::{EventKind, LabelledEvent, Labels, ReadOptions, Screen, TraceError};

/// Values per eye and sample: x, y, size of the pupil.
const PER_EYE: usize = 3;
/// The most fields of a line that are looked at.
const FIELDS: usize = 1 + 2 * PER_EYE;
/// Farthest gaze \[px\]; trackers extrapolate beyond the screen, but not this far.
const MAX_PX: f64 = 1e6;

/// Where nothing is said: a 24-inch screen at a desk. It is noted.
const ASSUMED_SCREEN: Screen = Screen {
    size_px: [1920.0, 1080.0],
    size_mm: [528.0, 297.0],
    distance_mm: 650.0,
};

/// Whether a line can be the first of a file of this format.
pub(super) fn begins(line: &str) -> bool {
    let mut words = line.split_ascii_whitespace();
    let first = words.next().unwrap_or_default();
    let number = |w: Option<&str>| w.is_some_and(|w| w.parse::<f64>().is_ok());
    first.starts_with("**") || (["MSG", "START", "INPUT"].contains(&first) && number(words.next()))
}

/// EyeLink's ASC (SR Research, edf2asc): samples between `START` and `END`, with messages and events in
/// between.
///
/// * `SAMPLES … RATE` states how often gaze was sampled: excerpts leave samples out.
/// * Times are in ms, with one decimal at 2 kHz. Blocks follow one another; the holes between are gaps.
/// * Samples have x, y (pixels from the top-left) and pupil size of one eye or both, as `SAMPLES` says;
///   what follows (input, target, flags) is not read. `.` is a lost value.
/// * Pixels become degrees by the resolution that `END … RES` states \[px/deg\], the mean over where the eye
///   looked, unless the screen's size and distance are given: the file has neither.
/// * `EFIX`, `ESACC` and `EBLINK` become labels.
/// * Lines outside of blocks, and inside of them those that begin with neither a digit nor a known word,
///   are text of calibrations, which spans lines.
pub(super) fn parse<R: BufRead>(
    lines: &mut Lines<'_, R>,
    options: &ReadOptions,
) -> Result<Parsed, TraceError> {
    let file = lines.file();
    let mut state = State::new(file);
    while let Some(line) = lines.next()? {
        let row = Row::new(file, &line, false);
        state.line(&row, line.text)?;
    }
    state.finish(options)
}

struct State<'a> {
    file: &'a str,
    /// Inside a block.
    recording: bool,
    eyes: Option<[bool; 2]>,
    /// As the first block says.
    rate: Option<Rate>,
    pair: EyePair,
    /// Left, top, right and bottom pixel.
    coordinates: Option<[f64; 4]>,
    /// Pixels per degree of each block, in x and y.
    resolutions: [Vec<f64>; 2],
    blocks: usize,
    samples: Vec<Sample<DVec3>>,
    previous: Option<Nanos>,
    duplicates: usize,
    events: Vec<LabelledEvent>,
}

impl<'a> State<'a> {
    fn new(file: &'a str) -> Self {
        Self {
            file,
            recording: false,
            eyes: None,
            rate: None,
            pair: EyePair::new([true, true], " on the screen"),
            coordinates: None,
            resolutions: [Vec::new(), Vec::new()],
            blocks: 0,
            samples: Vec::new(),
            previous: None,
            duplicates: 0,
            events: Vec::new(),
        }
    }

    fn line(&mut self, row: &Row<'_>, text: &str) -> Result<(), TraceError> {
        if text.as_bytes()[0].is_ascii_digit() {
            return if self.recording {
                self.sample(row, text)
            } else {
                Ok(())
            };
        }
        let mut words = text.split_ascii_whitespace();
        match words.next().unwrap_or_default() {
            "START" => {
                self.recording = true;
                self.blocks += 1;
            }
            "END" => {
                self.recording = false;
                self.end(words);
            }
            "SAMPLES" => self.described(row, text)?,
            "EFIX" => self.event(row, EventKind::Fixation, words)?,
            "ESACC" => self.event(row, EventKind::Saccade, words)?,
            "EBLINK" => self.event(row, EventKind::Blink, words)?,
            "MSG" => self.message(row, words)?,
            _ => {}
        }
        Ok(())
    }

    /// `SAMPLES GAZE LEFT RIGHT RATE 500.00 …`.
    fn described(&mut self, row: &Row<'_>, text: &str) -> Result<(), TraceError> {
        let has = |word| text.split_ascii_whitespace().any(|w| w == word);
        let eyes = [has("LEFT"), has("RIGHT")];
        if !has("GAZE") || eyes == [false, false] {
            let valid = "samples of GAZE of LEFT, RIGHT or both";
            return Err(row.bad("SAMPLES", text, valid));
        }
        if self.eyes.is_some_and(|before| before != eyes) {
            let valid = "the same eyes in all blocks";
            return Err(row.bad("SAMPLES", text, valid));
        }
        if self.eyes.is_none() {
            self.pair = EyePair::new(eyes, " on the screen");
        }
        self.eyes = Some(eyes);
        let mut after = text.split_ascii_whitespace().skip_while(|w| *w != "RATE");
        if let (None, Some(hz)) = (self.rate, after.nth(1)) {
            let hz = row.number("RATE", hz, 1.0..=1e5)?;
            self.rate = Rate::from_hz("RATE", hz).ok();
        }
        Ok(())
    }

    fn sample(&mut self, row: &Row<'_>, text: &str) -> Result<(), TraceError> {
        let Some(eyes) = self.eyes else {
            return Err(TraceError::Header {
                file: self.file.to_owned(),
                line: row.line,
                what: "a sample before any line SAMPLES that says which eyes there are".into(),
            });
        };
        let mut fields = [""; FIELDS];
        let mut found = 0;
        for (field, text) in fields.iter_mut().zip(text.split_ascii_whitespace()) {
            *field = text;
            found += 1;
        }
        let wanted = 1 + PER_EYE * eyes.iter().filter(|e| **e).count();
        if found < wanted {
            return Err(row.field_count(found, wanted));
        }
        let t = row.time("time", fields[0], -3)?;
        in_order(row, self.previous, t)?;
        self.duplicates += usize::from(self.previous == Some(t));
        self.previous = Some(t);
        let mut values = [None; 2];
        let mut first = 1;
        for (value, _) in values.iter_mut().zip(eyes).filter(|(_, present)| *present) {
            let coordinate = |name, text: &str| match text {
                "." => Ok(None),
                text => row.number(name, text, -MAX_PX..=MAX_PX).map(Some),
            };
            let x = coordinate("x", fields[first])?;
            let y = coordinate("y", fields[first + 1])?;
            *value = x.zip(y).map(|(x, y)| DVec3::new(x, y, 0.0));
            first += PER_EYE;
        }
        self.samples.push(Sample {
            t,
            value: self.pair.combine(values),
        });
        Ok(())
    }

    /// `E… L start end …`.
    fn event<'t>(
        &mut self,
        row: &Row<'_>,
        kind: EventKind,
        mut words: impl Iterator<Item = &'t str>,
    ) -> Result<(), TraceError> {
        let mut word = || words.next().ok_or_else(|| row.field_count(1, 4));
        let eye = match word()? {
            "L" => Eye::Left,
            "R" => Eye::Right,
            other => return Err(row.bad("eye", other, "L or R")),
        };
        let start = row.time("start", word()?, -3)?;
        let end = row.time("end", word()?, -3)?;
        if end < start {
            return Err(TraceError::TimeReversed {
                file: self.file.to_owned(),
                line: row.line,
                from: start,
                to: end,
            });
        }
        self.events.push(LabelledEvent {
            kind,
            eye: Some(eye),
            start,
            end,
        });
        Ok(())
    }

    /// `MSG time GAZE_COORDS left top right bottom`; `DISPLAY_COORDS` where there is no such.
    fn message<'t>(
        &mut self,
        row: &Row<'_>,
        mut words: impl Iterator<Item = &'t str>,
    ) -> Result<(), TraceError> {
        let name = words.nth(1).unwrap_or_default();
        if name != "GAZE_COORDS" && !(name == "DISPLAY_COORDS" && self.coordinates.is_none()) {
            return Ok(());
        }
        let mut edges = [0.0; 4];
        for edge in &mut edges {
            *edge = row.number(name, words.next().unwrap_or_default(), -1e6..=1e6)?;
        }
        if edges[2] <= edges[0] || edges[3] <= edges[1] {
            let text = format!("{edges:?}");
            return Err(row.bad(name, &text, "left, top, right, bottom"));
        }
        self.coordinates = Some(edges);
        Ok(())
    }

    /// `END time SAMPLES EVENTS RES x y`; what is no number says nothing.
    fn end<'t>(&mut self, words: impl Iterator<Item = &'t str>) {
        let mut words = words.skip_while(|w| *w != "RES").skip(1);
        let mut number = || words.next()?.parse::<f64>().ok();
        if let (Some(x), Some(y)) = (number(), number())
            && [x, y].iter().all(|r| (1.0..=1e4).contains(r))
        {
            self.resolutions[0].push(x);
            self.resolutions[1].push(y);
        }
    }

    fn finish(self, options: &ReadOptions) -> Result<Parsed, TraceError> {
        if self.samples.is_empty() {
            return Err(no_rows(self.file));
        }
        let mut notes = vec![GAZE_ASSUMED.to_owned()];
        let (screen, centre) = self.screen(options, &mut notes)?;
        let mm_per_px = [0, 1].map(|i| screen.size_mm[i] / screen.size_px[i]);
        let direction = |p: DVec3| {
            screen.direction([
                (p.x - centre[0]) * mm_per_px[0],
                (p.y - centre[1]) * mm_per_px[1],
            ])
        };
        let gaze = self.samples.iter().map(|s| Sample {
            t: s.t,
            value: s.value.map(direction),
        });
        let gaze = gaze.collect();
        notes.extend(self.pair.notes());
        notes.push(format!("{} of recording", count(self.blocks, "block")));
        if self.duplicates > 0 {
            notes.push(format!(
                "{} with the time of the sample before; the later one counts",
                count(self.duplicates, "sample")
            ));
        }
        Ok(Parsed {
            recording: Recording {
                gaze: series(gaze, Provenance::Truth),
                gaze_rate: self.rate,
                notes,
                ..Recording::default()
            },
            labels: Labels {
                events: self.events,
                targets: Vec::new(),
            },
        })
    }

    /// The screen, and the pixel at its centre.
    fn screen(
        &self,
        options: &ReadOptions,
        notes: &mut Vec<String>,
    ) -> Result<(Screen, [f64; 2]), TraceError> {
        let missing = |what: &str| TraceError::Header {
            file: self.file.to_owned(),
            line: 1,
            what: format!("{what}; give screen_px, screen_mm and distance_mm"),
        };
        let edges = self.coordinates;
        // The last pixel counts: 0 to 1279 are 1280.
        let size = edges.map(|[l, t, r, b]| [r - l + 1.0, b - t + 1.0]);
        let size_px = options.screen.size_px.or(size);
        let size_px =
            size_px.ok_or_else(|| missing("no GAZE_COORDS say how many pixels the screen had"))?;
        let centre = edges.map_or(size_px.map(|s| 0.5 * (s - 1.0)), |[l, t, r, b]| {
            [0.5 * (l + r), 0.5 * (t + b)]
        });
        let screen = match (options.screen.size_mm, options.screen.distance_mm) {
            (Some(size_mm), Some(distance_mm)) => {
                let screen = Screen {
                    size_px,
                    size_mm,
                    distance_mm,
                };
                notes.push(format!(
                    "pixels turned into degrees for a screen of {screen}"
                ));
                screen
            }
            (None, None) => {
                if self.resolutions[0].is_empty() {
                    let screen = Screen {
                        size_px,
                        ..ASSUMED_SCREEN
                    };
                    notes.push(format!(
                        "no END with RES says how many pixels a degree had: a screen of {screen} is assumed; \
                         --screen-mm and --distance-mm replace it"
                    ));
                    return Ok((screen, centre));
                }
                let [x, y] = [0, 1].map(|i| mean(&self.resolutions[i]));
                notes.push(format!(
                    "pixels turned into degrees by the file's mean resolution of {x:.1} x {y:.1} px per degree, \
                     taken as that of the centre; --screen-mm and --distance-mm replace it"
                ));
                // In units of a pixel's width.
                Screen {
                    size_px,
                    size_mm: [size_px[0], size_px[1] * x / y],
                    distance_mm: to_deg(x),
                }
            }
            _ => return Err(missing("a screen's size and its distance belong together")),
        };
        Ok((screen, centre))
    }
}
