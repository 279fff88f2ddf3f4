//! The descriptor sets, one file each, of the same name as the GLSL file that declares the set's bindings.

use std::sync::Arc;

use crate::Result;
use crate::encode::bvh::Bvh;
use crate::encode::cells::Cells;
use crate::encode::surfaces::Shading;
use crate::generated::kernels::Kernels;
use crate::gpu::{Buffer, Context, DescriptorSet};
use crate::renderer::film_store::pages::FilmPage;
use crate::renderer::sets::bvh::BvhSet;
use crate::renderer::sets::frame::Frame;
use crate::renderer::sets::normalization_grid::NormalizationGrid;
use crate::renderer::sets::radiance_grid::RadianceGrid;
use crate::scene::Scene;
use crate::settings::Settings;

pub(super) mod bvh;
pub(super) mod frame;
pub(super) mod normalization_grid;
pub(super) mod radiance_grid;
mod shapes;

/// All descriptor sets of a render, with the buffers that they show to kernels.
pub(crate) struct Sets {
    pub frame: Frame,
    pub bvh: Arc<BvhSet>,
    pub radiance_grid: RadianceGrid,
    pub normalization_grid: NormalizationGrid,
}

/// What the sets show of a scene.
pub(crate) struct Shown<'a> {
    pub scene: &'a Scene,
    pub shading: &'a Shading,
    pub bvh: &'a Bvh,
    pub cells: Cells,
    /// The hierarchy, where the device has it already.
    pub uploaded: Option<Arc<BvhSet>>,
}

impl Sets {
    /// Uploads the scene and allocates film and grids. Kernels find `scratch` in place of the scratch memory of the film's pages, if it is
    /// given.
    pub fn new(
        context: &Arc<Context>,
        kernels: &Kernels,
        shown: &Shown<'_>,
        settings: &Settings,
        scratch: Option<Arc<Buffer>>,
    ) -> Result<Self> {
        let Shown { scene, shading, bvh, cells, uploaded } = shown;
        let bvh_set = match uploaded {
            Some(uploaded) => Arc::clone(uploaded),
            None => BvhSet::new(context, kernels, bvh, scene.camera.eye())?.into(),
        };
        Ok(Self {
            frame: Frame::new(context, kernels, scene, shading, bvh, cells, settings, scratch)?,
            bvh: bvh_set,
            radiance_grid: RadianceGrid::new(context, kernels, settings, cells, &shading.lights)?,
            normalization_grid: NormalizationGrid::new(context, kernels, settings, cells)?,
        })
    }

    /// The sets of a kernel that works on a film page, in the order of their numbers. An empty page gets its zeros.
    pub fn of_page<'a>(&'a self, page: &'a FilmPage) -> Result<[&'a DescriptorSet; 4]> {
        page.write_zeros()?;
        Ok(self.beside(page))
    }

    /// The sets of a kernel that does not touch the film.
    pub fn without_film(&self) -> [&DescriptorSet; 4] {
        self.beside(self.frame.first_page())
    }

    fn beside<'a>(&'a self, page: &'a FilmPage) -> [&'a DescriptorSet; 4] {
        [page.set(), self.bvh.set(), self.radiance_grid.set(), self.normalization_grid.set()]
    }
}
