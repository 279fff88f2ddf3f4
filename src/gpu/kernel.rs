//! Kernels: compute shaders that can be dispatched.

use std::io::Cursor;
use std::sync::Arc;
use std::time::Instant;

use ash::vk;

use super::context::Context;
use super::executables::{self, PipelineReport};
use super::fault::failed;
use super::layout::PipelineLayout;
use super::pipelines::{Pipeline, PipelineKey};
use crate::generated::interface::KernelSource;
use crate::spirv::specialization::specialized;
use crate::{Error, Result};

/// Kernel of a context: its pipeline, and the layout that its sets must have.
pub struct Kernel {
    pipeline: Arc<Pipeline>,
    source: KernelSource,
    layout: PipelineLayout,
}

impl Kernel {
    /// Builds the pipeline with specialization constants as (id, bits), unless the context has it already. Ids that the
    /// kernel does not use are ignored. Constants that are not given keep their value in the GLSL.
    ///
    /// # Errors
    /// Where the driver cannot compile the kernel or is out of memory.
    pub fn new(context: &Arc<Context>, source: &KernelSource, constants: &[(u32, u32)]) -> Result<Self> {
        let layout = PipelineLayout::new(context, source)?;
        let used: Vec<_> = used_constants(source, constants).collect();
        let pipeline = context.pipelines().get_or_build(PipelineKey::new(source, &used), || {
            let module = ShaderModule::new(context, source, constants)?;
            create_pipeline(context, source, constants, &module, &layout, Build::ToRun)
        })?;
        Ok(Self { pipeline, source: source.clone(), layout })
    }

    /// Builds the pipeline without the pipeline cache, and returns it with the driver's report and the build time. Some
    /// drivers do part of the work only at the first dispatch.
    ///
    /// # Errors
    /// All errors of [`Self::new`], and errors of the driver's report.
    pub fn examine(
        context: &Arc<Context>,
        source: &KernelSource,
        constants: &[(u32, u32)],
    ) -> Result<(Self, PipelineReport)> {
        let module = ShaderModule::new(context, source, constants)?;
        let layout = PipelineLayout::new(context, source)?;
        let begin = Instant::now();
        let pipeline = create_pipeline(context, source, constants, &module, &layout, Build::ToExamine)?;
        let creation_seconds = begin.elapsed().as_secs_f64();
        let kernel = Self { pipeline: Arc::new(pipeline), source: source.clone(), layout };
        let executables = executables::of_pipeline(context.logical(), kernel.raw())?;
        Ok((kernel, PipelineReport { creation_seconds, executables }))
    }

    /// Name of the kernel: the stem of its `.comp` file.
    pub fn name(&self) -> &'static str {
        self.source.name
    }

    /// Source that the kernel was built from.
    pub fn source(&self) -> &KernelSource {
        &self.source
    }

    /// Handle of the pipeline, for a call during which the caller borrows this value.
    pub(super) fn raw(&self) -> vk::Pipeline {
        self.pipeline.raw()
    }

    pub(super) fn layout(&self) -> &PipelineLayout {
        &self.layout
    }

    pub(super) fn context(&self) -> &Arc<Context> {
        self.layout.context()
    }
}

/// Purposes of building a pipeline.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Build {
    ToRun,
    /// The pipeline cache is left aside, so that the build takes as long as in a first run. The driver keeps its
    /// statistics and representations, where it can report them.
    ToExamine,
}

fn create_pipeline(
    context: &Context,
    source: &KernelSource,
    constants: &[(u32, u32)],
    module: &ShaderModule,
    layout: &PipelineLayout,
    build: Build,
) -> Result<Pipeline> {
    let (entries, values) = specialization(source, constants);
    let specialization =
        vk::SpecializationInfo::default().map_entries(&entries).data(bytemuck::cast_slice(values.as_slice()));
    let stage = vk::PipelineShaderStageCreateInfo::default()
        .stage(vk::ShaderStageFlags::COMPUTE)
        .module(module.raw)
        .name(c"main")
        .specialization_info(&specialization);
    let keep =
        vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR | vk::PipelineCreateFlags::CAPTURE_INTERNAL_REPRESENTATIONS_KHR;
    let (flags, cache) = match build {
        Build::ToRun => (vk::PipelineCreateFlags::empty(), context.pipeline_cache().raw()),
        Build::ToExamine if context.logical().executables().is_some() => (keep, vk::PipelineCache::null()),
        Build::ToExamine => (vk::PipelineCreateFlags::empty(), vk::PipelineCache::null()),
    };
    let info = [vk::ComputePipelineCreateInfo::default().flags(flags).stage(stage).layout(layout.raw())];
    // SAFETY: invariant 1: device, module, layout and the cache, if any, are alive; all that `info` points to are
    // locals.
    let pipelines = unsafe { context.raw().create_compute_pipelines(cache, &info, None) };
    // One pipeline was asked for, so none has to be destroyed after a failure.
    let pipelines = pipelines.map_err(|(_, code)| failed(format!("compiling the kernel `{}`", source.name))(code))?;
    let pipeline = Pipeline::new(Arc::clone(context.shared_device()), pipelines[0]);
    context.logical().name(pipeline.raw(), source.name);
    Ok(pipeline)
}

/// Constants that the kernel uses.
fn used_constants(source: &KernelSource, constants: &[(u32, u32)]) -> impl Iterator<Item = (u32, u32)> {
    constants.iter().filter(|(id, _)| source.specialization_ids.contains(id)).copied()
}

/// Entries for the constants that the kernel uses, and the values that they point into, 4 bytes each.
fn specialization(source: &KernelSource, constants: &[(u32, u32)]) -> (Vec<vk::SpecializationMapEntry>, Vec<u32>) {
    let entry = |(place, (id, value)): (usize, (u32, u32))| {
        let entry = vk::SpecializationMapEntry::default().constant_id(id).offset(place as u32 * 4).size(4);
        (entry, value)
    };
    used_constants(source, constants).enumerate().map(entry).unzip()
}

/// Shader module, needed only until the pipeline is built.
struct ShaderModule {
    raw: vk::ShaderModule,
    context: Arc<Context>,
}

impl ShaderModule {
    fn new(context: &Arc<Context>, source: &KernelSource, constants: &[(u32, u32)]) -> Result<Self> {
        let call = format!("loading the kernel `{}`", source.name);
        let words = ash::util::read_spv(&mut Cursor::new(&source.spirv))
            .map_err(|error| Error::Vulkan { call: call.clone(), reason: error.to_string() })?;
        let words = specialized(&words, constants).unwrap_or(words);
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: invariant 1: the device is alive, and `words` is a local that holds SPIR-V (see `KernelSource`).
        let raw = unsafe { context.raw().create_shader_module(&info, None) }.map_err(failed(call))?;
        context.logical().name(raw, source.name);
        Ok(Self { raw, context: Arc::clone(context) })
    }
}

impl Drop for ShaderModule {
    fn drop(&mut self) {
        // SAFETY: invariant 1: owned by this value alone; a pipeline does not refer to its module once built.
        unsafe { self.context.raw().destroy_shader_module(self.raw, None) }
    }
}
