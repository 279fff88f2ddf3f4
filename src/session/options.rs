//! Everything that a caller may choose about a render, each with a default.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::fleet::exchange::Exchange;
use crate::gpu::{Context, ContextOptions};
use crate::scene::{Crop, ReconstructionFilter, Scene, Window};
use crate::session::files::OutputFiles;
use crate::session::length::Length;
use crate::settings::{Execution, Sampler, Settings, Traversal, depth_warning};
use crate::{Error, Result};

/// Samples per pixel if neither the caller nor the scene limits the render.
const DEFAULT_SPP: u32 = 64;
/// Seconds between two writings of a checkpoint.
pub const CHECKPOINT_EVERY: f64 = 60.0;

/// Size of the film.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum FilmSize {
    /// The scene's own size.
    #[default]
    OfScene,
    /// The scene's own size times a factor.
    Scaled(f32),
    /// Width and height in pixels.
    Pixels(u32, u32),
    /// Width in pixels, and a height that keeps the scene's aspect ratio.
    Width(u32),
    /// Height in pixels, and a width that keeps the scene's aspect ratio.
    Height(u32),
}

/// The device that renders.
#[derive(Clone)]
pub(super) enum DeviceChoice {
    /// A device to open.
    Open(ContextOptions),
    /// A device that is open already.
    Opened(Arc<Context>),
}

type Change = Arc<dyn Fn(&mut Settings) + Send + Sync>;
type Check = Arc<dyn Fn(&Settings) -> Result<()> + Send + Sync>;

/// Options of a render. Every option has a default: the scene's own choice where it makes one, 64 samples per pixel, the best
/// device, no files.
///
/// ```
/// use lodestar::settings::Sampler;
/// let options = lodestar::Options::new().samples(256).size(640, 480).seed(7).sampler(Sampler::Bsdf);
/// ```
#[derive(Clone)]
pub struct Options {
    pub(super) length: Length,
    size: FilmSize,
    crop: Option<Window>,
    filter: Option<ReconstructionFilter>,
    max_depth: Option<u32>,
    rr_depth: Option<u32>,
    changes: Vec<Change>,
    checks: Vec<Check>,
    pub(super) device: DeviceChoice,
    slice_milliseconds: Option<f64>,
    execution: Option<Execution>,
    traversal: Option<Traversal>,
    pub(super) kernel_folder: Option<PathBuf>,
    /// `None` keeps the picture in memory only.
    pub(super) files: Option<OutputFiles>,
    pub(super) checkpoint: Option<PathBuf>,
    pub(super) checkpoint_every: f64,
    pub(super) guide: Option<PathBuf>,
    /// Whether tiles are dealt out to devices by their measured speed.
    pub(super) deals_by_speed: bool,
    /// Connection to the other ranks of the render, where it has several.
    pub(super) exchange: Option<Arc<dyn Exchange>>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            length: Length::default(),
            size: FilmSize::OfScene,
            crop: None,
            filter: None,
            max_depth: None,
            rr_depth: None,
            changes: Vec::new(),
            checks: Vec::new(),
            device: DeviceChoice::Open(ContextOptions::default()),
            slice_milliseconds: None,
            execution: None,
            traversal: None,
            kernel_folder: None,
            files: None,
            checkpoint: None,
            checkpoint_every: CHECKPOINT_EVERY,
            guide: None,
            deals_by_speed: false,
            exchange: None,
        }
    }
}

/// Length, film, paths and guide.
impl Options {
    /// The defaults.
    pub fn new() -> Self {
        Self::default()
    }

    /// Ends the render after this number of samples per pixel.
    #[must_use]
    pub fn samples(mut self, per_pixel: u32) -> Self {
        self.length.spp = Some(per_pixel);
        self
    }

    /// Ends the render after this number of seconds. Loading does not count.
    #[must_use]
    pub fn seconds(mut self, seconds: f64) -> Self {
        self.length.seconds = Some(seconds);
        self
    }

    /// Sets the size of the film in pixels.
    #[must_use]
    pub fn size(self, width: u32, height: u32) -> Self {
        self.film_size(FilmSize::Pixels(width, height))
    }

    /// Sets the size of the film.
    #[must_use]
    pub fn film_size(self, size: FilmSize) -> Self {
        Self { size, ..self }
    }

    /// Renders only this window of the film.
    #[must_use]
    pub fn crop(self, crop: Crop) -> Self {
        Self { crop: Some(Window::Pixels(crop)), ..self }
    }

    /// Renders only this window of the film, in pixels or in shares of the film.
    #[must_use]
    pub fn window(self, window: Window) -> Self {
        Self { crop: Some(window), ..self }
    }

    /// Sets the reconstruction filter.
    #[must_use]
    pub fn filter(self, filter: ReconstructionFilter) -> Self {
        Self { filter: Some(filter), ..self }
    }

