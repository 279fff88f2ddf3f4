//! Several devices that render one picture, in one process or in several.
//!
//! Each device holds the whole scene and its own copy of the guide, and traces its share of the film's tiles. After tracing,
//! the sums of all devices are added up and handed to every device, which then learns from them as if it had traced the whole
//! film. So any number of devices of one kind gives the bits of one device.
//!
//! | part | file |
//! |---|---|
//! | the devices of one process | `devices.rs` |
//! | ranks, which are processes: who leads, and how they agree | `team.rs`, `command.rs`, `serve.rs`, `failure.rs` |
//! | the connection of ranks: in memory, or MPI | `exchange.rs`, `in_memory.rs`, `mpi.rs`, `trial.rs` |
//! | what they share: tiles, sums, the film, and times of that | `share.rs`, `speed.rs`, `sums.rs`, `addition.rs`, `film.rs`, `times.rs` |

use std::sync::Arc;

use super::Renderer;
use crate::renderer::ranks::share::Share;
use crate::renderer::ranks::sums::AddSums;
use crate::renderer::ranks::team::Team;
use crate::renderer::ranks::times::SharingTimes;
use crate::renderer::statistics::Counts;
use crate::{Error, Result};

mod addition;
pub(super) mod command;
mod devices;
pub mod exchange;
mod failure;
mod film;
pub mod in_memory;
#[cfg(feature = "mpi")]
pub mod mpi;
mod serve;
pub(super) mod share;
mod speed;
pub mod sums;
pub mod team;
pub(super) mod times;
pub mod trial;

impl Renderer {
    /// Shares the film with renderers of the same scene and settings on other devices.
    ///
    /// # Errors
    /// Where samples were taken already, or a device is lost.
    pub fn share_with(&mut self, others: Vec<Self>) -> Result<()> {
        self.share_with_sums(others, sums::add)
    }

    /// Shares the film as [`Renderer::share_with`] does. `add_sums` adds another device's sums to the total. Tests give a wrong one.
    ///
    /// # Errors
    /// Where samples were taken already, or a device is lost.
    #[doc(hidden)]
    pub fn share_with_sums(&mut self, others: Vec<Self>, add_sums: AddSums) -> Result<()> {
        if self.samples_done > 0 || others.iter().any(|other| other.samples_done > 0 || !other.others.is_empty()) {
            return Err(too_late());
        }
        (self.others, self.add_sums) = (others, add_sums);
        self.deal(&vec![1; self.device_count()])
    }

    /// Shares the film with the other ranks of a team. On other ranks than the first one, only [`Renderer::serve`] may follow.
    ///
    /// # Errors
    /// Where samples were taken already, or a device is lost.
    pub fn join(&mut self, team: &Arc<Team>) -> Result<()> {
        if self.samples_done > 0 {
            return Err(too_late());
        }
        self.team = Some(Arc::clone(team));
        self.deal(&vec![1; team.device_count()])
    }

    /// Deals out the tiles of the film to the devices of all ranks, in proportion to their weights. All ranks do it, with the same weights,
    /// before the first sample.
    ///
    /// # Errors
    /// Where a device is lost.
    #[doc(hidden)]
    pub fn deal(&mut self, weights: &[u32]) -> Result<()> {
        self.dealt = Share::by_weights(weights);
        self.all()
            .zip(self.shares())
            .try_for_each(|(renderer, &share)| renderer.sets.frame.pages().iter().try_for_each(|page| page.deal(share)))
    }

    /// Shares of the devices of this process.
    fn shares(&self) -> &[Share] {
        match &self.team {
            Some(team) => &self.dealt[team.own_devices()],
            None => &self.dealt,
        }
    }

    /// Whether this is the first rank, or the only one.
    pub(crate) fn leads(&self) -> bool {
        self.team.as_ref().is_none_or(|team| team.leads())
    }

    /// Number of devices of this process.
    pub fn device_count(&self) -> usize {
        1 + self.others.len()
    }

    /// Times of the work that devices do only because they share a film. `None` where one device renders alone.
    pub fn sharing_times(&self) -> Option<SharingTimes> {
        let team = self.team.as_deref();
        (team.is_some() || !self.others.is_empty()).then(|| SharingTimes {
            ranks: team.map_or(1, Team::ranks),
            devices: team.map_or_else(|| self.device_count(), Team::device_count),
            exchange_seconds: self.exchange_clock.seconds(),
            gather_seconds: self.gather_clock.seconds(),
            waiting_seconds: team.map_or(0.0, Team::waiting_seconds),
            exchanges: self.traffic.exchanges(),
            exchange_bytes: self.traffic.mean_bytes(),
        })
    }

    /// Largest number of bytes that the buffers of this process's devices have held, the sum over the devices.
    pub fn peak_device_bytes(&self) -> u64 {
        self.all().map(|renderer| renderer.context.peak_allocated_bytes()).sum()
    }

    /// Adds `batch` samples to every pixel, on all devices of all ranks at the same time. Where `stop` answers true on the first rank
    /// or a device fails, all devices end after their dispatches under way. Returns whether all samples were taken.
    pub(super) fn trace_batch(
        &mut self,
        batch: u32,
        first_of_sets: u32,
        counts: &mut Counts,
        stop: &dyn Fn() -> bool,
    ) -> Result<bool> {
        let Some(team) = self.team.clone() else { return self.trace_on_devices(batch, first_of_sets, counts, stop) };
        let mut own = Counts::default();
        let traced = self.trace_on_devices(batch, first_of_sets, &mut own, &|| team.is_to_stop(stop));
        team.end_batch(traced, &own, counts, stop)
    }
}

fn too_late() -> Error {
    Error::Render("devices share a film before its first sample, but it has samples already".into())
}
