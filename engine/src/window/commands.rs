//! Keys that are not flight: pause, step, full screen, screenshot, which panels are open.

use std::path::PathBuf;

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::IntoScheduleConfigs;

use crate::app::Engine;
use crate::editor::{DrawPanels, EditorState};
use crate::input::{Action, HandSet, Input, KeyMap};
use crate::schedule::FrameSet;
use crate::time::{Clock, Time};
use crate::trace::Level;

/// What the keys of this frame ask of the window; it takes them after the frame.
#[derive(Resource, Debug, Default)]
pub struct Requests {
    /// Full screen on or off.
    pub fullscreen: bool,
    /// Save the next frame's picture.
    pub screenshot: bool,
}

/// Adds the keys (set [`FrameSet::Edit`]).
pub fn plugin(engine: &mut Engine) {
    engine.world.init_resource::<Requests>();
    engine.add_systems(FrameSet::Edit, obey_keys.after(HandSet).before(DrawPanels));
}

fn obey_keys(
    mut input: ResMut<Input>,
    keys: Res<KeyMap>,
    time: Res<Time>,
    mut clock: ResMut<Clock>,
    mut editor: ResMut<EditorState>,
    mut requests: ResMut<Requests>,
) {
    let pressed = |action| keys.is_pressed(action, &input);
    if pressed(Action::Pause) {
        *clock = match *clock {
            Clock::Wall => Clock::Paused,
            Clock::Paused | Clock::Frame(_) => Clock::Wall,
        };
    }
    if pressed(Action::Step) {
        *clock = Clock::Frame(time.number() + 1);
    }
    if let Some(digit) = keys.pressed_digit(Action::Levels, &input) {
        editor.toggle_level(Level::of_digit(digit));
    }
    if pressed(Action::NoLevels) {
        editor.level = None;
    }
    editor.help ^= pressed(Action::Help);
    editor.panels ^= pressed(Action::Panels);
    editor.profiler ^= pressed(Action::Profiler);
    requests.fullscreen |= pressed(Action::Fullscreen);
    requests.screenshot |= pressed(Action::Screenshot);
    input.set_editing(editor.panels);
}

/// Where a screenshot of this moment goes: never onto another one.
pub fn screenshot_path(folder: &std::path::Path, scene: &str, time: &Time) -> PathBuf {
    let plain: String = scene
        .chars()
        .map(|c| {
            if c.is_alphanumeric() || c == '-' {
                c
            } else {
                '_'
            }
        })
        .collect();
    let name = format!("{plain}-{:06}", time.number());
    (1..)
        .map(|copy| match copy {
            1 => folder.join(format!("{name}.png")),
            _ => folder.join(format!("{name}-{copy}.png")),
        })
        .find(|path| !path.exists())
        .unwrap_or_else(|| folder.join(format!("{name}.png")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::KeyCode;

    #[test]
    fn a_digit_shows_its_level_and_hides_it_again_in_every_map() {
        for name in KeyMap::NAMES {
            let mut world = World::new();
            world.insert_resource(KeyMap::named(name).expect("every listed name has a map"));
            world.init_resource::<Input>();
            world.init_resource::<Time>();
            world.insert_resource(Clock::Wall);
            world.init_resource::<EditorState>();
            world.init_resource::<Requests>();
            let mut schedule = Schedule::default();
            schedule.add_systems(obey_keys);
            let mut press = |key| {
                world.resource_mut::<Input>().key(key, true);
                schedule.run(&mut world);
                let mut input = world.resource_mut::<Input>();
                input.key(key, false);
                input.end_frame();
                world.resource::<EditorState>().level
            };
            assert_eq!(press(KeyCode::Digit3), Some(Level::Depth(3)), "{name}");
            assert_eq!(press(KeyCode::Space), Some(Level::Depth(3)), "{name}");
            assert_eq!(press(KeyCode::Digit0), Some(Level::Leaves), "{name}");
            assert_eq!(press(KeyCode::Numpad0), None, "{name}");
            assert_eq!(press(KeyCode::Numpad9), Some(Level::Depth(9)), "{name}");
            assert_eq!(press(KeyCode::Escape), None, "{name}");
            assert_eq!(press(KeyCode::Escape), None, "{name}");
        }
    }

    #[test]
    fn screenshots_are_named_by_scene_and_frame_and_keep_each_other() {
        let folder = std::env::temp_dir().join(format!("orrery-shots-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let time = Time {
            secs: 7.0 / 30.0,
            ..Time::default()
        };
        let first = screenshot_path(&folder, "two spheres", &time);
        assert_eq!(first, folder.join("two_spheres-000007.png"));
        std::fs::write(&first, "taken").unwrap();
        let second = screenshot_path(&folder, "two spheres", &time);
        assert_eq!(second, folder.join("two_spheres-000007-2.png"));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
