//! Wavefront OBJ with MTL through the `tobj` crate. Called by the scene loader.
//!
//! Each object or group and each material in it becomes one mesh. Faces of more than three corners are cut
//! by ear clipping, so concave ones come out right; points and lines are left out.

mod plain;
mod weld;

use std::cell::RefCell;
use std::collections::{HashMap, HashSet};
use std::path::Path;

use glam::{DVec2, DVec3, Vec2, Vec3, Vec4};
use rayon::prelude::*;

use super::{
    Content, Files, Lie, Model, Node, Outline, Part, Pictures, Warnings, bytes_of, caught,
    material_of, with_pictures,
};
use crate::world::{Material, MeshData, linear_light, triangulate_face};
use plain::{MATERIAL_FILES, plain, plain_materials};
use weld::Weld;

/// Reads an OBJ file and the MTL files it names, which are looked for beside it.
///
/// # Errors
/// A sentence without the file's name: it cannot be opened, or has no face. A face that names what is not there or not
/// finite is left out with a warning, and so is a material file that is missing or bad.
pub fn import(path: &Path, files: &Files) -> Result<Model, String> {
    let open = |name: &Path| files.bytes(&files.folder().join(name));
    let mut warnings = Warnings::default();
    let text = text_of(&files.bytes(path)?, &mut warnings);
    read(&text, warnings, files, &open)
}

/// `import` for bytes. `open` gives those of its material files by their names; pictures are in the folder.
///
/// # Errors
/// See `import`.
pub fn read_obj(bytes: &[u8], folder: &Path, open: &Open) -> Result<Model, String> {
    let mut warnings = Warnings::default();
    let text = text_of(bytes, &mut warnings);
    read(&text, warnings, &Files::of_folder(folder), open)
}

/// Gives the bytes of a file beside the model.
type Open<'a> = dyn Fn(&Path) -> Result<Vec<u8>, String> + 'a;

/// The text of a file. What is known to make tobj 4.0 panic is taken out of it; what is not, is caught by those who call
/// importers.
fn text_of(bytes: &[u8], warnings: &mut Warnings) -> String {
    // Some exporters write Latin-1 names; geometry is ASCII.
    plain(&String::from_utf8_lossy(bytes), warnings)
}

fn read(text: &str, warnings: Warnings, files: &Files, open: &Open) -> Result<Model, String> {
    // tobj asks for material files through a shared closure.
    let warnings = RefCell::new(warnings);
    let loaded = tobj::load_obj_buf(&mut text.as_bytes(), &options(), |line| {
        Ok(load_libraries(line, open, &mut warnings.borrow_mut()))
    });
    let (models, materials) =
        loaded.map_err(|error| format!("it is not a valid OBJ file: {error}"))?;
    let mut warnings = warnings.into_inner();
    let mut pictures = Pictures::new(files);
    let mut lies = Vec::new();
    let materials: Vec<(String, _)> = materials
        .unwrap_or_default()
        .iter()
        .map(|mtl| {
            let plain = material_of(mtl);
            let (material, lie) = with_pictures(plain, mtl, &mut pictures, &mut warnings);
            lies.push(lie);
            (mtl.name.clone(), material)
        })
        .collect();
    warn_of_unknown_materials(text, &materials, &mut warnings);
    let mut model = Model {
        textures: pictures.textures,
        materials,
        warnings,
        ..Model::default()
    };
    let white = white_of(&models);
    let group = |source: &tobj::Model| {
        let lie = source.mesh.material_id.and_then(|row| lies.get(row));
        group_of(source, (lie.copied().unwrap_or_default(), white))
    };
    let groups: Vec<_> = models.par_iter().map(group).collect();
    for (source, group) in models.iter().zip(groups) {
        model.warnings.append(group.warnings);
        let (mesh, sources) = match group.mesh {
            Ok(found) => found,
            Err(why) => {
                let warning = format!("the mesh `{}` is left out: {why}", source.name);
                model.warnings.push(warning);
                continue;
            }
        };
        if !mesh.triangles.is_empty() {
            let content = Content::Part {
                part: model.parts.len(),
                material: source
                    .mesh
                    .material_id
                    .filter(|&row| row < model.materials.len()),
                skin: None,
            };
            model.nodes.push(Node {
                name: source.name.clone(),
                contents: vec![content],
                ..Node::default()
            });
            model.parts.push(Part {
                mesh,
                outline: group.outline,
                sources,
                ..Part::default()
            });
        }
    }
    if model.parts.is_empty() {
        let told = model.warnings.sentences();
        let why = std::iter::once("it has no face".to_owned()).chain(told);
        return Err(why.collect::<Vec<_>>().join("; "));
    }
    Ok(model)
}

/// What becomes of a group.
struct Group {
    mesh: Result<(MeshData, Vec<u32>), String>,
    outline: Outline,
    warnings: Warnings,
}

