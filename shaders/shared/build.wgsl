// What: what the passes that build a tree over boxes share: centres, and which levels hold which nodes.
// Reads and writes: build, all zero before the first pass.
// Twin: engine/src/trace/gpu/trees/instances.rs.
#define_import_path orrery::build

#import orrery::types::{BoxRow, BuildRow}

@group(0) @binding(2) var<storage, read_write> build: BuildRow;

// Whether nothing is in the box: it is in no tree.
fn is_vacant(row: BoxRow) -> bool {
    return any(row.min > row.max);
}

// Halves first: the sum of two large numbers may have no f32.
fn centre(row: BoxRow) -> vec3f {
    return row.min * 0.5 + row.max * 0.5;
}

// Whole numbers in the order of the f32, zero below all of them.
fn ordered(x: f32) -> u32 {
    let bits = bitcast<u32>(x);
    return select(bits | 0x80000000u, ~bits, bits >= 0x80000000u);
}

fn unordered(key: u32) -> f32 {
    return bitcast<f32>(select(~key, key & 0x7fffffffu, key >= 0x80000000u));
}
