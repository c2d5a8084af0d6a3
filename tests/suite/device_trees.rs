//! Meshes deformed and refitted on the device, against the host's word.

use std::f64::consts::TAU;
use std::sync::{Arc, OnceLock};

use glam::{DAffine3, DQuat, DVec3, Vec3};
use orrery_engine::bvh::{Child, Node4, Tree};
use orrery_engine::frame::wire::{PlacedTriangleRow, TriangleRow, VertexRow};
use orrery_engine::geom::Aabb;
use orrery_engine::trace::gpu::trees::{DeformedMesh, MeshPlace, Rig, RigRows};
use orrery_engine::trace::gpu::{AdapterChoice, Gpu};
use orrery_engine::world::{DeformStep, Deformation, MeshData, SkinBinding, VertexSets};
use orrery_tests::random_scene::{Random, icosphere};

/// One device for all tests.
pub fn gpu() -> Arc<Gpu> {
    static GPU: OnceLock<Arc<Gpu>> = OnceLock::new();
    let open = || Arc::new(Gpu::open(Gpu::instance(), &AdapterChoice::Any, None).expect("a GPU"));
    Arc::clone(GPU.get_or_init(open))
}

/// A sphere away from the origin, smooth or flat.
fn ball(levels: u32, centre: DVec3, smooth: bool) -> Arc<MeshData> {
    let sphere = icosphere(levels);
    let vertices: Vec<DVec3> = sphere.vertices.iter().map(|v| *v + centre).collect();
    let normals = if smooth {
        sphere.vertices.iter().map(|v| v.as_vec3()).collect()
    } else {
        Vec::new()
    };
    Arc::new(MeshData::new("ball", vertices, normals, sphere.triangles).expect("a mesh"))
}

fn tree_of(mesh: &MeshData) -> Tree {
    let corner = |i: u32| mesh.positions[i as usize];
    let boxes = mesh.triangles.iter().map(|t| Aabb::of(t.map(corner)));
    Tree::build(&boxes.collect::<Vec<_>>())
}

/// Every kind of step, one after the other.
fn all_steps(mesh: &MeshData, random: &mut Random) -> Deformation {
    let count = mesh.positions.len();
    let poses = |random: &mut Random, size: f32| {
        let jitter = |p: &Vec3| *p * (1.0 + size * random.unit() as f32);
        let values = [0, 1].iter().flat_map(|_| &mesh.positions);
        Arc::new(VertexSets {
            vertices: count,
            values: values.map(jitter).collect(),
        })
    };
    // About a place near the mesh: what moves far loses digits of f32.
    let pivot = DAffine3::from_translation(mesh.origin + DVec3::Y * 0.5);
    let turn = DAffine3::from_rotation_translation(DQuat::from_rotation_y(0.4), DVec3::X * 0.3);
    let turn = pivot * turn * pivot.inverse();
    let joints = (0..count).map(|i| [0, 1, (i % 2) as u32, 1]).collect();
    let weights = (0..count).map(|i| {
        // Whole sixteenths: the sum is one, not nearly one.
        let share = (i % 13) as f32 / 16.0;
        [share, 0.75 - 0.75 * share, 0.25 - 0.25 * share, 0.0]
    });
    let binding = SkinBinding::new(joints, weights.collect()).expect("a binding");
    Deformation {
        steps: vec![
            DeformStep::Keys {
                keys: poses(random, 0.2),
                from: 1,
                to: 0,
                share: 0.3,
            },
            DeformStep::Morph {
                targets: poses(random, 0.1),
                weights: vec![0.0, 0.15],
            },
            DeformStep::Skin {
                binding: Arc::new(binding),
                joints: vec![DAffine3::IDENTITY, turn],
            },
            DeformStep::Wave {
                wave: DVec3::new(3.0, -2.0, 5.0),
                amplitude: DVec3::new(0.1, 0.2, -0.1),
                phase: 40.0 * TAU + 1.0,
            },
            DeformStep::Twist {
                origin: mesh.origin + DVec3::new(0.2, 0.0, 0.1),
                axis: DVec3::new(1.0, 2.0, -0.5).normalize(),
                rate: 1.5,
                offset: -0.4,
            },
        ],
    }
}