fn group_of(source: &tobj::Model, looks: (Lie, f64)) -> Group {
    let mut warnings = Warnings::default();
    Group {
        mesh: mesh_of(source, looks, &mut warnings),
        outline: outline_of(&source.mesh),
        warnings,
    }
}

fn options() -> tobj::LoadOptions {
    tobj::LoadOptions {
        ignore_points: true,
        ignore_lines: true,
        ..Default::default()
    }
}

/// Faces and places of the vertices of each group that has faces, in the file's order. Materials are not read,
/// but part a group like those of [`import`].
///
/// # Errors
/// A sentence without the file's name: it cannot be opened or is no OBJ.
pub(super) fn outlines(path: &Path) -> Result<Vec<(Outline, Vec<DVec3>)>, String> {
    let text = text_of(&bytes_of(path)?, &mut Warnings::default());
    let loaded = tobj::load_obj_buf(&mut text.as_bytes(), &options(), |_| {
        Ok((Vec::new(), HashMap::new()))
    });
    let (models, _) = loaded.map_err(|error| format!("it is not a valid OBJ file: {error}"))?;
    let parts = models.iter().map(|model| {
        let vertices = points(&model.mesh.positions);
        (outline_of(&model.mesh), vertices)
    });
    Ok(parts
        .filter(|(outline, _)| !outline.corners.is_empty())
        .collect())
}

fn outline_of(mesh: &tobj::Mesh) -> Outline {
    Outline {
        vertices: mesh.positions.len() / 3,
        arities: mesh.face_arities.clone(),
        corners: mesh.indices.clone(),
    }
}

fn points(flat: &[f64]) -> Vec<DVec3> {
    let (points, _) = flat.as_chunks::<3>();
    points.iter().copied().map(DVec3::from_array).collect()
}

/// Says which names of materials are no entry's, where there is any entry: else it is told that there is no file of them.
fn warn_of_unknown_materials(
    text: &str,
    materials: &[(String, Material)],
    warnings: &mut Warnings,
) {
    let named = |key| {
        text.lines()
            .filter_map(move |line: &str| line.strip_prefix(key))
    };
    if materials.is_empty() && named("mtllib ").next().is_some() {
        return;
    }
    let mut known: HashSet<&str> = materials.iter().map(|(name, _)| name.as_str()).collect();
    for name in named("usemtl ") {
        if known.insert(name) {
            warnings.push(format!(
                "there is no material `{name}`; what wears it is plain"
            ));
        }
    }
}

/// Entries of the MTL files that a line names: one, in whose name there may be spaces, or else one a word.
fn load_libraries(line: &Path, open: &Open, warnings: &mut Warnings) -> Library {
    let text = line.to_string_lossy();
    let words: Vec<&str> = text.split_whitespace().take(MATERIAL_FILES).collect();
    if words.len() < 2 || open(line).is_ok() {
        return load_materials(line, open, warnings);
    }
    let (mut entries, mut rows) = Library::default();
    for word in words {
        let (more, named) = load_materials(Path::new(word), open, warnings);
        let before = entries.len();
        rows.extend(named.into_iter().map(|(name, row)| (name, before + row)));
        entries.extend(more);
    }
    (entries, rows)
}

/// Entries of MTL files, and their rows by name.
type Library = (Vec<tobj::Material>, HashMap<String, usize>);

/// Entries of one MTL file; a file that cannot be read is a warning and no entries.
fn load_materials(name: &Path, open: &Open, warnings: &mut Warnings) -> Library {
    let read = open(name).and_then(|bytes| {
        let text = plain_materials(
            &String::from_utf8_lossy(&bytes),
            &name.display().to_string(),
            warnings,
        );
        caught("MTL", || {
            tobj::load_mtl_buf(&mut text.as_bytes())
                .map_err(|error| format!("it is not a valid MTL file: {error}"))
        })
    });
    read.unwrap_or_else(|why| {
        warnings.push(format!("material file {}: {why}", name.display()));
        Default::default()
    })
}

/// Texture coordinates beyond this say nothing.
const FARTHEST_UV: f32 = 1e6;

/// A corner of a face: vertex, texture coordinate and normal.
type Corner = (u32, Option<u32>, Option<u32>);

