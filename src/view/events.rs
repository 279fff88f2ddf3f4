//! Events: the render's state, told to all pages that listen.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use hyper::body::Bytes;
use tokio::sync::{Semaphore, mpsc, watch};
use tokio::time::{sleep, timeout};

use crate::view::board::Board;
use crate::view::content::{Answer, claiming, events, text};
use crate::view::limits::{EVENT_INTERVAL, HEARTBEAT};

/// Everybody who listens to one render.
pub struct Listeners {
    board: Arc<Board>,
    told: watch::Sender<Told>,
    places: Arc<Semaphore>,
}

/// State of the render as an event.
#[derive(Clone, Default)]
struct Told {
    event: Bytes,
    is_last: bool,
}

impl Told {
    fn of(board: &Board) -> Self {
        // The end is looked at first, so that the last event has the last state.
        let is_last = board.is_closed();
        let state = board.lock().state.clone();
        let json = serde_json::to_string(&state).unwrap_or_default();
        Self { event: format!("data: {json}\n\n").into(), is_last }
    }
}

impl Listeners {
    /// Listeners of `board`, at most so many.
    pub fn new(board: Arc<Board>, most: usize) -> Self {
        Self { board, told: watch::Sender::default(), places: Arc::new(Semaphore::new(most)) }
    }

    /// Tells the state whenever it changes, until the render ends. All pages get the same bytes. A slow page misses states, but not
    /// the last one.
    pub async fn tell(&self) {
        let mut changes = self.board.changes();
        loop {
            changes.mark_unchanged();
            let is_last = self.board.is_closed();
            if self.told.receiver_count() > 0 {
                self.told.send_replace(Told::of(&self.board));
            }
            if is_last {
                return;
            }
            // A change meanwhile ends the wait at once.
            sleep(EVENT_INTERVAL).await;
            let _ = timeout(HEARTBEAT, changes.changed()).await;
        }
    }

    /// Answer with the state now and whenever it changes. Whoever listens also asks for a picture.
    pub fn listen(&self) -> Answer {
        let Ok(place) = Arc::clone(&self.places).try_acquire_owned() else {
            return text(503, "Too many pages are open; close some.");
        };
        self.board.wants_shot.store(true, Ordering::Relaxed);
        let (page, received) = mpsc::channel(1);
        let told = self.told.subscribe();
        tokio::spawn(forward(Told::of(&self.board), told, page));
        claiming(events(received), (Some(place), None))
    }
}

/// Sends a page what is told now and later.
async fn forward(mut now: Told, mut told: watch::Receiver<Told>, page: mpsc::Sender<Bytes>) {
    while page.send(now.event).await.is_ok() && !now.is_last && told.changed().await.is_ok() {
        now = told.borrow_and_update().clone();
    }
}
