//! A neutral scene as it is written: field by field what the JSON of the ground-truth set holds.

use std::collections::BTreeMap;

use serde::Deserialize;

#[derive(Deserialize)]
pub struct SceneFile {
    pub name: String,
    pub width: u32,
    pub height: u32,
    pub camera: CameraFile,
    pub background: [f32; 3],
    pub max_trace_level: u32,
    pub lights: Vec<LightFile>,
    pub materials: BTreeMap<String, MaterialFile>,
    pub objects: Vec<ObjectFile>,
    pub invariant_with: Option<String>,
    pub reference_kind: Option<String>,
}

#[derive(Deserialize)]
pub struct CameraFile {
    pub position: [f64; 3],
    pub forward: [f64; 3],
    pub right: [f64; 3],
    pub up: [f64; 3],
}

#[derive(Deserialize)]
pub struct LightFile {
    pub position: [f64; 3],
    pub color: [f32; 3],
    pub fade: Option<FadeFile>,
}

#[derive(Deserialize)]
pub struct FadeFile {
    pub distance: f64,
    pub power: f64,
}

#[derive(Deserialize)]
pub struct MaterialFile {
    pub color: [f32; 3],
    pub diffuse: f32,
    pub emission: f32,
    pub phong: Option<LobeFile>,
    pub specular: Option<LobeFile>,
    pub reflection: Option<ReflectionFile>,
    pub transmit: f32,
    pub filter: f32,
    pub ior: Option<f64>,
}

#[derive(Deserialize)]
pub struct LobeFile {
    pub k: f32,
    pub n: f32,
}

#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub enum ReflectionFile {
    Constant { k: [f32; 3] },
    Fresnel,
}

#[derive(Deserialize)]
pub struct ObjectFile {
    pub material: String,
    pub matrix: Option<[[f64; 4]; 3]>,
    #[serde(flatten)]
    pub shape: ShapeFile,
}

#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub enum ShapeFile {
    Sphere {
        center: [f64; 3],
        radius: f64,
    },
    Plane {
        normal: [f64; 3],
        d: f64,
    },
    Box {
        min: [f64; 3],
        max: [f64; 3],
    },
    Disc {
        center: [f64; 3],
        normal: [f64; 3],
        radius: f64,
    },
    Cylinder {
        a: [f64; 3],
        b: [f64; 3],
        radius: f64,
    },
    Cone {
        a: [f64; 3],
        ra: f64,
        b: [f64; 3],
        rb: f64,
    },
    Torus {
        major: f64,
        minor: f64,
    },
    Mesh {
        vertices: Vec<[f64; 3]>,
        triangles: Vec<[u32; 3]>,
    },
    Polygon {
        loops: Vec<Vec<[f64; 3]>>,
    },
}
