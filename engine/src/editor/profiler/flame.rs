//! One frame as a flame: systems and their steps above, what the device did for that frame below, on one axis.
//!
//! The wheel zooms about the pointer, dragging moves, a double click shows all again; a click on a span marks its name in
//! every frame.

use egui::{Align2, Color32, FontId, Pos2, Rect, Sense, Stroke, TextStyle, Ui, pos2, vec2};

use super::{ProfilerView, colors};
use crate::editor::theme;
use crate::profile::Frame;

/// Of a row of spans.
const ROW: f32 = 20.0;
/// Of the ruler.
const RULER: f32 = 18.0;
/// Between host and device.
const GAP: f32 = 18.0;
/// No closer than this many microseconds across.
const CLOSEST: f64 = 2.0;

/// A box of the flame.
struct Bar<'a> {
    name: &'a std::sync::Arc<str>,
    /// Begin and length, microseconds.
    time: [f64; 2],
    row: usize,
    own_micros: f64,
    /// Of a pass, how much later it may have been.
    error_micros: Option<f64>,
}

/// Microseconds to points.
struct Axis {
    rect: Rect,
    from: f64,
    to: f64,
}

impl Axis {
    fn x(&self, micros: f64) -> f32 {
        let share = (micros - self.from) / (self.to - self.from);
        self.rect.left() + self.rect.width() * share.clamp(-0.01, 1.01) as f32
    }

    fn micros(&self, x: f32) -> f64 {
        let share = f64::from((x - self.rect.left()) / self.rect.width().max(1.0));
        self.from + share * (self.to - self.from)
    }
}

/// Draws a frame.
pub fn show(ui: &mut Ui, view: &mut ProfilerView, frame: &Frame) {
    title(ui, frame);
    let size = vec2(ui.available_width(), ui.available_height().max(60.0));
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    let end = frame.end_micros().max(1.0);
    let [from, to] = view.shown.unwrap_or([0.0, end * 1.02]);
    let axis = Axis { rect, from, to };
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
    ruler(ui, &axis);
    let bars = bars(frame);
    let host_rows = frame.spans.iter().map(|s| usize::from(s.depth) + 1).max();
    let host_rows = host_rows.unwrap_or(1);
    let top = rect.top() + RULER + 2.0;
    let device_top = top + ROW * host_rows as f32 + GAP;
    if !frame.passes.is_empty() {
        let small = TextStyle::Small.resolve(ui.style());
        let at = pos2(rect.left() + 4.0, device_top - 2.0);
        painter.text(at, Align2::LEFT_BOTTOM, "device", small, theme::FAINT);
    }
    for (i, bar) in bars.iter().enumerate() {
        let on_device = bar.error_micros.is_some();
        let y = match on_device {
            true => device_top,
            false => top + ROW * bar.row as f32,
        };
        show_bar(ui, view, frame, bar, (i, y), &axis);
    }
    let all = [0.0, end * 1.02];
    if response.double_clicked() {
        view.shown = None;
    } else if response.dragged() {
        let moved = axis.micros(rect.left()) - axis.micros(rect.left() + response.drag_delta().x);
        view.shown = Some(within([from + moved, to + moved], all));
    }
    if let Some(at) = response.hover_pos().or_else(|| pointer_in(ui, rect)) {
        zoom(ui, view, &axis, at, all);
    }
}

/// The pointer, on the flame or on a span of it.
fn pointer_in(ui: &Ui, rect: Rect) -> Option<Pos2> {
    let at = ui.ctx().pointer_hover_pos()?;
    (rect.contains(at) && ui.rect_contains_pointer(rect)).then_some(at)
}

/// Which frame, and how well host and device are aligned.
fn title(ui: &mut Ui, frame: &Frame) {
    let mut words = format!(
        "frame {}   host {:.3} ms   wait {:.3} ms",
        frame.id,
        frame.host_micros() * 1e-3,
        frame.wait_micros * 1e-3
    );
    match frame.alignment_micros() {
        Some(error) => {
            let device = frame.device_micros() * 1e-3;
            words += &format!(
                "   device {device:.3} ms, aligned to + {:.3} ms",
                error * 1e-3
            );
        }
        None if frame.awaits_device => words += "   the device has not told yet",
        None => {}
    }
    ui.label(theme::faint(words));
}

fn bars(frame: &Frame) -> Vec<Bar<'_>> {
    let spans = frame.spans.iter().zip(frame.self_micros());
    let host = spans.map(|(span, own_micros)| Bar {
        name: &span.name,
        time: [span.start_micros, span.micros],
        row: span.depth.into(),
        own_micros,
        error_micros: None,
    });
    let device = frame.passes.iter().map(|pass| Bar {
        name: &pass.name,
        time: [pass.start_micros, pass.micros],
        row: 0,
        own_micros: pass.micros,
        error_micros: Some(pass.error_micros),
    });
    host.chain(device).collect()
}

