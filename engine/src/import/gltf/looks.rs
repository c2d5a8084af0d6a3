//! What surfaces look like from vertex to vertex: texture coordinates and colours.

use glam::{Mat2, Vec2, Vec4};
use gltf::accessor::Dimensions;
use gltf::mesh::{Primitive, Semantic};

use super::file::File;

/// Which texture coordinates a material takes, and what becomes of them (KHR_texture_transform).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinates {
    set: u32,
    offset: Vec2,
    /// Radians.
    rotation: f32,
    scale: Vec2,
}

impl Coordinates {
    /// Those of a texture.
    pub fn of(texture: &gltf::texture::Info) -> Self {
        let plain = Self::of_set(texture.tex_coord());
        match texture.texture_transform() {
            None => plain,
            Some(transform) => Self {
                set: transform.tex_coord().unwrap_or(plain.set),
                offset: transform.offset().into(),
                rotation: transform.rotation(),
                scale: transform.scale().into(),
            },
        }
    }

    /// Those of a set, as they are.
    pub fn of_set(set: u32) -> Self {
        Self {
            set,
            offset: Vec2::ZERO,
            rotation: 0.0,
            scale: Vec2::ONE,
        }
    }

    /// Where a coordinate comes to lie: scaled, turned counter-clockwise (down is up here), moved.
    fn moved(&self, uv: Vec2) -> Vec2 {
        Mat2::from_angle(-self.rotation) * (uv * self.scale) + self.offset
    }
}

/// The texture coordinates that the material wants, and the colours, of the vertices `used`; empty where there are none.
///
/// # Errors
/// What of them does not fit the vertices, or is not finite.
pub fn looks_of(
    file: &File,
    primitive: &Primitive,
    used: &[u32],
    wanted: Option<Coordinates>,
) -> Result<(Vec<Vec2>, Vec<Vec4>), String> {
    let uvs = match wanted {
        Some(wanted) => uvs_of(file, primitive, used, wanted)?,
        None => Vec::new(),
    };
    let colors = colors_of(file, primitive, used)?;
    let finite = uvs.iter().all(|uv| uv.is_finite()) && colors.iter().all(|c| c.is_finite());
    match finite {
        true => Ok((uvs, colors)),
        false => Err("a texture coordinate or a colour is not finite".into()),
    }
}

fn uvs_of(
    file: &File,
    primitive: &Primitive,
    used: &[u32],
    wanted: Coordinates,
) -> Result<Vec<Vec2>, String> {
    let Some(accessor) = primitive.get(&Semantic::TexCoords(wanted.set)) else {
        return Ok(Vec::new());
    };
    let numbers = file.numbers(&accessor, Dimensions::Vec2)?;
    let (pairs, _) = numbers.as_chunks::<2>();
    let uv = |&vertex: &u32| {
        pairs
            .get(vertex as usize)
            .map(|&pair| wanted.moved(pair.into()))
    };
    let uvs: Option<Vec<Vec2>> = used.iter().map(uv).collect();
    uvs.ok_or_else(|| "too few texture coordinates for its vertices".into())
}

fn colors_of(file: &File, primitive: &Primitive, used: &[u32]) -> Result<Vec<Vec4>, String> {
    let Some(accessor) = primitive.get(&Semantic::Colors(0)) else {
        return Ok(Vec::new());
    };
    let (shape, width) = match accessor.dimensions() {
        Dimensions::Vec3 => (Dimensions::Vec3, 3),
        _ => (Dimensions::Vec4, 4),
    };
    let numbers = file.numbers(&accessor, shape)?;
    let color = |&vertex: &u32| {
        let row = numbers.chunks_exact(width).nth(vertex as usize)?;
        let alpha = row.get(3).copied().unwrap_or(1.0);
        Some(Vec4::new(row[0], row[1], row[2], alpha))
    };
    let colors: Option<Vec<Vec4>> = used.iter().map(color).collect();
    colors.ok_or_else(|| "too few colours for its vertices".into())
}
