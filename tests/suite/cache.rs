//! Models kept from one start to the next: the same model and picture, bit for bit, whatever happens to the files.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, SystemTime};

use glam::{UVec2, Vec3};
use orrery_engine::Engine;
use orrery_engine::frame::{FrameScene, TraceSettings};
use orrery_engine::import::{Cache, Loader};
use orrery_engine::scene;
use orrery_engine::trace::cpu::CpuTracer;
use orrery_tests::program::program;
use orrery_tests::random_scene::Random;
use orrery_tests::tracers::picture;

use crate::cli::folder;

/// Bytes of an entry before its content.
const HEAD: usize = 96;
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";

/// A loader that keeps every model, in that folder.
fn loader(folder: &Path) -> Loader {
    let mut cache = Cache::in_folder(folder);
    cache.least = Duration::ZERO;
    Loader {
        cache: Some(cache),
        ..Loader::default()
    }
}

/// All of a model, every bit of its numbers, or why there is none.
pub(crate) fn loaded(loader: &Loader, path: &Path, smooth_angle: Option<f64>) -> String {
    let models = loader.load(&[(path.to_owned(), smooth_angle)]);
    format!("{models:?}")
}

/// Whether the model comes from the cache, and what it is.
pub(crate) fn found(cache: &Path, path: &Path) -> (bool, String) {
    let loader = loader(cache);
    let model = loaded(&loader, path, None);
    (loader.progress.now().found == 1, model)
}

/// The files in a folder.
fn files_in(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    files.sort();
    files
}

/// The one file in a folder.
fn only(folder: &Path) -> PathBuf {
    let files = files_in(folder);
    assert_eq!(files.len(), 1, "{files:?}");
    files[0].clone()
}

/// A small picture of a model.
fn traced(loader: &Loader, path: &Path) -> Vec<[u32; 3]> {
    let mut engine = Engine::new();
    engine.world.insert_resource(loader.clone());
    scene::load(&mut engine.world, path).expect("a scene");
    engine.frame();
    let settings = TraceSettings {
        size: UVec2::new(64, 48),
        ..TraceSettings::default()
    };
    let scene = engine.world.resource::<FrameScene>();
    let picture = picture(&mut CpuTracer::new(), scene, &settings).expect("a picture");
    let bits = |pixel: &Vec3| pixel.to_array().map(f32::to_bits);
    picture.pixels.iter().map(bits).collect()
}

/// An OBJ file with a material and a picture, an AFF file with an include.
pub(crate) fn models(folder: &Path) -> [PathBuf; 2] {
    write(folder, "square.bmp", &bmp([40, 80, 250]));
    write(
        folder,
        "square.mtl",
        b"newmtl a\nKd 1 0.5 0.2\nmap_Kd square.bmp\nmap_Bump none.png\n",
    );
    let obj = format!("mtllib square.mtl\n{SQUARE}usemtl a\nf 1/1 2/2 3/3 4/4\n");
    write(
        folder,
        "ball.aff",
        b"f 1 0.5 0 1 0 0 0 0\ns 0 0 0 1\np 3\n-2 0 0\n2 0 0\n0 3 0\n",
    );
    let aff = b"b 0.1 0.2 0.3\nl 4 4 4\ni 0 ball.aff\nxs 1 1 1 1 0 0 0 3 0 0 { i 0 ball.aff }\n";
    [
        write(folder, "square.obj", obj.as_bytes()),
        write(folder, "scene.aff", aff),
    ]
}

pub(crate) fn write(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, bytes).expect("a file can be written");
    path
}

/// A picture of one texel.
fn bmp(color: [u8; 3]) -> Vec<u8> {
    let mut bytes = b"BM".to_vec();
    bytes.extend([58_u32, 0, 54, 40, 1, 1].map(u32::to_le_bytes).concat());
    bytes.extend([1, 0, 24, 0]);
    bytes.extend([0; 24]);
    bytes.extend([color[2], color[1], color[0], 0]);
    bytes
}

/// Models of every format: those of the corpus, and [`models`].
fn all_models(folder: &Path) -> Vec<PathBuf> {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    let mut all = models(folder).to_vec();
    for format in files_in(&corpus) {
        all.extend(files_in(&format));
    }
    assert!(all.len() > 6, "no corpus in {}", corpus.display());
    all
}

#[test]
fn a_kept_model_is_the_one_that_was_made() {
    let folder = folder("cache_same");
    let kitchen =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes/bart-aff/kitchen");
    let kitchen = kitchen.join("kitchen.aff");
    let mut all = all_models(&folder);
    if kitchen.is_file() {
        all.push(kitchen);
    } else {
        eprintln!("skipped BART's kitchen, which is not there");
    }
    for (number, path) in all.iter().enumerate() {
        let name = path.display();
        let cache = folder.join(number.to_string());
        let plain = loaded(&Loader::default(), path, None);
        assert_eq!(found(&cache, path), (false, plain.clone()), "{name}");
        assert_eq!(files_in(&cache).len(), 1, "{name} is not kept");
        let (hit, kept) = found(&cache, path);
        assert!(hit, "{name} is made anew");
        assert!(kept == plain, "{name}: the kept model is another");
        let same = traced(&loader(&cache), path) == traced(&Loader::default(), path);
        assert!(same, "{name}: another picture");
    }
}

