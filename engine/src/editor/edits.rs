//! What waits to be done to the scene, and the one system that does it: commands, undo and redo, in order.

use std::path::PathBuf;

use bevy_ecs::prelude::*;

use super::history::{self, Command, History};
use super::{EditorState, Notices, document, playing};

/// A wish that waits.
#[derive(Debug)]
pub enum Wish {
    /// A command, as a step of its own or of a group.
    Do {
        /// What.
        command: Command,
        /// What the step is called; none: as the command calls itself.
        name: Option<String>,
        /// Commands of the same group make one step until the group is closed: a drag.
        group: Option<String>,
    },
    /// So many steps back.
    Undo(usize),
    /// So many steps forth.
    Redo(usize),
    /// What comes later joins no group that is open now.
    CloseGroup,
    /// Write the scene's file; ask for one where there is none.
    Save,
    /// Ask for a file to save to.
    AskWhere,
    /// Save to this file, which is the scene's from then on.
    SaveAs(PathBuf),
    /// Load the scene's file again.
    Revert,
    /// Take up the edits that an earlier run left.
    Recover,
    /// Let go of the edits that an earlier run left.
    DropLeft,
    /// Back to the moment before the clock began to run.
    Back {
        /// What was edited since stays.
        keeps_edits: bool,
    },
}

/// Wishes that wait for [`crate::schedule::FrameSet::Edit`], in order.
#[derive(Resource, Debug, Default)]
pub struct EditQueue(pub Vec<Wish>);

impl EditQueue {
    /// Asks for a command, as a step of its own.
    pub fn push(&mut self, command: Command) {
        self.0.push(Wish::Do {
            command,
            name: None,
            group: None,
        });
    }

    /// Asks for a command that is part of a drag; the group is closed by [`Wish::CloseGroup`].
    pub fn push_dragged(&mut self, command: Command, name: Option<String>, group: String) {
        self.0.push(Wish::Do {
            command,
            name,
            group: Some(group),
        });
    }
}

/// Does all that was asked for. What cannot be done is said and changes nothing.
pub(super) fn apply_edits(world: &mut World) {
    let wishes = std::mem::take(&mut world.resource_mut::<EditQueue>().0);
    for wish in wishes {
        match wish {
            Wish::Do {
                command,
                name,
                group,
            } => match history::perform(world, command, name, group) {
                Ok(outcome) => {
                    if let Some(select) = outcome.select {
                        let mut state = world.resource_mut::<EditorState>();
                        state.selection.set(select);
                    }
                }
                Err(why) => say(world, format!("Not done: {why}")),
            },
            Wish::Undo(steps) => go(world, steps, "Undone", history::undo),
            Wish::Redo(steps) => go(world, steps, "Done again", history::redo),
            Wish::CloseGroup => world.resource_mut::<History>().close_group(),
            Wish::Save => document::save(world),
            Wish::AskWhere => document::ask(world),
            Wish::SaveAs(path) => document::save_to(world, &path),
            Wish::Revert => document::revert(world),
            Wish::Recover => document::recover(world),
            Wish::DropLeft => document::drop_copy(world),
            Wish::Back { keeps_edits } => {
                let since = playing::go_back(world, keeps_edits);
                go(world, since, "Undone", history::undo);
            }
        }
    }
}

fn go(world: &mut World, steps: usize, said: &str, step: fn(&mut World) -> Option<String>) {
    let names: Vec<String> = (0..steps).map_while(|_| step(world)).collect();
    let words = match names.as_slice() {
        [] => return,
        [name] => format!("{said}: {name}"),
        many => format!("{said}: {} steps", many.len()),
    };
    say(world, words);
}

fn say(world: &mut World, words: String) {
    if let Some(mut notices) = world.get_resource_mut::<Notices>() {
        notices.toast(words);
    }
}
