//! The renderer: the paper's algorithm in safe code, one file per descriptor set.
//!
//! Read [`Renderer::step`], `glsl/kernels/trace/path_trace.comp` and `glsl/include/path/vertex.glsl`, and the algorithm is understood.

mod film_store;
mod learn;
mod memory_needs;
mod sets;
mod state;
mod statistics;
mod trace;
mod variants;

use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::{UVec3, Vec3};

pub use state::{RenderState, StatePart};
pub use statistics::{Counts, StepReport};
pub use variants::{variant_for, variant_of_settings};

use self::learn::quadtrees;
use crate::encode::bvh::Bvh;
use crate::encode::cells::Cells;
use crate::encode::lights::Lights;
use crate::encode::textures::PackedTextures;
use crate::encode::{materials, plastics};
use crate::film::Picture;
use crate::film::noise::{LEAST_SAMPLES, NoiseReport};
use crate::generated::kernels::{BackEnd, Kernels, Registry};
use crate::generated::layout::{MaterialRecord, PathTracePush, SampleWeights, TEXEL_BYTES, UpdatePush};
use crate::gpu::{BindingKind, Buffer, BufferKind, Context, DescriptorSet, Kernel, SetShape};
use crate::renderer::film_store::adaptive::Adaptive;
use crate::renderer::film_store::pages::FilmPage;
use crate::renderer::film_store::sums::FilmSums;
use crate::renderer::sets::bvh::Geometry;
use crate::renderer::sets::frame::Frame;
use crate::renderer::sets::normalization_grid::NormalizationGrid;
use crate::renderer::sets::radiance_grid::RadianceGrid;
use crate::renderer::trace::dispatch::Tracing;
use crate::renderer::trace::slices::{Slice, Slicer};
use crate::renderer::trace::wavefront::{check_wavefront, chosen};
use crate::scene::{Crop, Scene};
use crate::settings::{AUTO_GRID, Execution, Sampler, Settings};
use crate::{Error, Result};
use memory_needs::MemoryNeeds;

/// Bytes of a guide whose grid is chosen by the scene.
const GUIDE_BYTES: u64 = 8 << 20;

/// Renders one scene on one device, step by step.
pub struct Renderer {
    context: Arc<Context>,
    settings: Settings,
    tracing: Tracing,
    slicer: Slicer,
    updates: Updates,
    /// Where the sampler has quadtrees.
    refine_quadtrees: Option<Kernel>,
    /// Where noise ends the render.
    adaptive: Option<Adaptive>,
    cells: Cells,
    frame: Frame,
    geometry: Geometry,
    radiance_grid: RadianceGrid,
    normalization_grid: NormalizationGrid,
    back_end: BackEnd,
    /// Where the render is one part of several.
    film_sums: Option<FilmSums>,
    needs: MemoryNeeds,
    samples_done: u32,
    stopped: bool,
    at_step_end: bool,
}

/// The kernels that end a step.
struct Updates {
    radiance: Kernel,
    /// These two where cells fall back on larger ones.
    parents: Option<(Kernel, Kernel)>,
    normalization: Kernel,
}

/// What surfaces are made of, as it is uploaded: all that can be made ready before the hierarchy is.
pub struct Surfaces {
    materials: Vec<MaterialRecord>,
    textures: PackedTextures,
}

impl Surfaces {
    /// Tabulates a scene's materials and packs its textures.
    pub fn new(scene: &Scene) -> Self {
        let mut materials: Vec<_> = scene.materials.iter().map(materials::record).collect();
        let tables = plastics::complete(scene, &mut materials);
        Self { materials, textures: PackedTextures::new(&scene.textures, &scene.images, tables) }
    }
}

/// What surfaces are made of and lit by.
struct Shading {
    surfaces: Surfaces,
    lights: Lights,
}

