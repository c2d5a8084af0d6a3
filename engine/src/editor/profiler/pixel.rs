//! Why a pixel is as it is: its ray tree as a list and as lines over the picture.
//!
//! `Pick a pixel`, then a click in the picture: the f64 reference walks the frame as it is now and writes every ray down. The
//! lines stay in the world while camera and things move, so that the tree can be looked at from aside.

use bevy_ecs::prelude::*;
use egui::{Color32, Id, LayerId, Order, RichText, ScrollArea, Sense, Stroke, Ui};
use glam::{DVec2, DVec3, UVec2};

use super::things;
use crate::editor::levels::place;
use crate::editor::naming::label;
use crate::editor::{EditorState, theme};
use crate::frame::{FrameScene, TraceSettings};
use crate::input::{Input, MouseButton};
use crate::present::{self, line_over};
use crate::trace::Tracer;
use crate::trace::reference::{ExplainedRay, Explanation, Fate, RayKind, ReferenceTracer};

const ROW: f32 = 18.0;
/// Lines drawn at most.
const MOST_LINES: usize = 4000;

/// The pixel that is explained.
#[derive(Resource, Default)]
pub struct PixelView {
    /// Kept, since its trees are built anew for what changed alone.
    tracer: ReferenceTracer,
    /// The next click in the picture says which pixel.
    picking: bool,
    answer: Option<Answer>,
    /// The ray that is pointed at in the list.
    pointed: Option<usize>,
}

impl PixelView {
    /// Has the same reference count what every entity costs.
    pub fn count_things(&mut self, world: &mut World) {
        things::count(&mut self.tracer, world);
    }
}

struct Answer {
    explained: Explanation,
    /// Of each ray: what it met, in words, and whose it is.
    met: Vec<(String, Option<Entity>)>,
    /// How long rays that met nothing are drawn.
    far: f64,
}

/// The list; the answer is the entity that was clicked in it.
pub fn show(ui: &mut Ui, view: &mut PixelView) -> Option<Entity> {
    let mut clicked = None;
    ui.horizontal(|ui| {
        ui.toggle_value(&mut view.picking, "Pick a pixel");
        if view.answer.is_some() && ui.button("Clear").clicked() {
            (view.answer, view.pointed) = (None, None);
        }
        if view.picking {
            ui.label(theme::faint("click in the picture"));
        }
    });
    let Some(answer) = &view.answer else {
        let words = "every ray of a pixel: what it met, its weight, what it added and cost";
        ui.label(theme::faint(words));
        return None;
    };
    let explained = &answer.explained;
    let [r, g, b] = explained.color.to_array();
    let pixel = explained.pixel;
    let rays = match explained.rays.len() as u64 + explained.left_out {
        1 => "1 ray".to_owned(),
        more => format!("{more} rays"),
    };
    ui.label(theme::faint(format!(
        "pixel {},{}: {rays}, light {r:.4} {g:.4} {b:.4}",
        pixel.x, pixel.y
    )));
    view.pointed = None;
    ScrollArea::both()
        .id_salt("rays")
        .auto_shrink([false, false])
        .show_rows(ui, ROW, explained.rays.len(), |ui, rows| {
            for i in rows {
                let (words, entity) = &answer.met[i];
                let response = row(ui, &explained.rays[i], words, explained.added_below(i));
                if response.hovered() {
                    view.pointed = Some(i);
                }
                if response.clicked() {
                    clicked = *entity;
                }
            }
        });
    clicked
}

fn row(ui: &mut Ui, ray: &ExplainedRay, met: &str, below: DVec3) -> egui::Response {
    let response = ui.horizontal(|ui| {
        ui.set_min_height(ROW);
        ui.spacing_mut().item_spacing.x = 7.0;
        ui.add_space(12.0 * ray.depth as f32);
        let (dot, _) = ui.allocate_exact_size(egui::vec2(7.0, 7.0), Sense::hover());
        ui.painter().rect_filled(dot, 2.0, color(ray));
        let label = |text: RichText| egui::Label::new(text).extend().selectable(false);
        ui.add(label(RichText::new(format!("{}: {met}", kind(ray.kind)))));
        let figures = format!(
            "weight {:.3}  adds {:.4} of {:.4}  {} boxes {} shapes",
            ray.weight.max_element(),
            ray.added.max_element(),
            below.max_element(),
            ray.boxes,
            ray.shapes
        );
        ui.add(label(theme::faint(figures)));
    });
    response.response.interact(Sense::click())
}

