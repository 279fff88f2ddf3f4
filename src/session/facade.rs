//! Sessions as a caller sees them.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use crate::Result;
use crate::encode::cells::Cells;
use crate::film::Picture;
use crate::gpu::Context;
use crate::renderer::learned_guide::LearnedGuide;
use crate::scene::{Camera, LoadOptions, Scene};
use crate::session::finished::Finished;
use crate::session::history::History;
use crate::session::options::Options;
use crate::session::prepared::Prepared;
use crate::session::profile::Summary;
use crate::session::progress::{Ending, Event, Progress, Watch};
use crate::session::ranks;
use crate::session::running::Running;
use crate::session::start::{SceneInput, Start};
use crate::session::statistics::Statistics;
use crate::settings::{Sampler, Settings};

/// A render from its start to its end.
///
/// A session takes steps until enough samples or seconds have passed, noise is low enough, or its caller stops it. It keeps
/// checkpoints, a safety copy of the picture, statistics and times, and writes the files that its [`Options`](crate::Options)
/// name.
///
/// ```no_run
/// use lodestar::{Options, Session};
/// let mut session = Session::open("scene.xml", &Options::new())?;
/// session.step(16)?;
/// let preview = session.picture()?;
/// session.step(48)?;
/// # Ok::<(), lodestar::Error>(())
/// ```
pub struct Session {
    running: Running,
    /// What the end of the last [`Session::run`] has left.
    finished: Option<Finished>,
}

/// The beginning of a session.
impl Session {
    /// Makes everything ready for the first step of a new render of `scene`.
    ///
    /// # Errors
    /// Where an option does not suit the scene, no device can be used, or the device cannot hold the scene.
    pub fn new(scene: &Scene, options: &Options) -> Result<Self> {
        Self::start(Start::Anew(SceneInput::Memory(scene)), options, &Watch::silent())
    }

    /// Reads a scene and makes everything ready for the first step.
    ///
    /// # Errors
    /// Where [`Session::new`] fails, and where the scene cannot be read.
    pub fn open(scene: impl AsRef<Path>, options: &Options) -> Result<Self> {
        let input = SceneInput::File { path: scene.as_ref().to_path_buf(), options: LoadOptions::default() };
        Self::start(Start::Anew(input), options, &Watch::silent())
    }

    /// Goes on with a render from its checkpoint. The settings are those of the checkpoint. A length in `options` replaces the
    /// length of the checkpoint; its seconds count from now.
    ///
    /// # Errors
    /// Where the checkpoint cannot be read, or its scene has changed.
    pub fn resume(checkpoint: impl AsRef<Path>, options: &Options) -> Result<Self> {
        let start = Start::Resume { checkpoint: checkpoint.as_ref().to_path_buf(), moved_scene: None };
        Self::start(start, options, &Watch::silent())
    }

    /// Makes everything ready for the first step and tells `watch` every event.
    ///
    /// # Errors
    /// Where [`Session::open`] or [`Session::resume`] fails.
    pub fn start(start: Start<'_>, options: &Options, watch: &Watch<'_>) -> Result<Self> {
        let running = ranks::join(options, Prepared::new(start, options, watch))?.begin(watch)?;
        Ok(Self { running, finished: None })
    }

    /// Renders on another rank than the first one until the render ends. It writes no files. The first rank reports all errors.
    ///
    /// # Errors
    /// Where this rank or another one cannot render, or the first rank is lost.
    #[doc(hidden)]
    pub fn serve(start: Start<'_>, options: &Options, watch: &Watch<'_>) -> Result<()> {
        let mut options = options.clone();
        (options.files, options.checkpoint, options.guide) = (None, None, None);
        ranks::join(&options, Prepared::new(start, &options, watch))?.serve()
    }
}

/// Steps, and the end of a session.
impl Session {
    /// Takes `samples` more samples per pixel, whatever the length of the render. The guide's schedule splits them into steps, so
    /// that the guide learns between steps. If `samples` cuts a step short, the steps after it differ from the steps of one longer
    /// call. This function writes no files; [`Session::run`] does.
    ///
    /// # Errors
    /// Where the device is lost or a result would be wrong.
    pub fn step(&mut self, samples: u32) -> Result<Progress> {
        self.step_watched(samples, &Watch::silent())
    }

    /// Takes samples like [`Session::step`] and tells `watch` every event. A step that `watch` stops is the last one.
    ///
    /// # Errors
    /// Where [`Session::step`] fails.
    pub fn step_watched(&mut self, samples: u32, watch: &Watch<'_>) -> Result<Progress> {
        self.running.take_samples(samples, watch)?;
        Ok(self.progress())
    }

    /// Takes the next step of the render. Returns false, without a step, where a limit is reached or `watch` stops the render.
    /// A caller that takes all steps by this function may use the session between them; [`Session::run_watched`] then writes the
    /// files.
    ///
    /// # Errors
    /// Where the device is lost or a result would be wrong.
    pub fn next_step(&mut self, watch: &Watch<'_>) -> Result<bool> {
        self.running.next_step(watch)
    }

