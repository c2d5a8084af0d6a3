//! Compiled pipelines kept from one start to the next, where the adapter has a pipeline cache (Vulkan).
//!
//! A file an adapter, in a folder of the user's: a mark, the hash of what follows, and what wgpu gives out, whose header
//! names the adapter, the driver and their versions. wgpu checks that header but not what is behind it, and drivers trust
//! what they are given; so what does not have its hash is not used, and nothing is lost but time. A file is written
//! under another name first, so that none is ever half written.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::context::Gpu;

/// Begins a file.
const MARK: &[u8; 8] = b"ORPIPES1";
const HASH: usize = blake3::OUT_LEN;
/// Larger ones are begun anew: nothing is ever removed from them.
const MOST_BYTES: usize = 64 << 20;

/// A pipeline cache and its file.
pub struct KeptPipelines {
    cache: wgpu::PipelineCache,
    path: PathBuf,
    /// Of what the file holds.
    written: Mutex<Option<blake3::Hash>>,
}

impl KeptPipelines {
    /// What a folder, which need not be there, keeps for this device; none: the adapter has no such cache.
    pub fn open(gpu: &Gpu, folder: &Path) -> Option<Self> {
        let features = gpu.device.features();
        if !features.contains(wgpu::Features::PIPELINE_CACHE) {
            return None;
        }
        let path = folder.join(wgpu::util::pipeline_cache_key(&gpu.info)?);
        let bytes = fs::read(&path).ok();
        let data = bytes.as_deref().and_then(decode);
        let descriptor = wgpu::PipelineCacheDescriptor {
            label: Some("kept pipelines"),
            data,
            // Of another driver or version: it begins empty.
            fallback: true,
        };
        // SAFETY: the data is what `get_data` gave out for this adapter, by name and hash, in the user's own folder; wgpu
        // checks its header besides.
        #[allow(unsafe_code)]
        let cache = unsafe { gpu.device.create_pipeline_cache(&descriptor) };
        Some(Self {
            cache,
            written: Mutex::new(data.map(blake3::hash)),
            path,
        })
    }

    /// What pipelines are created with.
    pub fn cache(&self) -> &wgpu::PipelineCache {
        &self.cache
    }

    /// Writes what has come since it was last written. What cannot be written is not kept.
    pub fn write(&self) {
        let Some(data) = self.cache.get_data() else {
            return;
        };
        let hash = blake3::hash(&data);
        let mut written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
        if *written == Some(hash) {
            return;
        }
        if data.len() > MOST_BYTES {
            // Whatever it says, the next start begins without it.
            let _ = fs::remove_file(&self.path);
            return;
        }
        if replace(&self.path, &encode(&data)).is_ok() {
            *written = Some(hash);
        }
    }
}

fn encode(data: &[u8]) -> Vec<u8> {
    [&MARK[..], blake3::hash(data).as_bytes(), data].concat()
}

/// The data of a file; none: it is not one, or not whole, or not as it was written.
fn decode(bytes: &[u8]) -> Option<&[u8]> {
    let (hash, data) = bytes.strip_prefix(MARK)?.split_at_checked(HASH)?;
    (data.len() <= MOST_BYTES && blake3::hash(data).as_bytes() == hash).then_some(data)
}

/// Puts a file in place of another, whole or not at all.
fn replace(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let unfinished = path.with_extension(format!("{}.unfinished", std::process::id()));
    let replaced = fs::write(&unfinished, bytes).and_then(|()| fs::rename(&unfinished, path));
    if replaced.is_err() {
        // It may not even be there.
        let _ = fs::remove_file(&unfinished);
    }
    replaced
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::gpu::AdapterChoice;

    #[test]
    fn only_what_was_written_is_read() {
        let data: Vec<u8> = (0..200).collect();
        let file = encode(&data);
        assert_eq!(decode(&file), Some(&data[..]));
        for end in 0..file.len() {
            assert_eq!(decode(&file[..end]), None, "cut at {end}");
        }
        for at in 0..file.len() {
            let mut broken = file.clone();
            broken[at] ^= 1;
            assert_eq!(decode(&broken), None, "wrong at {at}");
        }
        assert_eq!(decode(&[&file[..], &[0]].concat()), None);
    }

    #[test]
    fn what_is_broken_is_made_anew() {
        let folder = std::env::temp_dir().join(format!("orrery-pipes-{}", std::process::id()));
        let gpu = Gpu::open(Gpu::instance(), &AdapterChoice::Any, None).expect("a GPU");
        let Some(kept) = KeptPipelines::open(&gpu, &folder) else {
            let features = gpu.device.features();
            assert!(!features.contains(wgpu::Features::PIPELINE_CACHE));
            return;
        };
        kept.write();
        let whole = fs::read(&kept.path).expect("a file");
        assert!(decode(&whole).is_some());
        for broken in [&b"nonsense"[..], &whole[..whole.len() - 1], &[]] {
            fs::write(&kept.path, broken).expect("a file");
            let again = KeptPipelines::open(&gpu, &folder).expect("it begins empty");
            again.write();
            assert!(decode(&fs::read(&kept.path).expect("a file")).is_some());
        }
        gpu.check().expect("nothing went wrong on the device");
        let files = fs::read_dir(&folder).expect("the folder").count();
        assert_eq!(files, 1, "something unfinished was left");
        fs::remove_dir_all(&folder).expect("the folder goes");
    }
}
