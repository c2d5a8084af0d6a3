//! The corners of OBJ's faces, which name a position, a texture coordinate and a normal each by a number of its own, as
//! the vertices of a mesh. Called by [`super`], group by group.

use std::collections::HashMap;

use glam::{DVec2, DVec3, Vec2, Vec3};

use super::Corner;

/// Vertices in the order of their first use, one a position, texture coordinate and normal.
#[derive(Default)]
pub struct Weld {
    rows: HashMap<Corner, u32>,
    /// Positions.
    pub vertices: Vec<DVec3>,
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    /// Of each vertex, the one of the file that it is.
    pub sources: Vec<u32>,
}

impl Weld {
    /// The vertex of a corner, by number.
    pub fn row(
        &mut self,
        corner: Corner,
        positions: &[DVec3],
        uvs: &[DVec2],
        normals: &[DVec3],
    ) -> Result<u32, String> {
        if let Some(&row) = self.rows.get(&corner) {
            return Ok(row);
        }
        let (vertex, uv, normal) = corner;
        let missing = |what: &str, i: u32, count: usize| {
            format!("a face names {what} {i}, but there are {count}")
        };
        let position = positions
            .get(vertex as usize)
            .ok_or_else(|| missing("vertex", vertex, positions.len()))?;
        if let Some(normal) = normal {
            let given = normals
                .get(normal as usize)
                .ok_or_else(|| missing("normal", normal, normals.len()))?;
            self.normals.push(given.normalize_or_zero().as_vec3());
        }
        if let Some(uv) = uv {
            let uv = uvs
                .get(uv as usize)
                .ok_or_else(|| missing("texture coordinate", uv, uvs.len()))?;
            // OBJ counts v from the lower edge.
            self.uvs.push(DVec2::new(uv.x, 1.0 - uv.y).as_vec2());
        }
        let row = self.vertices.len() as u32;
        self.vertices.push(*position);
        self.sources.push(vertex);
        self.rows.insert(corner, row);
        Ok(row)
    }
}
