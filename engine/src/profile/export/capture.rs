//! A capture: a line of JSON that says what it is, then a line a frame with all that is known of it.
//!
//! Read back by comparisons, from files that anyone may have written: whatever is in them, the answer is a capture or a
//! sentence with the line.

use std::collections::BTreeMap;
use std::fmt;
use std::io::{self, BufRead, Read, Write};

use serde::{Deserialize, Serialize};

use crate::profile::Frame;

/// The version written, and the only one read.
const VERSION: u32 = 1;
/// Bytes a line may have: a frame of a hundred thousand spans.
const LONGEST_LINE: u64 = 16 << 20;
/// Frames a capture may have: several hours.
const MOST_FRAMES: usize = 1_000_000;

/// The first line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Head {
    orrery_capture: u32,
    device: String,
}

/// A span: name, start and length in microseconds, depth.
pub type SpanRecord = (String, f64, f64, u16);
/// A pass: name, start, length, and how much later it may have been, in microseconds.
pub type PassRecord = (String, f64, f64, f64);

/// A frame, with its times as [`Frame`] has them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameRecord {
    /// Its number.
    pub id: u64,
    /// Seconds of scene time.
    pub secs: f64,
    /// When it began, microseconds.
    pub start: f64,
    /// To its report.
    pub micros: f64,
    /// Of that, the wait for the display.
    pub wait: f64,
    /// To the next frame's start; 0: not known.
    pub interval: f64,
    /// Systems and steps.
    pub spans: Vec<SpanRecord>,
    /// What the device did.
    pub passes: Vec<PassRecord>,
    /// Counts by name.
    pub counters: BTreeMap<String, u64>,
}

impl From<&Frame> for FrameRecord {
    fn from(frame: &Frame) -> Self {
        let spans = frame.spans.iter();
        let spans = spans.map(|s| (s.name.to_string(), s.start_micros, s.micros, s.depth));
        let passes = frame.passes.iter();
        let passes = passes.map(|p| (p.name.to_string(), p.start_micros, p.micros, p.error_micros));
        let counters = frame.counters.named();
        Self {
            id: frame.id,
            secs: frame.secs,
            start: frame.start_micros,
            micros: frame.micros,
            wait: frame.wait_micros,
            interval: frame.interval_micros,
            spans: spans.collect(),
            passes: passes.collect(),
            counters: counters.map(|(name, n)| (name.to_owned(), n)).into(),
        }
    }
}

impl FrameRecord {
    /// As [`Frame::work_micros`].
    pub fn work_micros(&self) -> f64 {
        let device: f64 = self.passes.iter().map(|pass| pass.2).sum();
        (self.micros - self.wait).max(device)
    }

    /// What is not a time at all.
    fn nonsense(&self) -> Option<String> {
        let spans = self.spans.iter().map(|s| (&s.0, s.1, s.2));
        let passes = self.passes.iter().map(|p| (&p.0, p.1, p.2));
        for (name, start, length) in spans.chain(passes) {
            if !start.is_finite() || !(0.0..=1e15).contains(&length) {
                return Some(format!(
                    "`{name}` is said to have taken {length} microseconds"
                ));
            }
        }
        let times = [self.micros, self.wait, self.interval];
        let wrong = times.iter().find(|time| !(0.0..=1e15).contains(*time))?;
        Some(format!(
            "frame {} has a time of {wrong} microseconds",
            self.id
        ))
    }
}

/// What was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Capture {
    /// Who traced.
    pub device: String,
    /// In the order of the file.
    pub frames: Vec<FrameRecord>,
}

/// Why a file is no capture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CaptureError {
    /// Counted from 1.
    pub line: usize,
    /// What is wrong there, and what was expected.
    pub why: String,
}

impl fmt::Display for CaptureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.line, self.why)
    }
}

impl std::error::Error for CaptureError {}

pub(super) fn begin(out: &mut impl Write, device: &str) -> io::Result<()> {
    let head = Head {
        orrery_capture: VERSION,
        device: device.to_owned(),
    };
    line(out, &head)
}

pub(super) fn frame(out: &mut impl Write, frame: &Frame) -> io::Result<()> {
    line(out, &FrameRecord::from(frame))
}

fn line(out: &mut impl Write, what: &impl Serialize) -> io::Result<()> {
    serde_json::to_writer(&mut *out, what)?;
    out.write_all(b"\n")
}

