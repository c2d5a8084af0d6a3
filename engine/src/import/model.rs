//! What a model file holds, as plain data between importers and the world.
//!
//! Importers fill it, the scene loader spawns it: a node becomes an entity, its contents become components. Rows
//! name rows by their number; every number is in range and every coordinate finite when an importer hands it over.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::{DAffine3, Vec3};
use serde::{Deserialize, Serialize};

use super::Outline;
use crate::world::{
    Camera, Clip, Cone, Cylinder, DirectionalLight, KeyFrames, Material, MeshData, Morph,
    PointLight, Shear, SkinBinding, Sphere, SpotLight, Texture, Transform,
};

/// What a model file holds.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Model {
    /// Parents before their children.
    pub nodes: Vec<Node>,
    /// Meshes that nodes show; none is empty.
    #[serde(with = "crate::pod::parallel")]
    pub parts: Vec<Part>,
    /// Pictures of the file; [`crate::world::TextureId`] of its materials is a row of these.
    #[serde(with = "crate::pod::parallel")]
    pub textures: Vec<Texture>,
    /// The materials of the file, by name.
    pub materials: Vec<(String, Material)>,
    /// Joints that meshes are bound to.
    pub skins: Vec<Joints>,
    /// Animations; [`crate::world::Track::target`] is a row of `nodes`.
    pub clips: Vec<Clip>,
    /// Linear RGB behind everything, where the file says it.
    pub background: Option<Vec3>,
    /// What is odd but did not stop the import.
    pub warnings: Warnings,
}

/// An entity to be.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Node {
    /// What the file calls it; may be empty, need not be unique.
    pub name: String,
    /// Row of [`Model::nodes`], less than this one's.
    pub parent: Option<usize>,
    /// Relative to the parent.
    pub pose: Transform,
    /// What the pose cannot say.
    pub shear: Option<Shear>,
    /// Neither it nor what is below it is shown.
    pub hidden: bool,
    /// What stands here; several become children of the entity.
    pub contents: Vec<Content>,
}

/// Something at a node.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Content {
    /// A mesh.
    Part {
        /// Row of [`Model::parts`].
        part: usize,
        /// Row of [`Model::materials`].
        material: Option<usize>,
        /// Row of [`Model::skins`]; for parts with a binding.
        skin: Option<usize>,
    },
    /// A solid by its numbers.
    Solid {
        /// Which.
        solid: Solid,
        /// Row of [`Model::materials`].
        material: Option<usize>,
    },
    /// A light.
    Point(PointLight),
    /// A light.
    Directional(DirectionalLight),
    /// A light.
    Spot(SpotLight),
    /// An eye.
    Camera(Camera),
}

/// A solid that files hold by its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Solid {
    /// About the node's origin.
    Sphere(Sphere),
    /// Between two points.
    Cylinder(Cylinder),
    /// Between two points.
    Cone(Cone),
}

/// One mesh of a [`Model`].
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Part {
    /// Its triangles.
    pub mesh: MeshData,
    /// The faces as the file has them; empty where no other file can be a pose of this one.
    pub outline: Outline,
    /// Which vertex of the outline each vertex of the mesh is.
    #[serde(with = "crate::pod::array")]
    pub sources: Vec<u32>,
    /// Poses that the file plays through.
    pub keys: Option<KeyFrames>,
    /// Morph targets, and the weights they have at rest.
    pub morph: Option<Morph>,
    /// Which joints of a [`Content::Part`]'s skin hold which vertex.
    #[serde(with = "crate::pod::maybe_shared")]
    pub binding: Option<Arc<SkinBinding>>,
}

/// Joints of a skin.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Joints {
    /// Rows of [`Model::nodes`].
    pub nodes: Vec<usize>,
    /// In the bind pose, one a joint (the inverse bind matrices).
    pub joint_from_mesh: Vec<DAffine3>,
}

/// Sentences about what is odd in a file: a texture that is missing, a face left out. Broken files can have one a
/// face, so only the first few are kept and the rest counted.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Warnings {
    told: Vec<String>,
    untold: usize,
}

