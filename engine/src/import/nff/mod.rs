//! NFF, the Neutral File Format of Haines' Standard Procedural Databases (NFF.TXT, 1988 to 1996), and AFF, which
//! BART, the benchmark for animated ray tracing, made of it (Lext, Assarsson and Möller, Chalmers, technical report 00-14, 2000).
//!
//! AFF adds to NFF: includes, static and animated transforms, Kochanek-Bartels keys, indexed meshes, triangles with
//! keys, ambient light, materials of three colours, named lights. One reader takes both, so an NFF file may use them too.
//!
//! - Fills: see [`look`](self::look). Polygons of one fill below one transform become one mesh, an indexed mesh becomes one part
//!   however often it is included, spheres, cones and cylinders become solids of their own.
//! - `angle` spans the picture from the middle of the top row of pixels to that of the bottom row; the camera's opening
//!   is the little wider one of the whole pixels. It is the vertical one where the picture is not square (as BART has it).
//! - All surfaces are two-sided here, `hither` does not clip, and a negative radius is one whose inside is seen.
//! - Textures are not read: a warning, and the fill's colour.

mod batch;
mod keys;
mod look;
mod moving;
mod shapes;
mod stage;
mod words;

use std::path::Path;

use super::{Files, Model};
use stage::Stage;

/// Reads an NFF or AFF file and those it includes, which are looked for beside it.
///
/// # Errors
/// A sentence without the file's name: it cannot be read, a statement is unknown or incomplete (with its line), or
/// nothing can be seen. A polygon that is none, an include that is not there, and keys without a transform are warnings.
pub fn import(path: &Path, files: &Files) -> Result<Model, String> {
    let text_of = |path: &Path| Ok(text(&files.bytes(path)?));
    import_nff_text(&text_of(path)?, &|name| text_of(&files.folder().join(name)))
}

/// Latin-1 comments do not stop the reading of the numbers beside them.
fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// `import` of a text; `open` gives those of included files by their names.
///
/// # Errors
/// See `import`.
pub fn import_nff_text(
    text: &str,
    open: &dyn Fn(&str) -> Result<String, String>,
) -> Result<Model, String> {
    let mut stage = Stage::new(open);
    stage.read(text, "")?;
    stage.finish()
}

#[cfg(test)]
mod tests;
