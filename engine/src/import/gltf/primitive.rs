//! Primitives of meshes to parts: triangles, normals, morph targets, bindings.

use std::collections::HashMap;
use std::sync::Arc;

use glam::Vec3;
use gltf::accessor::Dimensions;
use gltf::mesh::{Mode, Primitive, Semantic};

use super::file::File;
use super::looks::looks_of;
use super::material::Materials;
use super::skin::binding_of;
use crate::import::{Content, Model, Part};
use crate::world::{MeshData, Morph, VertexSets};

/// What a mesh at a node, or a joint that it has there, takes off the numbers a file may ask for.
const AN_ENTITY: usize = 16;

/// Reads each mesh once, however many nodes show it.
pub struct Parts<'a> {
    file: &'a File,
    materials: &'a Materials,
    /// Parts and materials of meshes, by mesh and the bits of the weights that a node gives it.
    read: HashMap<(usize, Vec<u32>), Vec<(usize, usize)>>,
    /// Why the first of those that are broken is left out.
    pub broken: Option<String>,
}

impl<'a> Parts<'a> {
    /// No mesh is read yet.
    pub fn new(file: &'a File, materials: &'a Materials) -> Self {
        Self {
            file,
            materials,
            read: HashMap::new(),
            broken: None,
        }
    }

    /// The parts that a node shows.
    pub fn of_node(&mut self, node: &gltf::Node, model: &mut Model) -> Vec<Content> {
        let Some(mesh) = node.mesh() else {
            return Vec::new();
        };
        let weights = node.weights().or(mesh.weights()).unwrap_or_default();
        let key = (mesh.index(), weights.iter().map(|w| w.to_bits()).collect());
        if !self.read.contains_key(&key) {
            let parts = self.parts_of(&mesh, weights, model);
            self.read.insert(key.clone(), parts);
        }
        let skin = node.skin().map(|skin| skin.index());
        let joints = skin.map_or(0, |skin| model.skins[skin].nodes.len());
        let parts = &self.read[&key];
        // Each becomes an entity, with joints of its own.
        let entities = parts.len().saturating_mul(AN_ENTITY + AN_ENTITY * joints);
        if let Err(why) = self.file.spend(entities) {
            let why = format!("nodes[{}]: {why}", node.index());
            leave_out(&mut self.broken, why, model);
            return Vec::new();
        }
        let contents = parts.iter().map(|&(part, material)| {
            let binding = model.parts[part].binding.as_ref();
            let held = binding.is_some_and(|b| (b.highest_joint() as usize) < joints);
            if skin.is_some() && !held {
                let place = format!("nodes[{}]", node.index());
                let warning = format!("{place}: its mesh names joints that its skin has not");
                model.warnings.push(warning);
            }
            Content::Part {
                part,
                material: Some(material),
                skin: skin.filter(|_| held),
            }
        });
        contents.collect()
    }

    /// The parts of a mesh, with their materials.
    fn parts_of(
        &mut self,
        mesh: &gltf::Mesh,
        weights: &[f32],
        model: &mut Model,
    ) -> Vec<(usize, usize)> {
        let mut parts = Vec::new();
        let several = mesh.primitives().len() > 1;
        for primitive in mesh.primitives() {
            let place = format!("meshes[{}].primitives[{}]", mesh.index(), primitive.index());
            let mut name = mesh.name().unwrap_or("mesh").to_owned();
            if several {
                name = format!("{name} {}", primitive.index());
            }
            match self.part_of(&primitive, (name, weights), (&place, model)) {
                Ok(Some(part)) => {
                    let material = self.materials.row(&primitive.material(), model);
                    parts.push((model.parts.len(), material));
                    model.parts.push(part);
                }
                Ok(None) => {}
                Err(why) => leave_out(&mut self.broken, format!("{place}: {why}"), model),
            }
        }
        parts
    }

