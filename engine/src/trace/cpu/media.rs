//! What a ray is inside of, and the index ratios that follow, as POV-Ray 3.7 keeps them.
//!
//! Twin of `shaders/shared/media.wgsl`.

use glam::Vec3;

use crate::frame::wire::MEDIA_CAPACITY;
use crate::trace::PackedScene;

const CAPACITY: usize = MEDIA_CAPACITY as usize;

/// Beyond this, nothing is left of light.
const FAINTEST: f32 = 87.0;
/// Lengths beyond this are as this one.
const LONGEST: f32 = 1e18;

/// The media a ray is inside of, in order of entry. Fixed size; what does not fit is counted.
#[derive(Clone, Copy, Debug, Default)]
pub struct Media {
    entries: [(u32, f32); CAPACITY],
    len: usize,
}

/// A crossing of a boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Index here over index there.
    pub eta: f32,
    /// Whether the medium was in the list: the ray leaves it.
    pub leaving: bool,
}

impl Media {
    fn position(&self, id: u32) -> Option<usize> {
        self.entries[..self.len].iter().position(|e| e.0 == id)
    }

    /// The ratio met at the boundary of medium `id` of index `ior`. Leaving a medium that is not the
    /// innermost changes nothing; air has index 1.
    pub fn crossing(&self, id: u32, ior: f32) -> Crossing {
        let ior_at = |depth: usize| {
            self.len
                .checked_sub(depth)
                .map_or(1.0, |i| self.entries[i].1)
        };
        match self.position(id) {
            None => Crossing {
                eta: ior_at(1) / ior,
                leaving: false,
            },
            Some(place) if place + 1 == self.len => Crossing {
                eta: ior / ior_at(2),
                leaving: true,
            },
            Some(_) => Crossing {
                eta: 1.0,
                leaving: true,
            },
        }
    }

    /// What is left of light after a length within the innermost medium (Beer and Lambert).
    pub fn left_after(&self, scene: &PackedScene, length: f32) -> Vec3 {
        let Some(&(id, _)) = self.entries[..self.len].last() else {
            return Vec3::ONE;
        };
        let row = scene.instances()[id as usize].material;
        let absorption = Vec3::from(scene.materials[row as usize].absorption);
        let lost = (absorption * length.clamp(0.0, LONGEST)).min(Vec3::splat(FAINTEST));
        (-lost).exp()
    }

    /// The list on the other side; false: a medium did not fit and was left out.
    pub fn cross(&mut self, id: u32, ior: f32) -> bool {
        if let Some(place) = self.position(id) {
            self.entries.copy_within(place + 1..self.len, place);
            self.len -= 1;
        } else if self.len < CAPACITY {
            self.entries[self.len] = (id, ior);
            self.len += 1;
        } else {
            return false;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nested_shells_pass_their_indices_on() {
        let mut media = Media::default();
        assert_eq!(media.crossing(1, 1.5).eta, 1.0 / 1.5);
        assert!(media.cross(1, 1.5));
        assert_eq!(media.crossing(2, 1.25).eta, 1.5 / 1.25);
        assert!(media.cross(2, 1.25));
        // Leaving the outer shell while inside the inner one bends nothing.
        assert_eq!(
            media.crossing(1, 1.5),
            Crossing {
                eta: 1.0,
                leaving: true
            }
        );
        assert_eq!(media.crossing(2, 1.25).eta, 1.25 / 1.5);
        assert!(media.cross(2, 1.25) && media.cross(1, 1.5));
        assert_eq!(media.len, 0);
    }

    #[test]
    fn a_full_list_says_so_and_stays_as_it_was() {
        let mut media = Media::default();
        for id in 0..MEDIA_CAPACITY {
            assert!(media.cross(id, 1.5));
        }
        assert!(!media.cross(99, 1.5));
        assert_eq!(media.len, CAPACITY);
    }
}
