//! Makes a renderer ready: uploads the scene and builds the pipelines, both at the same time.

use std::sync::Arc;

use super::Renderer;
use crate::Result;
use crate::encode::bvh::Bvh;
use crate::encode::cells::Cells;
use crate::encode::lights::Lights;
use crate::encode::media;
use crate::encode::surfaces::{Shading, Surfaces};
use crate::film::View;
use crate::film::ranges::SampleRanges;
use crate::generated::kernels::{BackEnd, Registry};
use crate::gpu::Context;
use crate::renderer::film_store::FilmStore;
use crate::renderer::guide_cells::{CellLimit, cells_of};
use crate::renderer::learn::Learning;
use crate::renderer::memory_needs::PictureWork;
use crate::renderer::sets::bvh::BvhSet;
use crate::renderer::sets::normalization_grid::NormalizationGrid;
use crate::renderer::sets::radiance_grid::RadianceGrid;
use crate::renderer::sets::{Sets, Shown};
use crate::renderer::trace::execution::{self, Plan};
use crate::renderer::trace::tracer::Tracer;
use crate::renderer::trace::wave_memory::wave_buffer;
use crate::renderer::variants;
use crate::scene::Scene;
use crate::settings::{Settings, Traversal};

/// A scene as a renderer is made of it.
pub(super) struct World<'a> {
    pub scene: &'a Scene,
    pub surfaces: Surfaces,
    pub bvh: &'a Bvh,
    /// Renderer of the same geometry on the same device. What it has of the geometry serves this one, too.
    pub before: Option<&'a Renderer>,
}

impl Renderer {
    /// Uploads the scene, builds the pipelines, and runs each once on nothing: some drivers compile at the first dispatch.
    ///
    /// # Errors
    /// Where a setting is out of range or the device cannot hold the scene.
    pub fn new(context: &Arc<Context>, scene: &Scene, bvh: &Bvh, settings: &Settings) -> Result<Self> {
        Self::with_surfaces(context, scene, Surfaces::new(scene), bvh, settings, &Registry::built_in())
    }

    /// Does the work of [`Renderer::new`] with surfaces that are ready already and kernels of the caller's. These have the
    /// interface of the built-in ones.
    ///
    /// # Errors
    /// Where a setting is out of range or the device cannot hold the scene.
    pub fn with_surfaces(
        context: &Arc<Context>,
        scene: &Scene,
        surfaces: Surfaces,
        bvh: &Bvh,
        settings: &Settings,
        registry: &Registry,
    ) -> Result<Self> {
        Self::with_work(context, scene, surfaces, bvh, settings, registry, PictureWork::default())
    }

    /// Does the work of [`Renderer::with_surfaces`] where memory must also suffice for `work` on the picture.
    ///
    /// # Errors
    /// Where a setting is out of range or the device cannot hold the scene.
    pub fn with_work(
        context: &Arc<Context>,
        scene: &Scene,
        surfaces: Surfaces,
        bvh: &Bvh,
        settings: &Settings,
        registry: &Registry,
        work: PictureWork,
    ) -> Result<Self> {
        Self::of_world(context, World { scene, surfaces, bvh, before: None }, settings, registry, work)
    }

    /// Does the work of [`Renderer::with_work`], but for what the renderer before has on the device already.
    pub(super) fn of_world(
        context: &Arc<Context>,
        world: World<'_>,
        settings: &Settings,
        registry: &Registry,
        work: PictureWork,
    ) -> Result<Self> {
        let World { scene, surfaces, bvh, before } = world;
        settings.validate()?;
        settings.check_lighting(scene)?;
        let shading = Shading { surfaces, lights: Lights::new(scene, bvh, settings.learns_lights()) };
        let (media, light_groups) = (media::boxes(scene), shading.lights.group_count());
        let known = before.and_then(|before| before.cells_for(settings, &media, light_groups));
        let cells = known.unwrap_or_else(|| cells_of(settings, bvh, &media, light_groups));
        let plan = execution::resolve(context.device(), settings, &shading, bvh, &cells, work)?;
        let back_end = back_end_for(context, &shading, bvh, &cells, &plan.settings);
        let uploaded = before.and_then(|before| before.hierarchy_for(back_end, scene.camera.eye()));
        let shown = Shown { scene, shading: &shading, bvh, cells, uploaded };
        Self::build(context, shown, back_end, &plan, registry).map_err(|error| plan.needs.explain(error))
    }

    fn build(
        context: &Arc<Context>,
        shown: Shown<'_>,
        back_end: BackEnd,
        plan: &Plan,
        registry: &Registry,
    ) -> Result<Self> {
        let settings = &plan.settings;
        let Shown { scene, shading, bvh, .. } = &shown;
        let variant = variants::variant(settings, scene, shading, bvh);
        let kernels = registry.kernels(back_end);
        let build = || -> Result<_> {
            let learning = Learning::new(context, kernels, &variant, settings)?;
            let film_store = FilmStore::new(context, kernels, &variant, settings)?;
            Ok((Tracer::new(context, kernels, &variant, settings)?, learning, film_store))
        };
        let upload = || Sets::new(context, kernels, &shown, settings, wave_buffer(context, settings)?);
        // Drivers compile on one core, and the other has time to copy.
        let (built, uploaded) = rayon::join(build, upload);
        let ((tracer, slicer), learning, film_store) = built?;
        let mut renderer = Self {
            context: Arc::clone(context),
            settings: settings.clone(),
            tracer,
            slicer,
            learning,
            film_store,
            sets: uploaded?,
            back_end,
            kernels: kernels.clone(),
            variant,
            needs: plan.needs.clone(),
            has_background: scene.environment.is_some() && !settings.hide_emitters,
            camera: scene.camera,
            view: View::new(&scene.camera, settings.width, settings.height),
            cells: shown.cells,
            cells_are_for: CellLimit::of(settings),
            guide_samples: SampleRanges::default(),
            samples_done: 0,
            stopped: false,
            at_step_end: true,
        };
        renderer.warm_up()?;
        Ok(renderer)
    }
}

/// Ray queries where the settings ask for them; else texel buffers where the device allows the sizes that geometry and tables need;
/// else storage buffers.
pub(super) fn back_end_for(
    context: &Context,
    shading: &Shading,
    bvh: &Bvh,
    cells: &Cells,
    settings: &Settings,
) -> BackEnd {
    if settings.traversal == Traversal::Query {
        return BackEnd::Query;
    }
    let grids = RadianceGrid::texels(settings, cells, shading.lights.group_count())
        .max(NormalizationGrid::texels(settings, cells));
    let texels = BvhSet::texels(bvh).max(grids).max(shading.texels());
    match texels <= context.device().limits.max_texel_elements && !settings.storage_reads {
        true => BackEnd::Texel,
        false => BackEnd::Storage,
    }
}