/// A group's mesh, on which pictures lie so and colours are of this unit, and which vertex of the group each of its vertices is.
fn mesh_of(
    source: &tobj::Model,
    (lie, white): (Lie, f64),
    warnings: &mut Warnings,
) -> Result<(MeshData, Vec<u32>), String> {
    let mesh = &source.mesh;
    let positions = points(&mesh.positions);
    let normals = points(&mesh.normals);
    let (uvs, _) = mesh.texcoords.as_chunks::<2>();
    let uvs: Vec<DVec2> = uvs.iter().map(|&uv| lie.moved(uv.into())).collect();
    let mut weld = Weld::default();
    let mut triangles = Vec::new();
    for corners in faces(source)? {
        match cut(&corners, &positions) {
            Ok((cut, is_twisted)) => {
                if is_twisted {
                    warnings.push(format!(
                        "a face of `{}` crosses itself; it is cut into triangles that fold over",
                        source.name
                    ));
                }
                for triangle in cut {
                    let mut rows = [0; 3];
                    for (row, corner) in rows.iter_mut().zip(triangle) {
                        *row = weld.row(corner, &positions, &uvs, &normals)?;
                    }
                    triangles.push(rows);
                }
            }
            Err(why) => warnings.push(format!("a face of `{}` is left out: {why}", source.name)),
        }
    }
    let mut normals = weld.normals;
    if normals.contains(&Vec3::ZERO) {
        warnings.push(format!(
            "the normals of `{}` are left out: one has no direction",
            source.name
        ));
        normals.clear();
    }
    let mut mesh = MeshData::new(source.name.clone(), weld.vertices, normals, triangles)?;
    mesh.curved = !mesh.normals.is_empty();
    let is_near = |uv: &Vec2| uv.is_finite() && uv.abs().max_element() <= FARTHEST_UV;
    if !weld.uvs.iter().all(is_near) {
        warnings.push(format!(
            "the texture coordinates of `{}` are left out: one is not finite, or far too large",
            source.name
        ));
        weld.uvs.clear();
    }
    let colors = colors_of(&source.mesh.vertex_color, white, &weld.sources);
    let mesh = mesh.with_looks(weld.uvs, colors)?;
    Ok((mesh, weld.sources))
}

/// The white of a file's colours of vertices: 255 where one is clearly above 1, which is what others have.
fn white_of(models: &[tobj::Model]) -> f64 {
    let colors = models.par_iter().map(|model| &model.mesh.vertex_color);
    let most = |flat: &Vec<f64>| flat.iter().copied().fold(0.0, f64::max);
    match colors.map(most).reduce(|| 0.0, f64::max) > 2.0 {
        true => 255.0,
        false => 1.0,
    }
}

/// The colours of vertices, which displays take as they are, from 0 to white. None where one is no number.
fn colors_of(flat: &[f64], white: f64, sources: &[u32]) -> Vec<Vec4> {
    let (colors, _) = flat.as_chunks::<3>();
    let light = |x: f64| linear_light((x / white).clamp(0.0, 1.0)) as f32;
    let color = |&source: &u32| {
        let color = colors.get(source as usize)?;
        let is_color = color.iter().all(|x| x.is_finite());
        is_color.then(|| Vec3::from(color.map(light)).extend(1.0))
    };
    let colors: Option<Vec<Vec4>> = sources.iter().map(color).collect();
    colors.unwrap_or_default()
}

/// The corners of each face; all with a normal, or none; all with a texture coordinate, or none.
fn faces(source: &tobj::Model) -> Result<Vec<Vec<Corner>>, String> {
    let mesh = &source.mesh;
    // With one index for all, tobj leaves the list of normal indices empty.
    let with_normals = !mesh.normals.is_empty() && mesh.normal_indices.len() == mesh.indices.len();
    let with_uvs = !mesh.texcoords.is_empty() && mesh.texcoord_indices.len() == mesh.indices.len();
    let corner = |i: usize| -> Corner {
        let normal = with_normals.then(|| mesh.normal_indices[i]);
        let uv = with_uvs.then(|| mesh.texcoord_indices[i]);
        (mesh.indices[i], uv, normal)
    };
    let arities = if mesh.face_arities.is_empty() {
        vec![3; mesh.indices.len() / 3]
    } else {
        mesh.face_arities.clone()
    };
    let mut first = 0;
    let face = |arity: u32| {
        let range = first..first + arity as usize;
        first = range.end;
        if range.end > mesh.indices.len() {
            return Err(format!(
                "a face of `{}` has fewer corners than it says",
                source.name
            ));
        }
        Ok(range.map(corner).collect())
    };
    arities.into_iter().map(face).collect()
}

/// Triangles of a face with its own winding, and whether it crosses itself.
fn cut(corners: &[Corner], positions: &[DVec3]) -> Result<(Vec<[Corner; 3]>, bool), String> {
    if let &[a, b, c] = corners {
        return Ok((vec![[a, b, c]], false));
    }
    let place = |corner: &Corner| {
        positions.get(corner.0 as usize).copied().ok_or_else(|| {
            format!(
                "it names vertex {}, but there are {}",
                corner.0,
                positions.len()
            )
        })
    };
    let outline: Vec<DVec3> = corners.iter().map(place).collect::<Result<_, _>>()?;
    let cut = triangulate_face(&outline)?;
    let corner = |i: u32| corners[i as usize];
    let triangles = cut.triangles.iter().map(|t| t.map(corner));
    Ok((triangles.collect(), cut.is_twisted))
}

#[cfg(test)]
mod tests;
