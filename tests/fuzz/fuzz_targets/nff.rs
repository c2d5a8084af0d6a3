//! NFF and AFF from bytes. Files that it includes are the file itself, so that includes are walked too.

#![no_main]

use libfuzzer_sys::fuzz_target;
use orrery_engine::import::import_nff_text;

fuzz_target!(|bytes: &[u8]| {
    let text = String::from_utf8_lossy(bytes).into_owned();
    let _ = import_nff_text(&text, &|_| Ok(text.clone()));
});
