//! The real program in a real window: Xvfb for a screen, xdotool for hands. Fails where they are missing.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use image::RgbImage;
use orrery_tests::program::program;

/// Longer than a slow, busy machine needs to open a window or trace a small picture.
const PATIENCE: Duration = Duration::from_secs(90);

/// Nothing in it moves, so that only a key can change the picture.
const SCENE: &str = r#"(
    version: 1,
    background: (0.1, 0.2, 0.4),
    materials: { "red": (color: (0.9, 0.2, 0.1)), "floor": (color: (0.5, 0.5, 0.5)) },
    entities: [
        (id: "camera", camera: (fov: 50), transform: (eye: (0, 1.5, 6), target: (0, 0.5, 0))),
        (id: "light", light: Point(color: (1, 1, 1)), transform: (translation: (3, 6, 4))),
        (id: "ball", sphere: (radius: 1), material: "red", transform: (translation: (0, 1, 0))),
        (id: "ground", plane: (), material: "floor"),
    ],
)"#;

/// A process that does not outlive the test.
struct Killed(Child);

impl Drop for Killed {
    fn drop(&mut self) {
        // It may have ended by itself, which is as good.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A screen's number and server; a server that is killed leaves its socket behind.
struct Screen(u32, Killed);

impl Drop for Screen {
    fn drop(&mut self) {
        // Both may be gone already, which is as good.
        let _ = self.1.0.kill();
        let _ = std::fs::remove_file(format!("/tmp/.X11-unix/X{}", self.0));
    }
}

/// A folder that does not outlive the test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("orrery-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("the folder for temporary files can be written");
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Asks until there is an answer.
fn wait_for<T>(what: &str, mut ask: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(answer) = ask() {
            return answer;
        }
        assert!(start.elapsed() < PATIENCE, "gave up waiting for {what}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// A screen of its own. Servers that look for a free display number at the same time take each other's, so
/// the number comes from this process and counts up.
fn screen() -> (Screen, String) {
    static SCREENS: AtomicU32 = AtomicU32::new(0);
    let count = SCREENS.fetch_add(1, Ordering::Relaxed);
    let number = 1000 + (std::process::id() * 8 + count) % 50_000;
    let mut xvfb = Command::new("Xvfb")
        .arg(format!(":{number}"))
        .args([
            "-displayfd",
            "1",
            "-screen",
            "0",
            "800x600x24",
            "-nolisten",
            "tcp",
            // Else it starts over, deaf for a moment, whenever a hand lets go of it.
            "-noreset",
        ])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .map(Killed)
        .expect("Xvfb starts (Debian: apt install xvfb; tests/run does it)");
    let stdout = xvfb.0.stdout.take().expect("stdout is piped");
    let mut ready = String::new();
    BufReader::new(stdout)
        .read_line(&mut ready)
        .expect("Xvfb writes its display number once it is ready");
    assert_eq!(ready.trim(), number.to_string(), "Xvfb has no display");
    (Screen(number, xvfb), format!(":{number}"))
}

fn xdotool(display: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new("xdotool")
        .args(arguments)
        .env("DISPLAY", display)
        .output()
        .expect("xdotool runs (Debian: apt install xdotool; tests/run does it)");
    let text = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    output.status.success().then_some(text)
}

/// The program playing [`SCENE`] on a screen of its own, with the focus on its window.
struct Player {
    program: Killed,
    display: String,
    window: String,
    shots: PathBuf,
    _screen: Screen,
    _folder: Folder,
}

impl Player {
    fn start(name: &str, arguments: &[&str]) -> Self {
        let folder = Folder::new(name);
        let scene = folder.0.join("still_life.ron");
        std::fs::write(&scene, SCENE).expect("the scene can be written");
        let (screen, display) = screen();
        let mut program = Command::new(program())
            .arg(&scene)
            .args(["--size", "320x240", "--backend", "cpu"])
            .args(arguments)
            .current_dir(&folder.0)
            .env("ORRERY_CACHE_DIR", "")
            .env("DISPLAY", &display)
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .spawn()
            .map(Killed)
            .expect("the program starts");
        let window = wait_for("the window", || {
            let ended = program.0.try_wait().expect("the program can be asked");
            assert!(
                ended.is_none(),
                "the program ended before its window opened: {ended:?}"
            );
            let found = xdotool(
                &display,
                &["search", "--onlyvisible", "--name", "still_life"],
            )?;
            found.lines().next().map(str::to_owned)
        });
        let player = Self {
            program,
            display,
            window,
            shots: folder.0.join("screenshots"),
            _screen: screen,
            _folder: folder,
        };
        player.hand(&["windowfocus", "--sync", &player.window]);
        player
    }

    fn hand(&self, arguments: &[&str]) {
        xdotool(&self.display, arguments)
            .unwrap_or_else(|| panic!("xdotool could not {arguments:?}"));
    }

    fn hold(&self, key: &str) {
        self.hand(&["keydown", key]);
        std::thread::sleep(Duration::from_millis(700));
        self.hand(&["keyup", key]);
    }

    /// Presses F12 and reads the picture that comes of it.
    fn screenshot(&self) -> RgbImage {
        let before = pictures(&self.shots);
        self.hand(&["key", "F12"]);
        let path = wait_for("a screenshot", || {
            pictures(&self.shots)
                .into_iter()
                .find(|path| !before.contains(path))
        });
        image::open(&path)
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
            .to_rgb8()
    }

    /// Gives the window another size, and takes a screenshot once the program has seen it.
    fn screenshot_at(&self, width: u32, height: u32) -> RgbImage {
        let size = [width, height].map(|pixels| pixels.to_string());
        self.hand(&["windowsize", &self.window, &size[0], &size[1]]);
        wait_for("a screenshot of the new size", || {
            Some(self.screenshot()).filter(|shot| shot.dimensions() == (width, height))
        })
    }

    fn assert_alive(mut self) {
        let ended = self.program.0.try_wait().expect("the program can be asked");
        assert!(ended.is_none(), "the program ended by itself: {ended:?}");
    }
}

fn pictures(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = entries
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "png"))
        .collect();
    paths.sort();
    paths
}

fn is_black(picture: &RgbImage) -> bool {
    picture.pixels().all(|pixel| pixel.0 == [0; 3])
}

#[test]
fn a_key_moves_the_camera_of_a_real_window() {
    let player = Player::start("window", &[]);
    let first = player.screenshot();
    // Levels of the trees come and go over the picture, not in it.
    for key in ["3", "0", "Escape"] {
        player.hand(&["key", key]);
    }
    let again = player.screenshot();
    assert_eq!(first.dimensions(), (320, 240));
    assert!(!is_black(&first), "the picture is black");
    assert!(
        first == again,
        "the picture changed although nothing was touched"
    );
    player.hold("w");
    let moved = player.screenshot();
    assert!(!is_black(&moved), "the picture is black after flying");
    assert!(
        first != moved,
        "W was held, and the picture stayed as it was"
    );
    player.assert_alive();
}

#[test]
fn a_window_that_is_resized_goes_on_even_at_one_pixel() {
    let player = Player::start("resized", &[]);
    let wide = player.screenshot_at(401, 123);
    assert!(!is_black(&wide), "the picture is black after resizing");
    player.screenshot_at(1, 1);
    player.hold("w");
    let back = player.screenshot_at(401, 123);
    assert!(!is_black(&back), "the picture is black after one pixel");
    assert!(
        wide != back,
        "W was held at one pixel, and the camera stayed where it was"
    );
    player.assert_alive();
}

/// I raises the camera in the report's key map and does nothing in the standard one.
#[test]
fn the_keys_of_the_report_move_the_camera() {
    let player = Player::start("report-keys", &["--keys", "report"]);
    let first = player.screenshot();
    player.hold("i");
    let raised = player.screenshot();
    assert!(!is_black(&raised), "the picture is black after rising");
    assert!(
        first != raised,
        "I was held, and the picture stayed as it was"
    );
    player.assert_alive();
}
