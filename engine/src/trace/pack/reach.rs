//! [`Reach`]: how far a deformed mesh can reach, without looking at its vertices.
//!
//! Called where a device deforms: the host never sees the vertices, but the tree over instances needs a box
//! around each mesh. Each step maps a box to a box by interval arithmetic in f64. The box may be larger than
//! the tightest one; that costs rays, never a hit.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};

use crate::geom::Aabb;
use crate::world::{DeformStep, Deformation, MeshData, SkinBinding, VertexSets};

/// What f32 may err by in a step, of the largest number on the way: some 80 roundings.
const SLACK: f64 = 1e-5;

/// A box in f64; empty while `min` exceeds `max`.
#[derive(Clone, Copy, Debug)]
struct Span {
    min: DVec3,
    max: DVec3,
}

impl Span {
    const EMPTY: Self = Self {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };
    const ZERO: Self = Self {
        min: DVec3::ZERO,
        max: DVec3::ZERO,
    };

    fn of<'a>(points: impl IntoIterator<Item = &'a Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |span, p| Self {
            min: span.min.min(p.as_dvec3()),
            max: span.max.max(p.as_dvec3()),
        })
    }

    fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// All sums of one point of each.
    fn plus(self, other: Self) -> Self {
        Self {
            min: self.min + other.min,
            max: self.max + other.max,
        }
    }

    fn times(self, factor: f64) -> Self {
        let (a, b) = (self.min * factor, self.max * factor);
        Self {
            min: a.min(b),
            max: a.max(b),
        }
    }

    /// Around the image of the box.
    fn mapped(self, map: &DAffine3) -> Self {
        let centre = map.transform_point3((self.min + self.max) * 0.5);
        let half = map.matrix3.abs() * ((self.max - self.min) * 0.5);
        Self {
            min: centre - half,
            max: centre + half,
        }
    }

    fn corners(self) -> [DVec3; 8] {
        [0, 1, 2, 3, 4, 5, 6, 7].map(|i| {
            let side = |bit: i32, low: f64, high: f64| if i & bit == 0 { low } else { high };
            DVec3::new(
                side(1, self.min.x, self.max.x),
                side(2, self.min.y, self.max.y),
                side(4, self.min.z, self.max.z),
            )
        })
    }

    fn largest(&self) -> f64 {
        self.min.abs().max(self.max.abs()).max_element()
    }
}

/// Boxes of what deformations of one mesh are made of, found when first needed.
#[derive(Default)]
pub struct Reach {
    rest: Option<Span>,
    sets: Vec<(Arc<VertexSets>, Vec<Span>)>,
    /// Positions at rest of each joint's vertices.
    joints: Option<(Arc<SkinBinding>, Vec<Span>)>,
}

/// A box on its way through the steps.
struct Walk {
    whole: Span,
    /// What a vertex may be away from where it is at rest; none: anything.
    moved: Option<Span>,
    largest: f64,
}

impl Reach {
    /// A box, relative to the mesh's origin, around every vertex after a deformation.
    pub fn bounds(&mut self, mesh: &MeshData, deformation: &Deformation) -> Aabb {
        let rest = *self.rest.get_or_insert_with(|| Span::of(&mesh.positions));
        if rest.is_empty() {
            return Aabb::EMPTY;
        }
        let mut walk = Walk {
            whole: rest,
            moved: Some(Span::ZERO),
            largest: rest.largest(),
        };
        for step in &deformation.steps {
            self.take(step, mesh, &mut walk);
            walk.largest = walk.largest.max(walk.whole.largest());
        }
        let slack = walk.largest * SLACK;
        Aabb {
            min: (walk.whole.min - slack).as_vec3(),
            max: (walk.whole.max + slack).as_vec3(),
        }
        .grown()
    }

