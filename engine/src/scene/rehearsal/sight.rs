//! Whether a camera sees anything of a thing: it does not where the thing is wholly outside one side of its pyramid of
//! view, or behind it (Assarsson and Moeller 2000). Called by [`super`] for what a model shows.
//!
//! What is called seen need not be, as it may be hidden or just pass a corner; what is called unseen never is.

use glam::{DAffine3, DVec3};

use crate::world::{Camera, GlobalTransform, Projection};

/// Width over height of the widest picture that is thought of: what a wide display shows.
const ASPECT: f64 = 64.0 / 27.0;

/// A thing that is shown.
pub enum Thing {
    /// Places in the world, and what is between them.
    Points(Vec<DVec3>),
    /// A ball that a map to the world may stretch, and its radius.
    Ball(DAffine3, f64),
    /// A box that a map to the world may turn: its least and its greatest corner.
    Box(DAffine3, DVec3, DVec3),
}

/// The space before a camera, within the sides of its pyramid of view.
pub struct Sight {
    /// Inwards from a side, and how far along it the side is.
    sides: [(DVec3, f64); 5],
}

impl Sight {
    /// That of a camera at a pose.
    pub fn of((camera, pose): (&Camera, &GlobalTransform)) -> Self {
        let (_, rotation, eye) = pose.0.to_scale_rotation_translation();
        let [right, up, back] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| rotation * axis);
        // How far the upper side is up at the eye, and how much farther at distance 1.
        let (start, slope) = match camera.projection {
            Projection::Perspective { vertical_fov } => (0.0, (0.5 * vertical_fov).tan()),
            Projection::Orthographic { height } => (0.5 * height, 0.0),
        };
        let side = |out: DVec3, wide: f64| {
            let inwards = -back * (slope * wide) - out;
            (inwards, inwards.dot(eye) - start * wide)
        };
        Self {
            sides: [
                side(right, ASPECT),
                side(-right, ASPECT),
                side(up, 1.0),
                side(-up, 1.0),
                (-back, -back.dot(eye)),
            ],
        }
    }

    /// Whether it may hold some of a thing.
    pub fn meets(&self, thing: &Thing) -> bool {
        let is_in = |&(inwards, least): &(DVec3, f64)| match thing {
            Thing::Points(points) => points.iter().any(|point| inwards.dot(*point) >= least),
            Thing::Ball(map, radius) => {
                let reach = radius * map.matrix3.mul_transpose_vec3(inwards).length();
                inwards.dot(map.translation) + reach >= least
            }
            Thing::Box(map, min, max) => {
                let along = map.matrix3.mul_transpose_vec3(inwards);
                let farthest = (along * *min).max(along * *max).element_sum();
                inwards.dot(map.translation) + farthest >= least
            }
        };
        self.sides.iter().all(is_in)
    }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;
    use crate::testing::Random;
    use crate::world::Transform;

    /// What is in a picture is met, however it is given; a small thing beside the picture or behind it is not.
    #[test]
    fn what_is_in_the_picture_is_met_and_what_is_beside_it_is_not() {
        let mut random = Random::new(3);
        for i in 0..2000 {
            let projection = match i % 2 {
                0 => Projection::Perspective { vertical_fov: 0.8 },
                _ => Projection::Orthographic { height: 3.0 },
            };
            let camera = Camera {
                projection,
                ..Camera::default()
            };
            let pose = Transform {
                translation: random.cube() * 10.0,
                rotation: DQuat::from_axis_angle(random.direction(), 2.0),
                ..Transform::IDENTITY
            };
            let sight = Sight::of((&camera, &GlobalTransform(pose.affine())));
            let local = random.cube() * 8.0;
            let half = match projection {
                Projection::Perspective { vertical_fov } => -local.z * (0.5 * vertical_fov).tan(),
                Projection::Orthographic { height } => 0.5 * height,
            };
            let out = (local.x.abs() - half * ASPECT).max(local.y.abs() - half);
            let out = out.max(local.z);
            let at = pose.affine() * DAffine3::from_translation(local);
            let place = at.translation;
            let things = [
                Thing::Points(vec![place]),
                Thing::Ball(at, 0.1),
                Thing::Box(at, DVec3::splat(-0.1), DVec3::splat(0.1)),
            ];
            for thing in &things {
                if out <= 0.0 {
                    assert!(sight.meets(thing), "{local}");
                }
                if out > 0.5 {
                    assert!(!sight.meets(thing), "{local}");
                }
            }
        }
    }
}
