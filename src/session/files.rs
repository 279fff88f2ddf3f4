//! Files of a render: the pictures that it writes and the reference that it is measured against.

use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::denoise::DenoiseOptions;
use crate::film::strips::{Pixels, Strips, each, with_rows};
use crate::film::{self, Denoised, Picture, Precision};
use crate::image::canvas::{Canvas, Format};
use crate::image::{Exposure, Image, Luminances, ToneCurve, exr, metrics};
use crate::scene::{Crop, Scene};
use crate::settings::Settings;
use crate::{Error, Result, files};

/// Files that a caller asks for. A resumed render takes picture files, tone curve and exposure from its checkpoint where none
/// are given here.
#[derive(Debug, Clone, Default)]
pub struct OutputFiles {
    /// Picture files; the extension chooses EXR, PNG, JPEG, TIFF or HDR. An empty list means one EXR file with the scene's name.
    pub pictures: Vec<PathBuf>,
    /// Tone curve of PNG, JPEG and TIFF files.
    pub tone: Option<ToneCurve>,
    /// Exposure of PNG, JPEG and TIFF files. Without one, it is automatic for a glTF model, and else 0 stops.
    pub exposure: Option<Exposure>,
    /// Whether the colors of EXR files are half floats.
    pub half: bool,
    /// How the last picture is denoised, if it is. EXR files have a layer `denoised` then, and other files show it.
    pub denoise: Option<DenoiseOptions>,
    /// Whether pictures of other scenes are replaced. Otherwise they are an error.
    pub overwrite: bool,
    /// Seconds between two writings of the unfinished picture. `None` writes the picture at the end only.
    pub write_every: Option<f64>,
    /// Picture that errors are measured against.
    pub reference: Option<PathBuf>,
    /// File for the guide, with which other renders can begin.
    pub guide: Option<PathBuf>,
    /// File for the statistics, as JSON.
    pub statistics: Option<PathBuf>,
    /// File for a trace of all dispatches, as JSON.
    pub profile: Option<PathBuf>,
}

impl OutputFiles {
    /// Interval between two writings of the unfinished picture.
    pub(super) fn write_interval(&self) -> Option<Duration> {
        self.write_every.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())
    }

    /// Fails where a file that is named here cannot be written.
    pub(super) fn check_writable(&self) -> Result<()> {
        let all = self.pictures.iter().chain(&self.guide).chain(&self.statistics).chain(&self.profile);
        all.into_iter().try_for_each(|path| files::check_writable(path))
    }
}

/// Files into which the picture is written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PictureFiles {
    pub(super) paths: Vec<PathBuf>,
    tone: ToneCurve,
    exposure: Exposure,
    #[serde(default)]
    pub(super) half: bool,
}

impl PictureFiles {
    /// Chooses the files: the caller's wishes come first, then the files of an `earlier` part of the render, then the defaults.
    /// Every path is tried, so that a file that cannot be written is found before the render begins.
    pub(super) fn new(wanted: &OutputFiles, earlier: Option<&Self>, scene: &Scene) -> Result<Self> {
        let scene_name = &scene.name;
        let given = |paths: &Vec<PathBuf>| (!paths.is_empty()).then(|| paths.clone());
        let default = || vec![PathBuf::from(format!("{scene_name}.exr"))];
        // Exporters write lamps of glTF models in units that differ by factors of hundreds.
        let of_format = || if scene.is_photometric { Exposure::Auto } else { Exposure::default() };
        let files = Self {
            paths: given(&wanted.pictures).or_else(|| given(&earlier?.paths)).unwrap_or_else(default),
            tone: wanted.tone.or_else(|| Some(earlier?.tone)).unwrap_or_default(),
            exposure: wanted.exposure.or_else(|| Some(earlier?.exposure)).unwrap_or_else(of_format),
            half: wanted.half || earlier.is_some_and(|earlier| earlier.half),
        };
        exr::check_date()?;
        files.paths.iter().try_for_each(|path| files::check_writable(path))?;
        Ok(files)
    }

    /// Refuses files whose format cannot hold a picture of this window.
    pub(super) fn check_size(&self, window: &Crop) -> Result<()> {
        self.paths.iter().try_for_each(|path| {
            let fault = Format::of(path).and_then(|format| format.fault_of_size([window.width, window.height]));
            fault.map_or(Ok(()), |fault| {
                Err(Error::Settings(format!("{}: {fault}; write an .exr file", path.display())))
            })
        })
    }

    /// No files, for a render whose picture stays in memory.
    pub fn none() -> Self {
        Self { paths: Vec::new(), tone: ToneCurve::default(), exposure: Exposure::default(), half: false }
    }

