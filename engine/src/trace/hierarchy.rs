//! Volumes of a tree's level, for looking at: what a tracer hands out and what a display says of it.
//!
//! The 2008 report showed the levels of its sphere trees in the picture; here every structure shows its own.

use std::fmt;
use std::str::FromStr;

use glam::Vec3;

/// Which volumes of the trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// So many steps below the root, from 1 to [`Level::DEEPEST`]; the root's children are level 1.
    Depth(u32),
    /// Those that hold primitives, at whatever depth.
    Leaves,
}

impl Level {
    /// The deepest level that can be asked for by number.
    pub const DEEPEST: u32 = 9;

    /// The level that a digit asks for: 0 is the leaves.
    pub fn of_digit(digit: u32) -> Option<Self> {
        match digit {
            0 => Some(Self::Leaves),
            depth if depth <= Self::DEEPEST => Some(Self::Depth(depth)),
            _ => None,
        }
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Depth(depth) => write!(f, "level {depth}"),
            Self::Leaves => f.write_str("leaves"),
        }
    }
}

impl FromStr for Level {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let depth = u32::from_str(text)
            .ok()
            .filter(|depth| (1..=Self::DEEPEST).contains(depth));
        match (text, depth) {
            ("leaves", _) => Ok(Self::Leaves),
            (_, Some(depth)) => Ok(Self::Depth(depth)),
            _ => Err(format!(
                "expected a level from 1 to {}, or leaves",
                Self::DEEPEST
            )),
        }
    }
}

/// What a volume looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// The eight corners are centre ± axes.
    Box,
    /// The image of the unit sphere: centre + axes times its points.
    Sphere,
}

/// Whose tree a volume is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Owner {
    /// The tree over all instances.
    Instances,
    /// The tree of a mesh, in place as this row of `FrameScene::instances`.
    Mesh(u32),
}

/// A bounding volume in the world, relative to the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// Its middle.
    pub center: Vec3,
    /// Half its extent along each side.
    pub axes: [Vec3; 3],
    /// What it looks like.
    pub form: Form,
    /// Whose it is.
    pub owner: Owner,
}

impl Volume {
    /// No point of it is farther from its centre.
    pub fn radius(&self) -> f32 {
        match self.form {
            Form::Box => self.axes.iter().map(|axis| axis.length()).sum(),
            Form::Sphere => {
                let squares = self.axes.iter().map(|axis| axis.length_squared());
                squares.sum::<f32>().sqrt()
            }
        }
    }
}

/// A level of the trees in the picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hierarchy {
    /// Those in view, the largest as seen if they are too many.
    pub volumes: Vec<Volume>,
    /// Boxes of the level, in view or not.
    pub boxes: usize,
    /// Spheres of the level, in view or not.
    pub spheres: usize,
    /// More are in view than could be handed out.
    pub is_cut: bool,
    /// What of the level is not there, as a sentence's end.
    pub lacks: Option<&'static str>,
}

impl Hierarchy {
    /// What is shown: "level 3: 212 boxes".
    pub fn words(&self, level: Level) -> String {
        let count = |count: usize, one: &str, many: &str| match count {
            0 => None,
            1 => Some(format!("1 {one}")),
            n => Some(format!("{n} {many}")),
        };
        let counts = [
            count(self.boxes, "box", "boxes"),
            count(self.spheres, "sphere", "spheres"),
        ];
        let counts: Vec<String> = counts.into_iter().flatten().collect();
        let mut words = if counts.is_empty() {
            format!("{level}: nothing")
        } else {
            format!("{level}: {}", counts.join(", "))
        };
        if self.is_cut {
            words += &format!(", the {} largest in view", self.volumes.len());
        }
        if let Some(lacks) = self.lacks {
            words += &format!("; {lacks}");
        }
        words
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_read_as_they_are_asked_for() {
        assert_eq!("3".parse(), Ok(Level::Depth(3)));
        assert_eq!("leaves".parse(), Ok(Level::Leaves));
        for wrong in ["0", "10", "-1", "leaf", ""] {
            assert!(wrong.parse::<Level>().is_err(), "{wrong}");
        }
        assert_eq!(Level::of_digit(0), Some(Level::Leaves));
        assert_eq!(Level::of_digit(9), Some(Level::Depth(9)));
        assert_eq!(Level::of_digit(10), None);
    }

    #[test]
    fn words_count_what_is_shown() {
        let mut shown = Hierarchy {
            boxes: 212,
            ..Hierarchy::default()
        };
        assert_eq!(shown.words(Level::Depth(3)), "level 3: 212 boxes");
        shown.spheres = 1;
        shown.is_cut = true;
        assert_eq!(
            shown.words(Level::Leaves),
            "leaves: 212 boxes, 1 sphere, the 0 largest in view"
        );
        assert_eq!(
            Hierarchy::default().words(Level::Depth(9)),
            "level 9: nothing"
        );
    }
}
