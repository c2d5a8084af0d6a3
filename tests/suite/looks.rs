//! Textures, colours of vertices, normal maps and holes: the tracers against each other, and against what is known.

use std::sync::Arc;

use glam::{DAffine3, DVec3, UVec2, Vec2, Vec3, Vec4};
use orrery_engine::frame::{
    Features, FrameScene, Instance, Light, LightKind, Shape, TraceSettings, View,
};
use orrery_engine::trace::cpu::CpuTracer;
use orrery_engine::trace::reference::ReferenceTracer;
use orrery_engine::trace::{Picture, Query, Ray, Tracer};
use orrery_engine::world::{ColorSpace, Material, MeshData, Texture, TextureId, Wrap};
use orrery_tests::metrics::compare_pictures;
use orrery_tests::random_looks::{Looks, random_looks};
use orrery_tests::random_scene::{Random, random_scene};
use orrery_tests::tracers::picture;

use crate::gpu;

fn settings(width: u32, height: u32) -> TraceSettings {
    TraceSettings {
        size: UVec2::new(width, height),
        ..Default::default()
    }
}

fn traced(tracer: &mut dyn Tracer, scene: &FrameScene, size: [u32; 2]) -> Picture {
    picture(tracer, scene, &settings(size[0], size[1])).expect("a picture")
}

/// Pixels off by more than 1/255, per million, over a few seeds.
fn apart(first: &mut dyn Tracer, second: &mut dyn Tracer, looks: Looks, seeds: u32) -> f64 {
    let count = f64::from(seeds);
    let mut ppm = 0.0;
    for seed in 0..seeds {
        let scene = random_looks(seed.into(), looks);
        let a = traced(first, &scene, [96, 72]);
        let b = traced(second, &scene, [96, 72]);
        let metrics = compare_pictures(&a, &b);
        assert_eq!(metrics.non_finite, 0, "seed {seed}, {looks:?}");
        ppm += metrics.mismatch_ppm / count;
    }
    ppm
}

#[test]
fn cpu_and_reference_see_the_same_looks() {
    for looks in Looks::ALL {
        let ppm = apart(&mut CpuTracer::new(), &mut ReferenceTracer::new(), looks, 3);
        assert!(ppm < 1000.0, "{looks:?}: {ppm} ppm of the pixels differ");
    }
}

#[test]
fn gpu_and_cpu_see_the_same_looks() {
    for looks in Looks::ALL {
        let ppm = apart(&mut gpu::tracer(), &mut CpuTracer::new(), looks, 1);
        assert!(ppm < 1000.0, "{looks:?}: {ppm} ppm of the pixels differ");
    }
}

#[test]
fn rays_pass_the_same_holes_in_all_tracers() {
    let scene = random_looks(5, Looks::ALL[3]);
    let mut random = Random::new(17);
    let rays: Vec<Ray> = (0..20_000)
        .map(|_| Ray {
            origin: (random.cube() * 4.0 - DVec3::new(0.0, 1.0, 9.0)).as_vec3(),
            dir: random.direction().as_vec3(),
            t_min: 0.0,
            t_max: f32::MAX,
        })
        .collect();
    let answers = |tracer: &mut dyn Tracer, query| {
        tracer.refit(&scene).expect("refits");
        tracer.upload(&scene, &settings(1, 1)).expect("uploads");
        tracer.intersect(&rays, query).expect("answers")
    };
    for query in [Query::Closest, Query::Any] {
        let cpu = answers(&mut CpuTracer::new(), query);
        let others: [&mut dyn Tracer; 2] = [&mut gpu::tracer(), &mut ReferenceTracer::new()];
        for tracer in others {
            let found = answers(tracer, query);
            let pairs = found.iter().zip(&cpu);
            let differ = pairs
                .filter(|(a, b)| (a.instance, a.prim) != (b.instance, b.prim))
                .count();
            assert!(differ <= 4, "{differ} of {} rays differ", rays.len());
        }
    }
}

#[test]
fn textures_that_nobody_shows_change_no_bit() {
    for seed in 0..2 {
        let plain = random_scene(seed, 30);
        let mut stocked = random_looks(seed, Looks::ALL[4]);
        stocked.instances = plain.instances.clone();
        stocked.meshes = plain.meshes.clone();
        stocked.features = Features::of(&stocked);
        assert_eq!(stocked.features, plain.features);
        for mut tracer in [
            Box::new(gpu::tracer()) as Box<dyn Tracer>,
            Box::new(CpuTracer::new()),
            Box::new(ReferenceTracer::new()),
        ] {
            let before = traced(&mut *tracer, &plain, [64, 48]);
            let after = traced(&mut *tracer, &stocked, [64, 48]);
            assert!(before.pixels == after.pixels, "{}", tracer.backend());
        }
    }
}

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
