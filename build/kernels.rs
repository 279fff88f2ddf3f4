//! SPIR-V and reflection of all kernels, on all cores.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::cores::on_all_cores;
use super::glsl::files::{below, read, read_all, write_file};
use super::glsl::{FOLDER as INCLUDE_FOLDER, Includes};
use super::interface::Interface;
use super::spirv;

/// Name of the file whose inclusion makes a kernel be built for texel buffers, too.
const GEOMETRY_FILE: &str = "geometry/bvh.glsl";
/// Extension whose name in a kernel's file makes the kernel be built for ray queries, too.
const RAY_QUERY_EXTENSION: &str = "GL_EXT_ray_query";
const KERNEL_FOLDER: &str = "glsl/kernels";
/// Folder of the tests' kernels. The published crate does not have it.
const TEST_FOLDER: &str = "glsl/test";
/// Most identifiers of a kernel. The optimizer hands out 4,194,303, and overflows the stack where it needs more.
const MOST_IDENTIFIERS: u32 = 3_500_000;

/// What a kernel reads geometry from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum BackEnd {
    /// Storage buffers.
    Storage,
    /// Texel buffers.
    Texel,
    /// Storage buffers, and an acceleration structure that the device's ray queries traverse.
    Query,
}

impl BackEnd {
    /// All back ends.
    pub const ALL: [Self; 3] = [Self::Storage, Self::Texel, Self::Query];

    /// Macros that the GLSL is compiled with.
    #[cfg(feature = "shaderc")]
    pub fn macros(self) -> &'static [&'static str] {
        match self {
            Self::Storage => &[],
            Self::Texel => &["TEXEL_READS"],
            Self::Query => &["RAY_QUERIES"],
        }
    }

    /// Part of the SPIR-V's file name.
    fn suffix(self) -> &'static str {
        match self {
            Self::Storage => "",
            Self::Texel => ".texel",
            Self::Query => ".query",
        }
    }
}

/// SPIR-V module with its interface.
pub struct Module {
    spirv: Vec<u8>,
    /// Interface that the SPIR-V demands of its pipeline.
    pub interface: Interface,
}

/// Kernel: a `.comp` file and its compiled modules.
pub struct Kernel {
    /// Name: the stem of the file name.
    pub name: String,
    /// Path of the source in the repository.
    pub file: String,
    modules: BTreeMap<BackEnd, Module>,
}

impl Kernel {
    /// Whether the kernel runs a pure function for the tests.
    pub fn is_test(&self) -> bool {
        self.file.starts_with(TEST_FOLDER)
    }

    /// Whether a renderer dispatches the kernel.
    pub fn is_product(&self) -> bool {
        !self.is_test()
    }

    /// Whether the kernel has a module of its own for this back end.
    pub fn has(&self, back_end: BackEnd) -> bool {
        self.modules.contains_key(&back_end)
    }

    /// Back end to use in place of `back_end`. Every kernel has the storage back end.
    pub fn available(&self, back_end: BackEnd) -> BackEnd {
        if self.has(back_end) { back_end } else { BackEnd::Storage }
    }

    /// Module of the back end that is [available](Self::available).
    pub fn module(&self, back_end: BackEnd) -> &Module {
        &self.modules[&self.available(back_end)]
    }

    /// File name of the SPIR-V.
    pub fn spirv_file(&self, back_end: BackEnd) -> String {
        spirv_file(&self.file, self.available(back_end))
    }

    /// Writes the kernel's SPIR-V into the folder `out`.
    pub fn write_modules(&self, out: &Path) -> Result<(), String> {
        let write =
            |(&back_end, module): (&BackEnd, &Module)| write_file(&out.join(self.spirv_file(back_end)), &module.spirv);
        self.modules.iter().try_for_each(write)
    }
}

/// Module to be made.
struct Job {
    kernel: usize,
    back_end: BackEnd,
    /// Size of all sources in bytes, an estimate of the compilation time.
    source_bytes: u64,
}

