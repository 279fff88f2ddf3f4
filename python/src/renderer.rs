//! Renders, step by step or from their start to their end.

use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use lodestar::encode::bvh::Bvh;
use lodestar::radiance_map::{MappedScene, SurfacePoint};
use lodestar::session::{Event, Options, Session, Start, Watch};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::{raised, warn};
use crate::guide::Guide;
use crate::picture::Picture;
use crate::scene::{Choices, SceneFile, Subject, path_of};
use crate::shared::{detached, from_json, is_forked, settings_of};
use crate::{options, scene};

/// Time between two looks at Python's signals.
const LOOK: Duration = Duration::from_millis(50);

/// A render that its `Renderer` and its guides share.
pub struct Shared {
    /// The session, until the end.
    session: Option<Mutex<Session>>,
    subject: Mutex<Subject>,
    /// Surfaces that pixels show, as far as they were asked for.
    points: Mutex<HashMap<(u32, u32), SurfacePoint>>,
    /// Whether `Renderer.stop` was called.
    is_stopped: AtomicBool,
}

impl Shared {
    /// Calls `act` with the session. The interpreter is released first: the thread that has the session may wait for it.
    fn with<T: Send>(&self, py: Python<'_>, act: impl FnOnce(&mut Session) -> T + Send) -> PyResult<T> {
        detached(py, || act(&mut self.session()))
    }

