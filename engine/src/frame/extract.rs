//! World to [`FrameScene`]: changed rows only, removals first, then structure, then values.

use bevy_ecs::entity::{EntityHashMap, EntityHashSet};
use bevy_ecs::prelude::*;
use glam::{DAffine3, DVec3};

use super::overview::overview;
use super::{
    Features, FrameScene, Instance, Light, LightKind, Shape, TraceSettings, View, ViewProjection,
};
use crate::app::Engine;
use crate::schedule::FrameSet;
use crate::world::{
    ActiveCamera, Background, Camera, Cuboid, DirectionalLight, FARTHEST, GlobalTransform,
    GlobalVisibility, Material, Mesh, Meshes, OwnMesh, Plane, PointLight, Projection, Sphere,
    SpotLight, Surface, TraceDepth, picture_camera,
};

/// Adds extraction.
pub fn plugin(engine: &mut Engine) {
    engine.world.init_resource::<Rows>();
    engine.add_systems(
        FrameSet::Extract,
        (
            extract_materials,
            extract_meshes,
            vacate_removed,
            relink_materials,
            extract_instances,
            extract_lights,
            extract_view,
            find_features,
        )
            .chain(),
    );
}

/// Which row an entity has in [`FrameScene::instances`] and [`FrameScene::materials`].
#[derive(Resource, Default)]
struct Rows {
    instances: EntityHashMap<u32>,
    vacant: Vec<u32>,
    materials: EntityHashMap<u32>,
    vacant_materials: Vec<u32>,
    /// Materials that got or lost their row in this frame; shapes that name them are written anew.
    relinked: EntityHashSet,
    /// Entities already reported for a transform that cannot be inverted.
    singular: EntityHashSet,
}

impl Rows {
    /// The row of a material that is there; a vacant one or a new one if it has none yet.
    fn material_row(&mut self, scene: &mut FrameScene, entity: Entity) -> u32 {
        if let Some(&row) = self.materials.get(&entity) {
            return row;
        }
        let row = self
            .vacant_materials
            .pop()
            .unwrap_or_else(|| scene.materials.push(Material::default()));
        self.materials.insert(entity, row);
        self.relinked.insert(entity);
        row
    }

    fn vacate_material(&mut self, scene: &mut FrameScene, entity: Entity) {
        if let Some(row) = self.materials.remove(&entity) {
            scene.materials.set(row, Material::default());
            self.vacant_materials.push(row);
            self.relinked.insert(entity);
        }
    }

    fn instance_row(&mut self, scene: &mut FrameScene, entity: Entity, row: Instance) {
        let index = *self.instances.entry(entity).or_insert_with(|| {
            self.vacant
                .pop()
                .unwrap_or_else(|| scene.instances.push(row))
        });
        scene.instances.set(index, row);
    }

    fn vacate(&mut self, scene: &mut FrameScene, entity: Entity) {
        if let Some(index) = self.instances.remove(&entity) {
            let mut row = scene.instances[index as usize];
            row.shape = Shape::Vacant;
            scene.instances.set(index, row);
            self.vacant.push(index);
        }
    }
}

fn extract_materials(
    mut scene: ResMut<FrameScene>,
    mut rows: ResMut<Rows>,
    mut removed: RemovedComponents<Material>,
    materials: Query<(), With<Material>>,
    changed: Query<(Entity, &Material), Changed<Material>>,
) {
    rows.relinked.clear();
    if scene.materials.is_empty() {
        scene.materials.push(Material::default());
    }
    for entity in removed.read().filter(|&entity| !materials.contains(entity)) {
        rows.vacate_material(&mut scene, entity);
    }
    for (entity, material) in &changed {
        let row = rows.material_row(&mut scene, entity);
        scene.materials.set(row, *material);
    }
}

fn extract_meshes(mut scene: ResMut<FrameScene>, meshes: Res<Meshes>) {
    if meshes.is_changed() {
        scene.meshes.clone_from(meshes.rows());
    }
}

type ShapeParts<'a> = (
    Entity,
    &'a GlobalTransform,
    &'a GlobalVisibility,
    Option<&'a Surface>,
    Option<&'a Mesh>,
    Option<&'a OwnMesh>,
    Option<&'a Sphere>,
    Option<&'a Plane>,
    Option<&'a Cuboid>,
);

