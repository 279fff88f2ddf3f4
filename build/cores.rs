//! Jobs on all cores, for the build scripts of the crate and of `tests/tampered`.

use std::sync::{Mutex, PoisonError};
use std::{env, thread};

/// Bytes of a thread's stack. The optimizer of SPIR-V recurses along the blocks of a kernel.
const STACK: usize = 1 << 30;

/// Runs all jobs on all cores. Returns their results in the order of the jobs.
pub fn on_all_cores<T: Send>(job_count: usize, job: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let queue = Mutex::new(0..job_count);
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
    let work = || std::iter::from_fn(next).map(|index| (index, job(index))).collect::<Vec<_>>();
    let mut results = thread::scope(|scope| {
        let spawn = |_| thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work).expect("a thread");
        let workers: Vec<_> = (0..core_count().min(job_count)).map(spawn).collect();
        workers.into_iter().flat_map(|worker| worker.join().expect("no job panics")).collect::<Vec<_>>()
    });
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}

/// Number of threads to use: the number that Cargo was told to use, or the number of cores.
fn core_count() -> usize {
    let told = env::var("NUM_JOBS").ok().and_then(|jobs| jobs.parse().ok());
    told.unwrap_or_else(|| thread::available_parallelism().map_or(1, usize::from))
}
