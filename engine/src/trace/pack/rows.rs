//! View, materials and lights as rows.

use glam::{DVec3, Vec3};

use super::Texels;
use crate::frame::wire::{
    LIGHT_DIRECTIONAL, LIGHT_POINT, LIGHT_SPOT, LightRow, MATERIAL_FRESNEL, MATERIAL_MIRROR,
    MATERIAL_TRANSMITS, MaterialRow, PROJECTION_ORTHOGRAPHIC, PROJECTION_PERSPECTIVE,
    SAMPLES_CAPACITY, ViewRow,
};
use crate::frame::{Light, LightKind, TraceSettings, View, ViewProjection};
use crate::world::{Material, Reflection};

/// The uniform, but for what the other rows decide.
pub(super) fn view_row(view: &View, settings: &TraceSettings) -> ViewRow {
    // Divided here in f64: a device's division may be 2.5 ulp off, which moves edges by a pixel now and then.
    let half_pixels = settings.size.as_dvec2() * 2.0;
    ViewRow {
        forward: view.forward.as_vec3().to_array(),
        width: settings.size.x,
        right_step: (view.right / half_pixels.x).as_vec3().to_array(),
        height: settings.size.y,
        up_step: (view.up / half_pixels.y).as_vec3().to_array(),
        samples: settings.samples.clamp(1, SAMPLES_CAPACITY),
        edge_contrast: match settings.adaptive {
            Some(contrast) if settings.samples > 1 => contrast.max(f32::MIN_POSITIVE),
            _ => 0.0,
        },
        projection: match view.projection {
            ViewProjection::Perspective => PROJECTION_PERSPECTIVE,
            ViewProjection::Orthographic => PROJECTION_ORTHOGRAPHIC,
        },
        ..Default::default()
    }
}

/// A material's row; its textures are among these.
pub(super) fn material_row(material: &Material, texels: &Texels) -> MaterialRow {
    let mut flags = 0;
    let mut reflection = Vec3::ZERO;
    match material.reflection {
        Reflection::None => {}
        Reflection::Constant(weight) => {
            reflection = weight;
            if weight.max_element() > 0.0 {
                flags |= MATERIAL_MIRROR;
            }
        }
        Reflection::Fresnel => flags |= MATERIAL_FRESNEL,
    }
    if material.transmission().max_element() > 0.0 {
        flags |= MATERIAL_TRANSMITS;
    }
    MaterialRow {
        color: material.color.to_array(),
        diffuse: material.diffuse,
        reflection: reflection.to_array(),
        emission: material.emission,
        phong_strength: material.phong.map_or(0.0, |lobe| lobe.strength),
        phong_exponent: material.phong.map_or(1.0, |lobe| lobe.exponent),
        specular_strength: material.specular.map_or(0.0, |lobe| lobe.strength),
        specular_exponent: material.specular.map_or(1.0, |lobe| lobe.exponent),
        transmit: material.transmit,
        filtered: material.filter,
        ior: material.ior as f32,
        flags,
        color_map: texels.first(material.color_map),
        normal_map: texels.first(material.normal_map),
        absorption: material.absorption.to_array(),
        alpha_cutoff: material.alpha_cutoff.unwrap_or(0.0),
        spare: [0; 2],
    }
}

/// One over the nearest end of light: its product with any distance fits f32.
const NEAREST_END: f64 = 1e18;

/// A light's row, relative to the eye.
pub(super) fn light_row(light: &Light, eye: DVec3) -> LightRow {
    let range = light.fade.and_then(|fade| fade.range);
    let mut row = LightRow {
        color: light.color.to_array(),
        fade_distance: light.fade.map_or(0.0, |fade| fade.distance as f32),
        fade_power: light.fade.map_or(0.0, |fade| fade.power as f32),
        fade_core: light
            .fade
            .map_or(0.0, |fade| f32::from(u8::from(!fade.exact))),
        range_inverse: range.map_or(0.0, |range| range.recip().min(NEAREST_END) as f32),
        ..Default::default()
    };
    match light.kind {
        LightKind::Point { position } => {
            row.kind = LIGHT_POINT;
            row.position = (position - eye).as_vec3().to_array();
        }
        LightKind::Directional { to_light } => {
            row.kind = LIGHT_DIRECTIONAL;
            row.position = to_light.as_vec3().to_array();
        }
        LightKind::Spot {
            position,
            axis,
            cos_inner,
            cos_outer,
        } => {
            row.kind = LIGHT_SPOT;
            row.position = (position - eye).as_vec3().to_array();
            row.axis = axis.as_vec3().to_array();
            row.cos_inner = cos_inner as f32;
            row.cos_outer = cos_outer as f32;
        }
    }
    row
}
