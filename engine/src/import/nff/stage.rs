//! What has been read so far, and the statements that put light, camera, fills, scopes and other files there.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::rc::Rc;

use glam::{DQuat, DVec3, Vec3};

use super::batch::Batch;
use super::keys::Block;
use super::look::{Fill, light_without_color, linear};
use super::moving::Moving;
use super::words::{Mark, Words};
use crate::import::{Content, Model, Node};
use crate::world::{Camera, PointLight, Projection, Transform};

/// Things that a file may make, also by including others again and again.
const NODES: usize = 1 << 21;
/// Bytes that may be read of included files, those read again counted again.
const INCLUDED_BYTES: usize = 128 << 20;
/// Includes below one another.
const INCLUDE_DEPTH: usize = 16;
/// Transforms below one another.
const SCOPE_DEPTH: usize = 200;
/// What keys call the eye.
const CAMERA: &str = "camera";

/// A model in the making.
pub struct Stage<'a> {
    open: &'a dyn Fn(&str) -> Result<String, String>,
    /// Included files.
    texts: HashMap<String, Rc<str>>,
    included_bytes: usize,
    include_depth: usize,
    /// Includes of more detail are left out.
    detail: f64,
    pub(super) model: Model,
    /// The file itself, and the transforms that reading is inside of.
    pub(super) scopes: Vec<Scope>,
    /// Those of the rows of [`Model::materials`].
    pub(super) fills: Vec<Fill>,
    /// Row of the one that shapes get.
    pub(super) fill: Option<usize>,
    ambient: Vec3,
    /// Nodes, and the colours that the file gives.
    lights: Vec<(usize, Option<Vec3>)>,
    /// Nodes that keys can name.
    pub(super) named: HashMap<String, Vec<usize>>,
    pub(super) blocks: Vec<Block>,
    /// Seconds from which to which the file plays.
    pub(super) span: Option<[f64; 2]>,
    /// Names of pictures that the file lays on surfaces.
    pub(super) textures: BTreeSet<String>,
    /// Parts of the indexed meshes read so far, by file and place, and where reading goes on.
    pub(super) meshes: HashMap<(String, usize), (Option<usize>, Mark)>,
}

/// A transform, and what stands below it that is not yet a part.
#[derive(Default)]
pub struct Scope {
    pub node: Option<usize>,
    /// By fill, and whether they have normals.
    pub batches: BTreeMap<(Option<usize>, bool), Batch>,
    /// By fill.
    pub moving: BTreeMap<Option<usize>, Moving>,
}

impl<'a> Stage<'a> {
    pub fn new(open: &'a dyn Fn(&str) -> Result<String, String>) -> Self {
        Self {
            open,
            texts: HashMap::new(),
            included_bytes: 0,
            include_depth: 0,
            detail: 0.0,
            model: Model::default(),
            scopes: vec![Scope::default()],
            fills: Vec::new(),
            fill: None,
            ambient: Vec3::ONE,
            lights: Vec::new(),
            named: HashMap::new(),
            blocks: Vec::new(),
            span: None,
            textures: BTreeSet::new(),
            meshes: HashMap::new(),
        }
    }

    /// Reads all statements of a text. `file` names it in sentences; empty: the file itself.
    pub fn read(&mut self, text: &str, file: &str) -> Result<(), String> {
        let outer = self.scopes.len();
        let mut words = Words::new(text, file);
        while let Some(word) = words.next() {
            if word == "}" {
                if self.scopes.len() == outer {
                    return Err(format!("{}: `}}` without its `{{`", words.place()));
                }
                self.leave_scope()?;
            } else {
                self.statement(word, &mut words)?;
            }
        }
        while self.scopes.len() > outer {
            self.model.warnings.push(format!(
                "{}: the file ends inside of a transform",
                words.place()
            ));
            self.leave_scope()?;
        }
        Ok(())
    }

