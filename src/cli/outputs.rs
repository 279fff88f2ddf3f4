//! The files of a render: the pictures it writes and the reference it is measured against.

use std::path::{Path, PathBuf};

use lodestar::film::{self, Picture};
use lodestar::image::{Image, ToneCurve, exr, metrics, png};
use lodestar::scene::Scene;
use lodestar::settings::Settings;
use lodestar::{Error, Result, files};

use serde::{Deserialize, Serialize};

use super::render_args::OutputArgs;

/// The files that the picture goes to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Outputs {
    paths: Vec<PathBuf>,
    tone: ToneCurve,
    exposure: f32,
}

impl Outputs {
    /// What the arguments say, else what was said `before`, else the defaults. Tries every path, those of statistics
    /// and profile included, so that what cannot be written is known before rendering begins.
    pub fn new(args: &OutputArgs, before: Option<&Self>, scene: &Scene) -> Result<Self> {
        let chosen = || (!args.output.is_empty()).then(|| args.output.clone());
        let default = || vec![PathBuf::from(format!("{}.exr", scene.name))];
        let outputs = Self {
            paths: chosen().or_else(|| Some(before?.paths.clone())).unwrap_or_else(default),
            tone: args.tone.or_else(|| Some(before?.tone)).unwrap_or_default(),
            exposure: args.exposure.or_else(|| Some(before?.exposure)).unwrap_or_default(),
        };
        outputs
            .paths
            .iter()
            .chain(&args.stats)
            .chain(&args.profile)
            .try_for_each(|path| files::check_writable(path))?;
        Ok(outputs)
    }

    /// The same from the root, for a program that is started elsewhere.
    ///
    /// # Errors
    /// Where a path is not UTF-8.
    pub fn to_whole_paths(&self) -> Result<Self> {
        let paths = self.paths.iter().map(|path| whole_path(path).map(PathBuf::from)).collect::<Result<_>>()?;
        Ok(Self { paths, ..self.clone() })
    }

    /// Writes all files; one that fails does not keep the others from being written.
    pub fn write(&self, picture: &Picture, attributes: &[(String, String)]) -> Result<()> {
        let write = |path: &PathBuf| match path.extension().is_some_and(|extension| extension == "png") {
            true => png::write(path, &picture.image(), self.tone, self.exposure),
            false => film::write_picture(path, picture, attributes),
        };
        self.paths.iter().map(write).fold(Ok(()), Result::and)
    }
}

/// `path` from the root, as text.
///
/// # Errors
/// Where it is not UTF-8.
pub fn whole_path(path: &Path) -> Result<String> {
    let whole = std::path::absolute(path).map_err(Error::read(path))?;
    let text = whole.to_str().map(str::to_owned);
    text.ok_or_else(|| {
        Error::Settings(format!("{}: a checkpoint cannot name it, for it is not UTF-8", whole.display()))
    })
}

/// The reference, cut to the rendered window where it is as large as the whole film.
pub fn read_reference(path: &Path, settings: &Settings) -> Result<Image> {
    let image = exr::read_rgb(path)?;
    // Against itself, to hear now and not after the first step of what cannot be measured.
    metrics::compare(&image, &image).map_err(|_| {
        Error::image(path, "the reference has pixels that are infinite or not a number; render it again")
    })?;
    let window = settings.window();
    let size = (image.width, image.height);
    if size == (window.width, window.height) {
        return Ok(image);
    }
    let whole = size == (settings.width, settings.height);
    let cut = whole.then(|| image.crop([window.x, window.y], window.width, window.height)).flatten();
    cut.ok_or_else(|| Error::image(path, wrong_size(size, settings)))
}

fn wrong_size((width, height): (u32, u32), settings: &Settings) -> String {
    let window = settings.window();
    format!(
        "the reference has {width} x {height} pixels, but {} x {} are rendered: choose that size with --width and --height",
        window.width, window.height
    )
}
