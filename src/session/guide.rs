//! The guide of a session between two steps: its cells and what they have learned.

use crate::Result;
use crate::encode::cells::Cells;
use crate::session::run::Session;
use crate::settings::Sampler;

impl Session {
    /// Cells of the guide.
    ///
    /// # Errors
    /// The reason, in one sentence, why there are none.
    #[doc(hidden)]
    pub fn cells(&self) -> Result<&Cells, &'static str> {
        match self.settings.sampler {
            Sampler::Bsdf => Err("The sampler bsdf learns nothing."),
            Sampler::Quadtree => Err("The sampler quadtree learns flux, not radiance, so there is no map of it."),
            _ => Ok(self.fleet.first().cells()),
        }
    }

    /// Learned radiance by cell and direction bin, as the next step samples it.
    ///
    /// # Errors
    /// Where the device is lost.
    #[doc(hidden)]
    pub fn learned_radiance(&self) -> Result<Vec<f32>> {
        self.fleet.first().radiance()
    }

    /// Shares of the samples that each cell leaves to BSDFs. Empty where shares are fixed.
    ///
    /// # Errors
    /// Where the device is lost.
    #[doc(hidden)]
    pub fn bsdf_shares(&self) -> Result<Vec<[f32; 2]>> {
        self.fleet.first().bsdf_shares()
    }
}
