//! Another view for a renderer: its kernels, its scene and its guide stay, and the film begins anew.

use super::Renderer;
use crate::film::View;
use crate::film::ranges::SampleRanges;
use crate::generated::kernels::{CAMERA_THINLENS, Variant};
use crate::renderer::film_store::part_sums::clear_film;
use crate::renderer::learn::Learning;
use crate::renderer::persistent::Persistent;
use crate::renderer::trace::tracer::Tracer;
use crate::renderer::variants;
use crate::scene::{Camera, Projection};
use crate::settings::{Sampler, Settings};
use crate::{Error, Result};

/// A view as all devices of a fleet change to it: a camera, the size of its film, and the seed of its samples.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AnotherView {
    pub camera: Camera,
    pub size: [u32; 2],
    pub seed: u32,
    /// Whether a step was stopped before the guide has learned from it.
    pub has_unlearned_sums: bool,
}

impl Renderer {
    /// Camera of the picture.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Shows the scene from now on by `camera`, which stands still, on a film of `width` x `height` pixels. The film begins anew. The
    /// guide keeps its cells and what it has learned, except that of [`Sampler::Quadtree`], which begins anew: its iterations count
    /// from the first sample. The medium around the camera stays that of the scene's camera.
    ///
    /// The seed becomes the next one from which the guide has not learned, so that a guide never has learned from the samples that it
    /// guides. From here on a renderer of that seed that begins with this guide does the same to the last bit.
    ///
    /// # Errors
    /// Where the camera or the size is out of range, the device cannot hold the film, or the device is lost.
    pub fn change_view(&mut self, camera: &Camera, [width, height]: [u32; 2]) -> Result<()> {
        self.change_view_to(&self.another_view(camera, [width, height])?)
    }

    /// The view that follows this one.
    pub(crate) fn another_view(&self, camera: &Camera, size: [u32; 2]) -> Result<AnotherView> {
        let (seed, has_unlearned_sums) = (self.next_seed()?, self.stopped);
        Ok(AnotherView { camera: *camera, size, seed, has_unlearned_sums })
    }

    /// Seed of the picture after a change: this one if the guide has not learned from samples of it that may be taken, or the next such
    /// one.
    pub(super) fn next_seed(&self) -> Result<u32> {
        let Settings { seed, sample_offset, .. } = self.settings;
        let learned = self.samples_of_guide();
        let is_free = |seed: &u32| learned.end(*seed).is_none_or(|end| end <= u64::from(sample_offset.unwrap_or(0)));
        (seed..=u32::MAX).find(is_free).ok_or_else(|| {
            let message =
                "the guide has learned from samples of all seeds up to 4294967295; begin with a smaller --seed";
            Error::Settings(message.into())
        })
    }

    /// Does the work of [`Renderer::change_view`] with a seed that is known.
    pub(crate) fn change_view_to(&mut self, view: &AnotherView) -> Result<()> {
        let AnotherView { camera, size: [width, height], seed, has_unlearned_sums } = *view;
        camera.check()?;
        let old = [self.settings.width, self.settings.height];
        let crop = self.settings.crop.map(|crop| crop.rescaled(old, [width, height]));
        let settings = Settings { width, height, crop, seed, ..self.settings.clone() };
        settings.validate()?;
        self.sets.bvh.check_eye(camera.eye())?;
        let needs = self.needs.with_film(&settings);
        if width > old[0] || height > old[1] {
            needs.check_film(self.context.device(), [width, height])?;
        }
        self.check_kernels(&camera)?;

        let samples = self.samples_of_guide();
        // An error on the way leaves the renderer stopped.
        self.stopped = true;
        match [width, height] == old {
            true => self.clear_film()?,
            false => self.sets.frame.resize(&self.context, &settings)?,
        }
        self.sets.frame.look_through(&camera, &settings)?;
        self.film_store.begin_anew(&settings);
        (self.settings, self.needs, self.camera) = (settings, needs, camera);
        self.view = View::new(&camera, width, height);
        (self.samples_done, self.at_step_end, self.guide_samples) = (0, true, samples);
        if self.settings.sampler == Sampler::Quadtree {
            self.begin_quadtrees()?;
        } else if has_unlearned_sums {
            self.sets.radiance_grid.clear_sums(&self.context)?;
        }
        self.choose_tiles()?;
        self.stopped = false;
        Ok(())
    }

    /// Samples from which the guide has learned, of this render and of earlier ones.
    pub(super) fn samples_of_guide(&self) -> SampleRanges {
        match self.settings.sampler {
            Sampler::Bsdf | Sampler::Quadtree => SampleRanges::default(),
            _ => self.guide_samples.clone().union(SampleRanges::of_render(&self.settings, self.samples_done)),
        }
    }

    /// Builds the tracing kernels anew where they do not know the kind of this camera, which stands still. Those of a thin lens know the
    /// camera without a lens, too.
    fn check_kernels(&mut self, camera: &Camera) -> Result<()> {
        let asked = variants::camera_kind(camera.projection);
        let has_lens = self.variant.camera == CAMERA_THINLENS;
        let is_known = asked == self.variant.camera || (has_lens && camera.projection == Projection::Perspective);
        if is_known && self.variant.camera_segments == 0 {
            return Ok(());
        }
        let variant = Variant { camera: asked, camera_segments: 0, ..self.variant };
        // The slicer stays: the memory of a wave is as large as the first film has asked for.
        (self.tracer, _) = Tracer::new(&self.context, &self.kernels, &variant, &self.settings)?;
        self.variant = variant;
        Ok(())
    }

    /// Fills the film with zeros.
    fn clear_film(&self) -> Result<()> {
        match self.film_store.adaptive() {
            None => clear_film(&self.context, &self.sets.frame),
            Some(_) => self.sets.frame.persistent().iter().try_for_each(Persistent::clear),
        }
    }

    /// Makes quadtrees as they are before the first sample.
    fn begin_quadtrees(&self) -> Result<()> {
        self.guide_parts().iter().try_for_each(Persistent::clear)?;
        self.sets.radiance_grid.begin_lights()?;
        match &self.learning {
            Learning::Quadtrees(refinement) => refinement.refine(&self.context, &self.sets, &self.settings, 0),
            Learning::Nothing | Learning::Grids(_) => Ok(()),
        }
    }
}
