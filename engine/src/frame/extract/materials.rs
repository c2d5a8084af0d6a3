//! Materials to rows: with numbers that a picture can be made of.
//!
//! Tracers multiply and add without looking, and a device may take an overflow for anything at all. So what people and
//! programs write is brought within limits here: what is no number is as in the default material, and a
//! surface passes on no more light than it gets.

use bevy_ecs::prelude::*;
use glam::Vec3;

use super::{Rows, is_news};
use crate::frame::FrameScene;
use crate::world::{Lobe, Material, Reflection, any_changed};

/// Brightest colour, emission, highlight or light: products of three of them are within f32.
pub(super) const BRIGHTEST: f32 = 1e9;
/// More than all light: what rounding may make of shares that add up to 1.
const ALL: f32 = 1.01;
/// Largest exponent of a highlight.
const TIGHTEST: f32 = 1e6;
/// Indices of refraction.
const INDICES: std::ops::RangeInclusive<f64> = 0.01..=100.0;

pub(super) fn extract_materials(
    mut scene: ResMut<FrameScene>,
    mut rows: ResMut<Rows>,
    mut removed: RemovedComponents<Material>,
    watch: Query<Ref<Material>>,
    changed: Query<(Entity, &Material), Changed<Material>>,
) {
    rows.relinked.clear();
    rows.restructured = false;
    if scene.materials.is_empty() {
        scene.materials.push(Material::default());
    }
    for entity in removed.read().filter(|&entity| !watch.contains(entity)) {
        rows.vacate_material(&mut scene, entity);
    }
    if !any_changed(&watch) {
        return;
    }
    for (entity, material) in &changed {
        let usable = usable(material);
        if is_news(&mut rows.unusable, entity, usable != *material) {
            tracing::warn!(
                "{entity}: its material has numbers that no picture can be made of; it is shown as {usable:?}"
            );
        }
        let row = rows.material_row(&mut scene, entity);
        rows.restructured |= scene.materials.set(row, usable);
    }
}

/// The nearest material that can be traced; the same one if it can.
fn usable(material: &Material) -> Material {
    let plain = Material::default();
    let bright = |x: f32, other: f32| within(x, other, 0.0, BRIGHTEST);
    let color = |c: Vec3, other: Vec3| {
        let [r, g, b] = c.to_array();
        Vec3::new(bright(r, other.x), bright(g, other.y), bright(b, other.z))
    };
    let lobe = |lobe: Lobe| Lobe {
        strength: bright(lobe.strength, 0.0),
        exponent: within(lobe.exponent, 1.0, 0.0, TIGHTEST),
    };
    let shade = color(material.color, plain.color);
    let transmit = within(material.transmit, 0.0, 0.0, 1.0);
    let filter = within(material.filter, 0.0, 0.0, 1.0);
    let passes = shade.max_element() * filter + transmit;
    Material {
        color: shade,
        diffuse: bright(material.diffuse, plain.diffuse),
        emission: bright(material.emission, 0.0),
        phong: material.phong.map(lobe),
        specular: material.specular.map(lobe),
        reflection: match material.reflection {
            Reflection::Constant(weight) => {
                let share = |x: f32| within(x, 0.0, 0.0, 1.0);
                Reflection::Constant(Vec3::from(weight.to_array().map(share)))
            }
            other => other,
        },
        transmit,
        filter: if passes > ALL {
            (1.0 - transmit) / shade.max_element()
        } else {
            filter
        },
        ior: if material.ior.is_finite() && material.ior > 0.0 {
            material.ior.clamp(*INDICES.start(), *INDICES.end())
        } else {
            plain.ior
        },
        absorption: color(material.absorption, Vec3::ZERO),
        color_map: material.color_map,
        normal_map: material.normal_map,
        alpha_cutoff: material
            .alpha_cutoff
            .map(|least| within(least, 0.0, 0.0, 2.0)),
    }
}

/// `x` brought within limits; `other` if it is none.
pub(super) fn within(x: f32, other: f32, least: f32, most: f32) -> f32 {
    if x.is_nan() {
        other
    } else {
        x.clamp(least, most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn good_materials_stay_as_they_are() {
        let glass = Material {
            color: Vec3::new(0.3, 1.0, 0.5),
            filter: 0.7,
            transmit: 0.3,
            reflection: Reflection::Constant(Vec3::ONE),
            phong: Some(Lobe::default()),
            ior: 1.5,
            emission: 40.0,
            ..Material::default()
        };
        for material in [Material::default(), glass] {
            assert_eq!(usable(&material), material);
        }
    }

    #[test]
    fn bad_numbers_become_finite_and_pass_on_no_more_than_all() {
        let bad = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            1e38,
            -1e38,
            -1.0,
        ];
        for x in bad {
            let lobe = Some(Lobe {
                strength: x,
                exponent: x,
            });
            let material = usable(&Material {
                color: Vec3::splat(x),
                diffuse: x,
                emission: x,
                phong: lobe,
                specular: lobe,
                reflection: Reflection::Constant(Vec3::splat(x)),
                transmit: x,
                filter: x,
                ior: x.into(),
                alpha_cutoff: Some(x),
                absorption: Vec3::splat(x),
                ..Material::default()
            });
            assert_eq!(usable(&material), material, "{x}");
            let through = material.transmission();
            assert!(through.is_finite() && through.max_element() <= ALL, "{x}");
            assert!(material.ior > 0.0 && material.color.is_finite(), "{x}");
        }
        let doubling = usable(&Material {
            color: Vec3::splat(2.0),
            filter: 1.0,
            ..Material::default()
        });
        assert_eq!(doubling.transmission(), Vec3::ONE);
    }
}
