//! OBJ and MTL texts without what is broken in them, for a reader that refuses a file for one bad line.
//!
//! [`super`] hands what comes out to tobj. Vertices come first, faces name them by their own numbers and only such as
//! are there; a line that means nothing is left out, with a warning that says which line it was.

use std::collections::HashSet;

use crate::import::Warnings;

/// Lines of material files that are read of one model, and files of one line.
pub const MATERIAL_FILES: usize = 100;

/// Behind the normals of a text that has any, for faces whose own are not there.
const NO_NORMAL: &str = "vn 0 0 0\n";

/// A line of a text, those that a backslash continues joined to it.
struct Line {
    number: usize,
    text: String,
}

fn lines(text: &str) -> impl Iterator<Item = Line> {
    let mut lines = text.lines().enumerate();
    std::iter::from_fn(move || {
        let (before, first) = lines.next()?;
        let mut joined = first.to_owned();
        while let Some(open) = joined.strip_suffix('\\') {
            joined.truncate(open.len());
            joined.push(' ');
            joined.push_str(lines.next().map_or("", |(_, next)| next));
        }
        Some(Line {
            number: before + 1,
            text: joined,
        })
    })
}

/// What a text has: how many texture coordinates and normals, and which of its vertices are sound.
#[derive(Default)]
struct Counts {
    vertices: Vec<bool>,
    uvs: usize,
    normals: usize,
}

/// The text of an OBJ file with nothing left in it that tobj 4.0 refuses or panics at. Colours of vertices stay
/// where all have one.
pub fn plain(text: &str, warnings: &mut Warnings) -> String {
    let mut plain = String::with_capacity(text.len());
    let mut all = Counts::default();
    let is_colored = lines(text).all(|line| has_color(&line.text));
    for line in lines(text) {
        let (key, rest) = split(&line.text);
        let is_vertex_colored = is_colored && key == "v";
        let Some(is_sound) = all.count(key, rest) else {
            continue;
        };
        plain.push_str(key);
        if is_sound {
            let numbers = if is_vertex_colored { 6 } else { 3 };
            for word in rest.split_whitespace().take(numbers) {
                plain.push(' ');
                plain.push_str(word);
            }
            // The second coordinate of a texture of one dimension.
            plain.push_str(if key == "vt" { " 0\n" } else { "\n" });
        } else {
            plain.push_str(" 0 0 0");
            plain.push_str(if is_vertex_colored { " 0 0 0\n" } else { "\n" });
            let what = format!("`{key}` is without its finite numbers");
            warnings.push(format!("line {}: {what}", line.number));
        }
    }
    if all.normals > 0 {
        plain.push_str(NO_NORMAL);
    }
    let mut so_far = Counts::default();
    let mut libraries = HashSet::new();
    for line in lines(text) {
        let (key, rest) = split(&line.text);
        match key {
            "v" | "vt" | "vn" => {
                so_far.count(key, rest);
            }
            "f" => match face(rest, &so_far, &all) {
                Ok((face, without)) => {
                    plain.push_str(&face);
                    if let Some(why) = without {
                        warnings.push(format!("line {}: {why}: left out of the face", line.number));
                    }
                }
                Err(why) => {
                    warnings.push(format!("line {}: a face is left out: {why}", line.number));
                }
            },
            "o" | "g" | "usemtl" if key != "usemtl" || !rest.is_empty() => {
                plain.push_str(&format!("{key} {rest}\n"));
            }
            "mtllib" if libraries.len() == MATERIAL_FILES => {
                warnings.push(format!(
                    "line {}: it names more than {MATERIAL_FILES} material files",
                    line.number
                ));
            }
            "mtllib" if libraries.insert(rest.to_owned()) => {
                plain.push_str(&format!("mtllib {rest}\n"));
            }
            _ => {}
        }
    }
    plain
}

/// Whether a line is none of a vertex, or of one with a colour and nothing more.
fn has_color(line: &str) -> bool {
    let (key, rest) = split(line);
    let words = rest.split_whitespace().take(7);
    let numbers = words.filter(|word| word.parse::<f64>().is_ok());
    key != "v" || numbers.count() == 6
}

