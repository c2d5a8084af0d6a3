//! Shapes to instance rows.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use glam::{DAffine3, DVec3};

use super::Rows;
use crate::frame::{FrameScene, Instance, Shape};
use crate::world::{
    Cuboid, FARTHEST, GlobalTransform, GlobalVisibility, Mesh, OwnMesh, Plane, Sphere, Surface,
    any_changed,
};

pub(super) type ShapeParts<'a> = (
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

pub(super) type AnyShape = Or<(
    With<Mesh>,
    With<OwnMesh>,
    With<Sphere>,
    With<Plane>,
    With<Cuboid>,
)>;

pub(super) type ShapeChanged = Or<(
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
pub(super) fn vacate_removed(
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
pub(super) fn relink_materials(
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

/// What tells that some shape changed.
#[derive(SystemParam)]
pub(super) struct ShapeWatch<'w, 's> {
    transforms: Query<'w, 's, Ref<'static, GlobalTransform>, AnyShape>,
    visibilities: Query<'w, 's, Ref<'static, GlobalVisibility>, AnyShape>,
    surfaces: Query<'w, 's, Ref<'static, Surface>>,
    meshes: Query<'w, 's, Ref<'static, Mesh>>,
    own: Query<'w, 's, Ref<'static, OwnMesh>>,
    spheres: Query<'w, 's, Ref<'static, Sphere>>,
    planes: Query<'w, 's, Ref<'static, Plane>>,
    cuboids: Query<'w, 's, Ref<'static, Cuboid>>,
}

impl ShapeWatch<'_, '_> {
    fn any_changed(&self) -> bool {
        any_changed(&self.transforms)
            || any_changed(&self.visibilities)
            || any_changed(&self.surfaces)
            || any_changed(&self.meshes)
            || any_changed(&self.own)
            || any_changed(&self.spheres)
            || any_changed(&self.planes)
            || any_changed(&self.cuboids)
    }
}

pub(super) fn extract_instances(
    mut scene: ResMut<FrameScene>,
    mut rows: ResMut<Rows>,
    watch: ShapeWatch,
    changed: Query<ShapeParts, (AnyShape, ShapeChanged)>,
) {
    if !watch.any_changed() {
        return;
    }
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
