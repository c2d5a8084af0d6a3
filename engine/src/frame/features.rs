//! What a scene makes necessary. What is false here is not compiled, bound or traced.

use glam::Vec3;

use super::{FrameScene, LightKind, Shape};
use crate::world::{Material, MeshData, Reflection, Structure, TextureId};

/// Which parts of a tracer this scene needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Features {
    /// Some material reflects.
    pub reflection: bool,
    /// Some material lets light through: refracted rays, and shadows that are not all or nothing.
    pub transmission: bool,
    /// Some mesh has vertex normals.
    pub smooth_normals: bool,
    /// There are triangle meshes or polygons.
    pub meshes: bool,
    /// There is something beside one mesh, so rays go from one thing to another: a level of trees more than that mesh's own.
    pub instances: bool,
    /// Some mesh is traced with a tree of spheres.
    pub sphere_trees: bool,
    /// There are spheres.
    pub spheres: bool,
    /// There are planes.
    pub planes: bool,
    /// There are boxes.
    pub cuboids: bool,
    /// There are discs.
    pub discs: bool,
    /// There are cylinders or cones.
    pub cones: bool,
    /// Some cylinder or cone is without caps.
    pub open_cones: bool,
    /// There are tori.
    pub tori: bool,
    /// There are spot lights.
    pub spot_lights: bool,
    /// There are directional lights.
    pub directional_lights: bool,
    /// Some light fades with distance.
    pub fade: bool,
    /// The background is not the same everywhere.
    pub sky: bool,
    /// The background has a panorama.
    pub panorama: bool,
    /// Some mesh's triangles stand for a curved surface.
    pub curved: bool,
    /// Some material takes light away within.
    pub absorption: bool,
    /// Some mesh shows a texture.
    pub textures: bool,
    /// Some mesh shows a texture of normals.
    pub normal_maps: bool,
    /// Some mesh has colours at its vertices.
    pub vertex_colors: bool,
    /// Some mesh is not there where its alpha is low.
    pub cutouts: bool,
}

