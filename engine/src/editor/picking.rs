//! What is under the mouse: a ray of the tracer that drew the picture, so what is selected is what is seen.
//!
//! With Alt the ray goes on from mirrors and through glass, along the heavier of the two, until it meets something that
//! shows its own colour: what is seen there.

use bevy_ecs::prelude::*;
use egui::{Pos2, Rect};
use glam::DVec3;

use super::outline::{Boxes, local_box};
use super::sight::Sight;
use crate::frame::FrameScene;
use crate::scene::Imported;
use crate::trace::{ActiveTracer, Hit, Query, Ray, Tracer};
use crate::world::{
    Camera, DirectionalLight, GlobalTransform, Material, PointLight, Reflection, SceneId, SpotLight,
};

/// Mirrors and panes that are looked along at most.
const BOUNCES: usize = 12;
/// Angle between a ray and the two beside it that tell how a surface lies, radians.
const BESIDE: f64 = 1e-3;
/// How near a mark of a light or a camera has to be, points.
pub const MARK_REACH: f32 = 11.0;

/// What a ray met.
struct Met {
    instance: u32,
    entity: Entity,
    t: f64,
}

fn ask(tracer: &mut dyn Tracer, scene: &FrameScene, rays: &[(DVec3, DVec3)]) -> Vec<Option<Met>> {
    let ray = |&(origin, dir): &(DVec3, DVec3)| Ray {
        origin: (origin - scene.view.origin).as_vec3(),
        dir: dir.as_vec3(),
        t_min: 0.0,
        t_max: f32::MAX,
    };
    let rays: Vec<Ray> = rays.iter().map(ray).collect();
    // A device that fails says so when it draws.
    let hits = tracer.intersect(&rays, Query::Closest).unwrap_or_default();
    let met = |hit: &Hit| {
        let instance = scene.instances.get(hit.instance as usize)?;
        Some(Met {
            instance: hit.instance,
            entity: Entity::try_from_bits(instance.tag)?,
            t: hit.t,
        })
    };
    let mut met: Vec<Option<Met>> = hits.iter().map(met).collect();
    met.resize_with(rays.len(), || None);
    met
}

/// The entity seen at a point of the window, through mirrors and glass if asked for.
pub fn entity_at(world: &mut World, sight: &Sight, at: Pos2, through: bool) -> Option<Entity> {
    world.resource_scope(|world, mut tracer: Mut<ActiveTracer>| {
        let tracer = tracer.0.as_deref_mut()?;
        let scene = world.get_resource::<FrameScene>()?;
        let (origin, dir) = sight.ray(at);
        if through {
            seen(tracer, scene, origin, dir)
        } else {
            ask(tracer, scene, &[(origin, dir)]).pop()??.entity.into()
        }
    })
}

/// Follows a ray along what weighs more, reflection or refraction, to the first surface that weighs more itself.
fn seen(tracer: &mut dyn Tracer, scene: &FrameScene, origin: DVec3, dir: DVec3) -> Option<Entity> {
    let (mut origin, mut dir) = (origin, dir);
    let mut inside: Vec<u32> = Vec::new();
    for _ in 0..BOUNCES {
        let (u, v) = dir.any_orthonormal_pair();
        let beside = [DVec3::ZERO, u * BESIDE, v * BESIDE].map(|aside| (origin, dir + aside));
        let met = ask(tracer, scene, &beside);
        let first = met.first()?.as_ref()?;
        let row = scene.instances.get(first.instance as usize)?;
        let material = scene.materials.get(row.material as usize)?;
        let way = Way::of(material);
        let point = origin + dir * first.t;
        let places: Vec<DVec3> = met
            .iter()
            .zip(beside)
            .filter_map(|(met, (origin, dir))| {
                let met = met.as_ref().filter(|met| met.instance == first.instance)?;
                Some(origin + dir * met.t)
            })
            .collect();
        // At an edge nobody can tell how the surface lies.
        let (Some(way), [a, b, c]) = (way, places.as_slice()) else {
            return Some(first.entity);
        };
        let normal = (*b - *a).cross(*c - *a).normalize_or_zero();
        let normal = if normal.dot(dir) > 0.0 {
            -normal
        } else {
            normal
        };
        let leaves = inside.contains(&first.instance);
        let refracted = match way {
            Way::Reflect => None,
            Way::Refract(ior) => refract(dir, normal, if leaves { ior } else { ior.recip() }),
        };
        let step = 1e-4 * (first.t + point.distance(scene.view.origin)).max(1e-6);
        match refracted {
            Some(next) => {
                if leaves {
                    inside.retain(|&instance| instance != first.instance);
                } else {
                    inside.push(first.instance);
                }
                (origin, dir) = (point - normal * step, next);
            }
            None => {
                (origin, dir) = (
                    point + normal * step,
                    dir - normal * (2.0 * dir.dot(normal)),
                );
            }
        }
    }
    None
}

