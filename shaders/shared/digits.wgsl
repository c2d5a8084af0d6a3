// What: sorting by digits of eight bits, the lowest (level 0) first: 1024 pairs a workgroup of 256.
// Reads: stage. Writes: nothing.
// Twin: engine/src/trace/gpu/trees/instances.rs.
#define_import_path orrery::digits

#import orrery::stage::stage

const DIGITS: u32 = 256u;
const BLOCK_PAIRS: u32 = 1024u;

fn digit_of(key: u32) -> u32 {
    return key >> (stage.level * 8u) & 255u;
}

fn block_count() -> u32 {
    return (stage.count + BLOCK_PAIRS - 1u) / BLOCK_PAIRS;
}
