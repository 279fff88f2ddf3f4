//! A renderer that takes the place of another one whose scene has changed. The device, the kernels that both need, the geometry where it is
//! the same, and what the guide has learned stay.

use std::sync::Arc;

use glam::Vec3;

use super::Renderer;
use crate::Result;
use crate::encode::bvh::Bvh;
use crate::encode::cells::Cells;
use crate::encode::surfaces::Surfaces;
use crate::generated::kernels::{BackEnd, Registry};
use crate::renderer::guide_cells::CellLimit;
use crate::renderer::guide_state::{GuideState, check_learns_radiance, difference};
use crate::renderer::sets::bvh::BvhSet;
use crate::renderer::setup::World;
use crate::scene::Scene;
use crate::settings::Settings;

/// A scene as all devices of a fleet change to it.
pub(crate) struct AnotherScene<'a> {
    pub scene: &'a Scene,
    pub bvh: &'a Bvh,
    /// Whether the geometry is that of the scene before.
    pub keeps_geometry: bool,
    /// Settings of the render, but for the seed where a guide stays.
    pub settings: Settings,
    pub registry: &'a Registry,
}

impl Renderer {
    /// The guide that a renderer with these settings can begin with, and the seed from which the guide has not learned. `None` where
    /// nothing was learned, or the other renderer learns otherwise.
    ///
    /// # Errors
    /// Where the guide has learned from samples of all seeds, or the device is lost.
    pub(crate) fn guide_that_stays(&self, settings: &Settings) -> Result<Option<(GuideState, u32)>> {
        let learns = check_learns_radiance(&self.settings).is_ok() && difference(&self.settings, settings).is_none();
        if !learns || self.samples_of_guide().first().is_none() {
            return Ok(None);
        }
        Ok(Some((self.guide_state()?, self.next_seed()?)))
    }

    /// Renderer of another scene on this device, without samples and without a guide.
    ///
    /// # Errors
    /// Where [`Renderer::with_work`] fails.
    pub(crate) fn of_another_scene(
        &self,
        another: &AnotherScene<'_>,
        surfaces: Surfaces,
        settings: &Settings,
    ) -> Result<Self> {
        let AnotherScene { scene, bvh, registry, .. } = *another;
        let before = another.keeps_geometry.then_some(self);
        let world = World { scene, surfaces, bvh, before };
        Self::of_world(&self.context, world, settings, registry, self.needs.work())
    }

    /// Cells of this geometry for a renderer with these settings, if they are those of this one.
    pub(super) fn cells_for(&self, settings: &Settings, media: &[(Vec3, Vec3)], light_groups: u32) -> Option<Cells> {
        let is_same_guide = difference(&self.settings, settings).is_none();
        let is_same_limit = CellLimit::of(settings) == self.cells_are_for && light_groups == self.light_groups();
        (is_same_guide && is_same_limit && self.cells.media == media).then(|| self.cells.clone())
    }

    /// The hierarchy on the device, for a renderer that reads it in the same way and sees it from `eye`.
    pub(super) fn hierarchy_for(&self, back_end: BackEnd, eye: Vec3) -> Option<Arc<BvhSet>> {
        (back_end == self.back_end && self.sets.bvh.is_seen_from(eye)).then(|| Arc::clone(&self.sets.bvh))
    }
}
