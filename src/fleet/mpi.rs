//! An exchange between processes: MPI, the library for messages that clusters have.
//!
//! All calls of MPI are made by one thread, which may wait in one of them for a process that has died. Whoever has asked for a call
//! then goes on when the launcher ends the processes.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use mpi::Threading;
use mpi::collective::{CommunicatorCollectives, SystemOperation};
use mpi::environment;
use mpi::point_to_point::{Destination, Source};
use mpi::topology::{Communicator, SimpleCommunicator};
use signal_hook::consts::SIGTERM;

use crate::fleet::exchange::{Exchange, Kind};
use crate::fleet::sums::Sums;
use crate::{Error, Result};

/// Time in which a call must end once the launcher ends the processes.
const GRACE: Duration = Duration::from_millis(500);
/// Interval at which a call that waits looks whether the launcher ends the processes.
const LOOK: Duration = Duration::from_millis(50);
/// Bytes of a message's first part: its length, and what fits of its content.
const FIRST_PART: usize = 4096;
/// Bytes of each further part. MPI counts them with 31 bits.
const FURTHER_PART: usize = 1 << 30;

/// A call of MPI.
type Call = Box<dyn FnOnce(&SimpleCommunicator) + Send>;

/// The processes of an MPI job.
pub struct Mpi {
    rank: usize,
    ranks: usize,
    local_rank: usize,
    machine: String,
    calls: Mutex<Option<Sender<Call>>>,
    thread: Mutex<Option<JoinHandle<()>>>,
    /// Whether the launcher has sent the signal with which it ends processes.
    is_ending: Arc<AtomicBool>,
    /// Whether a call has not come back.
    is_stuck: AtomicBool,
}

/// The place of a process among all.
struct Place {
    rank: usize,
    ranks: usize,
    local_rank: usize,
    machine: String,
}

impl Mpi {
    /// Starts MPI in this process.
    ///
    /// # Errors
    /// Where MPI cannot be started or runs already.
    pub fn start() -> Result<Self> {
        let is_ending = Arc::new(AtomicBool::new(false));
        let failed = |reason: String| Error::Render(format!("MPI cannot be started: {reason}"));
        signal_hook::flag::register(SIGTERM, Arc::clone(&is_ending)).map_err(|error| failed(error.to_string()))?;
        let (calls, received) = channel();
        let (tell_place, place) = channel();
        let run = move || run(&received, &tell_place);
        let thread = thread::Builder::new().name("mpi".into()).spawn(run).map_err(|error| failed(error.to_string()))?;
        let place: Option<Place> = place.recv().ok();
        let Some(Place { rank, ranks, local_rank, machine }) = place else {
            return Err(failed("it runs already".into()));
        };
        let (calls, thread) = (Mutex::new(Some(calls)), Mutex::new(Some(thread)));
        Ok(Self { rank, ranks, local_rank, machine, calls, thread, is_ending, is_stuck: AtomicBool::new(false) })
    }

    /// Has the thread of MPI do something.
    fn call<T: Send + 'static>(&self, act: impl FnOnce(&SimpleCommunicator) -> T + Send + 'static) -> Result<T> {
        let lost = || Error::RankLost { rank: "another rank".into(), note: String::new() };
        if self.is_stuck.load(Ordering::Relaxed) {
            return Err(lost());
        }
        let (reply, replied) = channel();
        let call: Call = Box::new(move |world| drop(reply.send(act(world))));
        let calls = self.calls.lock().unwrap_or_else(PoisonError::into_inner);
        calls.as_ref().and_then(|calls| calls.send(call).ok()).ok_or_else(lost)?;
        drop(calls);
        let mut ending = None;
        loop {
            match replied.recv_timeout(LOOK) {
                Ok(result) => return Ok(result),
                Err(RecvTimeoutError::Timeout) if !self.is_ending() => {}
                Err(RecvTimeoutError::Timeout) if ending.get_or_insert_with(Instant::now).elapsed() <= GRACE => {}
                Err(_) => {
                    self.is_stuck.store(true, Ordering::Relaxed);
                    return Err(lost());
                }
            }
        }
    }
}

