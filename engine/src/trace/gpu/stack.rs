//! How large a traversal's stack is: as large as trees need, and for a while as large as they did.
//!
//! A kernel is compiled for the size, so that one for every tree that comes and goes would make frames wait; and one that is
//! too large is slower, since it is cleared before a ray. So it grows at once and shrinks when it has not been needed for long.

/// Frames after which what none of them needed is given up: some seconds of a window.
const PATIENCE: u32 = 300;

/// See the module.
#[derive(Clone, Copy, Debug, Default)]
pub struct StackNeed {
    need: u32,
    /// The most of the frames since it was last needed.
    lately: u32,
    frames: u32,
}

impl StackNeed {
    /// Takes note of what a frame needs; the need to go by.
    pub fn note(&mut self, need: u32) -> u32 {
        self.lately = self.lately.max(need);
        self.frames += 1;
        if need >= self.need || self.frames > PATIENCE {
            *self = Self {
                need: self.lately,
                ..Self::default()
            };
        }
        self.need
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_grows_at_once_and_shrinks_when_nobody_needs_it() {
        let mut stack = StackNeed::default();
        assert_eq!(stack.note(20), 20);
        assert_eq!(stack.note(70), 70);
        for frame in 0..3 * PATIENCE {
            // A tree that comes and goes.
            let need = if frame % 100 == 99 { 70 } else { 30 };
            assert_eq!(stack.note(need), 70, "frame {frame}");
        }
        let mut frames = 0;
        while stack.note(30 + frames % 2) > 31 {
            frames += 1;
        }
        assert!((PATIENCE - 2..=PATIENCE + 2).contains(&frames), "{frames}");
        assert_eq!(stack.note(40), 40);
    }
}
