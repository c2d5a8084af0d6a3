//! Files broken by chance, the JSON and the bytes each on their own, so that what is broken is not just the container.

use super::{container, corpus, read};
use crate::import::{Content, Model};
use crate::testing::Random;

/// Broken files of each file of the corpus.
const TRIES: usize = 3000;
/// Numbers of vertices that a broken file of a few thousand bytes may come to.
const MOST: usize = 1 << 20;

/// Numbers that counts, offsets and indices should not be.
const WILD: [&str; 14] = [
    "0",
    "1",
    "2",
    "7",
    "-1",
    "0.5",
    "255",
    "65535",
    "4294967295",
    "18446744073709551615",
    "1e39",
    "-1e300",
    "5120",
    "5126",
];

/// The text with numbers exchanged, pieces doubled, cut out and swapped, letters changed.
fn broken_text(text: &[u8], chance: &mut Random) -> Vec<u8> {
    let mut text = text.to_vec();
    for _ in 0..1 + chance.below(3) {
        let at = chance.below(text.len());
        let digits = |text: &[u8], at: usize| {
            let start = (at..text.len()).find(|&i| text[i].is_ascii_digit())?;
            let end = (start..text.len()).find(|&i| !text[i].is_ascii_digit())?;
            Some(start..end)
        };
        match (chance.below(8), digits(&text, at)) {
            (0..=3, Some(range)) => {
                drop(text.splice(range, WILD[chance.below(WILD.len())].bytes()))
            }
            (4, Some(range)) => {
                let other = chance.below(text.len());
                if let Some(other) = digits(&text, other) {
                    let number = text[other].to_vec();
                    text.splice(range, number);
                }
            }
            (5, _) => text[at] = b"{}[]:,\"0a -"[chance.below(11)],
            (6, _) => {
                let end = (at + chance.below(60)).min(text.len());
                let piece = text[at..end].to_vec();
                text.splice(at..at, piece);
            }
            _ => {
                let end = (at + chance.below(60)).min(text.len() - 1);
                text.drain(at.min(end)..end);
            }
        }
    }
    text
}

/// The bytes with some changed, a number that is none put in, or the end cut off.
fn broken_bytes(bytes: &[u8], chance: &mut Random) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..chance.below(4) {
        let at = chance.below(bytes.len());
        match chance.below(4) {
            0 => bytes[at] ^= 1 << chance.below(8),
            1 => bytes[at] = chance.below(256) as u8,
            2 => {
                let odd = [f32::NAN, f32::INFINITY, -0.0, f32::MAX, 1e-40, 1e30];
                let number = odd[chance.below(6)].to_le_bytes();
                let at = at / 4 * 4;
                if let Some(place) = bytes.get_mut(at..at + 4) {
                    place.copy_from_slice(&number);
                }
            }
            _ => bytes.truncate((bytes.len() - chance.below(9)).max(1)),
        }
    }
    bytes
}

/// What every model must keep to, whatever file it came from.
fn hold(model: &Model) {
    let rows = model.nodes.len();
    for (row, node) in model.nodes.iter().enumerate() {
        assert!(node.parent.is_none_or(|parent| parent < row));
        assert!(node.pose.affine().is_finite());
        for content in &node.contents {
            if let &Content::Part {
                part,
                material,
                skin,
            } = content
            {
                assert!(material.is_none_or(|material| material < model.materials.len()));
                let binding = model.parts[part].binding.as_ref();
                if let Some(skin) = skin {
                    let joints = model.skins[skin].nodes.len();
                    assert!(binding.is_some_and(|b| (b.highest_joint() as usize) < joints));
                }
            }
        }
    }
    for skin in &model.skins {
        assert_eq!(skin.nodes.len(), skin.joint_from_mesh.len());
        assert!(skin.nodes.iter().all(|&node| node < rows));
    }
    let mut numbers = 0;
    for part in &model.parts {
        let count = part.mesh.vertices.len();
        assert!(!part.mesh.triangles.is_empty() && part.sources.len() == count);
        assert!(
            part.mesh
                .normals
                .iter()
                .all(|normal| normal.is_normalized())
        );
        assert!(
            part.binding
                .as_ref()
                .is_none_or(|b| b.joints.len() == count)
        );
        if let Some(morph) = &part.morph {
            assert_eq!(morph.targets.vertices, count);
            assert_eq!(morph.targets.count() as usize, morph.weights.len());
        }
        numbers += count;
    }
    assert!(numbers <= MOST, "{numbers} vertices");
    let mut tracks = model.clips.iter().flat_map(|clip| &clip.tracks);
    assert!(tracks.all(|track| track.target < rows && track.check().is_ok()));
    for (name, material) in &model.materials {
        let shares = [material.diffuse, material.transmit, material.filter];
        assert!(
            shares.iter().all(|share| (0.0..=1.0).contains(share)),
            "{name}: {material:?}"
        );
        assert!(material.color.is_finite() && material.emission.is_finite() && material.ior >= 1.0);
    }
}

#[test]
fn broken_files_are_read_or_refused() {
    let whole = corpus("skin.glb");
    let length = u32::from_le_bytes([whole[12], whole[13], whole[14], whole[15]]) as usize;
    let (json, bytes) = (&whole[20..20 + length], &whole[28 + length..]);
    let text = corpus("scene.gltf");
    let mut chance = Random::new(11);
    let (mut fine, mut refused) = (0, 0);
    let mut count = |found: Result<Model, String>| match found {
        Ok(model) => {
            hold(&model);
            fine += 1;
        }
        Err(why) => {
            assert!(!why.is_empty());
            refused += 1;
        }
    };
    for _ in 0..TRIES {
        let broken = match chance.below(3) {
            0 => container(&broken_text(json, &mut chance), bytes),
            1 => container(json, &broken_bytes(bytes, &mut chance)),
            _ => broken_bytes(&whole, &mut chance),
        };
        count(read(&broken));
        count(read(&broken_text(&text, &mut chance)));
    }
    assert!(
        fine > TRIES / 10 && refused > TRIES / 10,
        "{fine} read, {refused} refused"
    );
}
