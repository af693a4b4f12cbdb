use std::fmt::Write;

use foveasim_models::Nanos;

use crate::Cell;

/// A row of the timeline: one thread of one process, in the words of the format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Track {
    process: u32,
    thread: u32,
}

/// A timeline in the Chrome trace event format, which Perfetto (<https://ui.perfetto.dev>) opens.
///
/// Source: *Trace Event Format* (Google, the public format document): phases `M` metadata, `X`
/// complete, `i` instant, `C` counter, `s`/`t`/`f` flow. Times are microseconds there; nanoseconds
/// are kept as three decimals. Events may be added in any order.
#[derive(Debug, Clone, Default)]
pub struct TraceEvents {
    events: Vec<String>,
    processes: u32,
    threads: u32,
    flows: u64,
}

impl TraceEvents {
    /// An empty timeline.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a group of rows; groups appear in the order they are added.
    pub fn process(&mut self, name: &str) -> u32 {
        self.processes += 1;
        let id = self.processes;
        let name = quoted(name);
        self.events.push(format!(
            r#"{{"ph":"M","name":"process_name","pid":{id},"args":{{"name":{name}}}}}"#
        ));
        self.events.push(format!(
            r#"{{"ph":"M","name":"process_sort_index","pid":{id},"args":{{"sort_index":{id}}}}}"#
        ));
        id
    }

    /// Adds a row to a group, such as one per stage of the pipeline.
    pub fn track(&mut self, process: u32, name: &str) -> Track {
        self.threads += 1;
        let track = Track {
            process,
            thread: self.threads,
        };
        let (place, name, index) = (track.place(), quoted(name), self.threads);
        self.events.push(format!(
            r#"{{"ph":"M","name":"thread_name",{place},"args":{{"name":{name}}}}}"#
        ));
        self.events.push(format!(
            r#"{{"ph":"M","name":"thread_sort_index",{place},"args":{{"sort_index":{index}}}}}"#
        ));
        track
    }

    /// Something that takes time. `args` are shown when it is selected.
    pub fn complete(
        &mut self,
        track: Track,
        name: &str,
        start: Nanos,
        duration: Nanos,
        args: &[(&str, Cell)],
    ) {
        let (place, name, args) = (track.place(), quoted(name), arguments(args));
        let (ts, dur) = (micros(start), micros(duration.max(Nanos(0))));
        self.events.push(format!(
            r#"{{"ph":"X","name":{name},{place},"ts":{ts},"dur":{dur}{args}}}"#
        ));
    }

    /// Something that happens at once.
    pub fn instant(&mut self, track: Track, name: &str, at: Nanos, args: &[(&str, Cell)]) {
        let (place, name, args, ts) = (track.place(), quoted(name), arguments(args), micros(at));
        self.events.push(format!(
            r#"{{"ph":"i","s":"t","name":{name},{place},"ts":{ts}{args}}}"#
        ));
    }

    /// A quantity over time, drawn as a curve above the group's rows. A value that is not finite is
    /// left out: the curve keeps the one before.
    pub fn counter(&mut self, process: u32, name: &str, at: Nanos, value: f64) {
        if value.is_finite() {
            let (name, ts) = (quoted(name), micros(at));
            self.events.push(format!(
                r#"{{"ph":"C","name":{name},"pid":{process},"ts":{ts},"args":{{"value":{value}}}}}"#
            ));
        }
    }

    /// Arrows along `steps`, from each to the next: the way of one gaze sample to its photons. Each
    /// step must lie within an event that takes time on its track, or the viewer finds nothing to
    /// fasten the arrow to. Fewer than two steps draw nothing.
    pub fn flow(&mut self, name: &str, steps: &[(Track, Nanos)]) {
        if steps.len() < 2 {
            return;
        }
        self.flows += 1;
        let (id, name) = (self.flows, quoted(name));
        for (k, (track, at)) in steps.iter().enumerate() {
            let phase = match k {
                0 => r#""s""#,
                k if k + 1 == steps.len() => r#""f","bp":"e""#,
                _ => r#""t","bp":"e""#,
            };
            let (place, ts) = (track.place(), micros(*at));
            self.events.push(format!(
                r#"{{"ph":{phase},"cat":"flow","name":{name},"id":{id},{place},"ts":{ts}}}"#
            ));
        }
    }