#[test]
fn no_flipped_bit_changes_a_model() {
    let folder = folder("cache_flips");
    let cache = folder.join("cache");
    let mut random = Random::new(7);
    for path in models(&folder) {
        let _ = fs::remove_dir_all(&cache);
        let (_, plain) = found(&cache, &path);
        let expected = traced(&Loader::default(), &path);
        let entry = only(&cache);
        let whole = fs::read(&entry).expect("an entry");
        let drawn: Vec<usize> = (0..400).map(|_| random.below(whole.len())).collect();
        let places = (0..HEAD).chain(drawn);
        for (number, place) in places.enumerate() {
            let mut broken = whole.clone();
            broken[place] ^= 1 << random.below(8);
            fs::write(&entry, &broken).expect("an entry");
            if number % 40 == 0 {
                assert!(traced(&loader(&cache), &path) == expected, "byte {place}");
            } else {
                assert_eq!(found(&cache, &path), (false, plain.clone()), "byte {place}");
            }
            assert!(fs::read(&entry).expect("an entry") == whole, "not replaced");
        }
        assert_eq!(found(&cache, &path), (true, plain.clone()));
        let longer = [whole.as_slice(), b"and more"].concat();
        let empty: &[u8] = &[];
        for broken in [
            empty,
            &whole[..10],
            &whole[..HEAD],
            &whole[..whole.len() - 1],
            &longer,
        ] {
            fs::write(&entry, broken).expect("an entry");
            assert_eq!(found(&cache, &path), (false, plain.clone()));
            assert!(fs::read(&entry).expect("an entry") == whole, "not replaced");
        }
        // A model under another's name.
        let other = write(
            &folder,
            "other.obj",
            format!("{SQUARE}f 1 2 3\n").as_bytes(),
        );
        let (_, plain_other) = found(&cache, &other);
        let others = files_in(&cache).into_iter().find(|file| *file != entry);
        let others = others.expect("two entries");
        for broken in [whole.as_slice(), b"ORRERY\n"] {
            fs::write(&others, broken).expect("an entry");
            assert_eq!(found(&cache, &other), (false, plain_other.clone()));
            assert_eq!(found(&cache, &other), (true, plain_other.clone()));
        }
        fs::remove_file(&other).expect("a file");
    }
}

#[test]
fn what_a_model_refers_to_is_seen_to_change() {
    let folder = folder("cache_changes");
    let cache = folder.join("cache");
    let [obj, aff] = models(&folder);
    let shorter = format!("{SQUARE}f 1 2 3\n");
    let changes: [(&Path, &str, &[u8]); 6] = [
        (
            &obj,
            "square.mtl",
            b"newmtl a\nKd 0 0 1\nmap_Kd square.bmp\nmap_Bump none.png\n",
        ),
        (&obj, "square.bmp", &bmp([1, 2, 3])),
        // Looked for and missed before.
        (&obj, "none.png", &bmp([128, 128, 255])),
        (&obj, "square.obj", shorter.as_bytes()),
        (&aff, "ball.aff", b"f 0 1 0 1 0 0 0 0\ns 0 0 0 2\n"),
        (&aff, "scene.aff", b"l 4 4 4\ni 0 ball.aff\n"),
    ];
    for (path, name, bytes) in changes {
        let (_, before) = found(&cache, path);
        assert_eq!(found(&cache, path), (true, before.clone()), "before {name}");
        write(&folder, name, bytes);
        let plain = loaded(&Loader::default(), path, None);
        assert_ne!(plain, before, "{name} does not matter");
        assert_eq!(found(&cache, path), (false, plain.clone()), "{name}");
        assert_eq!(found(&cache, path), (true, plain), "after {name}");
    }
    fs::remove_file(folder.join("ball.aff")).expect("a file");
    let plain = loaded(&Loader::default(), &aff, None);
    assert_eq!(found(&cache, &aff), (false, plain));
    // The same content elsewhere is the same model, if what it refers to is.
    let elsewhere = folder.join("elsewhere");
    fs::create_dir(&elsewhere).expect("a folder");
    let [copy, _] = models(&elsewhere);
    found(&cache, &copy);
    let moved = folder.join("moved");
    fs::rename(&elsewhere, &moved).expect("a folder");
    assert!(found(&cache, &moved.join("square.obj")).0);
    let angle = |angle| loaded(&loader(&cache), &moved.join("square.obj"), angle);
    assert_ne!(angle(Some(60.0)), angle(None), "another smoothing");
}

