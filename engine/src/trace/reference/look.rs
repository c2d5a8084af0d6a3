//! What a mesh looks like in f64: textures, colours of vertices, normal maps, holes. The plain formulas; shares nothing
//! with the f32 lookups but the texels.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DVec2, DVec3, DVec4};

use super::shape::LocalHit;
use crate::frame::FrameScene;
use crate::world::{Level, Material, MeshData, Texture, TextureId, Wrap};

/// Looks of a point of a triangle: texture coordinates, and the vertices' colour.
pub struct Look {
    /// (0, 0) is the upper left corner; none: the mesh has none, and pictures do not show on it.
    pub uv: Option<DVec2>,
    /// Linear RGB and alpha.
    pub color: DVec4,
}

/// The looks at a hit; none where the mesh has none.
pub fn look_at(mesh: &MeshData, prim: u32, weights: DVec2) -> Option<Look> {
    if mesh.uvs.is_empty() && mesh.colors.is_empty() {
        return None;
    }
    let corners = mesh.triangles[prim as usize].map(|i| i as usize);
    let weights = [1.0 - weights.x - weights.y, weights.x, weights.y];
    let (mut uv, mut color) = (DVec2::ZERO, DVec4::ZERO);
    for (corner, weight) in corners.into_iter().zip(weights) {
        let own = mesh.uvs.get(corner);
        uv += own.map_or(DVec2::ZERO, |uv| uv.as_dvec2()) * weight;
        let own = mesh.colors.get(corner);
        color += own.map_or(DVec4::ONE, |color| color.as_dvec4()) * weight;
    }
    Some(Look {
        uv: (!mesh.uvs.is_empty()).then_some(uv),
        color,
    })
}

/// The texture of a row that has something to show.
pub fn texture(scene: &FrameScene, id: Option<TextureId>) -> Option<&Arc<Texture>> {
    let texture = scene.textures.get(id?.0 as usize)?;
    (!texture.levels.is_empty()).then_some(texture)
}

/// What cuts holes into an instance.
pub struct Cutout {
    least: f64,
    color_map: Option<Arc<Texture>>,
}

impl Cutout {
    /// That of a material, if it has one.
    pub fn of(scene: &FrameScene, material: &Material) -> Option<Self> {
        Some(Self {
            least: f64::from(material.alpha_cutoff?),
            color_map: texture(scene, material.color_map).cloned(),
        })
    }

    /// Whether the mesh is not there.
    pub fn is_hole(&self, mesh: &MeshData, hit: &LocalHit) -> bool {
        let Some(look) = look_at(mesh, hit.prim, hit.uv) else {
            return false;
        };
        let map = self.color_map.as_ref().zip(look.uv);
        let alpha = map.map_or(1.0, |(map, uv)| sample(map, uv, 0.0).w);
        look.color.w * alpha < self.least
    }
}

/// A texture averaged over about `footprint` of its edge.
pub fn sample(texture: &Texture, uv: DVec2, footprint: f64) -> DVec4 {
    let last = texture.levels.len() - 1;
    let whole = &texture.levels[0];
    let across = footprint * (f64::from(whole.width) * f64::from(whole.height)).sqrt();
    let level = across.max(1e-300).log2().clamp(0.0, last as f64);
    let (fine, share) = (level.floor(), level.fract());
    let near = bilinear(&texture.levels[fine as usize], texture.wrap, uv);
    if share == 0.0 {
        return near;
    }
    near.lerp(
        bilinear(&texture.levels[fine as usize + 1], texture.wrap, uv),
        share,
    )
}

fn bilinear(level: &Level, wrap: Wrap, uv: DVec2) -> DVec4 {
    let at = uv * DVec2::new(level.width.into(), level.height.into()) - 0.5;
    let (corner, share) = (at.floor(), at - at.floor());
    let texel = |x: f64, y: f64| {
        let [x, y] = [(x, level.width), (y, level.height)].map(|(i, n)| beyond(i, n, wrap));
        let texel = level.texels[(y * level.width + x) as usize];
        DVec4::from(texel.map(f64::from)) / 65_535.0
    };
    let upper = texel(corner.x, corner.y).lerp(texel(corner.x + 1.0, corner.y), share.x);
    let lower =
        texel(corner.x, corner.y + 1.0).lerp(texel(corner.x + 1.0, corner.y + 1.0), share.x);
    upper.lerp(lower, share.y)
}

/// The texel that shows at any whole number.
fn beyond(i: f64, count: u32, wrap: Wrap) -> u32 {
    let n = f64::from(count);
    let within = match wrap {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::Clamp => i.clamp(0.0, n - 1.0),
        Wrap::Mirror => {
            let turned = i.rem_euclid(2.0 * n);
            turned.min(2.0 * n - 1.0 - turned)
        }
    };
    (within as u32).min(count - 1)
}

/// What a panorama shows along a unit direction; `turn` in radians about +Y.
pub fn panorama(texture: &Texture, turn: f64, dir: DVec3) -> DVec3 {
    let level = &texture.levels[0];
    let around = 0.5 + (dir.x.atan2(-dir.z) + turn) / TAU;
    let down = 0.5 - dir.y.atan2(dir.x.hypot(dir.z)) / PI;
    let size = DVec2::new(level.width.into(), level.height.into());
    let at = DVec2::new(around, down) * size - 0.5;
    let (corner, share) = (at.floor(), at - at.floor());
    let light = |x: f64, y: f64| {
        let x = beyond(x, level.width, Wrap::Repeat);
        let y = beyond(y, level.height, Wrap::Clamp);
        let [r, g, b, e] = level.texels[(y * level.width + x) as usize].map(f64::from);
        DVec3::new(r, g, b) / 65_535.0 * (e - 127.0).exp2()
    };
    let upper = light(corner.x, corner.y).lerp(light(corner.x + 1.0, corner.y), share.x);
    let next = corner.y + 1.0;
    let lower = light(corner.x, next).lerp(light(corner.x + 1.0, next), share.x);
    upper.lerp(lower, share.y)
}

/// A triangle in the world and on its texture: edges from its first corner, and what they span there.
pub struct Chart {
    /// In the world.
    pub edges: [DVec3; 2],
    /// On the texture.
    pub spans: [DVec2; 2],
}

impl Chart {
    fn area(&self) -> f64 {
        self.spans[0].perp_dot(self.spans[1])
    }

    /// How much of the texture's edge a cone of this width covers that comes at this cosine.
    pub fn footprint(&self, width: f64, cosine: f64) -> f64 {
        let area = self.edges[0].cross(self.edges[1]).length();
        (self.area().abs() / area.max(1e-300)).sqrt() * width / cosine.abs().max(1e-3)
    }

    /// The outward unit normal tilted as a normal map says; none where the texture has no extent here.
    pub fn tilted(&self, normal: DVec3, map: DVec3) -> Option<DVec3> {
        let area = self.area();
        if area == 0.0 {
            return None;
        }
        let ([e, f], [s, t]) = (self.edges, self.spans);
        let right = (e * t.y - f * s.y) / area;
        let up = (e * t.x - f * s.x) / area;
        let across = right.reject_from_normalized(normal).normalize_or_zero();
        let along = normal.cross(across);
        let along = if along.dot(up) < 0.0 { -along } else { along };
        let tilt = map * 2.0 - 1.0;
        let tilted = across * tilt.x + along * tilt.y + normal * tilt.z;
        Some(tilted.normalize_or(normal))
    }
}
