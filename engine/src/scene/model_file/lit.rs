//! Whether a model brings light enough to be seen by, where its nodes are at rest.

use glam::{DAffine3, DVec3, Vec3};

use crate::import::{Content, Model, Solid};
use crate::world::{Cone, Fade, Framing, Material, corners, world_from_local};

/// Light that is no light: what a white surface gives back of it is a hundredth of a display's white.
const DIM: f64 = 0.01;

/// Whether so little light reaches the model that what does not glow would be black. A model all of whose surfaces
/// answer no light is not dark, whatever there is. What is dark joins what is framed.
pub fn is_dark(model: &Model, framing: &mut Framing) -> bool {
    let default = Material::default();
    let worn = |content: &Content| {
        let row = content.material().and_then(|row| model.materials.get(row));
        let material = row.map_or(&default, |(_, material)| material);
        content.is_visible() && answers(material)
    };
    if !model.contents().any(worn) {
        return false;
    }
    let places = places(model);
    let Some((min, max)) = bounds(model, &places) else {
        return false;
    };
    let mut light = 0.0;
    for (node, place) in model.nodes.iter().zip(&places) {
        if !node.hidden {
            let arrives = |content| arriving(content, place.translation, min, max);
            light += node.contents.iter().map(arrives).sum::<f64>();
        }
    }
    if light < DIM {
        framing.add_box(DAffine3::IDENTITY, min, max);
    }
    light < DIM
}

/// Whether a surface shows what light falls on it.
fn answers(material: &Material) -> bool {
    material.diffuse > 0.0 || material.phong.is_some() || material.specular.is_some()
}

/// The world from each node.
fn places(model: &Model) -> Vec<DAffine3> {
    let mut places: Vec<DAffine3> = Vec::with_capacity(model.nodes.len());
    for node in &model.nodes {
        let above = node.parent.map_or(DAffine3::IDENTITY, |row| places[row]);
        places.push(above * world_from_local([(&node.pose, node.shear.as_ref())]));
    }
    places
}

/// The least and the greatest corner of all that can be seen.
fn bounds(model: &Model, places: &[DAffine3]) -> Option<(DVec3, DVec3)> {
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut add = |point: DVec3| (min, max) = (min.min(point), max.max(point));
    for (node, place) in model.nodes.iter().zip(places) {
        for content in &node.contents {
            match *content {
                Content::Part { part, .. } => {
                    let vertices = model.parts[part].mesh.vertices.iter();
                    vertices.for_each(|&vertex| add(place.transform_point3(vertex)));
                }
                Content::Solid { solid, .. } => {
                    let (low, high) = bounds_of(solid);
                    for corner in corners(low, high) {
                        add(place.transform_point3(corner));
                    }
                }
                _ => {}
            }
        }
    }
    (min.is_finite() && max.is_finite()).then_some((min, max))
}

fn bounds_of(solid: Solid) -> (DVec3, DVec3) {
    match solid {
        Solid::Sphere(sphere) => (DVec3::splat(-sphere.radius), DVec3::splat(sphere.radius)),
        Solid::Cylinder(cylinder) => Cone::from(cylinder).bounds(),
        Solid::Cone(cone) => cone.bounds(),
    }
}

/// The light of a lamp at `from` where a box is nearest to it.
fn arriving(content: &Content, from: DVec3, min: DVec3, max: DVec3) -> f64 {
    let (color, intensity, fade) = match content {
        Content::Directional(light) => (light.color, light.intensity, None),
        Content::Point(light) => (light.color, light.intensity, light.fade),
        Content::Spot(light) => (light.color, light.intensity, light.fade),
        _ => return 0.0,
    };
    let distance = from.distance(from.clamp(min, max));
    let factor = fade.map_or(1.0, |fade: Fade| fade.factor(distance));
    f64::from(Vec3::max_element(color) * intensity) * factor
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;
    use crate::import::{Node, Part};
    use crate::world::{DirectionalLight, MeshData, PointLight, Sphere, Transform};

    fn dark(model: &Model) -> bool {
        is_dark(model, &mut Framing::new())
    }

    fn triangle(light: Option<(Content, f64)>) -> Model {
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        let mesh = MeshData::new("t", vertices, Vec::new(), vec![[0, 1, 2]]).unwrap();
        let mut model = Model {
            parts: vec![Part {
                mesh,
                ..Part::default()
            }],
            ..Model::default()
        };
        model.add_node(Node {
            contents: vec![Content::Part {
                part: 0,
                material: None,
                skin: None,
            }],
            ..Node::default()
        });
        if let Some((content, distance)) = light {
            model.add_node(Node {
                pose: Transform {
                    translation: DVec3::NEG_Z * distance,
                    ..Transform::IDENTITY
                },
                contents: vec![content],
                ..Node::default()
            });
        }
        model
    }

    #[test]
    fn light_counts_where_it_arrives() {
        let lamp = Content::Point(PointLight {
            fade: Some(Fade {
                distance: 1.0,
                power: 2.0,
                ..Fade::default()
            }),
            ..PointLight::default()
        });
        assert!(dark(&triangle(None)));
        assert!(!dark(&triangle(Some((lamp.clone(), 2.0)))));
        assert!(dark(&triangle(Some((lamp, 100.0)))));
        let sun = Content::Directional(DirectionalLight::default());
        assert!(!dark(&triangle(Some((sun, 1e6)))));
    }

    #[test]
    fn a_turned_ball_is_as_large_as_one_that_is_not() {
        let ball = Content::Solid {
            solid: Solid::Sphere(Sphere { radius: 1.0 }),
            material: None,
        };
        let mut model = Model::default();
        let turn = DQuat::from_rotation_arc(DVec3::ONE.normalize(), DVec3::X);
        model.add_node(Node {
            pose: Transform {
                rotation: turn,
                ..Transform::IDENTITY
            },
            contents: vec![ball],
            ..Node::default()
        });
        let (min, max) = bounds(&model, &places(&model)).unwrap();
        assert!((max - min).min_element() >= 2.0, "{min} {max}");
    }

    #[test]
    fn what_only_glows_needs_no_light() {
        let mut model = triangle(None);
        let glow = Material {
            diffuse: 0.0,
            emission: 1.0,
            ..Material::default()
        };
        model.materials.push(("glow".into(), glow));
        let Content::Part { material, .. } = &mut model.nodes[0].contents[0] else {
            panic!("a part");
        };
        *material = Some(0);
        assert!(!dark(&model));
    }
}
