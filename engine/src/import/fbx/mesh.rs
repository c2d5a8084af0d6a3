//! Meshes, parted by material.
//!
//! A vertex of a part is a vertex of the file with a normal, a colour (taken as sRGB) and, where the material has
//! textures, a texture coordinate (FBX's count upward, the engine's downward); what hangs on vertices (skins, blend shapes)
//! goes by the file's vertex, which [`Part::sources`] tells.

use std::collections::HashMap;

use glam::{DVec3, Vec2, Vec3, Vec4};
use ufbx::{Mesh, MeshPart, Scene};

use super::{cache, morph, number, skin};
use crate::import::{Files, Model, Part, Warnings};
use crate::world::{FARTHEST, MeshData, linear_light};

/// Which parts of the model the meshes of the file became.
pub struct Shapes {
    /// By mesh: the slot of the material and the row of [`Model::parts`].
    parts: Vec<Vec<(usize, usize)>>,
}

impl Shapes {
    /// The parts of a mesh: slot of the material, row of [`Model::parts`].
    pub fn of(&self, mesh: &Mesh) -> &[(usize, usize)] {
        self.parts
            .get(mesh.element.typed_id as usize)
            .map_or(&[], Vec::as_slice)
    }
}

/// Puts all meshes of a file of so many bytes, beside these, into the model.
pub fn read(scene: &Scene, (size, files): (usize, &Files), model: &mut Model) -> Shapes {
    let mut room = morph::room(size);
    let shapes = scene.meshes.into_iter().map(|mesh| {
        let deform = Deform {
            binding: skin::read(mesh, &mut model.warnings),
            targets: morph::read(mesh),
            poses: cache::read(mesh, files, &mut room, &mut model.warnings),
        };
        let mut parts = Vec::new();
        for (slot, of_material) in mesh.material_parts.iter().enumerate() {
            let textured = is_textured(mesh, slot, model);
            match part_of(mesh, (slot, of_material, textured), &mut model.warnings) {
                Ok(Some(mut part)) => {
                    deform.bind(&mut part, &mut room, &mut model.warnings);
                    parts.push((slot, model.parts.len()));
                    model.parts.push(part);
                }
                Ok(None) => {}
                Err(why) => model
                    .warnings
                    .push(format!("mesh `{}` is left out: {why}", name_of(mesh))),
            }
        }
        parts
    });
    Shapes {
        parts: shapes.collect(),
    }
}

/// What moves the vertices of a mesh.
struct Deform<'a> {
    binding: Option<skin::Weights>,
    targets: Vec<morph::Target<'a>>,
    poses: Option<cache::Poses>,
}

impl Deform<'_> {
    fn bind(&self, part: &mut Part, room: &mut usize, warnings: &mut Warnings) {
        let name = part.mesh.name.clone();
        if let Some(poses) = &self.poses {
            part.keys = Some(poses.keys(part));
            return;
        }
        if let Some(weights) = &self.binding {
            match weights.binding(&part.sources) {
                Ok(binding) => part.binding = Some(binding),
                Err(why) => warnings.push(format!("the skin of `{name}` is left out: {why}")),
            }
        }
        match morph::morph(&self.targets, &part.sources, room) {
            Ok(morph) => part.morph = morph,
            Err(why) => warnings.push(format!("the blend shapes of `{name}` are left out: {why}")),
        }
    }
}

fn name_of(mesh: &Mesh) -> String {
    let own = mesh.element.name.to_string();
    match mesh.element.instances.iter().next() {
        Some(node) if own.is_empty() => node.element.name.to_string(),
        _ => own,
    }
}

/// The faces of one material; none: it has none.
fn part_of(
    mesh: &Mesh,
    (slot, of_material, textured): (usize, &MeshPart, bool),
    warnings: &mut Warnings,
) -> Result<Option<Part>, String> {
    let mut weld = Weld::new(mesh, textured);
    let mut triangles = Vec::new();
    for &face in &of_material.face_indices {
        if mesh.face_hole.get(face as usize).copied().unwrap_or(false) {
            continue;
        }
        match cut(mesh, face as usize) {
            Ok(corners) => {
                triangles.extend(
                    corners
                        .into_iter()
                        .map(|t| t.map(|corner| weld.row(corner))),
                );
            }
            Err(why) => warnings.push(format!("a face of `{}` is left out: {why}", name_of(mesh))),
        }
    }
    if triangles.is_empty() {
        return Ok(None);
    }
    let mut name = name_of(mesh);
    if mesh.material_parts.len() > 1 {
        let material = mesh.materials.get(slot);
        let material = material.map_or(String::new(), |m| m.element.name.to_string());
        name = format!("{name} {material}").trim().to_owned();
    }
    if weld.normals.contains(&Vec3::ZERO) {
        if mesh.vertex_normal.exists {
            warnings.push(format!(
                "the normals of `{name}` are left out: one has no direction"
            ));
        }
        weld.normals.clear();
    }
    Ok(Some(Part {
        mesh: MeshData::new(name, weld.vertices, weld.normals, triangles)?
            .with_looks(weld.uvs, weld.colors)?,
        sources: weld.sources,
        ..Part::default()
    }))
}