    /// A primitive's part; none, and a warning, where it has no triangle. What of it cannot be read beside its triangles is
    /// left out with a warning.
    fn part_of(
        &self,
        primitive: &Primitive,
        (name, weights): (String, &[f32]),
        (place, model): (&str, &mut Model),
    ) -> Result<Option<Part>, String> {
        let within = |why: String| format!("{place}: {why}");
        let Some((positions, sound)) = self.sound(primitive, (place, model))? else {
            return Ok(None);
        };
        let normals = self.normals_of(primitive, &sound.used);
        let normals = normals.unwrap_or_else(|why| {
            model
                .warnings
                .push(within(format!("it is shaded flat: {why}")));
            Vec::new()
        });
        let wanted = self.materials.coordinates(&primitive.material());
        let looks = looks_of(self.file, primitive, &sound.used, wanted);
        let (uvs, colors) = looks.unwrap_or_else(|why| {
            model
                .warnings
                .push(within(format!("its looks are plain: {why}")));
            Default::default()
        });
        let vertices = gather(&positions, &sound.used);
        let vertices = vertices.into_iter().map(|v| v.as_dvec3()).collect();
        let mesh = MeshData::new(name, vertices, normals, sound.triangles)
            .and_then(|mesh| mesh.with_looks(uvs, colors))?;
        let morph = self.morph_of(primitive, &sound.used, weights, (place, model));
        let binding = binding_of(self.file, primitive, &sound.used, (place, model));
        let binding = binding.unwrap_or_else(|why| {
            model
                .warnings
                .push(within(format!("nothing holds its vertices: {why}")));
            None
        });
        Ok(Some(Part {
            mesh,
            morph,
            binding,
            sources: sound.used,
            ..Part::default()
        }))
    }

    /// The positions and the triangles that can be shown; none, and a warning, where there are none.
    fn sound(
        &self,
        primitive: &Primitive,
        (place, model): (&str, &mut Model),
    ) -> Result<Option<(Vec<f32>, Sound)>, String> {
        let mut warn = |why: &str| model.warnings.push(format!("{place}: {why}"));
        let Some(positions) = primitive.get(&Semantic::Positions) else {
            warn("it has no positions; it is left out");
            return Ok(None);
        };
        let positions = self.file.numbers(&positions, Dimensions::Vec3)?;
        let corners = match primitive.indices() {
            Some(indices) => self.file.indices(&indices)?,
            None => (0..positions.len() as u32 / 3).collect(),
        };
        let Some(triangles) = triangles(primitive.mode(), &corners) else {
            warn("it consists of points or lines; it is left out");
            return Ok(None);
        };
        let sound = Sound::new(&positions, triangles);
        if sound.left_out > 0 {
            let left_out = sound.left_out;
            warn(&format!(
                "{left_out} triangles name vertices that are not there or not finite"
            ));
        }
        if sound.triangles.is_empty() {
            warn("it has no triangle; it is left out");
            return Ok(None);
        }
        Ok(Some((positions, sound)))
    }

    /// Unit normals of the vertices that are used; empty where there are none.
    fn normals_of(&self, primitive: &Primitive, used: &[u32]) -> Result<Vec<Vec3>, String> {
        let Some(normals) = primitive.get(&Semantic::Normals) else {
            return Ok(Vec::new());
        };
        let numbers = self.file.numbers(&normals, Dimensions::Vec3)?;
        if numbers.len() < 3 * count_up_to_last(used) {
            return Err("too few normals".into());
        }
        let normals = gather(&numbers, used).into_iter();
        let unit: Option<Vec<Vec3>> = normals.map(Vec3::try_normalize).collect();
        unit.ok_or_else(|| "a normal is zero or not finite".into())
    }

    /// The morph targets; the weights are the node's, else the mesh's, else 0. One that is broken moves nothing, so that the
    /// others keep their weights.
    fn morph_of(
        &self,
        primitive: &Primitive,
        used: &[u32],
        weights: &[f32],
        (place, model): (&str, &mut Model),
    ) -> Option<Morph> {
        let mut values = Vec::new();
        let mut count = 0;
        for target in primitive.morph_targets() {
            let offsets = target.positions();
            let offsets = offsets.map_or(Ok(None), |offsets| self.offsets(&offsets, used));
            let offsets = offsets.unwrap_or_else(|why| {
                let warning = format!("{place}: morph target {count} moves nothing: {why}");
                model.warnings.push(warning);
                None
            });
            match offsets {
                Some(offsets) => values.extend(offsets),
                None if self.file.spend(3 * used.len()).is_ok() => {
                    values.resize(values.len() + used.len(), Vec3::ZERO);
                }
                None => {
                    let warning =
                        format!("{place}: its morph targets are too many; it keeps still");
                    model.warnings.push(warning);
                    return None;
                }
            }
            count += 1;
        }
        if count == 0 {
            return None;
        }
        let weight = |i: usize| {
            weights
                .get(i)
                .copied()
                .filter(|w| w.abs() <= 1e6)
                .unwrap_or(0.0)
        };
        Some(Morph {
            targets: Arc::new(VertexSets {
                vertices: used.len(),
                values,
            }),
            weights: (0..count).map(|i| f64::from(weight(i))).collect(),
        })
    }