impl Drop for Mpi {
    /// Ends MPI together with all other processes. A process that ends without it makes the launcher end the others.
    fn drop(&mut self) {
        let calls = self.calls.get_mut().unwrap_or_else(PoisonError::into_inner).take();
        let thread = self.thread.get_mut().unwrap_or_else(PoisonError::into_inner).take();
        if self.is_stuck.load(Ordering::Relaxed) || self.is_ending() || thread::panicking() {
            // The thread must not wait for the others, and dies with the process.
            std::mem::forget(calls);
            return;
        }
        drop(calls);
        thread.map(JoinHandle::join);
    }
}

/// Makes the calls that come, one after the other.
fn run(calls: &Receiver<Call>, tell_place: &Sender<Place>) {
    // Every call is made by this thread.
    let Some((universe, _)) = environment::initialize_with_threading(Threading::Funneled) else { return };
    let world = universe.world();
    let number = |number: i32| usize::try_from(number).unwrap_or(0);
    let local_rank = number(world.split_shared(world.rank()).rank());
    let machine = environment::processor_name().unwrap_or_else(|_| "an unnamed machine".into());
    let place = Place { rank: number(world.rank()), ranks: number(world.size()), local_rank, machine };
    if tell_place.send(place).is_ok() {
        calls.iter().for_each(|call| call(&world));
    }
}

/// Tags of a message's first part and of its further parts.
fn tags(kind: Kind) -> (i32, i32) {
    let number = match kind {
        Kind::Command => 0,
        Kind::Stop => 1,
        Kind::Report => 2,
        Kind::Answer => 3,
    };
    (2 * number, 2 * number + 1)
}

fn send(world: &SimpleCommunicator, to: i32, kind: Kind, bytes: &[u8]) {
    let (first_tag, further_tag) = tags(kind);
    let (first, rest) = bytes.split_at(bytes.len().min(FIRST_PART - size_of::<u64>()));
    let first = [&(bytes.len() as u64).to_le_bytes()[..], first].concat();
    let process = world.process_at_rank(to);
    process.send_with_tag(&first[..], first_tag);
    rest.chunks(FURTHER_PART).for_each(|part| process.send_with_tag(part, further_tag));
}

fn try_receive(world: &SimpleCommunicator, from: i32, kind: Kind) -> Option<Vec<u8>> {
    let (first_tag, further_tag) = tags(kind);
    let process = world.process_at_rank(from);
    process.immediate_probe_with_tag(first_tag)?;
    let (first, _) = process.receive_vec_with_tag::<u8>(first_tag);
    let (length, content) = first.split_at(size_of::<u64>().min(first.len()));
    let length = length.iter().rev().fold(0, |number, &byte| number << 8 | usize::from(byte));
    let mut bytes = content.to_vec();
    bytes.resize(length, 0);
    let rest = &mut bytes[content.len().min(length)..];
    for part in rest.chunks_mut(FURTHER_PART) {
        process.receive_into_with_tag(part, further_tag);
    }
    Some(bytes)
}

fn add(world: &SimpleCommunicator, sums: &Sums) -> Sums {
    let mut total = sums.clone();
    // Sums of unsigned integers wrap.
    world.all_reduce_into(&sums.targets[..], &mut total.targets[..], SystemOperation::sum());
    world.all_reduce_into(&sums.counts[..], &mut total.counts[..], SystemOperation::sum());
    world.all_reduce_into(&sums.marks[..], &mut total.marks[..], SystemOperation::bitwise_or());
    total
}

impl Exchange for Mpi {
    fn rank(&self) -> usize {
        self.rank
    }

    fn ranks(&self) -> usize {
        self.ranks
    }

    fn local_rank(&self) -> usize {
        self.local_rank
    }

    fn machine(&self) -> String {
        self.machine.clone()
    }

    fn send(&self, to: usize, kind: Kind, bytes: &[u8]) -> Result<()> {
        let bytes = bytes.to_vec();
        self.call(move |world| send(world, to as i32, kind, &bytes))
    }

    fn try_receive(&self, from: usize, kind: Kind) -> Result<Option<Vec<u8>>> {
        self.call(move |world| try_receive(world, from as i32, kind))
    }

    fn add(&self, sums: &mut Sums) -> Result<()> {
        let own = std::mem::take(sums);
        *sums = self.call(move |world| add(world, &own))?;
        Ok(())
    }

    fn is_ending(&self) -> bool {
        self.is_ending.load(Ordering::Relaxed)
    }
}
