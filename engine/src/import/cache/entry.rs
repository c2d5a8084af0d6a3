//! The bytes of a kept model: a head, then the files it refers to and the model, both by `postcard`.
//!
//! | bytes | head |
//! |---|---|
//! | 0..8 | [`MARK`], which ends in the version of this layout |
//! | 8..24 | [`BUILD`]: the sources of the program that wrote it |
//! | 24..56 | hash (BLAKE3) of all that follows the head |
//! | 56..64 | how many bytes that are |
//!
//! Nothing is made of bytes whose hash is another. The lengths within are held against what is left before anything is
//! allocated, by `postcard`.

use crate::import::Model;
use crate::import::files::Content;

const MARK: [u8; 8] = *b"ORRERY\n\x01";
/// A fingerprint of the engine's sources in hexadecimal; see `build.rs`.
pub const BUILD: [u8; 16] = match env!("ORRERY_SOURCES").as_bytes().as_chunks::<16>() {
    ([build], []) => *build,
    _ => panic!("16 digits"),
};
const HEAD: usize = 64;

/// A file by its path from the model's folder, and its content.
type Reference = (String, Content);

/// A model as bytes; none: it cannot be written.
pub fn encode(files: &[Reference], model: &Model) -> Option<Vec<u8>> {
    let bytes = postcard::to_extend(&files, vec![0; HEAD]).ok()?;
    let mut bytes = postcard::to_extend(model, bytes).ok()?;
    let (head, rest) = bytes.split_at_mut(HEAD);
    head.copy_from_slice(&head_of(rest));
    Some(bytes)
}

/// The model, if the bytes are whole and `holds` its files.
pub fn decode(bytes: &[u8], holds: impl FnOnce(&[Reference]) -> bool + Send) -> Option<Model> {
    let (head, rest) = bytes.split_at_checked(HEAD)?;
    if !head.starts_with(&MARK) || head[8..24] != BUILD {
        return None;
    }
    if head != head_of(rest) {
        return None;
    }
    let (files, rest) = postcard::take_from_bytes::<Vec<Reference>>(rest).ok()?;
    let (holds, model) = rayon::join(|| holds(&files), || postcard::from_bytes(rest));
    holds.then_some(model.ok()?)
}

fn head_of(rest: &[u8]) -> [u8; HEAD] {
    let mut head = [0; HEAD];
    head[..8].copy_from_slice(&MARK);
    head[8..24].copy_from_slice(&BUILD);
    head[24..56].copy_from_slice(blake3::hash(rest).as_bytes());
    head[56..].copy_from_slice(&(rest.len() as u64).to_le_bytes());
    head
}
