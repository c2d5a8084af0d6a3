//! What people do with keyboard and mouse, and what it means: keys, actions, the camera in hand.
//!
//! The window fills [`Input`] between frames with what the overlay did not take (one router: an event goes
//! to the panels or to the picture, never to both); systems of the frame read it; the window clears the
//! frame's part of it afterwards.

mod action;
mod fly;
mod keymap;
mod lamp;

pub use action::Action;
pub use fly::FlyCamera;
pub use keymap::{ALT, CTRL, Held, KeyMap, SHIFT, Trigger};
pub use lamp::HeldLight;
pub use winit::event::MouseButton;
pub use winit::keyboard::KeyCode;

use std::collections::HashSet;

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::IntoScheduleConfigs;
use glam::DVec2;

use crate::app::Engine;
use crate::schedule::FrameSet;

/// Keyboard and mouse, as far as they are meant for the picture.
#[derive(Resource, Debug, Default)]
pub struct Input {
    down: HashSet<KeyCode>,
    pressed: HashSet<KeyCode>,
    buttons: HashSet<MouseButton>,
    clicked: HashSet<MouseButton>,
    released: HashSet<MouseButton>,
    pointer: Option<DVec2>,
    mouse_delta: DVec2,
    wheel: f64,
    editing: bool,
}

impl Input {
    /// Whether a key is held down.
    pub fn is_down(&self, key: KeyCode) -> bool {
        self.down.contains(&key)
    }

    /// Whether a key went down since the last frame (repeats do not count).
    pub fn is_pressed(&self, key: KeyCode) -> bool {
        self.pressed.contains(&key)
    }

    /// Whether a mouse button is held down.
    pub fn is_button_down(&self, button: MouseButton) -> bool {
        self.buttons.contains(&button)
    }

    /// Whether a mouse button went down on the picture since the last frame.
    pub fn is_button_pressed(&self, button: MouseButton) -> bool {
        self.clicked.contains(&button)
    }

    /// Whether a mouse button was let go since the last frame.
    pub fn is_button_released(&self, button: MouseButton) -> bool {
        self.released.contains(&button)
    }

    /// Where the mouse is, in physical pixels of the window from its upper left corner; none: outside.
    pub fn pointer(&self) -> Option<DVec2> {
        self.pointer
    }

    /// The mouse is there now, or outside.
    pub fn point_at(&mut self, pointer: Option<DVec2>) {
        self.pointer = pointer;
    }

    /// Whether either key of a pair is held (both Ctrl keys, both Shift keys, both Alt keys).
    pub fn is_held(&self, pair: [KeyCode; 2]) -> bool {
        pair.iter().any(|&key| self.is_down(key))
    }

    /// Whether keys are tools of the editor just now: its panels are open, and no mouse button turns the camera.
    pub fn edits(&self) -> bool {
        self.editing && !self.is_button_down(MouseButton::Right)
    }

    /// The editor's panels are open, or not.
    pub fn set_editing(&mut self, editing: bool) {
        self.editing = editing;
    }

    /// Mouse movement since the last frame, pixels, y down.
    pub fn mouse_delta(&self) -> DVec2 {
        self.mouse_delta
    }

    /// Notches the wheel turned since the last frame, positive away from the user.
    pub fn wheel(&self) -> f64 {
        self.wheel
    }

    /// A key went down or up.
    pub fn key(&mut self, key: KeyCode, down: bool) {
        if !down {
            self.down.remove(&key);
        } else if self.down.insert(key) {
            self.pressed.insert(key);
        }
    }

    /// A mouse button went down or up.
    pub fn button(&mut self, button: MouseButton, down: bool) {
        if down {
            self.buttons.insert(button);
            self.clicked.insert(button);
        } else if self.buttons.remove(&button) {
            self.released.insert(button);
        }
    }

    /// The mouse moved, pixels, y down.
    pub fn mouse_moved(&mut self, delta: DVec2) {
        self.mouse_delta += delta;
    }

    /// The wheel turned, notches.
    pub fn wheel_turned(&mut self, notches: f64) {
        self.wheel += notches;
    }

    /// Everything is let go: the window lost the focus, and no release will be reported.
    pub fn release_all(&mut self) {
        self.down.clear();
        self.released.extend(&self.buttons);
        self.buttons.clear();
    }

    /// Forgets what belonged to the frame just run.
    pub fn end_frame(&mut self) {
        self.pressed.clear();
        self.clicked.clear();
        self.released.clear();
        self.mouse_delta = DVec2::ZERO;
        self.wheel = 0.0;
    }
}

/// Adds input and what is held in the hand: camera and light (set [`FrameSet::Edit`], that is after the
/// timeline has written its poses and before they are handed down).
pub fn plugin(engine: &mut Engine) {
    engine.world.init_resource::<Input>();
    engine.world.init_resource::<KeyMap>();
    engine.world.init_resource::<FlyCamera>();
    engine.world.init_resource::<HeldLight>();
    engine.add_systems(
        FrameSet::Edit,
        (fly::fly_camera, lamp::move_light).chain().in_set(HandSet),
    );
}

/// The systems of this module, for whoever has to be ordered around them.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct HandSet;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_pressed_once_however_often_it_repeats() {
        let mut input = Input::default();
        input.key(KeyCode::KeyW, true);
        input.key(KeyCode::KeyW, true);
        assert!(input.is_pressed(KeyCode::KeyW) && input.is_down(KeyCode::KeyW));
        input.end_frame();
        input.key(KeyCode::KeyW, true);
        assert!(!input.is_pressed(KeyCode::KeyW) && input.is_down(KeyCode::KeyW));
        input.key(KeyCode::KeyW, false);
        assert!(!input.is_down(KeyCode::KeyW));
    }

    #[test]
    fn a_tap_within_one_frame_is_seen() {
        let mut input = Input::default();
        input.key(KeyCode::F12, true);
        input.key(KeyCode::F12, false);
        assert!(input.is_pressed(KeyCode::F12) && !input.is_down(KeyCode::F12));
    }

    #[test]
    fn losing_the_focus_lets_go_of_everything() {
        let mut input = Input::default();
        input.key(KeyCode::KeyW, true);
        input.button(MouseButton::Right, true);
        input.release_all();
        assert!(!input.is_down(KeyCode::KeyW) && !input.is_button_down(MouseButton::Right));
    }
}