    /// How far a morph target moves the vertices that are used.
    fn offsets(
        &self,
        accessor: &gltf::Accessor,
        used: &[u32],
    ) -> Result<Option<Vec<Vec3>>, String> {
        let offsets = self.file.numbers(accessor, Dimensions::Vec3)?;
        if offsets.len() < 3 * count_up_to_last(used) {
            return Err("it has too few offsets".into());
        }
        let offsets = gather(&offsets, used);
        match offsets.iter().all(|offset| offset.is_finite()) {
            true => Ok(Some(offsets)),
            false => Err("an offset is not finite".into()),
        }
    }
}

/// Tells what is left out, and keeps the first reason.
fn leave_out(broken: &mut Option<String>, why: String, model: &mut Model) {
    model.warnings.push(format!("{why}; it is left out"));
    broken.get_or_insert(why);
}

/// Triangles by the corners' own numbers; none for points and lines.
fn triangles(mode: Mode, corners: &[u32]) -> Option<Vec<[u32; 3]>> {
    let each = |i: usize, [a, b, c]: [usize; 3]| [corners[i + a], corners[i + b], corners[i + c]];
    let strips = 0..corners.len().saturating_sub(2);
    Some(match mode {
        Mode::Triangles => corners
            .chunks_exact(3)
            .map(|c| [c[0], c[1], c[2]])
            .collect(),
        // Every other triangle of a strip runs the other way round.
        Mode::TriangleStrip => strips
            .map(|i| each(i, if i % 2 == 0 { [0, 1, 2] } else { [0, 2, 1] }))
            .collect(),
        Mode::TriangleFan => strips
            .map(|i| [corners[i + 1], corners[i + 2], corners[0]])
            .collect(),
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => return None,
    })
}

/// Triangles whose vertices are there, numbered among those that are used.
struct Sound {
    triangles: Vec<[u32; 3]>,
    /// The vertices' own numbers, rising.
    used: Vec<u32>,
    left_out: usize,
}

impl Sound {
    fn new(positions: &[f32], triangles: Vec<[u32; 3]>) -> Self {
        let far = crate::world::FARTHEST as f32;
        let sound = |&corner: &u32| {
            let first = corner as usize * 3;
            let vertex = positions.get(first..first.saturating_add(3));
            vertex.is_some_and(|vertex| vertex.iter().all(|x| x.abs() < far))
        };
        let before = triangles.len();
        let mut triangles = triangles;
        triangles.retain(|triangle| triangle.iter().all(sound));
        let left_out = before - triangles.len();
        // Strips use such triangles to turn corners.
        triangles.retain(|[a, b, c]| a != b && b != c && c != a);
        let mut place = vec![u32::MAX; positions.len() / 3];
        for &corner in triangles.iter().flatten() {
            place[corner as usize] = 0;
        }
        let mut used = Vec::new();
        for (vertex, place) in place
            .iter_mut()
            .enumerate()
            .filter(|(_, place)| **place == 0)
        {
            *place = used.len() as u32;
            used.push(vertex as u32);
        }
        for corner in triangles.iter_mut().flatten() {
            *corner = place[*corner as usize];
        }
        Self {
            triangles,
            used,
            left_out,
        }
    }
}

/// The vectors of the vertices that are used, which are all there.
fn gather(numbers: &[f32], used: &[u32]) -> Vec<Vec3> {
    let vector = |&vertex: &u32| Vec3::from_slice(&numbers[3 * vertex as usize..]);
    used.iter().map(vector).collect()
}

/// Vertices up to the last one that is used.
fn count_up_to_last(used: &[u32]) -> usize {
    used.last().map_or(0, |&last| last as usize + 1)
}
