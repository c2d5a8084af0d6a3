//! What people call things: entities, components, fields.

use std::any::TypeId;

use bevy_ecs::prelude::*;
use bevy_ecs::reflect::AppTypeRegistry;

use crate::world::{
    Camera, Cone, Cuboid, Cylinder, DirectionalLight, Disc, Material, Mesh, Plane, PointLight,
    Polygon, SceneId, Sphere, SpotLight, Torus,
};

/// What people call an entity: its name, else its id in the scene file, else its kind and number.
pub fn label(world: &World, entity: Entity) -> String {
    let Ok(found) = world.get_entity(entity) else {
        return format!("{entity} (gone)");
    };
    if let Some(name) = found.get::<Name>() {
        name.to_string()
    } else if let Some(id) = found.get::<SceneId>() {
        id.0.clone()
    } else {
        format!("{} {}", kind(found), entity.index())
    }
}

/// What an entity is, in a word.
pub fn kind(entity: EntityRef) -> &'static str {
    let kinds = [
        (entity.contains::<Camera>(), "camera"),
        (entity.contains::<PointLight>(), "point light"),
        (entity.contains::<DirectionalLight>(), "sun"),
        (entity.contains::<SpotLight>(), "spot light"),
        (entity.contains::<Sphere>(), "sphere"),
        (entity.contains::<Plane>(), "plane"),
        (entity.contains::<Cuboid>(), "box"),
        (entity.contains::<Disc>(), "disc"),
        (entity.contains::<Cylinder>(), "cylinder"),
        (entity.contains::<Cone>(), "cone"),
        (entity.contains::<Torus>(), "torus"),
        (entity.contains::<Polygon>(), "polygon"),
        (entity.contains::<Mesh>(), "mesh"),
        (entity.contains::<Material>(), "material"),
    ];
    let found = kinds.iter().find(|(is, _)| *is);
    found.map_or("group", |(_, kind)| kind)
}

/// What a component is called: its type's name as words, the scene file's word where that differs.
pub fn kind_of_part(world: &World, component: TypeId) -> String {
    let registry = world.resource::<AppTypeRegistry>().read();
    let name = registry
        .get_type_info(component)
        .and_then(|info| info.type_path_table().ident());
    name.map_or_else(|| "Component".into(), words)
}

/// `PointLight` is read as "Point light", and what the scene file calls otherwise as there.
pub fn words(name: &str) -> String {
    match name {
        "Cuboid" => return "Box".into(),
        "DirectionalLight" => return "Sun".into(),
        "Surface" => return "Material link".into(),
        "SceneId" => return "Id".into(),
        "ChildOf" => return "Parent".into(),
        "MeshSource" => return "Model file".into(),
        _ => {}
    }
    let mut words = String::new();
    for (i, letter) in name.chars().enumerate() {
        if i > 0 && letter.is_uppercase() {
            words.push(' ');
            words.extend(letter.to_lowercase());
        } else {
            words.push(letter);
        }
    }
    words
}

/// `vertical_fov` is read as "vertical fov".
pub fn spaced(name: &str) -> String {
    name.replace('_', " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_are_called_by_their_words() {
        assert_eq!(words("PointLight"), "Point light");
        assert_eq!(words("Cuboid"), "Box");
        assert_eq!(spaced("outer_angle"), "outer angle");
    }
}