    /// Samples per pixel of the next step by the guide's schedule.
    pub fn samples_of_next_step(&self) -> u32 {
        self.running.samples_of_next_step()
    }

    /// Renders to the end and writes the files. `on_step` is called after every step; `Break` ends the render.
    ///
    /// # Errors
    /// Where the device is lost, a result would be wrong, or a file cannot be written.
    pub fn run(&mut self, on_step: impl FnMut(&Self) -> ControlFlow<()>) -> Result<()> {
        self.run_watched(&Watch::silent(), on_step)
    }

    /// Renders like [`Session::run`] and tells `watch` every event.
    ///
    /// # Errors
    /// Where [`Session::run`] fails.
    pub fn run_watched(&mut self, watch: &Watch<'_>, mut on_step: impl FnMut(&Self) -> ControlFlow<()>) -> Result<()> {
        let mut is_broken = false;
        let rendered = self.take_all_steps(watch, |session| {
            let flow = on_step(session);
            is_broken |= flow.is_break();
            flow
        });
        let ending = self.running.ending(is_broken || (watch.stop)());
        watch.tell(Event::Rendered);
        let (finished, written) = Finished::of(&mut self.running, rendered, watch);
        self.finished = Some(finished);
        let ending = if written.is_ok() { ending } else { Ending::Failed };
        watch.tell(Event::Ended(ending, &self.progress()));
        written
    }

    /// Takes steps until a limit is reached or the caller stops the render. The time in which pictures are written or measured does
    /// not count.
    fn take_all_steps(&mut self, watch: &Watch<'_>, mut on_step: impl FnMut(&Self) -> ControlFlow<()>) -> Result<()> {
        while self.running.next_step(watch)? {
            if on_step(self).is_break() {
                break;
            }
            self.running.write_if_due(watch)?;
        }
        Ok(())
    }
}

/// Another view of the scene. The guide stays.
impl Session {
    /// Camera of the picture.
    pub fn camera(&self) -> &Camera {
        self.running.camera()
    }

    /// Shows the scene from now on by another camera, which stands still. Kernels, scene and guide stay; the film and the counters begin
    /// anew, and the length of the render counts from here. Another kind of projection needs other kernels, which are then built; those of a
    /// thin lens serve pinholes, too. The medium around the camera stays that of the scene's camera.
    ///
    /// The picture stays unbiased, because the guide has learned from other samples than those that it guides: its seed
    /// ([`Settings::seed`]) is the next one of which the guide has learned from no sample. Each change after samples so adds one to the
    /// seed, and the same changes after the same samples give the same bits. A session of that seed and that camera which begins with this
    /// guide has these bits, too.
    ///
    /// # Errors
    /// Where the camera has a number out of its range, the render keeps a checkpoint or is shared by ranks, or the device is lost. The
    /// render cannot go on only if the device failed.
    pub fn set_camera(&mut self, camera: &Camera) -> Result<()> {
        let Settings { width, height, .. } = *self.settings();
        self.set_view(camera, [width, height])
    }

    /// Renders from now on a film of `width` x `height` pixels. The session begins anew as after [`Session::set_camera`]. A crop window
    /// is scaled with the film. The guide keeps its cells, although a new render of this size may choose others.
    ///
    /// # Errors
    /// Where the device cannot hold the film, and where [`Session::set_camera`] fails.
    pub fn set_size(&mut self, width: u32, height: u32) -> Result<()> {
        let camera = *self.camera();
        self.set_view(&camera, [width, height])
    }

    /// Changes camera and size at once.
    ///
    /// # Errors
    /// Where [`Session::set_camera`] or [`Session::set_size`] fails.
    pub fn set_view(&mut self, camera: &Camera, size: [u32; 2]) -> Result<()> {
        self.running.change_view(camera, size)?;
        self.finished = None;
        Ok(())
    }
}

/// Another scene. The guide stays.
impl Session {
    /// Renders `scene` from now on: the scene before after a change, or any other one. The film, its counters and the length of the render
    /// begin anew; the film keeps its size and its window, and the camera is that of `scene`. The choices of [`Options`] hold for this scene
    /// as for the first one.
    ///
    /// What has not changed stays: the device, kernels that both scenes need, and the hierarchy where all shapes with their materials' and
    /// emitters' numbers are the same. For this, a session keeps the hierarchy in memory from its first change on, and meshes of files that
    /// it has read itself.
    ///
    /// The guide stays, too: each cell takes what the nearest cell has learned, as [`Session::begin_with_guide`] does, and the seed becomes
    /// the next one of which the guide has learned from no sample. So the picture stays unbiased, and has the bits of a new session of that
    /// seed and size which begins with this guide, from memory ([`Session::learned_guide`]) or from a file ([`Session::write_guide`]).
    ///
    /// # Errors
    /// Where [`Session::new`] fails, the device cannot hold both scenes for a moment, or the render keeps a checkpoint or is shared by
    /// ranks. The render then goes on as before.
    pub fn set_scene(&mut self, scene: &Scene) -> Result<()> {
        self.set_scene_watched(SceneInput::Memory(scene), &Watch::silent())
    }