    fn take(&mut self, step: &DeformStep, mesh: &MeshData, walk: &mut Walk) {
        match step {
            DeformStep::Keys {
                keys,
                from,
                to,
                share,
            } => {
                let sets = self.sets(keys);
                let (from, to) = (sets[*from as usize], sets[*to as usize]);
                walk.whole = from.times(1.0 - share).plus(to.times(*share));
                walk.moved = None;
            }
            DeformStep::Morph { targets, weights } => {
                let sets = self.sets(targets).iter().zip(weights);
                let offset = sets.fold(Span::ZERO, |sum, (set, &w)| sum.plus(set.times(w)));
                walk.shift(offset);
            }
            DeformStep::Skin { binding, joints } => self.skin(binding, joints, mesh, walk),
            DeformStep::Wave { amplitude, .. } => {
                // Sines of huge angles may leave [-1, 1] a little.
                let far = amplitude.abs() * 1.01;
                walk.shift(Span {
                    min: -far,
                    max: far,
                });
            }
            DeformStep::Twist { origin, axis, .. } => walk.turn(*origin - mesh.origin, *axis),
        }
    }

    /// Weights are shares of a whole, so a vertex stays between its joints' images of it.
    fn skin(
        &mut self,
        binding: &Arc<SkinBinding>,
        joints: &[DAffine3],
        mesh: &MeshData,
        walk: &mut Walk,
    ) {
        let spans = self.joints(binding, mesh);
        let mut whole = Span::EMPTY;
        for (span, joint) in spans.iter().zip(joints) {
            if span.is_empty() {
                continue;
            }
            let held = walk.moved.map_or(walk.whole, |moved| span.plus(moved));
            let mut joint = *joint;
            joint.translation = joint.transform_point3(mesh.origin) - mesh.origin;
            whole = whole.union(held.mapped(&joint));
            let linear = DAffine3::from_mat3(joint.matrix3.abs());
            let parts = linear.transform_point3(DVec3::splat(held.largest()));
            walk.largest = walk
                .largest
                .max((parts + joint.translation.abs()).max_element());
        }
        walk.whole = whole;
        walk.moved = None;
    }

    fn sets(&mut self, sets: &Arc<VertexSets>) -> &[Span] {
        let known = self.sets.iter().position(|(own, _)| Arc::ptr_eq(own, sets));
        let index = known.unwrap_or_else(|| {
            let spans = (0..sets.count()).map(|set| Span::of(sets.set(set)));
            self.sets.push((Arc::clone(sets), spans.collect()));
            self.sets.len() - 1
        });
        &self.sets[index].1
    }

    fn joints(&mut self, binding: &Arc<SkinBinding>, mesh: &MeshData) -> &[Span] {
        let known = self.joints.take();
        let known = known.filter(|(own, _)| Arc::ptr_eq(own, binding));
        let (_, spans) = self.joints.insert(known.unwrap_or_else(|| {
            let mut spans = vec![Span::EMPTY; binding.highest_joint() as usize + 1];
            let bound = binding.joints.iter().zip(&binding.weights);
            for (position, (joints, weights)) in mesh.positions.iter().zip(bound) {
                for (&joint, &weight) in joints.iter().zip(weights) {
                    if weight > 0.0 {
                        let span = &mut spans[joint as usize];
                        *span = span.union(Span::of([position]));
                    }
                }
            }
            (Arc::clone(binding), spans)
        }));
        spans
    }
}

impl Walk {
    fn shift(&mut self, by: Span) {
        self.whole = self.whole.plus(by);
        self.moved = self.moved.map(|moved| moved.plus(by));
        self.largest = self.largest.max(by.largest());
    }

    /// Around all turns of the box about a line: a cylinder.
    fn turn(&mut self, origin: DVec3, axis: DVec3) {
        let (mut low, mut high, mut radius) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
        for corner in self.whole.corners() {
            let along = (corner - origin).dot(axis);
            (low, high) = (low.min(along), high.max(along));
            radius = radius.max((corner - origin - axis * along).length());
        }
        let (a, b) = (origin + axis * low, origin + axis * high);
        let aside = (DVec3::ONE - axis * axis).max(DVec3::ZERO);
        let aside = radius * 1.01 * DVec3::new(aside.x.sqrt(), aside.y.sqrt(), aside.z.sqrt());
        self.whole = Span {
            min: a.min(b) - aside,
            max: a.max(b) + aside,
        };
        self.moved = None;
        self.largest = self.largest.max(radius).max(origin.length());
    }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;
    use crate::trace::pack::deform::deform_positions;