type AnyShape = Or<(
    With<Mesh>,
    With<OwnMesh>,
    With<Sphere>,
    With<Plane>,
    With<Cuboid>,
)>;

type ShapeChanged = Or<(
    Changed<GlobalTransform>,
    Changed<GlobalVisibility>,
    Changed<Surface>,
    Changed<Mesh>,
    Changed<OwnMesh>,
    Changed<Sphere>,
    Changed<Plane>,
    Changed<Cuboid>,
)>;

/// Frees the rows of entities that are gone or have no shape any more.
#[allow(clippy::too_many_arguments)] // one reader a kind of shape
fn vacate_removed(
    mut scene: ResMut<FrameScene>,
    mut rows: ResMut<Rows>,
    mut meshes: RemovedComponents<Mesh>,
    mut polygons: RemovedComponents<OwnMesh>,
    mut spheres: RemovedComponents<Sphere>,
    mut planes: RemovedComponents<Plane>,
    mut cuboids: RemovedComponents<Cuboid>,
    mut surfaces: RemovedComponents<Surface>,
    shapes: Query<ShapeParts, AnyShape>,
) {
    let touched: Vec<Entity> = meshes
        .read()
        .chain(polygons.read())
        .chain(spheres.read())
        .chain(planes.read())
        .chain(cuboids.read())
        .chain(surfaces.read())
        .collect();
    for entity in touched {
        match shapes.get(entity) {
            Ok(parts) => write_instance(&mut scene, &mut rows, parts),
            Err(_) => rows.vacate(&mut scene, entity),
        }
    }
}

/// Writes the shapes whose material got or lost its row, which the shapes themselves do not show.
fn relink_materials(
    mut scene: ResMut<FrameScene>,
    mut rows: ResMut<Rows>,
    shapes: Query<ShapeParts, (AnyShape, With<Surface>)>,
) {
    if rows.relinked.is_empty() {
        return;
    }
    for parts in &shapes {
        if parts
            .3
            .is_some_and(|surface| rows.relinked.contains(&surface.0))
        {
            write_instance(&mut scene, &mut rows, parts);
        }
    }
}

fn extract_instances(
    mut scene: ResMut<FrameScene>,
    mut rows: ResMut<Rows>,
    changed: Query<ShapeParts, (AnyShape, ShapeChanged)>,
) {
    for parts in &changed {
        write_instance(&mut scene, &mut rows, parts);
    }
}

fn write_instance(scene: &mut FrameScene, rows: &mut Rows, parts: ShapeParts) {
    let (entity, transform, visible, surface, mesh, own, sphere, plane, cuboid) = parts;
    let shape = if let Some(own) = own {
        Shape::Mesh(own.0.0)
    } else if let Some(mesh) = mesh {
        Shape::Mesh(mesh.0.0)
    } else if let Some(sphere) = sphere {
        Shape::Sphere {
            radius: sphere.radius,
        }
    } else if let Some(plane) = plane {
        Shape::Plane {
            normal: plane.normal,
            distance: plane.distance,
        }
    } else if let Some(cuboid) = cuboid {
        Shape::Cuboid {
            min: cuboid.min,
            max: cuboid.max,
        }
    } else {
        Shape::Vacant
    };
    let drawable = is_drawable(transform.0, shape, scene.meshes.len());
    if drawable {
        rows.singular.remove(&entity);
    } else if rows.singular.insert(entity) {
        tracing::warn!(
            "{entity} is left out of the picture: its transform or size is zero, singular or not finite"
        );
    }
    let row = Instance {
        tag: entity.to_bits(),
        shape: if drawable && visible.0 {
            shape
        } else {
            Shape::Vacant
        },
        world_from_local: transform.0,
        material: surface
            .and_then(|surface| rows.materials.get(&surface.0).copied())
            .unwrap_or(0),
    };
    rows.instance_row(scene, entity, row);
}

