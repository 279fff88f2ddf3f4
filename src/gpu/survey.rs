//! Survey of a machine: its Vulkan devices, the one that renders by default, and what keeps others from use.

use std::env;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::context::list_devices;
use super::device_info::DeviceInfo;
use super::diagnosis::{Facts, System, diagnose};
use super::instance::has_loader;
use super::selection;

/// First digits of the PCI class of display controllers.
const DISPLAY_CLASS: &str = "0x03";
/// Environment variables that replace the list of drivers; the first counts.
const DRIVER_LISTS: [&str; 2] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"];
/// Folders with the manifests of Vulkan drivers.
const MANIFEST_FOLDERS: [&str; 4] =
    ["/etc/vulkan/icd.d", "/usr/share/vulkan/icd.d", "/usr/local/share/vulkan/icd.d", "/usr/local/etc/vulkan/icd.d"];
/// Folders with shared libraries, besides those of the processor's architecture.
const LIBRARY_FOLDERS: [&str; 5] = ["/lib64", "/usr/lib64", "/lib", "/usr/lib", "/usr/local/lib"];
const LIBXEXT: &str = "libXext.so.6";

/// The Vulkan devices of this machine, and advice about them.
#[derive(Debug, Clone, Serialize)]
pub struct Survey {
    /// All devices, usable or not.
    pub devices: Vec<DeviceInfo>,
    /// Index of the device that renders; `None` where none can.
    pub default: Option<usize>,
    /// Sentences about what is wrong or slow, each with what to do.
    pub advice: Vec<String>,
}

/// Surveys this machine. `wanted` is the index or a part of the name of the device that renders, if one is chosen.
pub fn survey(wanted: Option<&str>) -> Survey {
    let listed = list_devices();
    let failure = listed.as_ref().err().map(ToString::to_string);
    let devices = listed.unwrap_or_default();
    let chosen = selection::choose(&devices, wanted);
    let default = chosen.as_ref().ok().map(|device| device.index);
    let refusal = chosen.err().map(|error| error.to_string()).filter(|_| !devices.is_empty());
    let mut advice = diagnose(&facts(devices.clone(), default));
    // A failure that no advice explains is said as it is.
    advice.extend(refusal);
    if advice.is_empty() {
        advice.extend(failure);
    }
    Survey { devices, default, advice }
}

/// Facts about this machine. Files that do not exist or cannot be read say nothing.
fn facts(devices: Vec<DeviceInfo>, default: Option<usize>) -> Facts {
    let list = |name: &&'static str| Some((*name, env::var(name).ok().filter(|value| !value.is_empty())?));
    let exists = |path: &str| Path::new(path).exists();
    Facts {
        system: System::HERE,
        has_loader: has_loader(),
        devices,
        default,
        display_vendors: display_vendors(Path::new("/sys/bus/pci/devices")),
        has_nvidia_kernel_driver: exists("/proc/driver/nvidia") || exists("/dev/nvidiactl"),
        nvidia_capabilities: env::var("NVIDIA_DRIVER_CAPABILITIES").ok(),
        has_libxext: has_library(LIBXEXT),
        has_nvidia_manifest: MANIFEST_FOLDERS.iter().any(|folder| names_nvidia(Path::new(folder))),
        closed_device_file: closed_device_file(Path::new("/dev/dri")),
        driver_list: DRIVER_LISTS.iter().find_map(list),
    }
}

/// Entries of a folder by name; none where it cannot be read.
fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().filter_map(io::Result::ok);
    let mut paths: Vec<_> = entries.map(|entry| entry.path()).collect();
    paths.sort();
    paths
}

/// Vendors of all display controllers in a folder like `/sys/bus/pci/devices`.
fn display_vendors(folder: &Path) -> Vec<u32> {
    let text = |path: PathBuf| fs::read_to_string(path).unwrap_or_default().trim().to_owned();
    let displays = entries(folder).into_iter().filter(|device| text(device.join("class")).starts_with(DISPLAY_CLASS));
    displays
        .filter_map(|device| u32::from_str_radix(text(device.join("vendor")).strip_prefix("0x")?, 16).ok())
        .collect()
}

fn names_nvidia(folder: &Path) -> bool {
    entries(folder).iter().any(|path| path.file_name().is_some_and(|name| name.to_string_lossy().contains("nvidia")))
}

/// Whether a shared library is in the linker's cache or in a common folder.
fn has_library(name: &str) -> bool {
    let cache = fs::read("/etc/ld.so.cache").unwrap_or_default();
    let is_cached = cache.windows(name.len()).any(|bytes| bytes == name.as_bytes());
    let own = format!("/usr/lib/{}-linux-gnu", env::consts::ARCH);
    let paths = env::var_os("LD_LIBRARY_PATH").unwrap_or_default();
    let folders = LIBRARY_FOLDERS.iter().map(PathBuf::from).chain([own.into()]).chain(env::split_paths(&paths));
    is_cached || folders.into_iter().any(|folder| folder.join(name).exists())
}

/// First device file of a GPU in a folder like `/dev/dri` that this user may not open.
fn closed_device_file(folder: &Path) -> Option<PathBuf> {
    let is_node = |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("renderD"));
    let is_closed = |path: &PathBuf| {
        let opened = File::options().read(true).write(true).open(path);
        opened.is_err_and(|error| error.kind() == io::ErrorKind::PermissionDenied)
    };
    entries(folder).into_iter().filter(is_node).find(is_closed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn display_controllers_are_found_among_other_devices() {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, class, vendor) in [
            ("0", "0x030000", "0x10de"),
            ("1", "0x020000", "0x1af4"),
            ("2", "0x038000", "0x1002"),
            ("3", "0x030200", "x"),
        ] {
            let device = folder.path().join(name);
            fs::create_dir(&device).expect("a folder");
            fs::write(device.join("class"), format!("{class}\n")).expect("a file");
            fs::write(device.join("vendor"), format!("{vendor}\n")).expect("a file");
        }
        assert_eq!(display_vendors(folder.path()), [0x10de, 0x1002]);
        assert!(display_vendors(&folder.path().join("missing")).is_empty());
    }

    #[test]
    fn a_manifest_is_found_by_its_name() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("lvp_icd.json"), "").expect("a file");
        assert!(!names_nvidia(folder.path()));
        fs::write(folder.path().join("nvidia_icd.json"), "").expect("a file");
        assert!(names_nvidia(folder.path()));
    }

    /// The C library is on every machine that runs this test.
    #[cfg(target_os = "linux")]
    #[test]
    fn libraries_are_found() {
        assert!(has_library("libc.so.6") && !has_library("libno-such-library.so.6"));
    }
}