    /// Changes the scene like [`Session::set_scene`], to one in a file or in memory, and tells `watch` every event.
    ///
    /// # Errors
    /// Where [`Session::set_scene`] fails, and where the scene cannot be read.
    pub fn set_scene_watched(&mut self, scene: SceneInput<'_>, watch: &Watch<'_>) -> Result<()> {
        self.running.change_scene(scene, watch)?;
        self.finished = None;
        Ok(())
    }
}

/// What a session has so far.
impl Session {
    /// The picture so far. If the device was lost during [`Session::run`], this is the last safety copy of the picture.
    ///
    /// # Errors
    /// Where the device is lost and there is no copy.
    pub fn picture(&self) -> Result<Picture> {
        let rescued = self.finished.as_ref().and_then(Finished::rescued);
        rescued.map_or_else(|| self.running.picture(), |picture| Ok(picture.clone()))
    }

    /// Progress of the render.
    pub fn progress(&self) -> Progress {
        self.running.progress()
    }

    /// The steps so far.
    #[doc(hidden)]
    pub fn history(&self) -> &History {
        self.running.history()
    }

    /// All numbers about the render so far, as `--stats` writes them. The error of the picture is measured at the end of a
    /// render only.
    #[doc(hidden)]
    pub fn statistics(&self) -> Statistics {
        self.running.statistics()
    }

    /// Times of all dispatches, after the end of a render with [`OutputFiles::profile`](crate::session::OutputFiles::profile).
    pub fn profile(&self) -> Option<&Summary> {
        self.finished.as_ref()?.profile()
    }

    /// Names and values that the header of a picture's EXR file holds: the settings, the sample numbers, the time, the device and
    /// the scene. `lodestar merge` needs them.
    pub fn attributes(&self, picture: &Picture) -> Vec<(String, String)> {
        self.running.attributes(picture)
    }

    /// Writes the unfinished picture into its files, without denoising it.
    ///
    /// # Errors
    /// Where the device is lost or a file cannot be written.
    #[doc(hidden)]
    pub fn write_now(&self, watch: &Watch<'_>) -> Result<()> {
        match self.finished.as_ref().and_then(Finished::rescued) {
            Some(rescued) => self.running.write_pictures(rescued, watch),
            None => self.running.write_pictures(&self.running.source()?, watch),
        }
    }

    /// Writes a checkpoint of the render so far into `file`, from which [`Session::resume`] goes on to the same bits.
    ///
    /// # Errors
    /// Where the scene was made in memory, a step was shorter than the schedule has it, another render keeps its checkpoint in the file, or
    /// the file cannot be written.
    pub fn write_checkpoint(&self, file: impl AsRef<Path>) -> Result<()> {
        self.running.write_checkpoint(file.as_ref())
    }

    /// The settings of the render.
    pub fn settings(&self) -> &Settings {
        self.running.settings()
    }

    /// The device that renders.
    pub fn context(&self) -> &Arc<Context> {
        self.running.context()
    }
}

/// The guide of a session.
impl Session {
    /// The guide as it has been learned so far.
    ///
    /// # Errors
    /// Where the sampler learns no radiance, or the device is lost.
    pub fn learned_guide(&self) -> Result<LearnedGuide> {
        self.running.renderer().learned_guide()
    }

    /// Writes the guide as it has been learned so far into `file`, with which another render can begin ([`Options::guide`]).
    ///
    /// # Errors
    /// Where the sampler learns no radiance, nothing was learned yet, the device is lost, or the file cannot be written.
    pub fn write_guide(&self, file: impl AsRef<Path>) -> Result<()> {
        self.running.write_guide(file.as_ref())
    }

    /// Begins with a guide that another render has learned, of this scene or of one that differs little. Each cell takes what the
    /// nearest cell has learned. The picture stays unbiased.
    ///
    /// # Errors
    /// Where steps were taken already, settings of the guides differ, or the guide has learned from samples that this render may
    /// take: a guide must not have learned from the samples that it guides.
    pub fn begin_with_guide(&mut self, guide: &LearnedGuide) -> Result<()> {
        self.running.begin_with_guide(guide.state().clone())
    }

    /// Cells of the guide.
    ///
    /// # Errors
    /// The reason, in one sentence, why there are none.
    #[doc(hidden)]
    pub fn cells(&self) -> Result<&Cells, &'static str> {
        match self.settings().sampler {
            Sampler::Bsdf => Err("The sampler bsdf learns nothing."),
            Sampler::Quadtree => Err("The sampler quadtree learns flux, not radiance, so there is no map of it."),
            _ => Ok(self.running.renderer().cells()),
        }
    }

    /// Learned radiance by cell and direction bin, as the next step samples it.
    ///
    /// # Errors
    /// Where the device is lost.
    #[doc(hidden)]
    pub fn learned_radiance(&self) -> Result<Vec<f32>> {
        self.running.renderer().radiance()
    }

    /// Shares of the samples that each cell leaves to BSDFs. Empty where shares are fixed.
    ///
    /// # Errors
    /// Where the device is lost.
    #[doc(hidden)]
    pub fn bsdf_shares(&self) -> Result<Vec<[f32; 2]>> {
        self.running.renderer().bsdf_shares()
    }
}
