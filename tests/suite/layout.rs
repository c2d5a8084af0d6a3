//! Rows, constants and bindings: the WGSL says what the Rust says.

use std::collections::BTreeMap;
use std::mem::offset_of;

use naga::{AddressSpace, Expression, Literal, Module, TypeInner};
use orrery_engine::bvh;
use orrery_engine::frame::Features;
use orrery_engine::frame::wire::{self, *};
use orrery_engine::trace::gpu::{
    Access, Kernel, SCENE_BINDINGS, STORAGE_BUFFERS, Specialisation, TYPES_SOURCE, shader_module,
    tree_bindings,
};

/// A struct: its size, and name, offset and size of each field.
type Layout = (usize, Vec<(&'static str, usize, usize)>);

/// The layout of a Rust struct. The pattern makes it an error to forget a field.
macro_rules! layout_of {
    ($row:ident { $($field:ident),* $(,)? }) => {{
        fn size_of_field<T, U>(_: fn(&T) -> &U) -> usize {
            size_of::<U>()
        }
        let _exhaustive = |row: $row| { let $row { $($field: _),* } = row; };
        let fields = vec![$((
            stringify!($field),
            offset_of!($row, $field),
            size_of_field::<$row, _>(|row| &row.$field),
        )),*];
        (stringify!($row), (size_of::<$row>(), fields))
    }};
}

fn rust_layouts() -> BTreeMap<&'static str, Layout> {
    BTreeMap::from([
        layout_of!(ViewRow {
            forward,
            width,
            right_step,
            height,
            up_step,
            samples,
            background,
            max_generations,
            projection,
            first_plane,
            light_count,
            root,
            eye_from_anchor,
            cutoff,
            bounds,
            spare,
            edge_contrast,
            zenith,
            panorama,
            ground,
            panorama_turn,
        }),
        layout_of!(PassRow {
            first,
            count,
            query,
            goes_on,
            spare,
            limit,
        }),
        layout_of!(Node4 {
            min_x,
            min_y,
            min_z,
            max_x,
            max_y,
            max_z,
            children
        }),
        layout_of!(InstanceRow {
            local_from_world,
            world_from_local,
            kind,
            material,
            root,
            first_triangle,
            parameter,
            mesh,
            link,
            first_normal,
        }),
        layout_of!(PlacedTriangleRow {
            corners,
            spare,
            a,
            prim,
            b,
            spare_too,
            c,
            spare_also,
        }),
        layout_of!(VertexRow { vector, further }),
        layout_of!(MaterialRow {
            color,
            diffuse,
            reflection,
            emission,
            phong_strength,
            phong_exponent,
            specular_strength,
            specular_exponent,
            transmit,
            filtered,
            ior,
            flags,
            absorption,
            alpha_cutoff,
            color_map,
            normal_map,
            spare,
        }),
        layout_of!(LightRow {
            position,
            kind,
            color,
            fade_distance,
            axis,
            fade_power,
            cos_inner,
            cos_outer,
            fade_core,
            range_inverse,
        }),
        layout_of!(RayRow {
            origin,
            t_min,
            dir,
            t_max
        }),
        layout_of!(HitRow {
            t,
            u,
            v,
            instance,
            prim,
            spare
        }),
        layout_of!(CounterRow {
            primary_rays,
            reflected_rays,
            refracted_rays,
            shadow_rays,
            media_overflows,
            straight_overflows,
            dropped_rays,
            edge_pixels,
            away_shadows,
            black_shadows,
            faint_shadows,
            weightless_rays,
        }),
        layout_of!(StageRow {
            first,
            count,
            level,
            levels
        }),
        layout_of!(JobRow {
            first_group,
            count,
            first,
            root,
            first_triangle,
            first_vertex,
            partial,
            rest,
            step_count,
            first_normal,
            spare,
        }),
        layout_of!(StepRow {
            kind,
            from_set,
            to_set,
            params,
            count,
            spare
        }),
        layout_of!(BoxRow {
            min,
            spare,
            max,
            spare_too
        }),
        layout_of!(BuildRow {
            least,
            live,
            greatest,
            spare,
            level_nodes,
            level_starts,
        }),
    ])
}

macro_rules! constants {
    ($module:ident: $($name:ident),* $(,)?) => {
        [$((stringify!($name), $module::$name)),*]
    };
}

fn rust_constants() -> BTreeMap<String, u32> {
    let of_rows = constants!(wire:
        NONE, CONE_OPEN, ROOT_OF_SPHERES, KIND_MESH, KIND_SPHERE, KIND_ELLIPSOID, KIND_CUBOID, KIND_PLANE,
        KIND_DISC, KIND_CONE, KIND_TORUS,
        LOOK_UNPLACED, WRAP_REPEAT, WRAP_CLAMP, WRAP_MIRROR, TEXELS_SHIFT,
        MATERIAL_FRESNEL, MATERIAL_MIRROR, MATERIAL_TRANSMITS, LIGHT_POINT, LIGHT_DIRECTIONAL,
        LIGHT_SPOT, PROJECTION_PERSPECTIVE, PROJECTION_ORTHOGRAPHIC, QUERY_CLOSEST, QUERY_ANY,
        MEDIA_CAPACITY, GENERATIONS_CAPACITY, STRAIGHT_CAPACITY, TRAVERSAL_CAPACITY,
        SAMPLES_CAPACITY, SAMPLE_FIRST_CELL, STEP_KEYS, STEP_MORPH, STEP_SKIN, STEP_WAVE, STEP_TWIST,
    );
    let of_nodes = constants!(bvh: CHILD_NONE, CHILD_LEAF, LEAF_COUNT_SHIFT, LEAF_FIRST_MASK);
    let of_samples = ["A", "B", "C", "D", "E", "F", "G", "H"];
    let of_samples = of_samples.map(|bit| format!("SAMPLE_COLUMN_{bit}"));
    let of_samples = of_samples.into_iter().zip(SAMPLE_COLUMNS);
    let others = of_rows.into_iter().chain(of_nodes);
    let others = others.map(|(name, value)| (name.to_owned(), value));
    others.chain(of_samples).collect()
}

fn types() -> Module {
    let plain: String = TYPES_SOURCE
        .lines()
        .filter(|line| !line.starts_with('#'))
        .flat_map(|line| [line, "\n"])
        .collect();
    naga::front::wgsl::parse_str(&plain).expect("types.wgsl parses")
}

#[test]
fn rows_have_the_same_layout_in_rust_and_wgsl() {
    let module = types();
    let mut context = naga::proc::Layouter::default();
    context.update(module.to_ctx()).expect("types have layouts");
    let expected = rust_layouts();
    let mut seen = 0;
    for (_, ty) in module.types.iter() {
        let TypeInner::Struct { members, span } = &ty.inner else {
            continue;
        };
        let name = ty.name.as_deref().unwrap_or("?");
        let (size, fields) = expected
            .get(name)
            .unwrap_or_else(|| panic!("{name} is in types.wgsl, but not in wire.rs"));
        seen += 1;
        let found: Vec<_> = members
            .iter()
            .map(|m| {
                let size = module.types[m.ty].inner.size(module.to_ctx()) as usize;
                (m.name.as_deref().unwrap_or("?"), m.offset as usize, size)
            })
            .collect();
        assert_eq!(&found, fields, "fields of {name}: WGSL, then Rust");
        assert_eq!(*span as usize, *size, "size of {name}: WGSL, then Rust");
        let mut end = 0;
        for (field, offset, size) in found {
            assert_eq!(
                offset, end,
                "padding that nobody named before {name}.{field}"
            );
            end = offset + size;
        }
        assert_eq!(end, *size, "padding that nobody named at the end of {name}");
    }
    assert_eq!(
        seen,
        expected.len(),
        "structs in wire.rs, but not in types.wgsl"
    );
}

#[test]
fn constants_have_the_same_values_in_rust_and_wgsl() {
    let module = types();
    let found: BTreeMap<_, _> = module
        .constants
        .iter()
        .map(|(_, constant)| {
            let name = constant.name.as_deref().unwrap_or("?");
            match module.global_expressions[constant.init] {
                Expression::Literal(Literal::U32(value)) => (name.to_owned(), value),
                ref other => panic!("{name} is no u32 but {other:?}"),
            }
        })
        .collect();
    assert_eq!(found, rust_constants(), "WGSL, then Rust");
}

/// Group, binding and name of what a kernel binds; names as in the file, without naga_oil's module.
fn bindings(module: &Module) -> Vec<(u32, u32, String, AddressSpace)> {
    let mut found: Vec<_> = module
        .global_variables
        .iter()
        .filter_map(|(_, variable)| {
            let at = variable.binding.as_ref()?;
            let name = variable.name.as_deref().unwrap_or("?");
            let name = name.split("X_naga_oil_mod_X").next().unwrap_or(name);
            Some((at.group, at.binding, name.to_owned(), variable.space))
        })
        .collect();
    found.sort_by_key(|(group, binding, ..)| (*group, *binding));
    found
}

#[test]
fn kernels_bind_what_the_layouts_and_the_table_say() {
    let table = include_str!("../../shaders/README.md");
    for (kernel, work) in [
        (Kernel::Whitted, ["pixels", "report"]),
        (Kernel::Edges, ["pixels", "report"]),
        (Kernel::Antialias, ["pixels", "report"]),
        (Kernel::Intersect, ["rays", "hits"]),
        (Kernel::Leave, ["rays", "hits"]),
    ] {
        let module = shader_module(kernel, Specialisation::new(Features::all(), 8)).unwrap();
        let number = |group, names: &[&'static str]| -> Vec<(u32, u32, &'static str)> {
            names
                .iter()
                .zip(0..)
                .map(|(name, i)| (group, i, *name))
                .collect()
        };
        let expected = [
            number(0, &["view", "pass_row"]),
            number(1, &SCENE_BINDINGS),
            number(2, &work),
            number(3, &["texels"]),
        ]
        .concat();
        let found = bindings(&module);
        for (group, binding, name, _) in &found {
            assert!(
                expected.contains(&(*group, *binding, name.as_str())),
                "{kernel:?} binds {name} at {group}, {binding}; the layouts: {expected:?}"
            );
            let row = format!("| {group} | {binding} | `{name}` |");
            assert!(table.contains(&row), "shaders/README.md lacks {row}");
        }
        let storage =
            |b: &&(u32, u32, String, AddressSpace)| matches!(b.3, AddressSpace::Storage { .. });
        let used = found.iter().filter(storage).count();
        assert!(
            used <= STORAGE_BUFFERS as usize,
            "{kernel:?} binds {used} storage buffers"
        );
        if kernel == Kernel::Whitted {
            assert_eq!(
                found.len(),
                expected.len(),
                "the picture kernel uses every binding"
            );
        }
    }
}

#[test]
fn kernels_of_trees_bind_what_the_layouts_and_the_table_say() {
    let table = include_str!("../../shaders/README.md");
    for kernel in Kernel::ALL {
        let bound = tree_bindings(kernel);
        if bound.is_empty() {
            continue;
        }
        let module = shader_module(kernel, Specialisation::new(Features::all(), 8)).unwrap();
        let found: Vec<_> = bindings(&module)
            .into_iter()
            .map(|(group, binding, name, space)| {
                assert_eq!(group, 0, "{kernel:?} binds {name} in another group");
                (binding, name, space)
            })
            .collect();
        let expected = std::iter::once((0, "stage", AddressSpace::Uniform));
        let buffers = bound.iter().zip(1..).map(|(&(name, access), binding)| {
            let mut uses = naga::StorageAccess::LOAD;
            uses.set(naga::StorageAccess::STORE, access == Access::Write);
            (binding, name, AddressSpace::Storage { access: uses })
        });
        let expected: Vec<_> = expected
            .chain(buffers)
            .map(|(binding, name, space)| (binding, name.to_owned(), space))
            .collect();
        assert_eq!(found, expected, "{kernel:?}: WGSL, then the layout");
        assert!(bound.len() <= STORAGE_BUFFERS as usize, "{kernel:?}");
        let names: Vec<String> = bound.iter().map(|(name, _)| format!("`{name}`")).collect();
        let row = format!("| `{}.wgsl` | {} |", kernel.name(), names.join(", "));
        assert!(table.contains(&row), "shaders/README.md lacks {row}");
    }
}
