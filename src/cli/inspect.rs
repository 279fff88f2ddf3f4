//! `lodestar inspect`.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lodestar::encode::bvh::Bvh;
use lodestar::generated::kernels::{BackEnd, Registry};
use lodestar::gpu::{Context, ContextOptions, DeviceInfo, Kernel, KernelSource, Representation};
use lodestar::renderer::{variant_for, variant_of_settings};
use lodestar::scene::{self, FilmDescription, IntegratorDescription, LoadOptions, ReconstructionFilter};
use lodestar::session::kernel_files::KernelFiles;
use lodestar::settings::options::form::{define, depth};
use lodestar::settings::{SamplePattern, Settings};
use lodestar::spirv::inspect;
use lodestar::{Error, Result, files};
use serde::Serialize;

use super::given::{Given, OfGuide};
use super::inspect_text;
use super::inspect_text::Inspected;
use super::print::{print_json, print_line, report};
use super::render_args::Filter;

/// Shows the interface and the instructions of the kernels.
///
/// The report has its interface, its instructions, one variant of it with constants folded, and the code that a driver compiles.
/// Options choose the variant. Constants that a scene decides have their defaults unless --scene names a scene.
#[derive(Debug, clap::Args)]
pub struct InspectArgs {
    /// The kernel, such as trace [default: all].
    kernel: Option<String>,
    /// Show this back end only [default: all].
    #[arg(long, value_enum)]
    back_end: Option<BackEnd>,
    /// Write .spv and .spvasm files and inspect.json to this folder; `specialized` holds the variant, `device` the driver's code.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Number of GLSL lines to show, beginning with the one that has the most instructions.
    #[arg(long, value_name = "N", default_value_t = 10)]
    lines: usize,
    /// Print JSON: everything, disassembly included.
    #[arg(long)]
    json: bool,
    /// Take kernels from the .spv files of this folder.
    #[arg(long, value_name = "DIR")]
    kernel_dir: Option<PathBuf>,
    /// Compile the variant with the driver of this Vulkan device, by index or by a part of its name, and show the result.
    #[arg(long, value_name = "INDEX|NAME")]
    device: Option<String>,

    /// Show the variant that renders this scene.
    #[arg(long, value_name = "SCENE", help_heading = "Variant")]
    scene: Option<PathBuf>,
    #[arg(short = 'D', value_parser = define, requires = "scene", help_heading = "Variant")]
    define: Vec<(String, String)>,
    #[arg(long, value_enum, help_heading = "Variant")]
    rfilter: Option<Filter>,
    #[arg(long, value_parser = depth, help_heading = "Variant")]
    max_depth: Option<u32>,
    #[arg(long, help_heading = "Variant")]
    rr_depth: Option<u32>,
    #[arg(long, value_enum, default_value_t = Switch::On, help_heading = "Variant")]
    nee: Switch,
    #[arg(long, value_enum, default_value_t = SamplePattern::Sobol, help_heading = "Variant")]
    pattern: SamplePattern,
    #[command(flatten)]
    guiding: Given<OfGuide>,
}

/// A switch that is on or off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Switch {
    /// Yes.
    On,
    /// No.
    Off,
}

/// Report that is printed as JSON.
#[derive(Debug, Serialize)]
struct Report<'a> {
    version: &'static str,
    /// Scene that decides constants of the variant.
    scene: Option<&'a Path>,
    device: Option<&'a DeviceInfo>,
    kernels: &'a [Inspected],
}

/// Prints and writes the report that `args` ask for.
pub fn run(args: &InspectArgs) -> Result<ExitCode> {
    let kernels = KernelFiles::load(args.kernel_dir.as_deref())?;
    kernels.warnings().iter().for_each(|warning| report("warning", warning));
    let constants = constants(args)?;
    let options = |device: &String| ContextOptions { device: Some(device.clone()), validate: false };
    let context = args.device.as_ref().map(|device| Context::new(&options(device))).transpose()?;
    let chosen = chosen(args, kernels.registry())?;
    let inspected = chosen.into_iter().map(|(back_ends, source)| {
        let examined = context.as_ref().map(|context| Kernel::examine(context, source, &constants)).transpose()?;
        Ok(Inspected {
            back_ends,
            report: inspect::report(source, &constants)?,
            pipeline: examined.map(|(_, report)| report),
            spirv: source.spirv.to_vec(),
        })
    });
    let inspected = inspected.collect::<Result<Vec<_>>>()?;
    let device = context.as_ref().map(|context| context.device());
    let whole =
        Report { version: env!("CARGO_PKG_VERSION"), scene: args.scene.as_deref(), device, kernels: &inspected };
    if let Some(folder) = &args.out {
        write_all(folder, &whole)?;
    }
    match args.json {
        true => print_json(&whole)?,
        false => print_line(inspect_text::text(&inspected, device, args.lines).trim_end())?,
    }
    Ok(ExitCode::SUCCESS)
}

