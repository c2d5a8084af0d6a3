//! Looks of surfaces and of the sky where what is seen is known, in all three tracers.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use orrery_engine::frame::{Features, FrameScene, Instance, Light, LightKind, Shape, View};
use orrery_engine::trace::Tracer;
use orrery_engine::trace::cpu::CpuTracer;
use orrery_engine::trace::reference::ReferenceTracer;
use orrery_engine::world::{Background, ColorSpace, Material, MeshData, Texture, TextureId, Wrap};
use orrery_tests::random_scene::smooth_icosphere;

use crate::gpu;
use crate::looks::traced;

/// A unit square from the origin to (1, 1), upright, its texture the right way up, in this material.
fn square(material: Material, textures: Vec<Texture>, colors: Vec<Vec4>) -> FrameScene {
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let vertices = corners.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec();
    let uvs = corners
        .map(|(x, y)| Vec2::new(x as f32, 1.0 - y as f32))
        .to_vec();
    let mesh = MeshData::new("square", vertices, Vec::new(), vec![[0, 1, 2], [0, 2, 3]]);
    let mesh = mesh.and_then(|mesh| mesh.with_looks(uvs, colors));
    let mut scene = FrameScene {
        max_generations: 4,
        materials: vec![material].into(),
        textures: textures.into_iter().map(Arc::new).collect(),
        meshes: vec![mesh.expect("a square").into()].into(),
        instances: vec![Instance {
            tag: 0,
            shape: Shape::Mesh(0),
            world_from_local: DAffine3::IDENTITY,
            material: 0,
        }]
        .into(),
        view: View {
            origin: DVec3::new(0.5, 0.5, 4.0),
            forward: DVec3::NEG_Z,
            right: DVec3::X / 4.0,
            up: DVec3::Y / 4.0,
            ..View::default()
        },
        ..FrameScene::default()
    };
    scene.features = Features::of(&scene);
    scene
}

/// Grey texels of linear numbers.
fn ramp(size: [u32; 2], bytes: &[[u8; 4]]) -> Texture {
    let texture = Texture::new(
        "ramp",
        size,
        bytes.as_flattened(),
        ColorSpace::Linear,
        Wrap::Clamp,
    );
    texture.expect("a texture")
}

fn tracers() -> [Box<dyn Tracer>; 3] {
    [
        Box::new(gpu::tracer()),
        Box::new(CpuTracer::new()),
        Box::new(ReferenceTracer::new()),
    ]
}

#[test]
fn a_texture_is_seen_texel_by_texel_the_right_way_up() {
    let texels: Vec<[u8; 4]> = (0..16_u8).map(|i| [i * 16, 255 - i, i, 255]).collect();
    let glow = Material {
        color: Vec3::new(1.0, 0.5, 2.0),
        diffuse: 0.0,
        emission: 1.0,
        color_map: Some(TextureId(0)),
        ..Material::default()
    };
    let scene = square(glow, vec![ramp([4, 4], &texels)], Vec::new());
    for mut tracer in tracers() {
        // Three pixels a texel, so that nothing is averaged; the middle ones see texels' centres.
        let seen = traced(&mut *tracer, &scene, [12, 12]);
        for (i, texel) in texels.iter().enumerate() {
            let pixel = seen.pixels[(i / 4 * 3 + 1) * 12 + i % 4 * 3 + 1];
            let [r, g, b, _] = texel.map(|byte| f32::from(byte) / 255.0);
            let expected = Vec3::new(r, 0.5 * g, 2.0 * b);
            let off = (pixel - expected).abs().max_element();
            assert!(off < 2e-5, "{}: {pixel} for {expected}", tracer.backend());
        }
    }
}

#[test]
fn colours_of_vertices_are_mixed() {
    let glow = Material {
        color: Vec3::ONE,
        diffuse: 0.0,
        emission: 1.0,
        ..Material::default()
    };
    let colors = [Vec4::ONE, Vec4::W, Vec4::W, Vec4::ONE].to_vec();
    let scene = square(glow, Vec::new(), colors);
    for mut tracer in tracers() {
        let seen = traced(&mut *tracer, &scene, [8, 8]);
        for (i, pixel) in seen.pixels.iter().enumerate() {
            let expected = 1.0 - ((i % 8) as f32 + 0.5) / 8.0;
            assert!((pixel.x - expected).abs() < 1e-5, "{}", tracer.backend());
        }
    }
}

