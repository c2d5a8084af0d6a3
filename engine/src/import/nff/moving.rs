//! Triangles with keys (`tpa`), gathered into meshes that go from pose to pose.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::shapes::part_of_mesh;
use super::stage::Stage;
use super::words::Words;
use crate::import::Part;
use crate::world::{KeyFrames, Loop, MeshData, VertexSets};

/// A mesh in the making. Vertices that are together in every pose are one, so that it is closed where the file's is,
/// and smooth where it has normals: those of the poses between follow from the triangles.
#[derive(Debug, Default)]
pub struct Moving {
    times: Vec<f64>,
    rows: HashMap<Vec<[u64; 3]>, u32>,
    /// A list a vertex, a place a pose.
    vertices: Vec<Vec<DVec3>>,
    /// In the first pose.
    normals: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl Stage<'_> {
    pub(super) fn moving_triangle(&mut self, words: &mut Words) -> Result<(), String> {
        let count = words.count("keys", 38)?;
        let mut times = Vec::with_capacity(count);
        let mut places = [(); 3].map(|()| Vec::with_capacity(count));
        let mut normals = [Vec3::ZERO; 3];
        for pose in 0..count {
            times.push(words.number("the time of a key")?);
            for corner in 0..3 {
                places[corner].push(words.point("a corner")?);
                let normal = self.normal(words, true)?;
                if pose == 0 {
                    normals[corner] = normal;
                }
            }
        }
        if count == 0 || !times.is_sorted_by(|a, b| a < b) {
            let place = words.place();
            let warning =
                format!("{place}: a triangle is left out: the times of its keys do not rise");
            self.model.warnings.push(warning);
            return Ok(());
        }
        let fill = self.fill;
        let Some(scope) = self.scopes.last_mut() else {
            return Ok(());
        };
        let mesh = scope.moving.entry(fill).or_default();
        let other = (mesh.times != times).then(|| std::mem::take(mesh));
        mesh.add(times, places, normals);
        match other.map(Moving::part).transpose()?.flatten() {
            Some(part) => self.show_new(part, fill),
            None => Ok(()),
        }
    }
}

/// Keys that last from the first second to the last: the first pose is held until its time, the last one after.
pub fn stretched(keys: &KeyFrames, [start, end]: [f64; 2]) -> KeyFrames {
    let mut stretched = KeyFrames {
        start,
        ..keys.clone()
    };
    let vertices = keys.keys.vertices;
    let mut values = keys.keys.values.clone();
    if keys.times.first().is_some_and(|&first| first > start) {
        stretched.times.insert(0, start);
        values.splice(0..0, keys.keys.values[..vertices].iter().copied());
    }
    if keys.times.last().is_some_and(|&last| last < end) {
        stretched.times.push(end);
        let last = keys.keys.values.len() - vertices;
        values.extend_from_slice(&keys.keys.values[last..]);
    }
    stretched.keys = Arc::new(VertexSets { vertices, values });
    stretched
}

impl Moving {
    fn add(&mut self, times: Vec<f64>, places: [Vec<DVec3>; 3], normals: [Vec3; 3]) {
        self.times = times;
        let mut normals = normals.into_iter();
        let rows = places.map(|poses| {
            let normal = normals.next().unwrap_or_default();
            let bits = |place: &DVec3| (*place + DVec3::ZERO).to_array().map(f64::to_bits);
            let key: Vec<[u64; 3]> = poses.iter().map(bits).collect();
            *self.rows.entry(key).or_insert_with(|| {
                self.vertices.push(poses);
                self.normals.push(normal);
                (self.vertices.len() - 1) as u32
            })
        });
        self.triangles.push(rows);
    }

    /// The mesh in its first pose, and all of them; none: it has no triangle.
    ///
    /// # Errors
    /// Why it is none.
    pub(super) fn part(self) -> Result<Option<Part>, String> {
        if self.triangles.is_empty() {
            return Ok(None);
        }
        let is_smooth = self.normals.iter().all(|normal| *normal != Vec3::ZERO);
        let normals = if is_smooth { self.normals } else { Vec::new() };
        let first = self.vertices.iter().map(|poses| poses[0]).collect();
        let mesh = MeshData::new("moving triangles", first, normals, self.triangles)?;
        let mut values = Vec::with_capacity(self.times.len() * self.vertices.len());
        for pose in 0..self.times.len() {
            let places = self.vertices.iter().map(|poses| poses[pose]);
            values.extend(places.map(|place| (place - mesh.origin).as_vec3()));
        }
        let keys = KeyFrames {
            keys: Arc::new(VertexSets {
                vertices: self.vertices.len(),
                values,
            }),
            times: self.times,
            start: 0.0,
            speed: 1.0,
            repeat: Loop::Repeat,
        };
        Ok(Some(Part {
            keys: Some(keys),
            ..part_of_mesh(mesh)
        }))
    }
}
