//! [`Kernels`]: which numerical kernels trace. The defaults are the robust ones; the textbook forms are there
//! to be measured against, by benchmarks and tests, and nothing else chooses them.
//!
//! Both f32 tracers honour them, for pictures and for rays; the f64 reference has its own arithmetic. A
//! device compiles what it is asked for, so a form that is not asked for costs nothing there.

/// How rays are tested against triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TriangleTest {
    /// Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection" (JCGT 2:1, 2013): triangles that share
    /// an edge decide it by the same bits.
    #[default]
    Watertight,
    /// Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection" (Journal of Graphics Tools 2:1,
    /// 1997): each triangle rounds its edges by itself, so rays slip through between two.
    MollerTrumbore,
}

/// How rays are tested against the boxes of trees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum BoxTest {
    /// Boxes grown outward, reciprocals that stay finite, the far side widened (after Ize, "Robust BVH Ray
    /// Traversal", JCGT 2:2, 2013).
    #[default]
    Padded,
    /// The slab test of Kay and Kajiya ("Ray Tracing Complex Scenes", SIGGRAPH 1986) as it is written down:
    /// plain reciprocals, nothing widened, and what boxes were grown by is taken off them again (which costs
    /// it a few instructions; its answers are what it is compared by).
    Bare,
}

/// How rays that leave a surface are kept off it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Offset {
    /// By a bound on the hit point's rounding error (Pharr, Jakob and Humphreys, "Physically Based Rendering",
    /// 4th edition, 6.8), and the primitive they start on is left out.
    #[default]
    Bounded,
    /// By [`FIXED_OFFSET`] along the normal, whatever the scene's size; nothing is left out.
    Fixed,
}

/// The length of [`Offset::Fixed`], in units of the world: what tutorials use.
pub const FIXED_OFFSET: f32 = 1e-4;

/// The kernels of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Kernels {
    /// Triangles.
    pub triangles: TriangleTest,
    /// Boxes of trees.
    pub boxes: BoxTest,
    /// Rays that leave a surface.
    pub offsets: Offset,
}

impl Kernels {
    /// Every choice, the robust one first.
    pub fn all() -> impl Iterator<Item = Self> {
        let triangles = [TriangleTest::Watertight, TriangleTest::MollerTrumbore];
        let boxes = [BoxTest::Padded, BoxTest::Bare];
        let offsets = [Offset::Bounded, Offset::Fixed];
        (0..8).map(move |i: usize| Self {
            triangles: triangles[i & 1],
            boxes: boxes[i >> 1 & 1],
            offsets: offsets[i >> 2],
        })
    }
}
