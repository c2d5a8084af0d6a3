//! The classes of scenes: some that come along, some made here, each as two frames that follow each other.

use std::path::Path;

use glam::{DAffine3, DVec3, UVec2, Vec3};
use orrery_engine::frame::{
    Features, FrameScene, Instance, Light, LightKind, Shape, View, ViewProjection,
};
use orrery_engine::world::{Lobe, Material, MeshRow, Reflection};

use crate::args::{BenchRequest, Common};
use crate::bench::frame::FRAMES_PER_SEC;
use crate::bench::hills::hills;
use crate::failure::Failure;
use crate::stage;

/// How far the far class is from the origin, along each axis.
const FAR: f64 = 1e7;
/// Radius of the huge class's ground.
const HUGE: f64 = 1e6;

/// A class.
pub struct Class {
    /// As rows and charts call it.
    pub name: &'static str,
    /// What it holds.
    pub about: &'static str,
    /// The measured frame and another one.
    pub frames: [FrameScene; 2],
}

/// All classes.
pub fn all(request: &BenchRequest, common: &Common) -> Result<Vec<Class>, Failure> {
    let scene = |name, about, file: &str| {
        file_frames(file, request.frame, common).map(|frames| Class {
            name,
            about,
            frames,
        })
    };
    let levels = if request.small { 1 } else { 3 };
    let triangles = if request.small { 200 } else { 8192 };
    let made = |name, about, base: FrameScene| Class {
        name,
        about,
        frames: stepped(base),
    };
    let plain = scene(
        "plain",
        "21 mirror balls of the report's kind",
        "mirrors_21",
    )?;
    let far = Class {
        name: "far",
        about: "the plain class, 10,000,000 units from the origin",
        frames: plain.frames.clone().map(moved),
    };
    let mount = mount(triangles).map_err(Failure::Input)?;
    Ok(vec![
        plain,
        scene("glass", "36 balls, half of them of glass", "spheres_36")?,
        scene(
            "gears",
            "the demo: gears, glass, mirrors, three lights",
            "demo",
        )?,
        made(
            "balls",
            "a sphereflake of 820 mirror balls after Haines's SPD",
            balls(levels),
        ),
        made(
            "mount",
            "a height field of 8,192 triangles and four glass balls",
            mount,
        ),
        far,
        made(
            "huge",
            "balls on a ground that is a ball of radius 1,000,000",
            huge(),
        ),
        scene("deforming", "a wolf, a cloth and columns, deformed", "wolf")?,
    ])
}

fn file_frames(scene: &str, frame: u64, common: &Common) -> Result<[FrameScene; 2], Failure> {
    let mut engine = stage::set(Path::new(scene), common, UVec2::ONE, FRAMES_PER_SEC)?;
    let mut at = |frame| {
        stage::advance(&mut engine, frame)?;
        Ok::<_, Failure>(engine.world.resource::<FrameScene>().clone())
    };
    Ok([at(frame)?, at(frame + 1)?])
}

/// The same world elsewhere.
fn moved(mut scene: FrameScene) -> FrameScene {
    let shift = DVec3::splat(FAR);
    scene.view.origin += shift;
    scene
        .instances
        .edit(|instance| instance.world_from_local.translation += shift);
    scene.lights.edit(|light| match &mut light.kind {
        LightKind::Point { position } | LightKind::Spot { position, .. } => *position += shift,
        LightKind::Directional { .. } => {}
    });
    scene
}

/// A frame and the next, a step to the side.
fn stepped(scene: FrameScene) -> [FrameScene; 2] {
    let mut next = scene.clone();
    next.view.origin += next.view.right.normalize_or_zero() * 0.01;
    [scene, next]
}

/// Seen from a point, 45 degrees high, four to three.
fn seen(eye: DVec3, at: DVec3, up: DVec3) -> View {
    let forward = (at - eye).normalize();
    let right = forward.cross(up).normalize();
    let height = 2.0 * 22.5_f64.to_radians().tan();
    View {
        origin: eye,
        forward,
        right: right * (height * 4.0 / 3.0),
        up: right.cross(forward) * height,
        projection: ViewProjection::Perspective,
        ..View::default()
    }
}

struct Builder(FrameScene);

impl Builder {
    fn new(view: View, background: Vec3, lights: &[(DVec3, f32)]) -> Self {
        let light = |&(position, brightness): &(DVec3, f32)| Light {
            color: Vec3::splat(brightness),
            fade: None,
            kind: LightKind::Point { position },
        };
        Self(FrameScene {
            view,
            background: background.into(),
            max_generations: 6,
            lights: lights.iter().map(light).collect::<Vec<_>>().into(),
            materials: vec![Material::default()].into(),
            ..FrameScene::default()
        })
    }

    fn material(&mut self, material: Material) -> u32 {
        self.0.materials.push(material)
    }

    fn add(&mut self, shape: Shape, at: DVec3, material: u32) {
        self.0.instances.push(Instance {
            tag: 0,
            shape,
            world_from_local: DAffine3::from_translation(at),
            material,
        });
    }

    fn done(mut self) -> FrameScene {
        self.0.features = Features::of(&self.0);
        self.0
    }
}