    fn statement(&mut self, word: &str, words: &mut Words) -> Result<(), String> {
        match word {
            "v" => self.view(words),
            "b" => {
                let display = words.color("the background's red, green, blue")?;
                self.model.background = Some(linear(display));
                Ok(())
            }
            "l" => self.light(words),
            "la" => {
                let name = words.word("the name of a light")?;
                self.light(words)?;
                if let Some(&(node, _)) = self.lights.last() {
                    self.named.entry(name.to_owned()).or_default().push(node);
                }
                Ok(())
            }
            "am" => {
                self.ambient = words.color("the ambient light's red, green, blue")?;
                Ok(())
            }
            "f" => self.fill_of_nff(words),
            "fm" => self.fill_of_aff(words),
            "c" => self.cone(words),
            "s" => self.sphere(words),
            "p" => self.polygon(words, false),
            "pp" => self.polygon(words, true),
            "tt" => self.textured_triangle(words, false),
            "ttp" => self.textured_triangle(words, true),
            "tpa" => self.moving_triangle(words),
            "m" => self.mesh(words),
            "xs" => self.static_transform(words),
            "x" => self.animated_transform(words),
            "k" => {
                let block = Block::read(words, &mut self.model.warnings)?;
                self.blocks.push(block);
                Ok(())
            }
            "a" => {
                let [start, end] = [words.number("the start")?, words.number("the end")?];
                words.number("the number of frames")?;
                self.span = Some([start, end.max(start)]);
                Ok(())
            }
            "d" => {
                self.detail = words.number("the level of detail")?;
                Ok(())
            }
            "i" => self.include(words),
            // How finely other readers cut curved shapes, which are exact here.
            "tess" => words.number("the fineness").map(drop),
            _ => Err(unknown(word, words)),
        }
    }

    fn view(&mut self, words: &mut Words) -> Result<(), String> {
        words.expect("from")?;
        let from = words.point("the eye's place")?;
        words.expect("at")?;
        let at = words.point("the place looked at")?;
        words.expect("up")?;
        let up = words.vector("the direction up")?;
        words.expect("angle")?;
        let angle = words.number("the angle in degrees")?;
        words.expect("hither")?;
        words.number("the hither distance")?;
        words.expect("resolution")?;
        let [_, height] = [(); 2].map(|()| words.number("a number of pixels"));
        if !(angle > 0.0 && angle < 180.0) {
            let place = words.place();
            return Err(format!("{place}: an angle of {angle} degrees sees nothing"));
        }
        let vertical_fov = opening(angle.to_radians(), height?);
        let camera = Camera {
            projection: Projection::Perspective { vertical_fov },
            ..Camera::default()
        };
        let pose = Transform::looking_at(from, at, up);
        let node = self.node(CAMERA, pose, vec![Content::Camera(camera)])?;
        self.named.entry(CAMERA.to_owned()).or_default().push(node);
        Ok(())
    }

    fn light(&mut self, words: &mut Words) -> Result<(), String> {
        let place = words.point("the light's place")?;
        let color = if words.is_number_next() {
            Some(words.color("the light's red, green, blue")?)
        } else {
            None
        };
        let pose = Transform::from_translation(place);
        // Its colour may depend on how many there will be.
        let content = Content::Point(PointLight::default());
        let node = self.node("light", pose, vec![content])?;
        self.lights.push((node, color));
        Ok(())
    }

    fn static_transform(&mut self, words: &mut Words) -> Result<(), String> {
        let scale = words.point("a scale")?;
        let rotation = turned(
            words.vector("the axis of a rotation")?,
            words.number("an angle in degrees")?,
        );
        let translation = words.point("a translation")?;
        words.expect("{")?;
        let pose = Transform {
            translation,
            rotation,
            scale,
        };
        self.enter_scope("", pose, words)
    }

    fn animated_transform(&mut self, words: &mut Words) -> Result<(), String> {
        let name = words.word("the name of a transform")?;
        words.expect("{")?;
        self.enter_scope(name, Transform::IDENTITY, words)?;
        let node = self.scopes.last().and_then(|scope| scope.node);
        self.named.entry(name.to_owned()).or_default().extend(node);
        Ok(())
    }

    fn enter_scope(&mut self, name: &str, pose: Transform, words: &Words) -> Result<(), String> {
        if self.scopes.len() > SCOPE_DEPTH {
            let place = words.place();
            return Err(format!(
                "{place}: more than {SCOPE_DEPTH} transforms below one another"
            ));
        }
        let node = Some(self.node(name, pose, Vec::new())?);
        self.scopes.push(Scope {
            node,
            ..Scope::default()
        });
        Ok(())
    }

