//! Vertex normals for meshes whose file has none, or wants others.
//!
//! A normal is the mean of the faces around a vertex, weighted by their angle there (Thürmer and Wüthrich
//! 1998), taken over the faces that meet at no more than the crease angle; a vertex where they do not all
//! meet so gently is split. Vertices of a file that share a place share its normals, and stay apart otherwise: they may
//! look different, or move apart.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::Part;
use crate::world::{MeshData, VertexSets};

/// The mesh with normals smooth across edges whose faces differ by at most `crease_degrees`.
///
/// Faces meet at places: whether the file repeats a vertex there makes no difference.
pub fn smooth(mesh: &MeshData, crease_degrees: f64) -> MeshData {
    smoothed(mesh, crease_degrees).0
}

/// [`smooth`] for a part of a model, which goes on knowing where its vertices come from and what moves them.
pub fn smooth_part(part: &mut Part, crease_degrees: f64) {
    let (mesh, sources) = smoothed(&part.mesh, crease_degrees);
    let gathered = |sets: &VertexSets| Arc::new(sets.gathered(&sources));
    if let Some(keys) = &mut part.keys {
        keys.keys = gathered(&keys.keys);
    }
    if let Some(morph) = &mut part.morph {
        morph.targets = gathered(&morph.targets);
    }
    if let Some(binding) = &mut part.binding {
        *binding = Arc::new(binding.gathered(&sources));
    }
    part.mesh = mesh;
    let source_of = |&vertex: &u32| part.sources.get(vertex as usize).copied();
    part.sources = sources.iter().filter_map(source_of).collect();
}

/// The smooth mesh, and which vertex of the mesh given each of its vertices is.
fn smoothed(mesh: &MeshData, crease_degrees: f64) -> (MeshData, Vec<u32>) {
    let places = places(&mesh.vertices);
    let faces: Vec<[Weighted; 3]> = mesh
        .triangles
        .iter()
        .map(|t| corners_of(mesh, *t))
        .collect();
    let mut around: Vec<Vec<(u32, u8)>> = vec![Vec::new(); mesh.vertices.len()];
    for (face, triangle) in mesh.triangles.iter().enumerate() {
        for corner in 0..3_u8 {
            let place = places[triangle[usize::from(corner)] as usize];
            around[place as usize].push((face as u32, corner));
        }
    }
    let crowds = crowds(&around, &faces);
    let limit = crease_degrees.to_radians().cos() - 1e-9;
    let mut rows: HashMap<(u32, [u32; 3]), u32> = HashMap::new();
    let (mut vertices, mut normals, mut sources) = (Vec::new(), Vec::new(), Vec::new());
    let (mut uvs, mut colors) = (Vec::new(), Vec::new());
    let triangles = mesh
        .triangles
        .iter()
        .enumerate()
        .map(|(face, triangle)| {
            let own = faces[face][0].normal;
            triangle.map(|vertex| {
                let place = places[vertex as usize];
                let gentle = |corner: &Weighted| corner.normal.dot(own) >= limit;
                let share = |corner: Weighted| corner.normal * corner.angle;
                let sum: DVec3 = match crowds.get(&place) {
                    Some(crowd) => crowd.iter().copied().filter(gentle).map(share).sum(),
                    None => {
                        let around = around[place as usize].iter();
                        let corners = around.map(|&(f, c)| faces[f as usize][usize::from(c)]);
                        corners.filter(gentle).map(share).sum()
                    }
                };
                // A triangle without area has no normal; any unit vector keeps shading finite.
                let own = own.try_normalize().unwrap_or(DVec3::Y);
                let normal: Vec3 = sum.try_normalize().unwrap_or(own).as_vec3();
                let key = (vertex, normal.to_array().map(f32::to_bits));
                *rows.entry(key).or_insert_with(|| {
                    vertices.push(mesh.vertices[vertex as usize]);
                    normals.push(normal);
                    uvs.extend(mesh.uvs.get(vertex as usize));
                    colors.extend(mesh.colors.get(vertex as usize));
                    sources.push(vertex);
                    vertices.len() as u32 - 1
                })
            })
        })
        .collect();
    let positions = vertices
        .iter()
        .map(|&v| (v - mesh.origin).as_vec3())
        .collect();
    let smooth = MeshData {
        vertices,
        positions,
        normals,
        curved: true,
        uvs,
        colors,
        triangles,
        ..mesh.clone()
    };
    (smooth, sources)
}

