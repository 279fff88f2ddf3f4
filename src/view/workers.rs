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

/// A few threads, and a permit for each MiB that their answers may take at one time. They end when this is dropped.
pub struct Workers {
    work: Sender<Work>,
    permits: Arc<Semaphore>,
    mebibytes: u32,
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
    /// Starts so many threads, whose answers take at most so many MiB.
    pub fn start(name: &str, threads: usize, mebibytes: u32) -> Result<Self> {
        let (work, queue) = channel();
        let queue = Arc::new(Mutex::new(queue));
        for _ in 0..threads {
            let queue = Arc::clone(&queue);
            let thread = thread::Builder::new().name(name.into()).spawn(move || follow(&queue));
            thread.map_err(|error| Error::Settings(format!("no thread for the page: {error}")))?;
        }
        Ok(Self { work, permits: Arc::new(Semaphore::new(mebibytes as usize)), mebibytes })
    }

    /// Does some work, whose result has so many bytes, on one of the threads. The result counts as in use until its permit is
    /// dropped. A result that is larger than all permits waits until it is alone.
    pub async fn run<T: Send + 'static>(
        &self,
        bytes: u64,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<(T, OwnedSemaphorePermit), Failure> {
        let mebibytes = u32::try_from(bytes.div_ceil(1 << 20)).unwrap_or(u32::MAX).clamp(1, self.mebibytes);
        let permit = timeout(QUEUE_TIME, Arc::clone(&self.permits).acquire_many_owned(mebibytes)).await;
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
            let failed = workers.run(0, || panic!("planted")).await.map(|((), _)| ());
            assert_eq!(failed, Err(Failure::Panicked));
            for i in 0..3 {
                assert_eq!(workers.run(0, move || i).await.map(|(i, _)| i), Ok(i));
            }
        });
    }

    #[test]
    fn answers_that_are_in_use_count() {
        let workers = Workers::start("test", 1, 4).unwrap();
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
        runtime.block_on(async {
            const MIB: u64 = 1 << 20;
            let [first, second] = [workers.run(3 * MIB - 1, || 1).await.unwrap(), workers.run(0, || 2).await.unwrap()];
            let third = timeout(std::time::Duration::from_millis(50), workers.run(1, || 3)).await;
            assert!(third.is_err(), "four MiB are in use");
            drop(first);
            assert_eq!(workers.run(3 * MIB, || 3).await.map(|(i, _)| i), Ok(3));
            let all = timeout(std::time::Duration::from_millis(50), workers.run(u64::MAX, || 4)).await;
            assert!(all.is_err(), "one MiB is in use");
            drop(second);
            assert_eq!(workers.run(u64::MAX, || 4).await.map(|(i, _)| i), Ok(4), "the largest answer is alone");
        });
    }
}
