//! What the editor draws over the picture: outlines of what is selected, marks of lights and cameras, handles, the box of a
//! drag. Drawn once the frame is traced, so that lines lie where the picture has what they are of.

use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use egui::{Color32, Id, LayerId, Order, Painter, Pos2, Stroke};

use super::gizmo::{self, Gizmo, Handle};
use super::history::with_all_below;
use super::outline::{self, Boxes, Line};
use super::pointer::{self, Press};
use super::sight::Sight;
use super::{EditorState, picking, theme};
use crate::frame::FrameScene;
use crate::present::Ui;
use crate::world::{Camera, GlobalTransform, PointLight, SpotLight};

/// Things outlined at most: with more, lines would hide what they are of.
const MOST_OUTLINES: usize = 300;
/// Colours of the axes, as everywhere: x red, y green, z blue.
const AXES: [Color32; 3] = [
    Color32::from_rgb(232, 84, 84),
    Color32::from_rgb(122, 200, 84),
    Color32::from_rgb(84, 148, 240),
];
/// What is held, or under the mouse.
const LIT: Color32 = Color32::from_rgb(255, 226, 120);

/// Draws it all; a system of [`crate::schedule::FrameSet::Present`].
pub fn draw_marks(world: &mut World) {
    if !world.resource::<EditorState>().panels {
        return;
    }
    let sight = pointer::sight(world);
    let ui = world.resource::<Ui>();
    let layer = LayerId::new(Order::Background, Id::unique("marks"));
    let painter = ui
        .context()
        .layer_painter(layer)
        .with_clip_rect(ui.picture_rect());
    draw_lights_and_cameras(world, &sight, &painter);
    draw_outlines(world, &sight, &painter);
    draw_handles(world, &sight, &painter);
    if let Some(area) = world.resource::<Press>().area {
        painter.rect_filled(area, 2.0, theme::ACCENT.gamma_multiply(0.08));
        let line = Stroke::new(1.0, theme::ACCENT);
        painter.rect_stroke(area, 2.0, line, egui::StrokeKind::Inside);
    }
}

/// Draws a line of the world, dark below so that it is seen on bright things too.
fn draw_line(painter: &Painter, sight: &Sight, line: &Line, width: f32, color: Color32) {
    let parts = || {
        line.windows(2)
            .filter_map(|ends| sight.line(ends[0], ends[1]))
    };
    let below = Stroke::new(width + 2.0, Color32::from_black_alpha(color.a() / 3));
    for ends in parts() {
        painter.line_segment(ends, below);
    }
    for ends in parts() {
        painter.line_segment(ends, Stroke::new(width, color));
    }
}

fn draw_outlines(world: &mut World, sight: &Sight, painter: &Painter) {
    let selection = world.resource::<EditorState>().selection.clone();
    if selection.is_empty() {
        return;
    }
    let lead: EntityHashSet = selection
        .lead()
        .map(|lead| with_all_below(world, &[lead]))
        .into_iter()
        .flatten()
        .collect();
    let all: EntityHashSet = with_all_below(world, selection.all()).into_iter().collect();
    world.resource_scope(|world, mut boxes: Mut<Boxes>| {
        let scene = world.resource::<FrameScene>();
        let instances = scene.instances.iter().filter_map(|instance| {
            let entity = Entity::try_from_bits(instance.tag)?;
            all.contains(&entity).then_some((entity, instance))
        });
        for (entity, instance) in instances.take(MOST_OUTLINES) {
            let strength = if lead.contains(&entity) { 0.95 } else { 0.5 };
            let color = theme::ACCENT.gamma_multiply(strength);
            for line in outline::of_instance(scene, &mut boxes, instance) {
                draw_line(painter, sight, &line, 1.3, color);
            }
        }
    });
    for &entity in selection.all() {
        let Some(pose) = world.get::<GlobalTransform>(entity) else {
            continue;
        };
        let mut lines = Vec::new();
        let reach = sight.world_per_point(pose.0.translation) * gizmo::REACH;
        if let Some(light) = world.get::<SpotLight>(entity) {
            let mut cone = outline::of_spot(light);
            for point in cone.iter_mut().flatten() {
                *point *= 1.3 * reach;
            }
            lines.extend(cone);
        }
        if let Some(camera) = world.get::<Camera>(entity) {
            let aspect = f64::from(sight.window.aspect_ratio());
            lines.extend(outline::of_camera(camera, aspect));
        }
        let (_, rotation, place) = pose.0.to_scale_rotation_translation();
        let unscaled = glam::DAffine3::from_rotation_translation(rotation, place);
        outline::place(&mut lines, unscaled);
        for line in &lines {
            draw_line(painter, sight, line, 1.2, theme::ACCENT);
        }
    }
}

