//! [`Skips`]: what is left out of a frame's work because no picture shows it, each by its name.
//!
//! Every one has a switch here, a count of what it saved (`trace::Counters::saved`) and a test that the picture is the same
//! without it. All are on; benchmarks and tests, and those who want to know, turn them off. Both f32 tracers honour those that
//! mean anything to them; the f64 reference leaves nothing out.
//!
//! Not here: systems and extraction follow change ticks, which tests hold to worlds made anew, and hidden things are in no tree
//! because they are not to be seen.

use std::fmt;
use std::str::FromStr;

/// Something that is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Skip {
    /// Kernels have what the scene needs.
    Kernels,
    /// No shadow ray to a light that the surface faces away from.
    Away,
    /// No shadow ray where nothing could come back.
    Black,
    /// No shadow ray for a share of light within the cut-off.
    FaintLights,
    /// No reflected or refracted ray within the cut-off.
    FaintRays,
    /// No reflected or refracted ray of weight 0.
    Weightless,
    /// No ray where nothing changed.
    Still,
    /// No tree of what did not change, and no new one of what moved.
    Trees,
    /// Nothing brought to a device that it has.
    Uploads,
}

impl Skip {
    /// Every one, in the order of a frame's rays and then of frames.
    pub const ALL: [Self; 9] = [
        Self::Kernels,
        Self::Away,
        Self::Black,
        Self::FaintLights,
        Self::FaintRays,
        Self::Weightless,
        Self::Still,
        Self::Trees,
        Self::Uploads,
    ];

    /// As the command line has it.
    pub fn name(self) -> &'static str {
        self.words().0
    }

    /// A sentence, without a capital and a full stop.
    pub fn about(self) -> &'static str {
        self.words().1
    }

    /// What is counted, in words of a panel.
    pub fn saved(self) -> &'static str {
        self.words().2
    }

    fn words(self) -> (&'static str, &'static str, &'static str) {
        match self {
            Self::Kernels => (
                "kernels",
                "a GPU compiles, binds and traces what the scene needs, not every feature",
                "features left out of kernels",
            ),
            Self::Away => (
                "away",
                "no shadow ray to a light that the surface faces away from",
                "shadow rays saved: facing away",
            ),
            Self::Black => (
                "black",
                "no shadow ray where nothing could come back: the surface is black to the light, or beyond its cone or range",
                "shadow rays saved: black to it",
            ),
            Self::FaintLights => (
                "faint-lights",
                "no shadow ray for light within `--cutoff`, whose bound is of all that a pixel leaves out, however many lights",
                "shadow rays saved: too faint",
            ),
            Self::FaintRays => (
                "faint-rays",
                "no reflected or refracted ray that brings back no more than `--cutoff` leaves out of a pixel",
                "rays too faint to follow",
            ),
            Self::Weightless => (
                "weightless",
                "no reflected or refracted ray of which the pixel takes nothing",
                "rays of no weight",
            ),
            Self::Still => (
                "still",
                "a frame in which nothing changed traces no ray once the picture has its samples",
                "samples kept from before",
            ),
            Self::Trees => (
                "trees",
                "what did not change keeps its rows and trees, and trees of what moved are refitted; without, all are made anew in every frame",
                "trees kept",
            ),
            Self::Uploads => (
                "uploads",
                "a GPU is brought, deforms and refits what changed alone",
                "bytes kept on the device",
            ),
        }
    }

    fn bit(self) -> u16 {
        1 << self as u16
    }
}

impl fmt::Display for Skip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Skip {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|skip| skip.name() == text);
        found.ok_or_else(|| format!("expected one of {}", Self::ALL.map(Self::name).join(", ")))
    }
}

/// Which of them are on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Skips(u16);

impl Skips {
    /// Everything is left out that may be.
    pub const ALL: Self = Self(u16::MAX);
    /// Nothing is.
    pub const NONE: Self = Self(0);

    /// Whether it is on.
    #[inline]
    pub fn has(self, skip: Skip) -> bool {
        self.0 & skip.bit() != 0
    }

    /// The same with this one off.
    #[must_use]
    pub fn without(self, skip: Skip) -> Self {
        Self(self.0 & !skip.bit())
    }

    /// The same with this one on.
    #[must_use]
    pub fn with(self, skip: Skip) -> Self {
        Self(self.0 | skip.bit())
    }
}

impl Default for Skips {
    fn default() -> Self {
        Self::ALL
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_has_a_name_and_a_bit_of_its_own() {
        for skip in Skip::ALL {
            assert_eq!(skip.name().parse(), Ok(skip));
            let others = Skips::ALL.without(skip);
            for other in Skip::ALL {
                assert_eq!(others.has(other), other != skip);
                assert!(!Skips::NONE.has(other));
            }
        }
        assert!("everything".parse::<Skip>().is_err());
    }
}
