//! What is traced: scenes in the dump format with an eye and a light, and scenes that Orrery plays.

use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3, UVec2, Vec3};
use orrery_engine::frame::{FrameScene, Light, LightKind, View};
use orrery_engine::world::{Material, Reflection};
use serde::Deserialize;

use crate::args::Common;
use crate::bench::work::{Work, WorkMesh};
use crate::failure::Failure;
use crate::stage;

/// What every surface of a dumped scene mirrors.
const MIRRORED: f32 = 0.3;
/// Generations of the whole frame that dumped scenes stand for: the eye's ray and the mirrored one.
const GENERATIONS: u32 = 2;

/// Numbers of a triangle.
const CORNERS: usize = 9;
/// Of an instance: its mesh, as the bits of a number, and three rows of its map.
const PLACED: usize = 13;

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

/// What this reads of a dump's `manifest.json`.
#[derive(Deserialize)]
struct Manifest {
    scene: String,
    camera: Eye,
    light: [f64; 3],
    meshes: Vec<Named>,
    instances: Named,
}

#[derive(Deserialize)]
struct Eye {
    position: [f64; 3],
    forward: [f64; 3],
    right: [f64; 3],
    up: [f64; 3],
}

#[derive(Deserialize)]
struct Named {
    #[serde(default)]
    name: String,
    file: String,
}

impl Stage {
    /// A folder in the dump format whose manifest has a `camera` and a `light`.
    pub fn of_dump(folder: &Path) -> Result<Self, Failure> {
        let path = folder.join("manifest.json");
        let manifest: Manifest = serde_json::from_slice(&read(&path)?)
            .map_err(|error| Failure::Input(format!("{}: {error}", path.display())))?;
        let eye = &manifest.camera;
        let view = View {
            origin: eye.position.into(),
            forward: eye.forward.into(),
            right: eye.right.into(),
            up: eye.up.into(),
            ..View::default()
        };
        let meshes = manifest.meshes.iter().map(|mesh| {
            let numbers = floats(&folder.join(&mesh.file), CORNERS)?;
            let corners = numbers.chunks_exact(3).map(Vec3::from_slice);
            let corners: Vec<Vec3> = corners.collect();
            let triangles = corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]);
            Ok(WorkMesh {
                name: mesh.name.clone(),
                triangles: triangles.collect(),
            })
        });
        let meshes: Result<Vec<WorkMesh>, Failure> = meshes.collect();
        let rows = floats(&folder.join(&manifest.instances.file), PLACED)?;
        let instances = rows.chunks_exact(PLACED).map(|row| {
            let number = |i: usize| f64::from(row[1 + i]);
            let column = |c: usize| DVec3::new(number(c), number(4 + c), number(8 + c));
            let linear = DMat3::from_cols(column(0), column(1), column(2));
            let map = DAffine3::from_mat3_translation(linear, column(3) - view.origin);
            (row[0].to_bits(), map)
        });
        let light = DVec3::from(manifest.light) - view.origin;
        Self::of_meshes(manifest.scene, meshes?, instances.collect(), view, light)
            .map_err(|what| Failure::Input(format!("{}: {what}", folder.display())))
    }

    /// Instances of meshes, all mirrors a little; their maps and the light are relative to the eye.
    pub fn of_meshes(
        name: String,
        meshes: Vec<WorkMesh>,
        instances: Vec<(u32, DAffine3)>,
        view: View,
        light: DVec3,
    ) -> Result<Self, String> {
        let mirror = Material {
            color: Vec3::splat(0.7),
            diffuse: 1.0 - MIRRORED,
            reflection: Reflection::Constant(Vec3::splat(MIRRORED)),
            ..Material::default()
        };
        let work = Work::of_meshes(meshes, instances, view, mirror)?;
        let mut frame = work.frame.clone();
        frame.max_generations = GENERATIONS;
        frame.lights.push(Light {
            color: Vec3::ONE,
            fade: None,
            kind: LightKind::Point { position: light },
        });
        Ok(Self {
            name,
            work,
            frame,
            light,
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
