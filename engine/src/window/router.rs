//! One router: what happens in the window goes to the overlay or to the picture, never to both.
//!
//! Keys go to the overlay while it edits text. A mouse button goes to the overlay if it goes down over a
//! panel, and the mouse belongs to the picture from then on until the button is up again otherwise.
//! Releases reach both: a key that was let go must not stay down anywhere.

use egui_winit::State;
use glam::DVec2;
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::keyboard::PhysicalKey;
use winit::window::{CursorGrabMode, Window};

use crate::input::Input;
use crate::present::Ui;

/// Pixels that count as one notch of the wheel on a touch pad.
const PIXELS_PER_NOTCH: f64 = 40.0;

/// Where events go, and where the pointer is.
pub struct Router {
    overlay: State,
    /// Physical pixels; none outside the window.
    pointer: Option<(f64, f64)>,
}

impl Router {
    /// A router into an overlay.
    pub fn new(overlay: State) -> Self {
        Self {
            overlay,
            pointer: None,
        }
    }

    /// The overlay's side.
    pub fn overlay(&mut self) -> &mut State {
        &mut self.overlay
    }

    /// Sends an event where it belongs.
    pub fn route(&mut self, input: &mut Input, ui: &Ui, window: &Window, event: &WindowEvent) {
        match event {
            WindowEvent::KeyboardInput {
                event: key,
                is_synthetic,
                ..
            } => {
                let down = key.state == ElementState::Pressed;
                let typing = ui.context().egui_wants_keyboard_input();
                if typing || !down {
                    self.tell_overlay(window, event);
                }
                if let PhysicalKey::Code(code) = key.physical_key
                    && !is_synthetic
                    && !(typing && down)
                {
                    input.key(code, down);
                }
            }
            WindowEvent::MouseInput { state, button, .. } => {
                let down = *state == ElementState::Pressed;
                let taken = self.overlay_takes_pointer(ui);
                if taken || !down {
                    self.tell_overlay(window, event);
                }
                if !taken && down {
                    leave_text(ui);
                }
                if !taken || !down {
                    input.button(*button, down);
                    hold_mouse(input, window);
                }
            }
            WindowEvent::MouseWheel { .. } if self.overlay_takes_pointer(ui) => {
                self.tell_overlay(window, event);
            }
            WindowEvent::MouseWheel { delta, .. } => input.wheel_turned(match delta {
                MouseScrollDelta::LineDelta(_, lines) => f64::from(*lines),
                MouseScrollDelta::PixelDelta(pixels) => pixels.y / PIXELS_PER_NOTCH,
            }),
            WindowEvent::CursorMoved { position, .. } => {
                self.pointer = Some((position.x, position.y));
                input.point_at(Some(DVec2::new(position.x, position.y)));
                if !is_looking(input) {
                    self.tell_overlay(window, event);
                }
            }
            WindowEvent::CursorLeft { .. } => {
                self.pointer = None;
                input.point_at(None);
                self.tell_overlay(window, event);
            }
            WindowEvent::Focused(false) => {
                input.release_all();
                hold_mouse(input, window);
                self.tell_overlay(window, event);
            }
            _ => self.tell_overlay(window, event),
        }
    }

    /// The answer, whether the overlay used the event, is decided here and not asked for.
    fn tell_overlay(&mut self, window: &Window, event: &WindowEvent) {
        let _ = self.overlay.on_window_event(window, event);
    }

    fn overlay_takes_pointer(&self, ui: &Ui) -> bool {
        let scale = ui.context().pixels_per_point();
        let over = self
            .pointer
            .is_some_and(|(x, y)| ui.covers(egui::pos2(x as f32 / scale, y as f32 / scale)));
        over || ui.context().egui_is_using_pointer()
    }
}

/// The mouse itself moved, wherever its pointer is.
pub fn mouse_moved(input: &mut Input, delta: (f64, f64)) {
    if is_looking(input) {
        input.mouse_moved(DVec2::from(delta));
    }
}

fn is_looking(input: &Input) -> bool {
    input.is_button_down(MouseButton::Right)
}

/// The picture was clicked: whatever was being typed into is left.
fn leave_text(ui: &Ui) {
    ui.context().memory_mut(|memory| {
        if let Some(focused) = memory.focused() {
            memory.surrender_focus(focused);
        }
    });
}

/// While the mouse turns the camera, its pointer is hidden and held where it is.
fn hold_mouse(input: &Input, window: &Window) {
    let looking = is_looking(input);
    if looking {
        // Not every system can lock the pointer or confine it; looking works without.
        let _ = window
            .set_cursor_grab(CursorGrabMode::Locked)
            .or_else(|_| window.set_cursor_grab(CursorGrabMode::Confined));
    } else {
        let _ = window.set_cursor_grab(CursorGrabMode::None);
    }
    window.set_cursor_visible(!looking);
}
