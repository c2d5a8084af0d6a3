//! What is traced: scenes in the dump format with an eye and a light, and scenes that Orrery plays.

use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3, UVec2, Vec3};
use orrery_engine::frame::{FrameScene, LightKind, View};
use orrery_engine::world::{Material, Reflection};
use serde_json::Value;

use crate::args::Common;
use crate::bench::work::{Work, WorkMesh};
use crate::failure::Failure;
use crate::stage;

/// What every surface of a dumped scene mirrors.
const MIRRORED: f32 = 0.3;
/// Generations of the whole frame that dumped scenes stand for: the eye's ray and the mirrored one.
const GENERATIONS: u32 = 2;

/// A scene to trace.
pub struct Stage {
    /// Its name.
    pub name: String,
    /// Its geometry, relative to the eye.
    pub work: Work,
    /// The whole scene, for pictures.
    pub frame: FrameScene,
    /// The light that shadow rays go to, relative to the eye.
    pub light: DVec3,
}

impl Stage {
    /// A folder in the dump format whose manifest has a `camera` and a `light`.
    pub fn of_dump(folder: &Path) -> Result<Self, Failure> {
        let bad = |what: String| Failure::Input(format!("{}: {what}", folder.display()));
        let bytes = read(&folder.join("manifest.json"))?;
        let manifest: Value = serde_json::from_slice(&bytes)
            .map_err(|error| bad(format!("manifest.json: {error}")))?;
        let vector = |value: &Value, what: &str| {
            let numbers = value.as_array().filter(|numbers| numbers.len() == 3);
            let numbers =
                numbers.and_then(|n| n.iter().map(Value::as_f64).collect::<Option<Vec<_>>>());
            let numbers = numbers.filter(|n| n.iter().all(|x| x.is_finite()));
            numbers
                .map(|n| DVec3::from_slice(&n))
                .ok_or_else(|| bad(format!("manifest.json: `{what}`: expected three numbers")))
        };
        let camera = &manifest["camera"];
        let axis = |name: &str| vector(&camera[name], name);
        let view = View {
            origin: axis("position")?,
            forward: axis("forward")?,
            right: axis("right")?,
            up: axis("up")?,
            ..View::default()
        };
        let light = vector(&manifest["light"], "light")?;
        let text = |value: &Value, what: &str| {
            value
                .as_str()
                .map(str::to_owned)
                .ok_or_else(|| bad(format!("manifest.json: `{what}`: expected a text")))
        };
        let mut meshes = Vec::new();
        for mesh in manifest["meshes"].as_array().into_iter().flatten() {
            let file = text(&mesh["file"], "file")?;
            let corners = floats(&folder.join(&file), 9)?;
            let corner = |c: &[f32]| Vec3::from_slice(c);
            meshes.push(WorkMesh {
                name: text(&mesh["name"], "name")?,
                triangles: corners
                    .chunks_exact(9)
                    .map(|t| [corner(&t[..3]), corner(&t[3..6]), corner(&t[6..])])
                    .collect(),
            });
        }
        let file = text(&manifest["instances"]["file"], "instances.file")?;
        let rows = read(&folder.join(&file))?;
        let instances = rows.chunks_exact(52).map(|row| {
            let word = |i: usize| <[u8; 4]>::try_from(&row[4 * i..4 * i + 4]).unwrap_or_default();
            let number = |i: usize| f64::from(f32::from_le_bytes(word(1 + i)));
            let column = |c: usize| DVec3::new(number(c), number(4 + c), number(8 + c));
            let linear = DMat3::from_cols(column(0), column(1), column(2));
            let map = DAffine3::from_mat3_translation(linear, column(3) - view.origin);
            (u32::from_le_bytes(word(0)), map)
        });
        let mirror = Material {
            color: Vec3::splat(0.7),
            diffuse: 1.0 - MIRRORED,
            reflection: Reflection::Constant(Vec3::splat(MIRRORED)),
            ..Material::default()
        };
        let work = Work::of_meshes(meshes, instances.collect(), view, mirror).map_err(bad)?;
        let mut frame = work.frame.clone();
        frame.max_generations = GENERATIONS;
        frame.lights.push(orrery_engine::frame::Light {
            color: Vec3::ONE,
            fade: None,
            kind: LightKind::Point {
                position: light - view.origin,
            },
        });
        Ok(Self {
            name: text(&manifest["scene"], "scene")?,
            work,
            frame,
            light: light - view.origin,
        })
    }

    /// A scene file or model at a frame.
    pub fn of_scene(
        path: &Path,
        frame: u64,
        size: UVec2,
        common: &Common,
    ) -> Result<Self, Failure> {
        let mut engine = stage::set(path, common, size, crate::bench::frame::FRAMES_PER_SEC)?;
        stage::advance(&mut engine, frame)?;
        let frame = engine.world.resource::<FrameScene>().clone();
        let work = Work::of(&frame).map_err(Failure::Input)?;
        let lights = frame.lights.iter().map(|light| match light.kind {
            LightKind::Directional { to_light } => to_light * 1e4,
            LightKind::Point { position } | LightKind::Spot { position, .. } => {
                position - frame.view.origin
            }
        });
        let stem = path.file_stem().unwrap_or_default();
        Ok(Self {
            name: stem.to_string_lossy().into_owned(),
            light: lights.clone().next().unwrap_or(DVec3::Y * 1e4),
            work,
            frame,
        })
    }
}

fn read(path: &PathBuf) -> Result<Vec<u8>, Failure> {
    std::fs::read(path)
        .map_err(|error| Failure::Input(format!("{}: cannot be read: {error}", path.display())))
}

/// A file of little-endian numbers, so many a row.
fn floats(path: &PathBuf, a_row: usize) -> Result<Vec<f32>, Failure> {
    let bytes = read(path)?;
    if bytes.len() % (4 * a_row) != 0 {
        return Err(Failure::Input(format!(
            "{}: {} bytes; expected rows of {a_row} f32",
            path.display(),
            bytes.len()
        )));
    }
    let words = bytes.chunks_exact(4);
    Ok(words
        .map(|word| f32::from_le_bytes(word.try_into().unwrap_or_default()))
        .collect())
}
