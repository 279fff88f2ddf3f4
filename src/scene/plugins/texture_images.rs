//! Decoding of image files to [`Image`]s, in parallel, within the limits of devices.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use rayon::prelude::*;

use super::textures::ImageRequest;
use crate::image::exr;
use crate::image::texels::{self, FileTexels, TexelImage};
use crate::math::srgb::{linear_from_srgb, luminance};
use crate::scene::folders::FoundFile;
use crate::scene::shrink::shrink;
use crate::scene::texture::{Image, Texels};
use crate::{Error, Result};

/// Images of a scene's textures.
pub(super) struct Decoded {
    pub images: Vec<Image>,
    /// Image of each request, by its index. Where a file has a fault, some are missing.
    pub indices: Vec<u32>,
    pub warnings: Vec<String>,
    pub faults: Vec<Error>,
}

/// Decodes every file once.
pub(super) fn decode(requests: &[ImageRequest]) -> Decoded {
    let mut seen = HashSet::new();
    let files: Vec<&FoundFile> =
        requests.iter().map(|request| &request.file).filter(|file| seen.insert(file.path.as_path())).collect();
    let files: Vec<_> = files.par_iter().map(|file| (file.path.as_path(), read(file))).collect();
    let mut files: HashMap<&Path, Result<TexelImage>> = files.into_iter().collect();
    let (mut images, mut warnings, mut faults) = (Vec::with_capacity(requests.len()), Vec::new(), Vec::new());
    // Requests by image, images by request, and the images of bytes, which are the same as heights and as colors.
    let (mut request_of, mut indices, mut of_bytes) = (Vec::new(), Vec::new(), HashMap::new());
    for (i, request) in requests.iter().enumerate() {
        let image = match files.remove(request.file.path.as_path()) {
            Some(Ok(file)) => {
                if requests[i + 1..].iter().any(|later| later.file.path == request.file.path) {
                    files.insert(&request.file.path, Ok(file.clone()));
                }
                image(request, file, &mut warnings)
            }
            Some(Err(error)) => Err(at_line(request, &error)),
            None => Err(request.location.error(format!("the image `{}` was not read", request.name))),
        };
        match image {
            Ok(image) => {
                let next = images.len() as u32;
                let index = match image.texels {
                    Texels::Bytes { .. } => *of_bytes.entry((&request.file.path, request.raw)).or_insert(next),
                    _ => next,
                };
                indices.push(index);
                if index == next {
                    images.push(image);
                    request_of.push(request);
                }
            }
            Err(fault) => faults.push(fault),
        }
    }
    if !faults.is_empty() {
        return Decoded { images, indices, warnings, faults };
    }
    let sizes: Vec<_> = images.iter().map(|image| [image.width, image.height]).collect();
    for i in shrink(&mut images) {
        let (ImageRequest { location, name, .. }, [width, height]) = (request_of[i], sizes[i]);
        let size = format!("{}x{}", images[i].width, images[i].height);
        let message =
            format!("{location}: the image `{name}` of {width}x{height} texels does not fit; reduced to {size}");
        warnings.push(message);
    }
    Decoded { images, indices, warnings, faults }
}

/// Image of an environment, in linear radiance, and what is to be said about values that are no radiance.
pub(super) fn decode_environment(file: &FoundFile) -> Result<(Image, Vec<&'static str>)> {
    let TexelImage { width, height, texels, .. } = read(file)?.in_srgb();
    let linear = match texels {
        FileTexels::Bytes(data) => {
            data.into_iter().map(|texel| decode_srgb(texel.map(|c| f32::from(c) / 255.0))).collect()
        }
        FileTexels::Encoded(data) => data.into_iter().map(decode_srgb).collect(),
        FileTexels::Linear(data) => data,
    };
    let any = |is: fn(f32) -> bool| linear.iter().any(|texel| texel[..3].iter().any(|&channel| is(channel)));
    let notes = [
        (any(|c| c < 0.0), "the environment's image has negative radiance, which counts as 0"),
        (any(|c| c == f32::INFINITY), "the environment's image has infinite radiance, which counts as 65504"),
        (any(f32::is_nan), "the environment's image has values that are no numbers, which count as 0"),
    ];
    let notes = notes.into_iter().filter(|(is_so, _)| *is_so).map(|(_, note)| note).collect();
    let light = |c: f32| match c {
        // Writers of half floats make radiance above the largest one infinite: mostly that of the sun.
        f32::INFINITY => exr::LARGEST_HALF,
        c if c.is_nan() => 0.0,
        c => c.max(0.0),
    };
    let texels = linear.into_iter().map(|[red, green, blue, _]| [light(red), light(green), light(blue), 1.0]).collect();
    Ok((Image { name: file.path.display().to_string(), width, height, texels: Texels::Floats(texels) }, notes))
}

