//! The GPU tracer: one WGSL kernel a picture, through wgpu.
//!
//! The report (2008) wrote its tracer in CUDA for one maker's cards; here the same algorithm, with the
//! moving scenes it left out, runs on whatever wgpu reaches. [`Gpu`] is the device, [`GpuTracer`] the
//! tracer; the shaders are in `shaders/`, whose README has the table of bindings.
//!
//! What was tried on an NVIDIA H200, 1920x1080, in milliseconds: the rays of a whole frame (primary, shadow, mirrored, shadow) of
//! a terrain of 2.1 million triangles and of 10,001 instances, and those pictures' kernel. Between runs of one form lie about 1 %.
//!
//! | form | terrain: rays, picture | instances: rays, picture |
//! |---|---|---|
//! | wgpu's counter in every loop | 1.97, 2.20 | 6.12, 6.85 |
//! | without it ([`wgpu::ShaderRuntimeChecks`]) | 1.91, 2.10 | 5.98, 6.63 |
//! | that, children sorted as integers, their slots in the low bits | 1.95, 2.15 | 6.02, 6.72 |
//! | that, nodes in a loop of their own within the loop over leaves | 2.09, 2.07 | 6.61, 6.60 |
//! | that, a copy of the walk for any-hit rays | 1.93, 2.09 | 6.06, 6.59 |
//! | that, workgroups of 32 / 128 rays instead of 64 | 1.94 / 1.90 | 6.04 / 5.93 |
//! | **planes read by the direction's signs and met by fused products, children pushed without a branch, a stack as large as trees need, leaves at the cost of one triangle a node** | 1.52, 1.67 | 5.00, 5.54 |
//!
//! One step each, primary and shadow rays of a hall of 148,544 triangles:
//!
//! | form | primary, shadow |
//! |---|---|
//! | a stack of 96 slots, cleared before a ray / of 32 | 0.625, 0.506 / 0.591, 0.466 |
//! | that, triangles not turned by the direction's sign | 0.572, 0.453 |
//! | **all of the table above** | 0.517, 0.413 |
//! | a walk for one mesh alone, without instances, numbers and starting triangles: a bound | 0.468, 0.359 |
//! | that, without bounds checks | 0.466, 0.358 |
//! | that, a subgroup's rays at one node together, nearest child of all first | 0.448, 0.413 |
//! | that, leaves of two triangles at most | 0.446, 0.346 |
//! | that, leaves put off until a whole subgroup has one (Aila and Laine, HPG 2009) | 0.499, 0.364 |
//! | that, one triangle a turn of the loop | 0.434, 0.337 |
//!
//! And then, all rays of the hall and its picture; of 1,001 instances and theirs; the kernel of `bench hope`:
//!
//! | form | hall | instances | hope |
//! |---|---|---|---|
//! | as above | 2.21, 2.34 | 4.12, 4.56 | 1.68 |
//! | that, one mesh alone walked without the tree over instances | 2.05, 2.11 | | |
//! | that, no look whether a child is there (its box is inside out) | 2.00, 2.06 | 4.13, 4.63 | 1.66 |
//! | that, one triangle a turn of the loop | 1.97, 2.02 | 3.88, 4.39 | 1.75 |
//! | that, distances compared as integers, signs by a shift | 1.97, 1.98 | 3.83, 4.30 | 1.70 |
//! | the same, without counts of rays | 1.96, 2.00 | 3.85, 4.21 | 1.64 |
//! | that, a node and a triangle in one turn | 1.90, 1.92 | 3.53, 4.02 | 1.60 |
//! | that, triangles without area asked for last | 1.86, 1.89 | 3.46, 3.92 | 1.62 |
//! | that, instances before nodes in one turn | 1.86, 1.89 | 3.44, 3.73 | 1.60 |
//! | **that, trees cut by area and collapsed at least cost ([`crate::bvh::Tree::build`])** | 1.83, 1.85 | 3.24, 3.50 | 1.58 |
//! | instead, a slot taken off after an instance | | 3.29, 3.71 | 1.51 |
//! | instead, slots taken off before and after an instance | | 3.58, 3.59 | 1.74 |
//! | instead, two nodes and a triangle in one turn | 1.88, 1.95 | 3.52, 3.81 | 1.83 |
//! | instead, two nodes, a slot taken off before each | 1.90, 1.97 | 3.72, 3.81 | 1.99 |
//! | instead, any-hit rays without order of children | 1.88, 1.86 | 3.57, 3.92 | |
//! | first form, children put on the stack by rank, without a sorting network | 2.06, 2.09 | 4.16, 4.65 | 1.64 |
//! | first form, keys sorted, children read when they are taken up | 2.15, 2.30 | 4.12, 4.66 | |
//! | first form, `robustBufferAccess` off, and no bounds checks | 2.21, 2.33 | 4.10, 4.54 | |
//!
//! Solids alone have the slot after them in the same turn: 36 spheres' picture takes 5 % less, 5.28 ms.
//!
//! Queues of rays (generate, intersect, shade, shadow; compacted in between) instead of one kernel were counted, not built. Of all
//! rays of a frame of the demo (8.7 a pixel, up to 59 hits of one) and of `bench hope`'s scene (4.6, up to 19), each taken at the
//! nodes and triangles it visits, lanes are busy 43 % and 61 % of the walks' time in one kernel, and would be 72 % and 74 % were each
//! kind of every generation a queue of its own in the order of pixels. So queues win at most 1.67 and 1.2 times the walks' part, before
//! rays are written and read again. Paths brought together after every hit: at most 16 % and 10 % of the whole; a workgroup's
//! shadow rays shared out among its lanes: 18 % and 3 %. With one mirrored ray a pixel there is nothing to win: a picture takes 1.01 to
//! 1.08 times its rays alone, each kind in the order that a queue would have.
//!
//! Where it goes: two more loads of 16 bytes a node take 4 %, four 6 %; 24 more integer operations 12 %, 24 more fused products 14 %.
//! So instructions count, each like any other, and the lanes that idle in them.
//!
//! Mesa's llvmpipe ends the loops of an invocation after 65,535 turns in all, without a word: pixels that need more (nine generations
//! and more between mirrors and glass) lose light there. The tracer on the processor has no such end.
//!
//! A tree over 2.4 million triangles that fell back on medians for want of room on the stack took 6.04, 6.80, and 3.46, 3.64 with
//! room ([`crate::bvh::TRAVERSAL_CAPACITY`]).

mod adapters;
mod buffers;
mod by_hand;
mod canvas;
mod compile;
mod context;
mod kept;
mod layout;
mod pace;
mod pipelines;
mod rate;
mod rays;
mod readback;
mod report;
mod shader;
mod stack;
mod submit;
#[cfg(test)]
mod tests;
mod texels;
mod tracer;
pub mod trees;
mod upload;

pub use adapters::AdapterChoice;
pub use by_hand::HandKernel;
pub use context::{Gpu, STORAGE_BUFFERS};
pub use layout::{Access, SCENE_BINDINGS, tree_bindings};
pub(crate) use report::{Ends, Report, Reports};
pub use shader::{Kernel, Shader, Specialisation, TYPES_SOURCE, shader_module, shader_source};
pub use tracer::GpuTracer;

/// Where the GPU left the picture: a storage buffer of `size.x * size.y` linear RGBA f32 pixels, top row first.
#[derive(Clone, Debug)]
pub struct DevicePicture {
    /// Pixels across and down.
    pub size: glam::UVec2,
    /// 16 bytes a pixel, usable as read-only storage.
    pub pixels: wgpu::Buffer,
}
