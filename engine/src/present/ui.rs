//! The overlay's life in a frame: begun in [`FrameSet::Input`], filled in [`FrameSet::Edit`], closed in
//! [`FrameSet::Present`]. Whoever draws panels finds the context here.

use bevy_ecs::prelude::*;

/// The overlay of this frame.
#[derive(Resource, Default)]
pub struct Ui {
    context: egui::Context,
    input: egui::RawInput,
    platform: egui::PlatformOutput,
    picture: Option<egui::Rect>,
    pub(super) shapes: Vec<egui::ClippedPrimitive>,
    pub(super) textures: egui::TexturesDelta,
    pub(super) pixels_per_point: f32,
}

impl Ui {
    /// Where panels are drawn.
    pub fn context(&self) -> &egui::Context {
        &self.context
    }

    /// What keyboard and mouse did since the last frame.
    pub fn feed(&mut self, input: egui::RawInput) {
        self.input = input;
    }

    /// Panels leave this part of the window to the picture, in points.
    pub fn leave_to_picture(&mut self, rect: egui::Rect) {
        self.picture = Some(rect);
    }

    /// What panels leave to the picture, in points; the picture itself fills the window behind them.
    pub fn picture_rect(&self) -> egui::Rect {
        self.picture.unwrap_or_else(|| self.context.content_rect())
    }

    /// Whether a position, in points, is on something of the overlay. egui's own answer is about the
    /// pointer as it was in the last frame, which a quick move and click have left behind.
    pub fn covers(&self, position: egui::Pos2) -> bool {
        let floating = self
            .context
            .layer_id_at(position)
            .is_some_and(|layer| layer.order != egui::Order::Background);
        floating || self.picture.is_some_and(|rect| !rect.contains(position))
    }

    /// What the overlay asks of the window: cursor, clipboard.
    pub fn take_platform_output(&mut self) -> egui::PlatformOutput {
        std::mem::take(&mut self.platform)
    }
}

impl Drop for Ui {
    fn drop(&mut self) {
        // egui takes textures that were never uploaded for a mistake; at the end they are not.
        self.textures.clear();
    }
}

pub(super) fn begin_ui(mut ui: ResMut<Ui>) {
    let input = std::mem::take(&mut ui.input);
    ui.context.begin_pass(input);
}

pub(super) fn end_ui(mut ui: ResMut<Ui>) {
    let output = ui.context.end_pass();
    ui.shapes = ui
        .context
        .tessellate(output.shapes, output.pixels_per_point);
    ui.pixels_per_point = output.pixels_per_point;
    ui.platform = output.platform_output;
    ui.textures.append(output.textures_delta);
}
