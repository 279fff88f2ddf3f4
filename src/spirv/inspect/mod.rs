//! SPIR-V for engineers: a kernel's interface, its instructions and the lines of GLSL that they come from, also for one
//! variant with its constants folded.

mod histogram;
mod interface;

mod specialize;

use serde::Serialize;

pub use crate::spirv::tools::ToolFault;
pub use histogram::{Class, Count, Histogram, SourceLine};
pub use interface::{Binding, Dimension, Interface, Layout, Member, SpecConstant};

use crate::generated::interface::KernelSource;
use crate::spirv::module::Module;
use crate::spirv::tools;
use crate::{Error, Result};

/// All facts about a kernel that are known without a device.
#[derive(Debug, Clone, Serialize)]
pub struct KernelReport {
    /// Name of the kernel.
    pub name: String,
    /// Name of the kernel's file, which distinguishes the back ends.
    pub file: String,
    /// Size of the SPIR-V in bytes.
    pub spirv_bytes: usize,
    /// Bindings and constants of the kernel.
    pub interface: Interface,
    /// Instructions as compiled.
    pub histogram: Histogram,
    /// Disassembly as compiled.
    pub disassembly: String,
    /// One variant of the kernel. An error says why there is none; it is repeated among the notes.
    #[serde(serialize_with = "serialize_specialized")]
    pub specialized: Result<Specialized, ToolFault>,
    /// Notes on missing or replaced parts, one sentence each.
    pub notes: Vec<String>,
}

/// One variant of a kernel: constants folded, dead code removed.
#[derive(Debug, Clone, Serialize)]
pub struct Specialized {
    /// Size of the SPIR-V in bytes.
    pub spirv_bytes: usize,
    /// Instructions of the variant.
    pub histogram: Histogram,
    /// Disassembly of the variant.
    pub disassembly: String,
    /// SPIR-V of the variant.
    #[serde(skip)]
    pub spirv: Vec<u8>,
}

/// Reports on a kernel; `constants` are the (id, bits) of the variant's specialization constants.
///
/// # Errors
/// [`Error::Kernel`] where the kernel's SPIR-V cannot be read.
pub fn report(source: &KernelSource, constants: &[(u32, u32)]) -> Result<KernelReport> {
    let unreadable = |message: String| Error::kernel(source.file, message);
    let module = Module::parse(&source.spirv).map_err(unreadable)?;
    let mut notes = Vec::new();
    let mut interface = Interface::of(&module).map_err(unreadable)?;
    interface.set_values(constants);
    let disassembly = disassembly(&module, &mut notes);
    let specialized = specialized(&module, constants);
    notes.extend(specialized.as_ref().err().map(|fault| format!("the variant is not shown: {fault}")));
    Ok(KernelReport {
        name: source.name.into(),
        file: source.file.into(),
        spirv_bytes: source.spirv.len(),
        interface,
        histogram: Histogram::of(&module),
        disassembly,
        specialized,
        notes,
    })
}

fn specialized(module: &Module, constants: &[(u32, u32)]) -> Result<Specialized, ToolFault> {
    let spirv = specialize::specialize(module, constants)?;
    let module = Module::parse(&spirv).map_err(ToolFault::Failed)?;
    Ok(Specialized {
        spirv_bytes: spirv.len(),
        histogram: Histogram::of(&module),
        disassembly: disassembly(&module, &mut Vec::new()),
        spirv,
    })
}

/// Disassembly with the names of the GLSL where SPIRV-Tools is installed, else with numbers.
fn disassembly(module: &Module, notes: &mut Vec<String>) -> String {
    tools::disassemble(module.words()).unwrap_or_else(|fault| {
        notes.push(format!("the disassembly has numbers for names: {fault}"));
        module.disassemble()
    })
}

fn serialize_specialized<S: serde::Serializer>(
    specialized: &Result<Specialized, ToolFault>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    specialized.as_ref().ok().serialize(serializer)
}
