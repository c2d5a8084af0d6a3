//! The frames held, saved from the panel: a trace for Perfetto and a capture to compare.

use std::fs::{File, create_dir_all};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use crate::profile::Frames;
use crate::profile::export::{Format, FrameWriter};

/// Where they go.
const FOLDER: &str = "captures";

/// Saves them under the newest frame's number; says where, or why not.
pub fn captures(frames: &Frames, device: &str) -> String {
    let Some(newest) = frames.latest() else {
        return "No frame has been recorded yet".into();
    };
    let path = |ending| Path::new(FOLDER).join(format!("frames-{:06}.{ending}", newest.id));
    let files = [
        (path("json"), Format::Trace),
        (path("cap"), Format::Capture),
    ];
    for (path, format) in &files {
        if let Err(error) = save(frames, device, path, *format) {
            return format!("{}: cannot be written: {error}", path.display());
        }
    }
    let [(trace, _), (capture, _)] = &files;
    let (trace, capture) = (trace.display(), capture.display());
    format!("Saved {trace} (for Perfetto) and {capture} (to compare)")
}

fn save(frames: &Frames, device: &str, path: &PathBuf, format: Format) -> io::Result<()> {
    create_dir_all(FOLDER)?;
    let mut writer = FrameWriter::new(BufWriter::new(File::create(path)?), format, device)?;
    for frame in frames.iter() {
        writer.frame(frame)?;
    }
    writer.finish().map(drop)
}
