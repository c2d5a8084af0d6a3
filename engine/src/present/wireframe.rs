//! Volumes as strokes over the picture: twelve edges of a box, three great circles of a sphere.
//!
//! Called by the overlay of a window and by [`super::Developed::draw`]. Strokes are in the picture's own
//! coordinates (see [`View`]); far ones come first and are fainter, so that near ones stand out.

use std::f32::consts::TAU;

use glam::{DVec3, Vec2, Vec3};

use crate::frame::{View, ViewProjection};
use crate::trace::{Form, Level, Owner, Volume};

/// Volumes that are drawn at most: what a person can still tell apart, and a display draws in time.
pub const MOST_VOLUMES: usize = 4000;

/// Picture heights that strokes may reach beyond the picture.
const BLEED: f32 = 0.05;
/// Half a stroke's width in picture heights: a pixel and a half in 720 rows, if there are few.
const HALF_WIDTH: f32 = 0.75 / 720.0;
/// Opacity of the nearest stroke and of the farthest.
const OPACITY: [f32; 2] = [0.95, 0.45];
/// Half the extent in picture heights below which a volume is fainter, or a heap of small ones is a blot. It is
/// that of the middle of the three sides: the long edges of a rod lie as close as those of a small box.
const SMALL: f32 = 24.0 / 720.0;
/// Opacity of the smallest, as a share.
const FAINTEST: f32 = 0.16;

/// One colour a level, from warm to cold; what the tree over instances shows is pale in every one.
const COLORS: [[u8; 3]; 9] = [
    [255, 92, 74],
    [255, 156, 51],
    [250, 217, 66],
    [157, 226, 72],
    [64, 219, 135],
    [52, 214, 222],
    [84, 162, 255],
    [150, 128, 255],
    [234, 110, 232],
];
/// The colour of leaves.
const LEAVES: [u8; 3] = [120, 240, 160];
/// The colour of the tree over instances.
const INSTANCES: [u8; 3] = [240, 240, 250];

/// A straight line over the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// In picture coordinates: from -1/2 to 1/2, x to the right, y up.
    pub ends: [Vec2; 2],
    /// sRGB.
    pub color: [u8; 3],
    /// From 0, unseen, to 1.
    pub opacity: f32,
    /// In picture heights.
    pub half_width: f32,
}

/// Strokes for the volumes of a level, relative to the eye of the view, the farthest first.
pub fn wireframe(volumes: &[Volume], level: Level, view: &View) -> Vec<Stroke> {
    let camera = Camera::new(view);
    let depth = |volume: &Volume| volume.center.dot(camera.forward).max(0.0);
    let mut order: Vec<(f32, &Volume)> = volumes.iter().map(|v| (depth(v), v)).collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0));
    let far = order.first().map_or(0.0, |(depth, _)| *depth);
    let near = order.last().map_or(0.0, |(depth, _)| *depth);
    // Many lines hide the picture and one another unless they are thinner.
    let crowd = (64.0 / volumes.len().max(64) as f32).powf(0.14);
    let mut strokes = Vec::new();
    for (_, volume) in order {
        let size = camera.size_of(volume);
        let mut sides = volume.axes.map(Vec3::length);
        sides.sort_by(f32::total_cmp);
        let middle = size * sides[1] / volume.radius().max(f32::MIN_POSITIVE);
        let weight = crowd * (middle / SMALL).clamp(FAINTEST, 1.0);
        for [a, b] in edges(volume, size) {
            let Some(ends) = camera.project(a, b) else {
                continue;
            };
            let depth = ((a + b) * 0.5).dot(camera.forward);
            let share = (depth - near) / (far - near).max(f32::MIN_POSITIVE);
            let share = if share.is_finite() { share } else { 0.0 };
            let [most, least] = OPACITY;
            strokes.push(Stroke {
                ends,
                color: color(volume, level),
                opacity: (most + (least - most) * share.clamp(0.0, 1.0)) * weight,
                half_width: HALF_WIDTH * crowd,
            });
        }
    }
    strokes
}

/// A line in the world over the picture, as [`Stroke::ends`]; none: it is behind the eye or beside the picture.
pub fn line_over(view: &View, ends: [DVec3; 2]) -> Option<[Vec2; 2]> {
    let [a, b] = ends.map(|end| (end - view.origin).as_vec3());
    Camera::new(view).project(a, b)
}

fn color(volume: &Volume, level: Level) -> [u8; 3] {
    match (volume.owner, level) {
        (Owner::Instances, _) => INSTANCES,
        (Owner::Mesh(_), Level::Leaves) => LEAVES,
        (Owner::Mesh(_), Level::Depth(depth)) => COLORS[(depth as usize - 1) % COLORS.len()],
    }
}

/// A volume's lines, relative to the eye; `size` is that of [`Camera::size_of`].
fn edges(volume: &Volume, size: f32) -> Vec<[Vec3; 2]> {
    let [x, y, z] = volume.axes;
    match volume.form {
        Form::Box => [[x, y, z], [y, z, x], [z, x, y]]
            .into_iter()
            .flat_map(|[along, a, b]| {
                [a + b, a - b, b - a, -a - b].map(|side| {
                    let middle = volume.center + side;
                    [middle - along, middle + along]
                })
            })
            .collect(),
        Form::Sphere => {
            // A chord is then nowhere farther than a fraction of a pixel from its arc.
            let chords = (96.0 * size.sqrt()).clamp(16.0, 96.0) as u32;
            [[x, y], [y, z], [z, x]]
                .into_iter()
                .flat_map(|[a, b]| {
                    let at = move |chord: u32| {
                        let (sin, cos) = (TAU * chord as f32 / chords as f32).sin_cos();
                        volume.center + a * cos + b * sin
                    };
                    (0..chords).map(move |chord| [at(chord), at(chord + 1)])
                })
                .collect()
        }
    }
}

