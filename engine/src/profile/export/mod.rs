//! Frames as files: a table of spans (CSV), a trace that Perfetto and chrome://tracing open (JSON), a capture to compare
//! with others ([`capture`]).
//!
//! Frames are written one by one as they are complete, so that a long run takes no memory.

pub mod capture;
mod chrome;

use std::io::{self, Write};
use std::path::Path;

use super::Frame;

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// A row a span or pass.
    Csv,
    /// The trace event format.
    Trace,
    /// See [`capture`].
    Capture,
}

impl Format {
    /// By the ending of a file's name: `csv`, `json` or `cap`.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()? {
            "csv" => Some(Self::Csv),
            "json" => Some(Self::Trace),
            "cap" => Some(Self::Capture),
            _ => None,
        }
    }
}

/// Writes frames in a format.
pub struct FrameWriter<W> {
    out: W,
    format: Format,
    /// Nothing but the head is written yet.
    is_empty: bool,
}

impl<W: Write> FrameWriter<W> {
    /// Writes the head; `device` says who traced.
    ///
    /// # Errors
    /// As the output has them.
    pub fn new(mut out: W, format: Format, device: &str) -> io::Result<Self> {
        match format {
            Format::Csv => out.write_all(b"frame,secs,kind,name,depth,start_micros,micros\n")?,
            Format::Trace => chrome::begin(&mut out, device)?,
            Format::Capture => capture::begin(&mut out, device)?,
        }
        Ok(Self {
            out,
            format,
            is_empty: true,
        })
    }

    /// Writes a frame.
    ///
    /// # Errors
    /// As the output has them.
    pub fn frame(&mut self, frame: &Frame) -> io::Result<()> {
        self.is_empty = false;
        match self.format {
            Format::Csv => csv_rows(&mut self.out, frame),
            Format::Trace => chrome::frame(&mut self.out, frame),
            Format::Capture => capture::frame(&mut self.out, frame),
        }
    }

    /// Writes what ends the file, and all that is still to be written.
    ///
    /// # Errors
    /// As the output has them.
    pub fn finish(mut self) -> io::Result<W> {
        if self.format == Format::Trace {
            chrome::end(&mut self.out)?;
        }
        self.out.flush()?;
        Ok(self.out)
    }
}

fn csv_rows(out: &mut impl Write, frame: &Frame) -> io::Result<()> {
    let Frame { id, secs, .. } = frame;
    for span in &frame.spans {
        let kind = if span.depth == 0 { "system" } else { "step" };
        let name = span.name.replace('"', "\"\"");
        let (depth, start, micros) = (span.depth, span.start_micros, span.micros);
        writeln!(
            out,
            "{id},{secs:.6},{kind},\"{name}\",{depth},{start:.3},{micros:.3}"
        )?;
    }
    for pass in &frame.passes {
        let (name, start, micros) = (&pass.name, pass.start_micros, pass.micros);
        writeln!(
            out,
            "{id},{secs:.6},pass,\"{name}\",0,{start:.3},{micros:.3}"
        )?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::frame::{nest, tests::span};
    use super::*;
    use crate::profile::Pass;

    /// Two frames as a run has them.
    pub fn frames() -> Vec<Frame> {
        let frame = |id: u64| {
            let mut spans = vec![
                span("first", 0.0, 100.0),
                span("spin<\"A\", B>", 100.0, 400.0),
                span("step", 150.0, 200.0),
            ];
            nest(&mut spans);
            Frame {
                id,
                secs: id as f64 / 32.0,
                start_micros: id as f64 * 1000.0,
                micros: 600.0,
                wait_micros: 25.0,
                interval_micros: 1000.0,
                spans,
                passes: vec![Pass {
                    name: "whitted".into(),
                    start_micros: 500.0,
                    micros: 300.0,
                    error_micros: 12.0,
                }],
                counters: crate::trace::Counters {
                    primary_rays: 64 * id,
                    ..Default::default()
                },
                awaits_device: false,
            }
        };
        vec![frame(7), frame(8)]
    }

    /// What a writer makes of frames.
    pub fn written(format: Format) -> String {
        let mut writer = FrameWriter::new(Vec::new(), format, "a \"device\"").unwrap();
        for frame in frames() {
            writer.frame(&frame).unwrap();
        }
        String::from_utf8(writer.finish().unwrap()).unwrap()
    }

    #[test]
    fn csv_has_a_row_a_span() {
        let text = written(Format::Csv);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 1 + 2 * 4, "{text}");
        assert_eq!(
            lines[2],
            "7,0.218750,system,\"spin<\"\"A\"\", B>\",0,100.000,400.000"
        );
        assert_eq!(lines[4], "7,0.218750,pass,\"whitted\",0,500.000,300.000");
    }

    #[test]
    fn the_ending_says_the_format() {
        let of = |name: &str| Format::of(Path::new(name));
        assert_eq!(of("a/b.json"), Some(Format::Trace));
        assert_eq!(of("b.cap"), Some(Format::Capture));
        assert_eq!((of("csv"), of("b.txt")), (None, None));
    }
}
