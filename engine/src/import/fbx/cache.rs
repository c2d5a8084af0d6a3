//! Geometry caches: files beside the FBX file that hold the places of a mesh's vertices at many times.
//!
//! They become key frames, which replace what skins and blend shapes do to the mesh: programs write the outcome of all.
//! Only files in the FBX file's own folder and below are opened, whatever path it has for them.

use std::path::{Component, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use ufbx::{
    CacheChannel, CacheDeformer, CacheInterpretation, GeometryCacheDataOpts, GeometryCacheOpts,
    GeometryCacheRoot, Mesh,
};

use super::{limits, number};
use crate::import::{Files, Part, Warnings};
use crate::world::{FARTHEST, KeyFrames, Loop, VertexSets};

/// Largest cache that ufbx may hold, as if it were an FBX file of so many bytes.
const SIZE: usize = 16 << 20;

/// Places of all vertices of a mesh of the file at rising times.
pub struct Poses {
    times: Vec<f64>,
    poses: Vec<Vec<DVec3>>,
}

/// The poses of a mesh from the first of its caches that can be read.
pub fn read(
    mesh: &Mesh,
    files: &Files,
    room: &mut usize,
    warnings: &mut Warnings,
) -> Option<Poses> {
    for deformer in &mesh.cache_deformers {
        match poses_of(mesh, deformer, files, room) {
            Ok(poses) => return Some(poses),
            Err(why) => warnings.push(format!(
                "a geometry cache of `{}` is left out: {why}",
                mesh.element.name
            )),
        }
    }
    None
}

fn poses_of(
    mesh: &Mesh,
    deformer: &CacheDeformer,
    files: &Files,
    room: &mut usize,
) -> Result<Poses, String> {
    let file = deformer.file.as_ref().ok_or("it names no file")?;
    let named = [
        &file.relative_filename,
        &file.filename,
        &file.absolute_filename,
    ];
    let names: Vec<&str> = named.map(|name| name.as_ref()).to_vec();
    let path =
        found(files, &names).ok_or_else(|| format!("there is no file `{}` beside it", names[0]))?;
    // It may name files of its own.
    files.lose_track();
    let path = path.to_str().ok_or("its path is no Unicode")?;
    let options = GeometryCacheOpts {
        temp_allocator: limits(SIZE),
        result_allocator: limits(SIZE),
        ..GeometryCacheOpts::default()
    };
    let cache =
        ufbx::load_geometry_cache(path, options).map_err(|error| error.description.to_string())?;
    let channel = channel_of(&cache, &deformer.channel)
        .ok_or_else(|| format!("it has no places `{}`", deformer.channel))?;
    let needed = channel.frames.len().saturating_mul(mesh.num_vertices);
    *room = room
        .checked_sub(needed)
        .ok_or_else(|| format!("{needed} places are too many for a file of its size"))?;
    let mut poses = Poses {
        times: Vec::new(),
        poses: Vec::new(),
    };
    let mut places = vec![ufbx::Vec3::default(); mesh.num_vertices];
    for frame in &channel.frames {
        let options = GeometryCacheDataOpts::default();
        let count = ufbx::read_geometry_cache_vec3(frame, &mut places, options);
        if count != mesh.num_vertices {
            return Err(format!(
                "a frame has {count} places, the mesh {} vertices",
                mesh.num_vertices
            ));
        }
        let rises = poses.times.last().is_none_or(|last| *last < frame.time);
        if rises && frame.time.is_finite() {
            poses.times.push(frame.time);
            poses
                .poses
                .push(places.iter().map(|place| number::vector(*place)).collect());
        }
    }
    let near = |place: &DVec3| place.is_finite() && place.abs().max_element() <= FARTHEST;
    if poses.times.is_empty() {
        return Err("it has no frame".into());
    }
    match poses.poses.iter().flatten().all(near) {
        true => Ok(poses),
        false => Err("a place is not finite".into()),
    }
}

/// The file of one of these names, in the folder or below it.
fn found(files: &Files, names: &[&str]) -> Option<PathBuf> {
    let folder = files.folder();
    let below = names.iter().filter_map(|name| {
        let plain = PathBuf::from(name.replace('\\', "/"));
        let inside = |part: Component| matches!(part, Component::Normal(_) | Component::CurDir);
        plain.components().all(inside).then(|| folder.join(plain))
    });
    let beside = names.iter().filter_map(|name| {
        let last = name.rsplit(['/', '\\']).next()?;
        (!last.is_empty() && last != "..").then(|| folder.join(last))
    });
    below.chain(beside).find(|path| files.is_there(path))
}

/// The places of that name, or of any.
fn channel_of<'a>(cache: &'a GeometryCacheRoot, name: &str) -> Option<&'a CacheChannel> {
    let places = |channel: &&CacheChannel| {
        matches!(
            channel.interpretation,
            CacheInterpretation::VertexPosition | CacheInterpretation::Points
        )
    };
    let channels = || cache.channels.iter();
    let named = channels().find(|channel| channel.name.as_ref() == name);
    named.or_else(|| channels().find(places))
}

impl Poses {
    /// The key frames of a part, from its first pose on.
    pub fn keys(&self, part: &Part) -> KeyFrames {
        let of = |pose: &Vec<DVec3>| -> Vec<glam::Vec3> {
            let places = part.sources.iter().map(|&source| pose[source as usize]);
            places
                .map(|place| (place - part.mesh.origin).as_vec3())
                .collect()
        };
        KeyFrames {
            keys: Arc::new(VertexSets {
                vertices: part.sources.len(),
                values: self.poses.iter().flat_map(of).collect(),
            }),
            times: self.times.clone(),
            start: self.times[0],
            speed: 1.0,
            repeat: Loop::Repeat,
        }
    }
}
