//! The trace event format, as Perfetto and chrome://tracing read it (Google, "Trace Event Format", 2016).
//!
//! One process; a thread of systems in which each frame encloses its systems and those their steps; a thread of the device's
//! passes; counters. Every event says which frame it is of.

use std::io::{self, Write};

use serde::Serialize;
use serde_json::{Value, json};

use crate::profile::Frame;

const PROCESS: u32 = 1;
const HOST: u32 = 1;
const DEVICE: u32 = 2;

/// A complete event: begin and length in microseconds.
#[derive(Serialize)]
struct Complete<'a> {
    name: &'a str,
    cat: &'static str,
    ph: &'static str,
    ts: f64,
    dur: f64,
    pid: u32,
    tid: u32,
    args: Value,
}

/// Opens the list, and names process and threads.
pub fn begin(out: &mut impl Write, device: &str) -> io::Result<()> {
    let name = |what: &str, tid: u32, name: &str| json!({ "name": what, "ph": "M", "pid": PROCESS, "tid": tid, "args": { "name": name } });
    out.write_all(b"[\n")?;
    let names = [
        name("process_name", 0, &format!("Orrery: {device}")),
        name("thread_name", HOST, "frame"),
        name("thread_name", DEVICE, "device"),
    ];
    for (i, name) in names.iter().enumerate() {
        if i > 0 {
            out.write_all(b",\n")?;
        }
        serde_json::to_writer(&mut *out, name)?;
    }
    Ok(())
}

/// Adds the events of a frame.
pub fn frame(out: &mut impl Write, frame: &Frame) -> io::Result<()> {
    let begin = frame.start_micros;
    let id = frame.id;
    let event = |name, cat, (start, dur): (f64, f64), tid, args| Complete {
        name,
        cat,
        ph: "X",
        ts: begin + start,
        dur,
        pid: PROCESS,
        tid,
        args,
    };
    let title = format!("frame {id}");
    let about = json!({ "frame": id, "secs": frame.secs, "wait_micros": frame.wait_micros });
    write(
        out,
        &event(&title, "frame", (0.0, frame.micros), HOST, about),
    )?;
    for span in &frame.spans {
        let kind = if span.depth == 0 { "system" } else { "step" };
        let time = (span.start_micros, span.micros);
        let args = json!({ "frame": id });
        write(out, &event(&span.name, kind, time, HOST, args))?;
    }
    for pass in &frame.passes {
        let time = (pass.start_micros, pass.micros);
        let args = json!({ "frame": id, "up_to_micros_later": pass.error_micros });
        write(out, &event(&pass.name, "pass", time, DEVICE, args))?;
    }
    let counters = frame.counters;
    let counted = json!({
        "camera": counters.primary_rays,
        "mirrored": counters.reflected_rays,
        "refracted": counters.refracted_rays,
        "shadow": counters.shadow_rays,
    });
    let rays = json!({ "name": "rays", "ph": "C", "ts": begin, "pid": PROCESS, "args": counted });
    write(out, &rays)?;
    let bytes = json!({ "bytes": counters.bytes_uploaded });
    let uploaded =
        json!({ "name": "uploaded", "ph": "C", "ts": begin, "pid": PROCESS, "args": bytes });
    write(out, &uploaded)
}

/// Closes the list.
pub fn end(out: &mut impl Write) -> io::Result<()> {
    out.write_all(b"\n]\n")
}

/// One more event: the names have come first.
fn write(out: &mut impl Write, event: &impl Serialize) -> io::Result<()> {
    out.write_all(b",\n")?;
    serde_json::to_writer(out, event).map_err(io::Error::from)
}

#[cfg(test)]
mod tests {
    use super::super::{Format, tests::written};
    use super::*;

    #[test]
    fn a_trace_parses_its_spans_nest_and_both_sides_agree_on_frames() {
        let text = written(Format::Trace);
        let events: Vec<Value> = serde_json::from_str(&text).expect("JSON");
        let number = |event: &Value, key: &str| event[key].as_f64().expect("a number");
        let complete: Vec<&Value> = events.iter().filter(|e| e["ph"] == "X").collect();
        assert_eq!(complete.len(), 2 * 5);
        for event in &events {
            assert!(
                event["pid"].is_u64() && event["name"].is_string(),
                "{event}"
            );
            assert!(["X", "M", "C"].contains(&event["ph"].as_str().unwrap()));
        }
        let on = |thread: u32| complete.iter().filter(move |e| e["tid"] == thread);
        // Perfetto wants events of a thread to nest, in order.
        let mut open: Vec<f64> = Vec::new();
        for event in on(HOST) {
            let (start, length) = (number(event, "ts"), number(event, "dur"));
            while open.last().is_some_and(|&end| start >= end) {
                open.pop();
            }
            assert!(
                open.last().is_none_or(|&end| start + length <= end + 1e-6),
                "{event}"
            );
            open.push(start + length);
        }
        let frames = |thread| -> Vec<u64> {
            let mut ids: Vec<u64> = on(thread)
                .map(|e| e["args"]["frame"].as_u64().unwrap())
                .collect();
            ids.dedup();
            ids
        };
        assert_eq!(frames(HOST), [7, 8]);
        assert_eq!(frames(DEVICE), frames(HOST));
    }
}
