//! The engine: a world, and the schedule that takes it through one frame.
//!
//! Windowed and headless runs share this; they differ in the plugins they add and in who calls
//! [`Engine::frame`].

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{IntoScheduleConfigs, ScheduleConfigs};
use bevy_ecs::system::ScheduleSystem;

use crate::profile::{forget, ledger};
use crate::schedule::{FrameSet, frame_schedule};

/// A world and its frame.
pub struct Engine {
    /// Entities and resources.
    pub world: World,
    schedule: Schedule,
}

impl Default for Engine {
    fn default() -> Self {
        Self::new()
    }
}

impl Engine {
    /// An engine with the world's components, time, extraction and the tracer's three steps;
    /// no scene, no tracer, no window yet.
    pub fn new() -> Self {
        let mut engine = Self {
            world: World::new(),
            schedule: frame_schedule(),
        };
        for plugin in [
            crate::time::plugin,
            crate::world::plugin,
            crate::frame::plugin,
            crate::trace::plugin,
            crate::scene::plugin,
        ] {
            plugin(&mut engine);
        }
        engine
    }

    /// Adds what a module brings.
    pub fn add_plugin(&mut self, plugin: impl FnOnce(&mut Self)) -> &mut Self {
        plugin(self);
        self
    }

    /// Adds systems to a set of the frame.
    pub fn add_systems<M>(
        &mut self,
        set: FrameSet,
        systems: impl IntoScheduleConfigs<ScheduleSystem, M>,
    ) -> &mut Self {
        let systems: ScheduleConfigs<ScheduleSystem> = systems.in_set(set);
        self.schedule.add_systems(systems);
        self
    }

    /// Orders the systems now and reports a cycle or an ambiguous pair instead of failing in the first frame.
    ///
    /// # Errors
    /// What bevy_ecs found wrong with the schedule, as text.
    pub fn validate(&mut self) -> Result<(), String> {
        self.schedule
            .initialize(&mut self.world)
            .map(|_| ())
            .map_err(|error| error.to_string(self.schedule.graph(), &self.world))
    }

    /// Runs one frame.
    pub fn frame(&mut self) {
        forget();
        // What was written since the last frame bears a tick before this one's systems.
        let before = self.world.increment_change_tick();
        self.schedule.run(&mut self.world);
        ledger::note(&mut self.world, &self.schedule, before);
        self.world.clear_trackers();
    }
}