/// A small sign where a light or a camera is.
fn draw_lights_and_cameras(world: &mut World, sight: &Sight, painter: &Painter) {
    let marks = picking::marks(world, sight);
    for (entity, at, _) in marks {
        let is_selected = world.resource::<EditorState>().selection.contains(entity);
        let color = if is_selected {
            theme::ACCENT
        } else {
            Color32::from_rgb(214, 218, 228).gamma_multiply(0.8)
        };
        let line = Stroke::new(1.4, color);
        painter.circle_filled(at, 9.0, Color32::from_black_alpha(90));
        if world.get::<Camera>(entity).is_some() {
            let body =
                egui::Rect::from_center_size(at - egui::vec2(1.5, 0.0), egui::vec2(9.0, 7.0));
            painter.rect_stroke(body, 1.5, line, egui::StrokeKind::Middle);
            let right = body.right_center();
            let lens = [(0.0, 0.0), (3.5, -3.0), (3.5, 3.0)];
            let lens = lens.map(|(x, y)| right + egui::vec2(x, y));
            painter.add(egui::Shape::convex_polygon(
                lens.to_vec(),
                color,
                Stroke::NONE,
            ));
            continue;
        }
        painter.circle_stroke(at, 3.2, line);
        let is_point = world.get::<PointLight>(entity).is_some();
        let rays = if is_point { 8 } else { 3 };
        for ray in 0..rays {
            let angle = if is_point {
                std::f32::consts::TAU * ray as f32 / rays as f32
            } else {
                std::f32::consts::FRAC_PI_2 + 0.5 * (ray as f32 - 1.0)
            };
            let dir = egui::Vec2::angled(angle);
            painter.line_segment([at + dir * 5.2, at + dir * 7.8], line);
        }
    }
}

fn draw_handles(world: &World, sight: &Sight, painter: &Painter) {
    let gizmo = world.resource::<Gizmo>();
    let Some(frame) = pointer::frame(world, sight) else {
        return;
    };
    let held = gizmo.drag.as_ref().map(|drag| drag.handle);
    let lit = held.or(gizmo.hover);
    for shown in gizmo::handles(&frame, gizmo.mode, sight) {
        // A drag shows what is held alone.
        if held.is_some_and(|held| held != shown.handle) {
            continue;
        }
        let own = match shown.handle {
            Handle::Axis(i) | Handle::Plane(i) => AXES[i],
            Handle::Middle => Color32::from_rgb(224, 228, 236),
            Handle::Radius | Handle::Cone => theme::ACCENT,
        };
        let is_lit = lit == Some(shown.handle);
        let color = if is_lit { LIT } else { own };
        let width = if is_lit { 3.2 } else { 2.2 };
        let places: Option<Vec<Pos2>> = shown
            .line
            .iter()
            .map(|&place| Some(sight.place(place)?.0))
            .collect();
        if let (true, Some(places)) = (shown.filled, &places) {
            let fill = color.gamma_multiply(0.35);
            let area = egui::Shape::convex_polygon(places.clone(), fill, Stroke::NONE);
            painter.add(area);
        }
        draw_line(painter, sight, &shown.line, width, color);
        if let (Handle::Axis(_), gizmo::Mode::Move, Some(places)) =
            (shown.handle, gizmo.mode, &places)
        {
            draw_tip(painter, places, color, true);
        } else if let (Handle::Axis(_), gizmo::Mode::Scale, Some(places)) =
            (shown.handle, gizmo.mode, &places)
        {
            draw_tip(painter, places, color, false);
        }
    }
}

/// An arrow's head, or a block, at the end of a line.
fn draw_tip(painter: &Painter, line: &[Pos2], color: Color32, arrow: bool) {
    let [.., from, to] = line else {
        return;
    };
    let dir = (*to - *from).normalized();
    if !arrow {
        let block = egui::Rect::from_center_size(*to, egui::Vec2::splat(9.0));
        painter.rect_filled(block, 1.5, color);
        return;
    }
    let side = dir.rot90() * 5.0;
    let head = vec![*to + dir * 12.0, *to + side, *to - side];
    painter.add(egui::Shape::convex_polygon(head, color, Stroke::NONE));
}