/// Behind a textured square, so that textures are compiled in: one with colours alone, in the same material.
#[test]
fn pictures_do_not_show_where_there_are_no_coordinates() {
    let glow = Material {
        color: Vec3::ONE,
        diffuse: 0.0,
        emission: 1.0,
        color_map: Some(TextureId(0)),
        normal_map: Some(TextureId(0)),
        alpha_cutoff: Some(0.25),
        ..Material::default()
    };
    let dark = ramp([1, 1], &[[60, 120, 30, 50]]);
    let mut scene = square(glow, vec![dark], Vec::new());
    let textured = scene.meshes[0].data.as_ref().clone();
    let bare = MeshData {
        uvs: Vec::new(),
        ..textured
    };
    let colors = vec![Vec4::new(0.5, 1.0, 0.75, 0.5); 4];
    let bare = bare
        .with_looks(Vec::new(), colors)
        .expect("colours that fit");
    scene.meshes.push(bare.into());
    let mut behind = scene.instances[0];
    behind.shape = Shape::Mesh(1);
    behind.world_from_local = DAffine3::from_translation(DVec3::NEG_Z * 1e-3);
    scene.instances.push(behind);
    scene.features = Features::of(&scene);
    assert!(scene.features.textures && scene.features.cutouts);
    for mut tracer in tracers() {
        // The square in front has an alpha of 50 / 255 everywhere, so it is not there.
        let seen = traced(&mut *tracer, &scene, [4, 4]).pixels[5];
        let off = (seen - Vec3::new(0.5, 1.0, 0.75)).abs().max_element();
        assert!(off < 1e-5, "{}: {seen}", tracer.backend());
    }
}

/// The square as a floor with a copy of it above, whose right half is a hole; a light above, the eye between.
#[test]
fn holes_let_light_through() {
    let matte = Material {
        color: Vec3::ONE,
        diffuse: 1.0,
        color_map: Some(TextureId(0)),
        alpha_cutoff: Some(0.5),
        ..Material::default()
    };
    let leaf = ramp([2, 1], &[[255; 4], [255, 255, 255, 0]]);
    let mut scene = square(matte, vec![leaf], Vec::new());
    scene.materials.push(Material {
        color_map: None,
        alpha_cutoff: None,
        ..matte
    });
    let mut floor = scene.instances[0];
    floor.material = 1;
    floor.world_from_local = DAffine3::from_translation(DVec3::NEG_Z);
    scene.instances.push(floor);
    scene.lights.push(Light {
        color: Vec3::ONE,
        fade: None,
        kind: LightKind::Directional { to_light: DVec3::Z },
    });
    scene.view.origin.z = -0.5;
    (scene.view.right, scene.view.up) = (DVec3::X * 2.0, DVec3::Y * 2.0);
    scene.features = Features::of(&scene);
    for mut tracer in tracers() {
        let seen = traced(&mut *tracer, &scene, [8, 8]);
        for (i, pixel) in seen.pixels.iter().enumerate() {
            let expected = if i % 8 < 4 { 0.0 } else { 1.0 };
            assert!(
                (pixel.x - expected).abs() < 1e-5,
                "{} {i}",
                tracer.backend()
            );
        }
    }
}

