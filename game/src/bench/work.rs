//! The geometry of a frame in what the dump format can say: meshes, instances of them, spheres.
//!
//! All in render space (relative to the eye), in f32. Boxes become instances of one mesh of 12
//! triangles; planes become large quads; an ellipsoid (a sphere under a general transform) is left out
//! and counted. Rays and hits are of exactly this work, not of the frame it came from.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3};
use orrery_engine::frame::{Features, FrameScene, Instance, Shape, View};
use orrery_engine::world::{Cone, Material, MeshData};

/// A mesh in object space.
pub struct WorkMesh {
    /// Its name.
    pub name: String,
    /// Corners.
    pub triangles: Vec<[Vec3; 3]>,
}

/// The geometry, and the same as a frame for tracers.
pub struct Work {
    /// Meshes.
    pub meshes: Vec<WorkMesh>,
    /// Mesh and object-to-render map of each instance; instance i is row i of the frame.
    pub instances: Vec<(u32, DAffine3)>,
    /// Centre and radius; sphere i is row `instances.len() + i` of the frame.
    pub spheres: Vec<(Vec3, f32)>,
    /// The frame of all that, seen from the origin.
    pub frame: FrameScene,
    /// Spheres that are ellipsoids, which the format cannot say.
    pub left_out: usize,
}

/// Planes reach this many times as far as the farthest other thing.
const PLANE_REACH: f64 = 16.0;

impl Work {
    /// The work of a frame.
    pub fn of(scene: &FrameScene) -> Result<Self, String> {
        let eye = DAffine3::from_translation(-scene.view.origin);
        let mut builder = Builder::new(scene);
        let reach = farthest(scene) * PLANE_REACH;
        let mut spheres = Vec::new();
        for instance in scene.instances.iter() {
            let render_from_local = eye * instance.world_from_local;
            let material = instance.material;
            match instance.shape {
                Shape::Vacant => {}
                Shape::Mesh(mesh) => {
                    let origin =
                        DAffine3::from_translation(scene.meshes[mesh as usize].data.origin);
                    builder.add_mesh(mesh as usize, render_from_local * origin, material);
                }
                Shape::Cuboid { min, max } => {
                    let half = DAffine3::from_scale((max - min) * 0.5);
                    let centre = DAffine3::from_translation((min + max) * 0.5);
                    builder.add_cube(render_from_local * centre * half, material);
                }
                Shape::Plane { normal, distance } => {
                    let map = quad_from_plane(render_from_local, normal, distance, reach);
                    builder.add_quad(map, material);
                }
                Shape::Sphere { radius } => match uniform_scale(render_from_local.matrix3) {
                    Some(scale) => spheres.push((
                        render_from_local.translation.as_vec3(),
                        (radius * scale) as f32,
                        material,
                    )),
                    None => builder.work.left_out += 1,
                },
                Shape::Disc { .. } | Shape::Cone(_) | Shape::Torus { .. } => {
                    builder.work.left_out += 1;
                }
            }
        }
        builder.finish(scene, &spheres)
    }

    /// Instances of meshes that all wear one material, relative to the eye.
    pub fn of_meshes(
        meshes: Vec<WorkMesh>,
        instances: Vec<(u32, DAffine3)>,
        view: View,
        material: Material,
    ) -> Result<Self, String> {
        let none = instances
            .iter()
            .find(|(mesh, _)| *mesh as usize >= meshes.len());
        if let Some((mesh, _)) = none {
            return Err(format!(
                "an instance is of mesh {mesh}; there are {}",
                meshes.len()
            ));
        }
        let mut scene = FrameScene {
            view,
            ..FrameScene::default()
        };
        scene.materials.push(material);
        let mut builder = Builder::new(&scene);
        builder.materials = vec![0; instances.len()];
        builder.work.meshes = meshes;
        builder.work.instances = instances;
        builder.finish(&scene, &[])
    }
}

