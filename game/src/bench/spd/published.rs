//! What the Readme of the Standard Procedural Databases (Haines, version 3.14) publishes: rays by kind of a tracer that
//! shoots 513 x 513 eye rays and follows five generations.
//!
//! Its rules are the engine's own: the eye's ray is of generation 1, every hit of a surface that reflects or transmits spawns its
//! rays unless it is of the last generation, and a shadow ray is shot unless the surface faces away from the light,
//! transmitting or not. It says that figures "can vary noticeably from a given ray tracer, but should all be within about 10%".

/// A scene, and its figures.
pub struct Published {
    /// Its name in the rows, and of the author's picture.
    pub name: &'static str,
    /// The size factor that the figures are of.
    pub size: u32,
    /// What becomes of small errors in it.
    pub kind: Kind,
    /// Eye rays that hit something, reflected, refracted, and shadow rays.
    pub rays: [u64; 4],
}

/// What a scene makes of small errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Nothing much.
    Plain,
    /// Long ways through glass add them up.
    Glass,
    /// Each bounce off a small ball or tube takes what a ray is off times its distance over the radius, a hundred and
    /// more, so that after a few of them nothing is left of the digits of f32: held to its first bounce.
    CurvedMirrors,
}

/// How the rows call the figures of [`Published::rays`].
pub const KINDS: [&str; 4] = ["eye_hits", "reflected", "refracted", "shadow"];
/// Eye rays they are of.
pub const EYE_RAYS: u64 = 513 * 513;
/// How far they may be off, percent.
pub const TOLERANCE: f64 = 10.0;
/// Generations followed.
pub const DEPTH: u32 = 5;

/// All scenes.
pub const SCENES: [Published; 7] = [
    scene(
        "balls",
        4,
        Kind::CurvedMirrors,
        [263_169, 175_095, 0, 954_368],
    ),
    scene(
        "gears",
        4,
        Kind::Glass,
        [245_086, 304_643, 207_564, 2_246_955],
    ),
    scene(
        "mount",
        6,
        Kind::Glass,
        [173_125, 354_769, 354_769, 412_922],
    ),
    scene(
        "rings",
        7,
        Kind::CurvedMirrors,
        [263_169, 315_236, 0, 1_085_002],
    ),
    scene("teapot", 12, Kind::Plain, [161_120, 225_248, 0, 407_656]),
    scene("tetra", 6, Kind::Plain, [49_788, 0, 0, 46_112]),
    scene("tree", 11, Kind::Plain, [169_836, 0, 0, 1_097_419]),
];

const fn scene(name: &'static str, size: u32, kind: Kind, rays: [u64; 4]) -> Published {
    Published {
        name,
        size,
        kind,
        rays,
    }
}

/// Percent that a count is off a published one; a count where there should be none is all off.
pub fn percent_off(count: f64, published: f64) -> f64 {
    if count == published {
        return 0.0;
    }
    (count - published).abs() / published.max(1.0) * 100.0
}
