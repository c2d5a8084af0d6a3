// What: the colour and the normal that a ray sees on a mesh with looks.
// Reads: what look reads. Writes: nothing.
// Twin: engine/src/trace/cpu/look.rs.
#define_import_path orrery::appear

#ifdef TINTED
#import orrery::types::{MaterialRow, NONE}
#import orrery::scene::{instances, materials, triangles, vertices}
#import orrery::affine::{map_transposed, map_vector, unit_or}
#import orrery::surface::Surface
#import orrery::traverse::Found
#import orrery::look::{look_at, mapped}
#ifdef NORMAL_MAPS
#import orrery::texture::sample
#endif

// Cosine of the flattest angle at which a footprint grows.
const FLATTEST: f32 = 1e-3;
// Stands for an area of nothing.
const TINY: f32 = 1e-30;

// The surface as a ray sees it whose cone is `width` wide there.
fn appear(found: Found, plain: Surface, dir: vec3f, width: f32) -> Surface {
    if found.triangle == NONE || instances[found.row].link == NONE {
        return plain;
    }
    var surface = plain;
    let material = materials[surface.material];
    let look = look_at(found.row, found.triangle, found.uv);
#ifdef TEXTURES
    let rows = instances[found.row].world_from_local;
    let a = triangles[found.triangle].a;
    let edge_b = map_vector(rows, triangles[found.triangle].b - a);
    let edge_c = map_vector(rows, triangles[found.triangle].c - a);
    let at = triangles[found.triangle].corners + instances[found.row].link;
    let span_b = vertices[at.y].vector.xy - vertices[at.x].vector.xy;
    let span_c = vertices[at.z].vector.xy - vertices[at.x].vector.xy;
    let area = span_b.x * span_c.y - span_c.x * span_b.y;
    let density = sqrt(abs(area) / max(length(cross(edge_b, edge_c)), TINY));
    let footprint = density * width / max(abs(dot(dir, surface.n_geom)), FLATTEST);
#else
    let footprint = 0.0;
#endif
    surface.color *= mapped(material, look, footprint);
#ifdef NORMAL_MAPS
    if !look.is_placed || material.normal_map == NONE || area == 0.0 {
        return surface;
    }
    let face = cross(triangles[found.triangle].b - a, triangles[found.triangle].c - a);
    let outward = map_transposed(instances[found.row].local_from_world, face);
    let side = select(1.0, -1.0, dot(surface.n_geom, outward) < 0.0);
    // Along u, and against v: up the picture.
    let right = (edge_b * span_c.y - edge_c * span_b.y) * sign(area);
    let up = (edge_b * span_c.x - edge_c * span_b.x) * sign(area);
    let tilt = sample(material.normal_map, look.uv, footprint).xyz * 2.0 - 1.0;
    let tilted = tilted_normal(surface.n_shade * side, right, up, tilt) * side;
    if dot(tilted, surface.n_geom) > 0.0 {
        surface.n_shade = tilted;
    }
#endif
    return surface;
}

// A normal tilted in the frame of it and what of `right` is across it, `up` saying on which hand.
fn tilted_normal(normal: vec3f, right: vec3f, up: vec3f, tilt: vec3f) -> vec3f {
    let across = unit_or(right - normal * dot(normal, right), vec3f(0.0));
    let along = cross(normal, across);
    let hand = select(1.0, -1.0, dot(along, up) < 0.0);
    return unit_or(across * tilt.x + along * (hand * tilt.y) + normal * tilt.z, normal);
}
#endif
