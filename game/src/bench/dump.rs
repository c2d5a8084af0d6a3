//! `--dump DIR`: the exact work of a frame as files, for timing other tracers on the same rays.
//!
//! A folder with `manifest.json` and little-endian binary files: meshes (f32 x 9 a triangle), instances
//! (u32 mesh, f32 x 12 row-major object-to-render), spheres (f32 x y z r), rays by kind (f32 origin,
//! t_min, dir, t_max) and their hits (f32 t, u32 instance, u32 primitive; a sphere counts as instance
//! `instances + i`; any-hit answers are instance 0 or 1).

use std::path::{Path, PathBuf};

use glam::{DAffine3, UVec2};
use orrery_engine::frame::{FrameScene, TraceSettings};
use orrery_engine::trace::{Hit, Query, Ray};
use serde_json::json;

use super::frame::{FRAMES_PER_SEC, SIZE};
use super::rays::{self, RaySet};
use super::work::Work;
use crate::args::{BenchRequest, Common};
use crate::failure::Failure;
use crate::output::say;
use crate::{device, stage};

/// Writes the work of the first measured frame.
pub fn run(folder: &Path, request: &BenchRequest, common: &Common) -> Result<(), Failure> {
    let mut engine = stage::set(&request.scene, common, SIZE, FRAMES_PER_SEC)?;
    stage::advance(&mut engine, request.frame)?;
    let scene = engine.world.resource::<FrameScene>();
    let settings = engine.world.resource::<TraceSettings>();
    let work = Work::of(scene).map_err(Failure::Input)?;
    let mut tracer = device::open(common)?;
    tracer.refit(&work.frame)?;
    tracer.upload(&work.frame, settings)?;
    let sets = rays::trace(&work, scene, settings.size, tracer.as_mut())?;
    let name = request
        .scene
        .file_stem()
        .map_or("scene".into(), |stem| stem.to_string_lossy());
    write(folder, &name, settings.size, &work, &sets)?;
    let triangles: usize = work.meshes.iter().map(|m| m.triangles.len()).sum();
    let rays: usize = sets.iter().map(|set| set.rays.len()).sum();
    say(format_args!(
        "{}: {} meshes of {triangles} triangles, {} instances, {} spheres ({} ellipsoids left out), {rays} rays with their hits",
        folder.display(),
        work.meshes.len(),
        work.instances.len(),
        work.spheres.len(),
        work.left_out
    ));
    Ok(())
}

/// Writes geometry, and rays with their hits.
pub fn write(
    folder: &Path,
    name: &str,
    size: UVec2,
    work: &Work,
    sets: &[RaySet],
) -> Result<(), Failure> {
    let out = Folder::make(folder)?;
    out.write_work(work)?;
    for set in sets {
        out.write_rays(set)?;
    }
    out.write("manifest.json", &manifest(name, size, work, sets))
}

/// Writes geometry alone: for timing builds, updates and refits.
pub fn write_geometry(folder: &Path, name: &str, work: &Work) -> Result<(), Failure> {
    write(folder, name, UVec2::ONE, work, &[])
}

/// What is in which file.
fn manifest(name: &str, size: UVec2, work: &Work, sets: &[RaySet]) -> Vec<u8> {
    let meshes = work.meshes.iter().enumerate().map(|(i, mesh)| {
        json!({"name": mesh.name, "triangles": mesh.triangles.len(), "file": format!("mesh{i}.bin")})
    });
    let rays = sets.iter().map(|set| {
        json!({"kind": set.kind, "any_hit": set.query == Query::Any, "count": set.rays.len(),
            "file": format!("rays_{}.bin", set.kind)})
    });
    let hits = sets
        .iter()
        .map(|set| json!({"kind": set.kind, "file": format!("hits_{}.bin", set.kind)}));
    let manifest = json!({
        "scene": name, "width": size.x, "height": size.y,
        "meshes": meshes.collect::<Vec<_>>(),
        "instances": {"count": work.instances.len(), "file": "instances.bin"},
        "spheres": {"count": work.spheres.len(), "file": "spheres.bin"},
        "rays": rays.collect::<Vec<_>>(),
        "hits": hits.collect::<Vec<_>>(),
    });
    format!("{manifest:#}\n").into_bytes()
}

