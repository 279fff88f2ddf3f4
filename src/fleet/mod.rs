//! Several devices that render one picture, in one process or in several.
//!
//! Each device has a [`Renderer`] with the whole scene and its own copy of the guide, and traces its share of the film's tiles. After
//! tracing, the sums of all devices are added up and handed to every device, which then learns from them as if it had traced the
//! whole film. So any number of devices of one kind gives the bits of one device. A fleet of one device does what its renderer does.
//!
//! | part | file |
//! |---|---|
//! | one step | `step.rs` |
//! | work of the devices of one process at the same time | `devices.rs` |
//! | what devices exchange: sums of learning targets, the film, states | `sums.rs`, `addition.rs`, `film.rs`, `state.rs` |
//! | another scene | `another_scene.rs` |
//! | tiles by measured speed, and times of sharing a film | `speed.rs`, `times.rs` |
//! | ranks, which are processes: who leads, and how they agree | `team.rs`, `command.rs`, `serve.rs`, `failure.rs` |
//! | the connection of ranks: in memory, or MPI | `exchange.rs`, `in_memory.rs`, `mpi.rs`, `trial.rs` |

mod addition;
mod another_scene;
mod command;
mod devices;
pub mod exchange;
mod failure;
mod film;
pub mod in_memory;
#[cfg(feature = "mpi")]
pub mod mpi;
mod serve;
mod speed;
mod state;
mod step;
pub mod sums;
pub mod team;
mod times;
pub mod trial;

use std::sync::Arc;

pub use times::SharingTimes;

use crate::fleet::sums::AddSums;
use crate::fleet::team::Team;
use crate::fleet::times::{Clock, Traffic};
use crate::renderer::Renderer;
use crate::renderer::share::Share;
use crate::{Error, Result};

/// Renders one scene on all devices of a process, together with other processes where there are some.
pub struct Fleet {
    first: Renderer,
    /// Renderers of the same scene and settings on other devices.
    others: Vec<Renderer>,
    /// Share of each device of all ranks in the film's tiles.
    dealt: Vec<Share>,
    /// The ranks of the render, where it has several.
    team: Option<Arc<Team>>,
    /// Adds up the sums of this process's devices.
    add_sums: AddSums,
    /// Time of adding up sums over devices.
    exchange_clock: Clock,
    /// Time of gathering the film from devices.
    gather_clock: Clock,
    /// Exchanges of sums.
    traffic: Traffic,
}

impl From<Renderer> for Fleet {
    /// A fleet of one device.
    fn from(first: Renderer) -> Self {
        Self {
            first,
            others: Vec::new(),
            dealt: vec![Share::ALL],
            team: None,
            add_sums: sums::add,
            exchange_clock: Clock::default(),
            gather_clock: Clock::default(),
            traffic: Traffic::default(),
        }
    }
}

impl Fleet {
    /// A fleet of renderers of the same scene and settings, each on a device of its own.
    ///
    /// # Errors
    /// Where samples were taken already, or a device is lost.
    pub fn new(first: Renderer, others: Vec<Renderer>) -> Result<Self> {
        Self::with_sums(first, others, sums::add)
    }

    /// A fleet as [`Fleet::new`] makes it. `add_sums` adds another device's sums to the total. Tests give a wrong one.
    ///
    /// # Errors
    /// Where samples were taken already, or a device is lost.
    pub fn with_sums(first: Renderer, others: Vec<Renderer>, add_sums: AddSums) -> Result<Self> {
        let mut fleet = Self { others, add_sums, ..Self::from(first) };
        if fleet.is_alone() {
            return Ok(fleet);
        }
        fleet.deal(&vec![1; fleet.device_count()])?;
        Ok(fleet)
    }

    /// Shares the film with the other ranks of a team. On other ranks than the first one, only [`Fleet::serve`] may follow.
    ///
    /// # Errors
    /// Where samples were taken already, or a device is lost.
    pub fn join(&mut self, team: &Arc<Team>) -> Result<()> {
        self.team = Some(Arc::clone(team));
        self.deal(&vec![1; team.device_count()])
    }

    /// Deals out the tiles of the film to the devices of all ranks, in proportion to their weights. All ranks do it, with the same weights,
    /// before the first sample.
    ///
    /// # Errors
    /// Where samples were taken already, or a device is lost.
    pub fn deal(&mut self, weights: &[u32]) -> Result<()> {
        self.check_unsampled()?;
        self.dealt = Share::by_weights(weights);
        self.all().zip(self.shares()).try_for_each(|(device, &share)| device.deal(share))
    }

    /// The first device. It has the guide, the numbers and the state of the whole render, and its own share of the film.
    pub fn first(&self) -> &Renderer {
        &self.first
    }

    /// Number of devices of this process.
    pub fn device_count(&self) -> usize {
        1 + self.others.len()
    }

    /// Whether this is the first rank, or the only one.
    pub fn leads(&self) -> bool {
        self.team.as_ref().is_none_or(|team| team.leads())
    }

    /// Times of the work that devices do only because they share a film. `None` where one device renders alone.
    pub fn sharing_times(&self) -> Option<SharingTimes> {
        let team = self.team.as_deref();
        (!self.is_alone()).then(|| SharingTimes {
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
        self.all().map(Renderer::peak_bytes).sum()
    }

    /// Whether one device renders alone, so that there is nobody to exchange anything with.
    fn is_alone(&self) -> bool {
        self.others.is_empty() && self.team.is_none()
    }

    /// The devices of this process.
    fn all(&self) -> impl Iterator<Item = &Renderer> {
        std::iter::once(&self.first).chain(&self.others)
    }

    fn all_mut(&mut self) -> impl Iterator<Item = &mut Renderer> {
        std::iter::once(&mut self.first).chain(&mut self.others)
    }

    /// Shares of the devices of this process.
    fn shares(&self) -> &[Share] {
        match &self.team {
            Some(team) => &self.dealt[team.own_devices()],
            None => &self.dealt,
        }
    }

    /// Refuses devices that have samples already.
    fn check_unsampled(&self) -> Result<()> {
        match self.all().all(|device| device.samples_done() == 0) {
            true => Ok(()),
            false => {
                Err(Error::Render("devices share a film before its first sample, but it has samples already".into()))
            }
        }
    }
}
