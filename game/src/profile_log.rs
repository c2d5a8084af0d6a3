//! `--profile FILE`: when every system and pass of every frame ran, and for how long, or with `--capture-on-spike` of the
//! frames that led to a slow one.
//!
//! A GPU tells of a frame later: a frame is written when that has come, or when it is too late for it.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use orrery_engine::Engine;
use orrery_engine::profile::export::{Format, FrameWriter};
use orrery_engine::profile::{Frame, Frames, Stop, blame};
use orrery_engine::trace::ActiveTracer;

use crate::args::Common;
use crate::failure::Failure;
use crate::output::note;

/// Frames that may be ahead of one whose device has not told yet.
const PATIENCE: usize = 8;

/// An open file of frames, or none.
pub struct ProfileLog(Option<OpenLog>);

struct OpenLog {
    path: PathBuf,
    file: Option<File>,
    format: Format,
    /// None before the first frame: only then is it known who traces.
    out: Option<FrameWriter<BufWriter<File>>>,
    /// Not written yet, oldest first.
    pending: VecDeque<Frame>,
    /// Only the frames that led to one that worked longer than so many milliseconds.
    spike_limit: Option<f64>,
    /// Frames since the spike, whose device may not have told yet.
    since: usize,
    is_done: bool,
}

impl ProfileLog {
    /// Opens the file that was asked for, if one was.
    pub fn open(common: &Common) -> Result<Self, Failure> {
        let Some(path) = common.profile.as_deref() else {
            return match common.capture_on_spike {
                None => Ok(Self(None)),
                Some(_) => Err(Failure::Usage(
                    "--capture-on-spike needs a file for what it captures: --profile FILE".into(),
                )),
            };
        };
        let format = Format::of(path).ok_or_else(|| {
            Failure::Usage(format!(
                "--profile {}: expected a name that ends in .csv, .json (for Perfetto) or .cap (for `orrery compare`)",
                path.display()
            ))
        })?;
        let file = File::create(path).map_err(|error| unwritable(path, &error))?;
        Ok(Self(Some(OpenLog {
            path: path.to_path_buf(),
            file: Some(file),
            format,
            out: None,
            pending: VecDeque::new(),
            spike_limit: common.capture_on_spike,
            since: 0,
            is_done: false,
        })))
    }

    /// Has frames watched for a spike if that was asked for; before the first.
    pub fn watch(&self, engine: &mut Engine) {
        if let Some(log) = &self.0 {
            let mut frames = engine.world.resource_mut::<Frames>();
            frames.set_spike_limit(log.spike_limit);
        }
    }

    /// Takes in the frame that has just ended.
    pub fn frame(&mut self, engine: &Engine) -> Result<(), Failure> {
        let Some(log) = &mut self.0 else {
            return Ok(());
        };
        let frames = engine.world.resource::<Frames>();
        let tracer = &engine.world.resource::<ActiveTracer>().0;
        let device = || tracer.as_ref().map_or_else(String::new, |t| t.device());
        let written = match log.spike_limit {
            None => log.take_in(frames, device),
            Some(limit) => log.look_for_spike(frames, limit, device),
        };
        written.map_err(|error| unwritable(&log.path, &error))
    }

    /// Writes the rest.
    pub fn finish(&mut self) -> Result<(), Failure> {
        let Some(mut log) = self.0.take() else {
            return Ok(());
        };
        if let Some(limit) = log.spike_limit.filter(|_| !log.is_done) {
            note(format_args!(
                "no frame worked longer than {limit} ms: {} has none",
                log.path.display()
            ));
        }
        log.write(0, String::new)
            .and_then(|()| log.out.take().map_or(Ok(()), |out| out.finish().map(drop)))
            .map_err(|error| unwritable(&log.path, &error))
    }
}

impl OpenLog {
    fn take_in(&mut self, frames: &Frames, device: impl FnOnce() -> String) -> io::Result<()> {
        for pending in &mut self.pending {
            if let Some(frame) = frames.get(pending.id) {
                pending.clone_from(frame);
            }
        }
        let last = self.pending.back().map(|frame| frame.id);
        let newest = frames.latest();
        self.pending
            .extend(newest.filter(|f| Some(f.id) != last).cloned());
        self.write(PATIENCE, device)
    }

    /// Writes what is complete, and of the rest all but the last few.
    fn write(&mut self, wait_for: usize, device: impl FnOnce() -> String) -> io::Result<()> {
        let out = match (&mut self.out, self.file.take()) {
            (Some(out), _) => out,
            (None, Some(file)) => {
                let out = FrameWriter::new(BufWriter::new(file), self.format, &device())?;
                self.out.insert(out)
            }
            (None, None) => return Ok(()),
        };
        while let Some(frame) = self.pending.front() {
            // The next one's start says how long it was to there.
            let is_complete = !frame.awaits_device && self.pending.len() > 1;
            if self.pending.len() <= wait_for && !is_complete {
                break;
            }
            out.frame(frame)?;
            self.pending.pop_front();
        }
        Ok(())
    }

    fn look_for_spike(
        &mut self,
        frames: &Frames,
        limit: f64,
        device: impl FnOnce() -> String,
    ) -> io::Result<()> {
        let Some(Stop::Spike(id)) = frames.stopped().filter(|_| !self.is_done) else {
            return Ok(());
        };
        self.since += 1;
        let awaits = frames.get(id).is_some_and(|frame| frame.awaits_device);
        if awaits && self.since < PATIENCE {
            return Ok(());
        }
        self.is_done = true;
        self.pending = frames.iter().cloned().collect();
        if let Some(frame) = frames.get(id) {
            let culprit = blame(frame, frames.iter()).map_or_else(String::new, |blame| {
                format!(
                    ", most of it beyond what is usual in `{}`: {:.1} ms, usually {:.1}",
                    blame.name,
                    blame.micros * 1e-3,
                    blame.usual_micros * 1e-3
                )
            });
            note(format_args!(
                "frame {id} worked {:.1} ms, more than {limit}{culprit}; it and the {} before it: {}",
                frame.work_micros() * 1e-3,
                self.pending.len().saturating_sub(1),
                self.path.display()
            ));
        }
        self.write(0, device)
    }
}

fn unwritable(path: &Path, error: &io::Error) -> Failure {
    Failure::Input(format!(
        "{}: cannot write the profile: {error}",
        path.display()
    ))
}
