//! How light falls off, where it is known, in all three tracers.

use glam::{DAffine3, DVec3, Vec3};
use orrery_engine::frame::{Features, FrameScene, Instance, Light, LightKind, Shape, View};
use orrery_engine::trace::Tracer;
use orrery_engine::trace::cpu::CpuTracer;
use orrery_engine::trace::reference::ReferenceTracer;
use orrery_engine::world::{Fade, Material};

use crate::gpu;
use crate::looks::traced;

/// What a white wall gives back that a light shines on from so far in front of it.
fn lit(tracer: &mut dyn Tracer, fade: Fade, distance: f64) -> Vec3 {
    let matte = Material {
        color: Vec3::ONE,
        diffuse: 1.0,
        ..Material::default()
    };
    let wall = Shape::Plane {
        normal: DVec3::Z,
        distance: 0.0,
    };
    let position = DVec3::Z * distance;
    let mut scene = FrameScene {
        max_generations: 1,
        materials: vec![matte].into(),
        instances: vec![Instance {
            tag: 0,
            shape: wall,
            world_from_local: DAffine3::IDENTITY,
            material: 0,
        }]
        .into(),
        lights: vec![Light {
            color: Vec3::new(1.0, 0.5, 0.25),
            fade: Some(fade),
            kind: LightKind::Point { position },
        }]
        .into(),
        view: View {
            origin: DVec3::Z,
            ..View::default()
        },
        ..FrameScene::default()
    };
    scene.features = Features::of(&scene);
    traced(tracer, &scene, [1, 1]).pixels[0]
}

#[test]
fn light_falls_off_as_the_formulas_say() {
    let exact = Fade::exact(1.0, 2.0);
    let ranged = Fade {
        range: Some(4.0),
        ..exact
    };
    let soft = Fade {
        distance: 2.0,
        ..Fade::default()
    };
    let cases = [
        (exact, 0.5, 4.0),
        (exact, 5.0, 1.0 / 25.0),
        (exact, 1e-7, 1e8),
        (Fade::exact(1.0, 1.0), 4.0, 0.25),
        (Fade::exact(2.0, 3.0), 4.0, 0.125),
        (ranged, 2.0, 0.25 * (1.0 - 1.0 / 16.0)),
        (ranged, 4.0, 0.0),
        (ranged, 40.0, 0.0),
        (soft, 2.0, 1.0),
        (soft, 4.0, 0.4),
    ];
    let tracers: [Box<dyn Tracer>; 3] = [
        Box::new(gpu::tracer()),
        Box::new(CpuTracer::new()),
        Box::new(ReferenceTracer::new()),
    ];
    for mut tracer in tracers {
        for (fade, distance, expected) in cases {
            let seen = lit(&mut *tracer, fade, distance);
            let expected = Vec3::new(1.0, 0.5, 0.25) * expected;
            let off = (seen - expected).abs().max_element();
            let within = 1e-5 * expected.x.max(1e-3);
            assert!(
                off <= within,
                "{}: {fade:?}, {distance}: {seen}",
                tracer.backend()
            );
        }
    }
}
