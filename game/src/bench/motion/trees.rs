//! The tree over instances when all of them move: what it chooses to do, refits and new trees by force, and
//! what it is worth to rays.
//!
//! The boxes are those of a crowd in motion, recorded frame by frame, so that all three follow the same.

use glam::{DAffine3, DVec3};
use orrery_engine::bvh::{InstanceTree, Tree, TreeAction};
use orrery_engine::frame::{FrameScene, Shape};
use orrery_engine::geom::{Aabb, SphereFrame};
use orrery_engine::time::Clock;

use super::Sizes;
use super::scenes::{Scene, Thing};
use crate::bench::crowd::{Crowd, Kind, Plan};
use crate::bench::report::{Better, Row};
use crate::bench::timing::{median, millis, millis_row, pools, zero_row};
use crate::failure::Failure;

/// Frames before the clock counts.
const WARM_UP: usize = 5;
/// How fast rays may be against those in a tree of full quality, at least.
const RAYS_TARGET: f64 = 0.9;

/// A crowd's boxes, frame by frame.
pub struct Recording {
    /// Kind and count, as rows are called.
    pub name: String,
    /// How many things.
    pub count: usize,
    /// Of every frame, of every row.
    pub boxes: Vec<Vec<Aabb>>,
    /// What is in the boxes of the last frame.
    pub scene: Scene,
    /// The frame itself.
    pub last: FrameScene,
    /// All are instances of meshes, which rivals' trees over instances can hold.
    pub is_for_rivals: bool,
}

/// Both kinds, every count; made as they are asked for.
pub fn recordings(sizes: &Sizes, samples: usize) -> impl Iterator<Item = Recording> {
    let kinds = [(Kind::Spheres, "spheres"), (Kind::Meshes, "meshes")];
    kinds.into_iter().flat_map(move |(kind, word)| {
        sizes.trees.iter().map(move |&count| {
            let name = format!("{word}.{count}");
            record(name, count, kind, WARM_UP + samples.max(60))
        })
    })
}

fn record(name: String, count: usize, kind: Kind, frames: usize) -> Recording {
    let mut crowd = Crowd::new(Plan {
        count,
        kind,
        moving: true,
        profiled: false,
    });
    let mut boxes = Vec::with_capacity(frames);
    for frame in 0..frames {
        *crowd.engine.world.resource_mut::<Clock>() = Clock::Frame(frame as u64);
        crowd.engine.frame();
        boxes.push(boxes_of(crowd.engine.world.resource::<FrameScene>()));
    }
    let last = crowd.engine.world.resource::<FrameScene>().clone();
    Recording {
        name,
        count,
        boxes,
        scene: Scene::of(&last),
        last,
        is_for_rivals: kind == Kind::Meshes,
    }
}

/// Boxes of a crowd of spheres that stands still.
pub fn still_boxes(count: usize) -> Vec<Aabb> {
    let boxes = record(String::new(), count, Kind::Spheres, 1).boxes.pop();
    boxes.unwrap_or_default()
}

/// A box around every row, in the world's space.
fn boxes_of(scene: &FrameScene) -> Vec<Aabb> {
    let rows = scene.instances.iter();
    rows.map(|row| match row.shape {
        Shape::Sphere { radius } => {
            let centre = row.world_from_local.translation;
            Aabb::of([centre - radius, centre + radius].map(|p| p.as_vec3()))
        }
        Shape::Mesh(mesh) => {
            let vertices = &scene.meshes[mesh as usize].data.vertices;
            let place = |map: DAffine3, p: &DVec3| map.transform_point3(*p).as_vec3();
            Aabb::of(vertices.iter().map(|p| place(row.world_from_local, p)))
        }
        _ => Aabb::EMPTY,
    })
    .collect()
}

/// Everything about one recording.
pub fn rows(recording: &Recording, sizes: &Sizes, samples: usize) -> Result<Vec<Row>, Failure> {
    let mut rows = Vec::new();
    let mut followed = InstanceTree::default();
    for pool in pools()? {
        let name = |what: &str| {
            let threads = pool.current_num_threads();
            format!("tree.{}.{threads}t.{what}", recording.name)
        };
        let mut invalid = 0;
        let chosen = pool.install(|| follow(recording, &mut invalid));
        rows.push(millis_row(name("update"), &chosen.millis));
        rows.push(Row::single(
            name("rebuilds"),
            "frames",
            Better::Lower,
            chosen.rebuilds as f64,
        ));
        let refit =
            pool.install(|| force(recording, &mut invalid, |tree, boxes| tree.refit(boxes)));
        rows.push(millis_row(name("refit"), &refit));
        let rebuild =
            pool.install(|| force(recording, &mut invalid, |tree, boxes| tree.rebuild(boxes)));
        rows.push(millis_row(name("rebuild"), &rebuild));
        rows.push(zero_row(name("invalid"), "trees", invalid));
        followed = chosen.tree;
    }
    rows.extend(ray_rows(recording, &followed, sizes, samples));
    Ok(rows)
}

