//! Random scenes whose meshes have looks: pictures of any size, colours at vertices, normal maps, holes.

use std::sync::Arc;

use glam::{Vec2, Vec3, Vec4};
use orrery_engine::frame::{Features, FrameScene};
use orrery_engine::world::{ColorSpace, MeshData, Texture, TextureId, Wrap};

use crate::random_scene::{Random, icosphere, random_scene, smooth_icosphere};

/// Which looks a scene has.
#[derive(Clone, Copy, Debug, Default)]
pub struct Looks {
    /// Pictures.
    pub textures: bool,
    /// Colours at vertices.
    pub colors: bool,
    /// Normal maps.
    pub normals: bool,
    /// Holes by alpha.
    pub holes: bool,
    /// Glass that takes light away, under a sky of three colours.
    pub media: bool,
    /// Smooth meshes that stand for curved surfaces.
    pub curved: bool,
}

impl Looks {
    /// Each alone, and all.
    pub const ALL: [Self; 7] = [
        looks([true, false, false, false, false, false]),
        looks([false, true, false, false, false, false]),
        looks([false, false, true, false, false, false]),
        looks([true, false, false, true, false, false]),
        looks([false, false, false, false, true, false]),
        looks([false, false, false, false, false, true]),
        looks([true; 6]),
    ];
    /// Holes, and pictures that have them.
    pub const HOLES: Self = Self::ALL[3];
    /// All together.
    pub const EVERY: Self = Self::ALL[6];
}

const fn looks([textures, colors, normals, holes, media, curved]: [bool; 6]) -> Looks {
    Looks {
        textures,
        colors,
        normals,
        holes,
        media,
        curved,
    }
}

/// [`random_scene`] with more meshes than it has, in these looks.
pub fn random_looks(seed: u64, looks: Looks) -> FrameScene {
    let mut scene = random_scene(seed, 24);
    let mut random = Random::new(seed + 7);
    let meshes = [icosphere(1), smooth_icosphere(2)];
    scene.meshes = meshes
        .map(|mesh| dressed(mesh, looks, &mut random).into())
        .to_vec()
        .into();
    let mut meshes = random_scene(seed + 50, 80);
    meshes.instances.edit(|instance| {
        if !matches!(instance.shape, orrery_engine::frame::Shape::Mesh(_)) {
            instance.shape = orrery_engine::frame::Shape::Vacant;
        }
    });
    for instance in meshes.instances.iter() {
        scene.instances.push(*instance);
    }
    let wraps = [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror];
    scene.textures = [[16, 16], [13, 7], [1, 5], [8, 8]]
        .into_iter()
        .enumerate()
        .map(|(i, size)| Arc::new(noise(size, wraps[i % 3], i == 3, &mut random)))
        .collect();
    scene.materials.edit(|material| {
        let color_map = TextureId(random.below(3) as u32);
        material.color_map = looks.textures.then_some(color_map);
        material.normal_map = looks.normals.then_some(TextureId(3));
        material.alpha_cutoff = looks.holes.then_some(0.4);
        if looks.media {
            material.absorption = random.cube().as_vec3().abs();
        }
    });
    if looks.media {
        let mut color = |_| random.cube().as_vec3().abs();
        scene.background = scene.background.map(&mut color);
    }
    scene.features = Features::of(&scene);
    scene
}

/// The mesh with texture coordinates and, if asked for, colours.
fn dressed(mesh: MeshData, looks: Looks, random: &mut Random) -> MeshData {
    let (scale, shift) = (random.range(0.3, 1.5), random.cube());
    let uv = |v: &glam::DVec3| {
        let at = (*v + shift) * scale;
        Vec2::new(at.x as f32 + 0.3 * at.z as f32, at.y as f32)
    };
    let uvs: Vec<Vec2> = mesh.vertices.iter().map(uv).collect();
    let mut color = || (random.cube() * 0.5 + 0.5).as_vec3();
    let colors: Vec<Vec4> = mesh
        .vertices
        .iter()
        .map(|_| color().extend(color().x))
        .collect();
    let colors = if looks.colors { colors } else { Vec::new() };
    let mut mesh = mesh;
    mesh.curved = looks.curved;
    mesh.with_looks(uvs, colors).expect("looks that fit")
}

/// A picture of random texels: colours, or normals within 45 degrees of straight out.
fn noise(size: [u32; 2], wrap: Wrap, normals: bool, random: &mut Random) -> Texture {
    let texel = |_| {
        let cube = random.cube().as_vec3();
        let rgb = if normals {
            Vec3::new(cube.x * 0.5, cube.y * 0.5, 1.0) * 0.5 + 0.5
        } else {
            cube * 0.5 + 0.5
        };
        let alpha = random.unit() as f32;
        (rgb.extend(alpha) * 255.0).to_array().map(|x| x as u8)
    };
    let texels: Vec<[u8; 4]> = (0..size[0] * size[1]).map(texel).collect();
    let space = if normals {
        ColorSpace::Linear
    } else {
        ColorSpace::Srgb
    };
    Texture::new("noise", size, texels.as_flattened(), space, wrap).expect("a texture")
}