    fn session(&self) -> MutexGuard<'_, Session> {
        match &self.session {
            Some(session) => lock(session),
            None => unreachable!("only `drop` takes the session"),
        }
    }

    /// Surface that the center of a pixel shows.
    pub fn point(&self, py: Python<'_>, pixel: (u32, u32)) -> PyResult<SurfacePoint> {
        let find = || {
            if let Some(&known) = lock(&self.points).get(&pixel) {
                return Ok(known);
            }
            let session = self.session();
            let subject = lock(&self.subject).clone();
            let scene = subject.scene()?;
            let scene = match *session.camera() {
                camera if camera == scene.camera => scene,
                camera => Arc::new(lodestar::Scene { camera, camera_motion: None, ..(*scene).clone() }),
            };
            let bvh = Bvh::of_scene(&scene);
            let place = MappedScene { context: session.context(), scene: &scene, bvh: &bvh };
            let point = place.visible_point(session.settings(), [pixel.0, pixel.1])?;
            lock(&self.points).insert(pixel, point);
            Ok(point)
        };
        detached(py, find)?.map_err(raised)
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        if is_forked() {
            // The device belongs to the parent process. To free it here would wait for threads that are not here.
            std::mem::forget(self.session.take());
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A render, step by step.
///
/// Parameters
/// ----------
/// scene : Scene, path or dict
///     The scene, as `lodestar.load` takes it.
/// camera, environment : str, int or path
///     For a scene in a file, as `lodestar.load` takes them.
/// spp : int
///     Samples per pixel. Default: the scene's own, or 64.
/// time : float
///     Seconds of rendering. The first limit that is reached ends the render.
/// seed : int
///     Seed of all random numbers. The same seed gives the same bits.
/// width, height : int
///     Size of the film in pixels. One alone keeps the scene's aspect ratio.
/// device : int, str or Renderer
///     Index of a device of `lodestar.devices()`, or a part of its name. Or another renderer, whose device is taken: kernels that
///     were built for it need not be built again.
/// guide : Guide or path
///     A guide that another render has learned, to begin with, or its file. The seeds must differ.
/// **settings
///     Every other option of `lodestar render`, with underscores: `lodestar.options()` lists them.
///
/// Raises
/// ------
/// lodestar.Error
///     Where the scene cannot be read, a setting does not suit it, or no device can be used.
#[pyclass(frozen, module = "lodestar")]
pub struct Renderer(Arc<Shared>);

impl Renderer {
    /// Options by keywords. A device may be that of another renderer.
    fn options(settings: Option<&Bound<'_, PyDict>>) -> PyResult<Options> {
        let device = settings.map(|settings| settings.get_item("device")).transpose()?.flatten();
        let (Some(settings), Some(Ok(beside))) = (settings, device.map(Bound::cast_into::<Self>)) else {
            return options::of_render(settings);
        };
        let py = settings.py();
        let settings = settings.copy()?;
        settings.del_item("device")?;
        let context = beside.get().0.with(py, |session| Arc::clone(session.context()))?;
        Ok(options::of_render(Some(&settings))?.context(&context))
    }

    fn begin(
        py: Python<'_>,
        subject: Subject,
        options: &Options,
        resumed: Option<(PathBuf, Option<PathBuf>)>,
    ) -> PyResult<Self> {
        let warnings = Mutex::new(Vec::new());
        let start = || {
            let watch = Watch { stop: &|| false, events: &|event| keep_warning(event, &warnings) };
            let start = match resumed {
                Some((checkpoint, moved_scene)) => Start::Resume { checkpoint, moved_scene },
                None => Start::Anew(subject.input()),
            };
            Session::start(start, options, &watch)
        };
        let session = detached(py, start)?.map_err(raised)?;
        warn(py, &subject.unknown(std::mem::take(&mut *lock(&warnings))))?;
        Ok(Self(Arc::new(Shared {
            session: Some(Mutex::new(session)),
            subject: Mutex::new(subject),
            points: Mutex::default(),
            is_stopped: AtomicBool::new(false),
        })))
    }

    /// Calls `act` with the session and a watch, which `Renderer.stop` and an exception of a signal handler stop. Returns the exception, too.
    fn watched<T: Send>(
        &self,
        py: Python<'_>,
        act: impl FnOnce(&mut Session, &Watch<'_>) -> T + Send,
    ) -> PyResult<(T, Option<PyErr>)> {
        let warnings = Mutex::new(Vec::new());
        let (outcome, exception) = detached(py, || {
            let (exception, looked) = (RefCell::new(None), Cell::new(Instant::now()));
            let stop = || {
                if exception.borrow().is_some() || self.0.is_stopped.load(Ordering::Relaxed) {
                    return true;
                }
                if looked.get().elapsed() < LOOK {
                    return false;
                }
                looked.set(Instant::now());
                *exception.borrow_mut() = Python::attach(|py| py.check_signals()).err();
                exception.borrow().is_some()
            };
            let watch = Watch { stop: &stop, events: &|event| keep_warning(event, &warnings) };
            let outcome = act(&mut self.0.session(), &watch);
            (outcome, exception.into_inner())
        })?;
        warn(py, &lock(&warnings))?;
        Ok((outcome, exception))
    }

    /// Takes all steps and calls `callback` after each. Returns whether the render was stopped before its end.
    fn take_steps(this: &Bound<'_, Self>, callback: Option<&Bound<'_, PyAny>>) -> PyResult<bool> {
        let py = this.py();
        loop {
            py.check_signals()?;
            let (taken, exception) = this.get().watched(py, Session::next_step)?;
            if let Some(exception) = exception {
                return Err(exception);
            }
            if !taken.map_err(raised)? {
                return Ok(false);
            }
            if let Some(callback) = callback {
                let answer = callback.call1((this,))?;
                // A function without an answer returns None.
                if !answer.is_none() && !answer.is_truthy()? {
                    return Ok(true);
                }
            }
        }
    }

    /// Writes the checkpoint of a render that has ended, if one is kept.
    fn finish(&self, py: Python<'_>) -> PyResult<()> {
        let finish = |session: &mut Session, watch: &Watch<'_>| {
            let stopped = Watch { stop: &|| true, events: watch.events };
            session.run_watched(&stopped, |_| std::ops::ControlFlow::Break(()))
        };
        self.watched(py, finish)?.0.map_err(raised)
    }

    fn picture_with(&self, py: Python<'_>, ending: Option<&'static str>) -> PyResult<Picture> {
        let read = |session: &mut Session| {
            let picture = session.picture()?;
            let attributes = session.attributes(&picture);
            Ok((picture, attributes, session.statistics()))
        };
        let (picture, attributes, statistics) = self.0.with(py, read)?.map_err(raised)?;
        Ok(Picture::new(picture, attributes, Some(from_json(py, &statistics)?), ending))
    }

    /// Reason why the render has ended.
    fn ending(&self, py: Python<'_>, is_stopped: bool) -> PyResult<&'static str> {
        let progress = self.0.with(py, |session| session.progress())?;
        let has_all = progress.length.spp.is_some_and(|spp| progress.samples >= spp);
        Ok(match () {
            () if has_all => "samples",
            () if is_stopped => "stopped",
            () if progress.length.seconds.is_some_and(|limit| progress.seconds >= limit) => "time",
            () if progress.noise.is_some() => "noise",
            () => "stopped",
        })
    }
}

/// Keeps a warning for the moment when Python can show it.
fn keep_warning(event: Event<'_>, warnings: &Mutex<Vec<String>>) {
    match event {
        Event::Warning(message) => lock(warnings).push(message.to_owned()),
        Event::Validation(message) => lock(warnings).push(format!("validation: {message}")),
        _ => {}
    }
}

#[pymethods]
impl Renderer {
    #[new]
    #[pyo3(
        signature = (scene, *, camera = None, environment = None, guide = None, **settings),
        text_signature = "(scene, *, camera=None, environment=None, spp=None, time=None, seed=0, width=None, height=None, device=None, guide=None, **settings)"
    )]
    fn new(
        scene: &Bound<'_, PyAny>,
        camera: Option<&Bound<'_, PyAny>>,
        environment: Option<&Bound<'_, PyAny>>,
        guide: Option<&Bound<'_, PyAny>>,
        settings: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let py = scene.py();
        let options = Self::options(settings)?;
        let (guide, options) = match guide.map(|guide| (guide, guide.cast::<Guide>())) {
            None => (None, options),
            Some((_, Ok(guide))) => (Some(guide), options),
            Some((file, Err(_))) => (None, options.guide(path_of(file)?)),
        };
        let renderer = Self::begin(py, Subject::of(scene, Choices { camera, environment })?, &options, None)?;
        if let Some(guide) = guide {
            let learned = guide.get().learned();
            renderer.0.with(py, |session| session.begin_with_guide(learned))?.map_err(raised)?;
        }
        Ok(renderer)
    }

    /// Takes more samples for every pixel, then lets the guide learn. Returns the samples per pixel so far.
    ///
    /// Parameters
    /// ----------
    /// samples : int
    ///     Samples per pixel, whatever the length of the render. Default: one step of the guide's schedule, after which checkpoints can
    ///     be written. More samples are split into steps; a step that is cut short makes the steps after it differ from those of
    ///     one longer render.
    #[pyo3(signature = (samples = None))]
    fn step(&self, py: Python<'_>, samples: Option<u32>) -> PyResult<u32> {
        py.check_signals()?;
        let (progress, exception) = self.watched(py, |session, watch| {
            let samples = samples.unwrap_or_else(|| session.samples_of_next_step());
            session.step_watched(samples, watch)
        })?;
        match exception {
            Some(exception) => Err(exception),
            None => Ok(progress.map_err(raised)?.samples),
        }
    }

    /// Renders to the end and returns the picture.
    ///
    /// Ctrl-C ends the render with the picture so far, whose `ending` is then `stopped`.
    ///
    /// Parameters
    /// ----------
    /// callback : callable
    ///     Function of the renderer, called after every step. An answer that is false ends the render; None does not.
    #[pyo3(signature = (callback = None))]
    fn run(slf: &Bound<'_, Self>, callback: Option<&Bound<'_, PyAny>>) -> PyResult<Picture> {
        let (py, this) = (slf.py(), slf.get());
        let stepped = Self::take_steps(slf, callback);
        let is_stopped = match &stepped {
            Ok(is_stopped) => *is_stopped,
            Err(error) => error.is_instance_of::<PyKeyboardInterrupt>(py),
        };
        let finished = this.finish(py);
        match stepped {
            Ok(_) => finished?,
            // Without any sample there is no picture to return.
            Err(error) if !is_stopped || !this.has_samples(py)? => return Err(error),
            Err(_) => finished?,
        }
        let ending = this.ending(py, is_stopped)?;
        this.picture_with(py, Some(ending))
    }

    /// Ends the render, from any thread: a step that another thread takes returns after its next dispatch, with fewer samples, and later
    /// ones take none. The picture so far stays. `set_scene`, `set_camera` and `set_size` begin anew and end the stop.
    fn stop(&self) {
        self.0.is_stopped.store(true, Ordering::Relaxed);
    }

    /// The picture so far.
    fn picture(&self, py: Python<'_>) -> PyResult<Picture> {
        self.picture_with(py, None)
    }

    /// Renders another scene from now on: the scene before after a change, or any other one. The guide stays, each cell takes what the
    /// nearest cell has learned, and hierarchy and kernels stay where they suit. The picture and all counters begin anew, with another
    /// seed, as for `set_camera`; the film keeps its size, and the settings are those that the render began with. Where this fails, the
    /// render goes on as before.
    ///
    /// Parameters
    /// ----------
    /// scene : Scene, path or dict
    ///     The scene, as `lodestar.load` takes it.
    /// camera, environment : str, int or path
    ///     For a scene in a file, as `lodestar.load` takes them.
    #[pyo3(signature = (scene, *, camera = None, environment = None))]
    fn set_scene(
        &self,
        scene: &Bound<'_, PyAny>,
        camera: Option<&Bound<'_, PyAny>>,
        environment: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let (py, subject) = (scene.py(), Subject::of(scene, Choices { camera, environment })?);
        let warnings = Mutex::new(Vec::new());
        let changed = |session: &mut Session| {
            let watch = Watch { stop: &|| false, events: &|event| keep_warning(event, &warnings) };
            session.set_scene_watched(subject.input(), &watch)?;
            *lock(&self.0.subject) = subject.clone();
            Ok(())
        };
        self.change(py, changed)?;
        let warnings = std::mem::take(&mut *lock(&warnings));
        warn(py, &subject.unknown(warnings))
    }

    /// Shows the scene from now on by another camera, which stands still. The guide stays, so the first samples are guided already. The
    /// picture and all counters begin anew, and the seed becomes the next one of which the guide has learned from no sample, so that the
    /// picture stays unbiased. The same changes give the same bits.
    ///
    /// Parameters
    /// ----------
    /// camera : dict or Scene
    ///     A sensor of Mitsuba's dictionary, such as `{"type": "perspective", "fov": 40, "to_world": transform}`, or a scene whose camera
    ///     is taken. The film of either is left out.
    fn set_camera(&self, camera: &Bound<'_, PyAny>) -> PyResult<()> {
        let (py, camera) = (camera.py(), scene::camera_of(camera)?);
        self.change(py, |session| session.set_camera(&camera))
    }

    /// Renders from now on a film of another size in pixels. The guide stays; everything else begins anew, as for `set_camera`.
    fn set_size(&self, py: Python<'_>, width: u32, height: u32) -> PyResult<()> {
        self.change(py, |session| session.set_size(width, height))
    }

    /// Writes a checkpoint of the render so far, from which `lodestar.resume` goes on to the same bits. The scene must have been
    /// read from a file, and every step must have had the length of the guide's schedule (`step()`).
    fn checkpoint(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        self.0.with(py, |session| session.write_checkpoint(&path))?.map_err(raised)
    }

    /// Writes the guide as it has been learned so far into a file, with which another render can begin (`guide`).
    fn write_guide(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        self.0.with(py, |session| session.write_guide(&path))?.map_err(raised)
    }

    /// The guide as it has been learned so far. Later steps do not change it.
    #[getter]
    fn guide(&self, py: Python<'_>) -> PyResult<Guide> {
        let learned = self.0.with(py, |session| session.learned_guide())?.map_err(raised)?;
        Ok(Guide::new(learned, Arc::clone(&self.0)))
    }

    /// Samples per pixel so far.
    #[getter]
    fn samples(&self, py: Python<'_>) -> PyResult<u32> {
        self.0.with(py, |session| session.progress().samples)
    }

    /// Seconds of rendering so far, without loading.
    #[getter]
    fn seconds(&self, py: Python<'_>) -> PyResult<f64> {
        self.0.with(py, |session| session.progress().seconds)
    }

    /// Share of the render that is done, in [0, 1]: the larger one of its shares of the samples and of the time.
    #[getter]
    fn fraction(&self, py: Python<'_>) -> PyResult<f64> {
        self.0.with(py, |session| session.progress().fraction)
    }

    /// Share of the last step's scattered rays that hit an emitter, in [0, 1]. It grows as the guide learns.
    #[getter]
    fn light_hit_rate(&self, py: Python<'_>) -> PyResult<f64> {
        self.0.with(py, |session| session.progress().light_hit_rate)
    }

    /// Settings of the render by name.
    #[getter]
    fn settings(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let settings = self.0.with(py, |session| session.settings().clone())?;
        settings_of(py, &settings)
    }

    /// All numbers about the render so far, as `--stats` writes them.
    #[getter]
    fn stats(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let statistics = self.0.with(py, |session| session.statistics())?;
        from_json(py, &statistics)
    }

    /// Name of the device that renders.
    #[getter]
    fn device(&self, py: Python<'_>) -> PyResult<String> {
        self.0.with(py, |session| session.context().device().name.clone())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let (samples, device) =
            self.0.with(py, |session| (session.progress().samples, session.context().device().name.clone()))?;
        Ok(format!("<lodestar.Renderer: {samples} samples per pixel on {device}>"))
    }
}

impl Renderer {
    /// Changes the scene or the view. The surfaces that pixels showed are forgotten.
    fn change(&self, py: Python<'_>, change: impl FnOnce(&mut Session) -> lodestar::Result<()> + Send) -> PyResult<()> {
        // A stop that comes while something changes is for the picture before the change.
        let changed = |session: &mut Session| {
            change(session)?;
            self.0.is_stopped.store(false, Ordering::Relaxed);
            lock(&self.0.points).clear();
            Ok(())
        };
        self.0.with(py, changed)?.map_err(raised)
    }

    fn has_samples(&self, py: Python<'_>) -> PyResult<bool> {
        let picture = self.0.with(py, |session| session.picture())?.map_err(raised)?;
        Ok(picture.sample_count.iter().any(|&count| count > 0))
    }
}

/// Renders a scene and returns the picture.
///
/// Ctrl-C ends the render with the picture so far, whose `ending` is then `stopped`.
///
/// Parameters
/// ----------
/// scene : Scene, path or dict
///     The scene, as `lodestar.load` takes it.
/// camera, environment : str, int or path
///     For a scene in a file, as `lodestar.load` takes them.
/// spp : int
///     Samples per pixel. Default: the scene's own, or 64.
/// time : float
///     Seconds of rendering. The first limit that is reached ends the render.
/// seed : int
///     Seed of all random numbers. The same seed gives the same bits, which are those of the command line.
/// width, height : int
///     Size of the film in pixels. One alone keeps the scene's aspect ratio.
/// device : int or str
///     Index of a device of `lodestar.devices()`, or a part of its name.
/// guide : Guide or path
///     A guide that another render has learned, to begin with, or its file. The seeds must differ.
/// callback : callable
///     Function of the `Renderer`, called after every step. An answer that is false ends the render; None does not.
/// **settings
///     Every other option of `lodestar render`, with underscores: `lodestar.options()` lists them.
///
/// Examples
/// --------
/// >>> picture = lodestar.render("scene.xml", spp=64)
/// >>> picture.radiance.shape
/// (256, 256, 3)
/// >>> picture.save("picture.exr")
#[pyfunction]
#[pyo3(
    signature = (scene, *, camera = None, environment = None, guide = None, callback = None, **settings),
    text_signature = "(scene, *, camera=None, environment=None, spp=None, time=None, seed=0, width=None, height=None, device=None, guide=None, callback=None, **settings)"
)]
pub fn render(
    scene: &Bound<'_, PyAny>,
    camera: Option<&Bound<'_, PyAny>>,
    environment: Option<&Bound<'_, PyAny>>,
    guide: Option<&Bound<'_, PyAny>>,
    callback: Option<&Bound<'_, PyAny>>,
    settings: Option<&Bound<'_, PyDict>>,
) -> PyResult<Picture> {
    let renderer = Bound::new(scene.py(), Renderer::new(scene, camera, environment, guide, settings)?)?;
    Renderer::run(&renderer, callback)
}

