//! Compiled pipelines, kept on disk between runs.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::{env, fs, process};

use ash::vk;

use super::device::LogicalDevice;
use super::device_info::DeviceInfo;
use super::fault::failed;
use crate::{Error, Result};

/// Size in bytes of Vulkan's header of a pipeline cache: length, version, vendor, device, uuid.
const HEADER_BYTES: usize = 32;

/// Pipeline cache of one device and driver.
pub(super) struct PipelineCache {
    raw: vk::PipelineCache,
    file: Option<PathBuf>,
    /// Checksum of the data read from the file; 0 where none was read.
    loaded: u64,
    device: Arc<LogicalDevice>,
}

impl PipelineCache {
    pub(super) fn new(device: Arc<LogicalDevice>) -> Result<Self> {
        let file = folder().map(|folder| folder.join(file_name(device.info())));
        let data = file.as_deref().and_then(|file| load(file, device.info())).unwrap_or_default();
        let info = vk::PipelineCacheCreateInfo::default().initial_data(&data);
        // SAFETY: invariant 1: the device is alive, and `data` is a local, unchanged since this driver wrote it.
        let raw =
            unsafe { device.raw().create_pipeline_cache(&info, None) }.map_err(failed("vkCreatePipelineCache"))?;
        let loaded = if data.is_empty() { 0 } else { checksum(&data) };
        Ok(Self { raw, file, loaded, device })
    }

    /// Handle of the cache, for a call during which the caller borrows this value.
    pub(super) fn raw(&self) -> vk::PipelineCache {
        self.raw
    }

    /// Writes the file, unless nothing is new or the system has no cache folder.
    fn save(&self) -> Result<()> {
        let Some(file) = &self.file else { return Ok(()) };
        // SAFETY: invariant 1: device and cache are alive.
        let data = unsafe { self.device.raw().get_pipeline_cache_data(self.raw) };
        let data = data.map_err(failed("vkGetPipelineCacheData"))?;
        if data.len() <= HEADER_BYTES || checksum(&data) == self.loaded {
            return Ok(());
        }
        write_whole(file, &sealed(data)).map_err(Error::write(file))
    }
}

impl Drop for PipelineCache {
    fn drop(&mut self) {
        if let Err(error) = self.save() {
            tracing::warn!("the pipeline cache could not be saved: {error}");
        }
        // SAFETY: invariants 1 and 2: owned by this value alone, and the kernels made with it are gone.
        unsafe { self.device.raw().destroy_pipeline_cache(self.raw, None) }
    }
}

/// Content of the file; `None` where it is damaged or was written by another driver.
fn load(file: &Path, info: &DeviceInfo) -> Option<Vec<u8>> {
    let data = unsealed(fs::read(file).ok()?)?;
    has_header_of(&data, info).then_some(data)
}

fn has_header_of(data: &[u8], info: &DeviceInfo) -> bool {
    let word =
        |place: usize| data.get(place..place + 4).and_then(|bytes| bytes.try_into().ok()).map(u32::from_ne_bytes);
    let uuid = data.get(16..HEADER_BYTES).unwrap_or_default();
    let uuid: String = uuid.iter().map(|byte| format!("{byte:02x}")).collect();
    word(0) == Some(HEADER_BYTES as u32)
        && word(4) == Some(vk::PipelineCacheHeaderVersion::ONE.as_raw() as u32)
        && word(8) == Some(info.vendor_id)
        && word(12) == Some(info.device_id)
        && uuid == info.pipeline_cache_uuid
}

/// Appends a checksum: drivers check the header at best, and a damaged body has crashed some.
fn sealed(mut data: Vec<u8>) -> Vec<u8> {
    let seal = checksum(&data).to_le_bytes();
    data.extend(seal);
    data
}

