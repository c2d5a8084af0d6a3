//! Polygons of one fill, gathered into meshes.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

use crate::world::{MeshData, newell_normal, triangulate_face};

/// Triangles of one mesh.
const TRIANGLES: usize = 1 << 20;

/// A corner of a polygon; its normal is zero where it is flat.
pub type Corner = (DVec3, Vec3);

/// A mesh in the making, vertices with the same place and normal being one.
#[derive(Debug, Default)]
pub struct Batch {
    rows: HashMap<([u64; 3], [u32; 3]), u32>,
    vertices: Vec<DVec3>,
    normals: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl Batch {
    /// Adds a polygon of any number of corners, concave ones too, and says whether it crosses itself. All have
    /// normals, or none.
    ///
    /// # Errors
    /// Why it is no polygon.
    pub fn add(&mut self, corners: &[Corner]) -> Result<bool, String> {
        let outline: Vec<DVec3> = corners.iter().map(|corner| corner.0).collect();
        let (cut, is_twisted) = match corners.len() {
            3 => (vec![[0, 1, 2]], false),
            _ => {
                let cut = triangulate_face(&outline)?;
                (cut.triangles, cut.is_twisted)
            }
        };
        let is_smooth = corners.iter().any(|corner| corner.1 != Vec3::ZERO);
        let face = newell_normal(&outline).normalize_or(DVec3::Y).as_vec3();
        for triangle in cut {
            let rows = triangle.map(|corner| {
                let (place, normal) = corners[corner as usize];
                let normal = match (is_smooth, normal == Vec3::ZERO) {
                    (false, _) => Vec3::ZERO,
                    (true, true) => face,
                    (true, false) => normal,
                };
                self.row(place, normal)
            });
            self.triangles.push(rows);
        }
        Ok(is_twisted)
    }

    fn row(&mut self, place: DVec3, normal: Vec3) -> u32 {
        // Adding zero makes -0 and 0 the same place.
        let bits = (place + DVec3::ZERO).to_array().map(f64::to_bits);
        let key = (bits, (normal + Vec3::ZERO).to_array().map(f32::to_bits));
        *self.rows.entry(key).or_insert_with(|| {
            self.vertices.push(place);
            self.normals.push(normal);
            (self.vertices.len() - 1) as u32
        })
    }

    /// Whether the next polygon belongs into another mesh.
    pub fn is_full(&self) -> bool {
        self.triangles.len() >= TRIANGLES
    }

    /// The mesh; none: it has no triangle.
    ///
    /// # Errors
    /// Why it is none.
    pub fn mesh(self, name: &str) -> Result<Option<MeshData>, String> {
        if self.triangles.is_empty() {
            return Ok(None);
        }
        let is_flat = self.normals.iter().all(|normal| *normal == Vec3::ZERO);
        let normals = if is_flat { Vec::new() } else { self.normals };
        MeshData::new(name, self.vertices, normals, self.triangles).map(Some)
    }
}
