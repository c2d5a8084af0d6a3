//! Names of picture files: a pattern with a place for the frame number, and the format by its ending.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use orrery_engine::frame::View;
use orrery_engine::present::{
    Developed, write_developed, write_exr, write_png8, write_png16_linear,
};
use orrery_engine::trace::Picture;

use crate::failure::Failure;

/// A pattern such as `frames/f_####.png` or `f_%05d.exr`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    before: String,
    /// Digits at least; none: the pattern has no place for a number.
    digits: Option<usize>,
    after: String,
    format: Format,
}

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Png,
    Exr,
}

impl FromStr for Pattern {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let format = match Path::new(text).extension().and_then(|e| e.to_str()) {
            Some(e) if e.eq_ignore_ascii_case("png") => Format::Png,
            Some(e) if e.eq_ignore_ascii_case("exr") => Format::Exr,
            _ => return Err("expected a name that ends in .png or .exr".to_owned()),
        };
        let (before, digits, after) = split(text);
        if digits.is_some() && split(&after).1.is_some() {
            return Err("expected one place for the frame number, there are two".to_owned());
        }
        Ok(Self {
            before,
            digits,
            after,
            format,
        })
    }
}

/// What is before, in and after the first `####` or `%04d`.
fn split(text: &str) -> (String, Option<usize>, String) {
    if let Some(start) = text.find('#') {
        let digits = text[start..].chars().take_while(|&c| c == '#').count();
        return (
            text[..start].into(),
            Some(digits),
            text[start + digits..].into(),
        );
    }
    for (start, _) in text.match_indices('%') {
        let rest = &text[start + 1..];
        let width = rest.chars().take_while(char::is_ascii_digit).count();
        if rest[width..].starts_with('d') {
            // No picture has a number of more than 20 digits; a longer width is a slip of the keyboard.
            let digits = rest[..width].parse().unwrap_or(1).clamp(1, 20);
            return (text[..start].into(), Some(digits), rest[width + 1..].into());
        }
    }
    (text.into(), None, String::new())
}

impl Pattern {
    /// Whether frames get files of their own.
    pub fn has_number(&self) -> bool {
        self.digits.is_some()
    }

    /// The file of a frame.
    pub fn path(&self, frame: u64) -> PathBuf {
        match self.digits {
            Some(digits) => format!("{}{frame:0digits$}{}", self.before, self.after).into(),
            None => self.before.clone().into(),
        }
    }

    /// The pattern as C's printf has it, for programs that know no `####`.
    pub fn in_c(&self) -> String {
        let plain = |text: &str| text.replace('%', "%%");
        let number = self
            .digits
            .map_or(String::new(), |digits| format!("%0{digits}d"));
        format!("{}{number}{}", plain(&self.before), plain(&self.after))
    }

    /// Whether the files are PNG.
    pub fn is_png(&self) -> bool {
        self.format == Format::Png
    }

    /// Writes a frame's picture; the file appears only when it is whole.
    pub fn write(
        &self,
        frame: u64,
        picture: &Picture,
        view: &View,
        linear16: bool,
    ) -> Result<(), Failure> {
        let path = self.path(frame);
        match (self.format, linear16) {
            (Format::Exr, _) => write_exr(&path, picture),
            (Format::Png, true) => write_png16_linear(&path, picture),
            (Format::Png, false) => write_png8(&path, picture, view.exposure, view.tone_map),
        }
        .map_err(|error| Failure::Input(error.to_string()))
    }

    /// Writes a frame's picture that is for display already.
    pub fn write_developed(&self, frame: u64, picture: &Developed) -> Result<(), Failure> {
        write_developed(&self.path(frame), picture)
            .map_err(|error| Failure::Input(error.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(pattern: &str, frame: u64) -> String {
        let pattern = Pattern::from_str(pattern).unwrap();
        pattern.path(frame).display().to_string()
    }

    #[test]
    fn numbers_fill_their_place() {
        assert_eq!(name("frames/f_####.png", 42), "frames/f_0042.png");
        assert_eq!(name("f_%05d.exr", 42), "f_00042.exr");
        assert_eq!(name("%d.png", 42), "42.png");
        assert_eq!(name("#.png", 1234), "1234.png");
        assert_eq!(name("100%_##.PNG", 7), "100%_07.PNG");
        assert_eq!(name("still.png", 7), "still.png");
    }

    #[test]
    fn wrong_patterns_are_refused() {
        for wrong in ["f_####", "f_####.jpg", "a##b##.png", "%d_%d.png", ""] {
            assert!(Pattern::from_str(wrong).is_err(), "{wrong}");
        }
    }
}