/// Corners (rows of the file's lists of corners) of the triangles of a face, with its own winding. ufbx cuts faces of
/// tens of thousands of corners, concave ones too, in time that hardly grows faster than they do.
fn cut(mesh: &Mesh, face: usize) -> Result<Vec<[usize; 3]>, String> {
    let face = mesh.faces.get(face).ok_or("there is none")?;
    let first = face.index_begin as usize;
    let count = face.num_indices as usize;
    if count < 3 {
        return Err("it has fewer than three corners".into());
    }
    for corner in first..first + count {
        position(mesh, corner)?;
    }
    let mut corners = vec![0; 3 * (count - 2)];
    let triangles = ufbx::triangulate_face(&mut corners, mesh, *face) as usize;
    let (triangles, _) = corners[..3 * triangles].as_chunks::<3>();
    Ok(triangles
        .iter()
        .map(|t| t.map(|row| row as usize))
        .collect())
}

/// Where a corner is.
fn position(mesh: &Mesh, corner: usize) -> Result<DVec3, String> {
    let positions = &mesh.vertex_position;
    let row = positions.indices.get(corner).copied();
    let place = row.and_then(|row| positions.values.get(row as usize));
    let place = number::vector(*place.ok_or("a corner has no place")?);
    if place.is_finite() && place.abs().max_element() <= FARTHEST {
        Ok(place)
    } else {
        Err("a corner is not finite".into())
    }
}

/// Whether the material of a slot, of the mesh or of a node that shows it, has textures.
fn is_textured(mesh: &Mesh, slot: usize, model: &Model) -> bool {
    let nodes = mesh.element.instances.iter();
    let given = nodes.filter_map(|node| node.materials.get(slot));
    let materials = given.chain(mesh.materials.get(slot));
    materials
        .filter_map(|material| model.materials.get(material.element.typed_id as usize))
        .any(|(_, material)| material.color_map.is_some() || material.normal_map.is_some())
}

/// Vertices in the order of their first use, one for each way in which one of the file's looks.
struct Weld<'a> {
    mesh: &'a Mesh,
    textured: bool,
    rows: HashMap<(u32, [u32; 9]), u32>,
    vertices: Vec<DVec3>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    colors: Vec<Vec4>,
    sources: Vec<u32>,
}

impl<'a> Weld<'a> {
    fn new(mesh: &'a Mesh, textured: bool) -> Self {
        Self {
            mesh,
            textured: textured && mesh.vertex_uv.exists,
            rows: HashMap::new(),
            vertices: Vec::new(),
            normals: Vec::new(),
            uvs: Vec::new(),
            colors: Vec::new(),
            sources: Vec::new(),
        }
    }

    /// The row of a corner whose place is finite.
    fn row(&mut self, corner: usize) -> u32 {
        let source = self.mesh.vertex_indices.get(corner).copied();
        let source = source.filter(|&source| (source as usize) < self.mesh.num_vertices);
        let source = source.unwrap_or_default();
        let (normal, uv, color) = (self.normal(corner), self.uv(corner), self.color(corner));
        let ([a, b, c], [u, v], [r, g, bl, al]) =
            (normal.to_array(), uv.to_array(), color.to_array());
        let key = (source, [a, b, c, u, v, r, g, bl, al].map(f32::to_bits));
        if let Some(&row) = self.rows.get(&key) {
            return row;
        }
        let row = self.vertices.len() as u32;
        self.vertices
            .push(position(self.mesh, corner).unwrap_or_default());
        self.normals.push(normal);
        if self.textured {
            self.uvs.push(uv);
        }
        if self.mesh.vertex_color.exists {
            self.colors.push(color);
        }
        self.sources.push(source);
        self.rows.insert(key, row);
        row
    }

    /// Unit length, or zero.
    fn normal(&self, corner: usize) -> Vec3 {
        let normals = &self.mesh.vertex_normal;
        let row = normals.indices.get(corner).copied();
        let normal = row.and_then(|row| normals.values.get(row as usize));
        let normal = normal.map_or(DVec3::ZERO, |normal| number::vector(*normal));
        // Adding zero makes -0 the same as 0.
        normal.normalize_or_zero().as_vec3() + Vec3::ZERO
    }

    /// Zero where there is none.
    fn uv(&self, corner: usize) -> Vec2 {
        if !self.textured {
            return Vec2::ZERO;
        }
        let uvs = &self.mesh.vertex_uv;
        let row = uvs.indices.get(corner).copied();
        let uv = row.and_then(|row| uvs.values.get(row as usize));
        let uv = uv.map_or(Vec2::ZERO, |uv| Vec2::new(uv.x as f32, (1.0 - uv.y) as f32));
        if uv.is_finite() { uv } else { Vec2::ZERO }
    }

    /// White where there is none.
    fn color(&self, corner: usize) -> Vec4 {
        let colors = &self.mesh.vertex_color;
        let row = colors.indices.get(corner).copied();
        let color = row.and_then(|row| colors.values.get(row as usize));
        let color = color.map_or(Vec4::ONE, |color| {
            let linear = |c: f64| linear_light(c.clamp(0.0, 1.0)) as f32;
            let [r, g, b] = [color.x, color.y, color.z].map(linear);
            Vec4::new(r, g, b, color.w.clamp(0.0, 1.0) as f32)
        });
        if color.is_finite() { color } else { Vec4::ONE }
    }
}
