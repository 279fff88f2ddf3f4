//! Addition of the sums of all devices.

use crate::Result;
use crate::fleet::Fleet;
use crate::fleet::sums::Sums;
use crate::renderer::Renderer;

impl Fleet {
    /// Hands every device of every rank the sums of all, and the marks of all normalizers that a device has asked for.
    pub(super) fn add_up_sums(&self) -> Result<()> {
        let total = self.total_sums()?;
        self.exchange_clock.time(|| {
            let sums = total.of_device();
            self.all().try_for_each(|device| {
                device.set_target_sums(&sums)?;
                device.set_marks(&total.marks)
            })
        })
    }

    /// Moves the sums of all devices to the first one of the first rank.
    pub(super) fn gather_sums(&self) -> Result<()> {
        let total = self.total_sums()?;
        self.all().try_for_each(Renderer::clear_target_sums)?;
        if self.leads() { self.first.set_target_sums(&total.of_device()) } else { Ok(()) }
    }

    /// Sums of all devices of all ranks.
    fn total_sums(&self) -> Result<Sums> {
        let own = self.exchange_clock.time(|| self.sums_of_devices());
        let Some(team) = &self.team else {
            own.iter().for_each(|own| self.traffic.note(own.len_bytes()));
            return own;
        };
        team.add(own, &self.exchange_clock, &self.traffic)
    }

    /// Sums of the devices of this process.
    fn sums_of_devices(&self) -> Result<Sums> {
        let sums_of = |device: &Renderer| device.target_sums().map(|(sums, marks)| Sums::new(&sums, marks));
        let mut total = sums_of(&self.first)?;
        for other in &self.others {
            (self.add_sums)(&mut total, &sums_of(other).map_err(|error| other.named(error))?);
        }
        Ok(total)
    }
}