struct Followed {
    tree: InstanceTree,
    millis: Vec<f64>,
    rebuilds: usize,
}

/// What the tree chooses to do, all rows being told as moved.
fn follow(recording: &Recording, invalid: &mut u64) -> Followed {
    let moved: Vec<u32> = (0..recording.count as u32).collect();
    let mut tree = InstanceTree::default();
    let mut rebuilds = 0;
    let samples = recording.boxes.len() - WARM_UP;
    let millis = millis(WARM_UP, samples, |frame| {
        let changed = (frame > 0).then_some(&moved[..]);
        let work = tree.update(&recording.boxes[frame], changed);
        rebuilds += usize::from(frame >= WARM_UP && work.action == TreeAction::Rebuild);
    });
    *invalid += is_invalid(&tree, recording);
    Followed {
        tree,
        millis,
        rebuilds,
    }
}

/// What is done to the tree of the first frame, whatever it would choose, at every other.
fn force(
    recording: &Recording,
    invalid: &mut u64,
    step: impl Fn(&mut InstanceTree, &[Aabb]),
) -> Vec<f64> {
    let mut tree = InstanceTree::default();
    tree.rebuild(&recording.boxes[0]);
    let samples = recording.boxes.len() - WARM_UP;
    let times = millis(WARM_UP, samples, |frame| {
        step(&mut tree, &recording.boxes[frame])
    });
    *invalid += is_invalid(&tree, recording);
    times
}

fn is_invalid(tree: &InstanceTree, recording: &Recording) -> u64 {
    let last = recording.boxes.last();
    last.map_or(0, |boxes| u64::from(tree.validate(boxes).is_err()))
}

/// Rays a second in the tree as it followed, in one built anew as quickly, and in one of full quality, on one
/// thread and in turns; all find the same.
fn ray_rows(
    recording: &Recording,
    followed: &InstanceTree,
    sizes: &Sizes,
    samples: usize,
) -> Vec<Row> {
    let boxes = recording.boxes.last().map_or(&[][..], Vec::as_slice);
    let full = Tree::build_single(boxes);
    let mut fresh = InstanceTree::default();
    fresh.update(boxes, None);
    let scene = &recording.scene;
    let mut rows = Vec::new();
    let mut wrong = 0;
    for (kind, rays) in scene.rays(recording.count, sizes.rays) {
        let mut rates = [(); 3].map(|()| Vec::with_capacity(samples));
        for _ in 0..samples {
            let (a, b, c) = (
                scene.trace(followed.nodes(), None, &rays),
                scene.trace(fresh.nodes(), None, &rays),
                scene.trace(&full.nodes, Some(&full.prims), &rays),
            );
            wrong += c.differences(&a) + c.differences(&b);
            for (rates, traced) in rates.iter_mut().zip([a, b, c]) {
                rates.push(rays.len() as f64 / traced.secs * 1e-6);
            }
        }
        let name = |what: &str| format!("tree.{}.{kind}.{what}", recording.name);
        let words = ["followed", "rebuilt", "full_quality"];
        rows.extend(
            words
                .iter()
                .zip(&rates)
                .map(|(what, rates)| Row::sampled(name(what), "Mrays/s", Better::Higher, rates)),
        );
        let [followed, _, full] = rates.map(|rates| median(&rates));
        rows.push(
            Row::single(name("ratio"), "1", Better::Higher, followed / full)
                .with_target(RAYS_TARGET),
        );
    }
    let name = format!("tree.{}.wrong", recording.name);
    rows.push(zero_row(name, "rays", wrong));
    rows
}

impl Scene {
    /// What is in the boxes of a frame.
    fn of(scene: &FrameScene) -> Self {
        let things = scene.instances.iter().map(|row| match row.shape {
            Shape::Sphere { radius } => {
                Thing::Sphere(SphereFrame::new(row.world_from_local.translation, radius))
            }
            Shape::Mesh(mesh) => Thing::Mesh {
                mesh,
                local_from_world: row.world_from_local.inverse().as_affine3a(),
            },
            _ => Thing::Sphere(SphereFrame::new(DVec3::ZERO, 0.0)),
        });
        let corners = |row: &orrery_engine::world::MeshRow| {
            let corner = |i: u32| row.data.vertices[i as usize].as_vec3();
            row.data.triangles.iter().map(|t| t.map(corner)).collect()
        };
        Self {
            things: things.collect(),
            meshes: scene.meshes.iter().map(corners).collect(),
        }
    }
}
