//! The container: JSON and buffers, checked, before anything is made of them.

use std::cell::Cell;

use gltf::json::validation::{Checked, Error as Invalid, Validate};
use gltf::{Document, Gltf, buffer};

use crate::import::{Files, LONGEST};

/// A document that passed the checks of its schema, and the bytes of its buffers.
pub struct File {
    pub document: Document,
    buffers: Vec<Vec<u8>>,
    /// Numbers that may still be read. A file can name the same bytes any number of times; what it becomes must
    /// not be out of proportion to its size.
    budget: Cell<usize>,
}

/// Numbers that any file may ask for, and as many more for each of its bytes.
const BUDGET: usize = 1 << 20;
const BUDGET_A_BYTE: usize = 32;

/// Extensions that the crate does not know and that ask for nothing but what is done here anyway.
const KNOWN: [&str; 1] = ["KHR_mesh_quantization"];

impl File {
    /// Reads a document and its buffers.
    pub fn open(bytes: &[u8], files: &Files) -> Result<Self, String> {
        let length = bytes.get(8..12).and_then(|length| length.try_into().ok());
        let is_binary = bytes.starts_with(b"glTF");
        if is_binary && length.is_none_or(|length| u32::from_le_bytes(length) < 12) {
            return Err("its binary header is cut off or gives a length below 12".into());
        }
        let Gltf { document, blob } =
            Gltf::from_slice_without_validation(bytes).map_err(|error| describe(&error))?;
        check(&document)?;
        let mut blob = blob;
        let mut size = bytes.len();
        let mut buffers = Vec::new();
        for buffer in document.buffers() {
            let data = match buffer.source() {
                buffer::Source::Bin => blob.take().ok_or_else(|| "it has no binary chunk".into()),
                buffer::Source::Uri(uri) => read_uri(uri, files),
            };
            let data = data.map_err(|why| format!("buffers[{}]: {why}", buffer.index()))?;
            if data.len() < buffer.length() {
                return Err(format!(
                    "buffers[{}]: {} bytes where byteLength says {}",
                    buffer.index(),
                    data.len(),
                    buffer.length()
                ));
            }
            size += data.len();
            if size as u64 > LONGEST {
                let most = LONGEST >> 20;
                return Err(format!("its buffers come to more than {most} MiB"));
            }
            buffers.push(data);
        }
        Ok(Self {
            document,
            buffers,
            budget: Cell::new(size.saturating_mul(BUDGET_A_BYTE).saturating_add(BUDGET)),
        })
    }

    /// The bytes of a view.
    pub fn view(&self, view: &buffer::View) -> Result<&[u8], String> {
        let data = &self.buffers[view.buffer().index()];
        let range = view
            .offset()
            .checked_add(view.length())
            .and_then(|end| data.get(view.offset()..end));
        range.ok_or_else(|| {
            format!(
                "bufferViews[{}]: {} bytes from byte {} on, but its buffer has {}",
                view.index(),
                view.length(),
                view.offset(),
                data.len()
            )
        })
    }

    /// Takes so many numbers off what the file may ask for.
    pub fn spend(&self, numbers: usize) -> Result<(), String> {
        let left = self.budget.get().checked_sub(numbers);
        let left =
            left.ok_or("it uses the same bytes over and over: far more numbers than it has bytes")?;
        self.budget.set(left);
        Ok(())
    }
}