/// Red is to the right and green up, whichever way the instance is mirrored, and a dent from behind.
#[test]
fn normal_maps_tilt_to_the_right_and_up() {
    let lit = |texel: [u8; 3], to_light: DVec3, pose: DAffine3, from_behind: bool| {
        let matte = Material {
            color: Vec3::ONE,
            diffuse: 1.0,
            normal_map: Some(TextureId(0)),
            ..Material::default()
        };
        let [r, g, b] = texel;
        let mut scene = square(matte, vec![ramp([1, 1], &[[r, g, b, 255]])], Vec::new());
        scene
            .instances
            .edit(|instance| instance.world_from_local = pose);
        scene.lights.push(Light {
            color: Vec3::ONE,
            fade: None,
            kind: LightKind::Directional {
                to_light: to_light.normalize(),
            },
        });
        if from_behind {
            scene.view.origin.z = -4.0;
            scene.view.forward = DVec3::Z;
        }
        scene.features = Features::of(&scene);
        tracers().map(|mut tracer| traced(&mut *tracer, &scene, [1, 1]).pixels[0].x)
    };
    let [right, up] = [[218, 128, 218], [128, 218, 218]];
    let plain = DAffine3::IDENTITY;
    let mirrored =
        DAffine3::from_translation(DVec3::X) * DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let (from_right, from_above) = (DVec3::new(1.0, 0.0, 1.0), DVec3::new(0.0, 1.0, 1.0));
    for seen in [
        lit(right, from_right, plain, false),
        lit(up, from_above, plain, false),
        lit(up, from_above, mirrored, false),
        lit(
            right,
            from_right * DVec3::new(-1.0, 1.0, 1.0),
            mirrored,
            false,
        ),
        // What stands out on one side is a dent on the other.
        lit(right, from_right * -1.0, plain, true),
    ] {
        assert!(seen.iter().all(|&x| x > 0.99), "{seen:?}");
    }
    let away = lit(right, from_right * DVec3::new(-1.0, 1.0, 1.0), plain, false);
    assert!(away.iter().all(|&x| x < 0.05), "{away:?}");
}

/// Two units of glass that bends nothing, before a background of 1 and over a lit wall.
#[test]
fn glass_takes_light_away_by_the_length_within() {
    let absorption = Vec3::new(0.1, 0.5, 0.0);
    let glass = Material {
        color: Vec3::ONE,
        diffuse: 0.0,
        transmit: 1.0,
        absorption,
        ..Material::default()
    };
    let instance = |shape, material| Instance {
        tag: 0,
        shape,
        world_from_local: DAffine3::IDENTITY,
        material,
    };
    let slab = Shape::Cuboid {
        min: DVec3::new(-9.0, -9.0, 0.0),
        max: DVec3::new(9.0, 9.0, 2.0),
    };
    let wall = Shape::Plane {
        normal: DVec3::Z,
        distance: -2.0,
    };
    let matte = Material {
        color: Vec3::ONE,
        diffuse: 1.0,
        ..Material::default()
    };
    let mut scene = square(glass, Vec::new(), Vec::new());
    scene.materials.push(matte);
    scene.instances = vec![instance(slab, 0)].into();
    scene.background = Vec3::ONE.into();
    scene.features = Features::of(&scene);
    let mut shaded = scene.clone();
    shaded.instances.push(instance(wall, 1));
    shaded.lights.push(Light {
        color: Vec3::ONE,
        fade: None,
        kind: LightKind::Directional { to_light: DVec3::Z },
    });
    shaded.view.origin.z = -1.0;
    shaded.features = Features::of(&shaded);
    let expected = (absorption * -2.0).exp();
    for mut tracer in tracers() {
        for scene in [&scene, &shaded] {
            let seen = traced(&mut *tracer, scene, [1, 1]).pixels[0];
            let off = (seen - expected).abs().max_element();
            assert!(off < 1e-5, "{}: {seen} for {expected}", tracer.backend());
        }
    }
}

