//! The camera in hand: flies through the world, over whatever the timeline says, until it is given back.
//!
//! The pose is kept in the world. A camera that hangs from a moving parent is brought back into its
//! parent's space every frame, so it flies straight however the parent turns.

use bevy_ecs::prelude::*;
use glam::{DAffine3, DQuat, DVec3};

use super::{Action, Input, KeyMap};
use crate::time::Time;
use crate::world::{
    ActiveCamera, Camera, GlobalVisibility, Shear, Transform, picture_camera, world_from_local,
};

/// Radians the camera turns for a pixel of mouse movement: a hand's breadth is about half a turn.
const RADIANS_PER_PIXEL: f64 = 0.003;
/// Radians a second while a turn key is held.
const TURN_RADIANS_PER_SEC: f64 = 1.2;
/// How near to straight up or down the view may come, as the sine of its height.
const STEEPEST: f64 = 0.999;
/// How many radii away a thing is looked at from: a ball then fills most of a picture of 45 degrees.
const RADII_AWAY: f64 = 3.5;
/// A stalled frame must not throw the camera across the scene.
const LONGEST_STEP_SECS: f64 = 0.1;

/// The camera as its user flies it.
#[derive(Resource, Clone, Copy, Debug)]
pub struct FlyCamera {
    /// World units a second.
    pub speed: f64,
    flight: Option<Flight>,
    /// A place to look at, and how far it reaches.
    focus: Option<(DVec3, f64)>,
}

impl Default for FlyCamera {
    fn default() -> Self {
        Self {
            // A scene of a few units across is crossed in a few seconds; the wheel does the rest.
            speed: 3.0,
            flight: None,
            focus: None,
        }
    }
}

impl FlyCamera {
    /// Whether the camera is off the scene's own path.
    pub fn is_active(&self) -> bool {
        self.flight.is_some()
    }

