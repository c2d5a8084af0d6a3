//! The last frames as bars, newest at the right: work bright, the wait for the display dark above it. A click looks at a frame.

use egui::{Align2, Color32, Rect, Sense, Stroke, Ui, pos2, vec2};

use super::{ProfilerView, colors, looked_at};
use crate::editor::theme;
use crate::profile::{Frame, Frames, SETTLING_FRAMES};

const HEIGHT: f32 = 58.0;
/// Of a bar, with the gap beside it.
const STEP: f32 = 4.0;

/// Draws the bars.
pub fn show(ui: &mut Ui, view: &mut ProfilerView, frames: &mut Frames) {
    let size = vec2(ui.available_width(), HEIGHT);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, true, "frame history"));
    let shown = ((rect.width() / STEP) as usize).min(frames.iter().len());
    let first = frames.iter().len() - shown;
    let held: Vec<&Frame> = frames.iter().skip(first).collect();
    let top = scale(view, &held);
    let left = rect.right() - STEP * shown as f32;
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
    let current = looked_at(view, frames).map(|frame| frame.id);
    let limit = frames.spike_limit();
    let height = |micros: f64| rect.height() * (micros * 1e-3 / top).clamp(0.0, 1.0) as f32;
    for (i, frame) in held.iter().enumerate() {
        let x = left + STEP * i as f32;
        let bar = |from: f32, to: f32| {
            Rect::from_min_max(
                pos2(x, rect.bottom() - to),
                pos2(x + STEP - 1.0, rect.bottom() - from),
            )
        };
        let work = height(frame.work_micros()).max(1.0);
        let whole = height(frame.work_micros() + frame.wait_micros);
        painter.rect_filled(bar(work, whole), 0.0, colors::WAIT.gamma_multiply(0.6));
        let is_slow = limit.is_some_and(|limit| frame.work_micros() > limit * 1e3);
        let color = if is_slow {
            theme::ALARM
        } else if Some(frame.id) == current {
            Color32::WHITE
        } else {
            theme::ACCENT.gamma_multiply(0.8)
        };
        painter.rect_filled(bar(0.0, work), 0.0, color);
    }
    lines(ui, view, rect, top, limit);
    let pointed = response.hover_pos().and_then(|at| {
        let place = ((at.x - left) / STEP).floor();
        (place >= 0.0).then(|| held.get(place as usize).copied())?
    });
    let Some(frame) = pointed else {
        return;
    };
    let (id, words) = (frame.id, words(frame));
    if response.clicked() {
        view.select(frames, id);
    }
    response.on_hover_ui_at_pointer(|ui| {
        ui.label(words);
    });
}

/// Milliseconds at the top: what nearly all frames stay below, so that one slow one does not flatten the rest.
fn scale(view: &ProfilerView, held: &[&Frame]) -> f64 {
    let settled = held.iter().filter(|frame| frame.id > SETTLING_FRAMES);
    let most = settled.map(|f| (f.work_micros() + f.wait_micros) * 1e-3);
    let [median, p95] = view.summary.lines();
    let most = most.fold(0.0, f64::max);
    most.min(3.0 * p95.max(median)).max(1.0) * 1.1
}

/// Median and 95 %, and the limit, across the bars.
fn lines(ui: &Ui, view: &ProfilerView, rect: Rect, top: f64, limit: Option<f64>) {
    let painter = ui.painter_at(rect);
    let [median, p95] = view.summary.lines();
    let marks = [
        (Some(median), "median", theme::FAINT),
        (Some(p95), "95 %", theme::FAINT),
        (limit, "limit", theme::ALARM),
    ];
    let mut last = f32::INFINITY;
    for (millis, name, color) in marks {
        let Some(millis) = millis.filter(|millis| *millis > 0.0 && *millis < top) else {
            continue;
        };
        let y = rect.bottom() - rect.height() * (millis / top) as f32;
        painter.hline(
            rect.x_range(),
            y,
            Stroke::new(1.0, color.gamma_multiply(0.5)),
        );
        if last - y < 11.0 {
            continue;
        }
        last = y;
        let font = egui::TextStyle::Small.resolve(ui.style());
        let at = pos2(rect.left() + 4.0, y);
        let words = format!("{name} {millis:.2}");
        painter.text(at, Align2::LEFT_BOTTOM, words, font, color);
    }
}

/// A frame in a line.
fn words(frame: &Frame) -> String {
    let millis = |micros: f64| micros * 1e-3;
    let mut words = format!(
        "frame {}: work {:.2} ms (host {:.2}",
        frame.id,
        millis(frame.work_micros()),
        millis(frame.host_micros())
    );
    if !frame.passes.is_empty() {
        words += &format!(", device {:.2}", millis(frame.device_micros()));
    }
    words + &format!("), wait {:.2} ms", millis(frame.wait_micros))
}
