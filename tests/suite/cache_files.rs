//! Kept models and the files that they refer to: ones that come later, ones that cannot be read.

use std::fs;
use std::path::Path;
#[cfg(unix)]
use std::process::Command;
#[cfg(unix)]
use std::sync::mpsc;
#[cfg(unix)]
use std::time::Duration;

use orrery_engine::import::Loader;

use crate::cache::{found, loaded, models, write};
use crate::cli::folder;

/// A triangle with a geometry cache beside it: places of its vertices, which replace its own.
const MOVED: &str = r#"; written by hand
FBXHeaderExtension: {
	FBXHeaderVersion: 1003
	FBXVersion: 7400
}
Objects: {
	Geometry: 10, "Geometry::flag", "Mesh" {
		Vertices: *9 {
			a: 0,0,0,1,0,0,0,1,0
		}
		PolygonVertexIndex: *3 {
			a: 0,1,-3
		}
	}
	Model: 20, "Model::flag", "Mesh" {
	}
	Deformer: 30, "Deformer::wave", "VertexCacheDeformer" {
	}
	Cache: 31, "Cache::wave", "" {
		Properties70: {
			P: "CacheFileName", "KString", "", "","below\wave.pc2"
		}
	}
}
Connections: {
	C: "OO",20,0
	C: "OO",10,20
	C: "OO",30,10
	C: "OO",31,30
}
"#;

#[test]
fn a_geometry_cache_that_comes_later_is_seen() {
    let folder = folder("cache_poses");
    let cache = folder.join("cache");
    // Two poses of three points, a frame apart.
    let mut poses = b"POINTCACHE2\0".to_vec();
    poses.extend([1_u32, 3].map(u32::to_le_bytes).concat());
    poses.extend([0.0_f32, 1.0].map(f32::to_le_bytes).concat());
    poses.extend(2_u32.to_le_bytes());
    let places = (0..18_u8).map(|number| f32::from(number * number % 7));
    poses.extend(places.flat_map(f32::to_le_bytes));
    let path = write(&folder, "wave.fbx", MOVED.as_bytes());
    let (_, still) = found(&cache, &path);
    assert!(still.contains("wave.pc2` beside it"), "{still}");
    assert_eq!(found(&cache, &path), (true, still.clone()));
    // Below the file's folder as it says, or in it.
    fs::create_dir(folder.join("below")).expect("a folder");
    for name in ["wave.pc2", "below/wave.pc2"] {
        let file = write(&folder, name, &poses);
        let plain = loaded(&Loader::default(), &path, None);
        assert!(plain.contains("KeyFrames {"), "{plain}");
        assert_eq!(found(&cache, &path), (false, plain), "{name}");
        fs::remove_file(file).expect("a file");
        assert_eq!(found(&cache, &path).1, still);
    }
}

/// What [`found`] says, or that it waits for something.
#[cfg(unix)]
fn found_soon(cache: &Path, path: &Path) -> (bool, String) {
    let (told, hears) = mpsc::channel();
    let [cache, path] = [cache, path].map(Path::to_owned);
    std::thread::spawn(move || told.send(found(&cache, &path)));
    let found = hears.recv_timeout(Duration::from_secs(60));
    found.expect("it waits")
}

/// A pipe that nobody writes to.
#[cfg(unix)]
fn pipe(path: &Path) {
    let made = Command::new("mkfifo").arg(path).status();
    assert!(made.is_ok_and(|made| made.success()), "no pipe");
}

#[cfg(unix)]
#[test]
fn pipes_are_not_waited_for() {
    let folder = folder("cache_pipes");
    let cache = folder.join("cache");
    let [obj, _] = models(&folder);
    let (_, plain) = found_soon(&cache, &obj);
    assert_eq!(found_soon(&cache, &obj), (true, plain.clone()));
    // No file, as before.
    pipe(&folder.join("none.png"));
    assert_eq!(found_soon(&cache, &obj), (true, plain));
    let model = folder.join("pipe.obj");
    pipe(&model);
    let (hit, refused) = found_soon(&cache, &model);
    assert!(!hit && refused.contains("it is not a file"), "{refused}");
}

#[test]
fn a_model_with_a_file_that_is_too_long_is_kept() {
    let folder = folder("cache_long");
    let cache = folder.join("cache");
    let [obj, _] = models(&folder);
    let long = fs::File::create(folder.join("none.png")).expect("a file");
    // Nothing is written: it takes no room.
    long.set_len((1 << 30) + 1).expect("a length");
    let (hit, plain) = found(&cache, &obj);
    assert!(!hit && plain.contains("longer than 1024 MiB"), "{plain}");
    assert_eq!(found(&cache, &obj), (true, plain));
}