impl Shading {
    /// Texels of the largest buffer.
    fn texels(&self) -> u64 {
        let Surfaces { materials, textures } = &self.surfaces;
        let materials = size_of_val(&materials[..]) as u64 / TEXEL_BYTES as u64;
        materials.max(textures.longest()).max(self.lights.texel_count() as u64)
    }
}

impl Renderer {
    /// Uploads the scene, builds the pipelines, and runs each once on nothing, so that a driver that compiles at the first
    /// dispatch has done so.
    ///
    /// # Errors
    /// Where a setting is out of range or the device cannot hold the scene.
    pub fn new(context: &Arc<Context>, scene: &Scene, bvh: &Bvh, settings: &Settings) -> Result<Self> {
        Self::with_surfaces(context, scene, Surfaces::new(scene), bvh, settings, &Registry::built_in())
    }

    /// [`Renderer::new`] where the scene's surfaces are ready already, with kernels of the caller's, which have the interface
    /// of the built-in ones.
    ///
    /// # Errors
    /// As there.
    pub fn with_surfaces(
        context: &Arc<Context>,
        scene: &Scene,
        surfaces: Surfaces,
        bvh: &Bvh,
        settings: &Settings,
        registry: &Registry,
    ) -> Result<Self> {
        settings.validate()?;
        settings.check_lighting(scene)?;
        let shading = Shading { surfaces, lights: Lights::new(scene, bvh) };
        let cells = cells_of(settings, bvh);
        check_wavefront(context.device(), settings)?;
        let needs_by = |execution| {
            let settings = Settings { execution, ..settings.clone() };
            (MemoryNeeds::new(context.device(), &shading, bvh, &cells, &settings), settings)
        };
        let samples_lights = settings.nee && !shading.lights.is_empty();
        let chosen = chosen(context.device(), settings, samples_lights, bvh.primitives.len());
        let (mut needs, mut resolved) = needs_by(chosen);
        if settings.execution == Execution::Auto && needs.check(context.device()).is_err() {
            (needs, resolved) = needs_by(Execution::Megakernel);
        }
        needs.check(context.device())?;
        Self::build(context, scene, &shading, bvh, cells, &resolved, registry)
            .map_err(|error| note_needs(error, &needs))
    }

    fn build(
        context: &Arc<Context>,
        scene: &Scene,
        shading: &Shading,
        bvh: &Bvh,
        cells: Cells,
        settings: &Settings,
        registry: &Registry,
    ) -> Result<Self> {
        let variant = variants::variant(settings, scene, shading, bvh, &cells);
        let back_end = back_end_for(context, shading, bvh, &cells, settings);
        let kernels = registry.kernels(back_end);
        let build = |source| Kernel::new(context, source, &variant.entries());
        let has_quadtrees = settings.sampler == Sampler::Quadtree;
        let build = || -> Result<_> {
            let pool_and_blend = || Ok((build(&kernels.pool_radiance)?, build(&kernels.blend_radiance)?));
            let updates = Updates {
                radiance: build(&kernels.update_radiance)?,
                parents: (settings.fallback > 0.0).then(pool_and_blend).transpose()?,
                normalization: build(&kernels.update_normalization)?,
            };
            let refine_quadtrees = has_quadtrees.then(|| build(&kernels.refine_quadtrees)).transpose()?;
            let judge = |target| Ok(Adaptive::new(build(&kernels.judge_noise)?, settings, target));
            let adaptive = settings.noise.map(judge).transpose()?;
            Ok((Tracing::new(context, kernels, &variant, settings)?, updates, refine_quadtrees, adaptive))
        };
        let upload = || -> Result<_> {
            let frame = Frame::new(context, kernels, scene, shading, &cells, settings)?;
            let geometry = Geometry::new(context, kernels, bvh)?;
            let radiance_grid = RadianceGrid::new(context, kernels, settings, &cells)?;
            Ok((frame, geometry, radiance_grid, NormalizationGrid::new(context, kernels, settings, &cells)?))
        };
        // Drivers compile on one core, and the other has time to copy.
        let (built, uploaded) = rayon::join(build, upload);
        let ((tracing, slicer), updates, refine_quadtrees, adaptive) = built?;
        let (frame, geometry, radiance_grid, normalization_grid) = uploaded?;
        let mut renderer = Self {
            tracing,
            slicer,
            updates,
            refine_quadtrees,
            adaptive,
            frame,
            geometry,
            radiance_grid,
            normalization_grid,
            back_end,
            context: Arc::clone(context),
            settings: settings.clone(),
            film_sums: None,
            needs: MemoryNeeds::new(context.device(), shading, bvh, &cells, settings),
            cells,
            samples_done: 0,
            stopped: false,
            at_step_end: true,
        };
        renderer.film_sums = settings.sample_offset.map(|_| FilmSums::new(&renderer.frame));
        renderer.warm_up()?;
        Ok(renderer)
    }

