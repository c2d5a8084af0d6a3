//! A drag of a handle: from where it began and where the mouse is, what the things are to become.

use std::any::TypeId;

use bevy_ecs::prelude::*;
use bevy_reflect::PartialReflect;
use egui::Pos2;
use glam::{DAffine3, DQuat, DVec2, DVec3};

use super::handles::{Handle, across};
use super::{Frame, Mode};
use crate::editor::history::{FieldSet, topmost, world_from};
use crate::editor::sight::Sight;
use crate::world::{Rest, Sphere, SpotLight, Transform};

/// Lengths are snapped to multiples of this, in world units.
const LENGTH_STEP: f64 = 0.25;
/// Angles are snapped to multiples of this, radians.
const ANGLE_STEP: f64 = 15.0 * std::f64::consts::PI / 180.0;
/// Factors are snapped to multiples of this.
const FACTOR_STEP: f64 = 0.1;

/// A thing as it was when the drag began.
#[derive(Clone, Copy, Debug)]
struct Start {
    entity: Entity,
    /// It moves by itself: what is changed is where it rests.
    rests: bool,
    pose: Transform,
    world_from_parent: DAffine3,
}

/// A drag in progress.
#[derive(Clone, Debug)]
pub struct Drag {
    /// What is held.
    pub handle: Handle,
    /// The handles as they were.
    pub frame: Frame,
    mode: Mode,
    grabbed: Pos2,
    /// Angle of the mouse about the axis when last seen, and how far it has come since the start.
    turned: (Option<f64>, f64),
    starts: Vec<Start>,
}

impl Drag {
    /// Takes hold of a handle.
    pub fn begin(
        world: &World,
        (handle, frame, mode): (Handle, Frame, Mode),
        selected: &[Entity],
        at: Pos2,
    ) -> Self {
        let start = |entity: Entity| {
            let rest = world.get::<Rest>(entity).map(|rest| rest.0);
            let parent = world.get::<ChildOf>(entity).map(ChildOf::parent);
            Some(Start {
                entity,
                rests: rest.is_some(),
                pose: rest.or_else(|| world.get::<Transform>(entity).copied())?,
                world_from_parent: world_from(world, parent),
            })
        };
        let starts = topmost(world, selected).into_iter().filter_map(start);
        Self {
            handle,
            frame,
            mode,
            grabbed: at,
            turned: (None, 0.0),
            starts: starts.collect(),
        }
    }

