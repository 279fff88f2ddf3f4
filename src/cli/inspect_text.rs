//! Text that `lodestar inspect` prints for people.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use lodestar::generated::kernels::BackEnd;
use lodestar::gpu::{DeviceInfo, Executable, PipelineReport};
use lodestar::spirv::inspect::{Class, Count, Histogram, Interface, KernelReport, Layout, Member};

use serde::Serialize;

/// Report on one kernel.
#[derive(Debug, Serialize)]
pub struct Inspected {
    /// Back ends that use the kernel.
    pub back_ends: Vec<BackEnd>,
    #[serde(flatten)]
    pub report: KernelReport,
    /// Code and statistics of the device's driver, if a device was chosen.
    pub pipeline: Option<PipelineReport>,
    #[serde(skip)]
    pub spirv: Vec<u8>,
}

/// Report on every kernel, with `line_count` lines of GLSL each.
pub fn text(kernels: &[Inspected], device: Option<&DeviceInfo>, line_count: usize) -> String {
    let mut text = String::new();
    for kernel in kernels {
        header(&mut text, kernel);
        interface(&mut text, &kernel.report.interface);
        let specialized = kernel.report.specialized.as_ref().ok().map(|s| &s.histogram);
        instructions(&mut text, &kernel.report.histogram, specialized);
        lines(&mut text, specialized.unwrap_or(&kernel.report.histogram), line_count);
        if let (Some(pipeline), Some(device)) = (&kernel.pipeline, device) {
            driver(&mut text, pipeline, device);
        }
        kernel.report.notes.iter().for_each(|note| push(&mut text, &format!("note: {note}\n")));
        text.push('\n');
    }
    text
}

fn push(text: &mut String, more: &str) {
    text.push_str(more);
}

fn header(text: &mut String, kernel: &Inspected) {
    let report = &kernel.report;
    let reads = match &kernel.back_ends[..] {
        _ if report.file.ends_with(".texel.spv") => "reads texel buffers",
        _ if report.file.ends_with(".query.spv") => "asks ray queries",
        all if all.len() == BackEnd::ALL.len() => "used by all back ends",
        _ => "reads storage buffers",
    };
    let size = report.interface.workgroup_size.map(|dimension| dimension.to_string()).join(" x ");
    let title = format!("{} ({}, {reads})", report.name, report.file);
    let _ = writeln!(text, "{title}\n{}", "=".repeat(title.len()));
    let _ = write!(text, "{} bytes", report.spirv_bytes);
    if let Ok(specialized) = &report.specialized {
        let _ = write!(text, ", {} with the constants below folded", specialized.spirv_bytes);
    }
    let _ = writeln!(text, "; entry point {}, workgroup {size}\n", report.interface.entry_point);
}

fn interface(text: &mut String, interface: &Interface) {
    push(text, "bindings: set, number, kind, access, name; offset, bytes, stride, member\n");
    for binding in &interface.bindings {
        let (kind, access) = (&binding.kind, binding.access);
        let _ = writeln!(text, "  {} {:<2} {kind:<21} {access:<12} {}", binding.set, binding.binding, binding.name);
        binding.layout.iter().for_each(|layout| members(text, &layout.members, 0));
    }
    if let Some(Layout { bytes, members: all }) = &interface.push_constants {
        let _ = writeln!(text, "\npush constants: {} bytes", bytes.unwrap_or_default());
        members(text, all, 0);
    }
    if !interface.constants.is_empty() {
        push(text, "\nspecialization constants: id, type, name, default, value\n");
    }
    for c in &interface.constants {
        let (default, value) = (c.default.to_string(), c.value.to_string());
        let mark = if default == value { "" } else { " *" };
        let _ = writeln!(text, "  {:>3} {:<6} {:<22} {default:>8} {value:>8}{mark}", c.id, c.type_name, c.name);
    }
}

fn members(text: &mut String, all: &[Member], depth: usize) {
    for member in all {
        let number = |number: Option<usize>| number.map(|number| number.to_string()).unwrap_or_default();
        let (bytes, stride) = (number(member.bytes), number(member.stride));
        let indent = " ".repeat(2 * depth);
        let Member { type_name, name, offset, .. } = member;
        let _ = writeln!(text, "       {indent}{offset:>4} {bytes:>5} {stride:>5}  {type_name} {name}");
        members(text, &member.members, depth + 1);
    }
}

fn instructions(text: &mut String, compiled: &Histogram, variant: Option<&Histogram>) {
    let (left, right) = ("as compiled", if variant.is_some() { "this variant" } else { "" });
    let _ = writeln!(text, "\n{:<34} {left:>17} {right:>18}", "instructions, (scalars)");
    let empty = Histogram::default();
    let other = variant.unwrap_or(&empty);
    let classes: BTreeSet<Class> = compiled.classes.keys().chain(other.classes.keys()).copied().collect();
    for class in classes {
        let right = variant.map(|variant| pair(variant.class(class))).unwrap_or_default();
        let _ = writeln!(text, "  {:<32} {:>17} {right:>18}", class.describe(), pair(compiled.class(class)));
    }
    let right = variant.map(|variant| pair(variant.total)).unwrap_or_default();
    let _ = writeln!(text, "  {:<32} {:>17} {right:>18}", "all", pair(compiled.total));
}

fn pair(count: Count) -> String {
    format!("{} ({})", count.instructions, count.scalars)
}

fn lines(text: &mut String, histogram: &Histogram, line_count: usize) {
    push(text, "\ninstructions by GLSL file\n");
    for (file, count) in histogram.files() {
        let _ = writeln!(text, "  {:>5}  {file}", count.instructions);
    }
    push(text, "\ninstructions by line of GLSL, inlined copies added up\n");
    for line in histogram.lines.iter().take(line_count) {
        let _ = writeln!(text, "  {:>5}  {}:{}: {}", line.total.instructions, line.file, line.line, line.text);
    }
}

fn driver(text: &mut String, pipeline: &PipelineReport, device: &DeviceInfo) {
    let _ = writeln!(text, "\non {} ({} {})", device.name, device.driver_name, device.driver_info);
    let _ = writeln!(text, "  compiled in {:.1} ms, without a cache", pipeline.creation_seconds * 1e3);
    match &pipeline.executables {
        None => push(text, "  the driver lacks VK_KHR_pipeline_executable_properties, so its code cannot be shown\n"),
        Some(executables) => executables.iter().for_each(|executable| program(text, executable)),
    }
}

fn program(text: &mut String, executable: &Executable) {
    let Executable { name, description, subgroup_size, .. } = executable;
    let _ = writeln!(text, "  {name}: {description}, subgroups of {subgroup_size}");
    for statistic in &executable.statistics {
        let _ =
            writeln!(text, "    {:<30} {:>10}  {}", statistic.name, statistic.value.to_string(), statistic.description);
    }
    for form in &executable.representations {
        let _ = writeln!(text, "    {:<30} {:>10}  bytes; --out writes them", form.name, form.bytes.len());
    }
}
