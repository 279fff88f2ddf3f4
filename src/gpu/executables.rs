//! Reports of the driver on the machine code of a kernel (VK_KHR_pipeline_executable_properties).

use std::ffi::CStr;

use ash::{khr, vk};
use serde::Serialize;

use super::device::LogicalDevice;
use super::fault::failed;
use super::fault_injection::{May, before};
use crate::Result;

/// Report on a kernel's pipeline.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PipelineReport {
    /// Time that the driver took to build the pipeline, in seconds, without Lodestar's pipeline cache.
    pub creation_seconds: f64,
    /// Programs that the driver made; `None` where it lacks VK_KHR_pipeline_executable_properties.
    pub executables: Option<Vec<Executable>>,
}

/// One program of a pipeline.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Executable {
    /// Name that the driver gives it.
    pub name: String,
    /// Description by the driver.
    pub description: String,
    /// Number of invocations that run in lockstep; 0 where the driver does not say.
    pub subgroup_size: u32,
    /// Numbers that the driver reports, such as registers, spills and instructions.
    pub statistics: Vec<Statistic>,
    /// Intermediate and machine code.
    pub representations: Vec<Representation>,
}

/// One number about a program.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Statistic {
    /// Name that the driver gives it.
    pub name: String,
    /// Description by the driver.
    pub description: String,
    /// The number itself.
    pub value: StatisticValue,
}

/// Number of the type that the driver chose.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged)]
pub enum StatisticValue {
    /// Yes or no.
    Bool(bool),
    /// Signed integer.
    Signed(i64),
    /// Unsigned integer.
    Unsigned(u64),
    /// Real number.
    Real(f64),
}

impl std::fmt::Display for StatisticValue {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Bool(value) => value.fmt(f),
            Self::Signed(value) => value.fmt(f),
            Self::Unsigned(value) => value.fmt(f),
            Self::Real(value) => value.fmt(f),
        }
    }
}

/// One form of a program on its way to machine code.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Representation {
    /// Name that the driver gives it.
    pub name: String,
    /// Description by the driver.
    pub description: String,
    /// The code, where it is text.
    pub text: Option<String>,
    /// The code as the driver gave it.
    #[serde(skip)]
    pub bytes: Vec<u8>,
}

/// Programs of a pipeline that was built to keep statistics, and whose kernel the caller borrows for this call; `None`
/// where the driver does not report them.
pub(super) fn of_pipeline(device: &LogicalDevice, pipeline: vk::Pipeline) -> Result<Option<Vec<Executable>>> {
    let Some(device) = device.executables() else { return Ok(None) };
    let info = vk::PipelineInfoKHR::default().pipeline(pipeline);
    // SAFETY: invariant 1: device and pipeline are alive.
    let properties = before(May::RunOutOfMemory)
        .and_then(|()| unsafe { device.get_pipeline_executable_properties(&info) })
        .map_err(failed("vkGetPipelineExecutablePropertiesKHR"))?;
    let executables = (0..).zip(&properties).map(|(index, properties)| {
        let info = vk::PipelineExecutableInfoKHR::default().pipeline(pipeline).executable_index(index);
        Ok(Executable {
            name: text(properties.name_as_c_str().ok()),
            description: text(properties.description_as_c_str().ok()),
            subgroup_size: properties.subgroup_size,
            statistics: statistics(device, &info)?,
            representations: representations(device, &info)?,
        })
    });
    executables.collect::<Result<_>>().map(Some)
}

fn statistics(
    device: &khr::pipeline_executable_properties::Device,
    info: &vk::PipelineExecutableInfoKHR,
) -> Result<Vec<Statistic>> {
    // SAFETY: invariant 1: device and pipeline are alive; the pipeline was built to keep statistics.
    let statistics = before(May::RunOutOfMemory)
        .and_then(|()| unsafe { device.get_pipeline_executable_statistics(info) })
        .map_err(failed("vkGetPipelineExecutableStatisticsKHR"))?;
    let known = statistics.iter().filter_map(|statistic| {
        Some(Statistic {
            name: text(statistic.name_as_c_str().ok()),
            description: text(statistic.description_as_c_str().ok()),
            value: value(statistic.format, statistic.value)?,
        })
    });
    Ok(known.collect())
}

/// Value of a statistic; `None` where its format belongs to a later version of the extension.
fn value(
    format: vk::PipelineExecutableStatisticFormatKHR,
    value: vk::PipelineExecutableStatisticValueKHR,
) -> Option<StatisticValue> {
    use vk::PipelineExecutableStatisticFormatKHR as Format;
    // SAFETY: every field is a plain number that is valid for any bits and no longer than the union, which ash clears.
    unsafe {
        match format {
            Format::BOOL32 => Some(StatisticValue::Bool(value.b32 != 0)),
            Format::INT64 => Some(StatisticValue::Signed(value.i64)),
            Format::UINT64 => Some(StatisticValue::Unsigned(value.u64)),
            Format::FLOAT64 => Some(StatisticValue::Real(value.f64)),
            _ => None,
        }
    }
}

fn representations(
    device: &khr::pipeline_executable_properties::Device,
    info: &vk::PipelineExecutableInfoKHR,
) -> Result<Vec<Representation>> {
    let call = "vkGetPipelineExecutableInternalRepresentationsKHR";
    // SAFETY: invariant 1: device and pipeline are alive; the pipeline was built to keep representations.
    let mut answers = before(May::RunOutOfMemory)
        .and_then(|()| unsafe { device.get_pipeline_executable_internal_representations(info) })
        .map_err(failed(call))?;
    // The first answer has sizes only; the second fills buffers of these sizes.
    let mut buffers: Vec<Vec<u8>> = answers.iter().map(|answer| vec![0; answer.data_size]).collect();
    for (answer, buffer) in answers.iter_mut().zip(&mut buffers) {
        answer.p_data = buffer.as_mut_ptr().cast();
    }
    let mut count = answers.len() as u32;
    // SAFETY: invariant 1: as above; `answers` has `count` elements, each pointing at a local of the size it states.
    let mut fill = || unsafe {
        (device.fp().get_pipeline_executable_internal_representations_khr)(
            device.device(),
            info,
            &mut count,
            answers.as_mut_ptr(),
        )
    };
    before(May::RunOutOfMemory).and_then(|()| fill().result()).map_err(failed(call))?;
    let filled = answers.iter().zip(buffers).take(count as usize).map(|(answer, mut bytes)| {
        bytes.truncate(answer.data_size);
        let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
        let is_text = answer.is_text == vk::TRUE;
        Representation {
            name: text(answer.name_as_c_str().ok()),
            description: text(answer.description_as_c_str().ok()),
            text: is_text.then(|| String::from_utf8_lossy(&bytes[..end]).into_owned()),
            bytes,
        }
    });
    Ok(filled.collect())
}

fn text(chars: Option<&CStr>) -> String {
    chars.map(|chars| chars.to_string_lossy().into_owned()).unwrap_or_default()
}
