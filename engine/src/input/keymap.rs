//! Which keys do what. The help overlay is made from this table.

use std::fmt;

use bevy_ecs::prelude::*;
use winit::event::MouseButton;
use winit::keyboard::KeyCode;

use super::{Action, Input};

/// A key, a mouse button or the wheel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Trigger {
    /// A key, by its place on the keyboard.
    Key(KeyCode),
    /// The mouse moves while this button is held.
    Drag(MouseButton),
    /// The wheel turns.
    Wheel,
    /// Any of the ten digits; which one says what is meant.
    Digit,
}

/// The keys of each digit, above the letters and beside them.
const DIGITS: [[KeyCode; 2]; 10] = [
    [KeyCode::Digit0, KeyCode::Numpad0],
    [KeyCode::Digit1, KeyCode::Numpad1],
    [KeyCode::Digit2, KeyCode::Numpad2],
    [KeyCode::Digit3, KeyCode::Numpad3],
    [KeyCode::Digit4, KeyCode::Numpad4],
    [KeyCode::Digit5, KeyCode::Numpad5],
    [KeyCode::Digit6, KeyCode::Numpad6],
    [KeyCode::Digit7, KeyCode::Numpad7],
    [KeyCode::Digit8, KeyCode::Numpad8],
    [KeyCode::Digit9, KeyCode::Numpad9],
];

impl fmt::Display for Trigger {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Key(key) => f.write_str(&key_name(*key)),
            Self::Drag(MouseButton::Right) => f.write_str("Right mouse button, held"),
            Self::Drag(button) => write!(f, "{button:?} mouse button"),
            Self::Wheel => f.write_str("Wheel"),
            Self::Digit => f.write_str("1 to 9, 0"),
        }
    }
}

/// The name on the key.
fn key_name(key: KeyCode) -> String {
    match key {
        KeyCode::Period => ".".into(),
        KeyCode::ArrowUp => "Up".into(),
        KeyCode::ArrowDown => "Down".into(),
        KeyCode::ArrowLeft => "Left".into(),
        KeyCode::ArrowRight => "Right".into(),
        KeyCode::ShiftLeft => "Shift".into(),
        KeyCode::ControlLeft => "Ctrl".into(),
        KeyCode::Escape => "Esc".into(),
        // KeyW is called W, Digit1 is called 1, F12 is called F12.
        other => {
            let name = format!("{other:?}");
            name.strip_prefix("Key")
                .or_else(|| name.strip_prefix("Digit"))
                .unwrap_or(&name)
                .to_owned()
        }
    }
}

/// Which triggers do what. No trigger does two things.
#[derive(Resource, Clone, Debug, PartialEq, Eq)]
pub struct KeyMap {
    /// What `--keys` calls it.
    pub name: &'static str,
    bindings: Vec<(Trigger, Action)>,
}

impl Default for KeyMap {
    fn default() -> Self {
        Self::standard()
    }
}

impl KeyMap {
    /// Names of all key maps.
    pub const NAMES: [&str; 2] = ["standard", "report"];

