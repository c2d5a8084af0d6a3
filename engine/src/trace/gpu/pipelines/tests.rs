//! What stands in while a kernel is compiled, and for how long.

use super::*;
use crate::frame::{Features, FrameScene, TraceSettings};
use crate::trace::gpu::GpuTracer;
use crate::trace::gpu::tests::{open, picture, scene, settings};
use crate::trace::{Picture, Tracer};
use crate::world::Material;

fn glassy() -> FrameScene {
    let mut scene = scene(30, 20);
    scene.materials.edit(|material: &mut Material| {
        material.transmit = 0.6;
        material.ior = 1.3;
    });
    scene.features = Features::of(&scene);
    assert!(scene.features.transmission);
    scene
}

/// Waits for the thread.
fn settle(pipelines: &mut Pipelines) {
    let is_busy = |pipelines: &Pipelines| {
        let background = pipelines.background.as_ref();
        background.is_some_and(|background| !background.ordered.is_empty())
    };
    while is_busy(pipelines) {
        std::thread::sleep(std::time::Duration::from_millis(5));
        pipelines.take_answers();
    }
}

fn largest_difference(a: &Picture, b: &Picture) -> f32 {
    let pairs = a.pixels.iter().zip(&b.pixels);
    let differences = pairs.map(|(a, b)| (a - b).abs().max_element());
    differences.fold(0.0, f32::max)
}

#[test]
fn an_edit_that_adds_glass_is_traced_with_the_general_kernel_until_its_own_is_there() {
    let (plain, glass, settings): (_, _, TraceSettings) = (scene(30, 20), glassy(), settings(48));
    let mut waiting = GpuTracer::new(open()).expect("a tracer");
    let expected =
        [&plain, &glass].map(|scene| picture(&mut waiting, scene, &settings).expect("a picture"));
    let mut tracer = GpuTracer::new(open()).expect("a tracer");
    tracer.compile_in_background();
    let first = picture(&mut tracer, &plain, &settings).expect("a picture");
    assert!(
        first == expected[0],
        "the first picture waits for its own kernel"
    );
    settle(&mut tracer.pipelines);
    assert_eq!(
        tracer.pipelines.compiled.len(),
        2,
        "its own and the general one"
    );
    let meanwhile = picture(&mut tracer, &glass, &settings).expect("a picture");
    let off = largest_difference(&meanwhile, &expected[1]);
    assert!(off <= 1.5e-5, "{off}");
    settle(&mut tracer.pipelines);
    assert_eq!(tracer.pipelines.compiled.len(), 3);
    let back = picture(&mut tracer, &plain, &settings).expect("a picture");
    assert!(back == expected[0]);
    let own = picture(&mut tracer, &glass, &settings).expect("a picture");
    assert!(own == expected[1], "its own kernel is there and not used");
}

/// It is told once, and what stood in goes on.
#[test]
fn what_cannot_be_compiled_is_not_tried_again_and_again() {
    // SAFETY: it has no loop, nor anything else.
    #[allow(unsafe_code)]
    let broken = unsafe { HandKernel::new("broken.wgsl", "this is no shader") };
    let gpu = open();
    let layouts = Layouts::new(&gpu);
    let mut pipelines = Pipelines::default();
    pipelines.compile_in_background(&gpu);
    let [little, more] =
        [Features::default(), Features::all()].map(|features| Specialisation::new(features, 4));
    let get = |pipelines: &mut Pipelines, special| {
        pipelines.get(&gpu, &layouts, Kernel::Whitted, special)
    };
    let general = get(&mut pipelines, more).expect("compiles");
    pipelines.by_hand = Some(broken);
    assert!(get(&mut pipelines, little).is_err(), "nothing stands in");
    let key = (Kernel::Whitted, more, Some(broken));
    pipelines.compiled.insert(key, general.clone());
    for _ in 0..3 {
        let meanwhile = get(&mut pipelines, little).expect("stands in");
        assert!(meanwhile.compute == general.compute);
        settle(&mut pipelines);
    }
    let background = pipelines.background.as_ref().expect("a thread");
    assert_eq!(background.refused.len(), 1);
    assert!(background.ordered.is_empty());
}

#[test]
fn a_compiler_that_panics_refuses_one_shader() {
    let error = held::<()>(|| panic!("as a broken driver's might"));
    assert!(matches!(error, Err(TraceError::Device(why)) if why.contains("panicked")));
    assert_eq!(held(|| Ok(3)), Ok(3));
}

#[test]
fn of_kernels_that_will_do_the_one_with_least_is_taken() {
    let gpu = open();
    let layouts = Layouts::new(&gpu);
    let mut pipelines = Pipelines::default();
    pipelines.compile_in_background(&gpu);
    let get = |pipelines: &mut Pipelines, features: Features| {
        let special = Specialisation::new(features, 4);
        let pipeline = pipelines.get(&gpu, &layouts, Kernel::Intersect, special);
        pipeline.expect("compiles").compute
    };
    let spheres = Features {
        spheres: true,
        ..Features::default()
    };
    let both = Features {
        cuboids: true,
        ..spheres
    };
    let all = get(&mut pipelines, Features::all());
    let meanwhile = get(&mut pipelines, both);
    assert!(meanwhile == all, "nothing else is there");
    settle(&mut pipelines);
    let own = get(&mut pipelines, both);
    assert!(own != all);
    assert!(get(&mut pipelines, spheres) == own, "less than all will do");
    settle(&mut pipelines);
    assert!(get(&mut pipelines, spheres) != own);
    // Without a thread nothing stands in.
    let mut waiting = Pipelines::default();
    let all = get(&mut waiting, Features::all());
    assert!(get(&mut waiting, both) != all);
}