    /// In the next frame the camera looks at a place as it looks now, from where a ball of that radius is seen whole.
    pub fn look_at(&mut self, place: DVec3, radius: f64) {
        if place.is_finite() && radius.is_finite() {
            self.focus = Some((place, radius.max(1e-6)));
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct Flight {
    entity: Entity,
    position: DVec3,
    rotation: DQuat,
    /// What to give back.
    home: Transform,
    home_camera: ActiveCamera,
}

/// What the user wants of the camera in this frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Wish {
    /// In the camera's axes but for y, which is the world's; lengths in world units.
    step: DVec3,
    /// About the world's up, radians.
    yaw: f64,
    /// About the camera's right, radians.
    pitch: f64,
}

fn wish(input: &Input, keys: &KeyMap, speed: f64, secs: f64) -> Wish {
    let mut pace = speed;
    if keys.is_down(Action::Fast, input) {
        pace *= 4.0;
    }
    if keys.is_down(Action::Slow, input) {
        pace *= 0.25;
    }
    let direction = DVec3::new(
        keys.axis(Action::Right, Action::Left, input),
        keys.axis(Action::Up, Action::Down, input),
        keys.axis(Action::Back, Action::Forward, input),
    );
    let turn = keys.axis(Action::TurnLeft, Action::TurnRight, input);
    let looks = keys.is_down(Action::Look, input);
    let mouse = if looks {
        input.mouse_delta() * RADIANS_PER_PIXEL
    } else {
        glam::DVec2::ZERO
    };
    Wish {
        step: direction.normalize_or_zero() * (pace * secs),
        yaw: turn * TURN_RADIANS_PER_SEC * secs - mouse.x,
        pitch: -mouse.y,
    }
}

/// Turns first, then moves; the view never tips over.
fn flown(position: DVec3, rotation: DQuat, wish: Wish) -> (DVec3, DQuat) {
    let yawed = DQuat::from_rotation_y(wish.yaw) * rotation;
    let pitched = yawed * DQuat::from_rotation_x(wish.pitch);
    let height = |rotation: DQuat| (rotation * DVec3::NEG_Z).y.abs();
    let tips_over = height(pitched) > STEEPEST && height(pitched) > height(yawed)
        || (pitched * DVec3::Y).y < 0.0 && (yawed * DVec3::Y).y >= 0.0;
    let rotation = if tips_over { yawed } else { pitched }.normalize();
    let step = rotation * DVec3::new(wish.step.x, 0.0, wish.step.z) + DVec3::Y * wish.step.y;
    (position + step, rotation)
}

/// Poses of an entity and its ancestors as they are in this frame, before propagation.
type Poses<'w, 's> = Query<'w, 's, (&'static mut Transform, Option<&'static Shear>)>;

/// world_from_local out of this frame's transforms, from the entity up.
fn world_from(entity: Entity, poses: &Poses, parents: &Query<&ChildOf>) -> DAffine3 {
    world_from_local(
        std::iter::once(entity)
            .chain(parents.iter_ancestors(entity))
            .filter_map(|entity| poses.get(entity).ok()),
    )
}

/// The flight of a camera from where it is now; none if it is nowhere.
fn take_in_hand(
    entity: Entity,
    home_camera: ActiveCamera,
    poses: &Poses,
    parents: &Query<&ChildOf>,
) -> Option<Flight> {
    let (_, rotation, position) =
        world_from(entity, poses, parents).to_scale_rotation_translation();
    Some(Flight {
        entity,
        position,
        rotation,
        home: *poses.get(entity).ok()?.0,
        home_camera,
    })
}

/// Takes the camera into the hand at the first wish, flies it, gives it back.
#[expect(
    clippy::too_many_arguments,
    reason = "what a hand on a camera needs to know"
)]
pub(super) fn fly_camera(
    input: Res<Input>,
    keys: Res<KeyMap>,
    time: Res<Time>,
    mut fly: ResMut<FlyCamera>,
    mut active: ResMut<ActiveCamera>,
    cameras: Query<(Entity, &GlobalVisibility), With<Camera>>,
    mut poses: Poses,
    parents: Query<&ChildOf>,
) {
    if keys.is_pressed(Action::Return, &input) {
        if let Some(flight) = fly.flight.take() {
            *active = flight.home_camera;
            if let Ok((mut transform, _)) = poses.get_mut(flight.entity) {
                transform.set_if_neq(flight.home);
            }
        }
        return;
    }
    if input.wheel() != 0.0 {
        fly.speed = (fly.speed * 1.2_f64.powf(input.wheel())).clamp(1e-3, 1e6);
    }
    let secs = time.wall_delta_secs.min(LONGEST_STEP_SECS);
    let wish = wish(&input, &keys, fly.speed, secs);
    let focus = fly.focus.take();
    if fly.flight.is_none() && (wish != Wish::default() || focus.is_some()) {
        let shown = cameras.iter().map(|(entity, visible)| (entity, visible.0));
        fly.flight = picture_camera(*active, shown)
            .and_then(|entity| take_in_hand(entity, *active, &poses, &parents));
    }
    let Some(flight) = &mut fly.flight else {
        return;
    };
    if let Some((place, radius)) = focus {
        flight.position = place - flight.rotation * DVec3::NEG_Z * (radius * RADII_AWAY);
    }
    (flight.position, flight.rotation) = flown(flight.position, flight.rotation, wish);
    let flight = *flight;
    let parent = parents.get(flight.entity).ok().map(ChildOf::parent);
    let world_from_parent = parent.map_or(DAffine3::IDENTITY, |parent| {
        world_from(parent, &poses, &parents)
    });
    let world_from_camera = DAffine3::from_rotation_translation(flight.rotation, flight.position);
    let (_, rotation, translation) =
        (world_from_parent.inverse() * world_from_camera).to_scale_rotation_translation();
    let Ok((mut transform, _)) = poses.get_mut(flight.entity) else {
        fly.flight = None; // the camera was removed in flight
        return;
    };
    let scale = transform.scale;
    transform.set_if_neq(Transform {
        translation,
        rotation,
        scale,
    });
    active.set_if_neq(ActiveCamera(Some(flight.entity)));
}

#[cfg(test)]
mod tests {
    use super::super::{KeyCode, MouseButton};
    use super::*;
    use crate::app::Engine;
    use crate::world::GlobalTransform;

    fn engine() -> Engine {
        let mut engine = Engine::new();
        engine.add_plugin(super::super::plugin);
        engine.validate().unwrap();
        engine
    }

    fn eye(engine: &Engine, camera: Entity) -> DAffine3 {
        engine.world.get::<GlobalTransform>(camera).unwrap().0
    }