    /// Takes `samples` more samples per pixel, then learns from them: one step of the paper's online pipeline. The first
    /// step samples the BSDF only, for no entry of the normalization grid is filled yet.
    ///
    /// `stop` is asked between dispatches; where it answers true, the step ends early and [`StepReport::complete`] is false.
    ///
    /// # Errors
    /// Where the device is lost, a loop of a kernel was cut short and the picture would be wrong, or an earlier step was
    /// stopped: some pixels then lack its samples, so that none can follow.
    pub fn step(&mut self, samples: u32, stop: &dyn Fn() -> bool) -> Result<StepReport> {
        if self.stopped {
            return Err(Error::Render("a render cannot go on after a step that was stopped".into()));
        }
        let begin = Instant::now();
        let mut counts = Counts::default();
        let pixels = self.sampled_pixels();
        self.at_step_end &= samples == self.samples_of_next_step();
        // Also where an error ends it.
        self.stopped = true;
        let traced = self.path_trace(samples, &mut counts, stop);
        let complete = traced.map_err(|error| note_needs(error, &self.needs))?;
        if complete && self.settings.has_grids() {
            self.update_grids().map_err(|error| note_needs(error, &self.needs))?;
        }
        if let Some(sums) = self.film_sums.as_mut().filter(|_| complete) {
            sums.take(&self.context, &self.frame)?;
        }
        if complete {
            self.judge()?;
        }
        self.stopped = !complete;
        Ok(StepReport { samples, pixels, complete, seconds: begin.elapsed().as_secs_f64(), counts })
    }

    /// Samples per pixel of the next step: by the schedule ([`Settings::samples_of_step`]), and more where noise has ended most
    /// of the picture.
    pub fn samples_of_next_step(&self) -> u32 {
        let usual = self.settings.samples_of_step(self.samples_done);
        self.adaptive.as_ref().map_or(usual, |adaptive| usual * adaptive.lengthening(self.samples_done, usual))
    }

    /// Whether every step was as long as it was to be, so that a longer render has been here, too.
    pub fn is_at_step_end(&self) -> bool {
        self.at_step_end && !self.stopped
    }

    /// How noisy the picture is, where noise ends the render ([`Settings::noise`]).
    pub fn noise(&self) -> Option<NoiseReport> {
        self.adaptive.as_ref().map(Adaptive::report)
    }

    /// Pixels that are sampled: all, unless noise has ended some.
    pub fn sampled_pixels(&self) -> u64 {
        let Crop { width, height, .. } = self.settings.window();
        self.adaptive.as_ref().map_or(u64::from(width) * u64::from(height), Adaptive::sampled_pixels)
    }

    /// Where its kernels read geometry and tables from.
    pub fn back_end(&self) -> BackEnd {
        self.back_end
    }

    /// Bytes of the guide on the device.
    pub fn guide_bytes(&self) -> u64 {
        memory_needs::guide_bytes(&self.settings, &self.cells)
    }

    /// Samples per pixel that complete steps and dispatches have taken.
    pub fn samples_done(&self) -> u32 {
        self.samples_done
    }

    /// Whether the last step was stopped or has failed, so that no other can follow.
    pub fn is_stopped(&self) -> bool {
        self.stopped
    }

