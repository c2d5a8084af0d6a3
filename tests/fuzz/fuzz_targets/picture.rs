//! Pictures from bytes, as textures and as skies. The first byte says what the name of the file ends in.

#![no_main]

use libfuzzer_sys::fuzz_target;
use orrery_engine::import::{decode_sky, decode_texture};
use orrery_engine::world::{ColorSpace, Wrap};

const ENDINGS: [Option<&str>; 6] = [
    None,
    Some("png"),
    Some("jpg"),
    Some("bmp"),
    Some("tga"),
    Some("hdr"),
];

fuzz_target!(|bytes: &[u8]| {
    let Some((&first, bytes)) = bytes.split_first() else {
        return;
    };
    let ending = ENDINGS[usize::from(first) % ENDINGS.len()];
    let _ = decode_texture(bytes, ending, ColorSpace::Srgb, Wrap::Repeat);
    let _ = decode_sky(bytes, ending);
});
