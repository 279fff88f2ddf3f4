//! Board between a render and its viewers: the render pins its progress and copies of the picture on it, viewers pin requests.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde::Serialize;
use tokio::sync::watch;

use crate::scene::Camera;
use crate::view::guide::{GuideCells, GuideCopy};
use crate::view::pose::Pose;
use crate::view::shot::Shot;

/// Phase of a render as the page shows it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Phase {
    /// The scene is read and the kernels are built.
    #[default]
    Preparing,
    /// Steps are taken.
    Rendering,
    /// A pause was asked for; the step under way goes on to its end.
    Pausing,
    /// No steps are taken until somebody asks for them.
    Paused,
    /// The end was asked for; the files follow.
    Stopping,
    /// The render has ended.
    Ended,
    /// The picture is one from a file.
    File,
    /// The camera moves, and pictures are small.
    Moving,
    /// The camera stands still, and the picture gets finer.
    Resting,
}

/// Noise or error after some samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct CurvePoint {
    pub samples: u64,
    pub seconds: f64,
    pub value: f64,
}

/// Most points of a curve. Each event carries all of them.
const MOST_POINTS: usize = 1000;

/// `points` of a curve, every second one left out as often as there are too many. The last one stays.
pub(super) fn thinned(mut points: Vec<CurvePoint>) -> Vec<CurvePoint> {
    while points.len() > MOST_POINTS {
        let odd = points.len() % 2;
        let mut at = 0;
        points.retain(|_| {
            at += 1;
            at % 2 == odd
        });
    }
    points
}

/// Facts about a render that the page shows.
#[derive(Debug, Clone, Default, Serialize)]
pub(super) struct State {
    pub phase: Phase,
    /// One sentence about the phase, or the last warning.
    pub message: String,
    pub scene: String,
    pub device: String,
    pub sampler: String,
    /// Files into which the picture is written.
    pub files: Vec<String>,
    /// Samples per pixel so far, and as many as are wanted.
    pub samples: u64,
    pub wanted_samples: Option<u32>,
    /// Seconds of rendering so far, and as many as are wanted.
    pub seconds: f64,
    pub wanted_seconds: Option<f64>,
    pub fraction: f64,
    /// Rays per second of the last step, shadow rays included.
    pub rays_per_second: f64,
    pub light_hit_rate: f64,
    /// Relative error at which tiles end, and that of the noisiest tile.
    pub noise_target: Option<f32>,
    pub noisiest_tile: Option<f64>,
    /// Share of the pixels that are still sampled.
    pub sampled_share: f64,
    /// Estimates of the noise of the shots so far.
    pub noise: Vec<CurvePoint>,
    /// Mean absolute errors against the reference.
    pub errors: Vec<CurvePoint>,
    /// Number of the last shot; 0 before the first.
    pub shot: u64,
    /// Number of the last copy of the guide; 0 before the first.
    pub guide: u64,
    /// Reason why there is no guide to be seen.
    pub no_guide: Option<String>,
    /// Whether light that is sampled directly stays out of the guide.
    pub samples_lights: bool,
    /// The camera, where viewers may move it.
    pub view: Option<Seen>,
}

/// The camera that pictures are taken with.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Seen {
    pub pose: Pose,
    /// Number of the wish that it follows; 0 before the first.
    pub wish: u64,
    /// Distance to what the middle of the picture shows, scene units.
    pub distance: f32,
    pub is_orthographic: bool,
    /// Half the width of the view at depth 1, or of an orthographic one at the scale 1, scene units.
    pub half_width: f32,
    /// Size of the picture of a camera at rest.
    pub size: [u32; 2],
}

/// Cameras of a session that moves.
#[derive(Debug, Clone, Default)]
pub(super) struct Scenery {
    /// The scene's cameras.
    pub cameras: Vec<Camera>,
    /// Their names and poses.
    pub poses: Vec<(String, Pose)>,
    /// The camera now, as XML.
    pub xml: String,
}

