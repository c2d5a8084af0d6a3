//! FBX from bytes, without files beside it.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use orrery_engine::import::read_fbx;

fuzz_target!(|bytes: &[u8]| {
    let _ = read_fbx(bytes, Path::new("no folder"));
});
