//! Several devices that render one picture.
//!
//! Each device holds the whole scene and its own copy of the guide, and traces its share of the film's tiles. After tracing,
//! the sums of all devices are added up and handed to every device, which then learns from them as if it had traced the whole
//! film. So any number of devices of one kind gives the bits of one device.
//!
//! Devices never wait for each other: the first one starts the work of the others as threads and joins them. A device that fails
//! ends its thread, so nobody hangs.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use super::Renderer;
use crate::generated::constants::TILE_PIXELS;
use crate::generated::layout::RadianceSum;
use crate::renderer::film_store::pages::padded_pixels;
use crate::renderer::ranks::share::Share;
use crate::renderer::ranks::sums::AddSums;
use crate::renderer::ranks::times::SharingTimes;
use crate::renderer::statistics::Counts;
use crate::{Error, Result};

pub(super) mod share;
pub mod sums;
pub(super) mod times;

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
            let message = "devices share a film before its first sample, but it has samples already";
            return Err(Error::Render(message.into()));
        }
        (self.others, self.add_sums) = (others, add_sums);
        let ranks = 1 + self.others.len() as u32;
        for (rank, renderer) in (0..).zip(self.all()) {
            renderer.sets.frame.pages().iter().try_for_each(|page| page.deal(Share { rank, ranks }))?;
        }
        Ok(())
    }

    /// Number of devices that share the film.
    pub fn device_count(&self) -> usize {
        1 + self.others.len()
    }

    /// Times of the work that devices do only because they share a film. `None` where one device renders alone.
    pub fn sharing_times(&self) -> Option<SharingTimes> {
        (!self.others.is_empty()).then(|| SharingTimes {
            devices: self.device_count(),
            exchange_seconds: self.exchange_clock.seconds(),
            gather_seconds: self.gather_clock.seconds(),
        })
    }

    fn all(&self) -> impl Iterator<Item = &Self> {
        std::iter::once(self).chain(&self.others)
    }

    /// Adds `batch` samples to every pixel, on all devices at the same time. Where `stop` answers true or a device fails, all
    /// devices end after their dispatches under way. Returns whether all samples were taken.
    pub(super) fn trace_batch(
        &mut self,
        batch: u32,
        first_of_sets: u32,
        counts: &mut Counts,
        stop: &dyn Fn() -> bool,
    ) -> Result<bool> {
        if self.others.is_empty() {
            return self.trace_share(batch, first_of_sets, counts, stop);
        }
        let samples_done = self.samples_done;
        let mut others = std::mem::take(&mut self.others);
        let is_ended = AtomicBool::new(false);
        let ends = |traced: &Result<bool>| {
            if !matches!(traced, Ok(true)) {
                is_ended.store(true, Ordering::Relaxed);
            }
        };
        let start = |other: &mut Self| {
            let mut counts = Counts::default();
            other.samples_done = samples_done;
            let is_ended = || is_ended.load(Ordering::Relaxed);
            let traced = other.trace_share(batch, first_of_sets, &mut counts, &is_ended);
            ends(&traced);
            (traced.map_err(|error| other.named(error)), counts)
        };
        let (own, joined) = thread::scope(|scope| {
            let start = &start;
            let threads: Vec<_> = others.iter_mut().map(|other| scope.spawn(move || start(other))).collect();
            let own = self.trace_share(batch, first_of_sets, counts, &|| is_ended.load(Ordering::Relaxed) || stop());
            ends(&own);
            let joined = threads.into_iter().map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)));
            (own, joined.collect::<Vec<_>>())
        });
        self.others = others;
        let mut is_complete = own?;
        for (traced, of_device) in joined {
            is_complete &= traced?;
            counts.add(&of_device);
        }
        for other in &mut self.others {
            other.samples_done = samples_done + batch;
        }
        Ok(is_complete)
    }

    /// Does something on all devices at the same time.
    pub(super) fn on_every_device(&mut self, act: &(dyn Fn(&Self) -> Result<()> + Sync)) -> Result<()> {
        let mut others = std::mem::take(&mut self.others);
        let start = |other: &mut Self| act(other).map_err(|error| other.named(error));
        let done: Vec<Result<()>> = thread::scope(|scope| {
            let start = &start;
            let threads: Vec<_> = others.iter_mut().map(|other| scope.spawn(move || start(other))).collect();
            let own = act(self);
            let joined = threads.into_iter().map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)));
            let joined: Vec<_> = joined.collect();
            std::iter::once(own).chain(joined).collect()
        });
        self.others = others;
        done.into_iter().collect()
    }

    /// Hands every device the sums of all, and the marks of all normalizers that a device has asked for.
    pub(super) fn add_up_sums(&self) -> Result<()> {
        if self.others.is_empty() {
            return Ok(());
        }
        self.exchange_clock.time(|| {
            let total = self.total_sums()?;
            let marks = self.all_marks()?;
            self.all().try_for_each(|renderer| {
                renderer.sets.radiance_grid.target_sums().upload(0, &total)?;
                renderer.sets.normalization_grid.marks().upload(0, &marks)
            })
        })
    }

    /// Moves the sums of all devices to the first one.
    pub(super) fn gather_sums(&self) -> Result<()> {
        if self.others.is_empty() {
            return Ok(());
        }
        let total = self.total_sums()?;
        self.sets.radiance_grid.target_sums().upload(0, &total)?;
        self.others.iter().try_for_each(|other| other.sets.radiance_grid.clear_sums(&other.context))
    }

    fn total_sums(&self) -> Result<Vec<RadianceSum>> {
        let read = |renderer: &Self| {
            let sums = renderer.sets.radiance_grid.target_sums();
            sums.read::<RadianceSum>(0, sums.len_bytes() as usize / size_of::<RadianceSum>())
        };
        let mut total = read(self)?;
        for other in &self.others {
            (self.add_sums)(&mut total, &read(other).map_err(|error| other.named(error))?);
        }
        Ok(total)
    }

    fn all_marks(&self) -> Result<Vec<u32>> {
        let read = |renderer: &Self| {
            let marks = renderer.sets.normalization_grid.marks();
            marks.read::<u32>(0, marks.len_bytes() as usize / size_of::<u32>())
        };
        let mut all = read(self)?;
        for other in &self.others {
            let marks = read(other).map_err(|error| other.named(error))?;
            all.iter_mut().zip(marks).for_each(|(all, marks)| *all |= marks);
        }
        Ok(all)
    }

    /// Copies the tiles of the other devices into the film of the first one.
    pub(super) fn gather_film(&self) -> Result<()> {
        if self.others.is_empty() {
            return Ok(());
        }
        self.gather_clock.time(|| self.copy_tiles())
    }

    fn copy_tiles(&self) -> Result<()> {
        let tiles = (padded_pixels(&self.settings) / u64::from(TILE_PIXELS)) as usize;
        for (number, part) in self.sets.frame.persistent().iter().enumerate() {
            let mut film = part.read()?;
            let tile_bytes = film.len() / tiles;
            for (rank, other) in (1..).zip(&self.others) {
                let theirs = other.sets.frame.persistent()[number].read().map_err(|error| other.named(error))?;
                for tile in (rank..tiles).step_by(self.device_count()) {
                    let bytes = tile * tile_bytes..(tile + 1) * tile_bytes;
                    film[bytes.clone()].copy_from_slice(&theirs[bytes]);
                }
            }
            part.write(&film)?;
        }
        Ok(())
    }

    /// An error that names this device.
    fn named(&self, error: Error) -> Error {
        let device = self.context.device();
        error.during(&format!("device {} ({})", device.index, device.name))
    }
}
