//! Statements that fill surfaces, and those that make them.

use glam::{DVec3, Vec3};

use super::batch::{Batch, Corner};
use super::look::Fill;
use super::stage::Stage;
use super::words::Words;
use crate::import::{Content, Part, Solid};
use crate::world::{Cone, Cylinder, MeshData, Sphere, Transform};

impl Stage<'_> {
    /// `f`: files of other programs leave numbers at the end out, or name a texture.
    pub(super) fn fill_of_nff(&mut self, words: &mut Words) -> Result<(), String> {
        let color = words.color("a fill's red, green, blue")?;
        let mut rest = [1.0, 0.0, 1.0, 0.0, 1.0];
        for (number, what) in rest.iter_mut().zip(["Kd", "Ks", "Shine", "T", "ior"]) {
            if !words.is_number_next() {
                break;
            }
            *number = words.number(what)?;
        }
        let [kd, ks, shine, transmittance, ior] = rest;
        if let Some(texture) = words.next_on_line() {
            self.textures.insert(texture.to_owned());
        }
        self.set_fill(Fill {
            color,
            diffuse: kd.clamp(0.0, 1e6) as f32,
            ambient: None,
            specular: Vec3::splat(ks.clamp(0.0, 1e6) as f32),
            shine: shine.clamp(0.0, 1e9) as f32,
            transmittance: transmittance as f32,
            ior,
        });
        Ok(())
    }

    /// `fm`.
    pub(super) fn fill_of_aff(&mut self, words: &mut Words) -> Result<(), String> {
        let ambient = words.color("an ambient red, green, blue")?;
        let color = words.color("a diffuse red, green, blue")?;
        let specular = words.color("a specular red, green, blue")?;
        let shine = words.number("a shine")?.clamp(0.0, 1e9) as f32;
        let transmittance = words.number("a transmittance")? as f32;
        let ior = words.number("an index of refraction")?;
        self.set_fill(Fill {
            color,
            diffuse: 1.0,
            ambient: Some(ambient),
            specular,
            shine,
            transmittance,
            ior,
        });
        Ok(())
    }

    fn set_fill(&mut self, fill: Fill) {
        let row = self.fills.iter().position(|known| *known == fill);
        self.fill = Some(row.unwrap_or_else(|| {
            self.fills.push(fill);
            self.fills.len() - 1
        }));
    }

    fn solid(&mut self, at: DVec3, name: &str, solid: Solid) -> Result<(), String> {
        let content = Content::Solid {
            solid,
            material: self.fill,
        };
        let pose = Transform::from_translation(at);
        self.node(name, pose, vec![content]).map(drop)
    }

    pub(super) fn sphere(&mut self, words: &mut Words) -> Result<(), String> {
        let center = words.point("a sphere's centre")?;
        let radius = words.number("a sphere's radius")?.abs();
        if !(radius > 0.0) {
            self.leave_out(words, "sphere", "its radius is 0");
            return Ok(());
        }
        self.solid(center, "sphere", Solid::Sphere(Sphere { radius }))
    }

    pub(super) fn cone(&mut self, words: &mut Words) -> Result<(), String> {
        let base = words.point("a cone's base")?;
        let radius_a = words.number("the base's radius")?.abs();
        let apex = words.point("a cone's apex")?;
        let radius_b = words.number("the apex's radius")?.abs();
        let b = apex - base;
        if b == DVec3::ZERO || !(radius_a + radius_b > 0.0) {
            self.leave_out(words, "cone", "it has no length or no width");
            return Ok(());
        }
        // About its base, so that its numbers keep their digits far from the origin.
        let a = DVec3::ZERO;
        if radius_a == radius_b {
            let cylinder = Cylinder {
                a,
                b,
                radius: radius_a,
                open: true,
            };
            return self.solid(base, "cylinder", Solid::Cylinder(cylinder));
        }
        let cone = Cone {
            a,
            radius_a,
            b,
            radius_b,
            open: true,
        };
        self.solid(base, "cone", Solid::Cone(cone))
    }

    pub(super) fn polygon(&mut self, words: &mut Words, is_patch: bool) -> Result<(), String> {
        let count = words.count("corners", if is_patch { 12 } else { 6 })?;
        let mut corners: Vec<Corner> = Vec::with_capacity(count);
        for _ in 0..count {
            let place = words.point("a corner")?;
            corners.push((place, self.normal(words, is_patch)?));
        }
        self.add_polygon(words, &corners)
    }

    /// A unit normal, or zero where the shape has none.
    pub(super) fn normal(&self, words: &mut Words, is_there: bool) -> Result<Vec3, String> {
        if !is_there {
            return Ok(Vec3::ZERO);
        }
        Ok(words.vector("a normal")?.normalize_or_zero().as_vec3())
    }

    pub(super) fn textured_triangle(
        &mut self,
        words: &mut Words,
        is_patch: bool,
    ) -> Result<(), String> {
        let texture = words.word("the name of a texture")?;
        self.textures.insert(texture.to_owned());
        let mut corners = [Corner::default(); 3];
        for corner in &mut corners {
            corner.0 = words.point("a corner")?;
            corner.1 = self.normal(words, is_patch)?;
            words.number("a texture coordinate")?;
            words.number("a texture coordinate")?;
        }
        self.add_polygon(words, &corners)
    }

    fn add_polygon(&mut self, words: &Words, corners: &[Corner]) -> Result<(), String> {
        let key = (self.fill, corners.iter().any(|c| c.1 != Vec3::ZERO));
        let Some(scope) = self.scopes.last_mut() else {
            return Ok(());
        };
        let batch = scope.batches.entry(key).or_default();
        let full = batch.is_full().then(|| std::mem::take(batch));
        match batch.add(corners) {
            Ok(false) => {}
            Ok(true) => {
                let warning = "a polygon crosses itself; it is cut into triangles that fold over";
                let warning = format!("{}: {warning}", words.place());
                self.model.warnings.push(warning);
            }
            Err(why) => self.leave_out(words, "polygon", &why),
        }
        match full {
            Some(batch) => self.part_of(batch, key.0),
            None => Ok(()),
        }
    }

    fn leave_out(&mut self, words: &Words, what: &str, why: &str) {
        let warning = format!("{}: a {what} is left out: {why}", words.place());
        self.model.warnings.push(warning);
    }

    /// Makes parts of what stands below the transform that reading is inside of.
    pub(super) fn make_parts(&mut self) -> Result<(), String> {
        let Some(scope) = self.scopes.last_mut() else {
            return Ok(());
        };
        let batches = std::mem::take(&mut scope.batches);
        let moving = std::mem::take(&mut scope.moving);
        for ((fill, _), batch) in batches {
            self.part_of(batch, fill)?;
        }
        for (fill, moving) in moving {
            if let Some(part) = moving.part()? {
                self.show_new(part, fill)?;
            }
        }
        Ok(())
    }

    fn part_of(&mut self, batch: Batch, fill: Option<usize>) -> Result<(), String> {
        match batch.mesh("polygons")? {
            Some(mesh) => self.show_new(part_of_mesh(mesh), fill),
            None => Ok(()),
        }
    }

    pub(super) fn show_new(&mut self, part: Part, fill: Option<usize>) -> Result<(), String> {
        self.model.parts.push(part);
        self.show(self.model.parts.len() - 1, fill)
    }

    fn show(&mut self, part: usize, material: Option<usize>) -> Result<(), String> {
        let content = Content::Part {
            part,
            material,
            skin: None,
        };
        let name = self.model.parts[part].mesh.name.clone();
        self.node(&name, Transform::IDENTITY, vec![content])
            .map(drop)
    }

    /// `m`: once a place of a file, however often it is included.
    pub(super) fn mesh(&mut self, words: &mut Words) -> Result<(), String> {
        let key = (words.file().to_owned(), words.left());
        let part = match self.meshes.get(&key) {
            Some(&(part, end)) => {
                words.go_to(end);
                part
            }
            None => {
                let part = self.new_mesh(words)?;
                self.meshes.insert(key, (part, words.mark()));
                part
            }
        };
        part.map_or(Ok(()), |part| self.show(part, self.fill))
    }

    fn new_mesh(&mut self, words: &mut Words) -> Result<Option<usize>, String> {
        words.expect("vertices")?;
        let count = words.count("vertices", 6)?;
        let vertices = read_all(count, || words.point("a vertex"))?;
        let mut normals = Vec::new();
        let mut has_texture = false;
        loop {
            match words.word("`triangles`")? {
                "normals" => {
                    let count = words.count("normals", 6)?;
                    normals = read_all(count, || self.normal(words, true))?;
                }
                "texturecoords" => {
                    let count = words.count("texture coordinates", 4)?;
                    let texture = words.word("the name of a texture")?;
                    self.textures.insert(texture.to_owned());
                    read_all(2 * count, || words.number("a texture coordinate"))?;
                    has_texture = true;
                }
                "triangles" => break,
                other => {
                    return Err(words.wrong("`normals`, `texturecoords` or `triangles`", other));
                }
            }
        }
        let count = words.count("triangles", 6)?;
        let mut batch = Batch::default();
        for _ in 0..count {
            let places = [(); 3].map(|()| words.index("a vertex", &vertices));
            let mut corners = [Corner::default(); 3];
            for (corner, place) in corners.iter_mut().zip(places) {
                corner.0 = place?;
            }
            if !normals.is_empty() {
                for corner in &mut corners {
                    corner.1 = words.index("a normal", &normals)?;
                }
            }
            if has_texture {
                for _ in 0..3 {
                    words.number("a texture coordinate's number")?;
                }
            }
            if let Err(why) = batch.add(&corners) {
                self.leave_out(words, "triangle", &why);
            }
        }
        let Some(mesh) = batch.mesh(words.file())? else {
            self.leave_out(words, "mesh", "it has no triangle");
            return Ok(None);
        };
        self.model.parts.push(part_of_mesh(mesh));
        Ok(Some(self.model.parts.len() - 1))
    }
}

/// So many values. The count has been checked against the bytes that are left.
fn read_all<T>(
    count: usize,
    mut read: impl FnMut() -> Result<T, String>,
) -> Result<Vec<T>, String> {
    (0..count).map(|_| read()).collect()
}

/// A part that is the pose of no other.
pub fn part_of_mesh(mesh: MeshData) -> Part {
    Part {
        mesh,
        ..Part::default()
    }
}
