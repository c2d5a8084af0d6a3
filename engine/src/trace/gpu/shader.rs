//! The WGSL sources, put together for what a scene needs.
//!
//! Composition (`#import`, `#ifdef`) is naga_oil's and stays in this file: everybody else gets plain WGSL
//! from [`shader_source`]. The sources are embedded; a program carries its shaders.

use std::collections::HashMap;

use naga::back::wgsl::WriterFlags;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue,
};

use crate::frame::wire::{GENERATIONS_CAPACITY, TRAVERSAL_CAPACITY};
use crate::frame::{BoxTest, Features, Kernels, Offset, Skip, Skips, TriangleTest};

/// A kernel: a file of `shaders/` with one entry point of the same name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kernel {
    /// Pictures.
    Whitted,
    /// Where a picture needs more samples.
    Edges,
    /// Those samples.
    Antialias,
    /// Rays from a buffer.
    Intersect,
    /// Rays that leave where rays of a buffer arrive.
    Leave,
    /// Deformed positions.
    Deform,
    /// Normals of deformed positions.
    Normals,
    /// A level of meshes' trees.
    Refit,
    /// What refitted trees cost.
    Cost,
    /// The box around boxes' centres.
    Span,
    /// Codes of boxes.
    Morton,
    /// How often each digit is in each block.
    SortCount,
    /// Where each block's digits go.
    SortScan,
    /// Pairs to their places.
    SortScatter,
    /// A level of an instance tree.
    Split,
    /// The boxes of a level of an instance tree.
    Fit,
}

impl Kernel {
    /// All kernels.
    pub const ALL: [Self; 16] = [
        Self::Whitted,
        Self::Edges,
        Self::Antialias,
        Self::Intersect,
        Self::Leave,
        Self::Deform,
        Self::Normals,
        Self::Refit,
        Self::Cost,
        Self::Span,
        Self::Morton,
        Self::SortCount,
        Self::SortScan,
        Self::SortScatter,
        Self::Split,
        Self::Fit,
    ];

    /// File stem and entry point.
    pub fn name(self) -> &'static str {
        self.file().0
    }

    fn source(self) -> &'static str {
        self.file().1
    }

    fn file(self) -> (&'static str, &'static str) {
        macro_rules! file {
            ($name:literal) => {
                (
                    $name,
                    include_str!(concat!("../../../../shaders/", $name, ".wgsl")),
                )
            };
        }
        match self {
            Self::Whitted => file!("whitted"),
            Self::Edges => file!("edges"),
            Self::Antialias => file!("antialias"),
            Self::Intersect => file!("intersect"),
            Self::Leave => file!("leave"),
            Self::Deform => file!("deform"),
            Self::Normals => file!("normals"),
            Self::Refit => file!("refit"),
            Self::Cost => file!("cost"),
            Self::Span => file!("span"),
            Self::Morton => file!("morton"),
            Self::SortCount => file!("sort_count"),
            Self::SortScan => file!("sort_scan"),
            Self::SortScatter => file!("sort_scatter"),
            Self::Split => file!("split"),
            Self::Fit => file!("fit"),
        }
    }
}

/// The rows that host and device share, as their one WGSL file states them.
pub const TYPES_SOURCE: &str = include_str!("../../../../shaders/shared/types.wgsl");

macro_rules! shared {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_str!(concat!("../../../../shaders/shared/", $name, ".wgsl")))),*]
    };
}

/// `shaders/shared`, each after what it imports.
const SHARED: [(&str, &str); 30] = shared![
    "types", "scene", "affine", "slab", "triangle", "sphere", "cuboid", "disc", "cone", "torus",
    "texture", "look", "traverse", "surface", "appear", "counters", "media", "cutoff", "light",
    "trig", "sky", "path", "pixel", "picture", "boxes", "stage", "jobs", "fit", "build", "digits",
];

/// Stacks are multiples of this.
const STACK_STEP: u32 = 32;

