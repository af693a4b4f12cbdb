use std::borrow::Cow;

use foveasim_models::math::to_rad;
use foveasim_models::{GazeDirection, Nanos, Pose, Provenance, Sample};
use glam::{DQuat, DVec3};

use super::axes::unity_euler;
use super::columns::Columns;
use super::eyes::EyePair;
use super::gyroscope::Gyroscope;
use super::layout::{Layout, Rotation};
use super::number::Row;
use super::places::{EyePlaces, Places, PosePlaces, WIDE};
use super::rows::{AllRows, RowReader, RowSamples};
use super::runs::Runs;
use super::segments::choose;
use super::{GAZE_ASSUMED, Head, POSE_ASSUMED, count, in_order, no_rows};
use crate::lines::Line;
use crate::{Labels, ReadOptions, Screen, TargetStep, TraceError};

/// Columns not used are listed up to this many, and counted beyond.
const LISTED: usize = 12;

/// Reads a delimited file of any [`Layout`].
pub(super) struct Table<'a> {
    layout: &'a Layout,
    file: &'a str,
    names: [&'static str; WIDE],
    columns: Columns<WIDE>,
    time: usize,
    eyes: Vec<Option<EyePlaces>>,
    pose: Option<PosePlaces>,
    target: Option<([usize; 2], Option<usize>)>,
    session: Option<usize>,
    /// Which field of a row two columns are written in, where they are.
    glued: Option<usize>,
    screen: Option<Screen>,
    pair: EyePair,
    gyroscope: Gyroscope,
    runs: Vec<(usize, Runs)>,
    previous: Option<Nanos>,
    previous_session: String,
    starts: Vec<usize>,
    /// Rows read so far.
    rows: usize,
    targets: Vec<TargetStep>,
    duplicates: usize,
    mended: usize,
    blinking: usize,
    integrated: bool,
}

impl<'a> Table<'a> {
    pub(super) fn new(
        layout: &'a Layout,
        head: &Head,
        file: &'a str,
        options: &ReadOptions,
    ) -> Result<Self, TraceError> {
        let Places {
            names,
            time,
            eyes,
            pose,
            target,
            session,
            events,
        } = Places::new(layout);
        let columns = Columns::new(file, &head.columns, names)?;
        let header = |what: String| TraceError::Header {
            file: file.to_owned(),
            line: head.columns.0,
            what,
        };
        if !columns.has(time) {
            return Err(header(format!("no column {}", names[time])));
        }
        let whole = |places: &[usize]| places.iter().all(|&i| columns.has(i));
        let eyes: Vec<_> = eyes
            .into_iter()
            .map(|e| Some(e).filter(|e| whole(&e.coordinates)))
            .collect();
        if !eyes.is_empty() && eyes.iter().all(Option::is_none) {
            let wants: Vec<_> = layout
                .eyes
                .iter()
                .map(|e| e.columns.join(" and "))
                .collect();
            return Err(header(format!(
                "one coordinate of each eye alone; want {}",
                wants.join(", or ")
            )));
        }
        let needed = pose.as_ref().map(PosePlaces::needed).unwrap_or_default();
        if let Some(i) = needed.into_iter().find(|&i| !columns.has(i)) {
            return Err(header(format!("no column {}", names[i])));
        }
        let runs = layout.events.iter().zip(events);
        let runs = runs.map(|((kind, _), place)| (place, Runs::new(*kind)));
        let present = |i: usize| eyes.get(i).is_some_and(Option::is_some);
        let glued = layout.glued.and_then(|[first, _]| {
            let name = |n: &&str| n.eq_ignore_ascii_case(first);
            super::columns::names(&head.columns.1).iter().position(name)
        });
        Ok(Self {
            time,
            target: target.filter(|(xy, _)| whole(xy)),
            session: session.filter(|&i| columns.has(i)),
            glued,
            screen: layout.coding.screen().map(|s| options.screen.or(s)),
            pair: EyePair::new([present(0), present(1)], layout.coding.of()),
            gyroscope: Gyroscope::default(),
            runs: runs.filter(|(i, _)| columns.has(*i)).collect(),
            previous: None,
            previous_session: String::new(),
            starts: vec![0],
            rows: 0,
            targets: Vec::new(),
            duplicates: 0,
            mended: 0,
            blinking: 0,
            integrated: false,
            layout,
            file,
            names,
            columns,
            eyes,
            pose,
        })
    }