    /// What menus call it, without what it is about.
    pub fn verb(&self) -> &'static str {
        match (self.handle, self.mode) {
            (Handle::Radius, _) => "Radius of",
            (Handle::Cone, _) => "Opening of",
            (_, Mode::Move) => "Move",
            (_, Mode::Rotate) => "Rotate",
            (_, Mode::Scale) => "Scale",
        }
    }

    /// How many things it is about.
    pub fn count(&self) -> usize {
        match self.handle {
            Handle::Radius | Handle::Cone => 1,
            _ => self.starts.len(),
        }
    }

    /// The fields as the mouse has them now.
    pub fn fields(&mut self, world: &World, sight: &Sight, at: Pos2, snaps: bool) -> Vec<FieldSet> {
        match (self.handle, self.mode) {
            (Handle::Radius, _) => self.radius(world, sight, at, snaps),
            (Handle::Cone, _) => self.cone(world, sight, at, snaps),
            (_, Mode::Move) => {
                let by = self.shift(sight, at, snaps);
                let starts = self.starts.iter();
                starts.filter_map(|start| start.moved(by)).collect()
            }
            (Handle::Axis(axis), Mode::Rotate) => {
                let turn = self.turn(axis, sight, at, snaps);
                let pivot = self.frame.pivot;
                let starts = self.starts.iter();
                starts.flat_map(|start| start.turned(pivot, turn)).collect()
            }
            (_, Mode::Rotate) => Vec::new(),
            (_, Mode::Scale) => {
                let by = self.factors(sight, at, snaps);
                self.starts.iter().map(|start| start.scaled(by)).collect()
            }
        }
    }

    /// How far along a line through the pivot the mouse has come.
    fn along(&self, axis: DVec3, sight: &Sight, at: Pos2) -> f64 {
        let on_axis = |at: Pos2| {
            let (origin, dir) = sight.ray(at);
            let from = origin - self.frame.pivot;
            // The point of the axis that is nearest to the ray.
            let (b, d, e) = (axis.dot(dir), axis.dot(from), dir.dot(from));
            let spread = 1.0 - b * b;
            (spread > 1e-6).then(|| (d - b * e) / spread)
        };
        match (on_axis(at), on_axis(self.grabbed)) {
            (Some(now), Some(then)) => now - then,
            // Looked at end on: it cannot be told.
            _ => 0.0,
        }
    }

    /// How far in a plane through the pivot the mouse has come.
    fn within(&self, normal: DVec3, sight: &Sight, at: Pos2) -> DVec3 {
        let pivot = self.frame.pivot;
        match (
            meets(sight, at, pivot, normal),
            meets(sight, self.grabbed, pivot, normal),
        ) {
            (Some(now), Some(then)) => now - then,
            _ => DVec3::ZERO,
        }
    }

    fn shift(&self, sight: &Sight, at: Pos2, snaps: bool) -> DVec3 {
        let axes = self.frame.axes;
        let step = |length: f64| snapped(length, LENGTH_STEP, snaps);
        match self.handle {
            Handle::Axis(i) => axes[i] * step(self.along(axes[i], sight, at)),
            Handle::Plane(i) => {
                let by = self.within(axes[i], sight, at);
                let [u, v] = [axes[(i + 1) % 3], axes[(i + 2) % 3]];
                u * step(by.dot(u)) + v * step(by.dot(v))
            }
            _ => {
                let by = self.within(sight.view.forward, sight, at);
                let parts = axes.map(|axis| axis * step(by.dot(axis)));
                if snaps { parts.iter().sum() } else { by }
            }
        }
    }

    fn turn(&mut self, axis: usize, sight: &Sight, at: Pos2, snaps: bool) -> DQuat {
        let axis = self.frame.axes[axis];
        let (u, v) = axis.any_orthonormal_pair();
        let angle_at = |at: Pos2| {
            let place = meets(sight, at, self.frame.pivot, axis)? - self.frame.pivot;
            let flat = DVec2::new(place.dot(u), place.dot(v));
            (flat.length() > 1e-9).then(|| flat.y.atan2(flat.x))
        };
        let last = self.turned.0.or_else(|| angle_at(self.grabbed));
        if let (Some(now), Some(last)) = (angle_at(at), last) {
            let step = (now - last + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU);
            self.turned = (Some(now), self.turned.1 + step - std::f64::consts::PI);
        }
        DQuat::from_axis_angle(axis, snapped(self.turned.1, ANGLE_STEP, snaps))
    }

    fn factors(&self, sight: &Sight, at: Pos2, snaps: bool) -> DVec3 {
        let step = |factor: f64| snapped(factor, FACTOR_STEP, snaps);
        match self.handle {
            Handle::Axis(i) => {
                let along = self.along(self.frame.axes[i], sight, at) / self.frame.reach;
                let mut by = DVec3::ONE;
                by[i] = step(1.0 + along);
                by
            }
            _ => {
                let by = f64::from((at.x - self.grabbed.x) - (at.y - self.grabbed.y));
                DVec3::splat(step((by / super::REACH).exp()))
            }
        }
    }

    fn radius(&self, world: &World, sight: &Sight, at: Pos2, snaps: bool) -> Vec<FieldSet> {
        let entity = self.frame.entity;
        let Some(sphere) = world.get::<Sphere>(entity) else {
            return Vec::new();
        };
        let Some(place) = meets(sight, at, self.frame.pivot, sight.view.forward) else {
            return Vec::new();
        };
        // The scale is what the radius in the world was to that of the component, and stays so.
        let world_radius = Frame::of(world, sight, entity, false).and_then(|frame| frame.radius);
        let scale = world_radius.map_or(1.0, |radius| radius / sphere.radius);
        let radius = snapped(place.distance(self.frame.pivot) / scale, LENGTH_STEP, snaps);
        field::<Sphere>(entity, ".radius", radius.max(1e-3))
            .into_iter()
            .collect()
    }

    fn cone(&self, world: &World, sight: &Sight, at: Pos2, snaps: bool) -> Vec<FieldSet> {
        let entity = self.frame.entity;
        let (Some((axis, _)), Some(light)) = (self.frame.cone, world.get::<SpotLight>(entity))
        else {
            return Vec::new();
        };
        let aside = across(axis, sight);
        let Some(place) = meets(sight, at, self.frame.pivot, axis.cross(aside)) else {
            return Vec::new();
        };
        let from = place - self.frame.pivot;
        let angle = from.dot(aside).abs().atan2(from.dot(axis));
        let angle = snapped(angle, ANGLE_STEP / 3.0, snaps).clamp(0.01, 89_f64.to_radians());
        let outer = field::<SpotLight>(entity, ".outer_angle", angle);
        let inner = field::<SpotLight>(entity, ".inner_angle", light.inner_angle.min(angle));
        outer.into_iter().chain(inner).collect()
    }
}

