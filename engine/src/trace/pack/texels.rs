//! All textures as one long memory of texels that is read by number: no sampler, so no two devices filter otherwise.
//!
//! A texture begins with a texel (levels, wrap, 0, 0); then comes one for each level (its place, low 16 bits and high
//! ones, width, height), then the levels' own. Read by the CPU tracer as it is, by the device's as a texture of integers.

use std::sync::Arc;

use crate::frame::wire::{NONE, WRAP_CLAMP, WRAP_MIRROR, WRAP_REPEAT};
use crate::world::{Table, Texture, TextureId, Wrap};

/// Four numbers of 16 bits: linear RGB and alpha, 65535 for 1, or a texture's head.
pub type Texel = [u16; 4];

/// See the module.
#[derive(Default)]
pub struct Texels {
    /// The memory.
    pub memory: Vec<Texel>,
    /// A device's copy is of another memory.
    pub is_stale: bool,
    /// Where each texture begins.
    first: Vec<u32>,
    seen: u64,
}

impl Texels {
    /// Brings the memory up to the frame's textures; whether it had to be made anew.
    pub fn update(&mut self, textures: &Table<Arc<Texture>>) -> bool {
        let version = textures.version();
        if version == self.seen {
            return false;
        }
        self.seen = version;
        self.memory.clear();
        self.first.clear();
        for texture in textures.iter() {
            let first = self.add(texture);
            self.first.push(first);
        }
        self.is_stale = true;
        true
    }

    /// Where a texture begins; [`NONE`]: there is nothing to show.
    pub fn first(&self, texture: Option<TextureId>) -> u32 {
        let first = texture.and_then(|id| self.first.get(id.0 as usize));
        first.copied().unwrap_or(NONE)
    }

    fn add(&mut self, texture: &Texture) -> u32 {
        let first = self.memory.len();
        let heads = 1 + texture.levels.len();
        let texels: usize = texture.levels.iter().map(|level| level.texels.len()).sum();
        if texture.levels.is_empty() || first + heads + texels >= NONE as usize {
            return NONE;
        }
        let wrap = match texture.wrap {
            Wrap::Repeat => WRAP_REPEAT,
            Wrap::Clamp => WRAP_CLAMP,
            Wrap::Mirror => WRAP_MIRROR,
        };
        self.memory
            .push([texture.levels.len() as u16, wrap as u16, 0, 0]);
        let mut place = first + heads;
        for level in &texture.levels {
            let (low, high) = (place as u16, (place >> 16) as u16);
            self.memory
                .push([low, high, level.width as u16, level.height as u16]);
            place += level.texels.len();
        }
        for level in &texture.levels {
            self.memory.extend_from_slice(&level.texels);
        }
        first as u32
    }
}