    /// Reads the film back.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn picture(&self) -> Result<Picture> {
        match &self.film_sums {
            Some(sums) => sums.picture(&self.frame, &self.settings),
            None => self.frame.picture(&self.settings),
        }
    }

    /// What the radiance grid holds: `[cell][direction bin]` of the cells that hold surfaces, radiance as the next step will sample it.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn radiance(&self) -> Result<Vec<f32>> {
        self.radiance_grid.read()
    }

    /// What it holds of the cell of a point, a bin after the other; nothing without a guide.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn radiance_at(&self, position: Vec3) -> Result<Vec<f32>> {
        let bins = self.settings.directions.pow(2) as usize;
        let begin = self.cells.cell_of(position) * bins;
        Ok(self.radiance()?.into_iter().skip(begin).take(bins).collect())
    }

    /// What each cell has learned that scattering functions keep of the samples: diffuse lobes, and those that are guided as a
    /// whole. Empty where shares are fixed.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn bsdf_shares(&self) -> Result<Vec<[f32; 2]>> {
        self.radiance_grid.read_shares()
    }

    /// Adds `samples` samples to every pixel, a bounded number per dispatch.
    fn path_trace(&mut self, samples: u32, counts: &mut Counts, stop: &dyn Fn() -> bool) -> Result<bool> {
        let first_of_step = self.next_sample();
        let mut left = samples;
        while left > 0 {
            let most = self.samples_of_iteration().min(self.settings.samples_of_same_weight(self.samples_done));
            let batch = left.min(self.settings.samples_per_dispatch).min(most);
            let first_of_sets = self.first_of_sets(first_of_step);
            for page in self.frame.pages() {
                let mut next = 0;
                while let Some(slice) = self.slicer.slice(page, next) {
                    if stop() {
                        return Ok(false);
                    }
                    let (elapsed, slice_counts) = self.trace(page, slice, batch, first_of_sets)?;
                    self.slicer.measured(slice, elapsed);
                    counts.add(&slice_counts);
                    next = slice.end();
                }
            }
            self.samples_done += batch;
            left -= batch;
            if let Some((kernel, iteration)) =
                self.refine_quadtrees.as_ref().zip(quadtrees::ended_iteration(self.samples_done))
            {
                self.refine(kernel, iteration)?;
            }
        }
        Ok(true)
    }

    /// Index of the next sample of every pixel.
    fn next_sample(&self) -> u32 {
        self.sample_index(self.samples_done)
    }

    fn sample_index(&self, samples_before: u32) -> u32 {
        self.settings.sample_offset.unwrap_or(0).wrapping_add(samples_before)
    }

    /// Index of the first sample whose set may reach to the next ones, which belong to the step that began with
    /// `first_of_step`: the first since the guide has learned. Without a guide, samples do not depend on steps.
    fn first_of_sets(&self, first_of_step: u32) -> u32 {
        match self.settings.sampler {
            Sampler::Bsdf => 0,
            Sampler::Quadtree => self.sample_index(quadtrees::first_of_iteration(self.samples_done)),
            _ => first_of_step,
        }
    }

    /// Where noise ends the render, has the film say which tiles go on.
    fn judge(&mut self) -> Result<()> {
        match &mut self.adaptive {
            Some(adaptive) if self.samples_done < LEAST_SAMPLES => adaptive.restart(self.frame.pages()),
            _ => self.judge_film(),
        }
    }

    fn judge_film(&mut self) -> Result<()> {
        let Some(adaptive) = &mut self.adaptive else { return Ok(()) };
        let others = [self.geometry.set(), self.radiance_grid.set(), self.normalization_grid.set()];
        adaptive.judge(&self.context, &self.slicer, self.frame.pages(), others)
    }

    /// Samples that may be taken before the guide is to learn from them.
    fn samples_of_iteration(&self) -> u32 {
        self.refine_quadtrees.as_ref().map_or(u32::MAX, |_| quadtrees::samples_left(self.samples_done))
    }

    fn trace(
        &self,
        page: &FilmPage,
        slice: Slice,
        sample_count: u32,
        first_of_sets: u32,
    ) -> Result<(Duration, Counts)> {
        let push = PathTracePush {
            first_workgroup: slice.first,
            workgroup_count: slice.count,
            workgroup_stride: slice.stride,
            page_first_pixel: page.first_pixel(),
            weights: self.weights_of_next_samples(),
            first_sample: self.next_sample(),
            sample_count,
            first_of_sets,
        };
        let others = [self.geometry.set(), self.radiance_grid.set(), self.normalization_grid.set()];
        let (elapsed, counts) = self.tracing.trace(&self.context, &self.frame, page, others, push)?;
        match counts.overruns {
            0 => Ok((elapsed, counts)),
            _ => Err(self.overrun_error()),
        }
    }

    fn weights_of_next_samples(&self) -> SampleWeights {
        let before = self.settings.weight_sums(self.samples_done);
        let lost = |effective: f64| (f64::from(self.samples_done) - effective) as f32;
        SampleWeights {
            of_sample: self.settings.weight_of_sample(self.samples_done),
            lost_weight: lost(before.weight),
            lost_samples: lost(before.effective_samples()),
        }
    }

    fn overrun_error(&self) -> Error {
        Error::Render(format!(
            "the driver of {} ended a loop of a kernel before its end, so pixels would come out dark: render again with \
             --samples-per-dispatch below {} or a smaller --max-depth",
            self.context.device().name,
            self.settings.samples_per_dispatch
        ))
    }

    /// The sets of kernels that reach no film.
    fn sets(&self) -> [&DescriptorSet; 4] {
        let page = self.frame.first_page();
        [page.set(), self.geometry.set(), self.radiance_grid.set(), self.normalization_grid.set()]
    }

    /// Has quadtrees sample what they have learned, after an iteration of as many samples as all before it and one.
    fn refine(&self, kernel: &Kernel, iteration: u32) -> Result<()> {
        let sets = self.sets();
        let refine = |recorder: &mut _| quadtrees::refine(recorder, kernel, &sets, &self.settings, iteration);
        self.context.submit("refine_quadtrees", refine).map(|_| ())
    }

    /// Moves the radiance grid towards what the step recorded (Eq. 7), pools what larger cells know of it, then refills the
    /// marked normalizers.
    fn update_grids(&self) -> Result<()> {
        let Updates { radiance, parents, normalization } = &self.updates;
        let cells = 0..self.cells.count();
        let Some((pool, blend)) = parents else {
            return self.update(cells, &[radiance, normalization]);
        };
        self.update(cells.clone(), &[radiance])?;
        let levels = self.cells.parent_levels();
        levels.iter().try_for_each(|level| self.update(level.clone(), &[pool]))?;
        levels.iter().rev().try_for_each(|level| self.update(level.clone(), &[blend]))?;
        self.update(cells, &[blend, normalization])
    }

    /// Runs kernels one after the other, each with a workgroup per cell.
    fn update(&self, cells: Range<u32>, kernels: &[&Kernel]) -> Result<()> {
        let sets = self.sets();
        let names: Vec<_> = kernels.iter().map(|kernel| kernel.name()).collect();
        for range in self.slicer.ranges(cells) {
            let push = UpdatePush { first_cell: range.start };
            self.context.submit(&names.join(" and "), |recorder| {
                for kernel in kernels {
                    recorder.dispatch(kernel, &sets, bytemuck::bytes_of(&push), [range.end - range.start, 1, 1]);
                    recorder.barrier();
                }
            })?;
        }
        Ok(())
    }

    /// Runs every kernel once. The path tracer takes no sample and the grids are still empty: an update of nothing, which
    /// writes the floor that later updates start from.
    fn warm_up(&mut self) -> Result<()> {
        if let Some(slice) = self.frame.pages().first().and_then(|page| self.slicer.smallest_slice(page)) {
            self.trace(self.frame.first_page(), slice, 0, 0)?;
        }
        // An empty film would end it.
        self.judge_film()?;
        self.judge()?;
        match &self.refine_quadtrees {
            Some(kernel) => self.refine(kernel, 0),
            None if self.settings.has_grids() => self.update_grids(),
            None => Ok(()),
        }
    }
}