/// Where the files go.
struct Folder(PathBuf);

impl Folder {
    fn make(path: &Path) -> Result<Self, Failure> {
        std::fs::create_dir_all(path).map_err(|error| {
            Failure::Input(format!(
                "{}: cannot make the folder: {error}",
                path.display()
            ))
        })?;
        Ok(Self(path.to_path_buf()))
    }

    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        let path = self.0.join(name);
        std::fs::write(&path, bytes)
            .map_err(|error| Failure::Input(format!("{}: cannot write: {error}", path.display())))
    }

    fn write_work(&self, work: &Work) -> Result<(), Failure> {
        for (i, mesh) in work.meshes.iter().enumerate() {
            let corners = mesh.triangles.iter().flatten();
            self.write(
                &format!("mesh{i}.bin"),
                &floats(corners.flat_map(|v| v.to_array())),
            )?;
        }
        let instances = work.instances.iter().flat_map(|&(mesh, map)| {
            let rows = floats(affine_rows(map).into_iter().flatten());
            mesh.to_le_bytes().into_iter().chain(rows)
        });
        self.write("instances.bin", &instances.collect::<Vec<u8>>())?;
        let spheres = work.spheres.iter();
        let spheres = spheres.flat_map(|(centre, radius)| centre.extend(*radius).to_array());
        self.write("spheres.bin", &floats(spheres))
    }

    fn write_rays(&self, set: &RaySet) -> Result<(), Failure> {
        let rays = floats(set.rays.iter().flat_map(ray_numbers));
        self.write(&format!("rays_{}.bin", set.kind), &rays)?;
        let hits = set.hits.iter().flat_map(hit_bytes);
        self.write(
            &format!("hits_{}.bin", set.kind),
            &hits.collect::<Vec<u8>>(),
        )
    }
}

fn floats(numbers: impl Iterator<Item = f32>) -> Vec<u8> {
    numbers.flat_map(f32::to_le_bytes).collect()
}

fn affine_rows(map: DAffine3) -> [[f32; 4]; 3] {
    let (m, t) = (map.matrix3, map.translation);
    [0, 1, 2].map(|i| {
        let row = m.row(i);
        [row.x, row.y, row.z, t[i]].map(|x| x as f32)
    })
}

fn ray_numbers(ray: &Ray) -> [f32; 8] {
    let (o, d) = (ray.origin, ray.dir);
    [o.x, o.y, o.z, ray.t_min, d.x, d.y, d.z, ray.t_max]
}

fn hit_bytes(hit: &Hit) -> [u8; 12] {
    let mut bytes = [0; 12];
    bytes[..4].copy_from_slice(&(hit.t as f32).to_le_bytes());
    bytes[4..8].copy_from_slice(&hit.instance.to_le_bytes());
    bytes[8..].copy_from_slice(&hit.prim.to_le_bytes());
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn maps_are_written_row_by_row() {
        let map = DAffine3::from_translation(DVec3::new(1.0, 2.0, 3.0))
            * DAffine3::from_scale(DVec3::new(4.0, 5.0, 6.0));
        assert_eq!(
            affine_rows(map),
            [
                [4.0, 0.0, 0.0, 1.0],
                [0.0, 5.0, 0.0, 2.0],
                [0.0, 0.0, 6.0, 3.0]
            ]
        );
    }

    #[test]
    fn a_miss_is_infinite_and_names_nothing() {
        let bytes = hit_bytes(&Hit::MISS);
        assert_eq!(bytes[..4], f32::INFINITY.to_le_bytes());
        assert_eq!(bytes[4..8], [0xff; 4]);
    }
}
