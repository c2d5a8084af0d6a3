//! What the frame cost, in tables: every name, the slowest frames, what was counted.

use std::sync::Arc;

use bevy_ecs::prelude::World;
use egui::{
    Align, Align2, Color32, Layout, Rect, RichText, ScrollArea, Sense, TextStyle, Ui, vec2,
};

use super::{Asked, PixelView, ProfilerView, Tab, colors, pixel, things, uploads};
use crate::editor::theme;
use crate::profile::{Frame, Frames, costs};

const ROW: f32 = 18.0;
/// Of a column of figures.
const FIGURE: f32 = 62.0;

/// Draws the table that is chosen.
pub fn show(
    ui: &mut Ui,
    (view, pixel_view): (&mut ProfilerView, &mut PixelView),
    (frames, frame): (&mut Frames, &Frame),
    (world, asked): (&World, &mut Asked),
) {
    ui.horizontal(|ui| {
        ui.selectable_value(&mut view.tab, Tab::Costs, "Costs");
        ui.selectable_value(&mut view.tab, Tab::Worst, "Slowest");
        ui.selectable_value(&mut view.tab, Tab::Counters, "Counters");
        ui.selectable_value(&mut view.tab, Tab::Uploads, "Uploads");
        ui.selectable_value(&mut view.tab, Tab::Things, "Things");
        ui.selectable_value(&mut view.tab, Tab::Pixel, "Pixel");
    });
    let tab = view.tab;
    if tab == Tab::Pixel {
        asked.entity = pixel::show(ui, pixel_view);
        return;
    }
    if tab == Tab::Uploads {
        asked.entity = uploads::show(ui, world);
        return;
    }
    if tab == Tab::Things {
        (asked.entity, asked.count) = things::show(ui, world);
        return;
    }
    if tab == Tab::Costs {
        head(ui);
    }
    ScrollArea::vertical()
        .id_salt(tab as u8)
        .auto_shrink([false, false])
        .show(ui, |ui| match tab {
            Tab::Costs => all_costs(ui, view, frame),
            Tab::Worst => worst(ui, view, frames),
            Tab::Counters | Tab::Uploads | Tab::Things | Tab::Pixel => counters(ui, frame),
        });
}

/// Over the columns of [`all_costs`].
fn head(ui: &mut Ui) {
    let size = vec2(ui.available_width(), 14.0);
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    let font = TextStyle::Small.resolve(ui.style());
    for (i, words) in ["at most", "median", "this frame"].iter().enumerate() {
        let at = rect.right_center() - vec2(4.0 + FIGURE * i as f32, 0.0);
        let painter = ui.painter_at(rect);
        painter.text(at, Align2::RIGHT_CENTER, words, font.clone(), theme::FAINT);
    }
}

/// Every name, the dearest in this frame first.
fn all_costs(ui: &mut Ui, view: &mut ProfilerView, frame: &Frame) {
    let mut rows: Vec<((Arc<str>, bool), f64)> = costs(frame).into_iter().collect();
    rows.sort_by(|a, b| b.1.total_cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
    let whole = frame.work_micros().max(1e-9);
    for ((name, on_device), micros) in rows {
        let usual = view.summary.usual(&name, on_device);
        let figures = [usual.most, usual.median, micros];
        let response = row(ui, &name, on_device, figures, micros / whole, view);
        if response.clicked() {
            let is_marked = view.marked.as_ref() == Some(&name);
            view.marked = (!is_marked).then_some(name);
        }
    }
}

/// A name, its share as a bar behind it, and its figures in milliseconds from right to left.
fn row(
    ui: &mut Ui,
    name: &str,
    on_device: bool,
    figures: [f64; 3],
    share: f64,
    view: &ProfilerView,
) -> egui::Response {
    let size = vec2(ui.available_width(), ROW);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, name));
    let painter = ui.painter_at(rect);
    let mut filled = rect.shrink2(vec2(0.0, 1.0));
    filled.set_width(rect.width() * share.clamp(0.0, 1.0) as f32);
    let color = colors::of(name, on_device);
    painter.rect_filled(filled, 2.0, color.gamma_multiply(0.35));
    let dot = Rect::from_center_size(rect.left_center() + vec2(6.0, 0.0), vec2(7.0, 7.0));
    painter.rect_filled(dot, 2.0, color);
    let is_marked = view.marked.as_deref() == Some(name);
    let ink = if is_marked || response.hovered() {
        Color32::WHITE
    } else {
        ui.visuals().text_color()
    };
    let font = TextStyle::Monospace.resolve(ui.style());
    for (i, micros) in figures.iter().enumerate() {
        let at = rect.right_center() - vec2(4.0 + FIGURE * i as f32, 0.0);
        let words = format!("{:.3}", micros * 1e-3);
        let ink = if i == 2 { ink } else { theme::FAINT };
        painter.text(at, Align2::RIGHT_CENTER, words, font.clone(), ink);
    }
    let room = Rect::from_min_max(rect.min, rect.max - vec2(FIGURE * 3.0 + 4.0, 0.0));
    let body = TextStyle::Body.resolve(ui.style());
    let at = rect.left_center() + vec2(15.0, 0.0);
    let inner = painter.with_clip_rect(room);
    inner.text(at, Align2::LEFT_CENTER, name, body, ink);
    response
}

/// The slowest frames since they were last forgotten, with who made them slow.
fn worst(ui: &mut Ui, view: &mut ProfilerView, frames: &mut Frames) {
    let mut clicked = None;
    for frame in frames.worst() {
        let because = view.summary.blame(frame.id).map_or_else(String::new, |b| {
            let place = if b.on_device { " on the device" } else { "" };
            let [taken, usual] = [b.micros, b.usual_micros].map(|micros| micros * 1e-3);
            format!("{}{place}: {taken:.2}, usually {usual:.2}", b.name)
        });
        let words = format!("frame {}   {:.2} ms", frame.id, frame.work_micros() * 1e-3);
        ui.horizontal(|ui| {
            let is_shown = view.selected == Some(frame.id);
            if ui.selectable_label(is_shown, words).clicked() {
                clicked = Some(frame.id);
            }
            ui.add(egui::Label::new(theme::faint(because)).truncate());
        });
    }
    if let Some(id) = clicked {
        view.select(frames, id);
    }
    if frames.worst().is_empty() {
        ui.label(theme::faint("none yet; the first frames do not count"));
    } else if ui.button("Forget").clicked() {
        frames.forget_worst();
    }
}

/// What the frame counted. Rows that are 0 are faint.
fn counters(ui: &mut Ui, frame: &Frame) {
    if frame.awaits_device {
        ui.label(theme::faint("the device has not told of its rays yet"));
    }
    ui.label(theme::faint(format!(
        "{} rays; counting them slows a GPU a little while the profiler is open",
        grouped(frame.counters.rays())
    )));
    for (name, count) in frame.counters.named() {
        ui.horizontal(|ui| {
            ui.label(theme::faint(name));
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let text = RichText::new(grouped(count)).monospace();
                ui.label(if count == 0 { text.weak() } else { text });
            });
        });
    }
}

/// 1234567 as "1 234 567".
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::grouped;

    #[test]
    fn numbers_are_grouped_by_thousands() {
        assert_eq!(
            [0, 999, 1000, 1_234_567].map(grouped),
            ["0", "999", "1 000", "1 234 567"]
        );
    }
}
