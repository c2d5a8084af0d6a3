//! Shapes to instance rows.

use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_ecs::system::SystemParam;
use glam::{DAffine3, DVec2, DVec3};

use super::{Rows, is_news};
use crate::frame::{FrameScene, Instance, Shape};
use crate::world::{
    Cone, Cuboid, Cylinder, Disc, FARTHEST, GlobalTransform, GlobalVisibility, Mesh, OwnMesh,
    Plane, Sphere, Surface, Torus, any_changed,
};

/// An entity with a shape.
#[derive(QueryData)]
pub(super) struct ShapeParts {
    entity: Entity,
    transform: &'static GlobalTransform,
    visible: &'static GlobalVisibility,
    surface: Option<&'static Surface>,
    solid: SolidParts,
    mesh: Option<&'static Mesh>,
    own_mesh: Option<&'static OwnMesh>,
}

/// The shapes that are a component and nothing else.
#[derive(QueryData)]
pub(super) struct SolidParts {
    sphere: Option<&'static Sphere>,
    plane: Option<&'static Plane>,
    cuboid: Option<&'static Cuboid>,
    disc: Option<&'static Disc>,
    cylinder: Option<&'static Cylinder>,
    cone: Option<&'static Cone>,
    torus: Option<&'static Torus>,
}

pub(super) type AnyShape = Or<(
    With<Mesh>,
    With<OwnMesh>,
    With<Sphere>,
    With<Plane>,
    With<Cuboid>,
    With<Disc>,
    With<Cylinder>,
    With<Cone>,
    With<Torus>,
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
    Changed<Disc>,
    Changed<Cylinder>,
    Changed<Cone>,
    Changed<Torus>,
)>;

/// What was taken off entities.
#[derive(SystemParam)]
pub(super) struct RemovedParts<'w, 's> {
    surfaces: RemovedComponents<'w, 's, Surface>,
    meshes: RemovedComponents<'w, 's, Mesh>,
    own: RemovedComponents<'w, 's, OwnMesh>,
    spheres: RemovedComponents<'w, 's, Sphere>,
    planes: RemovedComponents<'w, 's, Plane>,
    cuboids: RemovedComponents<'w, 's, Cuboid>,
    discs: RemovedComponents<'w, 's, Disc>,
    cylinders: RemovedComponents<'w, 's, Cylinder>,
    cones: RemovedComponents<'w, 's, Cone>,
    tori: RemovedComponents<'w, 's, Torus>,
}

impl RemovedParts<'_, '_> {
    fn read(&mut self) -> Vec<Entity> {
        let found = self.meshes.read().chain(self.own.read());
        let found = found.chain(self.spheres.read()).chain(self.planes.read());
        let found = found.chain(self.cuboids.read()).chain(self.discs.read());
        let found = found.chain(self.cylinders.read()).chain(self.cones.read());
        let found = found.chain(self.tori.read()).chain(self.surfaces.read());
        found.collect()
    }
}