    struct Random(u32);

    impl Random {
        fn unit(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(self.0 >> 8) / 16_777_216.0
        }

        fn cube(&mut self) -> DVec3 {
            DVec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
        }
    }

    fn step(kind: u32, count: usize, random: &mut Random) -> DeformStep {
        let mut sets = |size: f64| {
            Arc::new(VertexSets {
                vertices: count,
                values: (0..3 * count)
                    .map(|_| (random.cube() * size).as_vec3())
                    .collect(),
            })
        };
        match kind {
            0 => DeformStep::Keys {
                keys: sets(2.0),
                from: 2,
                to: 0,
                share: random.unit() * 1.2 - 0.1,
            },
            1 => DeformStep::Morph {
                targets: sets(0.3),
                weights: vec![random.unit() - 0.5, 0.0, random.unit()],
            },
            2 => {
                let joints = (0..count).map(|i| [i as u32 % 3, 1, 0, 2]).collect();
                let weights = (0..count).map(|i| [1.0, i as f32, 0.0, random.unit() as f32]);
                let turn = |random: &mut Random| {
                    let angle = random.unit() * 6.0;
                    let axis = random.cube().normalize();
                    DAffine3::from_rotation_translation(
                        DQuat::from_axis_angle(axis, angle),
                        random.cube(),
                    )
                };
                let binding = SkinBinding::new(joints, weights.collect()).expect("a binding");
                DeformStep::Skin {
                    binding: Arc::new(binding),
                    joints: (0..3).map(|_| turn(random)).collect(),
                }
            }
            3 => DeformStep::Wave {
                wave: random.cube() * 9.0,
                amplitude: random.cube(),
                phase: random.unit() * 1000.0,
            },
            _ => DeformStep::Twist {
                origin: random.cube() * 3.0,
                axis: random.cube().normalize(),
                rate: random.unit() * 8.0 - 4.0,
                offset: random.unit() * 6.0,
            },
        }
    }

    #[test]
    fn no_vertex_leaves_the_box_whatever_the_steps() {
        let mut random = Random(5);
        for round in 0..400 {
            let centre = random.cube() * if round % 2 == 0 { 0.0 } else { 50.0 };
            let count = 3 + round % 40;
            let vertices = (0..count).map(|_| random.cube() + centre).collect();
            let mesh = MeshData::new("cloud", vertices, Vec::new(), vec![[0, 1, 2]]).unwrap();
            let mut reach = Reach::default();
            for _ in 0..3 {
                let steps = (0..1 + round % 4)
                    .map(|_| step((random.unit() * 5.0) as u32, count, &mut random))
                    .collect();
                let deformation = Deformation { steps };
                let bounds = reach.bounds(&mesh, &deformation);
                let mut positions = Vec::new();
                deform_positions(&mesh, &deformation, &mut positions);
                let inside = Aabb::of(positions.iter().copied());
                assert!(
                    bounds.contains(&inside),
                    "{bounds:?}, {inside:?}, {deformation:?}"
                );
                let size = (inside.max - inside.min).max_element() + 1.0;
                let loose = (bounds.max - bounds.min).max_element();
                assert!(loose < 60.0 * size, "{loose} for {size}");
            }
        }
    }

    #[test]
    fn a_mesh_at_rest_reaches_as_far_as_its_vertices() {
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::new(0.5, 2.0, -3.0)];
        let mesh = MeshData::new("one", vertices, Vec::new(), vec![[0, 1, 2]]).unwrap();
        let bounds = Reach::default().bounds(&mesh, &Deformation::default());
        let inside = Aabb::of(mesh.positions.iter().copied());
        assert!(bounds.contains(&inside));
        assert!(inside.min.abs_diff_eq(bounds.min, 1e-4));
        assert!(inside.max.abs_diff_eq(bounds.max, 1e-4));
    }
}
