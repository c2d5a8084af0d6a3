//! The file itself, and its entities.

use super::clip::{ClipFile, read_clips, write_clips};
use super::primitive::At;
use super::timeline::write_all;
use super::{BackgroundFile, Deform, Light, MaterialFile, Motion, Pose, Shape, Timeline, range};
use crate::scene::reader::{Fields, Reader, Schema};
use crate::scene::syntax::{Kind, Node};
use crate::scene::writer::Writer;
use crate::world::{Camera, Structure, TraceDepth};

/// The version of the format written here, and the only one there is so far.
pub const VERSION: u32 = 1;

/// A scene file.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// What rays see that hit nothing.
    pub background: BackgroundFile,
    /// Generations of rays followed.
    pub max_generations: u32,
    /// Id of the camera in use; none: the first visible one.
    pub active_camera: Option<At<String>>,
    /// The material table in order.
    pub materials: Vec<(At<String>, MaterialFile)>,
    /// Entities without a parent, in order.
    pub entities: Vec<Entity>,
    /// What moves.
    pub timeline: Timeline,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            background: BackgroundFile::default(),
            max_generations: TraceDepth::default().0,
            active_camera: None,
            materials: Vec::new(),
            entities: Vec::new(),
            timeline: Timeline::default(),
        }
    }
}

/// An entity and what is below it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Entity {
    /// Unique among entities; none: one is made up at load.
    pub id: Option<At<String>>,
    /// What people read; none: the id.
    pub name: Option<String>,
    /// Hidden with all its children?
    pub hidden: bool,
    /// Where it is.
    pub pose: Pose,
    /// What can be hit.
    pub shape: Option<Shape>,
    /// What is done to its mesh.
    pub deform: Deform,
    /// What of its model's animations is played.
    pub clips: Vec<ClipFile>,
    /// What its mesh is traced with; none: the fastest, shared with all that show the same mesh.
    pub structure: Option<Structure>,
    /// What moves it without the timeline.
    pub motion: Motion,
    /// Id of its material; none: the default one, or that of the mesh's file.
    pub material: Option<At<String>>,
    /// What shines.
    pub light: Option<Light>,
    /// What looks.
    pub camera: Option<Camera>,
    /// Entities that move along.
    pub children: Vec<Self>,
}

const SCENE_FIELDS: [&str; 7] = [
    "version",
    "background",
    "max_generations",
    "active_camera",
    "materials",
    "entities",
    "timeline",
];

impl Schema for Scene {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let fields = reader.record(node, &SCENE_FIELDS, "a scene")?;
        read_version(reader, &fields);
        let default = Self::default();
        Some(Self {
            background: fields
                .read(reader, "background")
                .unwrap_or(default.background),
            max_generations: fields
                .read_checked(reader, "max_generations", range::generations)
                .unwrap_or(default.max_generations),
            active_camera: fields.read(reader, "active_camera"),
            materials: fields
                .with(reader, "materials", read_materials)
                .unwrap_or_default(),
            entities: fields
                .with(reader, "entities", read_entities)
                .unwrap_or_default(),
            timeline: fields.read(reader, "timeline").unwrap_or_default(),
        })
    }

    fn write(&self, writer: &mut Writer) {
        let default = Self::default();
        writer.record(None, |writer| {
            writer.field("version", &VERSION);
            writer.field_unless_default("background", &self.background, &default.background);
            writer.field_unless_default(
                "max_generations",
                &self.max_generations,
                &default.max_generations,
            );
            writer.field_if("active_camera", self.active_camera.as_ref());
            if !self.materials.is_empty() {
                writer.element("materials: ", |writer| {
                    write_materials(writer, &self.materials)
                });
            }
            write_all(writer, "entities: ", &self.entities);
            if self.timeline != default.timeline {
                writer.field("timeline", &self.timeline);
            }
        });
    }
}

fn read_version(reader: &mut Reader, fields: &Fields) {
    let Some(entry) = fields.get("version") else {
        reader.expected(
            fields.at,
            "`version` is missing",
            format!("`version: {VERSION}`"),
        );
        return;
    };
    if let Some(version) = fields.read::<u32>(reader, "version")
        && version != VERSION
    {
        reader.within(".version", |reader| {
            reader.expected(
                entry.value.at,
                format!("found version {version}"),
                format!("version {VERSION}, the only one this program reads"),
            );
        });
    }
}

