//! glTF from bytes, text or binary; its buffers are inside.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use orrery_engine::import::read_gltf;

fuzz_target!(|bytes: &[u8]| {
    let _ = read_gltf(bytes, Path::new("no such folder"));
});
