//! What is wrong with a scene file, where, and what would be right.
//!
//! Problems are collected, never thrown at the first: one broken entity does not hide the next.

use std::fmt;
use std::path::{Path, PathBuf};

/// One thing that is wrong (or, as a warning, odd) in a scene file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The file the problem is in, as it was named by the caller.
    pub file: PathBuf,
    /// Line, from 1; 0 where the file could not be read at all.
    pub line: usize,
    /// Column in characters, from 1; 0 where the file could not be read at all.
    pub column: usize,
    /// The field by its path in the file, such as `entities[3] "moon".sphere.radius`; may be empty.
    pub field: String,
    /// What was found.
    pub what: String,
    /// What would have been right.
    pub expected: Option<String>,
    /// The nearest valid name.
    pub suggestion: Option<String>,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if self.line > 0 {
            write!(f, ":{}:{}", self.line, self.column)?;
        }
        if !self.field.is_empty() {
            write!(f, ": {}", self.field)?;
        }
        write!(f, ": {}", self.what)?;
        if let Some(expected) = &self.expected {
            write!(f, "; expected {expected}")?;
        }
        if let Some(suggestion) = &self.suggestion {
            write!(f, "; did you mean `{suggestion}`?")?;
        }
        Ok(())
    }
}

/// All that is wrong with a file, in order of place; one a line when printed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Problems(pub Vec<Problem>);

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, problem) in self.0.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            write!(f, "{problem}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Problems {}

/// What a scene file holds, counted over all that is right in it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Entities, children included.
    pub entities: usize,
    /// Entries of the material table.
    pub materials: usize,
    /// Entities that shine.
    pub lights: usize,
    /// Entities that are cameras.
    pub cameras: usize,
    /// Spheres, planes, boxes and polygons.
    pub shapes: usize,
    /// Entities that name a mesh file.
    pub meshes: usize,
    /// Triangles of the meshes, each use counted.
    pub triangles: usize,
    /// Timeline tracks and paths.
    pub tracks: usize,
    /// Seconds until the timeline starts again, or its last key if it does not loop.
    pub timeline_secs: f64,
    /// Animations of the mesh files, each use counted.
    pub clips: usize,
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count =
            |n: usize, one: &str, many: &str| format!("{n} {}", if n == 1 { one } else { many });
        write!(
            f,
            "{}, {}, {}, {}, {}, {} ({}), {} over {} s, {}",
            count(self.entities, "entity", "entities"),
            count(self.materials, "material", "materials"),
            count(self.lights, "light", "lights"),
            count(self.cameras, "camera", "cameras"),
            count(self.shapes, "shape", "shapes"),
            count(self.meshes, "mesh", "meshes"),
            count(self.triangles, "triangle", "triangles"),
            count(self.tracks, "timeline track", "timeline tracks"),
            self.timeline_secs,
            count(self.clips, "clip", "clips"),
        )
    }
}

/// The answer of [`super::check`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// What keeps the file from being loaded; empty: it loads.
    pub problems: Problems,
    /// What is odd but does not keep it from being loaded.
    pub warnings: Vec<Problem>,
    /// What is right.
    pub summary: Summary,
}

/// What [`super::load`] has to say when it succeeds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadReport {
    /// What is odd.
    pub warnings: Vec<Problem>,
    /// What was loaded.
    pub summary: Summary,
}

/// Where something stands in a file: a byte offset and the path of the field.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Byte offset into the text.
    pub at: usize,
    /// Path of the field.
    pub field: String,
}

/// A problem whose place is not yet a line and a column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct RawProblem {
    pub place: Place,
    pub what: String,
    pub expected: Option<String>,
    pub suggestion: Option<String>,
}

/// Turns byte offsets into lines and columns, and puts the problems in order of place.
pub(super) fn locate(raw: Vec<RawProblem>, text: &str, file: &Path) -> Vec<Problem> {
    let starts: Vec<usize> = std::iter::once(0)
        .chain(text.match_indices('\n').map(|(i, _)| i + 1))
        .collect();
    let mut raw = raw;
    raw.sort_by_key(|problem| problem.place.at);
    raw.dedup();
    // Where the last one was, and its column: a line may be the whole file, with thousands of problems on it.
    let mut last = (0, 1);
    let located = raw.into_iter().map(|problem| {
        let mut at = problem.place.at.min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        let line = starts.partition_point(|&start| start <= at);
        let start = starts[line - 1];
        let from = if last.0 >= start { last } else { (start, 1) };
        last = (at, from.1 + text[from.0..at].chars().count());
        Problem {
            file: file.to_owned(),
            line,
            column: last.1,
            field: problem.place.field,
            what: problem.what,
            expected: problem.expected,
            suggestion: problem.suggestion,
        }
    });
    located.collect()
}

/// The candidate nearest to `name` by optimal string alignment distance, if it is near enough to be meant.
pub(super) fn nearest<'a>(
    name: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Option<String> {
    let lower = name.to_lowercase();
    // Longer names are nobody's misspelling and would make the comparison quadratic in hostile input.
    if lower.chars().count() > 64 {
        return None;
    }
    let limit = 1 + lower.chars().count() / 3;
    candidates
        .into_iter()
        .filter(|candidate| candidate.len() <= 64)
        .map(|candidate| (edit_distance(&lower, &candidate.to_lowercase()), candidate))
        .filter(|&(distance, _)| distance <= limit)
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate.to_owned())
}

/// Insertions, deletions, replacements and swaps of neighbours that lead from `a` to `b` (optimal string
/// alignment).
pub fn edit_distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for (i, row) in rows.iter_mut().enumerate() {
        row[0] = i;
    }
    for (j, cell) in rows[0].iter_mut().enumerate() {
        *cell = j;
    }
    for i in 1..=a.len() {
        for j in 1..=b.len() {
            let replaced = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = replaced.min(rows[i - 1][j] + 1).min(rows[i][j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(rows[i - 2][j - 2] + 1);
            }
            rows[i][j] = best;
        }
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_found_and_a_far_one_is_not() {
        let names = ["radius", "center", "material"];
        assert_eq!(nearest("radus", names).as_deref(), Some("radius"));
        assert_eq!(nearest("raduis", names).as_deref(), Some("radius"));
        assert_eq!(nearest("Material", names).as_deref(), Some("material"));
        assert_eq!(nearest("zzz", names), None);
    }

    #[test]
    fn edits_of_known_words_are_counted() {
        let words = [
            ("", "", 0),
            ("demo", "demo", 0),
            ("dmeo", "demo", 1),
            ("kitten", "sitting", 3),
            ("", "abc", 3),
        ];
        for (a, b, count) in words {
            assert_eq!(edit_distance(a, b), count, "{a} {b}");
            assert_eq!(edit_distance(b, a), count, "{b} {a}");
        }
    }

    #[test]
    fn offsets_become_lines_and_columns_in_characters() {
        let raw = |at| RawProblem {
            place: Place {
                at,
                field: String::new(),
            },
            what: at.to_string(),
            expected: None,
            suggestion: None,
        };
        let text = "aé\nb";
        let raws = vec![raw(4), raw(1), raw(3), raw(2), raw(99)];
        let found = locate(raws, text, Path::new("f"));
        let places: Vec<_> = found.iter().map(|p| (p.line, p.column)).collect();
        assert_eq!(places, [(1, 2), (1, 2), (1, 3), (2, 1), (2, 2)]);
    }
}