    /// Sets the longest path in edges.
    #[must_use]
    pub fn max_depth(self, edges: u32) -> Self {
        Self { max_depth: Some(edges), ..self }
    }

    /// Sets the number of edges after which Russian roulette by throughput begins.
    #[must_use]
    pub fn rr_depth(self, edges: u32) -> Self {
        Self { rr_depth: Some(edges), ..self }
    }

    /// Sets the seed of all random numbers.
    #[must_use]
    pub fn seed(self, seed: u32) -> Self {
        self.settings(move |settings| settings.seed = seed)
    }

    /// Sets the sampler of scattered directions, and the sampler's default learner.
    #[must_use]
    pub fn sampler(self, sampler: Sampler) -> Self {
        self.settings(move |settings| {
            (settings.sampler, settings.learner) = (sampler, sampler.default_learner());
            settings.min_uniform = sampler.default_min_uniform();
        })
    }

    /// Changes any other setting. Changes are made in the order in which they are given, after the film's size is known.
    #[must_use]
    pub fn settings(mut self, change: impl Fn(&mut Settings) + Send + Sync + 'static) -> Self {
        self.changes.push(Arc::new(change));
        self
    }

    /// Adds a check that the settings must pass.
    #[must_use]
    pub fn check(mut self, check: impl Fn(&Settings) -> Result<()> + Send + Sync + 'static) -> Self {
        self.checks.push(Arc::new(check));
        self
    }
}

/// Devices and files.
impl Options {
    /// Renders on a device that is open already.
    #[must_use]
    pub fn context(self, context: &Arc<Context>) -> Self {
        Self { device: DeviceChoice::Opened(Arc::clone(context)), ..self }
    }

    /// Opens the device with this index, or the device whose name contains this text.
    #[must_use]
    pub fn device(self, device: impl Into<String>) -> Self {
        self.open_device(ContextOptions { device: Some(device.into()), validate: false })
    }

    /// Opens the device that `options` describe.
    #[must_use]
    pub fn open_device(self, options: ContextOptions) -> Self {
        Self { device: DeviceChoice::Open(options), ..self }
    }

    /// Deals out the tiles of the film to the devices by their measured speed, in place of evenly. Where devices of different kinds
    /// render the picture, its last bits then depend on what was measured.
    #[must_use]
    pub fn deal_by_speed(self, deals_by_speed: bool) -> Self {
        Self { deals_by_speed, ..self }
    }

    /// Sets the time that one dispatch should take, in milliseconds.
    #[must_use]
    pub fn slice_milliseconds(self, milliseconds: f64) -> Self {
        Self { slice_milliseconds: Some(milliseconds), ..self }
    }

    /// Sets the time that one dispatch should take, in milliseconds, where the caller has not chosen it.
    #[doc(hidden)]
    #[must_use]
    pub fn default_slice_milliseconds(self, milliseconds: f64) -> Self {
        Self { slice_milliseconds: self.slice_milliseconds.or(Some(milliseconds)), ..self }
    }

    /// Sets the kernels that trace the paths.
    #[must_use]
    pub fn execution(self, execution: Execution) -> Self {
        Self { execution: Some(execution), ..self }
    }

    /// Sets the way of finding what a ray hits.
    #[must_use]
    pub fn traversal(self, traversal: Traversal) -> Self {
        Self { traversal: Some(traversal), ..self }
    }

    /// Takes kernels from the `.spv` files of this folder.
    #[must_use]
    pub fn kernel_folder(self, folder: impl AsRef<Path>) -> Self {
        Self { kernel_folder: Some(folder.as_ref().to_path_buf()), ..self }
    }

    /// Writes these files.
    #[must_use]
    pub fn files(self, files: OutputFiles) -> Self {
        Self { files: Some(files), ..self }
    }

    /// Keeps a checkpoint in this file, from which [`Session::resume`](crate::Session::resume) goes on. A resumed render
    /// ignores this option and keeps the file that it came from.
    #[must_use]
    pub fn checkpoint(self, file: impl AsRef<Path>) -> Self {
        Self { checkpoint: Some(file.as_ref().to_path_buf()), ..self }
    }

    /// Writes the checkpoint at this interval in seconds, and at the end.
    #[must_use]
    pub fn checkpoint_every(self, seconds: f64) -> Self {
        Self { checkpoint_every: seconds, ..self }
    }

    /// Begins with the guide of another render, from its file or from its checkpoint. The guide learns on. The picture stays unbiased,
    /// because the guide must not have learned from samples that this render may take.
    #[must_use]
    pub fn guide(self, file: impl AsRef<Path>) -> Self {
        Self { guide: Some(file.as_ref().to_path_buf()), ..self }
    }

