use glam::{DVec3, Vec3};

use super::*;
use crate::import::{Content, Node, Solid};
use crate::world::{Channel, Material, Projection, Reflection, newell_normal};

mod animated;

fn import(text: &str) -> Result<Model, String> {
    import_nff_text(text, &|name| Err(format!("there is no {name}")))
}

fn refused(text: &str) -> String {
    import(text).expect_err("it is not valid")
}

const HEAD: &str = "b 0.078 0.361 0.753\nv\nfrom 2 0 0\nat 0 0 0\nup 0 0 1\nangle 45\nhither 0.01\n\
    resolution 512 512\nl 4 3 2\nl 1 -4 4 1 0.5 0.25\nf 1 0.75 0.33 0.8 0.5 12 0 1\n";

fn only_solid(node: &Node) -> Solid {
    match node.contents.as_slice() {
        [Content::Solid { solid, .. }] => *solid,
        other => panic!("{other:?}"),
    }
}

fn material(model: &Model, row: usize) -> Material {
    model.materials[row].1
}

#[test]
fn the_view_spans_the_middles_of_the_outer_rows() {
    let model = import(&format!("{HEAD}s 0 0 0 1\n")).unwrap();
    let node = &model.nodes[0];
    let [Content::Camera(camera)] = node.contents.as_slice() else {
        panic!("{node:?}");
    };
    let Projection::Perspective { vertical_fov } = camera.projection else {
        panic!("{camera:?}");
    };
    let half = (0.5 * vertical_fov).tan();
    let middle_of_the_top_row = half * 511.0 / 512.0;
    assert!((middle_of_the_top_row - 22.5_f64.to_radians().tan()).abs() < 1e-12);
    let ahead = node.pose.rotation * DVec3::NEG_Z;
    assert!(ahead.abs_diff_eq(DVec3::NEG_X, 1e-12) && node.pose.translation == DVec3::X * 2.0);
    assert!((node.pose.rotation * DVec3::Y).abs_diff_eq(DVec3::Z, 1e-12));
    // Display values, decoded.
    let blue = model.background.unwrap();
    assert!(
        blue.abs_diff_eq(Vec3::new(0.00694, 0.10716, 0.52721), 1e-4),
        "{blue}"
    );
}

#[test]
fn lights_without_a_colour_share_what_the_readme_says() {
    let model = import(&format!("{HEAD}s 0 0 0 1\n")).unwrap();
    let colors = model.contents().filter_map(|content| match content {
        Content::Point(light) => Some(light.color),
        _ => None,
    });
    let colors: Vec<Vec3> = colors.collect();
    let [unsaid, said] = colors.as_slice() else {
        panic!("{colors:?}");
    };
    assert!(
        unsaid.abs_diff_eq(Vec3::splat(0.5_f32.sqrt()), 1e-6),
        "{unsaid}"
    );
    assert_eq!(*said, Vec3::new(1.0, 0.5, 0.25));
}

#[test]
fn fills_become_materials() {
    let text = "l 0 0 9 1 1 1\nf 1 1 1 0.1 0.2 40 0.9 1.5\ns 0 0 0 1\nf 1 0 0\ns 1 0 0 1\n\
        am 2 2 2\nfm 0.1 0.1 0.1  0.5 0.5 0.5  0.3 0.2 0.1  20 0.85 0\ns 2 0 0 1\n\
        f 1 1 1 0.1 0.2 40 0.9 1.5\ns 3 0 0 1\n";
    let model = import(text).unwrap();
    assert_eq!(model.materials.len(), 3, "equal fills are one");
    let of = |weight: f32| look::linear(Vec3::splat(weight)).x;
    let glass = material(&model, 0);
    assert!((glass.diffuse * (1.0 - glass.filter) - of(0.1)).abs() < 1e-6);
    assert_eq!(
        (glass.filter, glass.transmit, glass.ior),
        (of(0.9), 0.0, 1.5)
    );
    assert_eq!(glass.reflection, Reflection::Constant(Vec3::splat(of(0.2))));
    let lobe = glass.phong.unwrap();
    assert!((lobe.strength - of(0.2)).abs() < 1e-6 && lobe.exponent == 40.0);
    let red = material(&model, 1);
    assert_eq!((red.color, red.diffuse), (Vec3::X, 1.0));
    assert_eq!((red.reflection, red.phong), (Reflection::None, None));
    let three = material(&model, 2);
    let mirror = Vec3::new(of(0.3), of(0.2), of(0.1));
    assert_eq!(three.reflection, Reflection::Constant(mirror));
    assert_eq!(
        (three.filter, three.transmit, three.ior),
        (0.0, of(0.85), 1.0)
    );
    let glow = three.color.x * three.emission * (1.0 - of(0.85));
    assert!((glow - of(0.2)).abs() < 1e-6, "{glow}");
    let clear = import(
        "f 1 1 1 0 0 1 0.8 1.1\ns 0 0 0 1\nam 2 2 2\nfm 0.4 0.4 0.4 0 0 0 0 0 0 0 0 0\ns 3 0 0 1",
    )
    .unwrap();
    assert_eq!(material(&clear, 0).reflection, Reflection::Fresnel);
    let lit = material(&clear, 1);
    assert_eq!(
        (lit.color.x, lit.emission, lit.diffuse),
        (of(0.8), 1.0, 0.0)
    );
}