/// Whether f32 tracers can invert the transform, and the shape has an extent and a place in their range.
fn is_drawable(world_from_local: DAffine3, shape: Shape, meshes: usize) -> bool {
    let m = world_from_local.matrix3;
    let volume = m.determinant();
    // Hadamard: |det| <= product of column lengths; their ratio is how far from singular the map is.
    let bound = m.x_axis.length() * m.y_axis.length() * m.z_axis.length();
    let within = |p: DVec3| p.is_finite() && p.abs().max_element() <= FARTHEST;
    let reaches = |p: DVec3| within(p) && within(world_from_local.transform_vector3(p.abs()));
    let extent = match shape {
        Shape::Vacant => true,
        Shape::Mesh(mesh) => (mesh as usize) < meshes,
        Shape::Sphere { radius } => radius > 0.0 && reaches(DVec3::splat(radius)),
        Shape::Plane { normal, distance } => {
            let length = normal.length();
            length.is_normal() && within(normal * (distance / (length * length)))
        }
        Shape::Cuboid { min, max } => min.cmplt(max).all() && reaches(min) && reaches(max),
    };
    extent && within(world_from_local.translation) && volume.abs() > 1e-12 * bound && bound > 0.0
}

fn extract_lights(
    mut scene: ResMut<FrameScene>,
    points: Query<(&PointLight, &GlobalTransform, &GlobalVisibility)>,
    suns: Query<(&DirectionalLight, &GlobalTransform, &GlobalVisibility)>,
    spots: Query<(&SpotLight, &GlobalTransform, &GlobalVisibility)>,
) {
    let forward = |t: &GlobalTransform| {
        t.0.transform_vector3(DVec3::NEG_Z)
            .normalize_or(DVec3::NEG_Z)
    };
    let points = points.iter().filter(|(.., v)| v.0).map(|(l, t, _)| Light {
        color: l.color * l.intensity,
        fade: l.fade,
        kind: LightKind::Point {
            position: t.0.translation,
        },
    });
    let suns = suns.iter().filter(|(.., v)| v.0).map(|(l, t, _)| Light {
        color: l.color * l.intensity,
        fade: None,
        kind: LightKind::Directional {
            to_light: -forward(t),
        },
    });
    let spots = spots.iter().filter(|(.., v)| v.0).map(|(l, t, _)| Light {
        color: l.color * l.intensity,
        fade: l.fade,
        kind: LightKind::Spot {
            position: t.0.translation,
            axis: forward(t),
            cos_inner: l.inner_angle.cos(),
            // A cone without a rim still divides by its width.
            cos_outer: l.outer_angle.cos().min(l.inner_angle.cos() - 1e-6),
        },
    });
    scene
        .lights
        .assign(points.chain(suns).chain(spots).filter(|light| {
            let position_is_finite = match light.kind {
                LightKind::Point { position } | LightKind::Spot { position, .. } => {
                    position.is_finite() && position.abs().max_element() <= FARTHEST
                }
                LightKind::Directional { .. } => true,
            };
            position_is_finite && light.color.is_finite() && light.color != glam::Vec3::ZERO
        }));
}

fn extract_view(
    mut scene: ResMut<FrameScene>,
    active: Res<ActiveCamera>,
    background: Res<Background>,
    depth: Res<TraceDepth>,
    settings: Res<TraceSettings>,
    cameras: Query<(Entity, &Camera, &GlobalTransform, &GlobalVisibility)>,
) {
    scene.background = background.0;
    scene.max_generations = settings.max_generations.unwrap_or(depth.0);
    let aspect = f64::from(settings.size.x) / f64::from(settings.size.y);
    let shown = cameras
        .iter()
        .map(|(entity, .., visible)| (entity, visible.0));
    let chosen = picture_camera(*active, shown).and_then(|entity| cameras.get(entity).ok());
    scene.view = match chosen {
        Some((_, camera, transform, _)) => view_of(camera, transform.0, aspect),
        None => overview(&scene, aspect),
    };
}

/// The spanned view of a camera at a pose; scale and shear of the pose do not count.
pub(super) fn view_of(camera: &Camera, world_from_local: DAffine3, aspect: f64) -> View {
    let (_, rotation, origin) = world_from_local.to_scale_rotation_translation();
    let (height, projection) = match camera.projection {
        Projection::Perspective { vertical_fov } => (
            2.0 * (0.5 * vertical_fov).tan(),
            ViewProjection::Perspective,
        ),
        Projection::Orthographic { height } => (height, ViewProjection::Orthographic),
    };
    View {
        origin,
        forward: rotation * DVec3::NEG_Z,
        right: rotation * DVec3::X * (height * aspect),
        up: rotation * DVec3::Y * height,
        projection,
        exposure: camera.exposure,
        tone_map: camera.tone_map,
    }
}

fn find_features(mut scene: ResMut<FrameScene>) {
    let features = Features::of(&scene);
    scene.features = features;
}