/// A feature by its name, for those who look at one after the other.
pub type NamedFeature = (&'static str, fn(&mut Features) -> &mut bool);

impl Features {
    /// Every one of them.
    pub const NAMED: [NamedFeature; size_of::<Self>()] = [
        ("reflection", |f| &mut f.reflection),
        ("transmission", |f| &mut f.transmission),
        ("smooth_normals", |f| &mut f.smooth_normals),
        ("meshes", |f| &mut f.meshes),
        ("instances", |f| &mut f.instances),
        ("sphere_trees", |f| &mut f.sphere_trees),
        ("spheres", |f| &mut f.spheres),
        ("planes", |f| &mut f.planes),
        ("cuboids", |f| &mut f.cuboids),
        ("discs", |f| &mut f.discs),
        ("cones", |f| &mut f.cones),
        ("open_cones", |f| &mut f.open_cones),
        ("tori", |f| &mut f.tori),
        ("spot_lights", |f| &mut f.spot_lights),
        ("directional_lights", |f| &mut f.directional_lights),
        ("fade", |f| &mut f.fade),
        ("sky", |f| &mut f.sky),
        ("panorama", |f| &mut f.panorama),
        ("curved", |f| &mut f.curved),
        ("absorption", |f| &mut f.absorption),
        ("textures", |f| &mut f.textures),
        ("normal_maps", |f| &mut f.normal_maps),
        ("vertex_colors", |f| &mut f.vertex_colors),
        ("cutouts", |f| &mut f.cutouts),
    ];

    /// Everything: what a tracer is that leaves nothing out.
    pub fn all() -> Self {
        let mut all = Self::default();
        for (_, feature) in Self::NAMED {
            *feature(&mut all) = true;
        }
        all
    }

    /// Whether what serves a scene of these serves one of the others too.
    pub fn covers(&self, others: &Self) -> bool {
        let (mut these, mut others) = (*self, *others);
        Self::NAMED
            .into_iter()
            .all(|(_, feature)| *feature(&mut these) || !*feature(&mut others))
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        let mut these = *self;
        let flags = Self::NAMED.map(|(_, feature)| *feature(&mut these));
        flags.into_iter().filter(|is_there| *is_there).count()
    }

    /// Reads the rows of a scene.
    pub fn of(scene: &FrameScene) -> Self {
        let mut needs = Self::default();
        needs.find_sky(scene);
        for instance in scene.instances.iter() {
            needs.instances |= match instance.shape {
                Shape::Vacant | Shape::Plane { .. } => false,
                // The second.
                Shape::Mesh(_) => needs.meshes,
                _ => true,
            };
            match instance.shape {
                Shape::Vacant => continue,
                Shape::Mesh(mesh) => {
                    needs.meshes = true;
                    let row = &scene.meshes[mesh as usize];
                    let material = &scene.materials[instance.material as usize];
                    needs.find_looks(scene, material, &row.data);
                    let is_smooth = !row.data.normals.is_empty();
                    needs.smooth_normals |= is_smooth;
                    needs.curved |= is_smooth && row.data.curved;
                    needs.sphere_trees |= matches!(row.structure, Structure::Spheres { .. });
                }
                Shape::Sphere { .. } => needs.spheres = true,
                Shape::Plane { .. } => needs.planes = true,
                Shape::Cuboid { .. } => needs.cuboids = true,
                Shape::Disc { .. } => needs.discs = true,
                Shape::Cone(cone) => {
                    needs.cones = true;
                    needs.open_cones |= cone.open;
                }
                Shape::Torus { .. } => needs.tori = true,
            }
            let material = &scene.materials[instance.material as usize];
            needs.reflection |= material.reflection != Reflection::None;
            let transmits = material.transmission().max_element() > 0.0;
            needs.transmission |= transmits;
            needs.absorption |= transmits && material.absorption != Vec3::ZERO;
        }
        for light in scene.lights.iter() {
            needs.spot_lights |= matches!(light.kind, LightKind::Spot { .. });
            needs.directional_lights |= matches!(light.kind, LightKind::Directional { .. });
            needs.fade |= light.fade.is_some();
        }
        needs
    }

    /// Whether pictures of this scene read textures of any kind.
    pub fn reads_texels(&self) -> bool {
        self.textures || (self.sky && self.panorama)
    }

    /// What the background needs.
    pub(super) fn find_sky(&mut self, scene: &FrameScene) {
        let picture = scene.background.picture;
        let texture = picture.and_then(|id| scene.textures.get(id.0 as usize));
        self.sky = !scene.background.is_plain();
        self.panorama = texture.is_some_and(|texture| !texture.levels.is_empty());
    }

    /// Looks of a mesh beyond its material's colour.
    fn find_looks(&mut self, scene: &FrameScene, material: &Material, mesh: &MeshData) {
        let is_there = |map: Option<TextureId>| {
            let texture = map.and_then(|id| scene.textures.get(id.0 as usize));
            !mesh.uvs.is_empty() && texture.is_some_and(|texture| !texture.levels.is_empty())
        };
        let has_colors = !mesh.colors.is_empty();
        let (has_color_map, has_normal_map) =
            (is_there(material.color_map), is_there(material.normal_map));
        self.textures |= has_color_map || has_normal_map;
        self.normal_maps |= has_normal_map;
        self.vertex_colors |= has_colors;
        self.cutouts |= material.alpha_cutoff.is_some() && (has_color_map || has_colors);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_feature_has_one_name() {
        for (i, (_, feature)) in Features::NAMED.into_iter().enumerate() {
            let mut needs = Features::default();
            *feature(&mut needs) = true;
            let found = Features::NAMED.map(|(_, other)| *other(&mut needs));
            assert_eq!(found.iter().filter(|is_set| **is_set).count(), 1);
            assert!(found[i]);
        }
    }
}