/// The first word, and what is behind it.
fn split(line: &str) -> (&str, &str) {
    let line = line.trim();
    let (key, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    (key, rest.trim())
}

impl Counts {
    /// Counts a line of numbers, and says whether it has as many finite ones as it must; none: it is another line.
    fn count(&mut self, key: &str, rest: &str) -> Option<bool> {
        let (least, most) = match key {
            "v" | "vn" => (3, 3),
            "vt" => (1, 2),
            _ => return None,
        };
        let words = rest.split_whitespace().take(most);
        let is_finite = |word: &str| word.parse().is_ok_and(f64::is_finite);
        let is_sound = words.clone().count() >= least && words.clone().all(is_finite);
        match key {
            "v" => self.vertices.push(is_sound),
            "vt" => self.uvs += 1,
            _ => self.normals += 1,
        }
        Some(is_sound)
    }
}

/// A face by the file's own numbers from 1 on, and what it has to do without: texture coordinates or normals that are not
/// there are left out of all its corners.
fn face(rest: &str, so_far: &Counts, all: &Counts) -> Result<(String, Option<String>), String> {
    let mut corners = Vec::new();
    let (mut no_uvs, mut no_normals) = (None, None);
    for word in rest.split_whitespace() {
        let mut parts = word.split('/');
        let mut index = |before: usize, there: usize, what: &str| match parts.next() {
            None | Some("") => Ok(None),
            Some(number) => index_of(number, before, there)
                .map(Some)
                .ok_or_else(|| format!("there is no {what} {}, there are {there}", short(number))),
        };
        let vertex = index(so_far.vertices.len(), all.vertices.len(), "vertex")?;
        let vertex = vertex.ok_or_else(|| format!("`{}` is no corner", short(word)))?;
        if !all.vertices[vertex - 1] {
            return Err(format!("vertex {vertex} is not three finite numbers"));
        }
        let uv = index(so_far.uvs, all.uvs, "texture coordinate");
        let normal = index(so_far.normals, all.normals, "normal");
        no_uvs = no_uvs.or(uv.clone().err());
        no_normals = no_normals.or(normal.clone().err());
        corners.push((vertex, uv.ok().flatten(), normal.ok().flatten()));
    }
    if corners.len() < 3 {
        return Err("it has fewer than three corners".into());
    }
    let stand_in = (all.normals > 0).then_some(all.normals + 1);
    let text = |i: Option<usize>| i.map_or(String::new(), |i| i.to_string());
    let mut face = String::from("f");
    for (vertex, uv, normal) in corners {
        let uv = uv.filter(|_| no_uvs.is_none());
        let normal = normal.filter(|_| no_normals.is_none());
        let normal = normal.or(stand_in.filter(|_| no_normals.is_some()));
        face.push_str(&format!(" {vertex}/{}/{}", text(uv), text(normal)));
    }
    face.push('\n');
    Ok((face, no_uvs.or(no_normals)))
}

/// A number from 1 on; negative ones count back from those that came before.
fn index_of(number: &str, before: usize, there: usize) -> Option<usize> {
    let number: i64 = number.parse().ok()?;
    let index = match number < 0 {
        true => before.checked_sub(usize::try_from(number.unsigned_abs()).ok()?)? + 1,
        false => usize::try_from(number).ok()?,
    };
    (1..=there).contains(&index).then_some(index)
}

fn short(word: &str) -> String {
    word.chars().take(24).collect()
}

/// The text of an MTL file without lines that tobj 4.0 refuses or panics at. One number of a colour stands for three (as the
/// format has it).
pub fn plain_materials(text: &str, name: &str, warnings: &mut Warnings) -> String {
    let mut plain = String::with_capacity(text.len());
    for (i, line) in text.lines().enumerate() {
        let (key, rest) = split(line);
        let numbers = || rest.split_whitespace().map_while(|word| word.parse().ok());
        let count = numbers().filter(|number: &f64| number.is_finite()).count();
        let needs = match key {
            "Ka" | "Kd" | "Ks" | "Ke" if count == 1 => {
                let grey = rest.split_whitespace().next().unwrap_or_default();
                plain.push_str(&format!("{key} {grey} {grey} {grey}\n"));
                continue;
            }
            "Ka" | "Kd" | "Ks" | "Ke" if count < 3 => "one number or three",
            "Ns" | "Ni" | "d" if count < 1 => "a number",
            "illum"
                if rest
                    .split_whitespace()
                    .next()
                    .is_none_or(|n| n.parse::<u8>().is_err()) =>
            {
                "a small whole number"
            }
            "newmtl" if rest.is_empty() => "a name",
            _ if is_map(key) && rest.is_empty() => "a file",
            _ => {
                plain.push_str(&format!("{key} {rest}\n"));
                continue;
            }
        };
        if key == "newmtl" {
            // What follows is not that of the material before.
            plain.push_str("newmtl (without a name)\n");
        }
        warnings.push(format!(
            "line {} of material file {name} is left out: `{key}` needs {needs}",
            i + 1
        ));
    }
    plain
}

fn is_map(key: &str) -> bool {
    key.starts_with("map_") || key == "bump"
}
