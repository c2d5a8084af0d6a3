//! Random scenes for property tests: every shape, every kind of material, any pose; the same for a seed.

use glam::{DAffine3, DQuat, DVec3, Vec3};
use orrery_engine::frame::{FrameScene, Instance, Light, LightKind, Shape, View};
use orrery_engine::world::{Cone, Lobe, Material, MeshData, Reflection};

/// A small, fast generator (PCG-like); good enough to place things.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The same seed gives the same numbers.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in a range.
    pub fn range(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }

    /// Uniform in the cube [-1, 1]^3.
    pub fn cube(&mut self) -> DVec3 {
        DVec3::new(
            self.range(-1.0, 1.0),
            self.range(-1.0, 1.0),
            self.range(-1.0, 1.0),
        )
    }

    /// A direction.
    pub fn direction(&mut self) -> DVec3 {
        self.cube().try_normalize().unwrap_or(DVec3::X)
    }

    /// One of a few.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count - 1)
    }
}

/// An icosahedron with each face split `levels` times in four, its vertices on the unit sphere.
pub fn icosphere(levels: u32) -> MeshData {
    let g = (1.0 + 5_f64.sqrt()) / 2.0;
    let mut vertices: Vec<DVec3> = [
        (-1.0, g, 0.0),
        (1.0, g, 0.0),
        (-1.0, -g, 0.0),
        (1.0, -g, 0.0),
        (0.0, -1.0, g),
        (0.0, 1.0, g),
        (0.0, -1.0, -g),
        (0.0, 1.0, -g),
        (g, 0.0, -1.0),
        (g, 0.0, 1.0),
        (-g, 0.0, -1.0),
        (-g, 0.0, 1.0),
    ]
    .map(|(x, y, z)| DVec3::new(x, y, z).normalize())
    .to_vec();
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..levels {
        let mut middles = std::collections::HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push(((vertices[a as usize] + vertices[b as usize]) * 0.5).normalize());
                vertices.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    MeshData::new("icosphere", vertices, Vec::new(), triangles).expect("a sphere is a mesh")
}

/// The same with smooth normals.
pub fn smooth_icosphere(levels: u32) -> MeshData {
    let mut mesh = icosphere(levels);
    mesh.normals = mesh.vertices.iter().map(|v| v.as_vec3()).collect();
    mesh
}

/// Matte, mirror, glass, tinted and glowing.
pub fn materials() -> Vec<Material> {
    let matte = Material {
        color: Vec3::new(0.7, 0.4, 0.3),
        specular: Some(Lobe::default()),
        ..Default::default()
    };
    let mirror = Material {
        color: Vec3::splat(0.2),
        reflection: Reflection::Constant(Vec3::new(0.7, 0.75, 0.8)),
        phong: Some(Lobe::default()),
        ..Default::default()
    };
    let glass = Material {
        color: Vec3::ONE,
        diffuse: 0.0,
        reflection: Reflection::Fresnel,
        transmit: 1.0,
        ior: 1.5,
        ..Default::default()
    };
    let tinted = Material {
        color: Vec3::new(0.3, 0.8, 0.5),
        diffuse: 0.5,
        filter: 0.7,
        transmit: 0.1,
        ior: 1.0,
        ..Default::default()
    };
    let glow = Material {
        emission: 0.6,
        ..Default::default()
    };
    vec![matte, mirror, glass, tinted, glow]
}

/// A scene of `count` random shapes within a few units of the origin, seen from the side.
pub fn random_scene(seed: u64, count: usize) -> FrameScene {
    let mut random = Random::new(seed);
    let mut scene = FrameScene {
        background: Vec3::new(0.2, 0.3, 0.4).into(),
        max_generations: 6,
        materials: materials().into(),
        meshes: vec![icosphere(2).into(), smooth_icosphere(2).into()].into(),
        ..Default::default()
    };
    scene.view = View {
        origin: DVec3::new(0.0, 1.0, 9.0),
        forward: DVec3::NEG_Z,
        right: DVec3::X * 1.2,
        up: DVec3::Y * 0.9,
        ..Default::default()
    };
    for _ in 0..count {
        let instance = random_instance(&mut random, scene.materials.len());
        scene.instances.push(instance);
    }
    for position in [DVec3::new(4.0, 7.0, 6.0), DVec3::new(-6.0, 3.0, 5.0)] {
        scene.lights.push(Light {
            color: Vec3::splat(0.6),
            fade: None,
            kind: LightKind::Point { position },
        });
    }
    scene.features = orrery_engine::frame::Features::of(&scene);
    scene
}

fn random_instance(random: &mut Random, materials: usize) -> Instance {
    let place = random.cube() * 3.0;
    let turn = DQuat::from_axis_angle(random.direction(), random.range(0.0, 6.0));
    let even = DVec3::splat(random.range(0.2, 1.0));
    let uneven = DVec3::new(
        random.range(0.2, 1.0),
        random.range(0.2, 1.0),
        random.range(0.2, 1.0),
    );
    let (shape, scale) = match random.below(16) {
        0..=2 => (Shape::Sphere { radius: 1.0 }, even),
        3 => (Shape::Sphere { radius: 0.7 }, uneven),
        4..=6 => (
            Shape::Cuboid {
                min: DVec3::new(-0.5, -0.4, -0.6),
                max: DVec3::new(0.5, 0.6, 0.4),
            },
            uneven,
        ),
        7 => (
            Shape::Plane {
                normal: random.direction(),
                distance: -8.0,
            },
            DVec3::ONE,
        ),
        10 => (
            Shape::Disc {
                center: random.cube() * 0.3,
                normal: random.direction(),
                radius: 1.0,
            },
            uneven,
        ),
        11 | 12 => {
            // Cylinders, cones and what is between.
            let radius_a = random.range(0.2, 0.8);
            let radius_b = [radius_a, 0.0, random.range(0.1, 0.9)][random.below(3)];
            let (a, b) = (
                random.cube() * 0.5,
                random.cube() * 0.5 + random.direction() * 2.0,
            );
            let shape = Shape::Cone(Cone {
                a,
                radius_a,
                b,
                radius_b,
                open: radius_a < 0.4,
            });
            (shape, uneven)
        }
        13 | 14 => (
            Shape::Torus {
                major: 0.8,
                minor: random.range(0.05, 0.7),
            },
            uneven,
        ),
        8 | 9 => (Shape::Mesh(0), uneven * DVec3::new(-1.0, 1.0, 1.0)),
        _ => (Shape::Mesh(1), even),
    };
    Instance {
        tag: 0,
        shape,
        world_from_local: DAffine3::from_scale_rotation_translation(scale, turn, place),
        material: random.below(materials) as u32,
    }
}