/// All kernels, in the order of their names. The files that were written for GLSL lie in `written`.
pub fn all(includes: &Includes, written: &Path) -> Result<Vec<Kernel>, String> {
    let mut files = below(Path::new(""), KERNEL_FOLDER, ".comp")?;
    if Path::new(TEST_FOLDER).exists() {
        files.extend(below(Path::new(""), TEST_FOLDER, ".comp")?);
    }
    files.sort_by_key(|file| kernel_name(file));
    let jobs = jobs(&files, includes)?;
    let results = on_all_cores(jobs.len(), |job| module(&files[jobs[job].kernel], jobs[job].back_end, written));
    let mut modules: Vec<BTreeMap<BackEnd, Module>> = files.iter().map(|_| BTreeMap::new()).collect();
    let mut results: Vec<_> = jobs.iter().zip(results).collect();
    results.sort_by_key(|(job, _)| (job.kernel, job.back_end));
    for (job, module) in results {
        modules[job.kernel].insert(job.back_end, module?);
    }
    let kernel = |(file, modules): (String, _)| Kernel { name: kernel_name(&file), file, modules };
    Ok(files.into_iter().zip(modules).map(kernel).collect())
}

/// All jobs, the longest first, so that no long one runs alone at the end.
fn jobs(files: &[String], includes: &Includes) -> Result<Vec<Job>, String> {
    let mut jobs = Vec::new();
    for (kernel, file) in files.iter().enumerate() {
        let text = read(Path::new(""), file)?;
        let mut names = BTreeSet::new();
        let source_bytes = text.len() as u64 + included_bytes(&text, includes, &mut names)?;
        jobs.push(Job { kernel, back_end: BackEnd::Storage, source_bytes });
        if names.contains(GEOMETRY_FILE) {
            jobs.push(Job { kernel, back_end: BackEnd::Texel, source_bytes });
        }
        if text.contains(RAY_QUERY_EXTENSION) {
            jobs.push(Job { kernel, back_end: BackEnd::Query, source_bytes });
        }
    }
    jobs.sort_by_key(|job| std::cmp::Reverse(job.source_bytes));
    Ok(jobs)
}

/// Adds the names of all files that a text includes to `names`. Returns the number of bytes that were added.
fn included_bytes(text: &str, includes: &Includes, names: &mut BTreeSet<String>) -> Result<u64, String> {
    let mut bytes = 0;
    for name in text.lines().filter_map(|line| line.strip_prefix("#include \"")?.strip_suffix('"')) {
        if names.insert(name.to_owned()) {
            let text = includes.text(Path::new(""), name)?;
            bytes += text.len() as u64 + included_bytes(&text, includes, names)?;
        }
    }
    Ok(bytes)
}

fn module(file: &str, back_end: BackEnd, written: &Path) -> Result<Module, String> {
    let spirv = spirv::of(file, back_end, written)?;
    // The fourth word of a module is the bound of its identifiers.
    let bound = spirv.as_chunks::<4>().0.get(3).map_or(0, |word| u32::from_le_bytes(*word));
    if bound > MOST_IDENTIFIERS {
        return Err(format!(
            "{file}: the optimizer needs {bound} identifiers; the most is {MOST_IDENTIFIERS}. Let structs that are filled in parts begin as \
             constants"
        ));
    }
    let interface = Interface::reflect(&spirv).map_err(|e| format!("{file}: {e}"))?;
    Ok(Module { spirv, interface })
}

/// File name of the SPIR-V of the kernel `file`.
pub fn spirv_file(file: &str, back_end: BackEnd) -> String {
    let folder = if file.starts_with(TEST_FOLDER) { "test." } else { "" };
    format!("{folder}{}{}.spv", kernel_name(file), back_end.suffix())
}

/// Fingerprint of the GLSL of all kernels except the tests': 64-bit FNV-1a of the files' names and texts, in hexadecimal.
pub fn fingerprint(includes: &Includes) -> Result<String, String> {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let files = read_all(Path::new(""), &[KERNEL_FOLDER, INCLUDE_FOLDER])?;
    let files = files.iter().map(|(file, text)| (file, text));
    for (file, text) in files.chain(&includes.texts) {
        for byte in file.bytes().chain([0]).chain(text.bytes()).chain([0]) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    Ok(format!("{hash:016x}\n"))
}

fn kernel_name(file: &str) -> String {
    Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
