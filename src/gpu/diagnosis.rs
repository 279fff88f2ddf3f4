//! Diagnosis of a machine's Vulkan installation: from facts to sentences that say what is wrong and what to do.

use std::path::PathBuf;

use super::device_info::{DeviceInfo, DeviceKind};

/// Sentence about a missing Vulkan loader, with this system's way to get it.
pub(super) const NO_LOADER: &str = System::HERE.no_loader();
/// Sentence about a missing Vulkan driver, with this system's way to get one.
pub(super) const NO_DRIVER: &str = System::HERE.no_driver();
/// Sentence about a missing validation layer, with this system's way to get it.
pub(super) const NO_LAYER: &str = System::HERE.no_layer();
/// Sentence about a Vulkan loader that is too old.
pub(super) const OLD_LOADER: &str = System::HERE.old_loader();

/// Operating systems whose ways to install a driver differ.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum System {
    #[default]
    Linux,
    MacOs,
    Windows,
}

impl System {
    /// The system that the program was built for.
    pub(super) const HERE: Self = if cfg!(windows) {
        Self::Windows
    } else if cfg!(target_os = "macos") {
        Self::MacOs
    } else {
        Self::Linux
    };

    const fn no_loader(self) -> &'static str {
        match self {
            Self::Linux => "no Vulkan loader found: install it (`apt-get install libvulkan1`, or run setup.sh)",
            Self::MacOs => {
                "no Vulkan loader found: install it with MoltenVK (`brew install vulkan-loader molten-vk`, or run setup.sh)"
            }
            Self::Windows => {
                "no Vulkan loader (vulkan-1.dll) found: install your GPU's driver from its maker, which brings the loader"
            }
        }
    }

    const fn no_driver(self) -> &'static str {
        match self {
            Self::Linux => {
                "no Vulkan driver found: install your GPU's, or `apt-get install mesa-vulkan-drivers` to render on the CPU (setup.sh \
                 does), and check that VK_DRIVER_FILES and VK_ICD_FILENAMES are unset or correct"
            }
            Self::MacOs => {
                "no Vulkan driver found: `brew install molten-vk` (setup.sh does), and check that VK_DRIVER_FILES and \
                 VK_ICD_FILENAMES are unset or correct"
            }
            Self::Windows => {
                "no Vulkan driver found: install your GPU's driver from its maker. To render on the CPU, unpack a build of Mesa for \
                 Windows and set VK_DRIVER_FILES to its lvp_icd.x86_64.json. Check that VK_DRIVER_FILES and VK_ICD_FILENAMES are \
                 otherwise unset"
            }
        }
    }

    const fn no_layer(self) -> &'static str {
        match self {
            Self::Linux => {
                "the validation layer VK_LAYER_KHRONOS_validation is not installed: `apt-get install vulkan-validationlayers` \
                 (setup.sh does), or leave out --validate"
            }
            Self::MacOs => {
                "the validation layer VK_LAYER_KHRONOS_validation is not installed: `brew install vulkan-validationlayers`, or \
                 leave out --validate"
            }
            Self::Windows => {
                "the validation layer VK_LAYER_KHRONOS_validation is not installed: install the Vulkan SDK, or leave out --validate"
            }
        }
    }

    const fn old_loader(self) -> &'static str {
        match self {
            Self::Linux => "the Vulkan loader is older than 1.2: install a newer libvulkan1",
            Self::MacOs => "the Vulkan loader is older than 1.2: `brew upgrade vulkan-loader`",
            Self::Windows => {
                "the Vulkan loader is older than 1.2: install a newer driver of your GPU, which brings a newer loader"
            }
        }
    }
}

/// PCI number of the vendor NVIDIA.
const NVIDIA: u32 = 0x10de;
/// Other vendors of GPUs with Vulkan drivers, by their PCI numbers.
const OTHER_VENDORS: [(u32, &str); 2] = [(0x1002, "AMD"), (0x8086, "Intel")];
/// First version of Mesa's CPU driver that is faster on some processors, and what was measured.
const NEWER_MESA: u32 = 25;
const MEASURED: &str = "Mesa 25.0.7 had 1.2 to 1.38 times the speed of 22.3.6 on an Intel Xeon, but 0.88 times on an AMD EPYC with AVX-512";