/// Builds the two forms side by side.
struct Builder {
    work: Work,
    materials: Vec<u32>,
    /// Mesh of the work for each mesh of the scene, then of the cube and the quad.
    rows: Vec<Option<u32>>,
    sources: Vec<Arc<MeshData>>,
}

impl Builder {
    fn new(scene: &FrameScene) -> Self {
        let mut sources: Vec<_> = scene.meshes.iter().map(|row| row.data.clone()).collect();
        sources.extend([Arc::new(cube()), Arc::new(quad())]);
        Self {
            work: Work {
                meshes: Vec::new(),
                instances: Vec::new(),
                spheres: Vec::new(),
                frame: FrameScene::default(),
                left_out: 0,
            },
            materials: Vec::new(),
            rows: vec![None; sources.len()],
            sources,
        }
    }

    fn add_cube(&mut self, map: DAffine3, material: u32) {
        self.add_mesh(self.sources.len() - 2, map, material);
    }

    fn add_quad(&mut self, map: DAffine3, material: u32) {
        self.add_mesh(self.sources.len() - 1, map, material);
    }

    fn add_mesh(&mut self, source: usize, map: DAffine3, material: u32) {
        let data = &self.sources[source];
        let row = *self.rows[source].get_or_insert_with(|| {
            let corner = |i: u32| data.positions[i as usize];
            self.work.meshes.push(WorkMesh {
                name: data.name.clone(),
                triangles: data.triangles.iter().map(|t| t.map(corner)).collect(),
            });
            self.work.meshes.len() as u32 - 1
        });
        self.work.instances.push((row, rounded(map)));
        self.materials.push(material);
    }

    fn finish(mut self, scene: &FrameScene, spheres: &[(Vec3, f32, u32)]) -> Result<Work, String> {
        let mut frame = FrameScene {
            view: View {
                origin: DVec3::ZERO,
                ..scene.view
            },
            materials: scene.materials.clone(),
            ..FrameScene::default()
        };
        for mesh in &self.work.meshes {
            frame.meshes.push(mesh_data(mesh)?.into());
        }
        let shapes = self.work.instances.iter().zip(&self.materials);
        for (&(mesh, map), &material) in shapes {
            frame.instances.push(Instance {
                tag: 0,
                shape: Shape::Mesh(mesh),
                world_from_local: map,
                material,
            });
        }
        for &(centre, radius, material) in spheres {
            self.work.spheres.push((centre, radius));
            frame.instances.push(Instance {
                tag: 0,
                shape: Shape::Sphere {
                    radius: radius.into(),
                },
                world_from_local: DAffine3::from_translation(centre.as_dvec3()),
                material,
            });
        }
        frame.features = Features::of(&frame);
        self.work.frame = frame;
        Ok(self.work)
    }
}