fn show_bar(
    ui: &Ui,
    view: &mut ProfilerView,
    frame: &Frame,
    bar: &Bar,
    (index, y): (usize, f32),
    axis: &Axis,
) {
    let [start, length] = bar.time;
    if start > axis.to || start + length < axis.from {
        return;
    }
    let left = axis.x(start);
    let right = axis.x(start + length).max(left + 1.0);
    let rect = Rect::from_min_max(pos2(left, y), pos2(right, y + ROW - 2.0));
    let rect = rect.intersect(axis.rect);
    let on_device = bar.error_micros.is_some();
    let is_marked = view.marked.as_ref() == Some(bar.name);
    let mut color = colors::of(bar.name, on_device);
    if view.marked.is_some() && !is_marked {
        color = color.gamma_multiply(0.35);
    }
    let painter = ui.painter_at(axis.rect);
    painter.rect_filled(rect, 2.0, color);
    if rect.width() > 26.0 {
        let font = FontId::proportional(11.5);
        let is_bright = is_marked || view.marked.is_none();
        let ink = match is_bright && color != colors::WAIT {
            true => colors::INK,
            false => theme::FAINT,
        };
        let inner = painter.with_clip_rect(rect.shrink2(vec2(3.0, 0.0)));
        let words = match rect.width() > 140.0 {
            true => format!("{}  {:.3} ms", bar.name, length * 1e-3),
            false => bar.name.to_string(),
        };
        let at = rect.left_center() + vec2(4.0, 0.0);
        inner.text(at, Align2::LEFT_CENTER, words, font, ink);
    }
    // What is a hair's breadth wide cannot be pointed at anyway.
    if rect.width() < 3.0 {
        return;
    }
    let id = ui.scope_id().with(("bar", index));
    let response = ui.interact(rect, id, Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, bar.name.as_ref()));
    if response.hovered() {
        let stroke = Stroke::new(1.0, Color32::WHITE);
        painter.rect_stroke(rect, 2.0, stroke, egui::StrokeKind::Inside);
    }
    if response.clicked() {
        view.marked = if is_marked {
            None
        } else {
            Some(bar.name.clone())
        };
    }
    response.on_hover_ui_at_pointer(|ui| tooltip(ui, view, frame, bar));
}

fn tooltip(ui: &mut Ui, view: &ProfilerView, frame: &Frame, bar: &Bar) {
    let usual = view.summary.usual(bar.name, bar.error_micros.is_some());
    let [start, length] = bar.time.map(|micros| micros * 1e-3);
    ui.label(egui::RichText::new(bar.name.as_ref()).strong());
    let mut lines = vec![
        format!("{length:.3} ms from {start:.3} ms on"),
        format!(
            "{:.1} % of the frame",
            1e5 * length / frame.end_micros().max(1.0)
        ),
    ];
    if bar.own_micros + 0.5 < bar.time[1] {
        let own = bar.own_micros * 1e-3;
        lines.push(format!("{own:.3} ms without what is within it"));
    }
    let millis = [usual.median, usual.p95, usual.most].map(|micros| micros * 1e-3);
    let [median, p95, most] = millis;
    lines.push(format!(
        "usually {median:.3} ms, 95 % {p95:.3}, at most {most:.3}"
    ));
    if let Some(error) = bar.error_micros {
        let error = error * 1e-3;
        lines.push(format!("on the host's clock up to {error:.3} ms later"));
    }
    for line in lines {
        ui.label(line);
    }
}

/// Marks at round times.
fn ruler(ui: &Ui, axis: &Axis) {
    let rect = axis.rect;
    let painter = ui.painter_at(rect);
    let most = f64::from(rect.width() / 90.0).max(1.0);
    let step = round_step((axis.to - axis.from) / most);
    let small = TextStyle::Small.resolve(ui.style());
    let line = Stroke::new(1.0, theme::FAINT.gamma_multiply(0.18));
    let mut mark = (axis.from / step).ceil() * step;
    while mark < axis.to {
        let x = axis.x(mark);
        painter.vline(x, rect.y_range(), line);
        let words = match step < 1000.0 {
            true => format!("{:.0} µs", mark),
            false => format!("{:.0} ms", mark * 1e-3),
        };
        let at = pos2(x + 3.0, rect.top() + 2.0);
        painter.text(at, Align2::LEFT_TOP, words, small.clone(), theme::FAINT);
        mark += step;
    }
}

/// The least of 1, 2, 5, 10, 20, ... that is no less.
fn round_step(least: f64) -> f64 {
    let power = 10_f64.powf(least.max(1e-3).log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * power);
    let fits = steps.into_iter().find(|step| *step >= least);
    fits.unwrap_or(10.0 * power)
}

/// The wheel over the flame.
fn zoom(ui: &Ui, view: &mut ProfilerView, axis: &Axis, at: Pos2, all: [f64; 2]) {
    let turned = ui.input(|input| input.smooth_scroll_delta().y + input.zoom_delta().ln() * 200.0);
    if turned == 0.0 {
        return;
    }
    let about = axis.micros(at.x);
    let by = f64::from(-turned / 200.0).exp();
    let width = ((axis.to - axis.from) * by).clamp(CLOSEST, all[1] - all[0]);
    let share = (about - axis.from) / (axis.to - axis.from);
    let from = about - share * width;
    let shown = within([from, from + width], all);
    view.shown = (width < all[1] - all[0]).then_some(shown);
}

/// The same length moved so that it lies within all there is.
fn within([from, to]: [f64; 2], all: [f64; 2]) -> [f64; 2] {
    let length = (to - from).min(all[1] - all[0]);
    let from = from.clamp(all[0], all[1] - length);
    [from, from + length]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round_and_a_part_stays_within_the_frame() {
        let steps = [0.7, 1.0, 1.2, 3.0, 60.0, 2e4].map(round_step);
        let expected = [1.0, 1.0, 2.0, 5.0, 100.0, 2e4];
        for (step, expected) in steps.iter().zip(expected) {
            assert!((step / expected - 1.0).abs() < 1e-9, "{steps:?}");
        }
        assert_eq!(within([-5.0, 15.0], [0.0, 100.0]), [0.0, 20.0]);
        assert_eq!(within([90.0, 120.0], [0.0, 100.0]), [70.0, 100.0]);
        assert_eq!(within([-50.0, 170.0], [0.0, 100.0]), [0.0, 100.0]);
    }
}
