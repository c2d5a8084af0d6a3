//! The scene file as data: its names, its defaults, its ranges.
//!
//! The schema is its own: names here are those of the file and stay when a Rust field is renamed. Values
//! land in the world's own component types where they fit, so a default is said once.

mod angle;
mod background;
mod camera;
mod clip;
mod deform;
mod entity;
mod light;
mod material;
mod motion;
mod pose;
mod primitive;
mod shape;
mod structure;
mod texture;
mod timeline;

pub use angle::{Angle, from_degrees, to_degrees};
pub use background::BackgroundFile;
pub use clip::ClipFile;
pub use deform::{Deform, KeysFile, MorphFile};
pub use entity::{Entity, Scene, VERSION};
pub use light::Light;
pub use material::MaterialFile;
pub use motion::Motion;
pub use pose::{Pose, Rotation};
pub use primitive::{At, Color, Scale};
pub use shape::{MeshFile, Shape, flat_polygon};
pub use texture::TextureFile;
pub use timeline::{Ease, Key, KeyValue, LookAt, Path, Timeline, Track};

pub use crate::world::Loop;

/// Ranges that fields must keep to; each error says what was expected.
pub mod range {
    use super::Angle;
    use glam::DVec3;

    /// The value or what is expected of it.
    pub type Check = Result<(), &'static str>;

    fn when(holds: bool, expected: &'static str) -> Check {
        if holds { Ok(()) } else { Err(expected) }
    }

    /// A length.
    pub fn positive(value: &f64) -> Check {
        when(*value > 0.0, "a number greater than 0")
    }

    /// Where something ends, if it does.
    pub fn end(value: &Option<f64>) -> Check {
        value.as_ref().map_or(Ok(()), positive)
    }

    /// A length that may vanish.
    pub fn radius(value: &f64) -> Check {
        when(*value >= 0.0, "a number of at least 0")
    }

    /// A factor.
    pub fn not_negative(value: &f32) -> Check {
        when(*value >= 0.0, "a number of at least 0")
    }

    /// A share.
    pub fn share(value: &f32) -> Check {
        when((0.0..=1.0).contains(value), "a number from 0 to 1")
    }

    /// An alpha below which there is nothing.
    pub fn least_alpha(value: &Option<f32>) -> Check {
        value.as_ref().map_or(Ok(()), share)
    }

    /// A count of seconds.
    pub fn secs(value: &f64) -> Check {
        when(*value >= 0.0, "seconds, at least 0")
    }

    /// A full opening angle.
    pub fn opening(value: &Angle) -> Check {
        when(
            value.0 > 0.0 && value.0 < std::f64::consts::PI,
            "an angle between 0 and 180 degrees, both excluded",
        )
    }

    /// A half angle of a cone.
    pub fn half_angle(value: &Angle) -> Check {
        when(
            value.0 >= 0.0 && value.0 <= std::f64::consts::PI,
            "an angle from 0 to 180 degrees",
        )
    }

    /// Something that points somewhere.
    pub fn direction(value: &DVec3) -> Check {
        when(
            value.length_squared() > 0.0 && value.length_squared().is_finite(),
            "a direction: not all three numbers 0",
        )
    }

    /// Generations of rays.
    pub fn generations(value: &u32) -> Check {
        when((1..=64).contains(value), "a whole number from 1 to 64")
    }
}