/// Where a viewer wants the camera to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Wish {
    /// Number of the wish, counted from 1.
    pub number: u64,
    pub pose: Pose,
    pub camera: Camera,
    /// Whether others are to follow at once, so that the picture may stay small.
    pub is_moving: bool,
}

/// State, picture and guide that viewers see.
#[derive(Default)]
pub(super) struct Pinned {
    pub state: State,
    pub shot: Option<Arc<Shot>>,
    pub cells: Option<Arc<GuideCells>>,
    pub guide: Option<Arc<GuideCopy>>,
    pub is_paused: bool,
    /// Last wish that nobody has looked at, and the number of wishes so far. A later wish takes the place of an earlier one.
    pub wish: Option<Wish>,
    pub wishes: u64,
    /// Wish that the shot follows, and the sentence if it could not be followed.
    pub followed: (u64, Option<String>),
    /// Cameras that viewers may choose, where they may move one.
    pub scenery: Option<Arc<Scenery>>,
}

/// Things that a viewer may ask of a render.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    Pause,
    GoOn,
    Stop,
    Write,
    /// Render the picture that is seen, with the guide, and write it; or end that.
    Render,
}

/// The board.
#[derive(Default)]
pub(super) struct Board {
    pinned: Mutex<Pinned>,
    changed: watch::Sender<()>,
    /// Requests that the render looks at between two steps.
    pub wants_shot: AtomicBool,
    pub wants_guide: AtomicBool,
    pub wants_file: AtomicBool,
    /// Number of holders' requests that are being answered, without those for events.
    pub answering: AtomicUsize,
    pub wants_render: AtomicBool,
    wants_stop: AtomicBool,
    /// Whether viewers shall leave.
    is_closed: AtomicBool,
    /// Whoever moves the camera waits here for wishes and orders.
    asked: Condvar,
}

impl Board {
    pub fn lock(&self) -> MutexGuard<'_, Pinned> {
        self.pinned.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes what is pinned, and wakes whoever waits for a change.
    pub fn change(&self, change: impl FnOnce(&mut Pinned)) {
        change(&mut self.lock());
        self.changed.send_replace(());
    }

    /// Receiver that is told about every change from now on.
    pub fn changes(&self) -> watch::Receiver<()> {
        self.changed.subscribe()
    }

    /// Follows an order of a viewer.
    pub fn give(&self, order: Order) {
        self.change(|pinned| {
            let is_moving = pinned.scenery.is_some();
            let phase = &mut pinned.state.phase;
            match (order, *phase) {
                (_, Phase::Ended | Phase::File | Phase::Stopping) => {}
                (Order::Pause, Phase::Rendering) if !is_moving => (*phase, pinned.is_paused) = (Phase::Pausing, true),
                (Order::GoOn, Phase::Pausing | Phase::Paused) => (*phase, pinned.is_paused) = (Phase::Rendering, false),
                (Order::Stop, _) => {
                    (*phase, pinned.is_paused) = (Phase::Stopping, false);
                    self.wants_stop.store(true, Ordering::Relaxed);
                }
                (Order::Write, _) => self.wants_file.store(true, Ordering::Relaxed),
                (Order::Render, _) if is_moving => self.wants_render.store(true, Ordering::Relaxed),
                _ => {}
            }
        });
        self.asked.notify_all();
    }

    /// Wishes the camera to be elsewhere. Returns the number of the wish.
    pub fn wish(&self, pose: Pose, camera: Camera, is_moving: bool) -> u64 {
        let mut pinned = self.lock();
        pinned.wishes += 1;
        let number = pinned.wishes;
        pinned.wish = Some(Wish { number, pose, camera, is_moving });
        drop(pinned);
        self.asked.notify_all();
        number
    }

    /// Whether there is a wish that nobody has taken.
    pub fn has_wish(&self) -> bool {
        self.lock().wish.is_some()
    }

