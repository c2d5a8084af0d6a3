//! The look of the overlay: calm, dark, a little blue, one warm accent.

use egui::style::{Spacing, WidgetVisuals};
use egui::{
    Color32, Context, CornerRadius, FontFamily, FontId, Margin, Stroke, TextStyle, Visuals,
};

/// Behind panels.
const NIGHT: Color32 = Color32::from_rgb(17, 19, 26);
/// Behind fields.
const WELL: Color32 = Color32::from_rgb(11, 12, 17);
/// Lines between things.
const LINE: Color32 = Color32::from_rgb(42, 46, 60);
/// Things to press, at rest.
const REST: Color32 = Color32::from_rgb(32, 36, 48);
/// Under the mouse.
const HOVER: Color32 = Color32::from_rgb(46, 52, 70);
/// Text.
const TEXT: Color32 = Color32::from_rgb(208, 212, 222);
/// Text of lesser weight.
pub const FAINT: Color32 = Color32::from_rgb(130, 137, 155);
/// What is selected, and what wants to be seen: a planet's gold.
pub const ACCENT: Color32 = Color32::from_rgb(226, 178, 92);
/// What went wrong.
pub const ALARM: Color32 = Color32::from_rgb(236, 118, 104);

/// Dresses a context.
pub fn apply(context: &Context) {
    context.set_theme(egui::Theme::Dark);
    context.all_styles_mut(|style| {
        style.visuals = visuals();
        style.text_styles = [
            (
                TextStyle::Heading,
                FontId::new(15.0, FontFamily::Proportional),
            ),
            (TextStyle::Body, FontId::new(13.5, FontFamily::Proportional)),
            (
                TextStyle::Button,
                FontId::new(13.5, FontFamily::Proportional),
            ),
            (
                TextStyle::Small,
                FontId::new(11.5, FontFamily::Proportional),
            ),
            (
                TextStyle::Monospace,
                FontId::new(12.5, FontFamily::Monospace),
            ),
        ]
        .into();
        style.spacing = Spacing {
            item_spacing: egui::vec2(8.0, 5.0),
            button_padding: egui::vec2(7.0, 3.0),
            indent: 14.0,
            interact_size: egui::vec2(34.0, 20.0),
            ..Spacing::default()
        };
        style.interaction.selectable_labels = false;
    });
}

fn visuals() -> Visuals {
    let widget = |fill: Color32, text: Color32, outline: Color32| WidgetVisuals {
        bg_fill: fill,
        weak_bg_fill: fill,
        bg_stroke: Stroke::new(1.0, outline),
        corner_radius: CornerRadius::same(4),
        fg_stroke: Stroke::new(1.0, text),
        expansion: 0.0,
    };
    let mut visuals = Visuals::dark();
    visuals.panel_fill = NIGHT;
    visuals.window_fill = NIGHT;
    visuals.window_stroke = Stroke::new(1.0, LINE);
    visuals.window_corner_radius = CornerRadius::same(8);
    visuals.menu_corner_radius = CornerRadius::same(6);
    visuals.extreme_bg_color = WELL;
    visuals.faint_bg_color = Color32::from_rgb(22, 25, 33);
    visuals.selection.bg_fill = Color32::from_rgb(74, 60, 34);
    visuals.selection.stroke = Stroke::new(1.0, ACCENT);
    visuals.hyperlink_color = ACCENT;
    visuals.widgets.noninteractive = widget(NIGHT, TEXT, LINE);
    visuals.widgets.inactive = widget(REST, TEXT, Color32::TRANSPARENT);
    visuals.widgets.hovered = widget(HOVER, Color32::WHITE, LINE);
    visuals.widgets.active = widget(HOVER, ACCENT, ACCENT);
    visuals.widgets.open = widget(REST, TEXT, LINE);
    visuals
}

/// The frame of a side panel.
pub fn panel() -> egui::Frame {
    egui::Frame::new()
        .fill(NIGHT.gamma_multiply(0.94))
        .inner_margin(Margin::symmetric(12, 10))
}

/// The frame of the bar at the top.
pub fn bar() -> egui::Frame {
    egui::Frame::new()
        .fill(NIGHT.gamma_multiply(0.97))
        .inner_margin(Margin::symmetric(12, 4))
}

/// The frame of something that floats over the picture.
pub fn card() -> egui::Frame {
    egui::Frame::new()
        .fill(NIGHT.gamma_multiply(0.92))
        .stroke(Stroke::new(1.0, LINE))
        .corner_radius(CornerRadius::same(8))
        .inner_margin(Margin::symmetric(14, 10))
}

/// A panel's heading.
pub fn heading(ui: &mut egui::Ui, text: &str) {
    ui.label(egui::RichText::new(text).heading().color(ACCENT));
    ui.add_space(2.0);
}

/// Text of lesser weight.
pub fn faint(text: impl Into<String>) -> egui::RichText {
    egui::RichText::new(text).color(FAINT)
}
