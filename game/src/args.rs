//! The command line on one page: what can be asked, and what its words must look like.

use std::ops::Range;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use glam::UVec2;
use orrery_engine::frame::Skip;
use orrery_engine::frame::wire::{GENERATIONS_CAPACITY, SAMPLES_CAPACITY};
use orrery_engine::input::KeyMap;
use orrery_engine::trace::Level;
use orrery_engine::trace::reference::Heat;

use crate::pattern::Pattern;
use crate::words::{
    contrast, count, cutoff, frames, frames_per_sec, per_cent, pixel, scale, size, target_millis,
};

/// Watch ray-traced scenes in motion.
///
/// Orrery ray traces scenes in which everything moves: mirrors, glass, shadows and meshes, in compute
/// shaders on any GPU, without ray-tracing hardware, or on the processor where there is no GPU.
///
/// Without a command it plays a scene in a window (without a scene: the demo). Where there is no display
/// it renders a short preview into the folder `frames` instead and says so.
#[derive(Debug, Parser)]
#[command(name = "orrery", version, after_long_help = EXAMPLES, max_term_width = 100)]
pub struct Cli {
    /// What to do; nothing: play.
    #[command(subcommand)]
    pub command: Option<Command>,

    /// Scene file to play, or the bare name of one in `assets/scenes`.
    pub scene: Option<PathBuf>,

    #[command(flatten)]
    pub window: WindowArgs,

    #[command(flatten)]
    pub common: Common,
}

const EXAMPLES: &str = "\
Examples:
  orrery                                         play the demo
  orrery two_spheres                             play assets/scenes/two_spheres.ron
  orrery demo --target-ms 16.7                   60 frames a second, at whatever resolution that leaves
  orrery render demo --frames 0..90              90 pictures of the demo, 3 seconds, into frames/
  orrery render demo --frames 0..900 --video demo.mp4   the same and more, and a film of them
  orrery render demo --frames 30 --out f30.exr   one picture, linear light, 32-bit float
  orrery render demo --frames 30 --explain 640,360   every ray of a pixel: what it met, added and cost
  orrery bench frame --backend cpu               how long a frame of the demo takes
  orrery bench hope                              100,000 triangles in motion, half of them deforming: frames a second
  orrery bench growth --report growth            frame time against triangles, instances, lights, depth, pixels
  orrery bench skips                             what the GPU saves by tracing with what a scene needs alone
  orrery bench motion                            what it costs that things move, up to 100,000 of them
  orrery bench structures                        the 2008 report's bounding spheres beside boxes
  orrery bench stability --backend cpu           leaks, self-hits, lost boxes, far and tiny scenes, bad input
  orrery bench trace --suite mirrors_21           rays by kind and whole frames
  orrery bench cpu                               rays by kind on the processor, one thread and all
  orrery bench spd --report spd                  the Standard Procedural Databases, rays as published
  orrery bench bart --frames 100 --report bart   kitchen, robots and museum, played to their last frame
  orrery bench start                             large scenes from file to ready to trace, without and with the cache
  orrery bench import --report import            odd and broken model files: loaded or refused, never a panic
  orrery compare before.cap after.cap            two captures of --profile side by side; exit code 1 on a regression
  orrery check my_scene.ron                      every problem of a scene or model file with its place
  orrery model.obj                               a model by itself, lit and framed

Large models are kept, read and with their trees, in the user's cache folder (Linux: ~/.cache/orrery), at most 2 GiB, so that
they start faster the next time; so is, for windows, what the graphics driver compiles, where it lets that be kept. ORRERY_CACHE_DIR
names another folder; empty, nothing is kept.

ORRERY_CPU=avx512, avx2 or portable says which of the processor's instructions rays are traced with there; without it, or where
the processor lacks them, the widest there are. Pictures are the same, bit for bit. Another word is an error.

