//! `--profile FILE`: when every system and pass of every frame ran, and for how long.
//!
//! CSV has a row a span; JSON is the list of events that chrome://tracing and Perfetto read.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use orrery_engine::profile::Profile;
use serde::Serialize;

use crate::failure::Failure;

/// An open file of spans, or none.
pub struct ProfileLog(Option<OpenLog>);

struct OpenLog {
    path: PathBuf,
    out: BufWriter<File>,
    format: Format,
    /// Microseconds of the frames before: JSON events lie one frame after the other.
    elapsed_micros: f64,
    rows: u64,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Format {
    Csv,
    Json,
}

/// A complete event of the trace event format.
#[derive(Serialize)]
struct Event<'a> {
    name: &'a str,
    cat: &'static str,
    ph: &'static str,
    ts: f64,
    dur: f64,
    pid: u32,
    tid: u32,
    args: FrameNumber,
}

#[derive(Serialize)]
struct FrameNumber {
    frame: u64,
}

/// One thing that took time: its kind, name, start in the frame and length, microseconds.
struct Row<'a> {
    kind: &'static str,
    name: &'a str,
    start_micros: f64,
    micros: f64,
}

impl ProfileLog {
    /// Opens the file; without a path, a log that keeps nothing.
    pub fn open(path: Option<&Path>) -> Result<Self, Failure> {
        let Some(path) = path else {
            return Ok(Self(None));
        };
        let format = match path.extension().and_then(|e| e.to_str()) {
            Some("csv") => Format::Csv,
            Some("json") => Format::Json,
            _ => {
                return Err(Failure::Usage(format!(
                    "--profile {}: expected a name that ends in .csv or .json",
                    path.display()
                )));
            }
        };
        let mut log = File::create(path)
            .map(|file| OpenLog {
                path: path.to_path_buf(),
                out: BufWriter::new(file),
                format,
                elapsed_micros: 0.0,
                rows: 0,
            })
            .map_err(|error| unwritable(path, &error))?;
        let head = match format {
            Format::Csv => "frame,kind,name,start_micros,micros\n",
            Format::Json => "[\n",
        };
        let written = log.out.write_all(head.as_bytes());
        written.map_err(|error| unwritable(path, &error))?;
        Ok(Self(Some(log)))
    }

    /// Adds a frame, as its profile has it.
    pub fn frame(&mut self, frame: u64, profile: &Profile) -> Result<(), Failure> {
        let Some(log) = &mut self.0 else {
            return Ok(());
        };
        let trace_start = profile
            .spans
            .iter()
            .find(|span| &*span.name == "trace_picture")
            .map_or(0.0, |span| span.start_micros);
        let systems = profile.spans.iter().map(|span| Row {
            kind: "system",
            name: &span.name,
            start_micros: span.start_micros,
            micros: span.micros,
        });
        // Passes say how long, not when: they are laid end to end from where tracing began.
        let passes = profile.passes.iter().scan(trace_start, |start, pass| {
            let row = Row {
                kind: "pass",
                name: pass.name,
                start_micros: *start,
                micros: pass.millis * 1e3,
            };
            *start += row.micros;
            Some(row)
        });
        for row in systems.chain(passes) {
            log.row(frame, &row)
                .map_err(|error| unwritable(&log.path, &error))?;
        }
        log.elapsed_micros += profile.frame_millis * 1e3;
        Ok(())
    }

    /// Writes the rest.
    pub fn finish(&mut self) -> Result<(), Failure> {
        let Some(mut log) = self.0.take() else {
            return Ok(());
        };
        let tail = match log.format {
            Format::Csv => "",
            Format::Json => "\n]\n",
        };
        log.out
            .write_all(tail.as_bytes())
            .and_then(|()| log.out.flush())
            .map_err(|error| unwritable(&log.path, &error))
    }
}

impl OpenLog {
    fn row(&mut self, frame: u64, row: &Row) -> io::Result<()> {
        let first = self.rows == 0;
        self.rows += 1;
        match self.format {
            Format::Csv => writeln!(
                self.out,
                "{frame},{},\"{}\",{:.3},{:.3}",
                row.kind, row.name, row.start_micros, row.micros
            ),
            Format::Json => {
                if !first {
                    self.out.write_all(b",\n")?;
                }
                let event = Event {
                    name: row.name,
                    cat: row.kind,
                    ph: "X",
                    ts: self.elapsed_micros + row.start_micros,
                    dur: row.micros,
                    pid: 1,
                    tid: u32::from(row.kind == "pass"),
                    args: FrameNumber { frame },
                };
                serde_json::to_writer(&mut self.out, &event).map_err(io::Error::from)
            }
        }
    }
}

fn unwritable(path: &Path, error: &io::Error) -> Failure {
    Failure::Input(format!(
        "{}: cannot write the profile: {error}",
        path.display()
    ))
}
