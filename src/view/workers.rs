//! Threads that make what takes time: layers, cells and pixels. A panic of such work ends that work only.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};
use tokio::time::timeout;

use crate::view::limits::QUEUE_TIME;
use crate::{Error, Result};

type Work = Box<dyn FnOnce() + Send>;

/// A few threads, and as many permits as there may be answers at one time. They end when this is dropped.
pub struct Workers {
    work: Sender<Work>,
    permits: Arc<Semaphore>,
}

/// Reasons why there is no result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Failure {
    /// All permits are in use for a long time.
    Busy,
    /// The work has panicked.
    Panicked,
}

impl Workers {
    /// Starts so many threads.
    pub fn start(name: &str, threads: usize, permits: usize) -> Result<Self> {
        let (work, queue) = channel();
        let queue = Arc::new(Mutex::new(queue));
        for _ in 0..threads {
            let queue = Arc::clone(&queue);
            let thread = thread::Builder::new().name(name.into()).spawn(move || follow(&queue));
            thread.map_err(|error| Error::Settings(format!("no thread for the page: {error}")))?;
        }
        Ok(Self { work, permits: Arc::new(Semaphore::new(permits)) })
    }

    /// Does some work on one of the threads. The result counts as in use until its permit is dropped.
    pub async fn run<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<(T, OwnedSemaphorePermit), Failure> {
        let permit = timeout(QUEUE_TIME, Arc::clone(&self.permits).acquire_owned()).await;
        let permit = permit.ok().and_then(Result::ok).ok_or(Failure::Busy)?;
        let (done, result) = oneshot::channel();
        // The permit goes along, because the work goes on where nobody waits for it any more.
        let run = move || drop(done.send((work(), permit)));
        self.work.send(Box::new(run)).map_err(|_| Failure::Panicked)?;
        result.await.map_err(|_| Failure::Panicked)
    }
}

/// Does work until there can be no more.
fn follow(queue: &Mutex<Receiver<Work>>) {
    loop {
        let work = queue.lock().unwrap_or_else(PoisonError::into_inner).recv();
        let Ok(work) = work else { return };
        // The message of a panic has been printed.
        let _ = catch_unwind(AssertUnwindSafe(work));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_ends_its_own_work_only() {
        let workers = Workers::start("test", 1, 2).unwrap();
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
        runtime.block_on(async {
            let failed = workers.run(|| panic!("planted")).await.map(|((), _)| ());
            assert_eq!(failed, Err(Failure::Panicked));
            for i in 0..3 {
                assert_eq!(workers.run(move || i).await.map(|(i, _)| i), Ok(i));
            }
        });
    }

    #[test]
    fn answers_that_are_in_use_count() {
        let workers = Workers::start("test", 1, 2).unwrap();
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
        runtime.block_on(async {
            let [first, _second] = [workers.run(|| 1).await.unwrap(), workers.run(|| 2).await.unwrap()];
            let third = timeout(std::time::Duration::from_millis(50), workers.run(|| 3)).await;
            assert!(third.is_err(), "two permits are in use");
            drop(first);
            assert_eq!(workers.run(|| 3).await.map(|(i, _)| i), Ok(3));
        });
    }
}
