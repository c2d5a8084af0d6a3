//! Every shader composes and validates for every scene, without a GPU.

use orrery_engine::frame::{Features, Kernels};
use orrery_engine::trace::gpu::{Kernel, Specialisation, shader_source};

/// Number of switches in [`Features`].
const SWITCHES: u32 = 24;

/// The features whose bits are set.
fn features(bits: u32) -> Features {
    let bit = |i: u32| bits >> i & 1 == 1;
    Features {
        reflection: bit(0),
        transmission: bit(1),
        meshes: bit(2),
        spheres: bit(3),
        planes: bit(4),
        cuboids: bit(5),
        smooth_normals: bit(6),
        spot_lights: bit(7),
        directional_lights: bit(8),
        fade: bit(9),
        sphere_trees: bit(10),
        discs: bit(11),
        cones: bit(12),
        tori: bit(13),
        open_cones: bit(14),
        textures: bit(15),
        normal_maps: bit(16),
        vertex_colors: bit(17),
        cutouts: bit(18),
        absorption: bit(19),
        curved: bit(20),
        sky: bit(21),
        panorama: bit(22),
        instances: bit(23),
    }
}

fn compose(kernel: Kernel, features: Features, generations: u32) {
    let special = Specialisation::new(features, generations);
    if let Err(why) = shader_source(kernel, special) {
        panic!("{kernel:?} with {features:?}:\n{why}");
    }
}

#[test]
fn pictures_compose_for_each_mix_of_shapes_and_rays() {
    let all = (1 << SWITCHES) - 1;
    assert_eq!(features(all), Features::all());
    for bits in 0..1 << 6 {
        compose(Kernel::Whitted, features(bits), 8);
    }
}

#[test]
fn pictures_compose_with_each_feature_alone_and_with_each_missing() {
    let all = (1 << SWITCHES) - 1;
    for i in 0..SWITCHES {
        compose(Kernel::Whitted, features(1 << i), 8);
        compose(Kernel::Whitted, features(all & !(1 << i)), 8);
    }
    for generations in [0, 1, 5, 64, 1000] {
        compose(Kernel::Whitted, Features::all(), generations);
    }
}

#[test]
fn pictures_and_rays_compose_with_each_choice_of_arithmetic() {
    for kernels in Kernels::all() {
        let special = Specialisation::new(Features::all(), 8).with(kernels);
        for kernel in [Kernel::Whitted, Kernel::Intersect, Kernel::Leave] {
            if let Err(why) = shader_source(kernel, special) {
                panic!("{kernel:?} with {kernels:?}:\n{why}");
            }
        }
    }
}

#[test]
fn pictures_compose_with_a_cutoff() {
    for bits in 0..1 << 2 {
        let special = Specialisation {
            cutoff: true,
            ..Specialisation::new(features(bits | 1 << 3), 8)
        };
        for kernel in [Kernel::Whitted, Kernel::Antialias] {
            if let Err(why) = shader_source(kernel, special) {
                panic!("{kernel:?}: {why}");
            }
        }
    }
}

#[test]
fn pictures_compose_with_counts_and_read_none_of_them_without() {
    for bits in 0..1 << 2 {
        for cutoff in [false, true] {
            let without = Specialisation {
                cutoff,
                ..Specialisation::new(features(bits | 1 << 3), 8)
            };
            let counting = Specialisation {
                counts: true,
                ..without
            };
            for kernel in [Kernel::Whitted, Kernel::Antialias] {
                let [with, without] = [counting, without].map(|special| {
                    let shader = shader_source(kernel, special);
                    shader
                        .unwrap_or_else(|why| panic!("{kernel:?}: {why}"))
                        .source
                });
                assert!(with.contains("workgroupBarrier"));
                assert!(
                    !without.contains("workgroupBarrier"),
                    "{kernel:?}: {without}"
                );
            }
        }
    }
}

#[test]
fn presenting_validates_and_its_uniform_is_as_rust_writes_it() {
    use naga::valid::{Capabilities, ValidationFlags, Validator};
    let source = include_str!("../../shaders/present.wgsl");
    let module = naga::front::wgsl::parse_str(source)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string(source)));
    Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string(source)));
    let uniform = module.types.iter().find_map(|(_, ty)| match &ty.inner {
        naga::TypeInner::Struct { members, span } if ty.name.as_deref() == Some("Present") => {
            let name = |member: &naga::StructMember| member.name.clone().unwrap_or_default();
            let places: Vec<(String, u32)> = members.iter().map(|m| (name(m), m.offset)).collect();
            Some((places, *span))
        }
        _ => None,
    });
    let (places, span) = uniform.expect("a struct `Present`");
    let names = [
        "picture_size",
        "target_size",
        "gain",
        "tone",
        "stride",
        "encode",
    ];
    let offsets = [0, 8, 16, 20, 24, 28];
    let expected: Vec<(String, u32)> = names.map(str::to_owned).into_iter().zip(offsets).collect();
    assert_eq!(
        (places, span),
        (expected, 32),
        "see engine/src/present/pass.rs"
    );
}

#[test]
fn rays_compose_for_each_mix_of_shapes() {
    for shapes in 0..1 << 4 {
        compose(Kernel::Intersect, features(shapes << 2), 1);
    }
    for solids in 0..1 << 3 {
        compose(Kernel::Intersect, features(solids << 11), 1);
    }
}

#[test]
fn kernels_of_trees_compose() {
    for kernel in Kernel::ALL {
        compose(kernel, Features::default(), 1);
    }
}
