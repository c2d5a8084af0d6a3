//! The bytes of a kept model: a head, then the files it refers to and the model, both by `postcard`.
//!
//! | bytes | head |
//! |---|---|
//! | 0..8 | [`MARK`], which ends in the version of this layout |
//! | 8..24 | [`BUILD`]: the sources of the program that wrote it |
//! | 24..56 | the key of the model: a copy of the file under another's name is not taken for that one's |
//! | 56..88 | hash (BLAKE3) of all that follows the head |
//! | 88..96 | how many bytes that are |
//!
//! Nothing is made of bytes whose hash is another. The lengths within are held against what is left before anything is
//! allocated, by `postcard`.

use postcard::ser_flavors::Size;
use serde::Serialize;

use crate::import::Model;
use crate::import::files::Content;

const MARK: [u8; 8] = *b"ORRERY\n\x02";
/// A fingerprint of the engine's sources in hexadecimal; see `build.rs`.
pub const BUILD: [u8; 16] = match env!("ORRERY_SOURCES").as_bytes().as_chunks::<16>() {
    ([build], []) => *build,
    _ => panic!("16 digits"),
};
const HEAD: usize = 96;

/// What the file is named by.
type KeyBytes = [u8; 32];

/// A file by its path from the model's folder, and its content.
type Reference = (String, Content);

/// A model as bytes; none: it cannot be written, or would take more than so many.
pub fn encode(
    key: &KeyBytes,
    (files, model): (&[Reference], &Model),
    most_bytes: u64,
) -> Option<Vec<u8>> {
    if least_size(files, model)? > most_bytes {
        return None;
    }
    let bytes = postcard::to_extend(&files, vec![0; HEAD]).ok()?;
    let mut bytes = postcard::to_extend(model, bytes).ok()?;
    let (head, rest) = bytes.split_at_mut(HEAD);
    head.copy_from_slice(&head_of(key, rest));
    Some(bytes)
}

/// How many bytes [`encode`] makes, but for a few that say how long lists are: told in no time, as arrays of numbers are
/// not walked through.
fn least_size(files: &[Reference], model: &Model) -> Option<u64> {
    // Parts and textures one by one: as lists they would be encoded first.
    let Model {
        nodes,
        parts,
        textures,
        materials,
        skins,
        clips,
        background,
        warnings,
    } = model;
    let parts: u64 = parts.iter().map(size).sum::<Option<u64>>()?;
    let textures: u64 = textures.iter().map(size).sum::<Option<u64>>()?;
    let others = (nodes, materials, skins, clips, background, warnings);
    Some(HEAD as u64 + size(&files)? + parts + textures + size(&others)?)
}

fn size(thing: &impl Serialize) -> Option<u64> {
    let size = postcard::serialize_with_flavor(thing, Size::default()).ok()?;
    u64::try_from(size).ok()
}

/// The model, if the bytes are whole and of that key, and `holds` its files.
pub fn decode(
    bytes: &[u8],
    key: &KeyBytes,
    holds: impl FnOnce(&[Reference]) -> bool + Send,
) -> Option<Model> {
    let (head, rest) = bytes.split_at_checked(HEAD)?;
    if !head.starts_with(&MARK) || head[8..24] != BUILD || head[24..56] != *key {
        return None;
    }
    if head != head_of(key, rest) {
        return None;
    }
    let (files, rest) = postcard::take_from_bytes::<Vec<Reference>>(rest).ok()?;
    let (holds, model) = rayon::join(|| holds(&files), || postcard::from_bytes(rest));
    holds.then_some(model.ok()?)
}

fn head_of(key: &KeyBytes, rest: &[u8]) -> [u8; HEAD] {
    let mut head = [0; HEAD];
    head[..8].copy_from_slice(&MARK);
    head[8..24].copy_from_slice(&BUILD);
    head[24..56].copy_from_slice(key);
    head[56..88].copy_from_slice(blake3::hash(rest).as_bytes());
    head[88..].copy_from_slice(&(rest.len() as u64).to_le_bytes());
    head
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::import::{Node, Part};
    use crate::world::{Level, MeshData, Texture};

    #[test]
    fn what_would_take_too_much_room_is_not_encoded() {
        let part = |vertices| Part {
            mesh: MeshData {
                vertices: vec![DVec3::ONE; vertices],
                ..MeshData::default()
            },
            ..Part::default()
        };
        let level = Level {
            width: 40,
            height: 50,
            texels: vec![[1, 2, 3, 4]; 2000],
        };
        let texture = Texture {
            levels: vec![level],
            ..Texture::default()
        };
        let mut model = Model {
            nodes: vec![Node::default(); 300],
            parts: [1, 100, 10_000].map(part).to_vec(),
            textures: vec![texture; 3],
            ..Model::default()
        };
        model.warnings.push("it is odd");
        let files = [("a.png".to_owned(), Some([7; 32])), ("b".to_owned(), None)];
        let encoded = |most_bytes| encode(&[9; 32], (&files, &model), most_bytes);
        let bytes = encoded(u64::MAX).unwrap().len() as u64;
        let least = least_size(&files, &model).unwrap();
        assert!(least <= bytes && bytes < least + 64, "{least} of {bytes}");
        assert_eq!(encoded(bytes).map(|all| all.len() as u64), Some(bytes));
        assert_eq!(encoded(least - 1), None);
    }
}