#[test]
fn solids_keep_their_numbers() {
    let model = import("s 1 2 3 -4\nc 0 0 0 2\n0 0 5 1\nc 1 1 1 -2 1 1 5 -2\n").unwrap();
    let [sphere, cone, cylinder] = model.nodes.as_slice() else {
        panic!("{:?}", model.nodes);
    };
    assert_eq!(sphere.pose.translation, DVec3::new(1.0, 2.0, 3.0));
    assert!(matches!(only_solid(sphere), Solid::Sphere(s) if s.radius == 4.0));
    assert!(matches!(only_solid(cone), Solid::Cone(c)
        if c.open && c.radius_a == 2.0 && c.radius_b == 1.0 && c.b == DVec3::Z * 5.0));
    assert!(matches!(only_solid(cylinder), Solid::Cylinder(c)
        if c.open && c.radius == 2.0 && c.b == DVec3::Z * 4.0));
    assert_eq!(cylinder.pose.translation, DVec3::ONE);
}

#[test]
fn polygons_of_a_fill_become_one_mesh_of_their_area() {
    let arrow = "p 4\n0 0 0\n2 -1 0\n1 0 0\n2 1 0\n";
    let patch = "pp 3\n0 0 0 0 0 2\n1 0 0 0 0 2\n0 1 0 0 0 2\n";
    let text = format!("f 1 0 0\n{arrow}{patch}f 0 1 0\np 3 1 0 0 2 0 0 1 1 0\nf 1 0 0\n{arrow}");
    let model = import(&text).unwrap();
    assert_eq!((model.parts.len(), model.triangles()), (3, 2 + 2 + 1 + 1));
    let flat = &model.parts[0].mesh;
    assert!(flat.normals.is_empty());
    assert_eq!(flat.vertices.len(), 4, "equal corners are one");
    let area = |t: &[u32; 3]| newell_normal(&t.map(|i| flat.vertices[i as usize])).length();
    let areas: f64 = flat.triangles.iter().map(area).sum();
    assert!((areas - 4.0).abs() < 1e-12, "{areas}");
    assert_eq!(model.parts[1].mesh.normals, [Vec3::Z; 3]);
}

#[test]
fn broken_shapes_are_left_out_with_their_line() {
    let model = import("s 0 0 0 1\ns 0 0 0 0\np 2 0 0 0 1 1 1\nc 1 1 1 2 1 1 1 2\n").unwrap();
    assert_eq!(model.nodes.len(), 1);
    let warnings = model.warnings.sentences();
    assert_eq!(warnings.len(), 3, "{warnings:?}");
    assert!(warnings[0].starts_with("line 2: a sphere"), "{warnings:?}");
    let textured = import("f 1 0 0 0.5 0.5 45 0 1 gone.png\ns 0 0 0 1").unwrap();
    assert!(textured.warnings.sentences()[0].contains("gone.png"));
}

#[test]
fn what_cannot_be_read_is_refused_with_place_and_reason() {
    for (text, place, reason) in [
        ("", "", "no shape"),
        ("l 1 2 3", "", "no shape"),
        ("dod 0 0 0 5", "line 1", "`dod`"),
        ("nff\nversion 2.12", "line 1", "Sense8"),
        ("# one\n% two\ns 0 0 zero 1", "line 3", "`zero`"),
        ("s 0 0", "line 1", "the file ends"),
        ("s 0 0 inf 1", "line 1", "`inf`"),
        ("s 0 0 1e30 1", "line 1", "farther out"),
        ("p 99999999999\n0 0 0", "line 1", "more than the rest"),
        ("p -1", "line 1", "whole number"),
        ("v\nfrom 1 2 3\nup 0 0 1", "line 3", "`at`"),
        (
            "v from 1 2 3 at 0 0 0 up 0 0 1 angle 0 hither 1 resolution 9 9",
            "line 1",
            "angle",
        ),
        ("}", "line 1", "without"),
        (
            "m vertices 1 0 0 0 triangles 1 0 0 7",
            "line 1",
            "there are 1",
        ),
    ] {
        let why = refused(text);
        assert!(why.contains(place) && why.contains(reason), "{text}: {why}");
    }
}