/// Where memory has run out, what it went to.
fn note_needs(error: Error, needs: &MemoryNeeds) -> Error {
    let is_out_of_memory = matches!(error, Error::OutOfDeviceMemory { .. });
    if is_out_of_memory {
        error.noting(&format!("bytes that parts of the render need: {}", needs.describe()))
    } else {
        error
    }
}

/// Texel buffers where the device allows the sizes that geometry and tables need, else storage.
fn back_end_for(context: &Context, shading: &Shading, bvh: &Bvh, cells: &Cells, settings: &Settings) -> BackEnd {
    let grids = RadianceGrid::texels(settings, cells).max(NormalizationGrid::texels(settings, cells));
    let texels = Geometry::texels(bvh).max(grids);
    match texels.max(shading.texels()) <= context.device().limits.max_texel_elements && !settings.storage_reads {
        true => BackEnd::Texel,
        false => BackEnd::Storage,
    }
}

/// The cells of a render's grids.
fn cells_of(settings: &Settings, bvh: &Bvh) -> Cells {
    match settings.sampler {
        Sampler::Bsdf | Sampler::Quadtree => Cells::none(bvh),
        _ if settings.grid != AUTO_GRID => Cells::new(bvh, UVec3::splat(settings.grid)),
        _ => Cells::fitting(bvh, |cells| memory_needs::guide_bytes(settings, cells) <= GUIDE_BYTES),
    }
}

