//! FBX files of many programs and versions against OBJ files of the geometry that they hold, at rest and at frames of
//! their animations (ufbx's test data, (c) 2020 Samuli Raivio): what the engine places in the world is compared.
//!
//! An OBJ file has neither units nor axes: it may be 10 or 100 times as large or small, and have Z up.

use std::path::{Path, PathBuf};

use bevy_ecs::prelude::*;
use glam::DVec3;
use orrery_engine::Engine;
use orrery_engine::import::import;
use orrery_engine::time::Clock;
use orrery_engine::world::{
    ClipLayer, ClipPlayer, GlobalTransform, KeyFrames, Loop, Mesh, Meshes, OwnMesh,
    deformed_vertices,
};

/// How far a vertex may be off, of the size of all of it.
const TOLERANCE: f64 = 1e-3;
/// How many times larger the OBJ files' units may be.
const SCALES: [f64; 5] = [1.0, 100.0, 0.01, 10.0, 0.1];
/// OBJ files that are not of their FBX file as it stands.
const OF_OTHER_OPTIONS: &str = "lefthanded";

/// What is said where a file has no clip of the name in that of the OBJ file: that is of another file then.
const OF_ANOTHER: &str = "it has no clip of that name";

/// Files whose geometry is not read, and why; they are counted, and must not come to agree unnoticed.
const EXCEPTIONS: [(&str, &str); 1] = [(
    "blender_340_z_up_7400_binary",
    "the OBJ file has one of the FBX file's two meshes",
)];

/// What an OBJ file shows of an FBX file.
struct Expected {
    obj: PathBuf,
    /// Part of the clip's name, and the frame; none: at rest.
    frame: Option<(String, f64)>,
}

/// Triangles in the world.
#[derive(Default)]
struct Surface {
    vertices: Vec<DVec3>,
    triangles: usize,
}

impl Surface {
    fn add(&mut self, vertices: &[DVec3], triangles: &[[u32; 3]]) {
        self.triangles += triangles.len();
        for triangle in triangles {
            self.vertices
                .extend(triangle.map(|corner| vertices[corner as usize]));
        }
    }

    /// Each place once.
    fn settle(&mut self) {
        let bits = |v: &DVec3| v.to_array().map(f64::to_bits);
        self.vertices.sort_by_key(bits);
        self.vertices.dedup();
    }

    fn size(&self) -> f64 {
        let vertices = self.vertices.iter();
        let (min, max) = vertices.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), &v| {
            (min.min(v), max.max(v))
        });
        (max - min).length()
    }

    fn turned(&self, z_up: bool, scale: f64) -> Self {
        let turned = |v: &DVec3| {
            let v = *v * scale;
            if z_up { DVec3::new(v.x, v.z, -v.y) } else { v }
        };
        Self {
            vertices: self.vertices.iter().map(turned).collect(),
            triangles: self.triangles,
        }
    }

    /// The farthest any vertex of this is from the nearest of the other.
    fn farthest_from(&self, other: &Self) -> f64 {
        let to_nearest = |v: &DVec3| {
            let distances = other.vertices.iter().map(|w| v.distance_squared(*w));
            distances.fold(f64::INFINITY, f64::min)
        };
        self.vertices
            .iter()
            .map(to_nearest)
            .fold(0.0, f64::max)
            .sqrt()
    }

    /// How far the vertices of the two are apart at most, of this one's size.
    fn error(&self, other: &Self) -> f64 {
        let size = self.size();
        let rough = (other.size() / size - 1.0).abs();
        if !(rough < 0.1) {
            return rough.max(1.0);
        }
        self.farthest_from(other).max(other.farthest_from(self)) / size
    }
}

#[test]
fn fbx_files_hold_the_geometry_that_their_obj_files_say() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes/ufbx-fbx");
    let files = files_of(&folder, "fbx");
    if files.is_empty() {
        eprintln!("skipped: there is no FBX file in {}", folder.display());
        return;
    }
    let objs = files_of(&folder, "obj");
    let (mut tried, mut agreed, mut off) = (0, 0, Vec::new());
    for file in &files {
        for expected in expectations(file, &objs) {
            let name = format!("{} as {}", stem(file), stem(&expected.obj));
            let found = error_of(file, &expected);
            if found == Err(OF_ANOTHER.to_owned()) {
                continue;
            }
            tried += 1;
            match found {
                Ok(error) if error <= TOLERANCE => agreed += 1,
                Ok(error) => off.push(format!("{name}: off by {error:.2e} of its size")),
                Err(why) => off.push(format!("{name}: {why}")),
            }
        }
    }
    eprintln!("{tried} poses tried, {agreed} agreed to {TOLERANCE} of their size");
    let (known, unknown): (Vec<&String>, Vec<&String>) = off
        .iter()
        .partition(|line| EXCEPTIONS.iter().any(|(name, _)| line.starts_with(name)));
    for line in known {
        let why = EXCEPTIONS.iter().find(|(name, _)| line.starts_with(name));
        eprintln!("exception: {line} ({})", why.map_or("", |(_, why)| why));
    }
    assert!(tried > 60, "{tried} poses");
    assert!(unknown.is_empty(), "{unknown:#?}");
    for (name, why) in EXCEPTIONS {
        let is_off = off.iter().any(|line| line.starts_with(name));
        assert!(is_off, "`{name}` agrees now, though {why}");
    }
}

fn files_of(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    files.retain(|path| path.extension().is_some_and(|found| found == ending));
    files.sort();
    files
}