/// Faces at a place beyond which those that face nearly the same way are taken as one.
const CROWD: usize = 512;
/// Steps into which the coordinates of their normals are parted for that.
const STEPS: f64 = 6.0;

/// The faces at places where very many meet, put together by where they face: each face there is held against each of
/// these, and the fan of a file made for it has hundreds of thousands.
fn crowds(around: &[Vec<(u32, u8)>], faces: &[[Weighted; 3]]) -> HashMap<u32, Vec<Weighted>> {
    let crowded = (0_u32..).zip(around).filter(|(_, at)| at.len() > CROWD);
    let together = crowded.map(|(place, at)| {
        let mut sums: HashMap<[i32; 3], DVec3> = HashMap::new();
        for &(face, corner) in at {
            let Weighted { normal, angle } = faces[face as usize][usize::from(corner)];
            let step = (normal * STEPS).round().as_ivec3().to_array();
            *sums.entry(step).or_default() += normal * angle;
        }
        // Sums depend on their order, which that of the map is not.
        let mut sums: Vec<_> = sums.into_iter().collect();
        sums.sort_unstable_by_key(|(step, _)| *step);
        let weighted = |(_, sum): ([i32; 3], DVec3)| Weighted {
            normal: sum.normalize_or_zero(),
            angle: sum.length(),
        };
        (place, sums.into_iter().map(weighted).collect())
    });
    together.collect()
}

/// A face's normal and its angle at one corner.
#[derive(Clone, Copy)]
struct Weighted {
    normal: DVec3,
    angle: f64,
}

fn corners_of(mesh: &MeshData, triangle: [u32; 3]) -> [Weighted; 3] {
    let p = triangle.map(|i| mesh.vertices[i as usize]);
    let normal = (p[1] - p[0]).cross(p[2] - p[0]).normalize_or_zero();
    [0, 1, 2].map(|i| {
        let (a, b) = (p[(i + 1) % 3] - p[i], p[(i + 2) % 3] - p[i]);
        // atan2 keeps its precision for slivers, where acos does not.
        let angle = a.cross(b).length().atan2(a.dot(b));
        Weighted { normal, angle }
    })
}

