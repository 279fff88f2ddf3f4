//! The choices between one kernel and waves, and between own traversal and ray queries, made once for a render.

use crate::encode::bvh::Bvh;
use crate::encode::cells::Cells;
use crate::encode::query_geometry::QueryGeometry;
use crate::encode::surfaces::Shading;
use crate::generated::layout::TEXEL_BYTES;
use crate::gpu::{DeviceInfo, DeviceKind};
use crate::renderer::memory_needs::{MemoryNeeds, PictureWork};
use crate::renderer::sets::bvh::BvhSet;
use crate::settings::{Execution, Settings, Traversal};
use crate::{Error, Result};

/// Primitives from which on `auto` takes waves: among 18 they were slower, among 28,000 faster.
const LEAST_PRIMITIVES: usize = 10_000;

/// Settings whose execution is decided, and the memory that the render then needs.
pub(crate) struct Plan {
    pub settings: Settings,
    pub needs: MemoryNeeds,
}

/// Decides how paths and rays are traced. For paths, `auto` falls back on one kernel where a wave's paths do not fit the memory.
pub(crate) fn resolve(
    device: &DeviceInfo,
    settings: &Settings,
    shading: &Shading,
    bvh: &Bvh,
    cells: &Cells,
    work: PictureWork,
) -> Result<Plan> {
    let traversal = resolve_traversal(device, settings.traversal, bvh)?;
    let plan = |execution| {
        let settings = Settings { execution, traversal, ..settings.clone() };
        Plan { needs: MemoryNeeds::new(device, shading, bvh, cells, &settings, work), settings }
    };
    let plan = match settings.execution {
        Execution::Megakernel => plan(Execution::Megakernel),
        Execution::Wavefront => {
            check_ballots(device)?;
            plan(Execution::Wavefront)
        }
        Execution::Auto => {
            let waves = waves_pay(device, settings, shading, bvh).then(|| plan(Execution::Wavefront));
            let fits = |plan: &Plan| plan.needs.check(device).is_ok();
            waves.filter(fits).unwrap_or_else(|| plan(Execution::Megakernel))
        }
    };
    let fit = plan.needs.check(device);
    if fit.is_err() && settings.traversal == Traversal::Auto && traversal == Traversal::Query {
        let settings = Settings { traversal: Traversal::Compute, ..settings.clone() };
        return resolve(device, &settings, shading, bvh, cells, work);
    }
    fit.map(|()| plan)
}

/// Decides how rays are traced. `auto` takes ray queries on a GPU that has them and allows structures and buffers of the scene's size.
fn resolve_traversal(device: &DeviceInfo, wanted: Traversal, bvh: &Bvh) -> Result<Traversal> {
    let has_queries = device.limits.has_ray_queries;
    let fits = QueryGeometry::most_elements(bvh) <= device.limits.max_structure_elements
        && BvhSet::texels(bvh) * TEXEL_BYTES as u64 <= device.limits.max_storage_buffer_bytes;
    if bvh.has_instances() || bvh.deforms() {
        return match wanted {
            Traversal::Query if bvh.has_instances() => Err(Error::Settings(format!(
                "--traversal query does not trace instances, of which the scene keeps {}: take --traversal compute",
                bvh.instance_count()
            ))),
            Traversal::Query => {
                let message =
                    "--traversal query does not trace meshes that change their shape: take --traversal compute";
                Err(Error::Settings(message.into()))
            }
            Traversal::Auto | Traversal::Compute => Ok(Traversal::Compute),
        };
    }
    match wanted {
        Traversal::Query if !has_queries => Err(Error::Settings(format!(
            "--traversal query needs ray queries (VK_KHR_ray_query), which {} lacks: take --traversal compute",
            device.name
        ))),
        Traversal::Auto if has_queries && fits && device.kind != DeviceKind::Cpu => Ok(Traversal::Query),
        Traversal::Query => Ok(Traversal::Query),
        Traversal::Auto | Traversal::Compute => Ok(Traversal::Compute),
    }
}

/// Whether `auto` takes waves: on a GPU, for emitter sampling in a scene that is not tiny, where they were faster. The answer
/// depends on nothing that varies from run to run, for a driver may round the arithmetic of other kernels differently.
fn waves_pay(device: &DeviceInfo, settings: &Settings, shading: &Shading, bvh: &Bvh) -> bool {
    let samples_lights = settings.nee && !shading.lights.is_empty();
    let pays = device.kind != DeviceKind::Cpu && samples_lights && bvh.primitives.len() >= LEAST_PRIMITIVES;
    pays && device.limits.has_subgroup_ballot && settings.check_wavefront().is_ok()
}

/// Refuses a device that cannot count the lanes that go on.
fn check_ballots(device: &DeviceInfo) -> Result<()> {
    if device.limits.has_subgroup_ballot {
        return Ok(());
    }
    Err(Error::Settings(format!(
        "--execution wavefront needs subgroup ballots, which {} lacks: take --execution megakernel",
        device.name
    )))
}