    /// Begins without a guide.
    #[doc(hidden)]
    #[must_use]
    pub fn without_guide(self) -> Self {
        Self { guide: None, ..self }
    }

    /// Renders together with other ranks. The first one uses the session, the others call
    /// [`Session::serve`](crate::Session::serve).
    #[doc(hidden)]
    #[must_use]
    pub fn exchange(self, exchange: Arc<dyn Exchange>) -> Self {
        Self { exchange: Some(exchange), ..self }
    }
}

impl Options {
    /// Settings of a render of `scene`. Where no option is given, the scene's own choice counts.
    ///
    /// # Errors
    /// Where an option is out of its range or does not suit the scene.
    pub fn settings_for(&self, scene: &Scene) -> Result<Settings> {
        let mut settings = Settings::for_scene(scene);
        if let FilmSize::Scaled(factor) = self.size
            && !(factor > 0.0 && factor.is_finite())
        {
            let message = format!("the film's scale is {factor}, but must be a finite number above 0");
            return Err(Error::Settings(message));
        }
        self.resize(&mut settings);
        let size = [settings.width, settings.height];
        settings.crop = self.crop.map(|window| window.within(size)).or(settings.crop);
        settings.filter = self.filter.unwrap_or(settings.filter);
        settings.max_depth = self.max_depth.unwrap_or(settings.max_depth);
        settings.rr_depth = self.rr_depth.unwrap_or(settings.rr_depth);
        self.changes.iter().for_each(|change| change(&mut settings));
        settings.validate()?;
        self.checks.iter().try_for_each(|check| check(&settings))?;
        settings.check_lighting(scene)?;
        Ok(settings)
    }

    fn resize(&self, settings: &mut Settings) {
        let old = [settings.width, settings.height];
        // Side whose ratio to `of` is that of `other` to `of_other`, at least one pixel.
        let in_proportion = |of: u32, other: u32, of_other: u32| {
            (f64::from(of) * f64::from(other) / f64::from(of_other)).round().max(1.0) as u32
        };
        let new = match self.size {
            FilmSize::OfScene => return,
            FilmSize::Pixels(width, height) => [width, height],
            FilmSize::Width(width) => [width, in_proportion(old[1], width, old[0])],
            FilmSize::Height(height) => [in_proportion(old[0], height, old[1]), height],
            FilmSize::Scaled(factor) => old.map(|size| ((size as f32 * factor).round() as u32).max(1)),
        };
        settings.crop = settings.crop.map(|crop| crop.rescaled(old, new));
        [settings.width, settings.height] = new;
    }

    /// Limits of a new render of `scene` with `settings`.
    pub(super) fn length_for(&self, scene: &Scene, settings: &Settings) -> Length {
        let ends_otherwise = self.length.seconds.is_some() || settings.noise.is_some();
        let default = (!ends_otherwise).then(|| scene.sample_count.unwrap_or(DEFAULT_SPP));
        Length { spp: self.length.spp.or(default), seconds: self.length.seconds }
    }

    /// Warning that the scene's depth is outside the range that can be rendered. A caller who has chosen the depth gets none.
    pub(super) fn depth_warning(&self, scene: &Scene) -> Option<String> {
        let is_chosen = self.max_depth.is_some() || self.rr_depth.is_some();
        depth_warning(scene).filter(|_| !is_chosen)
    }

    /// Options for other scenes of a render that has begun. Its connection to ranks ends when its owner wants.
    pub(super) fn for_other_scenes(&self) -> Self {
        Self { exchange: None, ..self.clone() }
    }

    /// Settings and length of a render that takes `scene` in place of the one before. The film keeps its size and its window, and the seed
    /// stays until it is known what the guide has learned from.
    pub(super) fn for_another_scene(&self, scene: &Scene, before: &Settings) -> Result<(Settings, Length)> {
        let asked = self.settings_for(scene)?;
        let length = self.length_for(scene, &asked);
        let Settings { width, height, crop, seed, samples_per_dispatch, .. } = *before;
        let mut settings = Settings { width, height, crop, seed, samples_per_dispatch, ..asked };
        self.complete(&mut settings, &length)?;
        Ok((settings, length))
    }

    /// Sets the settings that do not decide what the picture is, and checks all settings.
    pub(super) fn complete(&self, settings: &mut Settings, length: &Length) -> Result<()> {
        settings.slice_milliseconds = self.slice_milliseconds.or(settings.slice_milliseconds);
        settings.execution = self.execution.unwrap_or(settings.execution);
        settings.traversal = self.traversal.unwrap_or(settings.traversal);
        settings.validate()?;
        length.check_sample_range(settings)?;
        if self.kernel_folder.is_some() && settings.execution == Execution::Auto {
            // An edited megakernel must run, also where wavefront kernels would be faster.
            settings.execution = Execution::Megakernel;
        }
        Ok(())
    }
}