/// For each vertex the first one at the same place.
fn places(vertices: &[DVec3]) -> Vec<u32> {
    let mut first: HashMap<[u64; 3], u32> = HashMap::with_capacity(vertices.len());
    vertices
        .iter()
        .enumerate()
        .map(|(i, v)| {
            // Adding zero makes -0 and 0 the same place.
            let bits = (*v + DVec3::ZERO).to_array().map(f64::to_bits);
            *first.entry(bits).or_insert(i as u32)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::{Morph, SkinBinding};

    /// A unit cube of 12 triangles on 8 vertices.
    fn cube() -> MeshData {
        let vertices = (0..8)
            .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
            .collect();
        let quads = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let triangles = quads
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect();
        MeshData::new("cube", vertices, Vec::new(), triangles).unwrap()
    }

    #[test]
    fn a_cube_keeps_its_edges_below_90_degrees_and_loses_them_above() {
        let sharp = smooth(&cube(), 60.0);
        assert_eq!(sharp.vertices.len(), 24, "three normals a corner");
        for (triangle, rows) in sharp
            .triangles
            .iter()
            .map(|t| (t, t.map(|i| sharp.normals[i as usize])))
        {
            assert!(
                rows.iter().all(|n| n.abs().max_element() == 1.0),
                "{triangle:?}: {rows:?}"
            );
        }
        let round = smooth(&cube(), 120.0);
        assert_eq!(round.vertices.len(), 8, "one normal a corner");
        for (v, n) in round.vertices.iter().zip(&round.normals) {
            let outward = (*v - DVec3::splat(0.5)).normalize().as_vec3();
            // Weighted by angle, the diagonals of the quads do not pull the normal aside.
            assert!(n.distance(outward) < 1e-6, "{n} != {outward}");
        }
    }

    #[test]
    fn what_moves_vertices_goes_along_when_they_are_split() {
        let mesh = cube();
        let offsets = mesh.positions.clone();
        let binding = SkinBinding::new(
            (0..8).map(|vertex| [vertex, 0, 0, 0]).collect(),
            vec![[1.0, 0.0, 0.0, 0.0]; 8],
        );
        let mut part = Part {
            sources: (0..8).collect(),
            morph: Some(Morph {
                targets: Arc::new(VertexSets {
                    vertices: 8,
                    values: offsets.iter().copied().chain(vec![Vec3::X; 8]).collect(),
                }),
                weights: vec![0.0; 2],
            }),
            binding: binding.ok().map(Arc::new),
            mesh,
            ..Part::default()
        };
        smooth_part(&mut part, 60.0);
        let (morph, binding) = (part.morph.unwrap(), part.binding.unwrap());
        assert_eq!(morph.targets.set(0), part.mesh.positions);
        assert_eq!(morph.targets.set(1), [Vec3::X; 24]);
        let joints = binding.joints.iter().map(|joints| joints[0]);
        assert_eq!(joints.collect::<Vec<_>>(), part.sources);
    }

    #[test]
    fn lips_that_touch_share_their_normals_and_open() {
        // Two triangles that meet at an edge whose vertices the file has twice.
        let corner = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let upper = [corner(0., 0., 0.), corner(1., 0., 0.), corner(0., 1., 0.2)];
        let lower = [corner(1., 0., 0.), corner(0., 0., 0.), corner(0., -1., 0.2)];
        let vertices = [upper, lower].concat();
        let mesh = MeshData::new("lips", vertices, Vec::new(), vec![[0, 1, 2], [3, 4, 5]]).unwrap();
        let opening: Vec<Vec3> = (0..6).map(|v| Vec3::splat(v as f32)).collect();
        let mut part = Part {
            morph: Some(Morph {
                targets: Arc::new(VertexSets {
                    vertices: 6,
                    values: opening.clone(),
                }),
                weights: vec![0.0],
            }),
            mesh,
            ..Part::default()
        };
        smooth_part(&mut part, 90.0);
        assert_eq!(part.morph.unwrap().targets.set(0), opening);
        assert_eq!(part.mesh.normals[0], part.mesh.normals[4]);
        assert!(part.sources.is_empty(), "no file is another pose of it");
    }

    #[test]
    fn a_degenerate_triangle_gives_no_nan() {
        let mesh = MeshData::new("d", vec![DVec3::ZERO; 3], Vec::new(), vec![[0, 1, 2]]).unwrap();
        assert!(smooth(&mesh, 60.0).normals.iter().all(|n| n.is_finite()));
    }

    #[test]
    fn hundreds_of_thousands_of_faces_around_a_vertex_are_smoothed() {
        let count = 200_000_u32;
        let rim = |i: u32| {
            let angle = f64::from(i) / f64::from(count) * std::f64::consts::TAU;
            DVec3::new(angle.cos(), angle.sin(), -1.0)
        };
        let vertices = (0..count).map(rim).chain([DVec3::ZERO]).collect();
        let fan = (0..count).map(|i| [i, (i + 1) % count, count]).collect();
        let cone = MeshData::new("cone", vertices, Vec::new(), fan).unwrap();
        let round = smooth(&cone, 180.0);
        let top = round.triangles[0][2] as usize;
        assert!(round.normals[top].distance(Vec3::Z) < 1e-4);
        // Faces within the crease of the first one, on both sides of it.
        let sharp = smooth(&cone, 60.0);
        let top = sharp.normals[sharp.triangles[0][2] as usize];
        assert!(top.x > 0.3 && top.y.abs() < 0.1 && top.z > 0.6, "{top}");
    }
}
