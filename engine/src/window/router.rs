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

/// Pixels that count as one notch of the wheel on a touch pad.
const PIXELS_PER_NOTCH: f64 = 40.0;

/// Sends an event where it belongs.
pub fn route(state: &mut State, input: &mut Input, window: &Window, event: &WindowEvent) {
    match event {
        WindowEvent::KeyboardInput {
            event: key,
            is_synthetic,
            ..
        } => {
            let down = key.state == ElementState::Pressed;
            let typing = state.egui_ctx().egui_wants_keyboard_input();
            if typing || !down {
                let _ = state.on_window_event(window, event);
            }
            if let PhysicalKey::Code(code) = key.physical_key
                && !is_synthetic
                && !(typing && down)
            {
                input.key(code, down);
            }
        }
        WindowEvent::MouseInput {
            state: button_state,
            button,
            ..
        } => {
            let down = *button_state == ElementState::Pressed;
            let over_panel = state.egui_ctx().egui_wants_pointer_input();
            if over_panel || !down {
                let _ = state.on_window_event(window, event);
            }
            if !down || !over_panel {
                input.button(*button, down);
                hold_mouse(state, input, window);
            }
        }
        WindowEvent::MouseWheel { delta, .. } => {
            if state.egui_ctx().egui_wants_pointer_input() {
                let _ = state.on_window_event(window, event);
            } else {
                input.wheel_turned(match delta {
                    MouseScrollDelta::LineDelta(_, lines) => f64::from(*lines),
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y / PIXELS_PER_NOTCH,
                });
            }
        }
        WindowEvent::CursorMoved { .. } if is_looking(input) => {}
        WindowEvent::Focused(false) => {
            input.release_all();
            hold_mouse(state, input, window);
            let _ = state.on_window_event(window, event);
        }
        _ => {
            let _ = state.on_window_event(window, event);
        }
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

/// While the mouse turns the camera, its pointer is hidden and held where it is.
fn hold_mouse(state: &State, input: &Input, window: &Window) {
    let looking = is_looking(input);
    if looking {
        // The picture was clicked: whatever was being typed into is left.
        state.egui_ctx().memory_mut(|memory| {
            if let Some(focused) = memory.focused() {
                memory.surrender_focus(focused);
            }
        });
        // Not every system can lock the pointer or confine it; looking works without.
        let _ = window
            .set_cursor_grab(CursorGrabMode::Locked)
            .or_else(|_| window.set_cursor_grab(CursorGrabMode::Confined));
    } else {
        let _ = window.set_cursor_grab(CursorGrabMode::None);
    }
    window.set_cursor_visible(!looking);
}
