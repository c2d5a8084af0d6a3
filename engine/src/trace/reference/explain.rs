//! The whole ray tree of a pixel: each ray with what it met, its weight, what it added, and what it cost.
//!
//! Whitted's tree is finite and the same on every run, so a picture can be asked why. The walk is the reference's own, with a
//! recorder beside it; without one the recorder is `()`, whose notes are nothing and compile to nothing.

use glam::{DVec3, UVec2};

use super::world::{WorldHit, WorldRay};
use crate::trace::Counters;

/// Rays recorded at most: more than anyone reads; of those beyond, only their number is kept.
pub const MOST_RAYS: usize = 20_000;

/// Why a ray was sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RayKind {
    /// Through a sample of the pixel, by its number.
    Camera(u32),
    /// Off a surface.
    Mirrored,
    /// Into or out of a medium of another index.
    Refracted,
    /// On through a boundary of equal indices.
    Straight,
    /// To a light, by its row in the frame's.
    Shadow(u32),
}

/// What became of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fate {
    /// It is past the last generation: black, and not traced.
    NotFollowed,
    /// It met nothing: the background; of a shadow ray, all of the light passes.
    Missed,
    /// It met this, of a shadow ray the last one it met.
    Met {
        /// In lengths of its direction.
        t: f64,
        /// Row of `FrameScene::instances`.
        instance: u32,
        /// Primitive of the instance.
        prim: u32,
    },
}

/// One ray of the tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExplainedRay {
    /// Its place in [`Explanation::rays`]'s order; none: a camera ray.
    pub parent: Option<usize>,
    /// Rays above it.
    pub depth: usize,
    /// Why it was sent.
    pub kind: RayKind,
    /// In the world.
    pub origin: DVec3,
    /// Unit.
    pub dir: DVec3,
    /// What became of it.
    pub fate: Fate,
    /// What one unit of its light adds to the pixel; media it came through have taken their share.
    pub weight: DVec3,
    /// What it added to the pixel itself, without the rays below it: emission or background, or a light's part.
    pub added: DVec3,
    /// Boxes of the reference's trees it was held against.
    pub boxes: u32,
    /// Triangles and other shapes it was held against.
    pub shapes: u32,
}

impl ExplainedRay {
    /// Where it ended, in the world; of one that met nothing, `far` away.
    pub fn end(&self, far: f64) -> DVec3 {
        let length = match self.fate {
            Fate::Met { t, .. } => t,
            Fate::NotFollowed | Fate::Missed => far,
        };
        self.origin + self.dir * length
    }
}

/// A pixel, explained.
#[derive(Clone, Debug, PartialEq)]
pub struct Explanation {
    /// Column and row.
    pub pixel: UVec2,
    /// Of the picture.
    pub size: UVec2,
    /// Linear RGB: the sum of what its rays added.
    pub color: DVec3,
    /// Each after its parent, in the order in which they were traced.
    pub rays: Vec<ExplainedRay>,
    /// Rays beyond [`MOST_RAYS`].
    pub left_out: u64,
    /// Rays by kind.
    pub counters: Counters,
}

impl Explanation {
    /// What a ray and all below it added to the pixel.
    pub fn added_below(&self, ray: usize) -> DVec3 {
        let depth = self.rays[ray].depth;
        let below = self.rays[ray + 1..].iter();
        let below = below.take_while(|other| other.depth > depth);
        self.rays[ray].added + below.map(|other| other.added).sum::<DVec3>()
    }
}

/// Who is told what a walk does.
pub trait Recorder {
    /// Rays that are under way.
    fn depth(&self) -> usize {
        0
    }
    /// A ray is sent: a unit of its light is `share` of its parent's.
    fn enter(&mut self, _kind: RayKind, _ray: &WorldRay, _share: DVec3) {}
    /// It met something, or nothing; media on its way left so much of its light.
    fn meet(&mut self, _hit: Option<&WorldHit>, _left: DVec3) {}
    /// It brings light, in its own units.
    fn add(&mut self, _light: DVec3) {}
    /// It was held against a box.
    fn test_box(&mut self) {}
    /// It was held against a shape.
    fn test_shape(&mut self) {}
    /// All rays below this depth are done.
    fn back_to(&mut self, _depth: usize) {}
}

/// Nobody.
impl Recorder for () {}

/// Writes the tree down.
pub struct TreeRecorder {
    eye: DVec3,
    rays: Vec<ExplainedRay>,
    /// Rays under way; none: one that is left out.
    open: Vec<Option<usize>>,
    left_out: u64,
}

impl TreeRecorder {
    /// Of rays relative to this eye.
    pub fn new(eye: DVec3) -> Self {
        Self {
            eye,
            rays: Vec::new(),
            open: Vec::new(),
            left_out: 0,
        }
    }

    /// What was written down.
    pub fn explanation(
        self,
        pixel: UVec2,
        size: UVec2,
        color: DVec3,
        counters: Counters,
    ) -> Explanation {
        Explanation {
            pixel,
            size,
            color,
            rays: self.rays,
            left_out: self.left_out,
            counters,
        }
    }

    fn current(&mut self) -> Option<&mut ExplainedRay> {
        let at = self.open.last().copied().flatten()?;
        self.rays.get_mut(at)
    }
}

impl Recorder for TreeRecorder {
    fn depth(&self) -> usize {
        self.open.len()
    }

    fn enter(&mut self, kind: RayKind, ray: &WorldRay, share: DVec3) {
        if self.rays.len() >= MOST_RAYS {
            self.left_out += 1;
            self.open.push(None);
            return;
        }
        let parent = self.open.last().copied().flatten();
        let weight = parent.map_or(DVec3::ONE, |parent| self.rays[parent].weight);
        self.rays.push(ExplainedRay {
            parent,
            depth: self.open.len(),
            kind,
            origin: ray.origin + self.eye,
            dir: ray.dir,
            fate: Fate::NotFollowed,
            weight: weight * share,
            added: DVec3::ZERO,
            boxes: 0,
            shapes: 0,
        });
        self.open.push(Some(self.rays.len() - 1));
    }

    fn meet(&mut self, hit: Option<&WorldHit>, left: DVec3) {
        if let Some(ray) = self.current() {
            ray.weight *= left;
            ray.fate = hit.map_or(Fate::Missed, |hit| Fate::Met {
                t: hit.key.0,
                instance: hit.key.1,
                prim: hit.key.2,
            });
        }
    }

    fn add(&mut self, light: DVec3) {
        if let Some(ray) = self.current() {
            ray.added += ray.weight * light;
        }
    }

    fn test_box(&mut self) {
        if let Some(ray) = self.current() {
            ray.boxes += 1;
        }
    }

    fn test_shape(&mut self) {
        if let Some(ray) = self.current() {
            ray.shapes += 1;
        }
    }

    fn back_to(&mut self, depth: usize) {
        self.open.truncate(depth);
    }
}