/// Constants of the variant, each as its id and its bits.
fn constants(args: &InspectArgs) -> Result<Vec<(u32, u32)>> {
    let Some(path) = &args.scene else {
        // The variant does not depend on the film's size.
        let film = FilmDescription { width: 1, height: 1, crop: None, filter: ReconstructionFilter::Box };
        let settings = settings(args, Settings::for_film(&film, &IntegratorDescription::default()))?;
        return Ok(variant_of_settings(&settings).entries());
    };
    let scene = scene::load(path, &LoadOptions { defines: args.define.clone(), ..LoadOptions::default() })?;
    scene.warnings.iter().for_each(|warning| report("warning", warning));
    let settings = settings(args, Settings::for_scene(&scene))?;
    settings.check_lighting(&scene)?;
    Ok(variant_for(&settings, &scene, &Bvh::of_scene(&scene)).entries())
}

fn settings(args: &InspectArgs, mut settings: Settings) -> Result<Settings> {
    args.guiding.apply(&mut settings);
    settings.filter = args.rfilter.map_or(settings.filter, Filter::with_default_width);
    settings.max_depth = args.max_depth.unwrap_or(settings.max_depth);
    settings.rr_depth = args.rr_depth.unwrap_or(settings.rr_depth);
    settings.nee = args.nee == Switch::On;
    settings.pattern = args.pattern;
    settings.validate()?;
    args.guiding.check_uses(&settings)?;
    Ok(settings)
}

/// Kernels that `args` ask for. A kernel that several back ends share is listed once.
fn chosen<'a>(args: &InspectArgs, registry: &'a Registry) -> Result<Vec<(Vec<BackEnd>, &'a KernelSource)>> {
    let mut chosen: Vec<(Vec<BackEnd>, &KernelSource)> = Vec::new();
    for back_end in BackEnd::ALL {
        if args.back_end.is_some_and(|wanted| wanted != back_end) {
            continue;
        }
        for kernel in registry.kernels(back_end).iter() {
            if args.kernel.as_ref().is_some_and(|wanted| wanted != kernel.name) {
                continue;
            }
            match chosen.iter_mut().find(|(_, other)| other.file == kernel.file) {
                Some((back_ends, _)) => back_ends.push(back_end),
                None => chosen.push((vec![back_end], kernel)),
            }
        }
    }
    match &args.kernel {
        Some(wanted) if chosen.is_empty() => {
            let names: Vec<_> = registry.texel.iter().map(|kernel| kernel.name).collect();
            Err(Error::Settings(format!("there is no kernel `{wanted}`; there are {}", names.join(", "))))
        }
        _ => Ok(chosen),
    }
}

/// Writes the kernels to `folder`, in the form that --kernel-dir reads, and the report.
fn write_all(folder: &Path, whole: &Report) -> Result<()> {
    for kernel in whole.kernels {
        let stem = kernel.report.file.trim_end_matches(".spv");
        write(&folder.join(&kernel.report.file), &kernel.spirv)?;
        write(&folder.join(format!("{stem}.spvasm")), kernel.report.disassembly.as_bytes())?;
        if let Ok(specialized) = &kernel.report.specialized {
            let folder = folder.join("specialized");
            write(&folder.join(&kernel.report.file), &specialized.spirv)?;
            write(&folder.join(format!("{stem}.spvasm")), specialized.disassembly.as_bytes())?;
        }
        let executables = kernel.pipeline.iter().flat_map(|pipeline| pipeline.executables.iter().flatten());
        for (executable, form) in executables.flat_map(|e| e.representations.iter().map(move |form| (e, form))) {
            write_form(&folder.join("device"), &format!("{stem}.{}", executable.name), form)?;
        }
    }
    let path = folder.join("inspect.json");
    files::write_json(&path, whole)
}

/// Writes one form of a driver's code. The driver chose its name, so characters that a file system may refuse are replaced.
fn write_form(folder: &Path, stem: &str, form: &Representation) -> Result<()> {
    let name = format!("{stem}.{}", form.name);
    let words = name.split(|c: char| !c.is_ascii_alphanumeric() && c != '.' && c != '_');
    let stem = words.filter(|word| !word.is_empty()).collect::<Vec<_>>().join("-");
    match &form.text {
        Some(text) => write(&folder.join(format!("{stem}.txt")), text.as_bytes()),
        None => write(&folder.join(format!("{stem}.bin")), &form.bytes),
    }
}

fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(Error::write(folder))?;
    }
    files::write_whole(path, |writer| writer.write_all(bytes))
}