Exit codes: 0 done, 1 the input is bad, 2 usage, 3 no usable device.";

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Play a scene with the editor open, standing still at first.
    ///
    /// Ctrl+S saves the scene's file; F1 shows every key. Unsaved edits are written beside the file and offered
    /// when it is opened again. Files that change on disk are read again.
    Edit {
        /// Scene file, or the bare name of one in `assets/scenes`.
        scene: PathBuf,
    },
    /// Render exact frames of a scene into picture files.
    ///
    /// The same frame number gives the same picture, bit for bit, on every run of the same backend. A
    /// file appears under its name only when it is whole, so a run that was stopped can be taken up again
    /// with `--resume`.
    ///
    /// `.png` files hold what a display would show: exposure, tone curve and sRGB applied, 8 bit; with
    /// `--linear16`, linear light clipped to [0, 1], 16 bit. `.exr` files hold linear light as it is.
    Render(RenderRequest),
    /// Measure, with the error bar beside the time.
    ///
    /// Prints a row a number, and writes them as JSON where asked. `--dump` writes the exact work that
    /// was measured, so that other tracers can be timed on the same rays.
    Bench(BenchRequest),
    /// Compare two captures, A before and B after a change.
    ///
    /// A capture is what `--profile NAME.cap` writes. The table has a row for the frame, for each system, step and pass and
    /// for each count: medians over the frames of either, and how much more B takes. Times are without the wait for the
    /// display. A row is a regression if B takes more than A by the limit, and, of times, by at least a hundredth of the
    /// frame, below which the clock says little. Exit code 1 if any is.
    Compare(CompareRequest),
    /// Read a scene file and list every problem with its line, field and what was expected.
    Check {
        /// Scene file, or the bare name of one in `assets/scenes`.
        file: PathBuf,
    },
    /// List the graphics adapters and which one would be chosen.
    Adapters,
}

/// Options of `render`.
#[derive(Debug, Args)]
pub struct RenderRequest {
    /// Scene file, or the bare name of one in `assets/scenes`.
    pub scene: PathBuf,
    /// Frames `A..B`: A and all up to, but not including, B. A single number is that frame alone.
    #[arg(long, value_name = "A..B", default_value = "0", value_parser = frames)]
    pub frames: Range<u64>,
    /// Frame numbers a second of scene time.
    #[arg(long, value_name = "N", default_value = "30", value_parser = frames_per_sec)]
    pub fps: f64,
    /// File names: `####` or `%04d` becomes the frame number; the ending `.png` or `.exr` the format.
    #[arg(long, value_name = "PATTERN", default_value = "frames/frame_####.png")]
    pub out: Pattern,
    /// PNG files hold linear light, 16 bit.
    #[arg(long)]
    pub linear16: bool,
    /// Leave frames alone whose file is there already.
    #[arg(long)]
    pub resume: bool,
    /// When all pictures are there, also make a film of them, such as film.mp4, through the program ffmpeg, which must be
    /// installed.
    #[arg(long, value_name = "FILE")]
    pub video: Option<PathBuf>,
    /// Draw the bounding volumes of a level of all trees over the picture: 1 to 9, 1 being the root's children, or
    /// `leaves`. The tree over instances is pale, those of meshes have a colour a level.
    #[arg(long, value_name = "N|leaves")]
    pub levels: Option<Level>,
    /// Instead of pictures: print every ray of this pixel of the first frame as a tree, with what each met, its weight, what it
    /// added in linear light and what it cost; by the f64 reference. 0,0 is the top left.
    #[arg(long, value_name = "X,Y", value_parser = pixel, conflicts_with_all = ["levels", "linear16", "resume"])]
    pub explain: Option<UVec2>,
    /// Instead of the picture: what each pixel costs, from dark (least) to white (most). Rays of every kind, the depth of the
    /// longest chain of them, or the boxes or shapes (triangles among them) that they were held against; by the f64 reference.
    #[arg(long, value_name = "rays|depth|boxes|shapes", conflicts_with_all = ["levels", "linear16", "explain"])]
    pub heat: Option<Heat>,
}

/// Options of `compare`.
#[derive(Debug, Args)]
#[command(after_long_help = COMPARE_EXAMPLES)]
pub struct CompareRequest {
    /// The capture before.
    pub a: PathBuf,
    /// The capture after.
    pub b: PathBuf,
    /// Per cent that B may take more than A.
    #[arg(long, value_name = "PERCENT", default_value_t = 10.0, value_parser = per_cent)]
    pub limit: f64,
    /// Every row, not only those that differ by more than a hundredth of the frame or by the limit.
    #[arg(long)]
    pub all: bool,
}

const COMPARE_EXAMPLES: &str = "\
Examples:
  orrery render demo --frames 0..90 --profile before.cap
  orrery render demo --frames 0..90 --profile after.cap --depth 4
  orrery compare before.cap after.cap --limit 5";

