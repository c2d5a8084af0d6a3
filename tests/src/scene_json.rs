//! The neutral scenes of the ground-truth set (JSON) as frames.
//!
//! They go into a [`FrameScene`] directly, past the world: what is measured is the tracers. All
//! conventions are those of the set: spanned cameras, linear colours, matrices of three rows applied last.

mod file;

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DAffine3, DMat3, DVec3, UVec2, Vec3};
use orrery_engine::frame::{Features, FrameScene, Instance, Light, LightKind, Shape, View};
use orrery_engine::world::{
    Cone, Fade, Lobe, Material, MeshData, Polygon, Reflection, ToneMap, triangulate,
};

use self::file::{
    LightFile, LobeFile, MaterialFile, ObjectFile, ReflectionFile, SceneFile, ShapeFile,
};

/// A scene of the set, ready to be traced.
#[derive(Clone, Debug)]
pub struct TruthScene {
    /// As in the file; its picture is `reference/NAME.png` unless `invariant_with` says otherwise.
    pub name: String,
    /// Size of the reference picture.
    pub size: UVec2,
    /// Compare with that scene's picture: this one is the same, moved or scaled.
    pub invariant_with: Option<String>,
    /// There is no picture: count pixels that show the background.
    pub is_leak_test: bool,
    /// The frame.
    pub frame: FrameScene,
}

/// Why a scene cannot be traced.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SceneError {
    /// It holds a shape that the engine does not have: its name.
    NotSupported(String),
    /// The file is unreadable or wrong: a sentence.
    Broken(String),
}