    /// The files by absolute paths, for a program that is started in another folder.
    ///
    /// # Errors
    /// Where a path is not UTF-8.
    pub(super) fn to_absolute_paths(&self) -> Result<Self> {
        let paths = self.paths.iter().map(|path| absolute_path(path).map(PathBuf::from)).collect::<Result<_>>()?;
        Ok(Self { paths, ..self.clone() })
    }

    /// Refuses files of a checkpoint that its user may not expect: a checkpoint may come from somebody else. Names must be those of
    /// pictures, and lie in the checkpoint's folder, in the current folder, or below one of them, with all links followed.
    pub(super) fn check_place(&self, checkpoint: &Path) -> Result<()> {
        let refuse = |path: &Path, fault: &str| {
            let message = format!("its picture is {path:?}, {fault} name the picture with -o");
            Err(Error::checkpoint(checkpoint, message))
        };
        let own = files::written_file(checkpoint).map(|file| files::folder_of(&file).to_path_buf());
        // Everything is below the root, so the root vouches for nothing.
        let current = std::env::current_dir().and_then(|folder| folder.canonicalize());
        let folders: Vec<_> = own.into_iter().chain(current).filter(|folder| folder.parent().is_some()).collect();
        for path in &self.paths {
            if !files::is_picture(path) {
                return refuse(path, "but a picture's name ends in .exr, .png, .jpg, .tif or .hdr;");
            }
            // A folder that does not exist is told when the file is tried.
            let Ok(written) = files::written_file(path) else { continue };
            if !files::is_picture(&written) {
                return refuse(&written, "but a picture's name ends in .exr, .png, .jpg, .tif or .hdr;");
            }
            if !folders.iter().any(|folder| written.starts_with(folder)) {
                return refuse(&written, "outside of the checkpoint's folder and the current one; go on there, or");
            }
        }
        Ok(())
    }

    /// Refuses files that hold the picture of another scene than the one with this hash at the path `scene`. A scene that was
    /// edited has another hash, and a scene that was moved has another path, but another scene differs in both.
    pub(super) fn check_scene(&self, scene: &Path, scene_hash: &str) -> Result<()> {
        self.paths.iter().try_for_each(|path| check_scene(path, &scene.display().to_string(), scene_hash))
    }

    /// Writes all files, and calls `tell` with the share of a file that is written, in [0, 1], again and again; 1 comes once, at its end. If
    /// one cannot be written, the others still are.
    pub(super) fn write(
        &self,
        picture: &dyn Strips,
        denoised: Option<&Denoised>,
        attributes: &[(String, String)],
        tell: &dyn Fn(&Path, f64),
    ) -> Result<()> {
        let precision = if self.half { Precision::Half } else { Precision::Float };
        let stops = self.stops(picture, denoised)?;
        let write = |path: &PathBuf| {
            // The end is told once, when the file has its name.
            let mut tell_share = |share| {
                if share < 1.0 {
                    tell(path, share)
                }
            };
            match Format::of(path) {
                Some(format) => {
                    let canvas = Canvas::new(format, picture.size(), self.tone, stops);
                    let mut read = |rows, colors: &mut Vec<[f32; 3]>| {
                        with_rows(picture, rows, &mut |pixels| colors.extend_from_slice(shown(pixels, denoised)))
                    };
                    canvas.write_rows(path, &mut read, &mut tell_share)?;
                }
                None => film::write_strips(path, picture, attributes, precision, denoised, &mut tell_share)?,
            }
            tell(path, 1.0);
            Ok(())
        };
        self.paths.iter().map(write).fold(Ok(()), Result::and)
    }

    /// Whether a file is for screens and has an exposure that its pixels choose.
    pub(super) fn chooses_exposure(&self) -> bool {
        let mut formats = self.paths.iter().filter_map(|path| Format::of(path));
        self.exposure == Exposure::Auto && formats.any(Format::is_for_screens)
    }

    /// Exposure of the picture in files for screens, in stops.
    fn stops(&self, picture: &dyn Strips, denoised: Option<&Denoised>) -> Result<f32> {
        let mut luminances = Luminances::default();
        if self.chooses_exposure() {
            each(picture, &mut |strip| {
                let shows_surface = strip.picture.hit_count[strip.within.clone()].iter().map(|&count| count > 0);
                luminances.add(shown(strip, denoised).iter().zip(shows_surface));
            })?;
        }
        Ok(self.exposure.stops(luminances))
    }

    /// Line about the exposure of files for screens, where it is automatic.
    pub(super) fn exposure_line(&self, picture: &dyn Strips, denoised: Option<&Denoised>) -> Result<Option<String>> {
        if !self.chooses_exposure() {
            return Ok(None);
        }
        let stops = self.stops(picture, denoised)?;
        Ok(Some(format!(
            "exposure of the picture: {stops} stops, chosen by itself (--exposure {stops} makes the same, --exposure 0 none)"
        )))
    }

