//! Nodes, and what stands at them.

use ufbx::{Node as FbxNode, Scene};

use super::light::{camera_of, light_of};
use super::mesh::Shapes;
use super::{number, skin};
use crate::import::{Content, Model, Node};

/// Older files say what is shown in their animations alone, and seem to hide all.
const STATES_VISIBILITY: u32 = 6000;

/// Puts all nodes into the model, node i of the file in row i.
pub fn read(scene: &Scene, shapes: &Shapes, model: &mut Model) {
    for (row, node) in scene.nodes.into_iter().enumerate() {
        let parent = node
            .parent
            .as_ref()
            .map(|parent| parent.element.typed_id as usize);
        let pose = number::pose(&node.local_transform);
        if pose.is_none() {
            model.warnings.push(format!(
                "the pose of node `{}` is not finite; it stands at its parent",
                node.element.name
            ));
        }
        model.nodes.push(Node {
            name: name_of(node),
            // ufbx sorts parents before their children.
            parent: parent.filter(|&parent| parent < row),
            pose: pose.unwrap_or_default(),
            hidden: !node.visible && scene.metadata.version >= STATES_VISIBILITY,
            ..Node::default()
        });
    }
    for (row, node) in scene.nodes.into_iter().enumerate() {
        show_mesh(row, node, shapes, model);
    }
    for (row, node) in scene.nodes.into_iter().enumerate() {
        let light = node.light.as_ref().and_then(|light| light_of(light, scene));
        let camera = node.camera.as_ref().filter(|_| !is_producer(node));
        let camera = camera.and_then(|camera| camera_of(camera));
        for (pose, content) in light.into_iter().chain(camera) {
            model.nodes.push(Node {
                name: name_of(node),
                parent: Some(row),
                pose,
                contents: vec![content],
                ..Node::default()
            });
        }
    }
}

fn name_of(node: &FbxNode) -> String {
    match node.is_root {
        true => "root".into(),
        false => node.element.name.to_string(),
    }
}

/// Whether a camera is one of the views of the editor that wrote the file: older exporters store them among the scene's.
fn is_producer(node: &FbxNode) -> bool {
    node.element.name.starts_with("Producer ")
}

/// The parts of a node's mesh, with the materials that this node gives them.
fn show_mesh(row: usize, node: &FbxNode, shapes: &Shapes, model: &mut Model) {
    let Some(mesh) = &node.mesh else { return };
    let parts = shapes.of(mesh);
    if parts.is_empty() {
        return;
    }
    let skin = skin::joints(mesh, row).map(|joints| {
        model.skins.push(joints);
        model.skins.len() - 1
    });
    for &(slot, part) in parts {
        let material = node
            .materials
            .get(slot)
            .map(|material| material.element.typed_id as usize)
            .filter(|&material| material < model.materials.len());
        model.nodes[row].contents.push(Content::Part {
            part,
            material,
            skin: skin.filter(|_| model.parts[part].binding.is_some()),
        });
    }
}
