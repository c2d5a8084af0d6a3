//! The scene file from bytes: read, looked up and checked. Files that it names are not there.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use orrery_engine::scene::check_text;

fuzz_target!(|bytes: &[u8]| {
    // A path from the root, or upward, would open what lies on the disk.
    let text = String::from_utf8_lossy(bytes).replace("\"/", "\"").replace("..", ".");
    let _ = check_text(&text, Path::new("no such folder/scene.ron"));
});
