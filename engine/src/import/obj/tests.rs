use super::*;
use crate::world::newell_normal;

fn import(text: &str) -> Result<Model, String> {
    read_obj(text.as_bytes(), Path::new("nowhere"), &|_| {
        Err("it cannot be read: it is not there".into())
    })
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn a_concave_face_is_cut_to_its_area_with_its_winding() {
    let arrow = "v 0 0 0\nv 2 -1 0\nv 1 0 0\nv 2 1 0\nf 1 2 3 4\n";
    let model = import(arrow).unwrap();
    let mesh = &model.parts[0].mesh;
    let total: DVec3 = mesh
        .triangles
        .iter()
        .map(|t| newell_normal(&t.map(|i| mesh.vertices[i as usize])))
        .sum();
    let unsigned: f64 = mesh
        .triangles
        .iter()
        .map(|t| newell_normal(&t.map(|i| mesh.vertices[i as usize])).length())
        .sum();
    assert_eq!(mesh.triangles.len(), 2);
    assert!(
        (unsigned - 2.0).abs() < 1e-12 && (total.z - 2.0).abs() < 1e-12,
        "{unsigned} {total}"
    );
}

#[test]
fn groups_and_materials_become_parts() {
    let text = format!("{SQUARE}o a\nf 1 2 3\no b\nf 1 3 4\n");
    let model = import(&text).unwrap();
    let names: Vec<_> = model
        .parts
        .iter()
        .map(|part| part.mesh.name.as_str())
        .collect();
    assert_eq!(names, ["a", "b"]);
}

#[test]
fn normals_of_the_file_are_kept() {
    let text = format!("{SQUARE}vn 0 0 2\nf 1//1 2//1 3//1\n");
    assert_eq!(
        import(&text).unwrap().parts[0].mesh.normals,
        vec![Vec3::Z; 3]
    );
}

#[test]
fn a_missing_material_file_is_a_warning() {
    let text = format!("mtllib gone.mtl\n{SQUARE}usemtl red\nf 1 2 3\n");
    let model = import(&text).unwrap();
    assert!(
        model.warnings.sentences()[0].contains("gone.mtl"),
        "{:?}",
        model.warnings
    );
    assert!(matches!(
        model.nodes[0].contents[..],
        [Content::Part { material: None, .. }]
    ));
}

#[test]
fn bad_files_are_sentences() {
    for text in [
        "",
        "f 1 2 3\n",
        "v a b c\n",
        "v 0 0\nf 1 1 1\n",
        "v NaN 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    ] {
        let error = import(text).unwrap_err();
        assert!(!error.is_empty(), "{text:?}");
    }
    assert!(
        super::super::import(Path::new("nowhere/gone.obj"))
            .unwrap_err()
            .contains("cannot be read")
    );
}

#[test]
fn mutated_files_end_in_a_model_or_a_sentence() {
    let base = format!(
        "mtllib a.mtl\n{SQUARE}vn 0 0 1\nvt 0 0\no a\nusemtl x\nf 1//1 2//1 3//1 4//1\ng b\nf -1 -2 -3\nl 1 2\np 1\n"
    );
    let mut state = 0x2545_F491_4F6C_DD1D_u64;
    let mut below = |n: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % n as u64) as usize
    };
    let pieces = [
        "\n",
        " ",
        "/",
        "-",
        "9",
        "1e999",
        "nan",
        "f",
        "v ",
        "0",
        "99999999999999999999",
        "\\\n",
        "\u{0}",
        "usemtl",
    ];
    for _ in 0..3000 {
        let mut text = base.clone();
        for _ in 0..1 + below(5) {
            let at = below(text.len());
            let end = (at + below(6)).min(text.len());
            text.replace_range(at..end, pieces[below(pieces.len())]);
        }
        if let Ok(model) = import(&text) {
            for part in &model.parts {
                assert!(part.mesh.vertices.iter().all(|v| v.is_finite()), "{text}");
                assert!(
                    part.mesh.normals.iter().all(|n| n.is_normalized()),
                    "{text}"
                );
            }
        }
    }
}

#[test]
fn colours_on_some_vertices_and_continued_lines_are_read() {
    let text = "v 0 0 0 1 0 0\nv 1 0 0\nv 1 1 \\\n0\nusemtl\nf 1 2 \\\r\n3\n";
    let mesh = &import(text).unwrap().parts[0].mesh;
    assert_eq!(mesh.vertices[2], DVec3::new(1.0, 1.0, 0.0));
}

#[test]
fn colours_of_materials_that_are_not_three_numbers_do_not_reach_the_reader() {
    let text = "newmtl a\nKd 0.5\nKs 1 2\nKe\nKa 1 2 3\nKd x y\nNs x\nillum\nmap_Kd\nnewmtl b\n Kd 0.1 0.2 0.3 4\n";
    let mut warnings = Warnings::default();
    let plain = plain_materials(text, "a.mtl", &mut warnings);
    // Without a net: tobj itself must not panic.
    let (materials, _) = tobj::load_mtl_buf(&mut plain.as_bytes()).unwrap();
    assert_eq!(materials[0].diffuse, Some([0.5; 3]));
    assert_eq!(materials[0].ambient, Some([1.0, 2.0, 3.0]));
    assert_eq!(materials[0].specular, None);
    assert_eq!(materials[1].diffuse, Some([0.1, 0.2, 0.3]));
    let warnings = warnings.sentences();
    assert_eq!(warnings.len(), 6, "{warnings:#?}");
    assert!(
        warnings[0].starts_with("line 3 of material file a.mtl"),
        "{}",
        warnings[0]
    );
}