/// Goes on with a render from its checkpoint, to the same bits as without the interruption.
///
/// Parameters
/// ----------
/// checkpoint : path
///     File of the checkpoint, from `Renderer.checkpoint`, the keyword `checkpoint` or the command line. The render keeps it up to
///     date.
/// scene : path
///     Path of the scene, if it was moved.
/// spp, time : int, float
///     A new length: all samples per pixel, and seconds from now.
/// device : int or str
///     The device that renders.
#[pyfunction]
#[pyo3(
    signature = (checkpoint, *, scene = None, **settings),
    text_signature = "(checkpoint, *, scene=None, spp=None, time=None, device=None, **settings)"
)]
pub fn resume(
    checkpoint: &Bound<'_, PyAny>,
    scene: Option<&Bound<'_, PyAny>>,
    settings: Option<&Bound<'_, PyDict>>,
) -> PyResult<Renderer> {
    let py = checkpoint.py();
    let checkpoint = path_of(checkpoint)?;
    let moved = scene.map(scene::path_of).transpose()?;
    let options = options::of_resumed(settings)?;
    let source = detached(py, || lodestar::session::saved::SavedCheckpoint::open(&checkpoint))?.map_err(raised)?.scene;
    let path = moved.clone().unwrap_or_else(|| source.path.into());
    let subject = Subject { scene: None, file: Some(SceneFile { path, options: source.options }) };
    Renderer::begin(py, subject, &options, Some((checkpoint, moved)))
}
