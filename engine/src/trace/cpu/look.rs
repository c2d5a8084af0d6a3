//! What a mesh looks like where it is hit: its colour, and the normal that a normal map tilts; and where it is cut out.
//!
//! Cut-outs are decided at the finest level of the picture, for all rays alike: what casts a shadow is what is seen.
//! Twin of `shaders/shared/look.wgsl` and `shaders/shared/appear.wgsl`.

use glam::{Vec2, Vec3, Vec4};

use super::query::Found;
use super::surface::Surface;
use super::texture::sample;
use crate::frame::wire::{InstanceRow, KIND_MESH, LOOK_UNPLACED, MaterialRow, NONE, TriangleRow};
use crate::geom::unit_or;
use crate::trace::PackedScene;
use crate::trace::pack::PackedMesh;

/// Cosine of the flattest angle at which a footprint grows.
const FLATTEST: f32 = 1e-3;
/// Stands for an area of nothing.
const TINY: f32 = 1e-30;

/// Looks of a point of a triangle.
struct Look {
    /// None: pictures do not show here.
    uv: Option<Vec2>,
    /// Of the vertices: linear RGB and alpha.
    color: Vec4,
}

/// What cuts holes into an instance.
#[derive(Clone, Copy)]
pub struct Cutout {
    least: f32,
    color_map: u32,
}

impl Cutout {
    /// That of an instance of a mesh, if there is one.
    pub fn of(scene: &PackedScene, row: &InstanceRow) -> Option<Self> {
        if !scene.has_cutouts {
            return None;
        }
        let material = &scene.materials[row.material as usize];
        (material.alpha_cutoff > 0.0 && row.link != NONE).then_some(Self {
            least: material.alpha_cutoff,
            color_map: material.color_map,
        })
    }

    /// Whether the mesh is not there.
    pub fn is_hole(
        &self,
        scene: &PackedScene,
        mesh: &PackedMesh,
        triangle: &TriangleRow,
        weights: [f32; 2],
    ) -> bool {
        let look = look_at(mesh, triangle, weights);
        let mut alpha = look.color.w;
        if let Some(uv) = look.uv
            && self.color_map != NONE
        {
            alpha *= sample(&scene.texels.memory, self.color_map, uv, 0.0).w;
        }
        alpha < self.least
    }
}

/// The looks of the vertices, mixed.
fn look_at(mesh: &PackedMesh, triangle: &TriangleRow, [u, v]: [f32; 2]) -> Look {
    let weights = [1.0 - u - v, u, v];
    let first = mesh.looks_start();
    let (mut place, mut color) = (Vec3::ZERO, Vec3::ZERO);
    let mut is_placed = true;
    for (corner, weight) in triangle.corners.into_iter().zip(weights) {
        let at = first + corner as usize;
        let row = &mesh.vertices[at];
        place += Vec3::from(row.vector) * weight;
        is_placed &= row.further & LOOK_UNPLACED == 0;
        color += match row.further & !LOOK_UNPLACED {
            0 => Vec3::ONE,
            further => Vec3::from(mesh.vertices[at + further as usize].vector),
        } * weight;
    }
    Look {
        uv: is_placed.then_some(place.truncate()),
        color: color.extend(place.z),
    }
}

/// The colour of a hit at the finest level: what tints a shadow.
pub fn tint(scene: &PackedScene, found: &Found, material: &MaterialRow) -> Vec3 {
    let row = &scene.instances()[found.key.id as usize];
    let color = Vec3::from(material.color);
    if !scene.has_looks || row.kind != KIND_MESH || row.link == NONE {
        return color;
    }
    let mesh = scene.mesh(row);
    let look = look_at(mesh, &mesh.triangles[found.triangle as usize], found.uv);
    color * mapped(scene, material, &look, 0.0)
}

/// The product of the vertices' colour and the map's.
fn mapped(scene: &PackedScene, material: &MaterialRow, look: &Look, footprint: f32) -> Vec3 {
    let color = look.color.truncate();
    match look.uv {
        Some(uv) if material.color_map != NONE => {
            let map = sample(&scene.texels.memory, material.color_map, uv, footprint);
            color * map.truncate()
        }
        _ => color,
    }
}

/// Gives a surface the colour and the normal that a ray sees whose cone is `width` wide there.
pub fn appear(scene: &PackedScene, found: &Found, surface: &mut Surface, dir: Vec3, width: f32) {
    let row = &scene.instances()[found.key.id as usize];
    if !scene.has_looks || row.kind != KIND_MESH || row.link == NONE {
        return;
    }
    let mesh = scene.mesh(row);
    let triangle = &mesh.triangles[found.triangle as usize];
    let look = look_at(mesh, triangle, found.uv);
    let [a, b, c] = mesh.corners(triangle);
    let edges = [b - a, c - a].map(|edge| row.world_from_local.vector(edge));
    let first = mesh.looks_start();
    let [at, at_b, at_c] = triangle.corners.map(|corner| {
        let [x, y, _] = mesh.vertices[first + corner as usize].vector;
        Vec2::new(x, y)
    });
    let spans = [at_b - at, at_c - at];
    let area = spans[0].x * spans[1].y - spans[1].x * spans[0].y;
    let density = (area.abs() / edges[0].cross(edges[1]).length().max(TINY)).sqrt();
    let slant = dir.dot(surface.n_geom).abs().max(FLATTEST);
    let footprint = density * width / slant;
    surface.color *= mapped(scene, surface.material, &look, footprint);
    let normal_map = surface.material.normal_map;
    let Some(uv) = look.uv.filter(|_| normal_map != NONE && area != 0.0) else {
        return;
    };
    let outward = row.local_from_world.transposed_vector((b - a).cross(c - a));
    let side = if surface.n_geom.dot(outward) < 0.0 {
        -1.0
    } else {
        1.0
    };
    // Along u, and against v: up the picture.
    let right = (edges[0] * spans[1].y - edges[1] * spans[0].y) * area.signum();
    let up = (edges[0] * spans[1].x - edges[1] * spans[0].x) * area.signum();
    let map = sample(&scene.texels.memory, normal_map, uv, footprint);
    let tilt = map.truncate() * 2.0 - 1.0;
    let tilted = tilted(surface.n_shade * side, right, up, tilt) * side;
    if tilted.dot(surface.n_geom) > 0.0 {
        surface.n_shade = tilted;
    }
}

/// A normal tilted in the frame of it and what of `right` is across it, `up` saying on which hand.
fn tilted(normal: Vec3, right: Vec3, up: Vec3, tilt: Vec3) -> Vec3 {
    let across = unit_or(right - normal * normal.dot(right), Vec3::ZERO);
    let along = normal.cross(across);
    let hand = if along.dot(up) < 0.0 { -1.0 } else { 1.0 };
    unit_or(
        across * tilt.x + along * (hand * tilt.y) + normal * tilt.z,
        normal,
    )
}