/// Options of `bench`.
#[derive(Debug, Args)]
pub struct BenchRequest {
    /// Which benchmark; `--list` names them.
    #[arg(default_value = "frame")]
    pub name: String,
    /// Name the benchmarks and stop.
    #[arg(long)]
    pub list: bool,
    /// Scene file, or the bare name of one in `assets/scenes`.
    #[arg(long, value_name = "SCENE", default_value = "demo")]
    pub scene: PathBuf,
    /// First frame measured, at 30 frames a second of scene time.
    #[arg(long, value_name = "N", default_value_t = 30)]
    pub frame: u64,
    /// Frames measured, at least 20.
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u64).range(20..=100_000))]
    pub repeat: u64,
    /// Also write the rows as JSON.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Accuracy, growth: also write the page, charts and tables, into this folder. SPD, BART: pictures and a contact sheet. Import: what became of each file.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Also write the work itself (meshes, instances, spheres, rays by kind, hits) into this folder.
    #[arg(long, value_name = "DIR")]
    pub dump: Option<PathBuf>,
    /// Motion: also time this program's trees on the same boxes and triangles. It is given folders as `--dump`
    /// writes them and prints `key=value` lines. May be given several times.
    #[arg(long, value_name = "PROGRAM")]
    pub rival: Vec<PathBuf>,
    /// Stability: only this suite, by a name that `bench stability --list` prints. Trace, cpu: only this scene. May be given several times.
    #[arg(long, value_name = "NAME")]
    pub suite: Vec<String>,
    /// Stability: rays of each aim of the suites that count rays, such as 1e9.
    #[arg(long, value_name = "N", value_parser = count)]
    pub rays: Option<u64>,
    /// BART: only so many frames, spread over the run, at least 2; without it, all. Hope: so many; without it, 1000.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(2..=100_000))]
    pub frames: Option<u64>,
    /// Trace: a folder of scenes in the dump format that have a camera and a light. SPD, BART: the folder of their scene files; without it, `../shared/scenes/spd-nff` and `bart-aff` beside it. Import: the folder
    /// of the folders that are read; without it, `../shared/scenes`.
    #[arg(long, value_name = "DIR")]
    pub files: Option<PathBuf>,
    /// Trace, cpu, hope, growth, skips, motion, profile, structures, stability, accuracy, SPD, BART: few things and triangles, for a look at the rows within seconds.
    #[arg(long)]
    pub small: bool,
}

/// What a window is to be like.
#[derive(Debug, Args)]
#[command(next_help_heading = "Window options")]
pub struct WindowArgs {
    /// Keys: `standard`, or `report` for those of the 2008 report.
    #[arg(long, global = true, value_name = "MAP", default_value = "standard", value_parser = KeyMap::NAMES)]
    pub keys: String,
    /// Show frames as fast as they come instead of waiting for the display.
    #[arg(long, global = true)]
    pub no_vsync: bool,
    /// Traced pixels for each of the window's, along an axis, from 0.05 to 1; without it, as many as `--target-ms` allows.
    #[arg(long, global = true, value_name = "F", value_parser = scale, conflicts_with = "target_ms")]
    pub scale: Option<f64>,
    /// Milliseconds that a frame is to take, from 1 to 10000: 16.7 is 60 a second, 33 is 30.
    ///
    /// Kept by tracing fewer pixels than the window has while things move, and by more samples a frame while nothing does.
    /// What counts is work, on a GPU by its own clock, not the wait for the display; the title shows it, as in "14.2 of
    /// 16.7 ms - 1280x720 x0.79". Without it, the processor (and software Vulkan) keeps 50 ms as far as a quarter of the
    /// pixels along an axis goes; a GPU traces every pixel unless its frames take more than 100 ms. `--scale 1` traces every pixel however long it takes.
    #[arg(long, global = true, value_name = "MS", value_parser = target_millis)]
    pub target_ms: Option<f64>,
    /// Samples a pixel up to which a picture refines while nothing changes, one or, within a frame's time, several a frame; 0: it does not.
    #[arg(long, global = true, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(0..=i64::from(SAMPLES_CAPACITY)))]
    pub refine: u32,
}

