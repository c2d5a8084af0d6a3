//! Framing: where a camera stands so that given points fill its picture, whatever the picture's shape.
//!
//! The direction of view is fixed, so that of a set of points only few numbers count: how far it reaches along the normals
//! of the four sides of a pyramid of view. Those above and below follow from the camera; those at the sides depend on the
//! picture's shape, so they are kept for a row of shapes. Between two of them the reach is convex, and the straight line
//! above it: no point ever leaves the picture.
//!
//! Filled by the frame's overview from what is there, and by the scene loader from all that a model file will do.

use bevy_ecs::prelude::*;
use glam::{DAffine3, DVec3};

use super::{Camera, Projection, Transform};

/// From the middle of what is framed towards the eye.
const TOWARDS_EYE: DVec3 = DVec3::new(0.5, 0.4, 1.0);
/// Of the picture's width or height; the rest is margin.
const FILLED: f64 = 0.9;
/// Slopes of the sides of a pyramid of view: half the widths of pictures at distance 1.
const SLOPES: [f64; 16] = [
    0.0, 0.05, 0.1, 0.15, 0.2, 0.26, 0.33, 0.41, 0.5, 0.6, 0.72, 0.9, 1.2, 2.0, 5.0, 20.0,
];
/// World units that an eye is away from what has no size.
const NEAREST: f64 = 1e-3;

/// See the module. As a resource: what a picture without a camera shows, instead of what is there.
#[derive(Resource, Clone, Debug, PartialEq)]
pub struct Framing {
    /// The slopes of the sides, rising.
    slopes: Vec<f64>,
    /// Reach to the right and to the left with each slope.
    sides: Vec<[f64; 2]>,
    /// Reach up and down.
    rise: [f64; 2],
    /// Reach towards the eye.
    front: f64,
}

impl Framing {
    /// Of nothing yet, for pictures of any shape.
    pub fn new() -> Self {
        Self::with_slopes(SLOPES.to_vec())
    }

    /// Of nothing yet, for pictures of one shape: their width over their height.
    pub fn of_aspect(aspect: f64) -> Self {
        Self::with_slopes(vec![FILLED * half_height() * aspect])
    }

    fn with_slopes(slopes: Vec<f64>) -> Self {
        Self {
            sides: vec![[f64::NEG_INFINITY; 2]; slopes.len()],
            slopes,
            rise: [f64::NEG_INFINITY; 2],
            front: f64::NEG_INFINITY,
        }
    }

    /// Adds a ball that a map may stretch.
    pub fn add_ball(&mut self, world_from_local: DAffine3, radius: f64) {
        let DAffine3 {
            matrix3,
            translation,
        } = world_from_local;
        self.reach(|along| {
            translation.dot(along) + radius * matrix3.mul_transpose_vec3(along).length()
        });
    }

    /// Adds a box that a map may turn.
    pub fn add_box(&mut self, world_from_local: DAffine3, min: DVec3, max: DVec3) {
        let corners = corners(min, max).into_iter();
        self.add_points(corners.map(|corner| world_from_local.transform_point3(corner)));
    }

    /// Adds points of the world.
    pub fn add_points(&mut self, points: impl IntoIterator<Item = DVec3>) {
        let [right, up, back] = axes();
        let slope = FILLED * half_height();
        for point in points {
            let (x, y, z) = (point.dot(right), point.dot(up), point.dot(back));
            for (side, &slope) in self.sides.iter_mut().zip(&self.slopes) {
                *side = [side[0].max(slope * z + x), side[1].max(slope * z - x)];
            }
            let [top, bottom] = self.rise;
            self.rise = [top.max(slope * z + y), bottom.max(slope * z - y)];
            self.front = self.front.max(z);
        }
    }

    /// Adds what reaches so far along vectors.
    fn reach(&mut self, how_far: impl Fn(DVec3) -> f64) {
        let [right, up, back] = axes();
        for (side, &slope) in self.sides.iter_mut().zip(&self.slopes) {
            let ahead = back * slope;
            let [a, b] = [ahead + right, ahead - right].map(&how_far);
            *side = [side[0].max(a), side[1].max(b)];
        }
        let ahead = back * (FILLED * half_height());
        let [a, b] = [ahead + up, ahead - up].map(&how_far);
        self.rise = [self.rise[0].max(a), self.rise[1].max(b)];
        self.front = self.front.max(how_far(back));
    }