/// A vertex by the definitions of [`DeformStep`], in f64 and in the mesh's own space.
fn deformed(mesh: &MeshData, deformation: &Deformation, vertex: usize) -> DVec3 {
    let at = |sets: &VertexSets, set: u32| sets.set(set)[vertex].as_dvec3();
    let mut p = mesh.positions[vertex].as_dvec3() + mesh.origin;
    for step in &deformation.steps {
        p = match step {
            DeformStep::Keys {
                keys,
                from,
                to,
                share,
            } => mesh.origin + at(keys, *from).lerp(at(keys, *to), *share),
            DeformStep::Morph { targets, weights } => {
                let offsets = (0..).zip(weights).map(|(set, w)| at(targets, set) * *w);
                p + offsets.sum::<DVec3>()
            }
            DeformStep::Skin { binding, joints } => (0..4)
                .map(|i| {
                    let joint = joints[binding.joints[vertex][i] as usize];
                    joint.transform_point3(p) * f64::from(binding.weights[vertex][i])
                })
                .sum(),
            DeformStep::Wave {
                wave,
                amplitude,
                phase,
            } => p + *amplitude * (wave.dot(p) - phase).sin(),
            DeformStep::Twist {
                origin,
                axis,
                rate,
                offset,
            } => {
                let angle = rate * (p - *origin).dot(*axis) + offset;
                *origin + DQuat::from_axis_angle(*axis, angle) * (p - *origin)
            }
        };
    }
    p - mesh.origin
}

/// What the device must make of a mesh's nodes, given its vertices; and what they cost.
fn refitted(tree: &Tree, mesh: &MeshData, vertices: &[Vec3]) -> (Vec<Node4>, f64) {
    let mut nodes = tree.nodes.clone();
    let mut cost = 0.0;
    let whole = |node: &Node4| {
        let boxes = (0..4).map(|slot| node.child_box(slot));
        boxes.fold(Aabb::EMPTY, Aabb::union)
    };
    for index in (0..nodes.len()).rev() {
        for slot in 0..4 {
            let child = Child::decode(nodes[index].children[slot]);
            let (bounds, weight) = match child {
                Child::None => continue,
                Child::Node(node) => (whole(&nodes[node as usize]), 1),
                Child::Leaf { first, count } => {
                    let prims = &tree.prims[first as usize..(first + count) as usize];
                    let corners = prims.iter().flat_map(|&p| mesh.triangles[p as usize]);
                    let bounds = Aabb::of(corners.map(|c| vertices[c as usize]));
                    (bounds.grown(), count)
                }
            };
            cost += f64::from(bounds.half_area()) * f64::from(weight);
            nodes[index].set_child(slot, &bounds, child);
        }
    }
    (
        nodes.clone(),
        cost / f64::from(whole(&nodes[0]).half_area()),
    )
}

/// Where a mesh lies among the rows of [`lay_out`].
struct Place {
    root: usize,
    first_triangle: usize,
    first_vertex: usize,
}

/// Meshes one after the other with something else before each. Boxes and vertices are poison: nothing that
/// the host knows of them may be used.
fn lay_out(meshes: &[(Arc<MeshData>, Tree)]) -> (RigRows, Vec<Place>) {
    let mut rows = RigRows::default();
    let mut places = Vec::new();
    let poison = f32::NAN;
    let nowhere = VertexRow {
        vector: [poison; 3],
        further: 0,
    };
    for (mesh, tree) in meshes {
        rows.nodes.push(Node4::EMPTY);
        rows.triangles.push(TriangleRow::default());
        rows.vertices.push(nowhere);
        places.push(Place {
            root: rows.nodes.len(),
            first_triangle: rows.triangles.len(),
            first_vertex: rows.vertices.len(),
        });
        rows.nodes.extend(tree.nodes.iter().map(|node| Node4 {
            min_x: [poison; 4],
            max_z: [poison; 4],
            ..*node
        }));
        rows.triangles
            .extend(tree.prims.iter().map(|&prim| TriangleRow {
                corners: mesh.triangles[prim as usize],
                prim,
            }));
        let vectors = mesh.positions.len() + mesh.normals.len();
        rows.vertices.extend(vec![nowhere; vectors]);
    }
    (rows, places)
}

fn vector(row: &VertexRow) -> Vec3 {
    Vec3::from(row.vector)
}