    /// The file, one event per line.
    pub fn json(&self) -> String {
        let mut out = String::from("{\"displayTimeUnit\":\"ms\",\"traceEvents\":[\n");
        for (k, event) in self.events.iter().enumerate() {
            let comma = if k + 1 < self.events.len() { "," } else { "" };
            // Writing to a string cannot fail.
            let _ = writeln!(out, "{event}{comma}");
        }
        out.push_str("]}\n");
        out
    }
}

impl Track {
    fn place(self) -> String {
        format!(r#""pid":{},"tid":{}"#, self.process, self.thread)
    }
}

/// Nanoseconds as microseconds, exactly.
fn micros(t: Nanos) -> String {
    let sign = if t.0 < 0 { "-" } else { "" };
    let ns = t.0.unsigned_abs();
    format!("{sign}{}.{:03}", ns / 1000, ns % 1000)
}

fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

fn arguments(args: &[(&str, Cell)]) -> String {
    if args.is_empty() {
        return String::new();
    }
    let fields: Vec<String> = args
        .iter()
        .map(|(name, value)| format!("{}:{}", quoted(name), value.to_json()))
        .collect();
    format!(r#","args":{{{}}}"#, fields.join(","))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use serde_json::Value;

    use super::*;

    fn sample() -> TraceEvents {
        let mut trace = TraceEvents::new();
        let process = trace.process("pipeline \"A\"");
        let (tracker, render) = (
            trace.track(process, "tracker"),
            trace.track(process, "render\n"),
        );
        for k in 0..3 {
            let at = Nanos(k * 8_333_333);
            trace.complete(
                tracker,
                "sample",
                at,
                Nanos(3_000_001),
                &[("azimuth_deg", 1.5.into())],
            );
            trace.complete(
                render,
                "frame",
                at + Nanos(4_000_000),
                Nanos(2_000_000),
                &[],
            );
            trace.flow(
                "gaze",
                &[
                    (tracker, at),
                    (render, at + Nanos(4_500_000)),
                    (render, at + Nanos(5_000_000)),
                ],
            );
        }
        trace.instant(
            render,
            "vsync",
            Nanos(-1_234_567),
            &[("bad", f64::NAN.into())],
        );
        trace.counter(process, "error_deg", Nanos(5), 0.25);
        trace.counter(process, "error_deg", Nanos(6), f64::NAN);
        trace.flow("none", &[(render, Nanos(0))]);
        trace
    }

    #[test]
    fn is_json_with_every_flow_begun_and_ended_once() {
        let parsed: Value = serde_json::from_str(&sample().json()).unwrap();
        let events = parsed["traceEvents"].as_array().unwrap();
        let mut flows: BTreeMap<u64, String> = BTreeMap::new();
        let mut names = Vec::new();
        for e in events {
            let phase = e["ph"].as_str().unwrap();
            match phase {
                "M" => names.push(e["args"]["name"].as_str().unwrap_or_default()),
                "s" | "t" | "f" => flows
                    .entry(e["id"].as_u64().unwrap())
                    .or_default()
                    .push_str(phase),
                "X" => assert!(e["dur"].is_number() && e["tid"].is_u64()),
                "i" => assert!(e["args"]["bad"].is_null() && e["ts"] == -1234.567),
                "C" => assert_eq!(e["args"]["value"], 0.25),
                other => panic!("unexpected phase {other}"),
            }
        }
        assert_eq!(flows.values().collect::<Vec<_>>(), ["stf"; 3]);
        assert!(names.contains(&"pipeline \"A\"") && names.contains(&"render\n"));
        assert_eq!(events.iter().filter(|e| e["ph"] == "C").count(), 1);
    }

    #[test]
    fn nanoseconds_are_kept() {
        assert!(
            sample()
                .json()
                .contains("\"ts\":16666.666,\"dur\":3000.001")
        );
        assert_eq!(micros(Nanos(-1)), "-0.001");
        assert_eq!(micros(Nanos(i64::MIN)), "-9223372036854775.808");
    }
}