impl Start {
    fn field(&self, path: &str, value: impl PartialReflect) -> FieldSet {
        let (component, path) = if self.rests {
            (TypeId::of::<Rest>(), format!(".0{path}"))
        } else {
            (TypeId::of::<Transform>(), path.to_owned())
        };
        FieldSet {
            entity: self.entity,
            component,
            path,
            value: Box::new(value),
        }
    }

    fn moved(&self, by: DVec3) -> Option<FieldSet> {
        let by = self.world_from_parent.inverse().transform_vector3(by);
        let place = self.pose.translation + by;
        place.is_finite().then(|| self.field(".translation", place))
    }

    /// Turned about a pivot in the world.
    fn turned(&self, pivot: DVec3, turn: DQuat) -> Vec<FieldSet> {
        let parent = self.world_from_parent;
        let (_, parent_turn, _) = parent.to_scale_rotation_translation();
        let rotation =
            (parent_turn.inverse() * turn * parent_turn * self.pose.rotation).normalize();
        let place = parent.transform_point3(self.pose.translation);
        let place = parent
            .inverse()
            .transform_point3(pivot + turn * (place - pivot));
        if !(place.is_finite() && rotation.is_finite()) {
            return Vec::new();
        }
        let mut fields = vec![self.field(".rotation", rotation)];
        // The lead turns about itself: roundings are no move.
        if place.distance(self.pose.translation) > 1e-9 * (1.0 + place.length()) {
            fields.push(self.field(".translation", place));
        }
        fields
    }

    fn scaled(&self, by: DVec3) -> FieldSet {
        self.field(".scale", self.pose.scale * by)
    }
}

fn field<C: Component>(entity: Entity, path: &str, value: f64) -> Option<FieldSet> {
    value.is_finite().then(|| FieldSet {
        entity,
        component: TypeId::of::<C>(),
        path: path.to_owned(),
        value: Box::new(value),
    })
}

/// Where the ray of the mouse meets a plane; none: it does not, or only far off at a glancing angle.
fn meets(sight: &Sight, at: Pos2, pivot: DVec3, normal: DVec3) -> Option<DVec3> {
    let (origin, dir) = sight.ray(at);
    let slope = dir.dot(normal);
    if slope.abs() < 1e-3 * normal.length() {
        return None;
    }
    let t = (pivot - origin).dot(normal) / slope;
    (t > 0.0).then(|| origin + dir * t)
}

fn snapped(value: f64, step: f64, snaps: bool) -> f64 {
    if snaps {
        (value / step).round() * step
    } else {
        value
    }
}