/// Facts about a machine that decide which Vulkan devices there are.
#[derive(Debug, Clone, Default)]
pub(super) struct Facts {
    /// Operating system, whose way to install a driver the sentences name.
    pub system: System,
    /// Whether the Vulkan loader can be loaded.
    pub has_loader: bool,
    /// Devices that the loader offers.
    pub devices: Vec<DeviceInfo>,
    /// Index of the device that renders if none is asked for.
    pub default: Option<usize>,
    /// PCI numbers of the vendors of all display controllers.
    pub display_vendors: Vec<u32>,
    /// Whether NVIDIA's kernel driver is loaded or has device files.
    pub has_nvidia_kernel_driver: bool,
    /// Value of NVIDIA_DRIVER_CAPABILITIES, if it is set.
    pub nvidia_capabilities: Option<String>,
    /// Whether libXext.so.6 is installed, which NVIDIA's Vulkan driver needs.
    pub has_libxext: bool,
    /// Whether the system names a Vulkan driver by NVIDIA.
    pub has_nvidia_manifest: bool,
    /// A device file of a GPU that this user may not open.
    pub closed_device_file: Option<PathBuf>,
    /// An environment variable that replaces the list of drivers, with its value.
    pub driver_list: Option<(&'static str, String)>,
}

/// Sentences about everything that keeps a device of the machine from use, or makes it slow. The most basic comes first.
pub(super) fn diagnose(facts: &Facts) -> Vec<String> {
    if !facts.has_loader {
        return vec![facts.system.no_loader().into()];
    }
    let mut sentences = Vec::new();
    if facts.devices.is_empty() {
        sentences.push(facts.system.no_driver().into());
    }
    if let Some((name, value)) = &facts.driver_list
        && !has_hardware_device(facts)
    {
        sentences.push(format!("{name} is `{value}`, so only the drivers in it are used: unset it to use all drivers"));
    }
    sentences.extend(nvidia_sentence(facts));
    sentences.extend(OTHER_VENDORS.iter().filter_map(|&(vendor, name)| vendor_sentence(facts, vendor, name)));
    sentences.extend(mesa_sentence(facts));
    sentences
}

fn has_hardware_device(facts: &Facts) -> bool {
    facts.devices.iter().any(|device| device.kind != DeviceKind::Cpu)
}

fn has_device_of(facts: &Facts, vendor: u32) -> bool {
    facts.devices.iter().any(|device| device.vendor_id == vendor)
}

/// Sentence about a GPU by NVIDIA that Vulkan does not offer. The first missing part is named.
fn nvidia_sentence(facts: &Facts) -> Option<String> {
    let has_card = facts.display_vendors.contains(&NVIDIA);
    if has_device_of(facts, NVIDIA) || !(has_card || facts.has_nvidia_kernel_driver) {
        return None;
    }
    let lacks_graphics = |capabilities: &&String| {
        !capabilities.split(',').any(|capability| ["all", "graphics"].contains(&capability.trim()))
    };
    let cause = match &facts.nvidia_capabilities {
        _ if !facts.has_nvidia_kernel_driver => {
            "its driver is not loaded: install NVIDIA's driver, or start the container with `--gpus all`".into()
        }
        Some(capabilities) if lacks_graphics(&capabilities) => format!(
            "NVIDIA_DRIVER_CAPABILITIES is `{capabilities}`, which leaves Vulkan out: start the container with \
             `-e NVIDIA_DRIVER_CAPABILITIES=all`, or add `graphics`"
        ),
        _ if !facts.has_libxext => {
            "its Vulkan driver cannot be loaded without libXext.so.6: `apt-get install libxext6`".into()
        }
        None if !facts.has_nvidia_manifest => {
            "its Vulkan driver is not installed: install `nvidia-vulkan-icd` (Debian) or `libnvidia-gl` of the kernel driver's \
             version (Ubuntu), or start the container with `-e NVIDIA_DRIVER_CAPABILITIES=all`"
                .into()
        }
        Some(_) if !facts.has_nvidia_manifest => {
            "the system has no nvidia_icd.json, which names its Vulkan driver: install `nvidia-vulkan-icd` (Debian) or \
             `libnvidia-gl` of the kernel driver's version (Ubuntu)"
                .into()
        }
        _ => "its Vulkan driver does not start: VK_LOADER_DEBUG=all shows why, and often the driver and the kernel driver differ \
              in their versions"
            .into(),
    };
    Some(format!("an NVIDIA GPU is there, but {cause}"))
}

/// Sentence about another vendor's GPU where Vulkan offers no GPU at all. A machine may have a second GPU that is not used.
fn vendor_sentence(facts: &Facts, vendor: u32, name: &str) -> Option<String> {
    if !facts.display_vendors.contains(&vendor) || has_hardware_device(facts) {
        return None;
    }
    Some(match &facts.closed_device_file {
        Some(file) => format!(
            "a GPU by {name} is there, but this user may not open {}: `sudo usermod -aG render $USER`, then log in again",
            file.display()
        ),
        None => format!(
            "a GPU by {name} is there, but no Vulkan driver offers it: `apt-get install mesa-vulkan-drivers`, or in a container \
             pass `--device /dev/dri`"
        ),
    })
}

/// Sentence about an old CPU driver, if the CPU renders.
fn mesa_sentence(facts: &Facts) -> Option<String> {
    let device = facts.devices.iter().find(|device| Some(device.index) == facts.default)?;
    let version = device.driver_info.strip_prefix("Mesa ").filter(|_| device.driver_name == "llvmpipe")?;
    let version = version.split(' ').next()?;
    let is_old = version.split('.').next()?.parse::<u32>().is_ok_and(|major| major < NEWER_MESA);
    let way = match facts.system {
        System::Linux => {
            ". To try it on Debian, `./setup.sh --mesa` in Lodestar's sources unpacks one beside the system's"
        }
        System::MacOs | System::Windows => "",
    };
    is_old.then(|| format!("the CPU renders with Mesa {version}; a newer one may be faster: {MEASURED}{way}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::Limits;

    fn device(index: usize, kind: DeviceKind, vendor_id: u32, driver_name: &str, driver_info: &str) -> DeviceInfo {
        DeviceInfo {
            index,
            name: "device".into(),
            kind,
            api_version: "1.3.0".into(),
            driver_name: driver_name.into(),
            driver_info: driver_info.into(),
            vendor_id,
            device_id: 0,
            driver_version: 0,
            pipeline_cache_uuid: String::new(),
            limits: Limits::default(),
            refused: None,
        }
    }

    fn cpu(mesa: &str) -> DeviceInfo {
        device(0, DeviceKind::Cpu, 0x10005, "llvmpipe", mesa)
    }

    /// Facts of a machine without a GPU and with a new CPU driver.
    fn healthy() -> Facts {
        let devices = vec![cpu("Mesa 25.0.7 (LLVM 19.1.7)")];
        Facts { has_loader: true, devices, default: Some(0), has_libxext: true, ..Facts::default() }
    }

    /// Facts of a machine whose GPU by NVIDIA is not offered.
    fn nvidia() -> Facts {
        Facts { display_vendors: vec![NVIDIA], has_nvidia_kernel_driver: true, has_nvidia_manifest: true, ..healthy() }
    }

    #[track_caller]
    fn assert_says(facts: &Facts, expected: &[&[&str]]) {
        let sentences = diagnose(facts);
        assert_eq!(sentences.len(), expected.len(), "{sentences:?}");
        for (sentence, words) in sentences.iter().zip(expected) {
            assert!(words.iter().all(|word| sentence.contains(word)), "{sentence} lacks one of {words:?}");
        }
    }

    #[test]
    fn a_healthy_machine_needs_no_word() {
        assert_says(&healthy(), &[]);
        let gpu = device(1, DeviceKind::Discrete, NVIDIA, "NVIDIA", "550.54");
        // An old CPU driver, and a list of drivers, do no harm where a GPU renders.
        let devices = vec![cpu("Mesa 22.3.6 (LLVM 15.0.6)"), gpu];
        let driver_list = Some(("VK_DRIVER_FILES", "/nvidia.json".into()));
        assert_says(&Facts { devices, default: Some(1), driver_list, ..nvidia() }, &[]);
    }

    #[test]
    fn a_missing_loader_is_all_that_is_said() {
        assert_says(&Facts { has_loader: false, devices: vec![], ..nvidia() }, &[&["no Vulkan loader", "libvulkan1"]]);
    }

    /// Each system has its own way to install what is missing, and names no other's.
    #[test]
    fn advice_names_the_way_of_the_system() {
        let ways = [
            (System::Linux, ["libvulkan1", "mesa-vulkan-drivers"], ["brew", "maker"]),
            (System::MacOs, ["brew install vulkan-loader", "brew install molten-vk"], ["apt-get", "maker"]),
            (System::Windows, ["vulkan-1.dll", "lvp_icd.x86_64.json"], ["apt-get", "setup.sh"]),
        ];
        for (system, [loader, driver], foreign) in ways {
            let nothing = Facts { system, devices: vec![], default: None, ..healthy() };
            assert_says(&Facts { has_loader: false, ..nothing.clone() }, &[&["no Vulkan loader", loader]]);
            assert_says(&nothing, &[&["no Vulkan driver", driver, "VK_DRIVER_FILES"]]);
            let old = Facts { system, devices: vec![cpu("Mesa 22.3.6 (LLVM 15.0.6)")], ..healthy() };
            assert_says(&old, &[&["Mesa 22.3.6"]]);
            let said = [diagnose(&nothing), diagnose(&old), vec![system.no_layer().into(), system.old_loader().into()]];
            assert!(!said.concat().iter().any(|sentence| foreign.iter().any(|way| sentence.contains(way))), "{said:?}");
        }
    }

    #[test]
    fn missing_drivers_are_said_with_the_list_that_replaces_them() {
        let empty = Facts { devices: vec![], default: None, ..healthy() };
        assert_says(&empty, &[&["no Vulkan driver", "mesa-vulkan-drivers"]]);
        let driver_list = Some(("VK_DRIVER_FILES", "/nonexistent".into()));
        let words: [&[&str]; 2] = [&["no Vulkan driver"], &["VK_DRIVER_FILES is `/nonexistent`", "unset"]];
        assert_says(&Facts { driver_list, ..empty }, &words);
    }

    #[test]
    fn an_nvidia_gpu_without_vulkan_is_explained_by_the_first_missing_part() {
        let no_kernel = Facts { has_nvidia_kernel_driver: false, ..nvidia() };
        assert_says(&no_kernel, &[&["an NVIDIA GPU", "driver is not loaded", "--gpus all"]]);
        for capabilities in ["compute,utility", ""] {
            let facts = Facts { nvidia_capabilities: Some(capabilities.into()), has_libxext: false, ..nvidia() };
            assert_says(&facts, &[&[&format!("is `{capabilities}`"), "NVIDIA_DRIVER_CAPABILITIES=all", "graphics"]]);
        }
        for capabilities in [None, Some("all".into()), Some("compute, graphics".into())] {
            let facts = Facts { nvidia_capabilities: capabilities, ..nvidia() };
            assert_says(&Facts { has_libxext: false, ..facts.clone() }, &[&["libXext.so.6", "libxext6"]]);
            assert_says(&Facts { has_nvidia_manifest: false, ..facts.clone() }, &[&["nvidia-vulkan-icd"]]);
            assert_says(&facts, &[&["does not start", "VK_LOADER_DEBUG"]]);
        }
        // Inside a container the card may be hidden while its driver is there.
        assert_says(&Facts { display_vendors: vec![], ..nvidia() }, &[&["an NVIDIA GPU"]]);
    }

    #[test]
    fn a_gpu_beside_a_software_driver_is_explained() {
        let facts = Facts { display_vendors: vec![0x1002], ..healthy() };
        assert_says(&facts, &[&["a GPU by AMD", "mesa-vulkan-drivers", "/dev/dri"]]);
        let closed = Some(PathBuf::from("/dev/dri/renderD128"));
        assert_says(&Facts { closed_device_file: closed, ..facts.clone() }, &[&["/dev/dri/renderD128", "usermod"]]);
        assert_says(&Facts { display_vendors: vec![0x8086], ..healthy() }, &[&["a GPU by Intel"]]);
        // Emulated display controllers are no GPUs.
        assert_says(&Facts { display_vendors: vec![0x1234, 0x1af4], ..healthy() }, &[]);
    }

    #[test]
    fn an_old_cpu_driver_is_said_with_what_was_measured() {
        let old = Facts { devices: vec![cpu("Mesa 22.3.6 (LLVM 15.0.6)")], ..healthy() };
        assert_says(
            &old,
            &[&[
                "Mesa 22.3.6",
                "1.2 to 1.38 times the speed",
                "Intel Xeon",
                "0.88 times on an AMD EPYC",
                "setup.sh --mesa",
            ]],
        );
        for newer in ["Mesa 25.0.0-devel (git-1a2b3c4)", "Mesa 26.1.0", "swiftshader"] {
            assert_says(&Facts { devices: vec![cpu(newer)], ..healthy() }, &[]);
        }
    }
}