    /// The key map of a name.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "standard" => Some(Self::standard()),
            "report" => Some(Self::report()),
            _ => None,
        }
    }

    /// What games and editors of today agree on: right mouse button and W A S D Q E.
    pub fn standard() -> Self {
        use KeyCode::{ArrowDown, ArrowLeft, ArrowRight, ArrowUp, KeyA, KeyD, KeyE, KeyH, KeyQ};
        use KeyCode::{KeyS, KeyW};
        Self::with_common_keys(
            "standard",
            &[
                (KeyW, Action::Forward),
                (ArrowUp, Action::Forward),
                (KeyS, Action::Back),
                (ArrowDown, Action::Back),
                (KeyA, Action::Left),
                (KeyD, Action::Right),
                (KeyE, Action::Up),
                (KeyQ, Action::Down),
                (ArrowLeft, Action::TurnLeft),
                (ArrowRight, Action::TurnRight),
                (KeyH, Action::Help),
            ],
        )
    }

    /// The keys of the 2008 report: arrows and I K O P for the camera, W A S D for the light, F for the screen.
    pub fn report() -> Self {
        use KeyCode::{ArrowDown, ArrowLeft, ArrowRight, ArrowUp, KeyA, KeyD, KeyF, KeyI, KeyK};
        use KeyCode::{KeyO, KeyP, KeyS, KeyW};
        Self::with_common_keys(
            "report",
            &[
                (ArrowUp, Action::Forward),
                (ArrowDown, Action::Back),
                (ArrowLeft, Action::Left),
                (ArrowRight, Action::Right),
                (KeyI, Action::Up),
                (KeyK, Action::Down),
                (KeyO, Action::TurnLeft),
                (KeyP, Action::TurnRight),
                (KeyW, Action::LightAway),
                (KeyS, Action::LightNear),
                (KeyA, Action::LightLeft),
                (KeyD, Action::LightRight),
                (KeyF, Action::Fullscreen),
            ],
        )
    }

    /// Keys that are the same in every map, and those of one.
    fn with_common_keys(name: &'static str, keys: &[(KeyCode, Action)]) -> Self {
        let common = [
            (Trigger::Drag(MouseButton::Right), Action::Look),
            (Trigger::Wheel, Action::Speed),
            (Trigger::Key(KeyCode::ShiftLeft), Action::Fast),
            (Trigger::Key(KeyCode::ControlLeft), Action::Slow),
            (Trigger::Key(KeyCode::Backspace), Action::Return),
            (Trigger::Key(KeyCode::Space), Action::Pause),
            (Trigger::Key(KeyCode::Period), Action::Step),
            (Trigger::Key(KeyCode::F1), Action::Help),
            (Trigger::Key(KeyCode::Tab), Action::Panels),
            (Trigger::Key(KeyCode::F2), Action::Panels),
            (Trigger::Key(KeyCode::F4), Action::Profiler),
            (Trigger::Key(KeyCode::F11), Action::Fullscreen),
            (Trigger::Key(KeyCode::F12), Action::Screenshot),
            // As in the 2008 report, in every map.
            (Trigger::Digit, Action::Levels),
            (Trigger::Key(KeyCode::Escape), Action::NoLevels),
        ];
        let own = keys
            .iter()
            .map(|&(key, action)| (Trigger::Key(key), action));
        Self {
            name,
            bindings: own.chain(common).collect(),
        }
    }

    /// What triggers an action, in the order of the table.
    pub fn triggers(&self, action: Action) -> impl Iterator<Item = Trigger> + '_ {
        self.bindings
            .iter()
            .filter(move |(_, bound)| *bound == action)
            .map(|(trigger, _)| *trigger)
    }

    /// Whether a key or button of the action is held.
    pub fn is_down(&self, action: Action, input: &Input) -> bool {
        self.triggers(action).any(|trigger| match trigger {
            Trigger::Key(key) => input.is_down(key),
            Trigger::Drag(button) => input.is_button_down(button),
            Trigger::Wheel | Trigger::Digit => false,
        })
    }

    /// Whether a key of the action went down since the last frame.
    pub fn is_pressed(&self, action: Action, input: &Input) -> bool {
        self.triggers(action)
            .any(|trigger| matches!(trigger, Trigger::Key(key) if input.is_pressed(key)))
    }

    /// The digit that went down since the last frame if digits do this; the least of several.
    pub fn pressed_digit(&self, action: Action, input: &Input) -> Option<u32> {
        self.triggers(action)
            .find(|&trigger| trigger == Trigger::Digit)?;
        let is_pressed = |keys: &[KeyCode; 2]| keys.iter().any(|&key| input.is_pressed(key));
        (0..)
            .zip(&DIGITS)
            .find(|(_, keys)| is_pressed(keys))
            .map(|(digit, _)| digit)
    }

    /// 1 where `plus` is held, -1 where `minus` is, 0 where both or neither are.
    pub fn axis(&self, plus: Action, minus: Action, input: &Input) -> f64 {
        f64::from(u8::from(self.is_down(plus, input)))
            - f64::from(u8::from(self.is_down(minus, input)))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    fn maps() -> impl Iterator<Item = KeyMap> {
        KeyMap::NAMES
            .iter()
            .map(|name| KeyMap::named(name).expect("every listed name has a map"))
    }

    #[test]
    fn no_trigger_does_two_things() {
        for map in maps() {
            let mut seen = HashSet::new();
            for (trigger, action) in &map.bindings {
                assert!(
                    seen.insert(*trigger),
                    "{}: {trigger} also does {action:?}",
                    map.name
                );
            }
        }
    }

    #[test]
    fn every_action_is_listed_once_and_bound_somewhere() {
        let listed: HashSet<Action> = Action::ALL.into_iter().collect();
        assert_eq!(listed.len(), Action::ALL.len());
        for map in maps() {
            for (_, action) in &map.bindings {
                assert!(listed.contains(action), "{action:?} is not in Action::ALL");
            }
        }
        for action in Action::ALL {
            assert!(
                maps().any(|map| map.triggers(action).next().is_some()),
                "{action:?} has no key in any map"
            );
        }
    }

    #[test]
    fn digits_are_pressed_once_in_every_map() {
        for map in maps() {
            let mut input = Input::default();
            assert_eq!(map.pressed_digit(Action::Levels, &input), None);
            for (digit, keys) in (0..).zip(DIGITS) {
                for key in keys {
                    input.key(key, true);
                    assert_eq!(map.pressed_digit(Action::Levels, &input), Some(digit));
                    assert_eq!(map.pressed_digit(Action::Speed, &input), None);
                    input.end_frame();
                    assert_eq!(map.pressed_digit(Action::Levels, &input), None, "held");
                    input.key(key, false);
                }
            }
        }
    }

    #[test]
    fn keys_are_called_what_is_written_on_them() {
        let names = [
            KeyCode::KeyW,
            KeyCode::Period,
            KeyCode::F12,
            KeyCode::ControlLeft,
        ];
        assert_eq!(names.map(key_name), ["W", ".", "F12", "Ctrl"]);
    }
}
