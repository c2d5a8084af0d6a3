//! From linear light to a screen or a file: exposure, tone curve, sRGB, overlay.
//!
//! The tone curve exists twice, as `tone.rs` and as `shaders/present.wgsl`; a test compares the two.

mod files;
mod pass;
mod screen;
mod screenshot;
mod tone;
mod ui;

pub use files::{FileError, write_exr, write_png8, write_png16_linear};
pub use pass::{Look, PresentPass};
pub use screen::Screen;
pub use screenshot::Screenshot;
pub use tone::{display_rgb, display_rgb8, srgb_from_linear};
pub use ui::Ui;

use bevy_ecs::schedule::IntoScheduleConfigs;

use crate::app::Engine;
use crate::schedule::FrameSet;

/// Adds the overlay and presenting (sets [`FrameSet::Input`] and [`FrameSet::Present`]); for windowed runs.
/// Nothing is shown until a [`Screen`] is there.
pub fn plugin(engine: &mut Engine) {
    engine.world.init_resource::<Ui>();
    engine.world.init_resource::<Screenshot>();
    engine.add_systems(FrameSet::Input, ui::begin_ui);
    engine.add_systems(
        FrameSet::Present,
        (
            ui::end_ui,
            screen::present_picture,
            screenshot::save_screenshot,
        )
            .chain(),
    );
}
