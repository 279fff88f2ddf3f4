//! Files of a render: the pictures that it writes and the reference that it is measured against.

use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::film::{self, Picture};
use crate::image::{Image, ToneCurve, exr, metrics, png};
use crate::settings::Settings;
use crate::{Error, Result, files};

/// Files that a caller asks for. A resumed render takes picture files, tone curve and exposure from its checkpoint where none
/// are given here.
#[derive(Debug, Clone, Default)]
pub struct OutputFiles {
    /// Picture files; the extension chooses EXR or PNG. An empty list means one EXR file with the scene's name.
    pub pictures: Vec<PathBuf>,
    /// Tone curve of PNG files.
    pub tone: Option<ToneCurve>,
    /// Exposure of PNG files in stops.
    pub exposure: Option<f32>,
    /// Seconds between two writings of the unfinished picture. `None` writes the picture at the end only.
    pub write_every: Option<f64>,
    /// Picture that errors are measured against.
    pub reference: Option<PathBuf>,
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
}

/// Files into which the picture is written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PictureFiles {
    pub(super) paths: Vec<PathBuf>,
    tone: ToneCurve,
    exposure: f32,
}

impl PictureFiles {
    /// Chooses the files: the caller's wishes come first, then the files of an `earlier` part of the render, then the defaults.
    /// Every path is tried, so that a file that cannot be written is found before the render begins.
    pub(super) fn new(wanted: &OutputFiles, earlier: Option<&Self>, scene_name: &str) -> Result<Self> {
        let given = |paths: &Vec<PathBuf>| (!paths.is_empty()).then(|| paths.clone());
        let default = || vec![PathBuf::from(format!("{scene_name}.exr"))];
        let files = Self {
            paths: given(&wanted.pictures).or_else(|| given(&earlier?.paths)).unwrap_or_else(default),
            tone: wanted.tone.or_else(|| Some(earlier?.tone)).unwrap_or_default(),
            exposure: wanted.exposure.or_else(|| Some(earlier?.exposure)).unwrap_or_default(),
        };
        let all = files.paths.iter().chain(&wanted.statistics).chain(&wanted.profile);
        all.into_iter().try_for_each(|path| files::check_writable(path))?;
        Ok(files)
    }

    /// No files, for a render whose picture stays in memory.
    pub fn none() -> Self {
        Self { paths: Vec::new(), tone: ToneCurve::default(), exposure: 0.0 }
    }

    /// The files by absolute paths, for a program that is started in another folder.
    ///
    /// # Errors
    /// Where a path is not UTF-8.
    pub(super) fn to_absolute_paths(&self) -> Result<Self> {
        let paths = self.paths.iter().map(|path| absolute_path(path).map(PathBuf::from)).collect::<Result<_>>()?;
        Ok(Self { paths, ..self.clone() })
    }

    /// Writes all files. If one cannot be written, the others still are.
    pub(super) fn write(&self, picture: &Picture, attributes: &[(String, String)]) -> Result<()> {
        let write = |path: &PathBuf| match path.extension().is_some_and(|extension| extension == "png") {
            true => png::write(path, &picture.image(), self.tone, self.exposure),
            false => film::write_picture(path, picture, attributes),
        };
        self.paths.iter().map(write).fold(Ok(()), Result::and)
    }
}

impl Picture {
    /// Writes the picture, whole or not at all. A `.png` file uses the sRGB curve; any other name is an EXR file with all layers.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<()> {
        let files = PictureFiles { paths: vec![path.as_ref().to_path_buf()], ..PictureFiles::none() };
        files.write(self, &[])
    }
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
