//! Submission of recorded work, and waiting for it.

use std::sync::Arc;
use std::time::{Duration, Instant};

use ash::vk;

use super::commands::Recorder;
use super::context::Context;
use super::fault::failed;
use super::slot::Slot;
use crate::Result;

/// Times that a submission took.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Submission {
    /// Time from handing the work over to knowing it done, by the host's clock.
    pub wall: Duration,
    /// Time from the start to the end of the work by the device's clock; `None` where it has none.
    pub device: Option<Duration>,
}

impl Context {
    /// Records work, submits it and waits until it is done. Everything that the work uses is borrowed for `'a`, so it
    /// outlives this call. Results can then be read by the host and by later submissions. The label names the work in
    /// errors and in debuggers.
    ///
    /// ```no_run
    /// # use lodestar::gpu::{Buffer, BufferKind, Context, ContextOptions};
    /// # let context = Context::new(&ContextOptions::default())?;
    /// let buffer = Buffer::new(&context, "outlives the call", 16, BufferKind::Storage)?;
    /// context.submit("fill", |recorder| recorder.fill_zero(&buffer))?;
    /// # Ok::<(), lodestar::Error>(())
    /// ```
    /// ```compile_fail,E0597
    /// # use lodestar::gpu::{Buffer, BufferKind, Context, ContextOptions};
    /// # let context = Context::new(&ContextOptions::default())?;
    /// context.submit("fill", |recorder| {
    ///     let buffer = Buffer::new(&context, "dies first", 16, BufferKind::Storage).unwrap();
    ///     recorder.fill_zero(&buffer);
    /// })?;
    /// # Ok::<(), lodestar::Error>(())
    /// ```
    ///
    /// # Errors
    /// Where the device is lost or out of memory.
    pub fn submit<'a>(self: &Arc<Self>, label: &str, record: impl FnOnce(&mut Recorder<'a>)) -> Result<Submission> {
        let mut recorder = Recorder::begin(self, label).map_err(|error| error.during(label))?;
        record(&mut recorder);
        let slot = recorder.end().map_err(|error| error.during(label))?;
        let (begin, wall) = self.run(label, slot)?;
        self.timings().add(label, begin, wall, recorder.dispatch_times());
        Ok(Submission { wall, device: recorder.elapsed() })
    }

    /// Runs a closed command buffer. Returns the time when it was handed over, and how long it took.
    fn run(self: &Arc<Self>, label: &str, slot: &Slot) -> Result<(Instant, Duration)> {
        let commands = [slot.commands()];
        let submits = [vk::SubmitInfo::default().command_buffers(&commands)];
        let queue = self.logical().idle_queue();
        let start = Instant::now();
        slot.set_reusable(false);
        // SAFETY: invariants 1 and 3: queue, fence and command buffer are alive and used by no one else; the queue is
        // held.
        unsafe { self.raw().queue_submit(*queue, &submits, slot.fence()) }.map_err(failed(label))?;
        self.wait(label, slot)?;
        slot.set_reusable(true);
        Ok((start, start.elapsed()))
    }

    /// Waits until the device no longer works on the submission: either it is done, or the device is lost.
    fn wait(&self, label: &str, slot: &Slot) -> Result<()> {
        // A driver that is out of memory may recover. If it keeps failing, there is no sound way to go on.
        for _ in 0..1000 {
            // SAFETY: invariant 1: device and fence are alive; the slot owns the fence.
            match unsafe { self.raw().wait_for_fences(&[slot.fence()], true, u64::MAX) } {
                Ok(()) => return Ok(()),
                Err(vk::Result::ERROR_DEVICE_LOST) => return Err(failed(label)(vk::Result::ERROR_DEVICE_LOST)),
                Err(vk::Result::TIMEOUT) => {}
                Err(code) => {
                    tracing::warn!("waiting for {label}: {code:?}");
                    std::thread::sleep(Duration::from_millis(10));
                }
            }
        }
        tracing::error!("{label} is still running and cannot be waited for; the process is ended");
        std::process::abort()
    }
}