#[test]
fn deformed_meshes_and_their_trees_are_as_the_host_computes_them() {
    let meshes: Vec<(Arc<MeshData>, Tree)> = [
        ball(3, DVec3::new(1000.0, -20.0, 3.0), true),
        ball(0, DVec3::ZERO, false),
        ball(4, DVec3::new(-7.0, 0.5, 0.25), true),
    ]
    .into_iter()
    .map(|mesh| (Arc::clone(&mesh), tree_of(&mesh)))
    .collect();
    let mut random = Random::new(3);
    let deformations: Vec<Deformation> = meshes
        .iter()
        .map(|(mesh, _)| all_steps(mesh, &mut random))
        .collect();
    let (rows, places) = lay_out(&meshes);
    let mut rig = Rig::new(gpu(), &rows).expect("a rig");
    let all: Vec<DeformedMesh> = (0..meshes.len())
        .map(|i| DeformedMesh {
            first_vertex: places[i].first_vertex as u32,
            first_normal: (places[i].first_vertex + meshes[i].0.positions.len()) as u32,
            data: &meshes[i].0,
            deformation: &deformations[i],
        })
        .collect();
    let trees: Vec<MeshPlace> = (0..meshes.len())
        .map(|i| MeshPlace {
            key: 10 + i as u32,
            root: places[i].root as u32,
            levels: &meshes[i].1.levels,
            first_triangle: places[i].first_triangle as u32,
            first_vertex: places[i].first_vertex as u32,
        })
        .collect();
    rig.refit(&all[..1], &trees[..1]).expect("one");
    rig.refit(&all, &trees).expect("all of them");
    let (nodes, vertices) = (
        rig.nodes().expect("nodes"),
        rig.vertices().expect("vertices"),
    );
    let triangles = rig.triangles().expect("triangles");
    let costs = rig.report().expect("a report").costs;
    for (i, (mesh, tree)) in meshes.iter().enumerate() {
        let vectors =
            &vertices[places[i].first_vertex..][..mesh.positions.len() + mesh.normals.len()];
        let (own, normals) = vectors.split_at(mesh.positions.len());
        for (v, row) in own.iter().enumerate() {
            let expected = deformed(mesh, &deformations[i], v);
            let error = (vector(row).as_dvec3() - expected).length();
            assert!(error < 1e-5, "vertex {v} of mesh {i}: {error}");
        }
        let positions: Vec<Vec3> = own.iter().map(vector).collect();
        check_normals(mesh, &positions, normals);
        let placed = &triangles[places[i].first_triangle..][..tree.prims.len()];
        check_placed(mesh, tree, &positions, placed);
        let (expected, cost) = refitted(tree, mesh, &positions);
        let found = &nodes[places[i].root..][..expected.len()];
        for (n, (found, expected)) in found.iter().zip(&expected).enumerate() {
            assert_eq!(found, expected, "node {n} of mesh {i}: device, then host");
        }
        let (key, own) = costs[i];
        assert_eq!(key, 10 + i as u32);
        let error = (f64::from(own) / cost - 1.0).abs();
        assert!(error < 1e-4, "mesh {i} costs {own} there, {cost} here");
    }
}

/// Triangles are those of the leaves, with the vertices' positions bit for bit.
fn check_placed(mesh: &MeshData, tree: &Tree, positions: &[Vec3], rows: &[PlacedTriangleRow]) {
    for (row, &prim) in rows.iter().zip(&tree.prims) {
        let corners = mesh.triangles[prim as usize];
        assert_eq!((row.corners, row.prim), (corners, prim));
        let expected = corners.map(|v| positions[v as usize]);
        let found = [row.a, row.b, row.c].map(Vec3::from);
        assert_eq!(found, expected, "triangle {prim}: device, then host");
    }
}

/// Smooth meshes have the mean of the faces around by area, others none.
fn check_normals(mesh: &MeshData, positions: &[Vec3], rows: &[VertexRow]) {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|v| positions[v as usize].as_dvec3());
        for &corner in triangle {
            sums[corner as usize] += (b - a).cross(c - a);
        }
    }
    for (v, (row, sum)) in rows.iter().zip(sums).enumerate() {
        let error = (vector(row).as_dvec3() - sum.normalize()).length();
        assert!(error < 1e-4, "normal {v}: {error}");
    }
}

#[test]
fn boxes_at_and_near_zero_grow_as_they_do_on_the_host() {
    let corners = [
        0.0, -0.0, 1e-21, -1e-20, 1e-38, 3e-20, -1.0, 1.0, 1e-12, -3e9,
    ];
    let vertices: Vec<DVec3> = (0..corners.len() * 3)
        .map(|i| {
            let at = |k: usize| corners[(i * 7 + k * 3) % corners.len()];
            DVec3::new(at(0), at(1), at(2))
        })
        .collect();
    let triangles = (0..corners.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
    let mut mesh = MeshData::new("edges", vertices, Vec::new(), triangles.collect()).unwrap();
    // As they are, whatever the middle.
    mesh.positions = mesh.vertices.iter().map(|v| v.as_vec3()).collect();
    let mesh = Arc::new(mesh);
    let tree = tree_of(&mesh);
    let meshes = [(Arc::clone(&mesh), tree)];
    let (rows, places) = lay_out(&meshes);
    let mut rig = Rig::new(gpu(), &rows).expect("a rig");
    let still = Deformation::default();
    let at_rest = DeformedMesh {
        first_vertex: places[0].first_vertex as u32,
        first_normal: 0,
        data: &mesh,
        deformation: &still,
    };
    let place = MeshPlace {
        key: 0,
        root: places[0].root as u32,
        levels: &meshes[0].1.levels,
        first_triangle: places[0].first_triangle as u32,
        first_vertex: places[0].first_vertex as u32,
    };
    rig.refit(&[at_rest], &[place]).expect("refits");
    let (expected, _) = refitted(&meshes[0].1, &mesh, &mesh.positions);
    assert_eq!(rig.nodes().unwrap()[places[0].root..], expected);
}