    /// Takes the last wish. Waits for one, or for an order, at most so long.
    pub fn take_wish(&self, at_most: Duration) -> Option<Wish> {
        let pinned = self.lock();
        let is_idle = |pinned: &mut Pinned| pinned.wish.is_none() && !self.wants_render.load(Ordering::Relaxed);
        let waited = self.asked.wait_timeout_while(pinned, at_most, is_idle);
        waited.unwrap_or_else(PoisonError::into_inner).0.wish.take()
    }

    /// Whether a viewer has ended the render.
    pub fn is_stopped(&self) -> bool {
        self.wants_stop.load(Ordering::Relaxed)
    }

    /// Sends all viewers away.
    pub fn close(&self) {
        self.is_closed.store(true, Ordering::Relaxed);
        self.change(|_| {});
    }

    pub fn is_closed(&self) -> bool {
        self.is_closed.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn phase_after(first: Phase, orders: &[Order]) -> (Phase, bool, bool) {
        let board = Board::default();
        board.change(|pinned| pinned.state.phase = first);
        orders.iter().for_each(|&order| board.give(order));
        let pinned = board.lock();
        (pinned.state.phase, pinned.is_paused, board.is_stopped())
    }

    #[test]
    fn orders_are_followed_where_they_make_sense() {
        use Order::{GoOn, Pause, Stop};
        assert_eq!(phase_after(Phase::Rendering, &[Pause]), (Phase::Pausing, true, false));
        assert_eq!(phase_after(Phase::Rendering, &[Pause, GoOn]), (Phase::Rendering, false, false));
        assert_eq!(phase_after(Phase::Rendering, &[Pause, Stop, GoOn]), (Phase::Stopping, false, true));
        assert_eq!(phase_after(Phase::Preparing, &[Pause]), (Phase::Preparing, false, false));
        assert_eq!(phase_after(Phase::Preparing, &[Stop]), (Phase::Stopping, false, true));
        assert_eq!(phase_after(Phase::Ended, &[Pause, Stop]), (Phase::Ended, false, false));
        assert_eq!(phase_after(Phase::File, &[Stop]), (Phase::File, false, false));
        assert_eq!(phase_after(Phase::Moving, &[Pause, Stop]), (Phase::Stopping, false, true));
    }

    /// Wishes do not queue up: whoever moves the camera sees the last one.
    #[test]
    fn the_last_wish_counts() {
        let board = Board::default();
        let pose = |focus| Pose {
            camera: 0,
            eye: [0.0; 3],
            forward: [0.0, 0.0, 1.0],
            up: [0.0, 1.0, 0.0],
            aperture: 0.0,
            focus,
            scale: 1.0,
        };
        assert_eq!(board.take_wish(Duration::ZERO), None);
        let camera = Camera::look_at([0.0; 3], [0.0, 0.0, 1.0], 40.0);
        assert_eq!((board.wish(pose(1.0), camera, true), board.wish(pose(2.0), camera, false)), (1, 2));
        assert!(board.has_wish());
        let last = Wish { number: 2, pose: pose(2.0), camera, is_moving: false };
        assert_eq!((board.take_wish(Duration::ZERO), board.has_wish()), (Some(last), false));
        assert_eq!(board.take_wish(Duration::ZERO), None);
    }

    #[test]
    fn changes_and_the_end_are_told() {
        let board = Board::default();
        let mut changes = board.changes();
        assert!(!changes.has_changed().unwrap());
        board.change(|_| {});
        assert!(changes.has_changed().unwrap());
        changes.mark_unchanged();
        board.close();
        assert!(changes.has_changed().unwrap() && board.is_closed());
    }
}

#[test]
fn curves_stay_short_and_keep_their_last_point() {
    let point = |samples| CurvePoint { samples, seconds: 0.0, value: 0.0 };
    for count in [0, 1, 999, 1000, 1001, 1002, 4711, 100_000] {
        let points = thinned((0..count).map(point).collect());
        assert!(points.len() <= MOST_POINTS && (count < 1000 || points.len() > MOST_POINTS / 3), "{count}");
        assert_eq!(points.last().map(|point| point.samples), count.checked_sub(1), "{count}");
        assert!(points.is_sorted_by_key(|point| point.samples));
    }
}