/// Reads a scene.
///
/// # Errors
/// See [`SceneError`].
pub fn read(path: &Path) -> Result<TruthScene, SceneError> {
    let broken = |error: String| SceneError::Broken(format!("{}: {error}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|e| broken(e.to_string()))?;
    parse(&text).map_err(|error| match error {
        SceneError::Broken(why) => broken(why),
        other => other,
    })
}

/// Reads a scene from its text.
///
/// # Errors
/// See [`SceneError`].
pub fn parse(text: &str) -> Result<TruthScene, SceneError> {
    let raw: serde_json::Value =
        serde_json::from_str(text).map_err(|e| SceneError::Broken(e.to_string()))?;
    if let Some(kind) = unsupported(&raw) {
        return Err(SceneError::NotSupported(kind));
    }
    let file: SceneFile =
        serde_json::from_value(raw).map_err(|e| SceneError::Broken(e.to_string()))?;
    file.into_scene()
}

const SUPPORTED: [&str; 9] = [
    "sphere", "plane", "box", "disc", "cylinder", "cone", "torus", "mesh", "polygon",
];

/// The names of shapes in the file that are not among [`SUPPORTED`], once each.
fn unsupported(file: &serde_json::Value) -> Option<String> {
    let objects = file.get("objects")?.as_array()?;
    let kinds = objects.iter().filter_map(|o| o.get("type")?.as_str());
    let mut unknown: Vec<&str> = kinds.filter(|k| !SUPPORTED.contains(k)).collect();
    unknown.sort_unstable();
    unknown.dedup();
    (!unknown.is_empty()).then(|| unknown.join(", "))
}

impl SceneFile {
    fn into_scene(self) -> Result<TruthScene, SceneError> {
        let mut frame = FrameScene {
            view: View {
                origin: self.camera.position.into(),
                forward: self.camera.forward.into(),
                right: self.camera.right.into(),
                up: self.camera.up.into(),
                tone_map: ToneMap::Clip,
                ..View::default()
            },
            background: Vec3::from(self.background).into(),
            max_generations: self.max_trace_level,
            lights: self.lights.iter().map(LightFile::light).collect(),
            materials: vec![Material::default()].into(),
            ..FrameScene::default()
        };
        let mut rows = BTreeMap::new();
        for (name, material) in &self.materials {
            rows.insert(name.as_str(), frame.materials.len() as u32);
            frame.materials.push(material.material());
        }
        for (number, object) in self.objects.into_iter().enumerate() {
            let material = *rows.get(object.material.as_str()).ok_or_else(|| {
                SceneError::Broken(format!(
                    "objects[{number}] names the material `{}`; there are {:?}",
                    object.material,
                    rows.keys().collect::<Vec<_>>()
                ))
            })?;
            object
                .add_to(&mut frame, material, number as u64)
                .map_err(|why| SceneError::Broken(format!("objects[{number}]: {why}")))?;
        }
        frame.features = Features::of(&frame);
        Ok(TruthScene {
            name: self.name,
            size: UVec2::new(self.width, self.height),
            invariant_with: self.invariant_with,
            is_leak_test: self.reference_kind.as_deref() == Some("leak-test"),
            frame,
        })
    }
}

impl LightFile {
    fn light(&self) -> Light {
        Light {
            color: self.color.into(),
            fade: self.fade.as_ref().map(|fade| Fade {
                distance: fade.distance,
                power: fade.power,
                ..Fade::default()
            }),
            kind: LightKind::Point {
                position: self.position.into(),
            },
        }
    }
}

impl MaterialFile {
    fn material(&self) -> Material {
        let lobe = |lobe: &LobeFile| Lobe {
            strength: lobe.k,
            exponent: lobe.n,
        };
        Material {
            color: self.color.into(),
            diffuse: self.diffuse,
            emission: self.emission,
            phong: self.phong.as_ref().map(lobe),
            specular: self.specular.as_ref().map(lobe),
            reflection: match &self.reflection {
                None => Reflection::None,
                Some(ReflectionFile::Constant { k }) => Reflection::Constant(Vec3::from(*k)),
                Some(ReflectionFile::Fresnel) => Reflection::Fresnel,
            },
            transmit: self.transmit,
            filter: self.filter,
            ior: self.ior.unwrap_or(1.0),
            ..Material::default()
        }
    }
}

impl ObjectFile {
    fn add_to(self, frame: &mut FrameScene, material: u32, tag: u64) -> Result<(), String> {
        let mut world_from_local = self.matrix.map_or(DAffine3::IDENTITY, affine);
        let mut mesh = |data: MeshData| {
            frame.meshes.push(data.into());
            Shape::Mesh(frame.meshes.len() as u32 - 1)
        };
        let points = |list: Vec<[f64; 3]>| list.into_iter().map(DVec3::from).collect();
        let shape = match self.shape {
            ShapeFile::Sphere { center, radius } => {
                world_from_local *= DAffine3::from_translation(center.into());
                Shape::Sphere { radius }
            }
            ShapeFile::Plane { normal, d } => Shape::Plane {
                normal: normal.into(),
                distance: d,
            },
            ShapeFile::Box { min, max } => Shape::Cuboid {
                min: min.into(),
                max: max.into(),
            },
            ShapeFile::Disc {
                center,
                normal,
                radius,
            } => Shape::Disc {
                center: center.into(),
                normal: normal.into(),
                radius,
            },
            ShapeFile::Cylinder { a, b, radius } => Shape::Cone(Cone {
                a: a.into(),
                radius_a: radius,
                b: b.into(),
                radius_b: radius,
                open: false,
            }),
            ShapeFile::Cone { a, ra, b, rb } => Shape::Cone(Cone {
                a: a.into(),
                radius_a: ra,
                b: b.into(),
                radius_b: rb,
                open: false,
            }),
            ShapeFile::Torus { major, minor } => Shape::Torus { major, minor },
            ShapeFile::Mesh {
                vertices,
                triangles,
            } => mesh(MeshData::new(
                "mesh",
                points(vertices),
                Vec::new(),
                triangles,
            )?),
            ShapeFile::Polygon { loops } => mesh(triangulate(&Polygon {
                loops: loops.into_iter().map(points).collect(),
            })?),
        };
        frame.instances.push(Instance {
            tag,
            shape,
            world_from_local,
            material,
        });
        Ok(())
    }
}

/// Three rows of a 3x4 matrix as an affine map.
fn affine(rows: [[f64; 4]; 3]) -> DAffine3 {
    let column = |i: usize| DVec3::new(rows[0][i], rows[1][i], rows[2][i]);
    DAffine3::from_mat3_translation(DMat3::from_cols(column(0), column(1), column(2)), column(3))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = r#"{
        "name": "small", "width": 4, "height": 2, "max_trace_level": 3, "background": [0.1, 0.2, 0.3],
        "camera": {"position": [0, 0, 5], "forward": [0, 0, -1], "right": [2, 0, 0], "up": [0, 1, 0]},
        "lights": [{"position": [1, 2, 3], "color": [1, 1, 1], "fade": {"distance": 2, "power": 2}}],
        "materials": {"glass": {"color": [1, 1, 1], "diffuse": 0, "emission": 0, "phong": null,
            "specular": {"k": 0.5, "n": 40}, "reflection": {"type": "fresnel"}, "transmit": 1, "filter": 0, "ior": 1.5}},
        "objects": [OBJECT]
    }"#;

    #[test]
    fn a_matrix_applies_after_the_centre() {
        let text = SMALL.replace(
            "OBJECT",
            r#"{"type": "sphere", "center": [1, 0, 0], "radius": 2, "material": "glass",
                "matrix": [[0, -1, 0, 10], [1, 0, 0, 20], [0, 0, 1, 30]]}"#,
        );
        let scene = parse(&text).unwrap();
        let row = &scene.frame.instances[0];
        assert_eq!(
            row.world_from_local.translation,
            DVec3::new(10.0, 21.0, 30.0)
        );
        assert_eq!(row.shape, Shape::Sphere { radius: 2.0 });
        assert!(scene.frame.features.transmission && scene.frame.features.reflection);
    }

    #[test]
    fn shapes_the_engine_lacks_are_named() {
        let text = SMALL.replace(
            "OBJECT",
            r#"{"type": "spring", "turns": 2, "material": "glass"},
               {"type": "blob", "material": "glass"}, {"type": "spring", "material": "glass"}"#,
        );
        let error = parse(&text).unwrap_err();
        assert_eq!(error, SceneError::NotSupported("blob, spring".into()));
    }

    #[test]
    fn an_unknown_material_is_named_with_its_object() {
        let text = SMALL.replace(
            "OBJECT",
            r#"{"type": "plane", "normal": [0, 1, 0], "d": 0, "material": "glas"}"#,
        );
        let SceneError::Broken(why) = parse(&text).unwrap_err() else {
            panic!("expected a broken scene");
        };
        assert!(why.contains("objects[0]") && why.contains("glas"), "{why}");
    }
}
