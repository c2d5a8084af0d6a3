//! OBJ from bytes. Material files that it names are the file itself, so that MTL is read too; there are no pictures.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use orrery_engine::import::read_obj;

fuzz_target!(|bytes: &[u8]| {
    let _ = read_obj(bytes, Path::new("no such folder"), &|_| Ok(bytes.to_vec()));
});