    /// Warning that colors are too bright for the files' half floats, if some are.
    pub(super) fn half_warning(&self, picture: &dyn Strips) -> Result<Option<String>> {
        if !self.half || self.paths.iter().all(|path| Format::of(path).is_some()) {
            return Ok(None);
        }
        let mut count = 0;
        each(picture, &mut |strip| {
            let is_bright = |pixel: &&[f32; 3]| pixel.iter().any(|&value| value > exr::LARGEST_HALF);
            count += strip.picture.radiance[strip.within.clone()].iter().filter(is_bright).count();
        })?;
        Ok((count > 0).then(|| {
            let largest = exr::LARGEST_HALF;
            format!("{count} pixels are brighter than {largest}, the largest half float, and are written as {largest}; leave out --half to keep them")
        }))
    }
}

impl Picture {
    /// Writes the picture, whole or not at all. A `.png`, `.jpg` or `.tif` file uses the sRGB curve, a `.hdr` file holds
    /// linear values; any other name is an EXR file with all layers.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<()> {
        let files = PictureFiles { paths: vec![path.as_ref().to_path_buf()], ..PictureFiles::none() };
        files.write(self, None, &[], &|_, _| {})
    }
}

/// Colors of a strip that a file of color alone has: the denoised ones where there are some.
fn shown<'a>(strip: &'a Pixels<'_>, denoised: Option<&'a Denoised>) -> &'a [[f32; 3]] {
    match denoised {
        Some(denoised) => &denoised.pixels[strip.of_whole.clone()],
        None => &strip.picture.radiance[strip.within.clone()],
    }
}

/// Refuses the file at `path` if it holds the picture of another scene. Files that no render of Lodestar has written are not
/// looked after.
fn check_scene(path: &Path, scene: &str, scene_hash: &str) -> Result<()> {
    let Ok(attributes) = exr::read_attributes(path) else { return Ok(()) };
    let value = |name: &str| attributes.iter().find(|(found, _)| found == name).map(|(_, value)| &value[..]);
    let (Some(their_scene), Some(their_hash)) = (value("scene"), value("scene_hash")) else { return Ok(()) };
    // A merged picture names the scene's path on every machine.
    let is_same_file = |other: &str| other == scene || is_same_file(Path::new(other), Path::new(scene));
    if their_hash == scene_hash || their_scene.split(", ").any(is_same_file) {
        return Ok(());
    }
    let message = format!(
        "it is a picture of another scene, {their_scene}; give another name with -o, or replace it with --overwrite"
    );
    Err(Error::image(path, message))
}

/// Whether both paths lead to one existing file, by links or not.
fn is_same_file(a: &Path, b: &Path) -> bool {
    a.canonicalize().ok().zip(b.canonicalize().ok()).is_some_and(|(a, b)| a == b)
}

/// The absolute path of `path`, as text.
///
/// # Errors
/// Where the absolute path is not UTF-8.
pub(super) fn absolute_path(path: &Path) -> Result<String> {
    let absolute = std::path::absolute(path).map_err(Error::read(path))?;
    let text = absolute.to_str().map(str::to_owned);
    text.ok_or_else(|| {
        Error::Settings(format!("{}: a checkpoint cannot hold this path, because it is not UTF-8", absolute.display()))
    })
}

/// Reads the reference. A reference with the size of the whole film is cut to the rendered window.
pub(super) fn read_reference(path: &Path, settings: &Settings) -> Result<Image> {
    if Format::of(path).is_some() {
        let message = "a reference is an EXR picture, whose colors are linear and have no largest value; give one";
        return Err(Error::image(path, message));
    }
    let image = exr::read_rgb(path)?;
    // The comparison with itself refuses a reference with broken pixels before the first step.
    metrics::compare(&image, &image).map_err(|_| {
        Error::image(path, "the reference has pixels that are infinite or not a number; render it again")
    })?;
    let window = settings.window();
    let size = (image.width, image.height);
    if size == (window.width, window.height) {
        return Ok(image);
    }
    let is_whole = size == (settings.width, settings.height);
    let cut = is_whole.then(|| image.crop([window.x, window.y], window.width, window.height)).flatten();
    cut.ok_or_else(|| Error::image(path, wrong_size(size, settings)))
}

fn wrong_size((width, height): (u32, u32), settings: &Settings) -> String {
    let window = settings.window();
    format!(
        "the reference has {width} x {height} pixels, but {} x {} are rendered: choose that size with --width and --height",
        window.width, window.height
    )
}