/// Where the light comes from that a surface shows most of.
enum Way {
    Reflect,
    Refract(f64),
}

impl Way {
    /// None: from the surface itself.
    fn of(material: &Material) -> Option<Self> {
        let own = material.color.max_element() * material.diffuse + material.emission;
        let reflected = match material.reflection {
            Reflection::None => 0.0,
            Reflection::Constant(weight) => weight.max_element(),
            // Straight on it is little, and little else is seen of what has it.
            Reflection::Fresnel => 0.05,
        };
        let through = material.transmission().max_element();
        if through >= own && through >= reflected && through > 0.0 {
            Some(Self::Refract(material.ior))
        } else if reflected >= own && reflected > 0.0 {
            Some(Self::Reflect)
        } else {
            None
        }
    }
}

/// Snell's law; none: all is reflected inside.
fn refract(dir: DVec3, normal: DVec3, eta: f64) -> Option<DVec3> {
    let cos = -dir.dot(normal);
    let root = 1.0 - eta * eta * (1.0 - cos * cos);
    (root >= 0.0).then(|| (dir * eta + normal * (eta * cos - root.sqrt())).normalize())
}

/// What a click on an entity means: the thing of the scene that a part of a model file belongs to, or the part where the
/// thing is selected already.
pub fn thing_of(world: &World, part: Entity, selected: Option<Entity>) -> Entity {
    let mut thing = part;
    while world.get::<SceneId>(thing).is_none() && world.get::<Imported>(thing).is_some() {
        match world.get::<ChildOf>(thing) {
            Some(parent) => thing = parent.parent(),
            None => return part,
        }
    }
    if selected == Some(thing) { part } else { thing }
}

/// Lights and cameras: things without a surface, which have marks in the picture.
type Marked = Or<(
    With<Camera>,
    With<PointLight>,
    With<SpotLight>,
    With<DirectionalLight>,
)>;

/// Where the marks of lights and cameras are, with how far they are.
pub fn marks(world: &mut World, sight: &Sight) -> Vec<(Entity, Pos2, f64)> {
    let mut things = world.query_filtered::<(Entity, &GlobalTransform), Marked>();
    let place = |(entity, pose): (Entity, &GlobalTransform)| {
        let place = pose.0.translation;
        // The camera that looks sees no mark of itself.
        if place.distance_squared(sight.view.origin) < 1e-12 {
            return None;
        }
        let (at, depth) = sight.place(place)?;
        sight.window.contains(at).then_some((entity, at, depth))
    };
    things.iter(world).filter_map(place).collect()
}

/// The nearest mark under the mouse.
pub fn mark_at(world: &mut World, sight: &Sight, at: Pos2) -> Option<Entity> {
    let marks = marks(world, sight).into_iter();
    let near = marks.filter(|(_, place, _)| place.distance(at) <= MARK_REACH);
    near.min_by(|a, b| a.1.distance(at).total_cmp(&b.1.distance(at)))
        .map(|(entity, ..)| entity)
}

/// The things whose middle is in a part of the window.
pub fn things_in(world: &mut World, sight: &Sight, area: Rect) -> Vec<Entity> {
    let mut found: Vec<Entity> = Vec::new();
    world.resource_scope(|world, mut boxes: Mut<Boxes>| {
        let scene = world.resource::<FrameScene>();
        for instance in scene.instances.iter() {
            let Some([min, max]) = local_box(scene, &mut boxes, instance) else {
                continue;
            };
            let middle = instance
                .world_from_local
                .transform_point3((min + max) * 0.5);
            let is_in = sight.place(middle).is_some_and(|(at, _)| area.contains(at));
            if let Some(entity) = Entity::try_from_bits(instance.tag).filter(|_| is_in) {
                found.push(thing_of(world, entity, None));
            }
        }
    });
    let marks = marks(world, sight).into_iter();
    found.extend(marks.filter(|(_, at, _)| area.contains(*at)).map(|m| m.0));
    let mut seen = bevy_ecs::entity::EntityHashSet::default();
    found.retain(|&entity| seen.insert(entity));
    found
}

#[cfg(test)]
mod tests;
