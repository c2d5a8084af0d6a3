//! From linear light to a screen or a file: exposure, tone curve, sRGB, overlay.
//!
//! The tone curve exists twice, as `tone.rs` and as `shaders/present.wgsl`; a test compares the two.

mod develop;
mod files;
mod pass;
mod screen;
mod screenshot;
mod tone;
mod ui;
mod wireframe;

pub use develop::Developed;
pub use files::{FileError, read_png8, write_developed, write_exr, write_png8, write_png16_linear};
pub use pass::{Look, PresentPass};
pub use screen::Screen;
pub use screenshot::Screenshot;
pub use tone::{display_rgb, display_rgb8, srgb_from_linear};
pub use ui::Ui;
pub use wireframe::{MOST_VOLUMES, Stroke, line_over, wireframe};

use bevy_ecs::prelude::*;

use crate::app::Engine;
use crate::schedule::FrameSet;

/// The systems that draw over the picture of this very frame, in [`FrameSet::Present`].
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DrawOverPicture;

/// Adds the overlay and presenting (sets [`FrameSet::Input`] and [`FrameSet::Present`]); for windowed runs.
/// Nothing is shown until a [`Screen`] is there.
pub fn plugin(engine: &mut Engine) {
    engine.world.init_resource::<Ui>();
    engine.world.init_resource::<Screenshot>();
    engine.add_systems(FrameSet::Input, ui::begin_ui);
    engine.add_systems(
        FrameSet::Present,
        (
            ui::end_ui.after(DrawOverPicture),
            screen::present_picture,
            screenshot::save_screenshot,
        )
            .chain(),
    );
}
