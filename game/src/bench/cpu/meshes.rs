//! The meshes whose rays are timed: hills with spheres over them, one mesh, half of its triangles in either.

use glam::{DAffine3, DMat3, DVec3, Vec3};
use orrery_engine::frame::View;

use crate::bench::hills::hills;
use crate::bench::stability::solids::Solid;
use crate::bench::trace::stage::Stage;
use crate::bench::work::WorkMesh;

/// Across and down the picture at distance 1.
const SPAN: (f64, f64) = (1.0, 0.75);

/// A mesh to be made.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// A word for it.
    pub name: &'static str,
    /// Triangles of the hills, about.
    pub hills: usize,
    /// Spheres over them along a side.
    pub spheres: u32,
    /// How often the faces of an icosahedron are split into four.
    pub splits: u32,
}

/// About 100,000 and 1,000,000 triangles.
pub const FULL: [Plan; 2] = [
    Plan {
        name: "s0",
        hills: 48_000,
        spheres: 3,
        splits: 4,
    },
    Plan {
        name: "s1",
        hills: 500_000,
        spheres: 5,
        splits: 5,
    },
];

/// For a look at the rows.
pub const SMALL: [Plan; 1] = [Plan {
    name: "s0",
    hills: 1000,
    spheres: 2,
    splits: 1,
}];

impl Plan {
    /// The mesh, an eye above its edge and a light.
    pub fn stage(&self) -> Result<Stage, String> {
        let eye = DVec3::new(0.5, 0.55, 1.15);
        let forward = (DVec3::new(0.5, 0.0, 0.4) - eye).normalize();
        let right = forward.cross(DVec3::Y).normalize();
        let view = View {
            origin: eye,
            forward,
            right: right * SPAN.0,
            up: right.cross(forward) * SPAN.1,
            ..View::default()
        };
        let mesh = WorkMesh {
            name: self.name.into(),
            triangles: self.triangles()?,
        };
        let place = DAffine3::from_mat3_translation(DMat3::IDENTITY, -eye);
        let light = DVec3::new(-0.4, 1.6, 0.9) - eye;
        Stage::of_meshes(self.name.into(), vec![mesh], vec![(0, place)], view, light)
    }

    fn triangles(&self) -> Result<Vec<[Vec3; 3]>, String> {
        let hills = hills(self.hills)?;
        let corner = |i: u32| hills.vertices[i as usize].as_vec3();
        let mut triangles: Vec<[Vec3; 3]> = hills.triangles.iter().map(|t| t.map(corner)).collect();
        let sphere = Solid::icosphere(self.splits);
        let pitch = 1.0 / f64::from(self.spheres);
        for i in 0..self.spheres * self.spheres {
            let at = |n: u32| (f64::from(n) + 0.5) * pitch;
            let centre = DVec3::new(
                at(i % self.spheres),
                0.4 * pitch + 0.03,
                at(i / self.spheres),
            );
            let corner = |v: u32| (sphere.points[v as usize] * (0.35 * pitch) + centre).as_vec3();
            triangles.extend(sphere.triangles.iter().map(|t| t.map(corner)));
        }
        Ok(triangles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_are_as_large_as_they_say() {
        for (plan, most) in [(FULL[0], 100_000), (SMALL[0], 2000)] {
            let stage = plan.stage().expect("a mesh");
            let count = stage.work.meshes[0].triangles.len();
            assert!(count > most / 2 && count <= most, "{count}");
        }
    }
}