/// Reads a capture to its end. A last line that was cut off, as a program that was killed leaves it, is left out.
///
/// # Errors
/// See [`CaptureError`].
pub fn read(mut input: impl BufRead) -> Result<Capture, CaptureError> {
    let wrong = |line: usize, why: String| CaptureError { line, why };
    let mut text = Vec::new();
    let head: Head = match next_line(&mut input, &mut text) {
        Ok(Some(_)) => serde_json::from_slice(&text).map_err(|_| {
            let why = "this is no capture: expected a file that `--profile NAME.cap` wrote, which begins with {\"orrery_capture\":1";
            wrong(1, why.into())
        })?,
        Ok(None) => return Err(wrong(1, "the file is empty; `--profile NAME.cap` writes captures".into())),
        Err(why) => return Err(wrong(1, why)),
    };
    if head.orrery_capture != VERSION {
        let found = head.orrery_capture;
        let why = format!(
            "the capture is of version {found}, this program reads version {VERSION}: capture anew"
        );
        return Err(wrong(1, why));
    }
    let mut frames: Vec<FrameRecord> = Vec::new();
    for number in 2.. {
        let is_whole = match next_line(&mut input, &mut text) {
            Ok(None) => break,
            Ok(Some(is_whole)) => is_whole,
            Err(why) => return Err(wrong(number, why)),
        };
        if text.is_empty() {
            continue;
        }
        if frames.len() == MOST_FRAMES {
            return Err(wrong(number, format!("more than {MOST_FRAMES} frames")));
        }
        match serde_json::from_slice::<FrameRecord>(&text) {
            Ok(frame) => match frame.nonsense() {
                None => frames.push(frame),
                Some(why) => return Err(wrong(number, why)),
            },
            Err(_) if !is_whole => break,
            Err(error) => {
                return Err(wrong(
                    number,
                    format!("this is no frame of a capture: {error}"),
                ));
            }
        }
    }
    if frames.is_empty() {
        return Err(wrong(2, "the capture has no frame".into()));
    }
    Ok(Capture {
        device: head.device,
        frames,
    })
}

/// The next line without its end, and whether that was there; none at the end of the file.
fn next_line(input: &mut impl BufRead, text: &mut Vec<u8>) -> Result<Option<bool>, String> {
    text.clear();
    let read = input.take(LONGEST_LINE).read_until(b'\n', text);
    let count = read.map_err(|error| format!("cannot be read: {error}"))?;
    if count == 0 {
        return Ok(None);
    }
    let is_whole = text.last() == Some(&b'\n');
    if is_whole {
        text.pop();
    } else if count as u64 == LONGEST_LINE {
        return Err("the line is too long for a frame".into());
    }
    Ok(Some(is_whole))
}

#[cfg(test)]
mod tests {
    use super::super::{Format, tests};
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let text = tests::written(Format::Capture);
        let capture = read(text.as_bytes()).expect("a capture");
        assert_eq!(capture.device, "a \"device\"");
        let records: Vec<FrameRecord> = tests::frames().iter().map(FrameRecord::from).collect();
        assert_eq!(capture.frames, records);
        assert_eq!(capture.frames[1].counters["camera rays"], 512);
        assert_eq!(capture.frames[0].work_micros(), 575.0);
    }

    #[test]
    fn a_capture_that_was_cut_off_is_read_up_to_there() {
        let text = tests::written(Format::Capture);
        let cut = &text[..text.len() - 20];
        assert_eq!(
            read(cut.as_bytes()).map(|capture| capture.frames.len()),
            Ok(1)
        );
    }

    #[test]
    fn other_files_are_refused_with_the_line() {
        let whole = tests::written(Format::Capture);
        let head = whole.lines().next().unwrap();
        let error = |text: &str| read(text.as_bytes()).expect_err("no capture").to_string();
        assert!(error("").contains("empty"));
        assert!(error("[\n{}\n]").contains("line 1: this is no capture"));
        assert!(error(&head.replace(":1", ":2")).contains("version 2"));
        assert!(error(head).contains("no frame"));
        assert!(error(&format!("{head}\n{{\"id\":3}}\n")).contains("line 2: this is no frame"));
        let negative = whole.replace("400.0", "-400.0");
        assert!(
            error(&negative).contains("line 2: `spin"),
            "{}",
            error(&negative)
        );
        let huge = whole.replace("600.0", "1e999");
        assert!(error(&huge).contains("line 2"), "{}", error(&huge));
        let deep = format!("{head}\n{}\n", "[".repeat(200_000));
        assert!(error(&deep).contains("line 2"));
    }

    #[test]
    fn no_change_of_bytes_makes_it_panic() {
        let whole = tests::written(Format::Capture).into_bytes();
        let mut random = 1_u64;
        let mut next = |most: usize| {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (random >> 33) as usize % most
        };
        for _ in 0..3000 {
            let mut bytes = whole.clone();
            for _ in 0..1 + next(4) {
                let at = next(bytes.len());
                match next(3) {
                    0 => bytes[at] = next(256) as u8,
                    1 => bytes.truncate(at.max(1)),
                    _ => bytes.insert(at, next(256) as u8),
                }
            }
            // Either is fine; a panic is not.
            let _ = read(bytes.as_slice());
        }
    }
}
