// What: affine maps by rows, p'[i] = dot(row[i].xyz, p) + row[i].w, and unit vectors.
// Reads: nothing. Writes: nothing.
// Twin: engine/src/geom/affine.rs.
#define_import_path orrery::affine

fn map_point(rows: array<vec4f, 3>, p: vec3f) -> vec3f {
    return map_vector(rows, p) + map_translation(rows);
}

fn map_vector(rows: array<vec4f, 3>, v: vec3f) -> vec3f {
    return vec3f(dot(rows[0].xyz, v), dot(rows[1].xyz, v), dot(rows[2].xyz, v));
}

// Transpose(M) n: normals go back through the inverse map's rows.
fn map_transposed(rows: array<vec4f, 3>, n: vec3f) -> vec3f {
    return rows[0].xyz * n.x + rows[1].xyz * n.y + rows[2].xyz * n.z;
}

// |M| v, entries' absolute values.
fn map_abs_linear(rows: array<vec4f, 3>, v: vec3f) -> vec3f {
    return vec3f(dot(abs(rows[0].xyz), v), dot(abs(rows[1].xyz), v), dot(abs(rows[2].xyz), v));
}

// t.
fn map_translation(rows: array<vec4f, 3>) -> vec3f {
    return vec3f(rows[0].w, rows[1].w, rows[2].w);
}

// v at unit length; the fallback for no length at all. Squares of very small or large vectors would
// leave f32's range, so those are brought near 1 first.
fn unit_or(v: vec3f, fallback: vec3f) -> vec3f {
    let squared = dot(v, v);
    if squared > 1e-30 && squared < 1e30 {
        return v / sqrt(squared);
    }
    let largest = max(max(abs(v.x), abs(v.y)), abs(v.z));
    if !(largest > 1e-37 && largest < 1e37) {
        return fallback;
    }
    let near_one = v / largest;
    return near_one / sqrt(dot(near_one, near_one));
}