fn stem(path: &Path) -> String {
    path.file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

/// What there is to compare a file with, whose name is NAME_VERSION_(ascii|binary)[_CLIP].fbx: NAME.obj is the file at
/// rest, NAME_CLIP_FRAME.obj a frame of a clip.
fn expectations(file: &Path, objs: &[PathBuf]) -> Vec<Expected> {
    let stem_of_file = stem(file);
    let words: Vec<&str> = stem_of_file.split('_').collect();
    let kind = words
        .iter()
        .position(|word| matches!(*word, "ascii" | "binary"));
    let Some(kind) = kind.filter(|kind| *kind >= 2) else {
        return Vec::new();
    };
    let name = words[..kind - 1].join("_");
    let own = words[kind + 1..].join("_");
    let one = |obj: &PathBuf| {
        let stem = stem(obj);
        let rest = stem.strip_prefix(&name)?;
        if stem.contains(OF_OTHER_OPTIONS) != name.contains(OF_OTHER_OPTIONS) {
            return None;
        }
        if rest.is_empty() {
            let obj = obj.clone();
            return Some(Expected { obj, frame: None });
        }
        let rest = rest.strip_prefix('_')?;
        let (clip, frame) = rest.rsplit_once('_').unwrap_or(("", rest));
        let frame = frame.parse().ok()?;
        let fits = own.is_empty() || own == "combined" || own == clip;
        (fits && !clip.contains('_')).then(|| Expected {
            obj: obj.clone(),
            frame: Some((clip.to_owned(), frame)),
        })
    };
    objs.iter().filter_map(one).collect()
}

/// How far a file is from what it is expected to be, of its size.
fn error_of(file: &Path, expected: &Expected) -> Result<f64, String> {
    let obj = surface_of_obj(&expected.obj)?;
    let fps = if stem(file).starts_with("max") {
        30.0
    } else {
        24.0
    };
    let surface = surface_at(file, expected.frame.as_ref(), fps)?;
    if surface.vertices.is_empty() {
        return Err("it shows nothing".into());
    }
    // Twisted faces of the OBJ file can lack triangles where they are cut in their plane, never have more.
    if surface.triangles < obj.triangles {
        return Err(format!(
            "{} triangles, {} in the OBJ file",
            surface.triangles, obj.triangles
        ));
    }
    let errors = [false, true].into_iter().flat_map(|z_up| {
        let (obj, surface) = (&obj, &surface);
        SCALES.map(|scale| obj.turned(z_up, scale).error(surface))
    });
    Ok(errors.fold(f64::INFINITY, f64::min))
}

fn surface_of_obj(path: &Path) -> Result<Surface, String> {
    let model = import(path)?;
    let mut surface = Surface::default();
    for part in &model.parts {
        surface.add(&part.mesh.vertices, &part.mesh.triangles);
    }
    surface.settle();
    Ok(surface)
}

/// All meshes in the world, hidden ones too; at rest, or at a frame of the clip with that word in its name.
fn surface_at(file: &Path, frame: Option<&(String, f64)>, fps: f64) -> Result<Surface, String> {
    let mut engine = Engine::new();
    let world = &mut engine.world;
    orrery_engine::scene::load(world, file).map_err(|problems| problems.to_string())?;
    let mut caches = world.query::<&mut KeyFrames>();
    let mut has_cache = false;
    for mut keys in caches.iter_mut(world) {
        keys.speed = 0.0;
        keys.start = frame.map_or(0.0, |(_, frame)| frame / fps);
        has_cache = true;
    }
    let mut players = world.query::<&mut ClipPlayer>();
    let player = players.iter_mut(world).next();
    match (player, frame) {
        (None, None) => {}
        (None, Some(_)) if has_cache => {}
        (None, Some(_)) => return Err(OF_ANOTHER.into()),
        (Some(mut player), None) => player.layers.clear(),
        (Some(mut player), Some((word, frame))) => {
            let layer = layer_at(&player, word, frame / fps).ok_or(OF_ANOTHER)?;
            player.layers = vec![layer];
        }
    }
    world.insert_resource(Clock::Frame(0));
    engine.frame();
    Ok(surface_of(&mut engine.world))
}

/// Holds the clip with that word in its name at a time.
fn layer_at(player: &ClipPlayer, word: &str, secs: f64) -> Option<ClipLayer> {
    let clips = player.clips.clips();
    let named = |name: &str| name.to_lowercase().contains(word);
    let clip = clips.iter().position(|clip| named(&clip.name))?;
    // Frames count from 0, or in a file of several clips one after the other from the clip's start.
    let begin = clips[clip].start;
    let start = if secs >= begin { secs - begin } else { secs };
    Some(ClipLayer {
        clip,
        start,
        repeat: Loop::Once,
        paused: true,
        ..ClipLayer::default()
    })
}

fn surface_of(world: &mut World) -> Surface {
    let mut surface = Surface::default();
    let mut shown = world.query::<(&GlobalTransform, &Mesh, Option<&OwnMesh>)>();
    let meshes = world.resource::<Meshes>();
    for (place, mesh, own) in shown.iter(world) {
        let row = own.map_or(mesh.0, |own| own.0);
        let Some(mesh) = meshes.rows().get(row.0 as usize) else {
            continue;
        };
        let vertices = deformed_vertices(&mesh.data, mesh.deformation.as_deref());
        let place = |v: &DVec3| place.0.transform_point3(*v);
        let vertices: Vec<DVec3> = vertices.iter().map(place).collect();
        surface.add(&vertices, &mesh.data.triangles);
    }
    surface.settle();
    surface
}