impl Model {
    /// Adds a node, and says its row.
    pub fn add_node(&mut self, node: Node) -> usize {
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    /// Triangles of all parts.
    pub fn triangles(&self) -> usize {
        let parts = self.parts.iter();
        parts.map(|part| part.mesh.triangles.len()).sum()
    }

    /// Gives every clip a name of its own, and drops tracks that cannot be played.
    pub(super) fn settle_clips(&mut self) {
        // What a clip is called in the file to how many are called so.
        let mut copies: HashMap<String, usize> = HashMap::new();
        let mut names = HashSet::new();
        for (number, clip) in (1..).zip(&mut self.clips) {
            if clip.name.is_empty() {
                clip.name = format!("clip {number}");
            }
            let name = clip.name.clone();
            let copy = copies.entry(name.clone()).or_insert(1);
            while !names.insert(clip.name.clone()) {
                *copy += 1;
                clip.name = format!("{name} {copy}");
            }
            clip.tracks.retain(|track| {
                let place = match track.target < self.nodes.len() {
                    true => track.check(),
                    false => Err(format!("a track moves node {}", track.target)),
                };
                if let Err(why) = &place {
                    let warning = format!("clip `{}`: {why}; it is left out", clip.name);
                    self.warnings.push(warning);
                }
                place.is_ok()
            });
            if !(clip.start.is_finite() && clip.end >= clip.start && clip.end.is_finite()) {
                clip.start = 0.0;
                clip.end = 0.0;
            }
        }
    }

    /// All that stands anywhere.
    pub fn contents(&self) -> impl Iterator<Item = &Content> {
        self.nodes.iter().flat_map(|node| &node.contents)
    }
}

impl Content {
    /// Whether it is a mesh.
    pub fn is_part(&self) -> bool {
        matches!(self, Self::Part { .. })
    }

    /// Whether rays can meet it.
    pub fn is_visible(&self) -> bool {
        matches!(self, Self::Part { .. } | Self::Solid { .. })
    }

    /// Row of [`Model::materials`] that it wears.
    pub fn material(&self) -> Option<usize> {
        match *self {
            Self::Part { material, .. } | Self::Solid { material, .. } => material,
            _ => None,
        }
    }

    /// Whether it shines.
    pub fn is_light(&self) -> bool {
        matches!(self, Self::Point(_) | Self::Directional(_) | Self::Spot(_))
    }
}

impl Warnings {
    /// Warnings kept for one file.
    const MOST: usize = 20;

    /// Adds a sentence, once.
    pub fn push(&mut self, sentence: impl Into<String>) {
        let sentence = sentence.into();
        if self.told.contains(&sentence) {
            return;
        }
        if self.told.len() < Self::MOST {
            self.told.push(sentence);
        } else {
            self.untold += 1;
        }
    }

    /// Adds those of a part behind its own.
    pub fn append(&mut self, part: Self) {
        for sentence in part.told {
            self.push(sentence);
        }
        self.untold += part.untold;
    }

    /// The sentences; the last one says how many more there were.
    pub fn sentences(&self) -> Vec<String> {
        let rest = (self.untold > 0).then(|| format!("and {} more", self.untold));
        self.told.iter().cloned().chain(rest).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::{Channel, Interpolation, Track};

    #[test]
    fn clips_have_names_of_their_own_and_tracks_that_play() {
        let track = |target, values| Track {
            target,
            channel: Channel::Scale,
            times: vec![0.0],
            values,
            interpolation: Interpolation::Step,
        };
        let clip = |name: &str| Clip {
            name: name.into(),
            tracks: vec![
                track(0, vec![1.0; 3]),
                track(1, vec![1.0; 3]),
                track(0, vec![1.0]),
            ],
            ..Clip::default()
        };
        let mut model = Model {
            clips: ["run", "", "run", "run"].map(clip).to_vec(),
            nodes: vec![Node::default()],
            ..Model::default()
        };
        model.settle_clips();
        let names: Vec<&str> = model.clips.iter().map(|clip| clip.name.as_str()).collect();
        assert_eq!(names, ["run", "clip 2", "run 2", "run 3"]);
        assert!(model.clips.iter().all(|clip| clip.tracks.len() == 1));
        let told = model.warnings.sentences();
        assert_eq!(told[0], "clip `run`: a track moves node 1; it is left out");
    }

    #[test]
    fn warnings_of_parts_are_those_of_the_whole() {
        let sentences = |from: usize| (from..from + 15).map(|face| format!("face {face}"));
        let mut whole = Warnings::default();
        let mut joined = Warnings::default();
        for from in [0, 10, 40, 80] {
            let mut part = Warnings::default();
            sentences(from).for_each(|sentence| part.push(sentence));
            joined.append(part);
            sentences(from).for_each(|sentence| whole.push(sentence));
        }
        assert_eq!(joined, whole);
    }

    #[test]
    fn the_first_warnings_are_told_and_the_rest_counted() {
        let mut warnings = Warnings::default();
        for face in 0..100 {
            warnings.push(format!("face {face}"));
            warnings.push("the same");
        }
        let told = warnings.sentences();
        assert_eq!(told.len(), Warnings::MOST + 1);
        assert_eq!((told[1].as_str(), told[2].as_str()), ("the same", "face 1"));
        assert_eq!(told.last().map(String::as_str), Some("and 81 more"));
    }
}