fn kind(kind: RayKind) -> String {
    match kind {
        RayKind::Camera(sample) => format!("camera, sample {sample}"),
        RayKind::Mirrored => "mirrored".into(),
        RayKind::Refracted => "refracted".into(),
        RayKind::Straight => "straight on".into(),
        RayKind::Shadow(light) => format!("to light {light}"),
    }
}

/// By kind; a shadow ray that brought nothing is dark.
fn color(ray: &ExplainedRay) -> Color32 {
    match ray.kind {
        RayKind::Camera(_) => Color32::WHITE,
        RayKind::Mirrored => Color32::from_rgb(110, 170, 255),
        RayKind::Refracted | RayKind::Straight => Color32::from_rgb(90, 220, 190),
        RayKind::Shadow(_) if ray.added == DVec3::ZERO => Color32::from_rgb(140, 70, 66),
        RayKind::Shadow(_) => theme::ACCENT,
    }
}

/// Explains the pixel that was clicked, if one was to be picked.
pub fn pick(ui: &Ui, world: &mut World) {
    let Some(input) = world.get_resource::<Input>() else {
        return;
    };
    // A click on a panel is the panel's: this one was on the picture.
    let clicked = input.is_button_pressed(MouseButton::Left);
    let at = input.pointer().filter(|_| clicked);
    let Some(at) = at.filter(|_| world.resource::<PixelView>().picking) else {
        return;
    };
    let window = ui.ctx().content_rect().size() * ui.ctx().pixels_per_point();
    let share = at / DVec2::new(window.x.into(), window.y.into());
    let size = world.resource::<TraceSettings>().size;
    let pixel = (share * size.as_dvec2()).max(DVec2::ZERO).as_uvec2();
    world.resource_scope(|world, mut view: Mut<PixelView>| {
        view.picking = false;
        view.answer = explain(&mut view.tracer, world, pixel);
    });
}

fn explain(tracer: &mut ReferenceTracer, world: &World, pixel: UVec2) -> Option<Answer> {
    let scene = world.resource::<FrameScene>();
    tracer.refit(scene).ok()?;
    tracer
        .upload(scene, world.resource::<TraceSettings>())
        .ok()?;
    let explained = tracer.explain(pixel)?;
    let met = |ray: &ExplainedRay| match ray.fate {
        Fate::NotFollowed => ("not followed: past the last generation".into(), None),
        Fate::Missed => match ray.kind {
            RayKind::Shadow(_) => ("nothing in the way".into(), None),
            _ => ("the background".into(), None),
        },
        Fate::Met { instance, .. } => {
            let row = scene.instances.get(instance as usize);
            let entity = row.and_then(|row| Entity::try_from_bits(row.tag));
            let name = entity.map_or_else(
                || format!("thing {instance}"),
                |entity| label(world, entity),
            );
            (name, entity)
        }
    };
    let lengths = explained.rays.iter().filter_map(|ray| match ray.fate {
        Fate::Met { t, .. } => Some(t),
        _ => None,
    });
    Some(Answer {
        met: explained.rays.iter().map(met).collect(),
        far: lengths.fold(1.0, f64::max),
        explained,
    })
}

/// Draws the tree's rays over the picture of this frame.
pub fn draw_rays(
    view: Res<PixelView>,
    state: Res<EditorState>,
    scene: Res<FrameScene>,
    ui: Res<present::Ui>,
) {
    let Some(answer) = view.answer.as_ref().filter(|_| state.profiler) else {
        return;
    };
    let context = ui.context();
    let window = context.content_rect();
    let layer = LayerId::new(Order::Background, Id::unique("rays"));
    let painter = context
        .layer_painter(layer)
        .with_clip_rect(ui.picture_rect());
    let rays = answer.explained.rays.iter().enumerate().take(MOST_LINES);
    for (i, ray) in rays.filter(|(_, ray)| ray.fate != Fate::NotFollowed) {
        let ends = [ray.origin, ray.end(answer.far)];
        let Some(ends) = line_over(&scene.view, ends) else {
            continue;
        };
        let ends = ends.map(|end| place(window, end));
        let is_pointed = view.pointed == Some(i);
        let strong = view.pointed.is_none() || is_pointed;
        let color = color(ray).gamma_multiply(if strong { 0.95 } else { 0.3 });
        let width = if is_pointed { 3.5 } else { 1.6 };
        painter.line_segment(ends, Stroke::new(width, color));
        painter.circle_filled(ends[1], width * 1.2, color);
    }
}
