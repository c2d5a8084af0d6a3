//! What is refused says where in the file and why.

use super::*;

#[test]
fn what_cannot_be_read_says_where_and_why() {
    let bytes = floats(&ZIGZAG);
    let good = one_mesh(5, "", "", "");
    let sparse = ",\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":0,\"componentType\":5121},\"values\":{\"bufferView\":0}}";
    for (from, to, why) in [
        (
            "\"count\":5",
            "\"count\":6",
            "accessors[0]: 6 elements 12 bytes apart from byte 0 on, but its view has 60 bytes",
        ),
        (
            "\"count\":5",
            "\"count\":4000000000",
            "accessors[0]: 4000000000 elements",
        ),
        (
            "\"count\":5",
            "\"count\":18446744073709551615",
            "accessors[0]: 18446744073709551615 elements",
        ),
        (
            "\"buffer\":0,\"byteLength\":60",
            "\"buffer\":0,\"byteLength\":61",
            "bufferViews[0]: 61 bytes from byte 0 on, but its buffer has 60",
        ),
        (
            "\"buffer\":0,",
            "\"buffer\":0,\"byteOffset\":18446744073709551615,",
            "bufferViews[0]",
        ),
        (
            "\"type\":\"VEC3\"",
            "\"type\":\"VEC2\"",
            "accessors[0]: it is Vec2 where Vec3 is needed",
        ),
        (
            "\"bufferView\":0,",
            "\"bufferView\":7,",
            "accessors[0].bufferView names something that is not there",
        ),
        (
            "\"mesh\":0",
            "\"mesh\":1",
            "nodes[0].mesh names something that is not there",
        ),
        ("\"count\":5,", &format!("\"count\":5{sparse},"), ""),
        (
            "\"bufferView\":0,\"componentType\":5126,\"count\":5,",
            &format!("\"componentType\":5126,\"count\":4000000000{sparse},"),
            "far more numbers",
        ),
        (
            "\"nodes\"",
            "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],\"nodes\"",
            "`KHR_draco_mesh_compression` is an extension that is not supported",
        ),
        (
            "\"byteLength\":60}],",
            "\"byteLength\":60,\"uri\":\"data:,x\"}],",
            "buffers[0]: its data URI is not in base64",
        ),
        (
            "\"byteLength\":60}],",
            "\"byteLength\":60,\"uri\":\"no%20such.bin\"}],",
            "buffers[0]: `no%20such.bin`: it cannot be read",
        ),
        (
            "\"byteLength\":60}],",
            "\"byteLength\":60,\"uri\":\"http://a/b\"}],",
            "neither a file beside it nor a data URI",
        ),
        (
            "\"byteLength\":60}],",
            "\"byteLength\":61}],",
            "buffers[0]: 60 bytes where byteLength says 61",
        ),
        ("\"nodes\"", "nodes", "its JSON is not that of glTF 2.0"),
    ] {
        // The container's `buffers` come before the rest.
        let buffers = "\"buffers\":[{\"byteLength\":60}],";
        let json = format!("{{\"asset\":{{\"version\":\"2.0\"}},{buffers}{good}}}");
        assert!(json.contains(from), "{from}");
        let json = json.replacen(from, to, 1);
        let found = read(&container(json.as_bytes(), &bytes));
        match (found, why) {
            (Ok(_), "") => {}
            (Err(found), why) if !why.is_empty() => {
                assert!(found.contains(why), "{found}\nshould contain {why}")
            }
            (found, why) => panic!("{to}: {why}: {:?}", found.map(|model| model.nodes.len())),
        }
    }
    for bytes in [
        &b""[..],
        b"glTF",
        b"glTF\x02\0\0\0\x03\0\0\0",
        b"glTF\x01\0\0\0\x0c\0\0\0",
        b"{}",
        b"[[[[",
    ] {
        assert!(read(bytes).is_err(), "{bytes:?}");
    }
}

#[test]
fn one_accessor_used_over_and_over_is_refused() {
    let count = 3000;
    let bytes = floats(&vec![0.5; 3 * count]);
    let json = one_mesh(count, "", "", "");
    let primitive = "{\"attributes\":{\"POSITION\":0}}";
    let json = json.replace(primitive, &[primitive; 1000].join(","));
    let found = read(&glb(&json, &bytes)).unwrap_err();
    assert!(
        found.contains("meshes[0].primitives[") && found.contains("over and over"),
        "{found}"
    );
}

#[test]
fn what_is_broken_is_left_out_and_the_rest_is_read() {
    let bytes = floats(&ZIGZAG);
    let scalar = ",{\"bufferView\":0,\"componentType\":5126,\"count\":2,\"type\":\"SCALAR\"}";
    let short = ",{\"bufferView\":0,\"componentType\":5126,\"count\":1,\"type\":\"VEC3\"}";
    let accessors = [scalar, short].concat();
    // Normals and a target that are numbers of another shape, a target that is too short, and one that is sound.
    let targets = ",\"targets\":[{\"POSITION\":1},{\"POSITION\":2},{\"POSITION\":0}]";
    let json = one_mesh(5, targets, &accessors, "")
        .replace("\"POSITION\":0}", "\"POSITION\":0,\"NORMAL\":1,\"JOINTS_0\":1,\"WEIGHTS_0\":1}")
        .replace("{\"POSITION\":0,\"NORMAL\":1,\"JOINTS_0\":1,\"WEIGHTS_0\":1}]", "{\"POSITION\":0}]")
        // A second primitive whose places are none.
        .replace("]}],\n", ",{\"attributes\":{\"POSITION\":1}}]}],\n")
        .replace(
            "\"nodes\"",
            "\"skins\":[{\"joints\":[0],\"inverseBindMatrices\":2}],
            \"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"scale\"}}],
                \"samplers\":[{\"input\":1,\"output\":1}]}],\"nodes\"",
        );
    let model = read(&glb(&json, &bytes)).unwrap();
    let told = model.warnings.sentences().join("\n");
    assert_eq!(model.parts.len(), 1, "{told}");
    let morph = model.parts[0].morph.as_ref().unwrap();
    let moved = |row| {
        morph
            .targets
            .set(row)
            .iter()
            .any(|offset| *offset != Vec3::ZERO)
    };
    assert_eq!([moved(0), moved(1), moved(2)], [false, false, true]);
    for expected in [
        "skins[0]: accessors[2]: it is Vec3 where Mat4 is needed; it holds nothing",
        "meshes[0].primitives[0]: it is shaded flat: accessors[1]",
        "meshes[0].primitives[0]: morph target 0 moves nothing: accessors[1]",
        "meshes[0].primitives[0]: morph target 1 moves nothing: it has too few offsets",
        "meshes[0].primitives[0]: nothing holds its vertices: accessors[1]",
        "meshes[0].primitives[1]: accessors[1]: it is Scalar where Vec3 is needed; it is left out",
        "animations[0].channels[0]: accessors[1]",
    ] {
        assert!(told.contains(expected), "{expected}\n{told}");
    }
}