/// The shape of the set of this number, the same for all kernels of a registry.
fn set_shape(kernels: &Kernels, set: u32) -> &'static SetShape {
    &kernels.path_trace.sets[set as usize]
}

/// The kind of buffer that the read-only binding of this number takes.
fn buffer_kind(shape: &SetShape, binding: u32) -> BufferKind {
    let binding = shape.bindings.iter().find(|shape| shape.binding == binding);
    match binding.map_or(BindingKind::StorageBuffer, |shape| shape.kind) {
        BindingKind::StorageBuffer => BufferKind::Storage,
        BindingKind::UniformBuffer => BufferKind::Uniform,
        BindingKind::TexelBufferFloat => BufferKind::TexelFloat,
        BindingKind::TexelBufferUint => BufferKind::TexelUint,
    }
}

/// The kind of buffer of single words that such a binding takes.
fn word_buffer_kind(shape: &SetShape, binding: u32) -> BufferKind {
    match buffer_kind(shape, binding) {
        BufferKind::TexelUint => BufferKind::TexelUint1,
        other => other,
    }
}

/// A set over `buffers`, each with the number of its binding. Those that no kernel of the registry sees are left out.
fn set_over(
    context: &Arc<Context>,
    name: &str,
    shape: &SetShape,
    buffers: &[(u32, &Arc<Buffer>)],
) -> Result<DescriptorSet> {
    let buffer_of = |number: u32| buffers.iter().find(|(binding, _)| *binding == number).map(|(_, buffer)| *buffer);
    let used: Vec<_> = shape.bindings.iter().filter_map(|binding| buffer_of(binding.binding)).collect();
    DescriptorSet::new(context, name, shape, &used)
}

/// The kind of a table that kernels write as words and may read as texels: `texel` where the set sees it as texels.
fn table_kind(shape: &SetShape, texel: BufferKind) -> BufferKind {
    let is_texel = |kind| matches!(kind, BindingKind::TexelBufferFloat | BindingKind::TexelBufferUint);
    let has_texels = shape.bindings.iter().any(|binding| is_texel(binding.kind));
    if has_texels { texel } else { BufferKind::Storage }
}
