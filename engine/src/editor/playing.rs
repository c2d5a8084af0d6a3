//! Play, and back to the moment before: the clock returns, and with it all that moves with time; what was edited meanwhile
//! stays, or is taken back with the other steps.

use bevy_ecs::prelude::*;

use super::history::History;
use crate::time::{Clock, Time};

/// The moment before the clock last began to run.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct BeforePlay {
    moment: Option<Moment>,
    ran: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Moment {
    secs: f64,
    state: u64,
}

impl BeforePlay {
    /// Whether there is a moment to go back to.
    pub fn is_there(&self) -> bool {
        self.moment.is_some()
    }
}

/// Notes the moment when the clock begins to run; a system of [`crate::schedule::FrameSet::Edit`].
pub fn note_play(
    clock: Res<Clock>,
    time: Res<Time>,
    history: Res<History>,
    mut before: ResMut<BeforePlay>,
) {
    let runs = *clock == Clock::Wall;
    if runs && !before.ran {
        before.moment = Some(Moment {
            secs: time.secs - time.delta_secs,
            state: history.state(),
        });
    }
    if before.ran != runs {
        before.ran = runs;
    }
}

/// Goes back to the moment before play and stands there; how many steps are to be undone for it: edits stay, or do not.
pub fn go_back(world: &mut World, keeps_edits: bool) -> usize {
    let Some(moment) = world.resource::<BeforePlay>().moment else {
        return 0;
    };
    *world.resource_mut::<Clock>() = Clock::Paused;
    world.resource_mut::<Time>().secs = moment.secs;
    world.resource_mut::<BeforePlay>().ran = false;
    if keeps_edits {
        0
    } else {
        edits_since(world, moment.state)
    }
}

/// How many steps were done since the clock began to run.
pub fn edits_while_playing(world: &World) -> usize {
    let moment = world.resource::<BeforePlay>().moment;
    moment.map_or(0, |moment| edits_since(world, moment.state))
}

fn edits_since(world: &World, state: u64) -> usize {
    let history = world.resource::<History>();
    history.steps_since(state).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::app::Engine;
    use crate::editor::history::{self, Command};
    use crate::editor::{EditQueue, EditorState, Wish, edits};
    use crate::schedule::FrameSet;
    use crate::world::{Orbit, Transform, Visibility};

    #[test]
    fn back_brings_the_moment_and_keeps_edits_if_asked_to() {
        for keeps in [true, false] {
            let mut engine = Engine::new();
            engine.world.init_resource::<History>();
            engine.world.init_resource::<EditQueue>();
            engine.world.init_resource::<EditorState>();
            engine.world.init_resource::<BeforePlay>();
            engine.add_systems(FrameSet::Edit, note_play);
            let parts = (Transform::IDENTITY, Orbit::default(), Visibility::default());
            let thing = engine.world.spawn(parts).id();
            engine.frame();
            let place = |engine: &Engine| engine.world.get::<Transform>(thing).unwrap().translation;
            let start = place(&engine);
            *engine.world.resource_mut::<Clock>() = Clock::Wall;
            for _ in 0..4 {
                std::thread::sleep(std::time::Duration::from_millis(5));
                engine.frame();
            }
            assert_ne!(place(&engine), start);
            let hide = Command::show(&[thing], false);
            history::perform(&mut engine.world, hide, None, None).unwrap();
            assert_eq!(edits_while_playing(&engine.world), 1);
            let back = Wish::Back { keeps_edits: keeps };
            engine.world.resource_mut::<EditQueue>().0.push(back);
            edits::apply_edits(&mut engine.world);
            engine.frame();
            assert_eq!(place(&engine), start);
            assert_ne!(start, DVec3::ZERO);
            let shown = engine.world.get::<Visibility>(thing).map(|v| v.shown);
            assert_eq!(shown, Some(!keeps));
        }
    }
}