    /// The pose of a default camera whose pictures of this width over height hold all of it; of nothing, as of a ball of
    /// radius 1 at the origin.
    pub fn pose(&self, aspect: f64) -> Transform {
        let slope = FILLED * half_height();
        let across = slope * aspect;
        let [right, left] = self.sides_at(across);
        let [top, bottom] = self.rise;
        if ![right, left, top, bottom]
            .iter()
            .all(|reach| reach.is_finite())
        {
            let mut ball = Self::of_aspect(aspect);
            ball.add_ball(DAffine3::IDENTITY, 1.0);
            return ball.pose(aspect);
        }
        // A point at (x, z) is in the picture of an eye at (e, h) while |x - e| <= slope (h - z).
        let away = (right + left) / (2.0 * across);
        let away = away.max((top + bottom) / (2.0 * slope));
        let away = away.max(self.front + NEAREST);
        let [x, y, z] = axes();
        let eye = x * (0.5 * (right - left)) + y * (0.5 * (top - bottom)) + z * away;
        Transform::looking_at(eye, eye - z, DVec3::Y)
    }

    /// The reach to the sides with a slope.
    fn sides_at(&self, slope: f64) -> [f64; 2] {
        let next = self.slopes.partition_point(|&other| other < slope);
        let [first, last] = [0, self.slopes.len() - 1];
        if next > last {
            let farther = (slope - self.slopes[last]) * self.front;
            return self.sides[last].map(|reach| reach + farther);
        }
        if next == first || self.slopes[next] == slope {
            return self.sides[next];
        }
        let (a, b) = (self.slopes[next - 1], self.slopes[next]);
        let share = (slope - a) / (b - a);
        let [low, high] = [self.sides[next - 1], self.sides[next]];
        [0, 1].map(|side| low[side] * (1.0 - share) + high[side] * share)
    }
}

impl Default for Framing {
    fn default() -> Self {
        Self::new()
    }
}

/// The corners of a box.
pub fn corners(min: DVec3, max: DVec3) -> [DVec3; 8] {
    std::array::from_fn(|i| {
        let side = |bit, low, high| if i & bit == 0 { low } else { high };
        DVec3::new(
            side(1, min.x, max.x),
            side(2, min.y, max.y),
            side(4, min.z, max.z),
        )
    })
}

/// To the right, up and back to the eye, unit.
fn axes() -> [DVec3; 3] {
    let back = TOWARDS_EYE.normalize();
    let right = DVec3::Y.cross(back).normalize();
    [right, back.cross(right), back]
}

/// Of a default camera's picture, at distance 1.
fn half_height() -> f64 {
    match Camera::default().projection {
        Projection::Perspective { vertical_fov } => (0.5 * vertical_fov).tan(),
        Projection::Orthographic { height } => 0.5 * height,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    /// How far out in its picture a point is that an eye at this pose sees: 1 at the edge.
    fn out_in(pose: &Transform, aspect: f64, point: DVec3) -> f64 {
        let seen = pose.affine().inverse().transform_point3(point);
        let (x, y) = (seen.x / -seen.z / aspect, seen.y / -seen.z);
        assert!(seen.z < 0.0, "{point} is behind the eye");
        x.abs().max(y.abs()) / half_height()
    }

    #[test]
    fn points_fill_the_picture_and_stay_in_it() {
        let mut random = Random::new(11);
        for _ in 0..200 {
            let stretch = random.cube().abs() * 10.0;
            let centre = random.cube() * 1e3;
            let points: Vec<DVec3> = (0..40).map(|_| centre + random.cube() * stretch).collect();
            let mut any = Framing::new();
            any.add_points(points.iter().copied());
            for aspect in [0.3, 0.7, 1.0, 4.0 / 3.0, 1.777, 5.0] {
                let mut exact = Framing::of_aspect(aspect);
                exact.add_points(points.iter().copied());
                for (framing, least) in [(&exact, FILLED - 1e-9), (&any, 0.85)] {
                    let pose = framing.pose(aspect);
                    let out = points.iter().map(|&point| out_in(&pose, aspect, point));
                    let most = out.fold(0.0, f64::max);
                    assert!(most <= FILLED + 1e-9, "{aspect}: {most}");
                    assert!(most >= least, "{aspect}: {most}");
                }
            }
        }
    }

    #[test]
    fn a_ball_is_framed_as_its_points() {
        let map = DAffine3::from_scale(DVec3::new(1.0, 3.0, 0.2));
        let mut ball = Framing::of_aspect(1.5);
        ball.add_ball(map, 2.0);
        let mut random = Random::new(5);
        let mut points = Framing::of_aspect(1.5);
        points.add_points((0..100_000).map(|_| map.transform_point3(random.direction() * 2.0)));
        let [a, b] = [ball, points].map(|framing| framing.pose(1.5).translation);
        assert!(a.distance(b) < 0.02, "{a} {b}");
    }

    #[test]
    fn nothing_and_a_point_are_framed_too() {
        let nothing = Framing::new().pose(1.0);
        assert!(out_in(&nothing, 1.0, DVec3::Y) < 1.0);
        let mut point = Framing::new();
        point.add_points([DVec3::ONE]);
        assert!(out_in(&point.pose(2.0), 2.0, DVec3::ONE) < 1e-6);
    }
}