/// What every command understands.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Common options")]
pub struct Common {
    /// What traces: compute shaders, all processor cores, or the slow f64 reference. `auto` takes the GPU
    /// where there is one and the processor otherwise.
    #[arg(long, global = true, value_name = "B", value_enum, default_value_t = BackendChoice::Auto)]
    pub backend: BackendChoice,
    /// Graphics adapter by its number in `orrery adapters`, or by a part of its name.
    #[arg(long, global = true, value_name = "N|NAME")]
    pub adapter: Option<String>,
    /// Pixels across and down, such as 1280x720.
    #[arg(long, global = true, value_name = "WxH", value_parser = size)]
    pub size: Option<UVec2>,
    /// Generations of rays followed, whatever the scene says; 1 is camera rays alone.
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(GENERATIONS_CAPACITY)))]
    pub depth: Option<u32>,
    /// Samples a pixel, the same in every picture and well spread whatever their number. Cost grows with it.
    #[arg(long, global = true, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=i64::from(SAMPLES_CAPACITY)))]
    pub samples: u32,
    /// Take all samples only where the picture's first samples differ from a neighbour's by more than this,
    /// relatively; elsewhere one. Without a number: 0.1.
    #[arg(long, global = true, value_name = "CONTRAST", num_args = 0..=1, require_equals = true, default_missing_value = "0.1", value_parser = contrast)]
    pub adaptive: Option<f32>,
    /// Leave out shadow, reflected and refracted rays too faint to matter: the largest error that all of them together may
    /// cause in a pixel, in linear light (0.002 is half a step of 8 bits); 0 leaves out none. First samples of adaptive
    /// pictures leave out none.
    #[arg(long, global = true, value_name = "E", default_value_t = 0.0, value_parser = cutoff)]
    pub cutoff: f32,
    /// Do without these ways to leave out what no picture shows, to see what they are worth; `--help` has them all.
    #[arg(long, global = true, value_name = "SKIP", value_delimiter = ',', long_help = without_help())]
    pub without: Vec<Skip>,
    /// Playing and rendering: write when every system and pass of every frame ran, and for how long, as .csv, as .json for
    /// Perfetto (ui.perfetto.dev) or as .cap for `orrery compare`.
    #[arg(long, global = true, value_name = "FILE")]
    pub profile: Option<PathBuf>,
    /// With `--profile`: write nothing until a frame works longer than so many milliseconds, then that one and up to 600
    /// before it, and name what took longer than usual. The first ten frames, which build and compile, are let through.
    #[arg(long, global = true, value_name = "MS", value_parser = target_millis)]
    pub capture_on_spike: Option<f64>,
    /// What is logged to stderr: off, error, warn, info, debug or trace.
    #[arg(long, global = true, value_name = "LEVEL", default_value = "warn")]
    pub log: String,
}

/// Words of `--backend`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BackendChoice {
    /// The GPU where there is one, the processor otherwise.
    Auto,
    /// Compute shaders, f32.
    Gpu,
    /// All processor cores, f32.
    Cpu,
    /// One slow, obvious f64 tracer.
    Reference,
}

fn without_help() -> String {
    let mut help = "Do without these ways to leave out what no picture shows, to see what they are worth. The picture is the same (to the roundings of another kernel, and to `--cutoff`); the profiler of a window counts what each saves.\n".to_owned();
    for skip in Skip::ALL {
        help.push_str(&format!("\n{:<13} {}", skip.name(), skip.about()));
    }
    help
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_well_formed() {
        use clap::CommandFactory;
        Cli::command().debug_assert();
    }

    #[test]
    fn a_target_excludes_a_scale() {
        let parsed = Cli::try_parse_from(["orrery", "demo", "--target-ms", "33"]);
        assert!(parsed.is_ok_and(|cli| cli.window.target_ms == Some(33.0)));
        let both = Cli::try_parse_from(["orrery", "demo", "--target-ms", "33", "--scale", "0.5"]);
        assert!(both.is_err());
    }

    #[test]
    fn what_is_done_without_goes_by_name() {
        let parsed = Cli::try_parse_from(["orrery", "demo", "--without", "away,still"]);
        assert!(parsed.is_ok_and(|cli| cli.common.without == [Skip::Away, Skip::Still]));
        let help = without_help();
        assert!(Skip::ALL.iter().all(|skip| help.contains(skip.about())));
    }
}
