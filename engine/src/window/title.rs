//! The window's title: "scene - 62 FPS - 16.1 ms - 1280x720 x0.75 - 17 samples - DEVICE".

use std::time::{Duration, Instant};

use glam::UVec2;

/// How often the title changes: often enough to be true, seldom enough to be read.
const EVERY: Duration = Duration::from_millis(500);

/// Counts frames between two titles.
#[derive(Debug)]
pub struct Title {
    since: Instant,
    frames: u32,
    work_millis: f64,
}

impl Title {
    /// Starts counting.
    pub fn new() -> Self {
        Self {
            since: Instant::now(),
            frames: 0,
            work_millis: 0.0,
        }
    }

    /// A frame was run; the title, if it is time for a new one.
    pub fn frame(
        &mut self,
        work_millis: f64,
        words: impl FnOnce(Pace) -> String,
    ) -> Option<String> {
        self.frames += 1;
        self.work_millis += work_millis;
        let elapsed = self.since.elapsed();
        if elapsed < EVERY {
            return None;
        }
        let pace = Pace {
            fps: f64::from(self.frames) / elapsed.as_secs_f64(),
            millis: self.work_millis / f64::from(self.frames),
        };
        *self = Self::new();
        Some(words(pace))
    }
}

/// Mean over the time since the last title.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Frames a second.
    pub fps: f64,
    /// Milliseconds of work a frame.
    pub millis: f64,
}

/// The title in words.
pub fn words(
    scene: &str,
    pace: Pace,
    window: UVec2,
    scale: f64,
    samples: u32,
    device: &str,
) -> String {
    let scale = if scale == 1.0 {
        String::new()
    } else {
        format!(" x{}", (scale * 100.0).round() / 100.0)
    };
    let samples = if samples > 1 {
        format!(" - {samples} samples")
    } else {
        String::new()
    };
    format!(
        "{scene} - {:.0} FPS - {:.1} ms - {}x{}{scale}{samples} - {device}",
        pace.fps, pace.millis, window.x, window.y
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_title_reads_as_documented() {
        let pace = Pace {
            fps: 61.8,
            millis: 16.13,
        };
        let size = UVec2::new(1280, 720);
        assert_eq!(
            words("orrery", pace, size, 0.75, 17, "NVIDIA H200"),
            "orrery - 62 FPS - 16.1 ms - 1280x720 x0.75 - 17 samples - NVIDIA H200"
        );
        assert_eq!(
            words("orrery", pace, size, 1.0, 1, "cpu"),
            "orrery - 62 FPS - 16.1 ms - 1280x720 - cpu"
        );
    }
}