#[test]
fn corners_that_differ_in_their_texture_coordinate_alone_are_vertices_of_their_own() {
    let text =
        format!("{SQUARE}vt 0 0\nvt 1 0.25\nvt 0.5 1\nvt 7 7\nf 1/1 2/2 3/3\nf 1/4 3/3 4/1\n");
    let mesh = import(&text).unwrap().parts.remove(0).mesh;
    assert_eq!((mesh.vertices.len(), mesh.uvs.len()), (5, 5));
    // v counts downward here.
    assert_eq!(mesh.uvs[1], Vec2::new(1.0, 0.75));
    assert_eq!(
        (mesh.vertices[0], mesh.vertices[3]),
        (DVec3::ZERO, DVec3::ZERO)
    );
    assert_eq!(
        (mesh.uvs[0], mesh.uvs[3]),
        (Vec2::new(0.0, 1.0), Vec2::new(7.0, -6.0))
    );
    let odd = import(&format!("{SQUARE}vt nan 0\nf 1/1 2/1 3/1\n")).unwrap();
    assert_eq!(odd.parts[0].mesh.uvs, [Vec2::Y; 3]);
    assert_eq!(odd.warnings.sentences().len(), 1);
}

#[test]
fn a_face_that_crosses_itself_leaves_no_hole() {
    let bow = format!("{SQUARE}f 1 3 2 4\n");
    let model = import(&bow).unwrap();
    assert_eq!(model.parts[0].mesh.triangles.len(), 2);
    let told = model.warnings.sentences().concat();
    assert!(told.contains("crosses itself"), "{told}");
}

#[test]
fn colours_behind_vertices_are_theirs_where_all_have_one() {
    let colored = "v 0 0 0 1 0 0.5\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nf 3 1 2\n";
    let model = import(colored).unwrap();
    let half = linear_light(0.5) as f32;
    let expected = [
        Vec4::new(0.0, 0.0, 1.0, 1.0),
        Vec4::new(1.0, 0.0, half, 1.0),
    ];
    assert_eq!(model.parts[0].mesh.colors[..2], expected);
    // Bytes, and what is no number or not everywhere.
    let bytes = import(&colored.replace("0.5\n", "255\n")).unwrap();
    let blue = bytes.parts[0].mesh.colors[1].z;
    assert_eq!(blue, 1.0);
    for bad in [
        colored.replace("0.5\n", "\n"),
        colored.replace("0.5\n", "nan\n"),
    ] {
        assert!(
            import(&bad).unwrap().parts[0].mesh.colors.is_empty(),
            "{bad}"
        );
    }
}

#[test]
fn pictures_lie_on_meshes_as_their_options_say() {
    let text = format!("mtllib a.mtl\n{SQUARE}vt 0 0\nvt 1 0\nvt 1 1\nusemtl a\nf 1/1 2/2 3/3\n");
    let mtl = |options: &str| format!("newmtl a\nmap_Kd {options} gone.png\n").into_bytes();
    let uvs = |options: &str| {
        let open = |_: &Path| Ok(mtl(options));
        let model = read_obj(text.as_bytes(), Path::new("nowhere"), &open).unwrap();
        model.parts[0].mesh.uvs.clone()
    };
    let place = |x: f32, y: f32| Vec2::new(x, 1.0 - y);
    assert_eq!(uvs(""), [place(0.0, 0.0), place(1.0, 0.0), place(1.0, 1.0)]);
    let moved = [place(0.5, 0.25), place(2.5, 0.25), place(2.5, 3.25)];
    assert_eq!(uvs("-s 2 3 -o 0.5 0.25"), moved);
    assert!(uvs("-s 1e6 1 -o 1e6").is_empty());
}

#[test]
fn what_is_broken_of_a_file_is_left_out_with_its_line() {
    let text = format!(
        "f 1 2 3\n{SQUARE}v x 0 0\nv nan 0 0\nvt 0.5\nvn 0 0\nf 1 2 9\nf 1 2 5\nf 1 2 6\nf 1 0 2\nf 1/2 2 3\nf 1 2 z\nf 1 2\nf -6/1 -5/1 -4/1\nl 1 x\nusemtl\n"
    );
    let model = import(&text).unwrap();
    assert_eq!(model.parts[0].mesh.triangles.len(), 3);
    assert_eq!(model.parts[0].mesh.vertices[1], DVec3::X);
    let told = model.warnings.sentences();
    let expected = [
        "line 6: `v` is without its finite numbers",
        "line 7: `v`",
        "line 9: `vn`",
        "line 10: a face is left out: there is no vertex 9, there are 6",
        "line 11: a face is left out: vertex 5 is not three finite numbers",
        "line 12: a face",
        "line 13: a face is left out: there is no vertex 0",
        "line 14: there is no texture coordinate 2, there are 1: left out of the face",
        "line 15: a face is left out: there is no vertex z",
        "line 16: a face is left out: it has fewer than three corners",
        "the normals of `unnamed_object` are left out",
    ];
    for (told, expected) in told.iter().zip(expected) {
        assert!(told.starts_with(expected), "{told} / {expected}");
    }
    assert_eq!(told.len(), expected.len(), "{told:#?}");
}

