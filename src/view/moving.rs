//! A session whose camera viewers move: small pictures while it moves, and one that gets finer while it rests.
//!
//! A wish of a viewer stops the step under way. Its first picture is small enough to come at once. What the guide has learned stays from
//! place to place.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use glam::Vec3;

use crate::denoise::DenoiseOptions;
use crate::film::{Precision, write_picture_with};
use crate::scene::{Camera, LoadOptions, Projection, Scene, load_with_progress, scene_file};
use crate::session::{Event, Options, Preparation, SceneInput, Session, Start, Watch};
use crate::settings::Settings;
use crate::view::board::{Board, Phase, Pinned, Scenery, Seen, Wish};
use crate::view::denoiser::LazyDenoiser;
use crate::view::detail::Detail;
use crate::view::names::{file_name, scene_name, without_folders};
use crate::view::pose::{Pose, xml};
use crate::view::server::Server;
use crate::view::shot::{Content, Shot};
use crate::view::viewers::{copy_guide, note_step, sampler_word};
use crate::{Error, Result};

/// Time of a dispatch in milliseconds, where the caller has not chosen it. A wish waits for the dispatch under way.
const SLICE: f64 = 40.0;
/// Time without a wish after which a camera that moves rests.
const REST_AFTER: Duration = Duration::from_millis(400);
/// Interval at which the caller is asked whether to end.
const LOOK: Duration = Duration::from_millis(50);
/// Most cameras of a scene that the page offers.
const MOST_CAMERAS: usize = 256;

/// Choices of a page whose camera moves.
#[derive(Clone)]
pub struct MovingOptions {
    /// How the scene is read.
    pub load: LoadOptions,
    /// Options of the session. Its length is that of a picture at rest.
    pub session: Options,
    /// The denoiser of the page's layer `denoised`.
    pub denoiser: DenoiseOptions,
    /// Picture that the page renders; `NAME.exr` stands for `NAME.1.exr`, `NAME.2.exr`, ..., of which the first that is free is written.
    /// `None` means the scene's name.
    pub picture: Option<PathBuf>,
}

/// A page whose camera moves.
pub struct MovingView {
    board: Arc<Board>,
    server: Server,
}

impl MovingView {
    /// Serves a page at `address`. It waits for [`MovingView::run`].
    ///
    /// # Errors
    /// Where the address cannot be used.
    pub fn start(address: &str) -> Result<Self> {
        let board = Arc::new(Board::default());
        Ok(Self { server: Server::start(address, Arc::clone(&board))?, board })
    }

    /// Address of the page.
    pub fn url(&self) -> String {
        self.server.url()
    }

    /// Reads the scene at `path` and shows it until `watch` or a viewer ends it.
    ///
    /// # Errors
    /// Where the scene cannot be read, an option does not suit it, or the device fails.
    pub fn run(&self, path: &Path, options: &MovingOptions, watch: &Watch<'_>) -> Result<()> {
        let board = &self.board;
        let events = |event: Event<'_>| {
            match event {
                Event::Preparing(preparation) => {
                    board.change(|pinned| pinned.state.message = without_folders(&preparation.to_string()));
                }
                Event::Warning(message) => board.change(|pinned| pinned.state.message = without_folders(message)),
                _ => {}
            }
            (watch.events)(event);
        };
        let stop = || (watch.stop)() || board.is_stopped();
        let watch = Watch { stop: &stop, events: &events };
        Moving::open(Arc::clone(board), path, options, &watch)?.run(&watch)?;
        board.change(|pinned| {
            (pinned.state.phase, pinned.state.message) = (Phase::Ended, "The program has ended.".into());
        });
        Ok(())
    }
}

/// The session and the camera of a page.
struct Moving {
    board: Arc<Board>,
    session: Session,
    pose: Pose,
    /// Size of the picture of a camera at rest.
    size: [u32; 2],
    /// Distance to what the middle of the picture shows.
    distance: f32,
    /// Last wish that the camera follows.
    wish: u64,
    detail: Detail,
    shots: u64,
    guides: u64,
    denoiser: Arc<LazyDenoiser>,
    picture: PathBuf,
}