#[test]
fn a_folder_that_cannot_be_used_is_no_error() {
    let folder = folder("cache_unusable");
    let [obj, _] = models(&folder);
    let plain = loaded(&Loader::default(), &obj, None);
    let file = write(&folder, "file", b"");
    for cache in [
        file.join("below"),
        file.clone(),
        PathBuf::from("/proc/nowhere"),
    ] {
        assert_eq!(found(&cache, &obj), (false, plain.clone()));
    }
    assert!(fs::read(&file).expect("a file").is_empty());
    // Where the file of the entry should be, a folder.
    let cache = folder.join("cache");
    found(&cache, &obj);
    let entry = only(&cache);
    fs::remove_file(&entry).expect("an entry");
    fs::create_dir(&entry).expect("a folder");
    assert_eq!(found(&cache, &obj), (false, plain));
    assert_eq!(only(&cache), entry, "nothing is left behind");
}

#[test]
fn what_was_not_used_for_longest_makes_room() {
    let folder = folder("cache_room");
    let cache = folder.join("cache");
    let obj = |name: &str, x: u32| {
        let text = format!("v {x} 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        write(&folder, name, text.as_bytes())
    };
    let [a, b, c] = [("a.obj", 2), ("b.obj", 3), ("c.obj", 4)].map(|(name, x)| obj(name, x));
    found(&cache, &a);
    let bytes = fs::metadata(only(&cache)).expect("an entry").len();
    let stranger = write(&cache, "letter.txt", &[0; 9000]);
    let mut small = loader(&cache);
    small.cache.as_mut().expect("a cache").most_bytes = bytes * 5 / 2;
    let pause = || std::thread::sleep(Duration::from_millis(20));
    for path in [&b, &a, &c] {
        pause();
        loaded(&small, path, None);
    }
    let is_kept = |path| found(&cache, path).0;
    assert_eq!([is_kept(&a), is_kept(&c)], [true, true]);
    assert!(!is_kept(&b), "the one that was not used for longest");
    assert!(stranger.is_file(), "what is not ours stays");
    small.cache.as_mut().expect("a cache").most_bytes = bytes / 2;
    let before = files_in(&cache);
    loaded(&small, &obj("d.obj", 5), None);
    assert_eq!(
        files_in(&cache),
        before,
        "one that is larger than all room is not kept"
    );
}

#[test]
fn several_at_once_agree() {
    let folder = folder("cache_at_once");
    let cache = folder.join("cache");
    let [obj, aff] = models(&folder);
    for path in [&obj, &aff] {
        let plain = loaded(&Loader::default(), path, None);
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    for _ in 0..5 {
                        assert_eq!(found(&cache, path).1, plain);
                    }
                });
            }
        });
    }
    assert_eq!(files_in(&cache).len(), 2);
}

#[test]
fn one_thread_makes_the_same_models_as_many() {
    let folder = folder("cache_threads");
    let pool = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().expect("threads")
    };
    let all: Vec<(PathBuf, Option<f64>)> = all_models(&folder)
        .into_iter()
        .flat_map(|path| [None, Some(50.0)].map(|angle| (path.clone(), angle)))
        .collect();
    let load = || format!("{:?}", Loader::default().load(&all));
    let serial = pool(1).install(load);
    for _ in 0..3 {
        assert!(pool(5).install(load) == serial);
    }
}

#[test]
fn the_program_keeps_models_where_it_is_told() {
    let folder = folder("cache_program");
    // Large enough that it is worth it.
    let side = 250;
    let mut text = String::new();
    for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
        text += &format!("v {x} {y} {}\n", x * y % 7);
    }
    for (x, y) in (1..side).flat_map(|y| (1..side).map(move |x| (x, y))) {
        let corner = |x: u32, y: u32| (y - 1) * side + x;
        let [a, b] = [corner(x, y), corner(x, y + 1)];
        text += &format!("f {a} {} {} {b}\n", a + 1, b + 1);
    }
    write(&folder, "hills.obj", text.as_bytes());
    let render = |cache: &str, picture: &str| {
        let output = Command::new(program())
            .args(["render", "hills.obj", "--backend", "cpu"])
            .args(["--size", "32x24", "--out", picture])
            .env("ORRERY_CACHE_DIR", cache)
            .current_dir(&folder)
            .output()
            .expect("the program starts");
        assert!(output.status.success(), "{output:?}");
        fs::read(folder.join(picture)).expect("a picture")
    };
    let plain = render("", "plain.png");
    let first = render("cache", "first.png");
    let entry = only(&folder.join("cache/models"));
    // The use of the kept model is noted in the file itself; a model that is made anew comes in another one.
    let same = folder.join("same");
    fs::hard_link(&entry, &same).expect("a link");
    let file = fs::File::options().write(true).open(&same);
    let early = file.and_then(|file| file.set_modified(SystemTime::UNIX_EPOCH));
    early.expect("a file's time can be set");
    let second = render("cache", "second.png");
    assert!(first == plain && second == plain, "another picture");
    assert_eq!(only(&folder.join("cache/models")), entry);
    let used = fs::metadata(&same).and_then(|file| file.modified());
    assert!(
        used.expect("a time") > SystemTime::UNIX_EPOCH,
        "the second start did not find what the first kept"
    );
}