    fn leave_scope(&mut self) -> Result<(), String> {
        self.make_parts()?;
        self.scopes.pop();
        Ok(())
    }

    fn include(&mut self, words: &mut Words) -> Result<(), String> {
        let detail = words.number("a level of detail")?;
        let name = words.word("the name of a file")?;
        if detail > self.detail {
            return Ok(());
        }
        let place = words.place();
        if self.include_depth == INCLUDE_DEPTH {
            return Err(format!(
                "{place}: `{name}` is the {INCLUDE_DEPTH}th include below another"
            ));
        }
        let text = match self.texts.get(name) {
            Some(text) => Rc::clone(text),
            None => match (self.open)(name) {
                Ok(text) => {
                    let text: Rc<str> = text.into();
                    self.texts.insert(name.to_owned(), Rc::clone(&text));
                    text
                }
                Err(why) => {
                    let warning = format!("{place}: the included file `{name}` is left out: {why}");
                    self.model.warnings.push(warning);
                    return Ok(());
                }
            },
        };
        // An empty one counts too, or it could be included without end.
        self.included_bytes += text.len() + 256;
        if self.included_bytes > INCLUDED_BYTES {
            let most = INCLUDED_BYTES >> 20;
            return Err(format!(
                "{place}: its includes come to more than {most} MiB"
            ));
        }
        self.include_depth += 1;
        self.read(&text, name)?;
        self.include_depth -= 1;
        Ok(())
    }

    /// Adds an entity to be below the transform that reading is inside of.
    pub(super) fn node(
        &mut self,
        name: &str,
        pose: Transform,
        contents: Vec<Content>,
    ) -> Result<usize, String> {
        if self.model.nodes.len() == NODES {
            return Err(format!("it makes more than {NODES} things"));
        }
        Ok(self.model.add_node(Node {
            name: name.to_owned(),
            parent: self.scopes.last().and_then(|scope| scope.node),
            pose,
            contents,
            ..Node::default()
        }))
    }

    /// One sentence for all: a scene may have hundreds.
    fn warn_of_textures(&mut self) {
        let Some(first) = self.textures.first() else {
            return;
        };
        let short: String = first.chars().take(60).collect();
        let warning = match self.textures.len() {
            1 => format!("the texture `{short}` is left out: a plain colour is in its place"),
            count => format!(
                "{count} textures are left out, `{short}` first: plain colours are in their place"
            ),
        };
        self.model.warnings.push(warning);
    }

    /// What remains to be done when all has been read.
    pub fn finish(mut self) -> Result<Model, String> {
        self.make_parts()?;
        if self
            .model
            .contents()
            .all(|c| c.is_light() || matches!(c, Content::Camera(_)))
        {
            return Err("it has no shape".into());
        }
        self.warn_of_textures();
        let lights = self.lights.len();
        for (row, fill) in self.fills.iter().enumerate() {
            let material = fill.material(self.ambient);
            self.model
                .materials
                .push((format!("fill {}", row + 1), material));
        }
        for &(node, color) in &self.lights {
            let color = color.unwrap_or(light_without_color(lights));
            self.model.nodes[node].contents = vec![Content::Point(PointLight {
                color,
                ..PointLight::default()
            })];
        }
        self.animate();
        Ok(self.model)
    }
}

/// A rotation by so many degrees; none about no axis.
pub fn turned(axis: DVec3, degrees: f64) -> DQuat {
    match axis.try_normalize() {
        Some(axis) => DQuat::from_axis_angle(axis, degrees.to_radians()),
        None => DQuat::IDENTITY,
    }
}

/// The opening of all rows of pixels where the middles of the outer ones are so far apart.
fn opening(angle: f64, rows: f64) -> f64 {
    let wider = if rows >= 2.0 {
        rows / (rows - 1.0)
    } else {
        1.0
    };
    2.0 * ((0.5 * angle).tan() * wider).atan()
}

fn unknown(word: &str, words: &Words) -> String {
    let place = words.place();
    if word == "nff" {
        return format!("{place}: it is an NFF file of Sense8, another format of the same name");
    }
    let short: String = word.chars().take(24).collect();
    format!(
        "{place}: `{short}` is no statement of NFF (b, v, l, f, c, s, p, pp) or AFF (am, fm, m, tt, ttp, tpa, i, d, x, xs, k, a, la)"
    )
}
