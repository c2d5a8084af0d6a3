//! Lights to rows.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use glam::{DVec3, Vec3};

use super::materials::BRIGHTEST;
use crate::frame::{FrameScene, Light, LightKind};
use crate::world::{
    DirectionalLight, FARTHEST, Fade, GlobalTransform, GlobalVisibility, PointLight, SpotLight,
    any_changed,
};

pub(super) type AnyLight = Or<(With<PointLight>, With<DirectionalLight>, With<SpotLight>)>;

/// What tells that some light changed, came or went.
#[derive(SystemParam)]
pub(super) struct LightWatch<'w, 's> {
    transforms: Query<'w, 's, Ref<'static, GlobalTransform>, AnyLight>,
    visibilities: Query<'w, 's, Ref<'static, GlobalVisibility>, AnyLight>,
    points: Query<'w, 's, Ref<'static, PointLight>>,
    suns: Query<'w, 's, Ref<'static, DirectionalLight>>,
    spots: Query<'w, 's, Ref<'static, SpotLight>>,
    without_points: RemovedComponents<'w, 's, PointLight>,
    without_suns: RemovedComponents<'w, 's, DirectionalLight>,
    without_spots: RemovedComponents<'w, 's, SpotLight>,
}

impl LightWatch<'_, '_> {
    fn any_changed(&mut self) -> bool {
        let gone = self.without_points.read().count()
            + self.without_suns.read().count()
            + self.without_spots.read().count();
        gone > 0
            || any_changed(&self.transforms)
            || any_changed(&self.visibilities)
            || any_changed(&self.points)
            || any_changed(&self.suns)
            || any_changed(&self.spots)
    }
}

pub(super) fn extract_lights(
    mut scene: ResMut<FrameScene>,
    mut watch: LightWatch,
    points: Query<(&PointLight, &GlobalTransform, &GlobalVisibility)>,
    suns: Query<(&DirectionalLight, &GlobalTransform, &GlobalVisibility)>,
    spots: Query<(&SpotLight, &GlobalTransform, &GlobalVisibility)>,
) {
    if !watch.any_changed() {
        return;
    }
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
        .assign(points.chain(suns).chain(spots).filter(shines));
}

/// Whether a light adds anything to a picture that is a number.
fn shines(light: &Light) -> bool {
    let within = |p: DVec3| p.is_finite() && p.abs().max_element() <= FARTHEST;
    let is_placed = match light.kind {
        LightKind::Directional { to_light } => to_light.is_finite(),
        LightKind::Point { position } => within(position),
        LightKind::Spot {
            position,
            axis,
            cos_inner,
            cos_outer,
        } => within(position) && axis.is_finite() && (cos_inner + cos_outer).is_finite(),
    };
    let fades = |fade: Fade| {
        let has_range = fade.range.is_none_or(|range| range > 0.0);
        fade.distance.is_finite() && fade.power.is_finite() && has_range
    };
    is_placed
        && light.fade.is_none_or(fades)
        && light.color.abs().cmple(Vec3::splat(BRIGHTEST)).all()
        && light.color != Vec3::ZERO
}