    /// A row whose number and truth value are written as one field (`666.5324True`), with the separator
    /// that is missing.
    fn mended<'t>(&mut self, text: &'t str) -> Cow<'t, str> {
        let Some(glued) = self.glued else {
            return Cow::Borrowed(text);
        };
        let separator = self.columns.separator();
        if text.matches(separator).count() + 2 != self.columns.width() {
            return Cow::Borrowed(text);
        }
        let start: usize = text
            .split(separator)
            .take(glued)
            .map(|field| field.len() + 1)
            .sum();
        let field = text[start..].split(separator).next().unwrap_or_default();
        let value = ["True", "False"].iter().find(|v| field.ends_with(**v));
        let Some(value) = value else {
            return Cow::Borrowed(text);
        };
        self.mended += 1;
        let (left, right) = text.split_at(start + field.len() - value.len());
        Cow::Owned(format!("{left}{separator}{right}"))
    }

    fn samples(&mut self, row: &Row<'_>, texts: &[&str; WIDE]) -> Result<RowSamples, TraceError> {
        let (name, text) = (self.names[self.time], texts[self.time]);
        let t = match self.layout.time.epoch {
            Some(epoch) => row.ticks(name, text, self.layout.time.exponent, epoch)?,
            None => row.time(name, text, self.layout.time.exponent)?,
        };
        let session = self.session.map_or("", |i| texts[i]);
        let begins = session != self.previous_session && self.previous.is_some_and(|p| t < p);
        if begins && row.complete {
            self.starts.push(self.rows);
        } else {
            in_order(row, self.previous, t)?;
            self.duplicates += usize::from(self.previous == Some(t));
        }
        if session != self.previous_session {
            session.clone_into(&mut self.previous_session);
        }
        self.previous = Some(t);
        self.rows += 1;
        Ok(RowSamples {
            gaze: self.gaze(row, texts, t)?,
            pose: self.pose(row, texts, t)?,
        })
    }

    fn gaze(
        &mut self,
        row: &Row<'_>,
        texts: &[&str; WIDE],
        t: Nanos,
    ) -> Result<Option<Sample<GazeDirection>>, TraceError> {
        if self.eyes.is_empty() {
            return Ok(None);
        }
        let mut blinking = false;
        for (column, run) in &mut self.runs {
            let inside = run.push(t, texts[*column]);
            blinking |= inside && run.kind() == crate::EventKind::Blink;
        }
        let single = self.eyes.len() == 1;
        let left = self.eye(0, row, texts)?;
        let value = if single {
            left
        } else {
            let right = self.eye(1, row, texts)?;
            self.pair.combine([left, right])
        };
        self.blinking += usize::from(blinking && value.is_some());
        let value = value.filter(|_| !blinking);
        self.target_row(row, texts, t)?;
        let value = value.and_then(|v| self.direction(v));
        Ok(Some(Sample { t, value }))
    }

    fn direction(&self, v: DVec3) -> Option<GazeDirection> {
        // Only codings on a screen look at it.
        const NONE: Screen = Screen {
            size_px: [1.0; 2],
            size_mm: [1.0; 2],
            distance_mm: 1.0,
        };
        let screen = self.screen.as_ref().unwrap_or(&NONE);
        self.layout.coding.direction(v, screen)
    }

    /// The coordinates of eye `i`; `None` where it was lost.
    fn eye(
        &self,
        i: usize,
        row: &Row<'_>,
        texts: &[&str; WIDE],
    ) -> Result<Option<DVec3>, TraceError> {
        let Some(Some(places)) = self.eyes.get(i) else {
            return Ok(None);
        };
        if let (Some(place), Some(valid)) = (places.valid, &self.layout.eyes[i].valid)
            && self.columns.has(place)
        {
            match (valid.rule)(texts[place]) {
                Some(true) => {}
                Some(false) => return Ok(None),
                None => return Err(row.bad(valid.column, texts[place], valid.expected)),
            }
        }
        let limit = self.layout.coding.limit();
        let mut v = [0.0; 3];
        let mut lost = false;
        for (v, &place) in v.iter_mut().zip(&places.coordinates) {
            match row.optional(self.names[place], texts[place], -limit..=limit)? {
                Some(value) => *v = value,
                None => lost = true,
            }
        }
        let vector = places.coordinates.len() == 3;
        let v = DVec3::from_array(v);
        let nowhere = vector && v.length() < 1e-6;
        Ok((!lost && !nowhere).then_some(v))
    }

    fn target_row(
        &mut self,
        row: &Row<'_>,
        texts: &[&str; WIDE],
        t: Nanos,
    ) -> Result<(), TraceError> {
        let Some((places, id)) = self.target else {
            return Ok(());
        };
        let none = self.layout.target.as_ref().and_then(|t| t.none);
        let absent = id
            .zip(none)
            .is_some_and(|(i, (_, value))| texts[i] == value);
        let mut xy = [None; 2];
        for (c, place) in xy.iter_mut().zip(places) {
            *c = row.optional(self.names[place], texts[place], -1e6..=1e6)?;
        }
        let place = xy[0].zip(xy[1]).filter(|_| !absent);
        let target = place.and_then(|(x, y)| self.direction(DVec3::new(x, y, 0.0)));
        if self.targets.last().is_none_or(|last| last.target != target) {
            self.targets.push(TargetStep { t, target });
        }
        Ok(())
    }

    fn pose(
        &mut self,
        row: &Row<'_>,
        texts: &[&str; WIDE],
        t: Nanos,
    ) -> Result<Option<Sample<Pose>>, TraceError> {
        let (Some(places), Some(pose)) = (&self.pose, &self.layout.pose) else {
            return Ok(None);
        };
        let numbers = |places: &[usize], limit: f64| -> Result<Option<Vec<f64>>, TraceError> {
            let value = |&i: &usize| row.optional(self.names[i], texts[i], -limit..=limit);
            places.iter().map(value).collect()
        };
        let position = match &places.position {
            Some(places) => numbers(places, 1e6)?.map(|v| DVec3::new(v[0], v[1], v[2])),
            None => Some(DVec3::ZERO),
        };
        let rotation = match &pose.rotation {
            Rotation::UnityEuler(_) => numbers(&places.rotation, 3600.0)?
                .map(|v| unity_euler(DVec3::new(v[0], v[1], v[2]))),
            Rotation::Quaternion(_) => self.quaternion(row, texts, &places.rotation)?,
            Rotation::Gyroscope { .. } => self.quaternion(row, texts, &places.rotation)?,
        };
        // A helmet at the very origin that is not turned at all is one that was not tracked.
        let tracked = |(p, q): &(DVec3, DQuat)| {
            places.position.is_none() || *p != DVec3::ZERO || *q != DQuat::IDENTITY
        };
        let mut value = position
            .zip(rotation)
            .filter(tracked)
            .map(|(p, q)| pose.frame.pose(p, q));
        if let (None, Rotation::Gyroscope { axes, .. }, Some(rate)) =
            (rotation, &pose.rotation, places.rate)
            && let Some(v) = numbers(&rate, 1e5)?
        {
            let rate = DVec3::new(v[0], v[1], v[2]) * to_rad(1.0);
            let turned = self.gyroscope.turn(t, axes.axial(rate));
            value = Some(Pose::new(DVec3::ZERO, turned));
            self.integrated = true;
        }
        Ok(Some(Sample { t, value }))
    }

    /// A quaternion from four fields; `None` where they are empty, or all zero.
    fn quaternion(
        &self,
        row: &Row<'_>,
        texts: &[&str; WIDE],
        places: &[usize],
    ) -> Result<Option<DQuat>, TraceError> {
        let mut q = [0.0; 4];
        for (q, &i) in q.iter_mut().zip(places) {
            match row.optional(self.names[i], texts[i], -1.1..=1.1)? {
                Some(value) => *q = value,
                None => return Ok(None),
            }
        }
        if q == [0.0; 4] {
            return Ok(None);
        }
        let rotation = row.rotation(q);
        rotation.map(Some).ok_or_else(|| {
            let joined = |of: &dyn Fn(usize) -> &'a str| -> String {
                places.iter().map(|&i| of(i)).collect::<Vec<_>>().join(",")
            };
            let values: Vec<_> = places.iter().map(|&i| texts[i]).collect();
            row.bad(
                &joined(&|i| self.names[i]),
                &values.join(","),
                "a quaternion of length 1 (within 0.02)",
            )
        })
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if !self.eyes.is_empty() {
            notes.push(GAZE_ASSUMED.to_owned());
        }
        if self.pose.is_some() {
            notes.push(POSE_ASSUMED.to_owned());
        }
        if let Some(screen) = &self.screen {
            notes.push(format!(
                "pixels turned into degrees for a screen of {screen}"
            ));
        }
        if self.eyes.len() == 2 {
            notes.extend(self.pair.notes());
        }
        notes.extend(self.layout.notes.iter().map(|n| (*n).to_owned()));
        if self.blinking > 0 {
            notes.push(format!(
                "{} inside blinks that the file labels, where its values go on: taken as lost",
                count(self.blinking, "sample")
            ));
        }
        if self.integrated {
            notes.push(
                "head orientation integrated from the gyroscope from an arbitrary start: it drifts, and the \
                 head's place is not known"
                    .into(),
            );
        }
        if self.gyroscope.holes > 0 {
            notes.push(format!(
                "{} of the gyroscope not bridged",
                count(self.gyroscope.holes, "hole")
            ));
        }
        if self.mended > 0 {
            let [first, second] = self.layout.glued.unwrap_or_default();
            notes.push(format!(
                "{} in which {first} and {second} are one field, taken apart",
                count(self.mended, "row")
            ));
        }
        if self.duplicates > 0 {
            notes.push(format!(
                "{} with the time of the sample before; the later one counts",
                count(self.duplicates, "sample")
            ));
        }
        match self.columns.extra() {
            [] => {}
            extra if extra.len() <= LISTED => {
                notes.push(format!("columns not used: {}", extra.join(", ")));
            }
            extra => notes.push(format!("{} not used", count(extra.len(), "column"))),
        }
        notes
    }
}

impl RowReader for Table<'_> {
    fn row(&mut self, line: &Line<'_>) -> Result<RowSamples, TraceError> {
        let row = Row::new(self.file, line, self.columns.decimal_comma());
        let text = self.mended(line.text);
        let texts = row.pick(&self.columns, &text)?;
        if !line.complete && text.ends_with(self.columns.separator()) {
            // Where a field is empty at the end of what has no end, it was lost.
            let width = self.columns.width();
            return Err(row.field_count(width - 1, width));
        }
        self.samples(&row, &texts)
    }

    fn finish(&mut self, options: &ReadOptions) -> Result<AllRows, TraceError> {
        if self.rows == 0 {
            return Err(no_rows(self.file));
        }
        let (range, note) = choose(self.file, &self.starts, self.rows, "row", options)?;
        let mut notes = self.notes();
        notes.extend(note);
        let mut events: Vec<_> = self.runs.iter_mut().flat_map(|(_, r)| r.finish()).collect();
        events.sort_by_key(|e| e.start);
        Ok(AllRows {
            range,
            provenance: [Provenance::Truth; 2],
            notes,
            labels: Labels {
                events,
                targets: std::mem::take(&mut self.targets),
            },
        })
    }
}
