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
    /// A key of the editor's, while its panels are open and the camera is not being turned; with these held.
    Tool(Held, KeyCode),
}

/// What has to be held while a tool's key goes down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Held {
    /// Nothing.
    None,
    /// Ctrl.
    Ctrl,
    /// Ctrl and Shift.
    CtrlShift,
    /// Shift.
    Shift,
}

/// The keys of Ctrl.
pub const CTRL: [KeyCode; 2] = [KeyCode::ControlLeft, KeyCode::ControlRight];
/// The keys of Shift.
pub const SHIFT: [KeyCode; 2] = [KeyCode::ShiftLeft, KeyCode::ShiftRight];
/// The keys of Alt.
pub const ALT: [KeyCode; 2] = [KeyCode::AltLeft, KeyCode::AltRight];

impl Held {
    fn of(input: &Input) -> Self {
        match (input.is_held(CTRL), input.is_held(SHIFT)) {
            (false, false) => Self::None,
            (true, false) => Self::Ctrl,
            (true, true) => Self::CtrlShift,
            (false, true) => Self::Shift,
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::None => "",
            Self::Ctrl => "Ctrl+",
            Self::CtrlShift => "Ctrl+Shift+",
            Self::Shift => "Shift+",
        }
    }
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
            Self::Drag(MouseButton::Left) => f.write_str("Click or drag"),
            Self::Drag(button) => write!(f, "{button:?} mouse button"),
            Self::Wheel => f.write_str("Wheel"),
            Self::Digit => f.write_str("1 to 9, 0"),
            Self::Tool(held, key) => write!(f, "{}{}", held.words(), key_name(*key)),
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

/// The editor's keys, the same in every map.
const TOOLS: [(Held, KeyCode, Action); 14] = [
    (Held::Ctrl, KeyCode::KeyZ, Action::Undo),
    (Held::CtrlShift, KeyCode::KeyZ, Action::Redo),
    (Held::Ctrl, KeyCode::KeyY, Action::Redo),
    (Held::Ctrl, KeyCode::KeyS, Action::Save),
    (Held::CtrlShift, KeyCode::KeyS, Action::SaveAs),
    (Held::Ctrl, KeyCode::KeyD, Action::Duplicate),
    (Held::None, KeyCode::Delete, Action::Delete),
    (Held::Ctrl, KeyCode::KeyH, Action::Hide),
    (Held::None, KeyCode::KeyW, Action::Move),
    (Held::None, KeyCode::KeyE, Action::Rotate),
    (Held::None, KeyCode::KeyR, Action::Scale),
    (Held::None, KeyCode::KeyX, Action::Axes),
    (Held::None, KeyCode::KeyF, Action::Focus),
    (Held::Shift, KeyCode::KeyA, Action::Add),
];

/// Which triggers do what. No trigger does two things; a tool's key goes before the same key's other meaning while tools are
/// in hand ([`Input::edits`]).
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
            (Trigger::Drag(MouseButton::Left), Action::Select),
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
        let tools = TOOLS.map(|(held, key, action)| (Trigger::Tool(held, key), action));
        let own = keys
            .iter()
            .map(|&(key, action)| (Trigger::Key(key), action));
        Self {
            name,
            bindings: own.chain(common).chain(tools).collect(),
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
            Trigger::Key(key) => input.is_down(key) && !self.is_tool(key, input),
            Trigger::Drag(button) => input.is_button_down(button),
            Trigger::Wheel | Trigger::Digit | Trigger::Tool(..) => false,
        })
    }

    /// Whether a key of the action went down since the last frame.
    pub fn is_pressed(&self, action: Action, input: &Input) -> bool {
        self.triggers(action).any(|trigger| match trigger {
            Trigger::Key(key) => input.is_pressed(key) && !self.is_tool(key, input),
            Trigger::Tool(held, key) => {
                input.is_pressed(key) && input.edits() && Held::of(input) == held
            }
            Trigger::Drag(_) | Trigger::Wheel | Trigger::Digit => false,
        })
    }

    /// Whether a key is one of the editor's just now, with what is held.
    fn is_tool(&self, key: KeyCode, input: &Input) -> bool {
        let held = Held::of(input);
        let is_it = |trigger: &Trigger| *trigger == Trigger::Tool(held, key);
        input.edits() && self.bindings.iter().any(|(trigger, _)| is_it(trigger))
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
    fn tools_go_before_flight_while_they_are_in_hand() {
        for map in maps() {
            let mut input = Input::default();
            input.key(KeyCode::KeyW, true);
            let flies = [Action::Forward, Action::LightAway];
            let flies = |input: &Input| flies.iter().any(|&a| map.is_down(a, input));
            assert!(flies(&input) && !map.is_pressed(Action::Move, &input));
            input.set_editing(true);
            assert!(!flies(&input) && map.is_pressed(Action::Move, &input));
            input.button(MouseButton::Right, true);
            assert!(flies(&input) && !map.is_pressed(Action::Move, &input));
            input.button(MouseButton::Right, false);
            input.key(KeyCode::ControlRight, true);
            input.key(KeyCode::KeyS, true);
            assert!(map.is_pressed(Action::Save, &input) && !map.is_pressed(Action::Move, &input));
            input.key(KeyCode::ShiftLeft, true);
            assert!(
                map.is_pressed(Action::SaveAs, &input) && !map.is_pressed(Action::Save, &input)
            );
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