impl Moving {
    fn open(board: Arc<Board>, path: &Path, options: &MovingOptions, watch: &Watch<'_>) -> Result<Self> {
        let file = scene_file(path)?;
        let show = |progress| (watch.events)(Event::Preparing(Preparation::Scene(progress)));
        let mut scene = load_with_progress(&file, &options.load, &show)?;
        let distance = distance_to_middle(&scene);
        let (names, cameras, index) = cameras(&scene);
        let pose = Pose::of(index, &scene.camera, distance);
        // Kernels of a lens serve pinholes, too, so that none are built when the lens is opened.
        scene.camera = pose.camera(&cameras).map_err(Error::Settings)?;
        scene.camera_motion = None;
        let session = options.session.clone().default_slice_milliseconds(SLICE);
        let input = SceneInput::Read { scene: &scene, path: file.clone(), options: options.load.clone() };
        let session = Session::start(Start::Anew(input), &session, watch)?;
        let default = || PathBuf::from(format!("{}.exr", scene.name));
        let picture = options.picture.clone().unwrap_or_else(default);
        let Settings { width, height, .. } = *session.settings();
        let poses = names.into_iter().zip((0..).zip(&cameras).map(|(at, camera)| Pose::of(at, camera, distance)));
        let scenery = Scenery { cameras: cameras.clone(), poses: poses.collect(), xml: String::new() };
        board.change(|pinned| {
            let state = &mut pinned.state;
            (state.phase, state.scene) = (Phase::Resting, scene_name(&file));
            state.message.clear();
            state.device.clone_from(&session.context().device().name);
            state.sampler = sampler_word(session.settings());
            state.samples_lights = session.settings().nee;
            state.wanted_samples = session.progress().length.spp;
            pinned.scenery = Some(Arc::new(scenery));
        });
        Ok(Self {
            board,
            session,
            pose,
            size: [width, height],
            distance,
            wish: 0,
            detail: Detail::default(),
            shots: 0,
            guides: 0,
            denoiser: Arc::new(LazyDenoiser::new(options.denoiser.clone())),
            picture,
        })
    }

    fn run(&mut self, watch: &Watch<'_>) -> Result<()> {
        let mut rests_at = Some(Instant::now());
        while !(watch.stop)() {
            let is_idle = rests_at.is_none() && self.is_complete();
            let wait = rests_at.map_or(Duration::ZERO, |at| at.saturating_duration_since(Instant::now())).min(LOOK);
            if let Some(wish) = self.board.take_wish(if is_idle { LOOK } else { wait }) {
                self.follow(&wish, watch)?;
                rests_at = Some(Instant::now() + if wish.is_moving { REST_AFTER } else { Duration::ZERO });
            } else if self.board.wants_render.swap(false, Ordering::Relaxed) {
                rests_at = None;
                self.render(watch)?;
            } else if rests_at.is_some_and(|at| at <= Instant::now()) {
                rests_at = None;
                let camera = *self.session.camera();
                self.session.set_view(&camera, self.size)?;
                self.note_phase(Phase::Resting);
            } else if rests_at.is_none() && !is_idle {
                self.refine(watch)?;
            } else if rests_at.is_none() {
                self.hand_guide_over();
            }
        }
        Ok(())
    }

    /// Whether the picture has all of its samples.
    fn is_complete(&self) -> bool {
        let progress = self.session.progress();
        progress.length.spp.is_some_and(|spp| progress.samples >= spp)
            || progress.length.seconds.is_some_and(|limit| progress.seconds >= limit)
    }

    /// Moves the camera and shows its first picture, which is small.
    fn follow(&mut self, wish: &Wish, watch: &Watch<'_>) -> Result<()> {
        let begin = Instant::now();
        let moved = self.session.set_view(&wish.camera, self.detail.small(self.size));
        if let Err(error) = moved {
            if error.is_loss() {
                return Err(error);
            }
            let sentence = error.to_string();
            self.board.change(|pinned| pinned.followed = (wish.number, Some(without_folders(&sentence))));
            // The step under way was stopped for the wish.
            let camera = *self.session.camera();
            return self.session.set_view(&camera, self.size);
        }
        (self.pose, self.wish) = (wish.pose, wish.number);
        self.board.change(|pinned| {
            pinned.state.noise.clear();
            pinned.state.phase = Phase::Moving;
        });
        self.session.step_watched(1, watch)?;
        self.show()?;
        self.detail.took(begin.elapsed());
        Ok(())
    }

    /// Takes some more samples of the camera at rest. A wish or an order ends them.
    fn refine(&mut self, watch: &Watch<'_>) -> Result<()> {
        let board = Arc::clone(&self.board);
        let stop = || (watch.stop)() || board.has_wish();
        let left = self.session.progress().length.spp.map_or(u32::MAX, |spp| spp - self.session.progress().samples);
        let samples = self.detail.samples(self.session.settings(), self.session.samples_of_next_step()).min(left);
        let begin = Instant::now();
        self.session.step_watched(samples, &Watch { stop: &stop, events: watch.events })?;
        if !board.has_wish() {
            self.detail.took_samples(self.session.settings(), samples, begin.elapsed());
            self.hand_guide_over();
            self.show()?;
        }
        Ok(())
    }

    /// Renders the picture that is seen, with the guide, until its length or another order ends it, and writes it.
    fn render(&mut self, watch: &Watch<'_>) -> Result<()> {
        let camera = *self.session.camera();
        self.session.set_view(&camera, self.size)?;
        self.note_phase(Phase::Rendering);
        let path = free_name(&self.picture);
        let message = format!("Rendering {}", file_name(&path));
        self.board.change(|pinned| pinned.state.message.clone_from(&message));
        (watch.events)(Event::Note(&format!("rendering {} with the guide", path.display())));
        let board = Arc::clone(&self.board);
        let stop = || (watch.stop)() || board.wants_render.load(Ordering::Relaxed);
        let stopped = Watch { stop: &stop, events: watch.events };
        while self.session.next_step(&stopped)? {
            self.hand_guide_over();
            self.show()?;
        }
        self.board.wants_render.store(false, Ordering::Relaxed);
        self.show()?;
        let written = self.write(&path);
        match &written {
            Ok(()) => (watch.events)(Event::Written(&path)),
            Err(error) => (watch.events)(Event::Warning(&error.to_string())),
        }
        let message = match written {
            Ok(()) => format!("Written: {}", file_name(&path)),
            Err(error) => without_folders(&error.to_string()),
        };
        self.board.change(|pinned| (pinned.state.message, pinned.state.phase) = (message, Phase::Resting));
        // A step that was stopped ends the session's picture, and the next one begins.
        if !self.is_complete() {
            self.session.set_view(&camera, self.size)?;
        }
        Ok(())
    }

