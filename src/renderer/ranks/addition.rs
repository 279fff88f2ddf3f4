//! Addition of the sums of all devices.

use crate::Result;
use crate::generated::layout::RadianceSum;
use crate::renderer::Renderer;
use crate::renderer::ranks::sums::Sums;

impl Renderer {
    /// Hands every device of every rank the sums of all, and the marks of all normalizers that a device has asked for.
    pub(in crate::renderer) fn add_up_sums(&self) -> Result<()> {
        if self.others.is_empty() && self.team.is_none() {
            return Ok(());
        }
        let total = self.total_sums()?;
        self.exchange_clock.time(|| {
            let sums = total.of_device();
            self.all().try_for_each(|renderer| {
                renderer.sets.radiance_grid.target_sums().upload(0, &sums)?;
                renderer.sets.normalization_grid.marks().upload(0, &total.marks)
            })
        })
    }

    /// Moves the sums of all devices to the first one of the first rank.
    pub(in crate::renderer) fn gather_sums(&self) -> Result<()> {
        if self.others.is_empty() && self.team.is_none() {
            return Ok(());
        }
        let total = self.total_sums()?;
        self.all().try_for_each(|renderer| renderer.sets.radiance_grid.clear_sums(&renderer.context))?;
        match self.leads() {
            true => self.sets.radiance_grid.target_sums().upload(0, &total.of_device()),
            false => Ok(()),
        }
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
        let mut total = self.own_sums()?;
        for other in &self.others {
            (self.add_sums)(&mut total, &other.own_sums().map_err(|error| other.named(error))?);
        }
        Ok(total)
    }

    fn own_sums(&self) -> Result<Sums> {
        let sums = self.sets.radiance_grid.target_sums();
        let marks = self.sets.normalization_grid.marks();
        let sums: Vec<RadianceSum> = sums.read(0, sums.len_bytes() as usize / size_of::<RadianceSum>())?;
        Ok(Sums::new(&sums, marks.read(0, marks.len_bytes() as usize / size_of::<u32>())?))
    }
}
