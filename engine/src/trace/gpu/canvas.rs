//! The picture on the device, and the passes that trace it.
//!
//! A picture is traced in bands of rows as high as the device's pace allows ([`super::pace`]), a sample a pass; or first its pixels' first samples, then the list of
//! edges, then parts of that list. How long the list is stays on the device where parts are few: they are asked for as if every pixel were on it, and those
//! behind its end find nothing to do, which costs less than the host's waiting or a dispatch of the device's own. A slow device's parts are many,
//! and waiting is little to what they take: there the list's length is asked for first. Each
//! pass is a submission, so that no single one is long. More samples a pass would be slower (4 in one took 7 times as long
//! as 1 on an NVIDIA H200), and software Vulkan ends an invocation's loops after 65,535 rounds in all.

use glam::{UVec2, Vec3, Vec4};

use super::buffers::{create, read};
use super::context::Gpu;
use super::layout::{Layouts, bind};
use super::report::Reports;
use super::shader::Kernel;
use crate::frame::wire::{PassRow, ViewRow};
use crate::trace::progress::{Due, first_samples, is_adaptive};
use crate::trace::{Picture, TraceError};

/// Invocations of a workgroup that works on the list.
const LIST_GROUP: u32 = 64;
/// Rows and columns of pixels of a workgroup that works on the picture.
const TILE: u32 = 8;

/// The picture on the device.
pub struct Canvas {
    /// Pixels across and down.
    pub size: UVec2,
    /// Linear RGB and the number of samples, row by row.
    pub pixels: wgpu::Buffer,
    /// What kernels bind.
    pub group: wgpu::BindGroup,
    /// There is room for a list of all pixels.
    lists: bool,
    /// For [`Canvas::picture`]; made when first asked for.
    staging: Option<wgpu::Buffer>,
}

impl Canvas {
    /// Whether it has room for the picture.
    fn fits(&self, view: &ViewRow) -> bool {
        let size = UVec2::new(view.width, view.height);
        self.size == size && (self.lists || !is_adaptive(view))
    }

    /// A canvas with room for the picture: this one if it will do.
    ///
    /// # Errors
    /// [`TraceError::TooLarge`]; the one before is still there then.
    pub fn fit(
        canvas: &mut Option<Self>,
        gpu: &Gpu,
        layouts: &Layouts,
        reports: &mut Reports,
        view: &ViewRow,
    ) -> Result<(), TraceError> {
        if canvas.as_ref().is_some_and(|canvas| canvas.fits(view)) {
            return Ok(());
        }
        let size = UVec2::new(view.width, view.height);
        let lists = is_adaptive(view);
        let count = u64::from(size.x) * u64::from(size.y);
        let bytes = count * size_of::<Vec4>() as u64;
        let (most, limit) = gpu.most_bound();
        let most_groups = gpu.device.limits().max_compute_workgroups_per_dimension;
        // A workgroup covers at least a pixel each way, so this many groups always suffice.
        let longest = size.max_element();
        if bytes == 0 || bytes > most || longest > most_groups {
            return Err(TraceError::TooLarge(format!(
                "a picture of {} x {} pixels does not fit {}: it takes {bytes} bytes of at most {most} ({limit}), and no side may be longer than {most_groups} (max_compute_workgroups_per_dimension); ask for a smaller size",
                size.x,
                size.y,
                gpu.describe()
            )));
        }
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let pixels = create(gpu, "pixels", usage, bytes);
        reports.make_room(gpu, if lists { count } else { 1 });
        let buffers = [&pixels, &reports.counters];
        *canvas = Some(Self {
            size,
            group: bind(gpu, "picture", &layouts.picture, &buffers),
            pixels,
            lists,
            staging: None,
        });
        Ok(())
    }

    /// The picture, on the host.
    ///
    /// # Errors
    /// [`TraceError::Device`].
    pub fn picture(&mut self, gpu: &Gpu) -> Result<Picture, TraceError> {
        let bytes = self.pixels.size();
        let staging = self.staging.get_or_insert_with(|| {
            let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
            create(gpu, "picture on its way", usage, bytes)
        });
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(&self.pixels, 0, staging, 0, bytes);
        gpu.queue.submit([encoder.finish()]);
        let pixels = read(gpu, staging)?
            .chunks_exact(size_of::<Vec4>())
            .map(|pixel| {
                let [r, g, b, _]: [f32; 4] = bytemuck::pod_read_unaligned(pixel);
                Vec3::new(r, g, b)
            })
            .collect();
        Ok(Picture {
            size: self.size,
            pixels,
        })
    }
}

/// A dispatch of a kernel.
#[derive(Clone, Copy, Debug)]
pub struct Pass {
    /// Which.
    pub kernel: Kernel,
    /// What it works on.
    pub row: PassRow,
    /// Workgroups across and down.
    pub groups: [u32; 2],
}

/// What brings the picture to what is due, but for further samples of edges, in dispatches of at most `most` samples where
/// that is possible.
pub fn passes(view: &ViewRow, due: Due, most: u32) -> Vec<Pass> {
    let next = |limit| PassRow {
        goes_on: 1,
        limit,
        ..PassRow::default()
    };
    let mut passes = Vec::new();
    match due {
        Due::Nothing => {}
        Due::Refinement { limit, by } => {
            for _ in 0..by {
                passes.extend(bands(view, next(limit), most));
            }
        }
        Due::Picture => {
            let first = first_samples(view);
            for taken in 0..first {
                let row = next(first);
                let goes_on = u32::from(taken > 0);
                passes.extend(bands(view, PassRow { goes_on, ..row }, most));
            }
        }
    }
    if due == Due::Picture && is_adaptive(view) {
        passes.push(Pass {
            kernel: Kernel::Edges,
            row: PassRow::default(),
            groups: [view.width.div_ceil(TILE), view.height.div_ceil(TILE)],
        });
    }
    passes
}