fn unsealed(mut data: Vec<u8>) -> Option<Vec<u8>> {
    let (body, seal) = data.split_last_chunk::<8>()?;
    let (len, is_whole) = (body.len(), u64::from_le_bytes(*seal) == checksum(body));
    data.truncate(len);
    is_whole.then_some(data)
}

/// FNV-1a hash of 64 bits.
fn checksum(data: &[u8]) -> u64 {
    data.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// Writes a file under a temporary name of this process and renames it, so that a reader never sees half a file.
fn write_whole(file: &Path, data: &[u8]) -> std::io::Result<()> {
    if let Some(folder) = file.parent() {
        fs::create_dir_all(folder)?;
    }
    // The address distinguishes contexts of one process that are dropped at the same time.
    let temporary = file.with_extension(format!("{}-{:x}", process::id(), data.as_ptr() as usize));
    let written = fs::write(&temporary, data).and_then(|()| fs::rename(&temporary, file));
    if written.is_err() {
        // A failure to remove it has the cause that the first error already reports.
        let _ = fs::remove_file(&temporary);
    }
    written
}

fn file_name(info: &DeviceInfo) -> String {
    let DeviceInfo { vendor_id, device_id, driver_version, pipeline_cache_uuid, .. } = info;
    format!("pipelines-{vendor_id:x}-{device_id:x}-{driver_version:x}-{pipeline_cache_uuid}.bin")
}

/// The user's cache folder for Lodestar; `None` where the system names none.
fn folder() -> Option<PathBuf> {
    let variable = |name| env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let caches = if cfg!(windows) {
        variable("LOCALAPPDATA")
    } else if cfg!(target_os = "macos") {
        variable("HOME").map(|home| home.join("Library/Caches"))
    } else {
        variable("XDG_CACHE_HOME")
            .filter(|folder| folder.is_absolute())
            .or_else(|| variable("HOME").map(|home| home.join(".cache")))
    };
    caches.map(|caches| caches.join("lodestar"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::list_devices;

    fn device() -> DeviceInfo {
        list_devices().expect("devices").swap_remove(0)
    }

    fn cache_of(info: &DeviceInfo) -> Vec<u8> {
        let words = [HEADER_BYTES as u32, 1, info.vendor_id, info.device_id];
        let digits = info.pipeline_cache_uuid.as_bytes().chunks(2);
        let uuid = digits.map(|digits| u8::from_str_radix(&String::from_utf8_lossy(digits), 16).expect("hexadecimal"));
        words.into_iter().flat_map(u32::to_ne_bytes).chain(uuid).chain(0..200).collect()
    }

    #[test]
    fn a_file_of_this_driver_is_read_back() {
        let (info, folder) = (device(), tempfile::tempdir().expect("a folder"));
        let file = folder.path().join("new/folder").join(file_name(&info));
        let data = cache_of(&info);
        write_whole(&file, &sealed(data.clone())).expect("a file");
        assert_eq!(load(&file, &info), Some(data));
        let left = fs::read_dir(file.parent().expect("a folder")).expect("a folder").count();
        assert_eq!(left, 1, "the temporary file is gone");
    }

    #[test]
    fn a_broken_or_foreign_file_is_ignored() {
        let (info, folder) = (device(), tempfile::tempdir().expect("a folder"));
        let file = folder.path().join("cache");
        assert_eq!(load(&file, &info), None);
        let whole = sealed(cache_of(&info));
        let mut flipped = whole.clone();
        flipped[100] ^= 1;
        let mut foreign = cache_of(&info);
        foreign[8] ^= 1;
        for content in [&[][..], &whole[..7], &whole[..whole.len() - 1], &flipped, &sealed(foreign), &sealed(vec![])] {
            fs::write(&file, content).expect("a file");
            assert_eq!(load(&file, &info), None);
        }
    }

    #[test]
    fn an_unwritable_place_is_an_error_and_leaves_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("file");
        fs::create_dir(&file).expect("a folder in its place");
        assert!(write_whole(&file, &[1]).is_err());
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
    }
}
