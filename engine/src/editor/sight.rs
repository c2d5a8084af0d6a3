//! The picture's view as the editor needs it: a point of the window to a ray, a point of the world to the window.
//!
//! The picture fills the window, behind the panels; all positions are in egui's points.

use egui::{Pos2, Rect};
use glam::{DVec2, DVec3};

use crate::frame::{View, ViewProjection};

/// How near before the eye lines are cut, as a share of the distance looked over.
const NEAR: f64 = 1e-4;

/// A view, and the window it fills.
#[derive(Clone, Copy, Debug)]
pub struct Sight {
    /// The eye.
    pub view: View,
    /// The window, in points.
    pub window: Rect,
}

impl Sight {
    /// From -1/2 to 1/2 across and up.
    fn in_picture(&self, at: Pos2) -> DVec2 {
        let from_center = at - self.window.center();
        DVec2::new(
            f64::from(from_center.x / self.window.width().max(1.0)),
            f64::from(-from_center.y / self.window.height().max(1.0)),
        )
    }

    /// The ray through a point of the window: its start in the world, and its direction.
    pub fn ray(&self, at: Pos2) -> (DVec3, DVec3) {
        let View {
            origin,
            forward,
            right,
            up,
            ..
        } = self.view;
        let at = self.in_picture(at);
        let aside = right * at.x + up * at.y;
        match self.view.projection {
            ViewProjection::Perspective => (origin, (forward + aside).normalize()),
            ViewProjection::Orthographic => (origin + aside, forward),
        }
    }

    /// Where a point of the world is in the window, and how far before the eye; none: behind it.
    pub fn place(&self, point: DVec3) -> Option<(Pos2, f64)> {
        let from_eye = point - self.view.origin;
        let depth = from_eye.dot(self.view.forward);
        if self.view.projection == ViewProjection::Perspective && depth <= NEAR {
            return None;
        }
        Some((self.at(from_eye, depth), depth))
    }

    fn at(&self, from_eye: DVec3, depth: f64) -> Pos2 {
        let View { right, up, .. } = self.view;
        let scale = match self.view.projection {
            ViewProjection::Perspective => depth,
            ViewProjection::Orthographic => 1.0,
        };
        let x = from_eye.dot(right) / right.length_squared() / scale;
        let y = from_eye.dot(up) / up.length_squared() / scale;
        let across = x as f32 * self.window.width();
        let down = -y as f32 * self.window.height();
        self.window.center() + egui::vec2(across, down)
    }

    /// A line between two points of the world in the window, cut at the eye; none: all of it is behind.
    pub fn line(&self, a: DVec3, b: DVec3) -> Option<[Pos2; 2]> {
        if self.view.projection == ViewProjection::Orthographic {
            return Some([self.place(a)?.0, self.place(b)?.0]);
        }
        let eye = self.view.origin;
        let (mut a, mut b) = (a - eye, b - eye);
        let depth = |p: DVec3| p.dot(self.view.forward);
        let near = NEAR * (depth(a).abs() + depth(b).abs()).max(1e-9);
        if depth(a) < near && depth(b) < near {
            return None;
        }
        let cut = |from: DVec3, to: DVec3| {
            from + (to - from) * ((near - depth(from)) / (depth(to) - depth(from)))
        };
        if depth(a) < near {
            a = cut(a, b);
        } else if depth(b) < near {
            b = cut(b, a);
        }
        Some([self.at(a, depth(a)), self.at(b, depth(b))])
    }

    /// The length in the world that a point of the window covers at a place.
    pub fn world_per_point(&self, place: DVec3) -> f64 {
        let depth = (place - self.view.origin).dot(self.view.forward).abs();
        let height = self.view.up.length() / f64::from(self.window.height().max(1.0));
        match self.view.projection {
            ViewProjection::Perspective => height * depth.max(1e-9),
            ViewProjection::Orthographic => height,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sights() -> [Sight; 2] {
        let view = View {
            origin: DVec3::new(3.0, 2.0, 8.0),
            right: DVec3::X * 1.6,
            up: DVec3::Y * 0.9,
            ..View::default()
        };
        let window = Rect::from_min_size(Pos2::ZERO, egui::vec2(1280.0, 720.0));
        let flat = View {
            projection: ViewProjection::Orthographic,
            ..view
        };
        [view, flat].map(|view| Sight { view, window })
    }

    #[test]
    fn what_a_ray_meets_is_seen_where_the_ray_began() {
        for sight in sights() {
            for (x, y, t) in [(640.0, 360.0, 1.0), (10.0, 700.0, 20.0), (1279.0, 3.0, 0.5)] {
                let (origin, dir) = sight.ray(Pos2::new(x, y));
                let (at, _) = sight.place(origin + dir * t).expect("it is before the eye");
                assert!(
                    at.distance(Pos2::new(x, y)) < 1e-2,
                    "{at:?} is not ({x}, {y})"
                );
            }
        }
    }

    #[test]
    fn lines_are_cut_at_the_eye() {
        let [sight, _] = sights();
        let eye = sight.view.origin;
        let behind = sight.line(eye + DVec3::Z, eye + DVec3::Z * 2.0);
        assert_eq!(behind, None);
        let [a, b] = sight
            .line(eye + DVec3::Z, eye - DVec3::Z + DVec3::X)
            .expect("half of it");
        assert!(a.is_finite() && b.is_finite());
        assert_eq!(sight.place(eye + DVec3::Z), None);
    }

    #[test]
    fn a_length_on_the_screen_is_a_length_in_the_world() {
        for sight in sights() {
            let place = sight.view.origin - DVec3::Z * 7.0;
            let up = place + DVec3::Y * sight.world_per_point(place) * 50.0;
            let (low, high) = (sight.place(place).unwrap().0, sight.place(up).unwrap().0);
            assert!((low.y - high.y - 50.0).abs() < 1e-2, "{low:?} {high:?}");
        }
    }
}
