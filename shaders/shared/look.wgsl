// What: looks of a point of a triangle: texture coordinates, colour and alpha of its vertices; where a mesh is cut out.
// Reads: instances, triangles, vertices (looks alone), materials, texels. Writes: nothing.
// Twin: engine/src/trace/cpu/look.rs.
#define_import_path orrery::look

#import orrery::types::{LOOK_UNPLACED, MaterialRow, NONE}
#import orrery::scene::{instances, materials, triangles, vertices}
#ifdef TEXTURES
#import orrery::texture::sample
#endif

struct Look {
    uv: vec2f,
    // Else pictures do not show here.
    is_placed: bool,
    // Of the vertices: linear RGB and alpha.
    color: vec4f,
}

#ifdef TINTED
// The looks of the vertices, mixed. The row has some.
fn look_at(row: u32, triangle: u32, weights: vec2f) -> Look {
    let at = triangles[triangle].corners + instances[row].link;
    let w = 1.0 - weights.x - weights.y;
    let place = vertices[at.x].vector * w + vertices[at.y].vector * weights.x + vertices[at.z].vector * weights.y;
    var color = vec3f(1.0);
    var is_placed = true;
#ifdef VERTEX_COLORS
    let further = vertices[at.x].further & ~LOOK_UNPLACED;
    is_placed = further == vertices[at.x].further;
    if further != 0u {
        let on = at + further;
        color = vertices[on.x].vector * w + vertices[on.y].vector * weights.x + vertices[on.z].vector * weights.y;
    }
#endif
    return Look(place.xy, is_placed, vec4f(color, place.z));
}

// The product of the vertices' colour and the map's.
fn mapped(material: MaterialRow, look: Look, footprint: f32) -> vec3f {
#ifdef TEXTURES
    if look.is_placed && material.color_map != NONE {
        return look.color.rgb * sample(material.color_map, look.uv, footprint).rgb;
    }
#endif
    return look.color.rgb;
}

// The colour of a hit at the finest level: what tints a shadow.
fn tint(row: u32, triangle: u32, weights: vec2f, material: MaterialRow) -> vec3f {
    if triangle == NONE || instances[row].link == NONE {
        return material.color;
    }
    return material.color * mapped(material, look_at(row, triangle, weights), 0.0);
}
#endif

#ifdef CUTOUTS
// Whether a mesh is not there: decided at the finest level, for all rays alike.
fn is_hole(row: u32, triangle: u32, weights: vec2f) -> bool {
    let material = materials[instances[row].material];
    if material.alpha_cutoff <= 0.0 || instances[row].link == NONE {
        return false;
    }
    let look = look_at(row, triangle, weights);
    var alpha = look.color.a;
#ifdef TEXTURES
    if look.is_placed && material.color_map != NONE {
        alpha *= sample(material.color_map, look.uv, 0.0).a;
    }
#endif
    return alpha < material.alpha_cutoff;
}
#endif