/// A view in f32, relative to its eye.
struct Camera {
    forward: Vec3,
    /// Times a point: its picture coordinates, before the division by depth.
    across: [Vec3; 2],
    is_perspective: bool,
    /// Picture width over its height.
    aspect: f32,
}

impl Camera {
    fn new(view: &View) -> Self {
        let across = [view.right, view.up].map(|span| (span / span.length_squared()).as_vec3());
        Self {
            forward: view.forward.as_vec3(),
            across,
            is_perspective: view.projection == ViewProjection::Perspective,
            aspect: (view.right.length() / view.up.length()) as f32,
        }
    }

    /// Half the extent of a volume in picture heights, about.
    fn size_of(&self, volume: &Volume) -> f32 {
        let size = volume.radius() * self.across[1].length();
        if self.is_perspective {
            size / volume.center.length().max(volume.radius())
        } else {
            size
        }
    }

    /// The part of a line that is before the eye and within the picture; none: nothing is.
    fn project(&self, a: Vec3, b: Vec3) -> Option<[Vec2; 2]> {
        let [from, to] = [a, b].map(|p| p.dot(self.forward));
        let near = 1e-4 * (a - b).length();
        if from.max(to) <= near {
            return None;
        }
        let to_plane = |p: Vec3, q: Vec3| {
            let [from, to] = [p, q].map(|p| p.dot(self.forward));
            if from < near {
                p + (q - p) * ((near - from) / (to - from))
            } else {
                p
            }
        };
        let flat = |p: Vec3| {
            let flat = Vec2::from(self.across.map(|across| across.dot(p)));
            if self.is_perspective {
                flat / p.dot(self.forward)
            } else {
                flat
            }
        };
        let ends = [flat(to_plane(a, b)), flat(to_plane(b, a))];
        let is_drawable = ends.iter().all(|end| end.is_finite());
        let bleed = Vec2::new(BLEED / self.aspect.max(f32::MIN_POSITIVE), BLEED);
        is_drawable.then(|| clip(ends, Vec2::splat(0.5) + bleed))?
    }
}

/// The part of a line within ±`most` (Liang and Barsky 1984).
fn clip([a, b]: [Vec2; 2], most: Vec2) -> Option<[Vec2; 2]> {
    let step = b - a;
    let (mut from, mut to) = (0.0_f32, 1.0_f32);
    for axis in 0..2 {
        for (towards, room) in [
            (-step[axis], a[axis] + most[axis]),
            (step[axis], most[axis] - a[axis]),
        ] {
            if towards == 0.0 && room < 0.0 {
                return None;
            } else if towards < 0.0 {
                from = from.max(room / towards);
            } else if towards > 0.0 {
                to = to.min(room / towards);
            }
        }
    }
    (from < to).then(|| [a + step * from, a + step * to])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume(form: Form, center: Vec3) -> Volume {
        Volume {
            center,
            axes: Vec3::AXES,
            form,
            owner: Owner::Mesh(0),
        }
    }

    fn view(projection: ViewProjection, right: f64) -> View {
        View {
            projection,
            right: DVec3::X * right,
            up: DVec3::Y * right,
            ..View::default()
        }
    }

    #[test]
    fn a_box_ahead_has_its_corners_where_a_pinhole_puts_them() {
        let ahead = [volume(Form::Box, Vec3::new(0.0, 0.0, -3.0))];
        let view = view(ViewProjection::Perspective, 2.0);
        let strokes = wireframe(&ahead, Level::Depth(1), &view);
        assert_eq!(strokes.len(), 12);
        // Corners at distance 2 and 4, one unit aside; half the picture is one unit at distance 1.
        for end in strokes.iter().flat_map(|stroke| stroke.ends) {
            for side in end.abs().to_array() {
                let near = (side - 0.25).abs().min((side - 0.125).abs());
                assert!(near < 1e-6, "{end}");
            }
        }
        assert!(strokes.iter().all(|stroke| stroke.opacity > 0.0));
    }

    #[test]
    fn a_sphere_in_parallel_rays_is_round() {
        let ahead = [volume(Form::Sphere, Vec3::new(0.0, 0.0, -3.0))];
        let view = view(ViewProjection::Orthographic, 4.0);
        let strokes = wireframe(&ahead, Level::Leaves, &view);
        let farthest = strokes.iter().flat_map(|s| s.ends).map(Vec2::length);
        let farthest = farthest.fold(0.0, f32::max);
        assert!((farthest - 0.25).abs() < 1e-5, "{farthest}");
    }

    #[test]
    fn lines_stay_about_the_picture_wherever_the_eye_is() {
        for form in [Form::Box, Form::Sphere] {
            for projection in [ViewProjection::Perspective, ViewProjection::Orthographic] {
                for z in [-1e9, -30.0, -1.0, -0.5, 0.0, 0.5, 1.0, 30.0] {
                    for x in [0.0, 0.999, 1.0, 7.0, f32::MAX] {
                        let volumes = [volume(form, Vec3::new(x, 0.0, z))];
                        let view = view(projection, 1.3);
                        for stroke in wireframe(&volumes, Level::Depth(3), &view) {
                            let reach = stroke.ends.map(|end| end.abs().max_element());
                            assert!(reach.iter().all(|&r| r <= 0.5501), "{x} {z}: {reach:?}");
                            assert!((0.0..=1.0).contains(&stroke.opacity));
                        }
                    }
                }
            }
        }
        let behind = [volume(Form::Box, Vec3::new(0.0, 0.0, 4.0))];
        let strokes = wireframe(&behind, Level::Depth(1), &View::default());
        assert_eq!(strokes, []);
    }
}
