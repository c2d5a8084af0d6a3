//! Clips of a model to players of the entities it became.

use std::sync::Arc;

use bevy_ecs::prelude::*;

use crate::import::{Content, Model, Node};
use crate::scene::schema::ClipFile;
use crate::world::{
    Camera, Channel, Clip, ClipLayer, ClipPlace, ClipPlayer, ClipSet, Projection, Track,
};

/// All clips of a model, made ready to play on the entities of its nodes, in order, followed by those of the contents
/// that have entities of their own ([`super::model`] lists them so).
pub fn clip_set(model: &Model, clips: Vec<Clip>) -> Arc<ClipSet> {
    let mut own = model.nodes.len();
    let mut first_content = Vec::with_capacity(model.nodes.len());
    for node in &model.nodes {
        first_content.push(own);
        own += own_entities(node);
    }
    let places = |track: &Track| {
        let Some(node) = model.nodes.get(track.target) else {
            return Vec::new();
        };
        if let Some(rest) = rest_of_node(node, track.channel) {
            let target = track.target;
            return vec![ClipPlace { target, rest }];
        }
        let contents = node.contents.iter().enumerate();
        let place = |(i, content)| {
            let target = match own_entities(node) {
                0 => track.target,
                _ => first_content[track.target] + i,
            };
            let rest = rest_of_content(model, content, track.channel)?;
            Some(ClipPlace { target, rest })
        };
        contents.filter_map(place).collect()
    };
    Arc::new(ClipSet::new(clips, places))
}

/// Contents that become children of the node's entity.
pub fn own_entities(node: &Node) -> usize {
    match node.contents.len() {
        1 => 0,
        several => several,
    }
}

/// What a channel holds at rest; none: it is not one of nodes.
fn rest_of_node(node: &Node, channel: Channel) -> Option<Vec<f64>> {
    match channel {
        Channel::Translation => Some(node.pose.translation.to_array().to_vec()),
        Channel::Rotation => Some(node.pose.rotation.to_array().to_vec()),
        Channel::Scale => Some(node.pose.scale.to_array().to_vec()),
        Channel::Shown => Some(vec![if node.hidden { 0.0 } else { 1.0 }]),
        Channel::Weights | Channel::VerticalFov => None,
    }
}

/// What a channel holds at rest; none: it is not one of this content.
fn rest_of_content(model: &Model, content: &Content, channel: Channel) -> Option<Vec<f64>> {
    match (channel, content) {
        (Channel::Weights, &Content::Part { part, .. }) => {
            let morph = model.parts[part].morph.as_ref()?;
            Some(morph.weights.clone())
        }
        (
            Channel::VerticalFov,
            &Content::Camera(Camera {
                projection: Projection::Perspective { vertical_fov },
                ..
            }),
        ) => Some(vec![vertical_fov]),
        _ => None,
    }
}

/// The player of a model with clips.
pub fn player(set: &Arc<ClipSet>, targets: Vec<Entity>, played: &[ClipFile]) -> Option<ClipPlayer> {
    if set.clips().is_empty() {
        return None;
    }
    let layer = |clip: &ClipFile| {
        let mut clips = set.clips().iter();
        let row = match &clip.name {
            Some(name) => clips.position(|clip| clip.name == name.value)?,
            None => 0,
        };
        Some(ClipLayer {
            clip: row,
            ..clip.layer
        })
    };
    Some(ClipPlayer {
        clips: Arc::clone(set),
        targets,
        layers: played.iter().filter_map(layer).collect(),
    })
}
