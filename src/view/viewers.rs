//! The render's side of its viewers: what happens between two steps.

use std::ops::ControlFlow;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use crate::Result;
use crate::denoise::DenoiseOptions;
use crate::film::Picture;
use crate::session::statistics::StepStatistics;
use crate::session::{Ending, Event, Progress, Session, Watch};
use crate::settings::{Settings, options};
use crate::view::board::{Board, CurvePoint, Phase, Pinned, State, thinned};
use crate::view::denoiser::LazyDenoiser;
use crate::view::display::Display;
use crate::view::guide::{GuideCells, GuideCopy, MOST_BYTES};
use crate::view::names::{file_name, scene_name, without_folders};
use crate::view::server::Server;
use crate::view::shot::{Content, Shot};

/// Least ratio of the time between two copies to the time that one copy takes.
const COPY_SHARE: u32 = 60;
/// Shortest time between two copies.
const COPY_INTERVAL: Duration = Duration::from_millis(250);
/// Interval at which a render that is paused looks for requests.
const PAUSED_INTERVAL: Duration = Duration::from_millis(50);
/// Time that pages have at the end to fetch the last picture.
const FAREWELL: Duration = Duration::from_secs(2);

/// Viewers that a caller wants.
#[derive(Debug, Clone, Default)]
pub struct ViewOptions {
    /// Address at which a page is served, such as `127.0.0.1:0`.
    pub page: Option<String>,
    /// Address of a display server that speaks tev's protocol.
    pub display_server: Option<String>,
    /// The denoiser of the page's layer `denoised`. It is loaded when a page asks for that layer first.
    pub denoiser: DenoiseOptions,
}

/// Viewers of one render. All of them may leave or hang without harm to the render.
pub struct Viewers {
    page: Option<(Arc<Board>, Server)>,
    display: Option<Display>,
    copies: Mutex<Copies>,
    denoiser: Option<Arc<LazyDenoiser>>,
}

/// Copies so far.
struct Copies {
    /// Time before which no further copy is made.
    next: Instant,
    shots: u64,
    guides: u64,
}

impl Viewers {
    /// Starts the viewers that `options` ask for.
    ///
    /// # Errors
    /// Where an address cannot be used.
    pub fn start(options: &ViewOptions) -> Result<Self> {
        let serve = |address: &String| {
            let board = Arc::new(Board::default());
            Ok((Arc::clone(&board), Server::start(address, board)?))
        };
        Ok(Self {
            page: options.page.as_ref().map(serve).transpose()?,
            display: options.display_server.as_deref().map(Display::start).transpose()?,
            copies: Mutex::new(Copies { next: Instant::now(), shots: 0, guides: 0 }),
            denoiser: options.page.as_ref().map(|_| Arc::new(LazyDenoiser::new(options.denoiser.clone()))),
        })
    }

    /// Address of the page, if one is served.
    pub fn url(&self) -> Option<String> {
        self.page.as_ref().map(|(_, server)| server.url())
    }

    /// Whether a viewer has ended the render.
    pub fn is_stopped(&self) -> bool {
        self.page.as_ref().is_some_and(|(board, _)| board.is_stopped())
    }

    /// Shows an event of the render.
    pub fn show(&self, event: Event<'_>) {
        let Some((board, _)) = &self.page else { return };
        match event {
            Event::Preparing(preparation) => board.change(|pinned| {
                pinned.state.message = without_folders(&preparation.to_string());
            }),
            Event::Begun(beginning) => board.change(|pinned| {
                let state = &mut pinned.state;
                if state.phase == Phase::Preparing {
                    state.phase = Phase::Rendering;
                }
                state.message.clear();
                state.scene = scene_name(beginning.scene);
                state.device = beginning.device.to_owned();
                state.sampler = sampler_word(beginning.settings);
                state.samples_lights = beginning.settings.nee;
                state.files = beginning.files.iter().map(|file| file_name(file)).collect();
                (state.wanted_samples, state.wanted_seconds) = (beginning.length.spp, beginning.length.seconds);
            }),
            Event::Written(path) => board.change(|pinned| {
                pinned.state.message = format!("Written: {}", file_name(path));
            }),
            Event::Warning(message) => board.change(|pinned| pinned.state.message = without_folders(message)),
            Event::Ended(ending, progress) => board.change(|pinned| end(pinned, ending, progress)),
            _ => {}
        }
    }