    /// Runs frames that take at least a few milliseconds each: flight follows the wall clock.
    fn frames(engine: &mut Engine, count: usize) {
        for _ in 0..count {
            std::thread::sleep(std::time::Duration::from_millis(5));
            engine.frame();
            engine.world.resource_mut::<Input>().end_frame();
        }
    }

    #[test]
    fn a_key_flies_the_camera_forward_and_another_gives_it_back() {
        let mut engine = engine();
        let start = Transform::looking_at(DVec3::new(4.0, 2.0, 9.0), DVec3::ZERO, DVec3::Y);
        let camera = engine.world.spawn((Camera::default(), start)).id();
        frames(&mut engine, 1);
        let before = eye(&engine, camera);
        engine
            .world
            .resource_mut::<Input>()
            .key(KeyCode::KeyW, true);
        frames(&mut engine, 4);
        engine
            .world
            .resource_mut::<Input>()
            .key(KeyCode::KeyW, false);
        let moved = eye(&engine, camera).translation - before.translation;
        let forward = before.transform_vector3(DVec3::NEG_Z);
        assert!(moved.length() > 0.02, "moved by {moved}");
        assert!(
            moved.normalize().dot(forward) > 1.0 - 1e-9,
            "{moved} is not along {forward}"
        );
        assert!(engine.world.resource::<FlyCamera>().is_active());
        engine
            .world
            .resource_mut::<Input>()
            .key(KeyCode::Backspace, true);
        frames(&mut engine, 1);
        assert_eq!(eye(&engine, camera), before);
        assert!(!engine.world.resource::<FlyCamera>().is_active());
    }

    #[test]
    fn under_a_moving_parent_it_stays_where_it_was_flown_to() {
        let mut engine = engine();
        let parent = engine.world.spawn(Transform::IDENTITY).id();
        let local = Transform::from_translation(DVec3::new(0.0, 1.0, 5.0));
        let camera = engine
            .world
            .spawn((Camera::default(), local, ChildOf(parent)))
            .id();
        frames(&mut engine, 1);
        engine
            .world
            .resource_mut::<Input>()
            .key(KeyCode::KeyD, true);
        frames(&mut engine, 2);
        engine
            .world
            .resource_mut::<Input>()
            .key(KeyCode::KeyD, false);
        let still = eye(&engine, camera);
        for turn in 1..5 {
            let mut pose = engine.world.get_mut::<Transform>(parent).unwrap();
            pose.rotation = DQuat::from_rotation_y(0.3 * f64::from(turn));
            pose.translation = DVec3::new(f64::from(turn), 0.5, 0.0);
            frames(&mut engine, 1);
            let now = eye(&engine, camera);
            assert!(now.abs_diff_eq(still, 1e-9), "{now:?} is not {still:?}");
        }
    }

    #[test]
    fn the_mouse_turns_the_view_only_while_the_button_is_held() {
        let mut engine = engine();
        let camera = engine.world.spawn(Camera::default()).id();
        frames(&mut engine, 1);
        let before = eye(&engine, camera);
        engine
            .world
            .resource_mut::<Input>()
            .mouse_moved(glam::DVec2::new(50.0, 0.0));
        frames(&mut engine, 1);
        assert_eq!(eye(&engine, camera), before);
        let mut input = engine.world.resource_mut::<Input>();
        input.button(MouseButton::Right, true);
        input.mouse_moved(glam::DVec2::new(50.0, 0.0));
        frames(&mut engine, 1);
        let forward = eye(&engine, camera).transform_vector3(DVec3::NEG_Z);
        assert!(
            forward.x > 0.1,
            "the mouse went right, the view went to {forward}"
        );
    }

    #[test]
    fn the_view_never_tips_over() {
        let mut rotation = DQuat::IDENTITY;
        for step in 0..2000 {
            let pitch = if step % 1000 < 500 { 0.05 } else { -0.05 };
            let wish = Wish {
                pitch,
                yaw: 0.01,
                ..Wish::default()
            };
            rotation = flown(DVec3::ZERO, rotation, wish).1;
            assert!((rotation * DVec3::Y).y > 0.0, "upside down at step {step}");
            assert!((rotation.length() - 1.0).abs() < 1e-12);
        }
    }
}
