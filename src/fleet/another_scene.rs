//! Another scene for all devices of a fleet.

use crate::encode::surfaces::Surfaces;
use crate::fleet::Fleet;
use crate::renderer::Renderer;
use crate::renderer::another_scene::AnotherScene;
use crate::renderer::guide_state::GuideState;
use crate::settings::Settings;
use crate::{Error, Result};

impl Fleet {
    /// Renders another scene from now on, with the guide that has been learned so far. Returns this guide, if there is one. The devices
    /// keep their shares of the film.
    ///
    /// # Errors
    /// Where ranks share the render, a device cannot hold the scene beside the one before, or a device is lost. The fleet is then as it was.
    pub(crate) fn change_scene(
        &mut self,
        another: &AnotherScene<'_>,
        surfaces: Surfaces,
    ) -> Result<Option<GuideState>> {
        if self.team.is_some() {
            let message = "ranks that share a render cannot change its scene; begin another render";
            return Err(Error::Settings(message.into()));
        }
        let (guide, seed) = self.first.guide_that_stays(&another.settings)?.unzip();
        let settings = Settings { seed: seed.unwrap_or(another.settings.seed), ..another.settings.clone() };
        let begun = |device: &Renderer, surfaces| -> Result<Renderer> {
            let mut changed = device.of_another_scene(another, surfaces, &settings)?;
            guide.iter().try_for_each(|guide| changed.begin_with_guide_state(guide))?;
            Ok(changed)
        };
        let of_other = |other: &Renderer| begun(other, surfaces.clone()).map_err(|error| other.named(error));
        let others = self.others.iter().map(of_other).collect::<Result<Vec<_>>>()?;
        let first = begun(&self.first, surfaces)?;
        if !self.is_alone() {
            let devices = std::iter::once(&first).chain(&others);
            devices.zip(self.shares()).try_for_each(|(device, &share)| device.deal(share))?;
        }
        (self.first, self.others) = (first, others);
        Ok(guide)
    }
}
