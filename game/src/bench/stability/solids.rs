//! Closed meshes that rays try to slip out of: round ones, slivers and needles.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::{DVec3, Vec3};
use orrery_engine::world::MeshData;

/// A closed surface around the origin; the ball of radius `core` is inside.
pub struct Solid {
    /// A word for it.
    pub name: &'static str,
    /// Vertices.
    pub points: Vec<DVec3>,
    /// Triangles of them.
    pub triangles: Vec<[u32; 3]>,
    /// See above.
    pub core: f64,
    /// Times this, its features are well above the spacing of f32 at 1.5e5, and products of them are rounded.
    pub far_scale: f64,
    /// Its share of the rays that all solids are tried with. Boxes of slivers that meet in a point overlap, so that a
    /// ray is tested against many: measured, six to twelve times as long a ray in the fan as in the icosphere, and
    /// thirty times as long in the needles. With these shares no solid takes longer than the icosphere.
    pub share: f64,
}

impl Solid {
    /// All.
    pub fn all() -> [Self; 3] {
        [Self::icosphere(4), Self::fan(), Self::needles()]
    }

    /// An icosahedron whose faces are split `levels` times in four: 20 * 4^levels triangles.
    pub fn icosphere(levels: u32) -> Self {
        let (points, mut triangles) = icosahedron();
        let mut points: Vec<DVec3> = points.into();
        for _ in 0..levels {
            let mut middles = HashMap::new();
            let mut middle = |a: u32, b: u32| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    points.push((points[a as usize] + points[b as usize]).normalize());
                    points.len() as u32 - 1
                })
            };
            let split = |&[a, b, c]: &[u32; 3]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            };
            triangles = triangles.iter().flat_map(split).collect();
        }
        Self {
            name: "icosphere",
            points,
            triangles,
            core: 0.6,
            far_scale: 2000.0,
            share: 0.9,
        }
    }

    /// A cube of side 1, two triangles a side. It is not among [`Solid::all`], and has no share of their rays.
    pub fn cube() -> Self {
        let corner = |i: u32| {
            let bit = |axis: u32| f64::from(i >> axis & 1) - 0.5;
            DVec3::new(bit(0), bit(1), bit(2))
        };
        let sides = [
            [0, 4, 6, 2],
            [1, 3, 7, 5],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 2, 3, 1],
            [4, 5, 7, 6],
        ];
        let split = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
        Self {
            name: "cube",
            points: (0..8).map(corner).collect(),
            triangles: sides.into_iter().flat_map(split).collect(),
            core: 0.4,
            far_scale: 2000.0,
            share: 0.0,
        }
    }

    /// Two fans of 360 slivers, back to back.
    fn fan() -> Self {
        Self::double_cone("fan", 360, (0.5, 0.07), |_| 1.0)
    }

    /// The same of a saw blade: needles of aspect 1 : 100.
    fn needles() -> Self {
        let radius = |i: u32| if i.is_multiple_of(2) { 1.0 } else { 0.5 };
        Self::double_cone("needles", 720, (0.6, 0.03), radius)
    }

    fn double_cone(
        name: &'static str,
        count: u32,
        (height, share): (f64, f64),
        radius: impl Fn(u32) -> f64,
    ) -> Self {
        let rim = (0..count).map(|i| {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(count)).sin_cos();
            DVec3::new(cos, 0.0, sin) * radius(i)
        });
        let tips = [DVec3::Y * height, DVec3::NEG_Y * height];
        let points: Vec<DVec3> = tips.into_iter().chain(rim).collect();
        let triangles = (0..count).flat_map(|i| {
            let (a, b) = (2 + i, 2 + (i + 1) % count);
            [[0, b, a], [1, a, b]]
        });
        Self {
            name,
            points,
            triangles: triangles.collect(),
            core: 0.2,
            far_scale: 2000.0,
            share,
        }
    }

    /// As a mesh whose f32 positions are `points * scale + at`, rounded, and in which a point reflection of it
    /// keeps the mesh's origin at zero, so that nothing is recentred. Its own triangles come first.
    pub fn mesh_at(&self, at: Vec3, scale: f64) -> Result<MeshData, String> {
        let place = |p: &DVec3| ((p * scale).as_vec3() + at).as_dvec3();
        let here: Vec<DVec3> = self.points.iter().map(place).collect();
        let mirrored = here.iter().map(|p| -p);
        let first = here.len() as u32;
        let twins = self.triangles.iter().map(|t| t.map(|v| v + first));
        let triangles = self.triangles.iter().copied().chain(twins).collect();
        let vertices = here.iter().copied().chain(mirrored).collect();
        MeshData::new(self.name, vertices, Vec::new(), triangles)
    }

    /// As a mesh.
    pub fn mesh(&self) -> Result<MeshData, String> {
        MeshData::new(
            self.name,
            self.points.clone(),
            Vec::new(),
            self.triangles.clone(),
        )
    }
}

fn icosahedron() -> ([DVec3; 12], Vec<[u32; 3]>) {
    let g = (1.0 + 5_f64.sqrt()) / 2.0;
    let points = [
        [-1.0, g, 0.0],
        [1.0, g, 0.0],
        [-1.0, -g, 0.0],
        [1.0, -g, 0.0],
        [0.0, -1.0, g],
        [0.0, 1.0, g],
        [0.0, -1.0, -g],
        [0.0, 1.0, -g],
        [g, 0.0, -1.0],
        [g, 0.0, 1.0],
        [-g, 0.0, -1.0],
        [-g, 0.0, 1.0],
    ];
    let upper = [[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11]];
    let middle = [
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    let lower = [[3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9]];
    (
        points.map(|p| DVec3::from(p).normalize()),
        [&upper[..], &middle, &lower].concat(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solids_are_closed_around_their_core() {
        for solid in Solid::all().into_iter().chain([Solid::cube()]) {
            let mut edges = HashMap::new();
            for &[a, b, c] in &solid.triangles {
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    *edges.entry((from, to)).or_insert(0) += 1;
                }
                let [a, b, c] = [a, b, c].map(|v| solid.points[v as usize]);
                for (i, j) in (0..=20).flat_map(|i| (0..=20 - i).map(move |j| (i, j))) {
                    let at = a + (b - a) * (f64::from(i) / 20.0) + (c - a) * (f64::from(j) / 20.0);
                    let distance = at.length();
                    assert!(distance > solid.core * 1.1, "{}: {distance}", solid.name);
                }
            }
            let twins = edges.keys().all(|&(a, b)| edges.get(&(b, a)) == Some(&1));
            assert!(twins, "{} has a rim", solid.name);
        }
    }

    #[test]
    fn shares_add_up() {
        let shares = Solid::all().map(|solid| solid.share);
        assert!(shares.iter().all(|&share| share > 0.0));
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn far_meshes_are_not_recentred() {
        for solid in Solid::all() {
            let at = Vec3::new(150_000.0, -120_000.0, 90_000.0);
            let mesh = solid.mesh_at(at, solid.far_scale).unwrap();
            assert_eq!(mesh.origin, DVec3::ZERO);
            assert!(mesh.positions[0].distance(at) <= 2001.0);
        }
    }
}