fn matt(color: [f32; 3]) -> Material {
    Material {
        color: color.into(),
        diffuse: 0.8,
        ..Material::default()
    }
}

fn mirror(color: [f32; 3], share: f32) -> Material {
    Material {
        diffuse: 0.5,
        specular: Some(Lobe {
            strength: 0.5,
            exponent: 30.0,
        }),
        reflection: Reflection::Constant(Vec3::splat(share)),
        ..matt(color)
    }
}

fn glass() -> Material {
    Material {
        color: Vec3::ONE,
        diffuse: 0.0,
        transmit: 1.0,
        ior: 1.5,
        reflection: Reflection::Fresnel,
        ..Material::default()
    }
}

/// Haines's sphereflake ("A Proposal for Standard Graphics Environments", 1987): nine balls of a third of the radius on
/// each ball, so many times.
fn balls(levels: u32) -> FrameScene {
    let view = seen(DVec3::new(2.1, 1.3, 1.7), DVec3::ZERO, DVec3::Z);
    let lights = [(4.0, 3.0, 2.0), (1.0, -4.0, 4.0), (-3.0, 1.0, 5.0)];
    let lights = lights.map(|(x, y, z)| (DVec3::new(x, y, z), 0.5));
    let mut scene = Builder::new(view, Vec3::new(0.078, 0.361, 0.753), &lights);
    let floor = scene.material(matt([1.0, 0.75, 0.33]));
    let ball = scene.material(mirror([1.0, 0.9, 0.7], 0.5));
    let ground = Shape::Plane {
        normal: DVec3::Z,
        distance: -0.5,
    };
    scene.add(ground, DVec3::ZERO, floor);
    flake(&mut scene, ball, levels, DVec3::ZERO, DVec3::Z, 0.5);
    scene.done()
}

fn flake(scene: &mut Builder, ball: u32, levels: u32, at: DVec3, up: DVec3, radius: f64) {
    scene.add(Shape::Sphere { radius }, at, ball);
    if levels == 0 {
        return;
    }
    let (x, y) = up.any_orthonormal_pair();
    // Six around the middle, tilted to fit three above.
    let ring = |count: u32, first: f64, height: f64| {
        (0..count).map(move |i| {
            let angle = first + f64::from(i) / f64::from(count) * std::f64::consts::TAU;
            let aside = (1.0 - height * height).sqrt();
            (x * angle.cos() + y * angle.sin()) * aside + up * height
        })
    };
    for out in ring(6, 0.0, 0.0).chain(ring(3, std::f64::consts::FRAC_PI_6, 0.8165)) {
        let child = at + out * (radius * 4.0 / 3.0);
        flake(scene, ball, levels - 1, child, out, radius / 3.0);
    }
}

/// A rough field under four balls of glass.
fn mount(triangles: usize) -> Result<FrameScene, String> {
    let view = seen(DVec3::new(-1.6, 1.0, 1.84), DVec3::ZERO, DVec3::Y);
    let mut scene = Builder::new(
        view,
        Vec3::new(0.1, 0.15, 0.3),
        &[(DVec3::new(-10.0, 10.0, 10.0), 0.9)],
    );
    let rock = scene.material(matt([0.6, 0.5, 0.35]));
    let clear = scene.material(glass());
    scene.0.meshes.push(MeshRow::from(hills(triangles)?));
    let field = DAffine3::from_scale_rotation_translation(
        DVec3::new(3.0, 6.0, 3.0),
        glam::DQuat::IDENTITY,
        DVec3::new(-1.5, -0.6, -1.5),
    );
    scene.0.instances.push(Instance {
        tag: 0,
        shape: Shape::Mesh(0),
        world_from_local: field,
        material: rock,
    });
    for (i, radius) in [0.3, 0.2, 0.25, 0.35].into_iter().enumerate() {
        let at = DVec3::new(0.5 * i as f64 - 0.9, 0.1 + radius, 0.3 - 0.2 * i as f64);
        scene.add(Shape::Sphere { radius }, at, clear);
    }
    Ok(scene.done())
}

/// Small things on the top of something huge.
fn huge() -> FrameScene {
    let view = seen(
        DVec3::new(0.0, 2.0, 6.0),
        DVec3::new(0.0, 0.7, 0.0),
        DVec3::Y,
    );
    let lights = [
        (DVec3::new(3.0, 5.0, 4.0), 0.8),
        (DVec3::new(-5.0, 4.0, 3.0), 0.2),
    ];
    let mut scene = Builder::new(view, Vec3::new(0.1, 0.15, 0.25), &lights);
    let ground = scene.material(matt([0.7, 0.7, 0.65]));
    let metal = scene.material(mirror([0.4, 0.4, 0.45], 0.6));
    let red = scene.material(matt([0.8, 0.3, 0.2]));
    scene.add(
        Shape::Sphere { radius: HUGE },
        DVec3::new(0.0, -HUGE, 0.0),
        ground,
    );
    for (i, radius) in [1.0, 0.5, 0.1, 0.01].into_iter().enumerate() {
        let at = DVec3::new(1.2 * i as f64 - 1.6, radius, 0.4 * i as f64);
        let material = if i % 2 == 0 { metal } else { red };
        scene.add(Shape::Sphere { radius }, at, material);
    }
    scene.done()
}