/// The triangles as a mesh of separate corners, in their order.
fn mesh_data(mesh: &WorkMesh) -> Result<MeshData, String> {
    let vertices = mesh.triangles.iter().flatten().map(|v| v.as_dvec3());
    let triangles = (0..mesh.triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    MeshData::new(
        mesh.name.clone(),
        vertices.collect(),
        Vec::new(),
        triangles.collect(),
    )
}

/// What is left of a map in f32.
fn rounded(map: DAffine3) -> DAffine3 {
    map.as_affine3().as_daffine3()
}

/// The factor of a map that scales alike in all directions.
fn uniform_scale(m: DMat3) -> Option<f64> {
    let scale = m.x_axis.length();
    let gram = m.transpose() * m;
    let residue = gram - DMat3::from_diagonal(DVec3::splat(scale * scale));
    let largest = residue.to_cols_array().into_iter().map(f64::abs);
    (largest.fold(0.0, f64::max) <= 1e-6 * scale * scale).then_some(scale)
}

/// How far the farthest point of anything but planes is from the eye; at least 1.
fn farthest(scene: &FrameScene) -> f64 {
    let eye = scene.view.origin;
    let of = |instance: &Instance| {
        let (centre, radius) = match instance.shape {
            Shape::Vacant | Shape::Plane { .. } => return 0.0,
            Shape::Sphere { radius } => (DVec3::ZERO, radius),
            Shape::Cuboid { min, max } => ((min + max) * 0.5, (max - min).length() * 0.5),
            Shape::Disc { center, radius, .. } => (center, radius),
            Shape::Cone(Cone {
                a,
                radius_a,
                b,
                radius_b,
                ..
            }) => {
                let largest = radius_a.max(radius_b);
                ((a + b) * 0.5, (b - a).length() * 0.5 + largest)
            }
            Shape::Torus { major, minor } => (DVec3::ZERO, major + minor),
            Shape::Mesh(mesh) => {
                let mesh = &scene.meshes[mesh as usize].data;
                let far = mesh.positions.iter().map(|p| p.length_squared());
                (mesh.origin, f64::from(far.fold(0.0, f32::max).sqrt()))
            }
        };
        let m = instance.world_from_local.matrix3;
        let stretch = m.x_axis.length() + m.y_axis.length() + m.z_axis.length();
        (instance.world_from_local.transform_point3(centre) - eye).length() + radius * stretch
    };
    scene.instances.iter().map(of).fold(1.0, f64::max)
}

/// The map of the quad [-1, 1]^2 in z = 0 to the part of a plane around the eye.
fn quad_from_plane(map: DAffine3, normal: DVec3, distance: f64, reach: f64) -> DAffine3 {
    let foot = normal * (distance / normal.length_squared());
    let point = map.transform_point3(foot);
    let normal = (map.matrix3.inverse().transpose() * normal).normalize_or(DVec3::Y);
    let centre = normal * normal.dot(point);
    let (right, up) = normal.any_orthonormal_pair();
    DAffine3::from_mat3_translation(DMat3::from_cols(right * reach, up * reach, normal), centre)
}

fn quad() -> MeshData {
    let corner = |x, y| DVec3::new(x, y, 0.0);
    let corners = vec![
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ];
    shape("plane", corners, vec![[0, 1, 2], [0, 2, 3]])
}

/// The box [-1, 1]^3; corner i has its coordinates' signs in the bits of i.
fn cube() -> MeshData {
    let sign = |i: u32, bit: u32| if i & bit == 0 { -1.0 } else { 1.0 };
    let corners = (0..8).map(|i| DVec3::new(sign(i, 1), sign(i, 2), sign(i, 4)));
    let faces = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let triangles = faces
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    shape("box", corners.collect(), triangles.collect())
}

fn shape(name: &str, vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> MeshData {
    MeshData {
        name: name.into(),
        positions: vertices.iter().map(|v| v.as_vec3()).collect(),
        vertices,
        triangles,
        ..MeshData::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cube_is_closed_and_faces_outward() {
        let cube = cube();
        let area: f64 = (cube.triangles.iter())
            .map(|t| {
                let [a, b, c] = t.map(|i| cube.vertices[i as usize]);
                let normal = (b - a).cross(c - a);
                assert!(normal.dot(a + b + c) > 0.0, "{t:?} faces inward");
                normal.length() * 0.5
            })
            .sum();
        assert!((area - 24.0).abs() < 1e-12);
    }

    #[test]
    fn only_similar_maps_keep_a_sphere() {
        let turn = DMat3::from_rotation_y(0.7);
        assert!((uniform_scale(turn * 2.0).unwrap() - 2.0).abs() < 1e-12);
        assert_eq!(
            uniform_scale(turn * DMat3::from_diagonal(DVec3::new(1.0, 2.0, 1.0))),
            None
        );
    }

    #[test]
    fn the_quad_lies_in_its_plane() {
        let map = DAffine3::from_translation(DVec3::new(3.0, -2.0, 1.0));
        let quad = quad_from_plane(map, DVec3::new(0.0, 2.0, 0.0), 4.0, 100.0);
        // 2 y = 4, moved by -2: y = 0 in render space.
        for corner in [DVec3::ZERO, DVec3::X, DVec3::Y] {
            assert!(quad.transform_point3(corner).y.abs() < 1e-12);
        }
    }
}