#[test]
fn a_sky_goes_from_the_horizon_to_the_zenith_and_the_ground() {
    let background = Background {
        zenith: Vec3::new(0.0, 0.0, 1.0),
        horizon: Vec3::ONE,
        ground: Vec3::new(0.5, 0.0, 0.0),
        ..Background::default()
    };
    let mut scene = FrameScene {
        background,
        max_generations: 1,
        ..FrameScene::default()
    };
    scene.features = Features::of(&scene);
    for (up, expected) in [
        (1.0, background.zenith),
        (0.6, Vec3::new(0.4, 0.4, 1.0)),
        (0.0, Vec3::ONE),
        (-0.5, Vec3::new(0.75, 0.5, 0.5)),
        (-1.0, background.ground),
    ] {
        let level = f64::sqrt(1.0 - up * up);
        scene.view.forward = DVec3::new(level, up, 0.0);
        for mut tracer in tracers() {
            let seen = traced(&mut *tracer, &scene, [1, 1]).pixels[0];
            let off = (seen - expected).abs().max_element();
            assert!(off < 1e-5, "{}: {seen} for {expected}", tracer.backend());
        }
    }
}

/// A coarse ball lit from the side: flat triangles put parts of it into their own shadow that a ball has in the light.
#[test]
fn curved_meshes_do_not_shade_themselves_at_the_terminator() {
    let in_wrong_shadow = |curved: bool| {
        let mut ball = smooth_icosphere(1);
        ball.curved = curved;
        let matte = Material {
            color: Vec3::ONE,
            diffuse: 1.0,
            ..Material::default()
        };
        let mut scene = square(matte, Vec::new(), Vec::new());
        scene.meshes = vec![ball.into()].into();
        let to_light = DVec3::new(1.0, 0.1, 0.15).normalize();
        scene.lights.push(Light {
            color: Vec3::ONE,
            fade: None,
            kind: LightKind::Directional { to_light },
        });
        scene.view = View {
            origin: DVec3::Z * 40.0,
            right: DVec3::X * 0.05,
            up: DVec3::Y * 0.05,
            ..View::default()
        };
        scene.features = Features::of(&scene);
        tracers().map(|mut tracer| {
            let seen = traced(&mut *tracer, &scene, [64, 64]);
            let lit = |i: usize| {
                let x = ((i % 64) as f64 + 0.5) / 32.0 - 1.0;
                let y = 1.0 - ((i / 64) as f64 + 0.5) / 32.0;
                let z = (1.0 - x * x - y * y).max(0.0).sqrt();
                let is_on_ball = x * x + y * y < 0.8;
                is_on_ball && DVec3::new(x, y, z).dot(to_light) > 0.1
            };
            let dark = |i: &usize| lit(*i) && seen.pixels[*i].x < 0.02;
            (0..64 * 64).filter(dark).count()
        })
    };
    let (flat, curved) = (in_wrong_shadow(false), in_wrong_shadow(true));
    assert!(flat.iter().all(|&count| count > 20), "{flat:?}");
    assert!(curved.iter().all(|&count| count <= 2), "{curved:?}");
}

#[test]
fn a_panorama_is_round_and_turns() {
    let light = |i: u32| Vec3::new((i % 8) as f32, (i / 8) as f32 * 100.0, 0.25);
    let texels: Vec<Vec3> = (0..32).map(light).collect();
    let sky = Texture::radiance("sky", [8, 4], &texels).expect("a sky");
    let mut scene = FrameScene {
        textures: vec![Arc::new(sky)].into(),
        background: Background {
            picture: Some(TextureId(0)),
            ..Vec3::ONE.into()
        },
        max_generations: 1,
        ..FrameScene::default()
    };
    scene.features = Features::of(&scene);
    for turned in [0, 3] {
        // A quarter and more to the left.
        scene.background.turn = f64::from(turned).to_radians() * 45.0;
        for i in 0..32 {
            let (column, row) = (f64::from(i % 8), f64::from(i / 8));
            let around = ((column + 0.5) / 8.0 - 0.5) * std::f64::consts::TAU;
            let around = around - scene.background.turn;
            let up = (0.5 - (row + 0.5) / 4.0) * std::f64::consts::PI;
            let level = up.cos();
            scene.view.forward = DVec3::new(level * around.sin(), up.sin(), -level * around.cos());
            for mut tracer in tracers() {
                let seen = traced(&mut *tracer, &scene, [1, 1]).pixels[0];
                let off = (seen - light(i)).abs().max_element();
                assert!(off < 0.02, "{}: {seen} for {}", tracer.backend(), light(i));
            }
        }
    }
}