/// Frees the rows of entities that are gone or have no shape any more.
pub(super) fn vacate_removed(
    mut scene: ResMut<FrameScene>,
    mut rows: ResMut<Rows>,
    mut removed: RemovedParts,
    shapes: Query<ShapeParts, AnyShape>,
) {
    for entity in removed.read() {
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
            .surface
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
    discs: Query<'w, 's, Ref<'static, Disc>>,
    cylinders: Query<'w, 's, Ref<'static, Cylinder>>,
    cones: Query<'w, 's, Ref<'static, Cone>>,
    tori: Query<'w, 's, Ref<'static, Torus>>,
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
            || any_changed(&self.discs)
            || any_changed(&self.cylinders)
            || any_changed(&self.cones)
            || any_changed(&self.tori)
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

fn write_instance(scene: &mut FrameScene, rows: &mut Rows, parts: ShapePartsItem) {
    let entity = parts.entity;
    let mesh = parts.own_mesh.map(|own| own.0);
    let mesh = mesh.or(parts.mesh.map(|mesh| mesh.0));
    let shape = match mesh {
        Some(mesh) => Shape::Mesh(mesh.0),
        None => parts.solid.shape(),
    };
    let world_from_local = parts.transform.0;
    let drawable = is_drawable(world_from_local, shape, scene.meshes.len());
    if is_news(&mut rows.singular, entity, !drawable) {
        tracing::warn!(
            "{entity} is left out of the picture: its transform or size is too small, too large, singular or not finite"
        );
    }
    let row = Instance {
        tag: entity.to_bits(),
        shape: if drawable && parts.visible.0 {
            shape
        } else {
            Shape::Vacant
        },
        world_from_local,
        material: parts
            .surface
            .and_then(|surface| rows.materials.get(&surface.0).copied())
            .unwrap_or(0),
    };
    rows.instance_row(scene, entity, row);
}

impl SolidPartsItem<'_, '_> {
    /// The first one there is.
    fn shape(&self) -> Shape {
        if let Some(&Sphere { radius }) = self.sphere {
            Shape::Sphere { radius }
        } else if let Some(&Plane { normal, distance }) = self.plane {
            Shape::Plane { normal, distance }
        } else if let Some(&Cuboid { min, max }) = self.cuboid {
            Shape::Cuboid { min, max }
        } else if let Some(disc) = self.disc {
            Shape::Disc {
                center: disc.center,
                normal: disc.normal,
                radius: disc.radius,
            }
        } else if let Some(cylinder) = self.cylinder {
            Shape::Cone(Cone::from(*cylinder))
        } else if let Some(&cone) = self.cone {
            Shape::Cone(cone)
        } else if let Some(&Torus { major, minor }) = self.torus {
            Shape::Torus { major, minor }
        } else {
            Shape::Vacant
        }
    }
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
        Shape::Disc {
            center,
            normal,
            radius,
        } => radius > 0.0 && normal.length().is_normal() && reaches(center.abs() + radius),
        Shape::Cone(Cone {
            a,
            radius_a,
            b,
            radius_b,
            ..
        }) => {
            let radii = DVec2::new(radius_a, radius_b);
            // Longer or wider by more than this, the map to its own space is singular in f32.
            let slenderness = (b - a).length() / radii.max_element();
            let is_solid = radii.cmpge(DVec2::ZERO).all() && (1e-7..1e7).contains(&slenderness);
            is_solid && reaches(a.abs() + radius_a) && reaches(b.abs() + radius_b)
        }
        Shape::Torus { major, minor } => {
            minor > 0.0 && minor < major && reaches(DVec3::splat(major + minor))
        }
    };
    let is_regular = volume.abs() > 1e-12 * bound && bound > 0.0;
    let is_placed = within(world_from_local.translation);
    extent && is_placed && is_regular && shape.is_in_range(&world_from_local)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every bounded shape, of this size along Y and of size 1 elsewhere.
    fn shapes(y: f64) -> [Shape; 3] {
        let half = DVec3::new(0.5, 0.5 * y, 0.5);
        [
            Shape::Cuboid {
                min: -half,
                max: half,
            },
            Shape::Sphere { radius: y },
            Shape::Torus {
                major: y,
                minor: 0.3 * y,
            },
        ]
    }

    #[test]
    fn what_f32_cannot_invert_is_left_out_by_size_and_by_scale() {
        for (size, expected) in [
            (1e-300, false),
            (1e-42, false),
            (1e-38, false),
            (1e-20, false),
            (1e-12, true),
            (1.0, true),
            (1e12, true),
            (1e20, false),
        ] {
            for shape in shapes(size) {
                let drawn = is_drawable(DAffine3::IDENTITY, shape, 0);
                assert_eq!(drawn, expected, "{shape:?}");
            }
            for shape in shapes(1.0) {
                let map = DAffine3::from_scale(DVec3::new(1.0, size, 1.0));
                assert_eq!(is_drawable(map, shape, 0), expected, "{size:e} {shape:?}");
            }
        }
    }
}
