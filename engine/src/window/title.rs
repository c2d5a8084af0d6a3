//! The window's title: "scene - 62 FPS - 16.1 of 20 ms - 1280x720 x0.79 - 17 samples - DEVICE".
//!
//! Frames a second as they come, milliseconds of work a frame without the wait for the display, and the time that is kept if one
//! is; the window, and how many of its pixels are traced along an axis; what a still picture has refined to.

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

/// What a title says besides its pace.
#[derive(Clone, Copy, Debug)]
pub struct Caption<'a> {
    /// What is shown.
    pub scene: &'a str,
    /// The window's pixels across and down.
    pub window: UVec2,
    /// Traced pixels for each of the window's, along an axis.
    pub scale: f64,
    /// The frame time that is kept, if one is.
    pub target_millis: Option<f64>,
    /// Samples of each pixel.
    pub samples: u32,
    /// Who traces.
    pub device: &'a str,
}

impl Caption<'_> {
    /// The title in words.
    pub fn words(&self, pace: Pace) -> String {
        let rounded = |number: f64| (number * 100.0).round() / 100.0;
        let target = self
            .target_millis
            .map_or_else(String::new, |target| format!(" of {}", rounded(target)));
        let scale = if self.scale == 1.0 {
            String::new()
        } else {
            format!(" x{}", rounded(self.scale))
        };
        let samples = if self.samples > 1 {
            format!(" - {} samples", self.samples)
        } else {
            String::new()
        };
        format!(
            "{} - {:.0} FPS - {:.1}{target} ms - {}x{}{scale}{samples} - {}",
            self.scene, pace.fps, pace.millis, self.window.x, self.window.y, self.device
        )
    }
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
        let slow = Caption {
            scene: "orrery",
            window: UVec2::new(1280, 720),
            scale: 0.7937,
            target_millis: Some(20.0),
            samples: 17,
            device: "llvmpipe",
        };
        assert_eq!(
            slow.words(pace),
            "orrery - 62 FPS - 16.1 of 20 ms - 1280x720 x0.79 - 17 samples - llvmpipe"
        );
        let fast = Caption {
            scale: 1.0,
            target_millis: None,
            samples: 1,
            device: "NVIDIA H200",
            ..slow
        };
        assert_eq!(
            fast.words(pace),
            "orrery - 62 FPS - 16.1 ms - 1280x720 - NVIDIA H200"
        );
    }
}