/// What a kernel is specialised by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Specialisation {
    /// What the scene needs.
    pub features: Features,
    /// The arithmetic it is traced with.
    pub kernels: Kernels,
    /// Room for deferred rays; see [`Specialisation::new`].
    pub deferred_slots: u32,
    /// Room for nodes that a ray has yet to look into; see [`Specialisation::with_stack`].
    pub stack: u32,
    /// There is a cut-off: what is too faint to matter is left out.
    pub cutoff: bool,
    /// What is left out, as far as kernels go.
    pub skips: Skips,
    /// Rays are counted by kind.
    pub counts: bool,
}

impl Specialisation {
    /// For a scene and a number of generations. One slot a generation would do; the next power of two
    /// from 4 on is taken, so that a slider for the depth does not compile a kernel a step.
    pub fn new(features: Features, max_generations: u32) -> Self {
        let slots = max_generations.clamp(4, GENERATIONS_CAPACITY);
        Self {
            features,
            kernels: Kernels::default(),
            deferred_slots: slots.next_power_of_two(),
            stack: 0,
            cutoff: false,
            skips: Skips::ALL,
            counts: false,
        }
        .with_stack(TRAVERSAL_CAPACITY)
    }

    /// The same for trees that need so much of a stack, and one place that is written to in vain, in steps that few changes of a tree step over. A kernel clears its
    /// stack before anything else, which for the largest took 8 % of a camera ray's time on an NVIDIA H200.
    #[must_use]
    pub fn with_stack(self, need: u32) -> Self {
        let stack = (need + 1).next_multiple_of(STACK_STEP);
        Self { stack, ..self }
    }

    /// Whether a kernel of this traces all that one of the other would.
    pub fn covers(&self, other: &Self) -> bool {
        self.kernels == other.kernels
            && self.skips == other.skips
            && self.features.covers(&other.features)
            && self.deferred_slots >= other.deferred_slots
            && self.stack >= other.stack
            && (self.cutoff || !other.cutoff)
            && (self.counts || !other.counts)
    }

    /// The same with these left out; what is none of a kernel's business makes no other one.
    #[must_use]
    pub fn skipping(self, skips: Skips) -> Self {
        let elsewhere = [Skip::Kernels, Skip::Still, Skip::Trees, Skip::Uploads];
        Self {
            skips: elsewhere.into_iter().fold(skips, Skips::with),
            ..self
        }
    }

    /// The same with this arithmetic.
    #[must_use]
    pub fn with(self, kernels: Kernels) -> Self {
        Self { kernels, ..self }
    }

    fn definitions(self) -> HashMap<String, ShaderDefValue> {
        let (f, k) = (self.features, self.kernels);
        let scatters = f.reflection || f.transmission;
        let faint_lights = self.cutoff && self.skips.has(Skip::FaintLights);
        let faint_rays = self.cutoff && scatters && self.skips.has(Skip::FaintRays);
        let flags = [
            // Total internal reflection mirrors where nothing else does.
            ("REFLECTION", scatters),
            ("TRANSMISSION", f.transmission),
            ("SCATTERS", scatters),
            ("DEFERS", f.reflection && f.transmission),
            ("CUTOFF", faint_lights || faint_rays),
            ("SKIPS_FAINT_LIGHTS", faint_lights),
            ("SKIPS_FAINT_RAYS", faint_rays),
            ("SKIPS_AWAY", self.skips.has(Skip::Away)),
            ("SKIPS_BLACK", self.skips.has(Skip::Black)),
            ("SKIPS_WEIGHTLESS", self.skips.has(Skip::Weightless)),
            ("COUNTS", self.counts),
            ("SMOOTH_NORMALS", f.smooth_normals),
            ("MESHES", f.meshes),
            // Where nothing is a mesh, everything is beside one.
            ("INSTANCES", f.instances || !f.meshes),
            ("SPHERE_TREES", f.sphere_trees),
            ("SPHERES", f.spheres),
            ("PLANES", f.planes),
            ("CUBOIDS", f.cuboids),
            ("DISCS", f.discs),
            ("CONES", f.cones),
            ("OPEN_CONES", f.open_cones),
            ("ABSORPTION", f.absorption && f.transmission),
            ("SKY", f.sky),
            ("PANORAMA", f.sky && f.panorama),
            ("TEXELS", f.reads_texels()),
            ("CURVED", f.curved && f.smooth_normals),
            ("TEXTURES", f.textures),
            ("NORMAL_MAPS", f.textures && f.normal_maps),
            ("VERTEX_COLORS", f.vertex_colors),
            ("CUTOUTS", f.cutouts && (f.textures || f.vertex_colors)),
            ("TINTED", f.textures || f.vertex_colors),
            ("FOOTPRINTS", f.textures),
            ("TORI", f.tori),
            ("SPOT_LIGHTS", f.spot_lights),
            ("DIRECTIONAL_LIGHTS", f.directional_lights),
            ("FADE", f.fade),
            (
                "UNSHARED_EDGES",
                k.triangles == TriangleTest::MollerTrumbore,
            ),
            ("BARE_BOXES", k.boxes == BoxTest::Bare),
            ("FIXED_OFFSETS", k.offsets == Offset::Fixed),
        ];
        let mut definitions: HashMap<_, _> = flags
            .into_iter()
            .filter(|(_, needed)| *needed)
            .map(|(name, _)| (name.to_owned(), ShaderDefValue::Bool(true)))
            .collect();
        let slots = ShaderDefValue::UInt(self.deferred_slots);
        definitions.insert("DEFERRED_SLOTS".to_owned(), slots);
        let stack = ShaderDefValue::UInt(self.stack);
        definitions.insert("STACK".to_owned(), stack);
        definitions
    }
}

