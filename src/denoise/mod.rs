//! Denoising by Intel's Open Image Denoise 2, which is loaded while the program runs. Neither building nor rendering needs it.
//!
//! A denoised picture is biased. It is a layer of its own beside the radiance, which stays as it was sampled.
//!
//! | part | file |
//! |---|---|
//! | search for the library | `search.rs` |
//! | its C interface, and all `unsafe` of this room | `library.rs` |
//! | pictures: which layers go in, and which files come out | `pictures.rs` |

mod library;
pub mod pictures;
mod search;

use std::path::PathBuf;

use library::{Device, Oidn, PhysicalDevice};
pub use search::FOLDER_VARIABLE;
use strum::{EnumMessage, IntoStaticStr, VariantArray};

use crate::{Error, Result};

/// Choices about the denoiser.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct DenoiseOptions {
    /// Folder of the library. `None` searches in [`FOLDER_VARIABLE`], beside the program and in the system.
    pub folder: Option<PathBuf>,
    /// Kind of device that denoises.
    pub device: DeviceKind,
}

/// Kind of device that denoises.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, EnumMessage, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
pub enum DeviceKind {
    /// The processor. The bits are the same in each run.
    #[default]
    Cpu,
    /// An Intel GPU.
    Sycl,
    /// An NVIDIA GPU.
    Cuda,
    /// An AMD GPU.
    Hip,
    /// An Apple GPU.
    Metal,
}

impl DeviceKind {
    /// Number of the kind in the library (`OIDNDeviceType`).
    fn number(self) -> i32 {
        match self {
            Self::Cpu => 1,
            Self::Sycl => 2,
            Self::Cuda => 3,
            Self::Hip => 4,
            Self::Metal => 5,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Cpu => "CPU",
            Self::Sycl => "SYCL",
            Self::Cuda => "CUDA",
            Self::Hip => "HIP",
            Self::Metal => "Metal",
        }
    }
}

/// Pictures that the denoiser reads: linear colors and features of the first hit, row by row from the top left.
#[derive(Debug, Clone, Copy)]
pub struct Features<'a> {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Mean radiance, linear and of any range.
    pub color: &'a [[f32; 3]],
    /// Mean albedo, if it is known.
    pub albedo: Option<&'a [[f32; 3]]>,
    /// Mean shading normal, if it is known. Without albedo it is not used, because the library cannot use it alone.
    pub normal: Option<&'a [[f32; 3]]>,
}

/// The loaded library and the device that it uses.
pub struct Denoiser {
    library: Oidn,
    device: PhysicalDevice,
    /// Name and version of the library, such as `Open Image Denoise 2.3.0`.
    version: String,
    kind: DeviceKind,
}

impl Denoiser {
    /// Loads the library and tries the device.
    ///
    /// # Errors
    /// [`Error::Settings`] where there is no library or no such device.
    pub fn open(options: &DenoiseOptions) -> Result<Self> {
        let library = search::find(options.folder.as_deref())?;
        let kind = options.device;
        let device = library.devices().into_iter().find(|device| device.kind == kind.number());
        let device = device.ok_or_else(|| {
            let name = kind.name();
            Error::Settings(format!("Open Image Denoise finds no {name} device here; denoise with --oidn-device cpu"))
        })?;
        let [major, minor, patch] = library.open(device.id).map_err(failure)?.version();
        if major != 2 {
            let message =
                format!("the Open Image Denoise found is {major}.{minor}.{patch}; name a 2.x with --oidn DIR");
            return Err(Error::Settings(message));
        }
        Ok(Self { library, device, version: format!("Open Image Denoise {major}.{minor}.{patch}"), kind })
    }

    /// Name and version of the library.
    pub fn version(&self) -> &str {
        &self.version
    }

    /// Kind and name of the device, such as `CPU (AMD EPYC)`.
    pub fn device(&self) -> String {
        format!("{} ({})", self.kind.name(), self.device.name.trim())
    }

    /// Denoises a picture of any range. Albedo and normal are denoised first. Values that are no finite numbers count as 0.
    ///
    /// # Errors
    /// [`Error::Render`] where the library fails, such as for lack of memory, or where the pictures' sizes differ.
    pub fn denoise(&self, features: &Features<'_>) -> Result<Vec<[f32; 3]>> {
        let size = [features.width as usize, features.height as usize];
        if features.color.is_empty() {
            return Ok(Vec::new());
        }
        let run = || {
            let device = self.library.open(self.device.id)?;
            let albedo = features.albedo.map(|albedo| prefiltered(&device, "albedo", albedo, size)).transpose()?;
            let normal = features.normal.filter(|_| albedo.is_some());
            let normal = normal.map(|normal| prefiltered(&device, "normal", normal, size)).transpose()?;
            denoised(&device, &finite(features.color), albedo.as_deref(), normal.as_deref(), size)
        };
        run().map_err(failure)
    }
}

fn failure(reason: String) -> Error {
    Error::Render(format!("Open Image Denoise failed: {reason}"))
}

/// Pixels with 0 in place of values that are no finite numbers.
fn finite(pixels: &[[f32; 3]]) -> Vec<[f32; 3]> {
    pixels.iter().map(|pixel| pixel.map(|value| if value.is_finite() { value } else { 0.0 })).collect()
}

/// The feature `name` without its noise, by a filter of its own.
fn prefiltered(
    device: &Device<'_>,
    name: &str,
    pixels: &[[f32; 3]],
    size: [usize; 2],
) -> Result<Vec<[f32; 3]>, String> {
    let pixels = finite(pixels);
    let (input, output) = (device.buffer(&pixels)?, device.buffer(&pixels)?);
    let filter = device.filter()?;
    filter.set_image(name, &input, size)?;
    filter.set_image("output", &output, size)?;
    filter.run()?;
    output.read()
}

/// The color without its noise. Albedo and normal have none.
fn denoised(
    device: &Device<'_>,
    color: &[[f32; 3]],
    albedo: Option<&[[f32; 3]]>,
    normal: Option<&[[f32; 3]]>,
    size: [usize; 2],
) -> Result<Vec<[f32; 3]>, String> {
    let (input, output) = (device.buffer(color)?, device.buffer(color)?);
    let buffer = |pixels: Option<&[[f32; 3]]>| pixels.map(|pixels| device.buffer(pixels)).transpose();
    let features = [("albedo", buffer(albedo)?), ("normal", buffer(normal)?)];
    let filter = device.filter()?;
    filter.set_image("color", &input, size)?;
    filter.set_image("output", &output, size)?;
    for (name, buffer) in &features {
        buffer.as_ref().map_or(Ok(()), |buffer| filter.set_image(name, buffer, size))?;
    }
    // The color is linear and has no upper limit.
    filter.turn_on("hdr")?;
    if albedo.is_some() {
        filter.turn_on("cleanAux")?;
    }
    filter.run()?;
    output.read()
}