fn read(file: &FoundFile) -> Result<TexelImage> {
    match &file.bytes {
        Some(bytes) => texels::decode(&file.path, bytes),
        None => texels::read(&file.path),
    }
}

fn image(request: &ImageRequest, file: TexelImage, warnings: &mut Vec<String>) -> Result<Image> {
    let file = if request.raw { file } else { file.in_srgb() };
    let mut texels = match file.texels {
        FileTexels::Bytes(data) => Texels::Bytes { srgb: !request.raw, data },
        FileTexels::Encoded(data) if !request.raw => Texels::Floats(data.into_iter().map(decode_srgb).collect()),
        FileTexels::Encoded(data) | FileTexels::Linear(data) => Texels::Floats(data),
    };
    if let Texels::Floats(data) = &mut texels {
        check_floats(request, file.width, data, warnings)?;
        remove_negatives(request, data, warnings);
        if request.is_heights {
            texels = Texels::Heights(data.iter().copied().map(height).collect());
        }
    }
    Ok(Image { name: request.name.clone(), width: file.width, height: file.height, texels })
}

/// Error for a file, with the line of the scene that names it.
fn at_line(request: &ImageRequest, error: &Error) -> Error {
    request.location.error(format!("the image `{}`: {error}", request.name))
}

fn check_floats(request: &ImageRequest, width: u32, data: &[[f32; 4]], warnings: &mut Vec<String>) -> Result<()> {
    let color = |texel: &[f32; 4]| [texel[0], texel[1], texel[2]];
    if let Some(index) = data.iter().position(|texel| !color(texel).iter().all(|value| value.is_finite())) {
        let (x, y) = (index % width as usize, index / width as usize);
        let message = format!("the texel ({x}, {y}) of `{}` is infinite or not a number", request.name);
        return Err(request.location.error(message));
    }
    // Mitsuba warns about values above 1 too.
    if request.is_reflectance && data.iter().any(|texel| color(texel).iter().any(|&value| value > 1.0)) {
        let (location, name) = (&request.location, &request.name);
        warnings
            .push(format!("{location}: the image `{name}` has values above 1, which create light as a reflectance"));
    }
    Ok(())
}

/// Makes negative colors 0 where they stand for light or reflectance: neither can be negative. Heights and normals keep them.
fn remove_negatives(request: &ImageRequest, data: &mut [[f32; 4]], warnings: &mut Vec<String>) {
    let colors = || data.iter().flat_map(|texel| &texel[..3]);
    if !request.is_color || !colors().any(|&channel| channel < 0.0) {
        return;
    }
    data.iter_mut().flat_map(|texel| &mut texel[..3]).for_each(|channel| *channel = channel.max(0.0));
    let (location, name) = (&request.location, &request.name);
    warnings.push(format!("{location}: the image `{name}` has negative colors, which count as 0"));
}

/// Height that a color stands for: its luminance, and for a gray color that color.
fn height([red, green, blue, _]: [f32; 4]) -> f32 {
    let is_gray = red == green && green == blue;
    if is_gray { red } else { luminance([red, green, blue].map(f64::from)) as f32 }
}

/// Texel with its colors decoded by the inverse sRGB curve (IEC 61966-2-1); alpha stays.
fn decode_srgb(texel: [f32; 4]) -> [f32; 4] {
    let [red, green, blue, alpha] = texel;
    let [red, green, blue] = [red, green, blue].map(|value| linear_from_srgb(f64::from(value)) as f32);
    [red, green, blue, alpha]
}
