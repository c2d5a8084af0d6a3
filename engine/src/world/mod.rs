//! Components, and the systems that keep the derived ones true.
//!
//! People, timelines and editors write the plain components here; [`GlobalTransform`],
//! [`GlobalVisibility`] and [`OwnMesh`] are derived and have one writer each. Things in motion ([`Orbit`] and its
//! like) have their [`Transform`] written for them.

mod camera;
mod changes;
mod clip;
mod cycle;
mod deform;
mod display;
mod framing;
mod hermite;
mod identity;
mod light;
mod material;
mod mesh;
mod motion;
mod own_mesh;
mod polygon;
mod propagate;
mod shape;
mod structure;
mod table;
mod texture;
mod transform;
mod visibility;

pub use camera::{ActiveCamera, Camera, Projection, ToneMap, picture_camera};
pub use changes::{any_changed, write_rows};
pub use clip::{
    Channel, Clip, ClipLayer, ClipPlace, ClipPlayer, ClipSet, Interpolation, Track, play_clips,
};
pub use cycle::{Loop, turn};
pub use deform::{
    DeformStep, Deformation, KeyFrames, Morph, Skin, SkinBinding, Twist, VertexSets, Wave,
    deformed_vertices,
};
pub use display::linear_from_srgb;
pub use framing::{Framing, corners};
pub use hermite::{Blend, hermite};
pub use identity::{Background, SceneId, TraceDepth};
pub use light::{DirectionalLight, Fade, PointLight, SpotLight};
pub use material::{Lobe, Material, Reflection};
pub use mesh::{FARTHEST, MeshData, MeshId, MeshRow, Meshes};
pub use motion::{Orbit, PathMotion, Rest, Spin, Sway, move_things};
pub use own_mesh::derive_own_meshes;
pub use polygon::{FaceCut, newell_normal, triangulate, triangulate_face};
pub use propagate::{Inherited, mark_reparented, propagate, propagate_alone};
pub use shape::{
    Cone, Cuboid, Cylinder, Disc, Mesh, OwnMesh, Plane, Polygon, Sphere, Surface, Torus,
};
pub use structure::Structure;
pub use table::{Changes, Table};
pub use texture::{ColorSpace, Level, Texture, TextureId, Textures, Wrap, linear_light};
pub use transform::{GlobalTransform, Shear, Transform, world_from_local};
pub use visibility::{GlobalVisibility, Visibility};

use bevy_ecs::prelude::*;
use bevy_ecs::reflect::AppTypeRegistry;

use crate::app::Engine;
use crate::schedule::FrameSet;

/// Adds the world's resources, its reflected types and its systems (sets [`FrameSet::Animate`] and
/// [`FrameSet::Propagate`]).
pub fn plugin(engine: &mut Engine) {
    let world = &mut engine.world;
    world.init_resource::<Meshes>();
    world.init_resource::<Textures>();
    world.init_resource::<ActiveCamera>();
    world.init_resource::<Background>();
    world.init_resource::<TraceDepth>();
    register_types(&world.get_resource_or_init::<AppTypeRegistry>());
    engine.world.add_observer(mark_reparented);
    engine.add_systems(FrameSet::Animate, (move_things, play_clips).chain());
    engine.add_systems(
        FrameSet::Propagate,
        (
            propagate_alone::<GlobalTransform>,
            propagate::<GlobalTransform>,
            propagate_alone::<GlobalVisibility>,
            propagate::<GlobalVisibility>,
            derive_own_meshes,
        )
            .chain(),
    );
}

/// Tells reflection about every component an inspector may edit.
fn register_types(registry: &AppTypeRegistry) {
    let mut registry = registry.write();
    registry.register::<Name>();
    registry.register::<ChildOf>();
    registry.register::<SceneId>();
    registry.register::<Transform>();
    registry.register::<Shear>();
    registry.register::<GlobalTransform>();
    registry.register::<Visibility>();
    registry.register::<GlobalVisibility>();
    registry.register::<Camera>();
    registry.register::<PointLight>();
    registry.register::<DirectionalLight>();
    registry.register::<SpotLight>();
    registry.register::<Material>();
    registry.register::<Surface>();
    registry.register::<Mesh>();
    registry.register::<Sphere>();
    registry.register::<Plane>();
    registry.register::<Cuboid>();
    registry.register::<Disc>();
    registry.register::<Cylinder>();
    registry.register::<Cone>();
    registry.register::<Torus>();
    registry.register::<Polygon>();
    registry.register::<OwnMesh>();
    registry.register::<Structure>();
    registry.register::<Rest>();
    registry.register::<Orbit>();
    registry.register::<Spin>();
    registry.register::<Sway>();
    registry.register::<PathMotion>();
    registry.register::<KeyFrames>();
    registry.register::<ClipPlayer>();
    registry.register::<Morph>();
    registry.register::<Skin>();
    registry.register::<Wave>();
    registry.register::<Twist>();
}
