//! Files to plain data. The only readers of foreign formats, each with its crate to itself.
//!
//! An importer returns a [`Model`], or a sentence that says what is wrong with the file; it never touches the world. What
//! its crate may do to it, [`import`] catches.

mod cache;
mod fbx;
mod files;
mod gltf;
mod load;
mod model;
mod mtl;
mod nff;
mod obj;
mod picture;
mod poses;
mod progress;
mod smooth;

pub use cache::{Cache, pipelines_folder, user_folder};
pub use fbx::read_fbx;
pub use files::Files;
use files::{LONGEST, bytes_of};
pub use gltf::read_gltf;
pub use load::Loader;
pub use model::{Content, Joints, Model, Node, Part, Solid, Warnings};
pub use mtl::{Lie, material_of, with_pictures};
pub use nff::import_nff_text;
pub use obj::read_obj;
pub use picture::{Pictures, Recipe, decode_sky, decode_texture, import_sky, import_texture};
pub use poses::import_pose;
pub use progress::{Progress, Step};
pub use smooth::{smooth, smooth_part};

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use serde::{Deserialize, Serialize};

/// A kind of file, by the ending of its name.
struct Format {
    endings: &'static [&'static str],
    name: &'static str,
    import: fn(&Path, &Files) -> Result<Model, String>,
}

/// All that can be read.
const FORMATS: &[Format] = &[
    Format {
        endings: &["fbx"],
        name: "FBX",
        import: fbx::import,
    },
    Format {
        endings: &["obj"],
        name: "Wavefront OBJ",
        import: obj::import,
    },
    Format {
        endings: &["gltf", "glb"],
        name: "glTF",
        import: gltf::import,
    },
    Format {
        endings: &["nff", "aff"],
        name: "NFF and AFF",
        import: nff::import,
    },
];

fn format_of(path: &Path) -> Option<&'static Format> {
    let ending = path.extension()?.to_str()?.to_ascii_lowercase();
    FORMATS
        .iter()
        .find(|format| format.endings.contains(&ending.as_str()))
}

/// Whether a file's name ends like one of a model.
pub fn is_model(path: &Path) -> bool {
    format_of(path).is_some()
}

/// The endings of model files, as a sentence lists them.
pub fn endings() -> String {
    let endings = FORMATS.iter().flat_map(|format| format.endings);
    let dotted: Vec<String> = endings.map(|ending| format!(".{ending}")).collect();
    dotted.join(", ")
}

/// Reads a model file of any format; the ending of its name says which.
///
/// # Errors
/// A sentence without the file's name that says what is wrong, and where in the file. A reader that gives up in the
/// middle is a mistake of ours or of its crate's; it is reported like that and ends nothing.
pub fn import(path: &Path) -> Result<Model, String> {
    import_from(path, &Files::beside(path))
}

/// [`import()`], with note of what was read for it.
fn import_from(path: &Path, files: &Files) -> Result<Model, String> {
    let format =
        format_of(path).ok_or_else(|| format!("its name does not end in one of {}", endings()))?;
    let mut model = caught(format.name, || (format.import)(path, files))?;
    model.settle_clips();
    if !model.contents().any(Content::is_visible) {
        model.warnings.push("it holds nothing that can be seen");
    }
    Ok(model)
}

/// Calls a reader that may panic.
fn caught<T>(format: &str, read: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(read))
        .unwrap_or_else(|_| Err(format!("the reader of {format} {GAVE_UP}")))
}

/// What is said of a reader that panicked.
const GAVE_UP: &str = "gave up";

/// Whether a reason given by [`import()`] is that its reader panicked.
pub fn is_of_a_panic(reason: &str) -> bool {
    reason.ends_with(GAVE_UP)
}

/// Faces without places: what all poses of a mesh have in common.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Outline {
    /// Vertices of the group, numbered by first use.
    pub vertices: usize,
    /// Corners of each face.
    #[serde(with = "crate::pod::array")]
    pub arities: Vec<u32>,
    /// Vertices at the corners, face by face.
    #[serde(with = "crate::pod::array")]
    pub corners: Vec<u32>,
}