#[test]
fn faces_stay_though_their_normals_or_texture_coordinates_are_not_there() {
    let faces = |face: &str| {
        let model = import(&format!("{SQUARE}{face}\n")).unwrap();
        let mesh = &model.parts[0].mesh;
        assert_eq!(mesh.triangles.len(), 1, "{face}");
        (
            mesh.normals.len(),
            mesh.uvs.len(),
            model.warnings.sentences().len(),
        )
    };
    assert_eq!(faces("f 1//1 2//2 3//3"), (0, 0, 1));
    assert_eq!(faces("f 1/1/1 2/2/2 3/3/3").2, 1);
    assert_eq!(faces("vn 0 0 1\nf 1//1 2//1 3//1"), (3, 0, 0));
    assert_eq!(faces("vn 0 0 1\nf 1//1 2//2 3//1"), (0, 0, 2));
    assert_eq!(faces("vt 0 0\nf 1/1 2/1 3/1"), (0, 3, 0));
    let (normals, _, told) = faces("vt 0 0\nf 1/1 2/2 3/1");
    assert_eq!((normals, told), (0, 1));
}

#[test]
fn a_material_file_is_read_once_however_often_it_is_named() {
    let text = format!("{}{SQUARE}f 1 2 3\n", "mtllib a.mtl\n".repeat(1000));
    let count = std::cell::Cell::new(0);
    let model = read_obj(text.as_bytes(), Path::new("nowhere"), &|_| {
        count.set(count.get() + 1);
        Ok(b"newmtl red\nKd 1 0 0\n".to_vec())
    });
    assert_eq!((count.get(), model.unwrap().materials.len()), (1, 1));
}

#[test]
fn a_line_names_one_material_file_with_spaces_or_several() {
    let read = |line: &str| {
        let text = format!("mtllib {line}\n{SQUARE}usemtl b\nf 1 2 3\nusemtl a\nf 1 3 4\n");
        let open = |name: &Path| match name.to_str() {
            Some("a.mtl") => Ok(b"newmtl a\nKd 1 0 0\n".to_vec()),
            Some("b.mtl") => Ok(b"newmtl c\nnewmtl b\nKd 0 0 1\n".to_vec()),
            Some("a b.mtl") => Ok(b"newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 0 1\n".to_vec()),
            _ => Err("it is not there".to_owned()),
        };
        let model = read_obj(text.as_bytes(), Path::new("nowhere"), &open).unwrap();
        let color = |content: &Content| model.materials[content.material().unwrap()].1.color;
        assert_eq!(
            model.contents().map(color).collect::<Vec<_>>(),
            [Vec3::Z, Vec3::X]
        );
        model.warnings.sentences()
    };
    assert_eq!(read("a b.mtl").len(), 0);
    assert_eq!(read("a.mtl b.mtl").len(), 0);
    assert_eq!(
        read("a.mtl gone.mtl  b.mtl"),
        ["material file gone.mtl: it is not there"]
    );
}

#[test]
fn a_material_that_is_not_there_is_told_once() {
    let text = format!(
        "mtllib a.mtl\n{SQUARE}usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\nusemtl a\nusemtl b\nf 2 3 4\n"
    );
    let told = |text: &str| {
        let open = |_: &Path| Ok(b"newmtl a\n".to_vec());
        let model = read_obj(text.as_bytes(), Path::new("nowhere"), &open).unwrap();
        model.warnings.sentences()
    };
    assert_eq!(
        told(&text),
        ["there is no material `b`; what wears it is plain"]
    );
    assert_eq!(told(&text.replace("mtllib a.mtl\n", "")).len(), 2);
}

#[test]
fn the_unit_of_colours_is_one_for_the_whole_file() {
    let file = |white: &str| {
        let dark = "v 0 0 0 1 1 1\nv 1 0 0 1 1 1\nv 0 1 0 1 1 1\n";
        let text = format!(
            "{dark}{}o a\nf 1 2 3\no b\nf 4 5 6\n",
            dark.replace(" 1 1 1", white)
        );
        let parts = import(&text).unwrap().parts;
        [0, 1].map(|part| parts[part].mesh.colors[0].x)
    };
    let byte = linear_light(1.0 / 255.0) as f32;
    assert_eq!(file(" 255 255 255"), [byte, 1.0]);
    assert_eq!(file(" 1.01 1.01 1.01"), [1.0, 1.0]);
}