/// Puts a kernel together as one validated module.
///
/// # Errors
/// Where the shader is wrong, in naga's words. Shipped shaders compose; a test tries them.
pub fn shader_module(kernel: Kernel, special: Specialisation) -> Result<naga::Module, String> {
    let path = format!("shaders/{}.wgsl", kernel.name());
    composed(kernel.source(), &path, special)
}

/// A file that may import `shaders/shared`, as one module.
fn composed(source: &str, path: &str, special: Specialisation) -> Result<naga::Module, String> {
    let definitions = special.definitions();
    let mut composer = Composer::default().with_capabilities(Capabilities::empty());
    for (name, source) in SHARED {
        let added = composer
            .add_composable_module(ComposableModuleDescriptor {
                source,
                file_path: &format!("shaders/shared/{name}.wgsl"),
                shader_defs: definitions.clone(),
                ..ComposableModuleDescriptor::default()
            })
            .map(|_| ());
        added.map_err(|error| error.emit_to_string(&composer))?;
    }
    composer
        .make_naga_module(NagaModuleDescriptor {
            source,
            file_path: path,
            shader_defs: definitions,
            ..NagaModuleDescriptor::default()
        })
        .map_err(|error| error.emit_to_string(&composer))
}

/// A kernel that a driver can be given.
#[derive(Clone, Debug)]
pub struct Shader {
    /// Plain WGSL.
    pub source: String,
    /// Invocations of a workgroup, as the entry point states them.
    pub workgroup: [u32; 3],
}

/// The kernel as plain WGSL.
///
/// # Errors
/// As [`shader_module`].
pub fn shader_source(kernel: Kernel, special: Specialisation) -> Result<Shader, String> {
    plain(shader_module(kernel, special)?, kernel)
}

/// The source of a kernel that stands in another one's place, as plain WGSL.
pub(super) fn stand_in_source(
    kernel: Kernel,
    (name, source): (&str, &str),
    special: Specialisation,
) -> Result<Shader, String> {
    plain(composed(source, name, special)?, kernel)
}

fn plain(module: naga::Module, kernel: Kernel) -> Result<Shader, String> {
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|error| format!("{}: {error:?}", kernel.name()))?;
    let source = naga::back::wgsl::write_string(&module, &info, WriterFlags::empty())
        .map_err(|error| format!("{}: {error}", kernel.name()))?;
    let entry = module.entry_points.iter().find(|e| e.name == kernel.name());
    let entry = entry.ok_or_else(|| format!("{} has no entry point of its name", kernel.name()))?;
    Ok(Shader {
        source,
        workgroup: entry.workgroup_size,
    })
}
