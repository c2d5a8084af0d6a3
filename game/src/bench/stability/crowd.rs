//! [`Crowd`]: instances of one kind of surface, and rays that arrive at them from well outside.

use glam::{DAffine3, DVec3};
use orrery_engine::frame::{FrameScene, Kernels};
use orrery_engine::trace::{Hit, Query, Ray};

use super::course::{Course, ready, scene_of};
use super::draw::Draw;
use super::solids::Solid;
use super::stream::Stream;
use super::surfaces::{Kind, meshes};
use super::tally::{Tally, Verdict};
use crate::failure::Failure;

/// Instances of a scene: with more of them, rays would find most of their way through others that overlap.
const INSTANCES: u64 = 64;
/// How far off the sides of a solid is well off them, in ULPs of the position: further than any origin is lifted.
const ROOM: f64 = 48.0;
/// Places that are looked at along a ray, each twice as far as the last: across the largest shape.
const STEPS: u32 = 24;

/// Instances of a kind, and what is known of them.
pub struct Crowd {
    /// See above.
    pub kind: Kind,
    /// They, alone.
    pub scene: FrameScene,
    solids: [Solid; 3],
    /// Which scene of the kind.
    number: u64,
}

/// Where a ray met the instance that it was sent at.
pub struct Arrival {
    /// Which pair.
    pub index: u64,
    /// Which primitive of it.
    prim: u32,
    /// Relative to the eye.
    pub at: DVec3,
    /// That of the instance.
    pub map: DAffine3,
}

impl Arrival {
    /// The spacing of f32 at the largest coordinate.
    pub fn ulp(&self) -> f64 {
        let largest = self.at.abs().max_element() as f32;
        f64::from(largest.next_up()) - f64::from(largest)
    }
}

impl Crowd {
    /// Instances placed by `place`.
    ///
    /// # Errors
    /// Meshes that the engine refuses.
    pub fn new(
        kind: Kind,
        number: u64,
        place: impl Fn(&mut Draw) -> DAffine3,
    ) -> Result<Self, Failure> {
        let count = match kind {
            // They have no boxes: every ray meets every plane.
            Kind::Plane => 12,
            _ => INSTANCES,
        };
        let placed = |i| (kind.shape(), place(&mut Draw::of(400 + number, i)));
        let mut scene = scene_of((0..count).map(placed));
        let solids = meshes();
        let rows: Result<Vec<_>, _> = solids.iter().map(|s| s.mesh().map(Into::into)).collect();
        scene.meshes = rows.map_err(Failure::Input)?.into();
        Ok(Self {
            kind,
            scene: ready(scene),
            solids,
            number,
        })
    }

    /// Sends pairs of rays: the first arrives at an instance, the second goes on along `onwards(index)`, in the frame of
    /// the surface. Where the first met what it was sent at, `judge` says what the pair is worth.
    ///
    /// # Errors
    /// Those of the tracer.
    pub fn send(
        &self,
        course: &mut Course,
        (name, kernels): (&str, Kernels),
        count: u64,
        onwards: impl Fn(u64) -> DVec3 + Sync,
        judge: impl Fn(&Arrival, &[Hit]) -> Verdict + Sync,
    ) -> Result<Tally, Failure> {
        course.upload(&self.scene, kernels)?;
        let stream = Stream {
            label: name,
            count,
            query: Query::Leave,
            make: |index, rays: &mut [Ray]| {
                self.arrive(index, &mut rays[0]);
                rays[1].dir = onwards(index).as_vec3();
            },
            judge: |index, rays: &[Ray], hits: &[Hit]| {
                let instance = self.draw(index).1;
                if hits[0].instance != instance {
                    // Something else was in the way.
                    return Verdict::Void;
                }
                let [origin, dir] = [rays[0].origin, rays[0].dir].map(|v| v.as_dvec3());
                let arrival = Arrival {
                    index,
                    prim: hits[0].prim,
                    at: origin + dir * hits[0].t,
                    map: self.scene.instances[instance as usize].world_from_local,
                };
                judge(&arrival, hits)
            },
        };
        stream.run(course.tracer.as_mut())
    }

    /// Whether a ray that goes on from where it arrived comes to a place in the solid that is well off all its sides. One
    /// that grazes an edge, or the rim of something flat, does not: by the roundings of its origin it may be beyond.
    pub fn goes_deep(&self, arrival: &Arrival, onwards: DVec3) -> bool {
        let to_local = arrival.map.inverse();
        let local = to_local.transform_point3(arrival.at);
        let normal = self.kind.normal(&self.solids, arrival.prim, local);
        let normal = (to_local.matrix3.transpose() * normal).normalize();
        // As Query::Leave has it.
        let (x, y) = normal.any_orthonormal_pair();
        let dir = x * onwards.x + y * onwards.y + normal * onwards.z;
        let room = ROOM * arrival.ulp();
        let is_held = |place| {
            self.kind
                .holds(&self.solids, to_local.transform_point3(place))
        };
        let mut places = (0..STEPS).map(|step| arrival.at + dir * room * f64::from(step).exp2());
        places.any(|place| {
            let mut sides = DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
            sides.all(|side| is_held(place + side * room))
        })
    }

    /// The numbers of a pair, and the instance it is for.
    fn draw(&self, index: u64) -> (Draw, u32) {
        let mut draw = Draw::of(500 + self.number, index);
        let instance = draw.below(self.scene.instances.len()) as u32;
        (draw, instance)
    }

    /// A ray from well outside, at least half the size of the shape off, at a point of it.
    fn arrive(&self, index: u64, ray: &mut Ray) {
        let (mut draw, instance) = self.draw(index);
        let map = self.scene.instances[instance as usize].world_from_local;
        let (local, local_normal) = self.kind.point(&self.solids, &mut draw);
        let point = map.transform_point3(local);
        let origin = if self.kind == Kind::Hole {
            // Along the axis: what is straight above the hole's side may be in the tube.
            let above = DVec3::Y * [-1.0, 1.0][draw.below(2)] * draw.power(0.0, 0.5);
            map.transform_point3(above + draw.cube() * 0.2)
        } else {
            let normal = (map.matrix3.inverse().transpose() * local_normal).normalize();
            let axes = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis];
            let size = axes.map(DVec3::length).into_iter().fold(0.0, f64::max);
            let aside = draw.direction().cross(normal) * draw.power(-2.0, 0.5);
            point + (normal * draw.power(0.0, 0.5) + aside) * size
        };
        ray.origin = origin.as_vec3();
        ray.dir = (point - ray.origin.as_dvec3()).as_vec3();
    }
}
