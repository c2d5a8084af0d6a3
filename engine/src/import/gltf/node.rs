//! The tree of nodes: poses first, so that skins can name them, then what stands at them.

use std::collections::HashMap;

use glam::{DAffine3, DMat3, DQuat, DVec3, Mat4};
use gltf::scene::Transform as Given;

use super::file::File;
use super::light::{camera_of, light_of};
use super::primitive::Parts;
use crate::import::{Model, Node};
use crate::world::{FARTHEST, Shear, Transform};

/// Nodes below each other; deeper ones are left out.
const DEEPEST: usize = 1024;

/// Rows of [`Model::nodes`] by the file's own numbers.
pub type Rows = HashMap<usize, usize>;

/// Puts the nodes of the scene into the model, parents first.
pub fn read_nodes(file: &File, model: &mut Model) -> Rows {
    let document = &file.document;
    let scene = document
        .default_scene()
        .or_else(|| document.scenes().next());
    let roots: Vec<gltf::Node> = match scene {
        Some(scene) => scene.nodes().collect(),
        None => {
            let children = document.nodes().flat_map(|node| node.children());
            let below: std::collections::HashSet<usize> =
                children.map(|node| node.index()).collect();
            let is_root = |node: &gltf::Node| !below.contains(&node.index());
            document.nodes().filter(is_root).collect()
        }
    };
    let mut rows = Rows::new();
    let mut open: Vec<(gltf::Node, Option<usize>, usize)> = Vec::new();
    open.extend(roots.into_iter().rev().map(|root| (root, None, 0)));
    while let Some((node, parent, depth)) = open.pop() {
        let index = node.index();
        if rows.contains_key(&index) {
            model.warnings.push(format!(
                "nodes[{index}]: it has two places; the first is kept"
            ));
            continue;
        }
        if depth == DEEPEST {
            let warning = format!("nodes[{index}]: more than {DEEPEST} nodes below each other");
            model.warnings.push(warning);
            continue;
        }
        let (pose, shear) = pose_of(&node).unwrap_or_else(|| {
            model.warnings.push(format!(
                "nodes[{index}]: its pose is not finite; it is left out"
            ));
            Default::default()
        });
        let row = model.add_node(Node {
            name: name_of(&node),
            parent,
            pose,
            shear,
            ..Node::default()
        });
        rows.insert(index, row);
        let mut children: Vec<_> = node
            .children()
            .map(|child| (child, Some(row), depth + 1))
            .collect();
        children.reverse();
        open.append(&mut children);
    }
    rows
}

/// What people read: the node's name, else its mesh's, else its number.
fn name_of(node: &gltf::Node) -> String {
    let mesh = node.mesh();
    let given = node.name().or(mesh.as_ref().and_then(gltf::Mesh::name));
    match given.filter(|name| !name.is_empty()) {
        Some(name) => name.to_owned(),
        None => format!("node {}", node.index()),
    }
}

/// Puts meshes, cameras and lights at the nodes.
pub fn fill_nodes(file: &File, rows: &Rows, parts: &mut Parts, model: &mut Model) {
    for node in file.document.nodes() {
        let Some(&row) = rows.get(&node.index()) else {
            continue;
        };
        let place = |what: &str| format!("nodes[{}]: its {what} makes none", node.index());
        let mut contents = parts.of_node(&node, model);
        if let Some(camera) = node.camera() {
            match camera_of(&file.document.as_json().cameras[camera.index()]) {
                Some(camera) => contents.push(camera),
                None => model.warnings.push(place("camera")),
            }
        }
        if let Some(light) = node.light() {
            match light_of(&light) {
                Some(light) => contents.push(light),
                None => model.warnings.push(place("light")),
            }
        }
        model.nodes[row].contents = contents;
    }
}

/// The pose, and what it cannot say; none where numbers are not finite or out of all bounds.
fn pose_of(node: &gltf::Node) -> Option<(Transform, Option<Shear>)> {
    match node.transform() {
        Given::Decomposed {
            translation,
            rotation,
            scale,
        } => {
            let rotation = DQuat::from_array(rotation.map(f64::from));
            let pose = Transform {
                translation: DVec3::from_array(translation.map(f64::from)),
                rotation: unit(rotation),
                scale: DVec3::from_array(scale.map(f64::from)),
            };
            let within = |v: DVec3| v.is_finite() && v.abs().max_element() <= FARTHEST;
            let fits = within(pose.translation) && within(pose.scale) && rotation.is_finite();
            fits.then_some((pose, None))
        }
        Given::Matrix { matrix } => {
            let matrix = DAffine3::from_mat4(Mat4::from_cols_array_2d(&matrix).as_dmat4());
            let within = |x: &f64| x.abs() <= FARTHEST;
            let fits = matrix.to_cols_array().iter().all(within);
            fits.then(|| decompose(matrix))
        }
    }
}

/// The turn of a quaternion of any length.
pub fn unit(rotation: DQuat) -> DQuat {
    if rotation.is_finite() && rotation.length_squared() > 0.0 {
        rotation.normalize()
    } else {
        DQuat::IDENTITY
    }
}

/// Translation, rotation and scale where the axes stay at right angles; else the matrix itself as what is left.
fn decompose(matrix: DAffine3) -> (Transform, Option<Shear>) {
    let translation = matrix.translation;
    let linear = matrix.matrix3;
    let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
    let mut scale = DVec3::new(x.length(), y.length(), z.length());
    let right = |a: DVec3, b: DVec3| a.dot(b).abs() <= 1e-6 * a.length() * b.length();
    if scale.min_element() > 0.0 && right(x, y) && right(y, z) && right(z, x) {
        if linear.determinant() < 0.0 {
            scale.x = -scale.x;
        }
        let axes = DMat3::from_cols(x / scale.x, y / scale.y, z / scale.z);
        let pose = Transform {
            translation,
            rotation: DQuat::from_mat3(&axes).normalize(),
            scale,
        };
        return (pose, None);
    }
    let shear = Shear(DAffine3::from_mat3(linear));
    (Transform::from_translation(translation), Some(shear))
}
