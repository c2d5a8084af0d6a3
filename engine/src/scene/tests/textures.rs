//! Pictures of materials: of the scene file, of a mesh's MTL, missing and broken ones.

use super::*;
use crate::world::{Material, Texture, TextureId, Textures, Wrap};

/// A folder of its own for one test, with an OBJ whose MTL names pictures, one of which is not there.
fn folder(name: &str) -> std::path::PathBuf {
    let folder = std::env::temp_dir().join(format!("orrery-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.join(name), bytes).unwrap();
    // Uncompressed true colour, 1 x 1, blue first.
    let tga = |b: u8, g: u8, r: u8| {
        let mut bytes = [0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 24, 0].to_vec();
        bytes.extend([b, g, r]);
        bytes
    };
    write("red.tga", &tga(0, 0, 255));
    write("mask.tga", &tga(255, 255, 255));
    write("broken.tga", &tga(0, 0, 0)[..19]);
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\nusemtl n\nf 1/1 3/1 2/1\n";
    write("a.obj", obj.as_bytes());
    let mtl = "newmtl m\nmap_Kd -s 1 1 1 C:\\elsewhere\\red.tga\nmap_d mask.tga\nnewmtl n\nmap_Kd gone.png\n";
    write("a.mtl", mtl.as_bytes());
    folder
}

fn texture(world: &World, id: Option<TextureId>) -> Option<Texture> {
    let textures = world.resource::<Textures>();
    textures.get(id?).map(|texture| (**texture).clone())
}

#[test]
fn pictures_are_loaded_once_saved_by_name_and_freed() {
    let folder = folder("textures");
    let text = "(version: 1, materials: {
        \"a\": (color_map: \"red.tga\", alpha_cutoff: 0.25),
        \"b\": (color_map: (path: \"red.tga\", wrap: Mirror), normal_map: \"red.tga\"),
        \"c\": (color_map: \"red.tga\"),
    }, entities: [(mesh: \"a.obj\"), (light: Point()), (camera: ())])";
    let mut engine = Engine::new();
    let world = &mut engine.world;
    let report = load_text(world, text, &folder.join("s.ron")).unwrap_or_else(|p| panic!("{p}"));
    let warnings: Vec<String> = report.warnings.iter().map(ToString::to_string).collect();
    assert!(
        matches!(&warnings[..], [gone] if gone.contains("gone.png")),
        "{warnings:?}"
    );
    let saved = describe(world);
    let of = |name: &str| {
        let found = saved.materials.iter().find(|(id, _)| id.value == name);
        found.unwrap().1.clone()
    };
    let path = |map: &Option<schema::TextureFile>| map.as_ref().unwrap().path.value.clone();
    assert_eq!(path(&of("a").color_map), "red.tga");
    assert_eq!(of("a").material.alpha_cutoff, Some(0.25));
    assert_eq!(of("b").color_map.unwrap().wrap, Wrap::Mirror);
    let reloaded = save(world);
    load_text(world, &reloaded, &folder.join("s.ron"))
        .unwrap_or_else(|p| panic!("{p}\n{reloaded}"));
    assert_eq!(save(world), reloaded);
    let mut query = world.query::<(&Name, &Material)>();
    let materials: Vec<(String, Material)> = query
        .iter(world)
        .map(|(name, material)| (name.as_str().to_owned(), *material))
        .collect();
    let material = |name: &str| materials.iter().find(|(found, _)| found == name).unwrap().1;
    assert_eq!(material("a").color_map, material("c").color_map);
    assert_ne!(material("b").color_map, material("b").normal_map);
    // Of the MTL: found beside the model, its mask in its alpha.
    let masked = texture(world, material("m").color_map).expect("the picture of the MTL");
    assert_eq!(masked.levels[0].texels, [[65_535, 0, 0, 65_535]]);
    assert_eq!(material("m").alpha_cutoff, Some(0.5));
    assert_eq!(material("n").color_map, None);
    unload(world);
    let left = world.resource::<Textures>().rows();
    assert!(left.iter().all(|texture| texture.levels.is_empty()));
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_broken_picture_is_a_warning_with_its_place() {
    let folder = folder("broken-textures");
    for name in ["broken.tga", "nowhere.png", "a.obj"] {
        let text = format!(
            "(version: 1, materials: {{\"a\": (color_map: \"{name}\")}}, entities: [(material: \"a\", sphere: ()), (light: Point()), (camera: ())])"
        );
        let report = check_text(&text, &folder.join("s.ron"));
        assert!(report.problems.0.is_empty(), "{}", report.problems);
        let [warning] = &report.warnings[..] else {
            panic!("{name}: {:?}", report.warnings);
        };
        assert_eq!((warning.line, warning.column), (1, 43), "{warning}");
        assert!(warning.to_string().contains(name), "{warning}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