fn read_materials(reader: &mut Reader, node: &Node) -> Option<Vec<(At<String>, MaterialFile)>> {
    let Kind::Map(pairs) = &node.kind else {
        return reader.mismatch(node, "a table of materials `{\"name\": (...), ...}`");
    };
    let mut materials: Vec<(At<String>, MaterialFile)> = Vec::new();
    for (key, value) in pairs {
        let Some(id) = At::<String>::read(reader, key) else {
            continue;
        };
        reader.within(&format!("[{:?}]", id.value), |reader| {
            if materials.iter().any(|(before, _)| *before == id) {
                reader.expected(
                    key.at,
                    format!("the material `{}` is there twice", id.value),
                    "another name",
                );
            }
            // A broken material is still a name that shapes may use.
            materials.push((id, MaterialFile::read(reader, value).unwrap_or_default()));
        });
    }
    Some(materials)
}

fn write_materials(writer: &mut Writer, materials: &[(At<String>, MaterialFile)]) {
    writer.map(|writer| {
        for (id, material) in materials {
            let mut key = Writer::inline();
            key.string(&id.value);
            writer.element(&format!("{}: ", key.finish()), |writer| {
                material.write(writer)
            });
        }
    });
}

fn read_entities(reader: &mut Reader, node: &Node) -> Option<Vec<Entity>> {
    reader.list(node, "entities", Entity::read)
}

const ENTITY_FIELDS: [&str; 21] = [
    "id",
    "name",
    "visible",
    "transform",
    "sphere",
    "plane",
    "box",
    "disc",
    "cylinder",
    "cone",
    "torus",
    "polygon",
    "mesh",
    "deform",
    "clip",
    "structure",
    "motion",
    "material",
    "light",
    "camera",
    "children",
];

impl Schema for Entity {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let label = match &node.kind {
            Kind::Record(_, entries) => entries.iter().find_map(|entry| match &entry.value.kind {
                Kind::Text(id) if entry.name == "id" => {
                    Some(format!(" \"{}\"", id.chars().take(60).collect::<String>()))
                }
                _ => None,
            }),
            _ => None,
        };
        reader.within(&label.unwrap_or_default(), |reader| {
            read_entity(reader, node)
        })
    }

    fn write(&self, writer: &mut Writer) {
        writer.record(None, |writer| {
            writer.field_if("id", self.id.as_ref());
            writer.field_if("name", self.name.as_ref());
            if self.hidden {
                writer.field("visible", &false);
            }
            writer.field_unless_default("transform", &self.pose, &Pose::default());
            if let Some(shape) = &self.shape {
                shape.write_field(writer);
            }
            writer.field_unless_default("deform", &self.deform, &Deform::default());
            write_clips(writer, &self.clips);
            writer.field_if("structure", self.structure.as_ref());
            writer.field_unless_default("motion", &self.motion, &Motion::default());
            writer.field_if("material", self.material.as_ref());
            writer.field_if("light", self.light.as_ref());
            writer.field_if("camera", self.camera.as_ref());
            write_all(writer, "children: ", &self.children);
        });
    }
}

fn read_entity(reader: &mut Reader, node: &Node) -> Option<Entity> {
    let fields = reader.record(node, &ENTITY_FIELDS, "an entity")?;
    let id: Option<At<String>> = fields.read(reader, "id");
    if let Some(id) = id.as_ref().filter(|id| id.value.is_empty()) {
        reader.expected(id.place.at, "found an empty id", "a name");
    }
    let shapes: Vec<&str> = Shape::NAMES
        .into_iter()
        .filter(|name| fields.get(name).is_some())
        .collect();
    if let [first, second, ..] = shapes.as_slice()
        && let Some(entry) = fields.get(second)
    {
        reader.expected(
            entry.at,
            format!("found both `{first}` and `{second}`"),
            "one shape an entity; put the other into `children`",
        );
    }
    let has_triangles = ["polygon", "mesh"]
        .iter()
        .any(|name| fields.get(name).is_some());
    for name in ["deform", "structure"] {
        if let Some(entry) = fields.get(name).filter(|_| !has_triangles) {
            let found = format!("found `{name}` of an entity without triangles");
            reader.expected(entry.at, found, "a mesh or a polygon beside it");
        }
    }
    if let Some(entry) = fields.get("clip").filter(|_| fields.get("mesh").is_none()) {
        reader.expected(
            entry.at,
            "found `clip` of an entity without a mesh file",
            "a mesh beside it",
        );
    }
    let shape = Shape::read_first(reader, &fields);
    Some(Entity {
        id,
        name: fields.read(reader, "name"),
        hidden: fields.read(reader, "visible") == Some(false),
        pose: fields.read(reader, "transform").unwrap_or_default(),
        shape,
        deform: fields.read(reader, "deform").unwrap_or_default(),
        clips: fields.with(reader, "clip", read_clips).unwrap_or_default(),
        structure: fields.read(reader, "structure"),
        motion: fields.read(reader, "motion").unwrap_or_default(),
        material: fields.read(reader, "material"),
        light: fields.read(reader, "light"),
        camera: fields.read(reader, "camera"),
        children: fields
            .with(reader, "children", read_entities)
            .unwrap_or_default(),
    })
}
