//! SPIR-V as an engineer reads it: a kernel's interface, what instructions it has and from which lines of GLSL, the same for
//! one variant with its constants folded, and kernels from files in place of the built-in ones.

mod histogram;
mod interface;

mod specialize;

use serde::Serialize;

pub use crate::spirv::tools::ToolFault;
pub use histogram::{Class, Count, Histogram, SourceLine};
pub use interface::{Binding, Dimension, Interface, Layout, Member, SpecConstant};

use crate::gpu::KernelSource;
use crate::spirv::module::Module;
use crate::spirv::tools;
use crate::{Error, Result};

/// All that is known of a kernel without a device.
#[derive(Debug, Clone, Serialize)]
pub struct KernelReport {
    /// The kernel's name.
    pub name: String,
    /// The name of its file, which tells apart the back ends.
    pub file: String,
    /// Its size.
    pub spirv_bytes: usize,
    /// What it asks of its pipeline.
    pub interface: Interface,
    /// Its instructions as compiled.
    pub histogram: Histogram,
    /// Its disassembly as compiled.
    pub disassembly: String,
    /// The same for one variant; or why there is none, which is a note, too.
    #[serde(serialize_with = "serialize_specialized")]
    pub specialized: Result<Specialized, ToolFault>,
    /// What is missing or was done another way, one sentence each.
    pub notes: Vec<String>,
}

/// One variant of a kernel: constants folded, dead code removed.
#[derive(Debug, Clone, Serialize)]
pub struct Specialized {
    /// Its size.
    pub spirv_bytes: usize,
    /// Its instructions.
    pub histogram: Histogram,
    /// Its disassembly.
    pub disassembly: String,
    /// The module.
    #[serde(skip)]
    pub spirv: Vec<u8>,
}

/// Reports on a kernel; `constants` are (id, bits) of the variant's specialization constants.
///
/// # Errors
/// Where the kernel is no SPIR-V that can be read.
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

/// With the names of the GLSL where SPIRV-Tools are there, else with numbers.
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