/// Holds a document against its schema.
fn check(document: &Document) -> Result<(), String> {
    let mut first = None;
    let mut count = 0_usize;
    let root = document.as_json();
    // The crate's own check would look at an accessor that is not there, and give up.
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let named = primitives.flat_map(|primitive| primitive.attributes.values());
    if let Some(missing) = named
        .map(|index| index.value())
        .find(|i| *i >= root.accessors.len())
    {
        return Err(format!(
            "an attribute of a mesh names accessors[{missing}], which is not there"
        ));
    }
    // Nor does it look at what channels move.
    let targets = root
        .animations
        .iter()
        .flat_map(|animation| &animation.channels);
    for target in targets.map(|channel| &channel.target) {
        if target.node.value() >= root.nodes.len() || target.path == Checked::Invalid {
            return Err("an animation moves a node or a property that is not there".into());
        }
    }
    root.validate(root, gltf::json::Path::new, &mut |path, error| {
        let path = path();
        // The crate adds the name, as ` = "NAME"`.
        let required = path
            .as_str()
            .strip_prefix("extensionsRequired[")
            .and_then(|rest| rest.split('"').nth(1));
        let known = required.is_some_and(|name| KNOWN.contains(&name));
        // Bounds are not read, and a primitive without positions is left out.
        let bounds = [".min", ".max"]
            .iter()
            .any(|name| path.as_str().ends_with(name));
        let positions = path.as_str().contains("attributes[\"POSITION\"]");
        let needless = positions && (bounds || error == Invalid::Missing);
        if known && error == Invalid::Unsupported || needless {
            return;
        }
        let what = match error {
            Invalid::IndexOutOfBounds => "names something that is not there",
            Invalid::Invalid => "has a value that glTF does not know",
            Invalid::Missing => "is missing",
            Invalid::Oversize => "is too large",
            Invalid::Unsupported => "is an extension that is not supported",
        };
        first.get_or_insert_with(|| match required {
            Some(name) => format!("extensionsRequired: `{name}` {what}"),
            None => format!("{path} {what}"),
        });
        count += 1;
    });
    match (first, count) {
        (None, _) => Ok(()),
        (Some(first), 1) => Err(first),
        (Some(first), count) => Err(format!("{first} (and {} more problems)", count - 1)),
    }
}

fn describe(error: &gltf::Error) -> String {
    match error {
        gltf::Error::Deserialize(error) => format!("its JSON is not that of glTF 2.0: {error}"),
        gltf::Error::Binary(error) => format!("its binary container is damaged: {error}"),
        error => error.to_string(),
    }
}

/// The bytes of a data URI, or of a file in the folder.
fn read_uri(uri: &str, files: &Files) -> Result<Vec<u8>, String> {
    if let Some(bytes) = data_of(uri) {
        return bytes;
    }
    let short: String = uri.chars().take(60).collect();
    if uri.contains(':') {
        return Err(format!(
            "`{short}` is neither a file beside it nor a data URI"
        ));
    }
    let path = files.folder().join(percent_decoded(uri));
    files
        .bytes(&path)
        .map_err(|why| format!("`{short}`: {why}"))
}

/// The bytes that a data URI holds; none: it is another kind of URI.
pub fn data_of(uri: &str) -> Option<Result<Vec<u8>, String>> {
    let (_, text) = match uri.strip_prefix("data:")?.split_once(";base64,") {
        Some(parts) => parts,
        None => return Some(Err("its data URI is not in base64".into())),
    };
    let wrong = || "its data URI holds what is not base64".to_owned();
    Some(base64(text).ok_or_else(wrong))
}

/// RFC 4648, section 4; padding may be left out.
fn base64(text: &str) -> Option<Vec<u8>> {
    let text = text.trim_end_matches('=').as_bytes();
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 2);
    for group in text.chunks(4) {
        let mut bits = 0_u32;
        for &c in group {
            let six = match c {
                b'A'..=b'Z' => c - b'A',
                b'a'..=b'z' => c - b'a' + 26,
                b'0'..=b'9' => c - b'0' + 52,
                b'+' => 62,
                b'/' => 63,
                _ => return None,
            };
            bits = bits << 6 | u32::from(six);
        }
        bits <<= 6 * (4 - group.len());
        // Four letters are three bytes, three two, two one; one alone is none.
        bytes.extend(&bits.to_be_bytes()[1..group.len()]);
    }
    Some(bytes)
}

/// RFC 3986, section 2.1.
pub fn percent_decoded(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let hex = after.get(..2).and_then(|hex| std::str::from_utf8(hex).ok());
        match hex.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) if first == b'%' => {
                bytes.push(byte);
                rest = &after[2..];
            }
            _ => {
                bytes.push(first);
                rest = after;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_rfc() {
        for (text, bytes) in [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYg", "foob"),
            ("Zm9vYmFy", "foobar"),
        ] {
            assert_eq!(base64(text).as_deref(), Some(bytes.as_bytes()), "{text}");
        }
        assert_eq!(base64("Zm9*"), None);
    }

    #[test]
    fn names_of_files_may_be_escaped() {
        assert_eq!(percent_decoded("a%20b%C3%A9.bin"), "a bé.bin");
        assert_eq!(percent_decoded("100%.bin%4"), "100%.bin%4");
    }
}