    /// Looks between two steps what viewers have asked for. While the render is paused, this function does not return.
    /// `Break` ends the render.
    pub fn after_step(&self, session: &Session, watch: &Watch<'_>) -> ControlFlow<()> {
        if let Some((board, _)) = &self.page {
            board.change(|pinned| note_step(pinned, session));
        }
        loop {
            self.hand_over(session);
            self.warn(watch.events);
            let Some((board, _)) = &self.page else { return ControlFlow::Continue(()) };
            if board.wants_file.swap(false, Ordering::Relaxed)
                && let Err(error) = session.write_now(watch)
            {
                (watch.events)(Event::Warning(&format!("{error}; the render goes on")));
            }
            let mut is_news = false;
            let mut pinned = board.lock();
            let is_paused = pinned.is_paused && !(watch.stop)();
            if is_paused && pinned.state.phase == Phase::Pausing {
                (pinned.state.phase, is_news) = (Phase::Paused, true);
            }
            drop(pinned);
            if is_news {
                board.change(|_| {});
            }
            if !is_paused {
                return ControlFlow::Continue(());
            }
            thread::sleep(PAUSED_INTERVAL);
        }
    }

    /// Tells what viewers cannot do, once.
    fn warn(&self, events: &dyn Fn(Event<'_>)) {
        if let Some(warning) = self.display.as_ref().and_then(Display::warning) {
            events(Event::Warning(&warning));
        }
    }

    /// Hands copies over to those who have asked, unless the last copy was made a moment ago.
    fn hand_over(&self, session: &Session) {
        let board = self.page.as_ref().map(|(board, _)| board);
        let asks = |flag: fn(&Board) -> bool| board.is_some_and(|board| flag(board));
        let samples: u64 = session.progress().samples.into();
        let [shot_of, guide_of] = self.shown();
        let wants_guide = asks(|board| board.wants_guide.load(Ordering::Relaxed)) && guide_of != Some(samples);
        let wants_shot = wants_guide || asks(|board| board.wants_shot.load(Ordering::Relaxed));
        let display = self.display.as_ref().filter(|display| display.is_ready());
        let wants_shot = display.is_some() || (wants_shot && shot_of != Some(samples));
        let Ok(mut copies) = self.copies.try_lock() else { return };
        let begin = Instant::now();
        if !(wants_guide || wants_shot) || begin < copies.next {
            return;
        }
        // A render whose device is lost fails at its next step, with a message.
        if let (true, Some(board)) = (wants_guide, board) {
            board.wants_guide.store(false, Ordering::Relaxed);
            copies.guides += 1;
            let _ = copy_guide(session, board, copies.guides);
        }
        if wants_shot && let Ok(picture) = session.picture() {
            copies.shots += 1;
            self.show_picture(picture, &session.progress(), copies.shots, display);
        }
        copies.next = Instant::now() + (begin.elapsed() * COPY_SHARE).max(COPY_INTERVAL);
    }

    /// Samples per pixel of the shot and of the guide that the page shows.
    fn shown(&self) -> [Option<u64>; 2] {
        let Some((board, _)) = &self.page else { return [None; 2] };
        let pinned = board.lock();
        [pinned.shot.as_ref().map(|shot| shot.samples), pinned.guide.as_ref().map(|copy| copy.samples)]
    }

    fn show_picture(&self, picture: Picture, progress: &Progress, number: u64, display: Option<&Display>) {
        let content = Content::Rendered(Box::new(picture));
        let shot = Shot::new(number, progress.samples.into(), progress.seconds, content);
        let shot = Arc::new(shot.with_denoiser(self.denoiser.clone()));
        if let Some(display) = display {
            display.send(Arc::clone(&shot));
        }
        if let Some((board, _)) = &self.page {
            board.wants_shot.store(false, Ordering::Relaxed);
            board.change(|pinned| {
                pinned.state.shot = shot.number;
                pinned.shot = Some(shot);
            });
        }
    }

    /// Shows the last picture and says goodbye. Pages that are open have 2 seconds to fetch it.
    pub fn finish(&self, session: &Session, watch: &Watch<'_>) {
        let number = self.copies.lock().map_or(0, |copies| copies.shots) + 1;
        let was_watched = number > 1 || self.page.as_ref().is_some_and(|(b, _)| b.wants_shot.load(Ordering::Relaxed));
        if (was_watched || self.display.is_some())
            && let Ok(picture) = session.picture()
        {
            self.show_picture(picture, &session.progress(), number, self.display.as_ref());
        }
        if let Some((board, _)) = self.page.as_ref().filter(|_| was_watched) {
            let end = Instant::now() + FAREWELL;
            let is_busy = || board.answering.load(Ordering::Relaxed) > 0 || !board.wants_shot.load(Ordering::Relaxed);
            while Instant::now() < end && is_busy() {
                thread::sleep(PAUSED_INTERVAL);
            }
            // A page asks for the pixel and the cells right after the picture.
            thread::sleep(PAUSED_INTERVAL);
        }
        if let Some(display) = &self.display {
            display.finish();
        }
        self.warn(watch.events);
    }
}

/// Word of the sampler on the command line.
pub(super) fn sampler_word(settings: &Settings) -> String {
    let setting = options::find("sampler").and_then(|option| option.setting);
    setting.map(|setting| (setting.get)(settings).to_string()).unwrap_or_default()
}

/// Notes the progress after a step.
pub(super) fn note_step(pinned: &mut Pinned, session: &Session) {
    let (progress, history) = (session.progress(), session.history());
    let state = &mut pinned.state;
    note_progress(state, &progress);
    if let Some(step) = history.steps.last() {
        state.rays_per_second = (step.rays + step.shadow_rays) as f64 / step.seconds.max(1.0e-9);
        // A resumed render has errors from before.
        if step.errors.is_some() {
            state.errors = errors_of(&history.steps);
        }
    }
}

/// Mean absolute errors after the steps at whose ends they were measured.
fn errors_of(steps: &[StepStatistics]) -> Vec<CurvePoint> {
    let (mut samples, mut seconds) = (0, 0.0);
    let point = |step: &StepStatistics| {
        samples += step.spp;
        seconds += step.seconds;
        Some(CurvePoint { samples, seconds, value: step.errors?.mae })
    };
    thinned(steps.iter().filter_map(point).collect())
}

fn note_progress(state: &mut State, progress: &Progress) {
    state.samples = progress.samples.into();
    (state.seconds, state.fraction) = (progress.seconds, progress.fraction);
    state.light_hit_rate = progress.light_hit_rate;
    state.noise_target = progress.noise.map(|noise| noise.target);
    state.noisiest_tile = progress.noise.and_then(|noise| noise.largest);
    state.sampled_share = progress.noise.map_or(1.0, |noise| noise.sampled_share);
}

fn end(pinned: &mut Pinned, ending: Ending, progress: &Progress) {
    note_progress(&mut pinned.state, progress);
    let reason = match ending {
        Ending::Samples => "All samples are taken.",
        Ending::Time => "The time is up.",
        Ending::Noise => "The noise is low enough everywhere.",
        Ending::Stopped => "The render was stopped.",
        Ending::Failed => "The render failed; the terminal says why.",
    };
    (pinned.state.phase, pinned.state.message) = (Phase::Ended, reason.to_owned());
    pinned.is_paused = false;
}

/// Copies what the guide has learned, if there is a guide that is not too large.
pub(super) fn copy_guide(session: &Session, board: &Board, number: u64) -> Result<()> {
    let known = board.lock().cells.clone();
    let cells = match (known, session.cells()) {
        (_, Err(reason)) => {
            board.change(|pinned| pinned.state.no_guide = Some(reason.to_owned()));
            return Ok(());
        }
        (Some(cells), _) => cells,
        (None, Ok(cells)) => Arc::new(GuideCells::new(cells, session.settings())),
    };
    if cells.bytes() > MOST_BYTES {
        let reason =
            format!("The guide is larger than {} MiB, so it is not copied while it renders.", MOST_BYTES >> 20);
        board.change(|pinned| pinned.state.no_guide = Some(reason));
        return Ok(());
    }
    let (radiance, shares) = (session.learned_radiance()?, session.bsdf_shares()?);
    let copy = GuideCopy { number, samples: session.progress().samples.into(), radiance, shares };
    board.change(|pinned| {
        pinned.state.guide = copy.number;
        (pinned.cells, pinned.guide) = (Some(cells), Some(Arc::new(copy)));
    });
    Ok(())
}
