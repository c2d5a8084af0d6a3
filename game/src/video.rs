//! A film of the pictures that `render` wrote, through ffmpeg, which must be installed.
//!
//! The pictures stay: a film that was interrupted is taken up again with `--resume`, and only its last step, which is
//! quick, is done twice.

use std::ffi::OsString;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::failure::Failure;
use crate::pattern::Pattern;

/// The program.
const FFMPEG: &str = "ffmpeg";
/// H.264 at a quality at which most see no difference, playable everywhere; its sizes are even.
const ENCODING: [&str; 10] = [
    "-vf",
    "pad=ceil(iw/2)*2:ceil(ih/2)*2",
    "-c:v",
    "libx264",
    "-crf",
    "16",
    "-pix_fmt",
    "yuv420p",
    "-movflags",
    "+faststart",
];

/// Says before anything is rendered whether a film can be made of it.
pub fn check(film: &Path, pictures: &Pattern) -> Result<(), Failure> {
    if !pictures.is_png() || !pictures.has_number() {
        return Err(Failure::Usage(
            "`--video` makes a film of numbered .png files: `--out` needs a place for the frame number, as in frames/f_####.png".into(),
        ));
    }
    match Command::new(FFMPEG).arg("-version").output() {
        Ok(_) => Ok(()),
        Err(error) => Err(Failure::Usage(format!(
            "`--video {}` needs the program {FFMPEG}, which cannot be run ({error}); install it, or leave `--video` out: the pictures alone need nothing",
            film.display()
        ))),
    }
}

/// Makes the film; it appears under its name only when it is whole.
pub fn make(film: &Path, pictures: &Pattern, frames: &Range<u64>, fps: f64) -> Result<(), Failure> {
    let failed = |why: String| Failure::Input(format!("{}: {why}", film.display()));
    if let Some(folder) = film.parent() {
        std::fs::create_dir_all(folder).map_err(|error| failed(error.to_string()))?;
    }
    let unfinished = unfinished(film);
    let done = Command::new(FFMPEG)
        .args(arguments(pictures, frames, fps))
        .arg(&unfinished)
        .output()
        .map_err(|error| failed(format!("{FFMPEG} cannot be run: {error}")))?;
    if !done.status.success() {
        // There may be none.
        let _ = std::fs::remove_file(&unfinished);
        let said = String::from_utf8_lossy(&done.stderr);
        let said = said.trim().lines().last().unwrap_or("it says nothing");
        return Err(failed(format!(
            "{FFMPEG} failed ({}): {said}; the pictures are whole",
            done.status
        )));
    }
    std::fs::rename(&unfinished, film).map_err(|error| failed(error.to_string()))
}

/// What ffmpeg is told, but for the name of the film.
fn arguments(pictures: &Pattern, frames: &Range<u64>, fps: f64) -> Vec<OsString> {
    let number = |number: u64| OsString::from(number.to_string());
    let mut told: Vec<OsString> = ["-y", "-loglevel", "error", "-framerate"]
        .map(OsString::from)
        .into();
    told.push(fps.to_string().into());
    told.push("-start_number".into());
    told.push(number(frames.start));
    told.push("-i".into());
    told.push(pictures.in_c().into());
    told.push("-frames:v".into());
    told.push(number(frames.end - frames.start));
    told.extend(ENCODING.map(OsString::from));
    told
}

/// Beside the film, with its ending, by which ffmpeg knows the format.
fn unfinished(film: &Path) -> PathBuf {
    let mut name = OsString::from(".unfinished_");
    name.push(film.file_name().unwrap_or_default());
    film.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ffmpeg_is_told_which_pictures_and_how_fast() {
        let pictures: Pattern = "100%_##.png".parse().unwrap();
        let told = arguments(&pictures, &(30..90), 24.0);
        let told: Vec<&str> = told.iter().filter_map(|word| word.to_str()).collect();
        let after = |name: &str| told[told.iter().position(|word| *word == name).unwrap() + 1];
        assert_eq!(after("-framerate"), "24");
        assert_eq!(after("-start_number"), "30");
        assert_eq!(after("-i"), "100%%_%02d.png");
        assert_eq!(after("-frames:v"), "60");
    }

    #[test]
    fn films_need_numbered_png_files() {
        for wrong in ["still.png", "f_####.exr"] {
            let error = check(Path::new("x.mp4"), &wrong.parse().unwrap()).unwrap_err();
            assert!(error.to_string().contains("####"), "{error}");
        }
    }

    #[test]
    fn an_unfinished_film_lies_beside_the_finished_one() {
        assert_eq!(
            unfinished(Path::new("a/b.mp4")),
            Path::new("a/.unfinished_b.mp4")
        );
    }
}