    fn write(&self, path: &Path) -> Result<()> {
        let picture = self.session.picture()?;
        let attributes = self.session.attributes(&picture);
        write_picture_with(path, &picture, &attributes, Precision::Float, None, &mut |_| {})
    }

    fn note_phase(&self, phase: Phase) {
        self.board.change(|pinned| pinned.state.phase = phase);
    }

    /// Copies what the guide has learned, if a page has asked for it.
    fn hand_guide_over(&mut self) {
        if self.board.wants_guide.swap(false, Ordering::Relaxed) {
            self.guides += 1;
            // A session whose device is lost fails at its next step, with a message.
            let _ = copy_guide(&self.session, &self.board, self.guides);
        }
    }

    /// Scene units in a unit of camera space, across an orthographic camera at the scale 1.
    fn own_width(&self, camera: &Camera) -> f32 {
        match camera.projection {
            Projection::Orthographic => camera.world_from_camera.x_axis.length() / self.pose.scale,
            _ => 1.0,
        }
    }

    /// Shows the picture so far.
    fn show(&mut self) -> Result<()> {
        let (picture, progress) = (self.session.picture()?, self.session.progress());
        self.shots += 1;
        let middle = picture.width as usize * (picture.height as usize / 2) + picture.width as usize / 2;
        let depth = picture.depth().get(middle).copied().unwrap_or(f32::INFINITY);
        if depth.is_finite() && depth > 0.0 {
            self.distance = depth;
        }
        let camera = *self.session.camera();
        let seen = Seen {
            pose: self.pose,
            wish: self.wish,
            distance: self.distance,
            is_orthographic: camera.projection == Projection::Orthographic,
            half_width: camera.half_extent(self.size[0], self.size[1]).x * self.own_width(&camera),
            size: self.size,
        };
        let content = Content::Rendered(Box::new(picture));
        let shot = Shot::new(self.shots, progress.samples.into(), progress.seconds, content).following(self.wish);
        let shot = Arc::new(shot.with_denoiser(Some(Arc::clone(&self.denoiser))));
        let size = self.size;
        self.board.change(|pinned| {
            note_step(pinned, &self.session);
            show_camera(pinned, seen, &camera, size);
            (pinned.state.shot, pinned.followed) = (shot.number, (shot.wish, None));
            pinned.shot = Some(shot);
        });
        Ok(())
    }
}

/// Notes the camera that the picture is taken with.
fn show_camera(pinned: &mut Pinned, seen: Seen, camera: &Camera, size: [u32; 2]) {
    let is_new = pinned.state.view.as_ref().is_none_or(|view| view.pose != seen.pose);
    pinned.state.view = Some(seen);
    if let (true, Some(scenery)) = (is_new, &mut pinned.scenery) {
        Arc::make_mut(scenery).xml = xml(camera, size);
    }
}

/// Names of the scene's cameras, the cameras, and the index of the one that the picture is taken with. One that is none of the file's
/// comes last.
fn cameras(scene: &Scene) -> (Vec<String>, Vec<Camera>, u32) {
    let known = (0..).zip(scene.cameras.iter().zip(&scene.views)).take(MOST_CAMERAS);
    let named = known.filter_map(|(at, (name, camera)): (usize, _)| {
        Some((name.clone().unwrap_or_else(|| format!("camera {at}")), (*camera)?))
    });
    let (mut names, mut cameras): (Vec<_>, Vec<_>) = named.unzip();
    let index = cameras.iter().position(|camera| *camera == scene.camera).unwrap_or_else(|| {
        names.push("start".into());
        cameras.push(scene.camera);
        cameras.len() - 1
    });
    (names, cameras, index as u32)
}

/// Distance from the camera to the middle of the scene.
fn distance_to_middle(scene: &Scene) -> f32 {
    let eye = scene.camera.world_from_camera.w_axis.truncate();
    let middle = scene.bounds().map_or(Vec3::ZERO, |(low, high)| 0.5 * (low + high));
    Some(eye.distance(middle)).filter(|distance| distance.is_finite() && *distance > 0.0).unwrap_or(1.0)
}

/// The first of `NAME.1.exr`, `NAME.2.exr`, ... that is no file yet.
fn free_name(picture: &Path) -> PathBuf {
    (1_u32..)
        .map(|number| picture.with_extension(format!("{number}.exr")))
        .find(|path| !path.exists())
        .unwrap_or_default()
}