/// The further samples of a list of so many edges, in dispatches of at most `most` samples; one at least.
pub fn edge_passes(view: &ViewRow, listed: u32, most: u32) -> Vec<Pass> {
    let row = PassRow {
        goes_on: 1,
        limit: view.samples,
        ..PassRow::default()
    };
    let parts = (1..view.samples).flat_map(|_| parts_of_list(listed.max(1), row, most));
    parts.collect()
}

/// Dispatches of [`edge_passes`] if every pixel is an edge.
pub fn most_edge_passes(view: &ViewRow, most: u32) -> u64 {
    let parts = (view.width * view.height).div_ceil(most);
    u64::from(parts) * u64::from(view.samples - 1)
}

/// A pass in bands of whole workgroups, with at most `most` samples where that is possible.
fn bands(view: &ViewRow, row: PassRow, most: u32) -> impl Iterator<Item = Pass> {
    let (width, height) = (view.width, view.height);
    let rows = (most / width.max(1) / TILE * TILE).clamp(TILE, height.max(TILE));
    (0..height).step_by(rows as usize).map(move |first| {
        let count = rows.min(height - first);
        Pass {
            kernel: Kernel::Whitted,
            row: PassRow {
                first,
                count,
                ..row
            },
            groups: [width.div_ceil(TILE), count.div_ceil(TILE)],
        }
    })
}

/// A pass in parts of the list of edges with at most `most` samples.
fn parts_of_list(listed: u32, row: PassRow, most: u32) -> impl Iterator<Item = Pass> {
    (0..listed).step_by(most as usize).map(move |first| {
        let count = most.min(listed - first);
        Pass {
            kernel: Kernel::Antialias,
            row: PassRow {
                first,
                count,
                ..row
            },
            groups: [count.div_ceil(LIST_GROUP), 1],
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::gpu::{Specialisation, shader_source};

    fn view(width: u32, height: u32, samples: u32, edge_contrast: f32) -> ViewRow {
        ViewRow {
            width,
            height,
            samples,
            edge_contrast,
            ..ViewRow::default()
        }
    }

    /// Samples of each row or entry after the passes of a kernel.
    fn samples(passes: &[Pass], kernel: Kernel, count: u32) -> Vec<u32> {
        let mut samples = vec![0; count as usize];
        for Pass { row, groups, .. } in passes.iter().filter(|pass| pass.kernel == kernel) {
            assert!(groups[0] <= 65_535 && groups[1] <= 65_535);
            for taken in &mut samples[row.first as usize..(row.first + row.count) as usize] {
                let had = if row.goes_on == 1 { *taken } else { 0 };
                *taken = (had + 1).min(row.limit);
            }
        }
        samples
    }

    #[test]
    fn passes_give_every_row_its_samples() {
        for (width, height, of_each) in
            [(1, 1, 1), (640, 480, 1), (1920, 1081, 5), (4096, 2160, 256)]
        {
            let view = view(width, height, of_each, 0.0);
            for most in [1 << 10, 1 << 17, 1 << 20] {
                let passes = passes(&view, Due::Picture, most);
                let taken = samples(&passes, Kernel::Whitted, height);
                assert!(taken.iter().all(|taken| *taken == of_each));
                let least = TILE * width;
                let largest = passes.iter().map(|pass| pass.row.count * width).max();
                assert!(largest <= Some(most.max(least)), "{largest:?} of {most}");
            }
        }
        let (one, refined) = (view(1024, 768, 1, 0.0), Due::Refinement { limit: 9, by: 1 });
        assert_eq!(passes(&one, Due::Picture, 1 << 20).len(), 1);
        assert_eq!(passes(&one, Due::Picture, 1 << 18).len(), 3);
        assert_eq!(passes(&one, refined, 1 << 20).len(), 1);
    }

    #[test]
    fn passes_give_every_edge_its_further_samples() {
        for (width, height, of_each) in [(1, 1, 2), (640, 480, 16), (1920, 1081, 256)] {
            let view = view(width, height, of_each, 0.1);
            let passes = passes(&view, Due::Picture, 1 << 20);
            let first = samples(&passes, Kernel::Whitted, height);
            assert!(first.iter().all(|taken| *taken == 1));
            let last = passes.last().map(|pass| pass.kernel);
            assert_eq!(last, Some(Kernel::Edges));
            let pixels = width * height;
            for (listed, most) in [
                (pixels, 1 << 20),
                (pixels, 1 << 12),
                (pixels / 9, 1 << 10),
                (0, 1 << 10),
            ] {
                let parts = edge_passes(&view, listed, most);
                let added: u64 = parts.iter().map(|pass| u64::from(pass.row.count)).sum();
                assert_eq!(added, u64::from(listed.max(1)) * u64::from(of_each - 1));
                assert!(
                    parts
                        .iter()
                        .all(|pass| pass.row.limit == of_each && pass.row.count <= most)
                );
                assert!(parts.len() as u64 <= most_edge_passes(&view, most));
            }
        }
    }

    #[test]
    fn workgroups_are_as_large_as_the_shaders_say() {
        for (kernel, size) in [
            (Kernel::Whitted, [TILE, TILE, 1]),
            (Kernel::Edges, [TILE, TILE, 1]),
            (Kernel::Antialias, [LIST_GROUP, 1, 1]),
        ] {
            let shader = shader_source(kernel, Specialisation::new(Default::default(), 1));
            assert_eq!(shader.expect("composes").workgroup, size, "{kernel:?}");
        }
    }
}
