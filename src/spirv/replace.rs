//! Replacement of built-in kernels by files, for people who tune kernels. A file must have the built-in kernel's
//! interface.

use std::borrow::Cow;
use std::fs;
use std::path::Path;

use crate::generated::interface::KernelSource;
use crate::generated::kernels::{BackEnd, Registry, Variant};
use crate::spirv::inspect::Interface;
use crate::spirv::module::Module;
use crate::spirv::tools::{self, ToolFault};
use crate::{Error, Result, inputs};

/// Largest file in bytes. Built-in kernels have a hundredth of it.
const MAX_BYTES: u64 = 64 << 20;

/// Registry in which some kernels came from files.
#[derive(Debug, Clone)]
pub struct Replacement {
    /// All kernels, built-in and replaced.
    pub registry: Registry,
    /// Names of the files that replaced a kernel.
    pub files: Vec<String>,
    /// Warnings about files that were ignored or could not be checked, one sentence each.
    pub warnings: Vec<String>,
}

/// Reads every `.spv` file of a folder that has a kernel's name. `lodestar inspect --out` writes such files:
/// `trace.spv` reads storage buffers, `trace.texel.spv` texel buffers, and `trace.query.spv` an acceleration structure.
///
/// # Errors
/// [`Error::Read`] where the folder or a file cannot be read; [`Error::Kernel`] where a file is no valid SPIR-V or has
/// another interface than the built-in kernel.
pub fn load(folder: &Path) -> Result<Replacement> {
    let mut replacement = Replacement { registry: Registry::built_in(), files: Vec::new(), warnings: Vec::new() };
    for name in file_names(folder)? {
        if !name.ends_with(".spv") {
            continue;
        }
        let path = folder.join(&name);
        match built_in(&replacement.registry, &name) {
            Some(built_in) => replacement.replace(&path, &name, &built_in)?,
            None => replacement.warnings.push(unknown(&path, &replacement.registry)),
        }
    }
    if replacement.files.is_empty() {
        let message = format!("{}: no file has the name of a kernel; the built-in ones are used", folder.display());
        replacement.warnings.push(message);
    }
    Ok(replacement)
}

impl Replacement {
    /// Names of the replacing files that a render with this back end uses.
    pub fn files_of(&self, back_end: BackEnd) -> Vec<&str> {
        let used: Vec<_> = self.registry.kernels(back_end).iter().map(|kernel| kernel.file).collect();
        self.files.iter().map(String::as_str).filter(|file| used.contains(file)).collect()
    }

    fn replace(&mut self, path: &Path, name: &str, built_in: &KernelSource) -> Result<()> {
        let spirv = inputs::read(path, MAX_BYTES)?;
        self.check(path, &spirv, built_in)?;
        for kernels in self.registry.all_mut() {
            for kernel in kernels.iter_mut().filter(|kernel| kernel.file == name) {
                kernel.spirv = Cow::Owned(spirv.clone());
            }
        }
        self.files.push(name.to_owned());
        Ok(())
    }

    fn check(&mut self, path: &Path, spirv: &[u8], built_in: &KernelSource) -> Result<()> {
        // `inspect --out` writes all kernels, of which most are not edited.
        if *spirv == *built_in.spirv {
            return Ok(());
        }
        let refused = |message: String| Error::kernel(path, message);
        let module = Module::parse(spirv).map_err(refused)?;
        match tools::validate(module.words()) {
            Ok(()) => {}
            Err(ToolFault::Failed(message)) => return Err(refused(format!("it is not valid SPIR-V: {message}"))),
            Err(ToolFault::Missing) => {
                let path = path.display();
                self.warnings
                    .push(format!("{path}: not validated, so a mistake may crash the driver: {}", ToolFault::Missing));
            }
        }
        let mut own = Module::parse(&built_in.spirv).and_then(|module| Interface::of(&module)).map_err(refused)?;
        // Every variant has one workgroup size, which a file may contain as a plain number.
        own.set_values(&Variant::default().entries());
        let given = Interface::of(&module).map_err(refused)?;
        let differences = own.differences(&given);
        if !differences.is_empty() {
            let message = format!("its interface is not that of the built-in kernel: {}", differences.join("; "));
            return Err(refused(message));
        }
        self.warnings.extend(frozen(path, &own, &given));
        Ok(())
    }
}

/// Warning about constants that are missing from the file, so that options cannot set them; `None` where it has all.
fn frozen(path: &Path, own: &Interface, given: &Interface) -> Option<String> {
    let is_gone = |id: u32| given.constants.iter().all(|constant| constant.id != id);
    let gone: Vec<_> = own.constants.iter().filter(|c| is_gone(c.id)).map(|c| c.name.as_str()).collect();
    let path = path.display();
    let list = gone.join(", ");
    (!gone.is_empty()).then(|| {
        format!("{path}: options and scene do not change these constants, which are fixed in the file: {list}")
    })
}

fn built_in(registry: &Registry, file: &str) -> Option<KernelSource> {
    let mut all = BackEnd::ALL.into_iter().flat_map(|back_end| registry.kernels(back_end).iter());
    all.find(|kernel| kernel.file == file).cloned()
}

fn unknown(path: &Path, registry: &Registry) -> String {
    let all = BackEnd::ALL.into_iter().flat_map(|back_end| registry.kernels(back_end).iter());
    let mut names: Vec<_> = all.map(|kernel| kernel.file).collect();
    names.sort_unstable();
    names.dedup();
    format!("{}: no kernel has this name, so it is not used; the names are {}", path.display(), names.join(", "))
}

fn file_names(folder: &Path) -> Result<Vec<String>> {
    let entries = fs::read_dir(folder).map_err(Error::read(folder))?;
    let names = entries.map(|entry| Ok(entry.map_err(Error::read(folder))?.file_name().to_string_lossy().into_owned()));
    let mut names = names.collect::<Result<Vec<_>>>()?;
    names.sort();
    Ok(names)
}

#[cfg(test)]
mod tests {
    use rspirv::binary::Assemble;
    use rspirv::dr::{self, Instruction, Operand};
    use rspirv::grammar::INSTRUCTION_TABLE;
    use rspirv::spirv::{Decoration, Op};

    use super::*;

    /// The texel-buffer path tracer, edited.
    fn edited(edit: impl Fn(&mut dr::Module)) -> Vec<u8> {
        let mut module = dr::load_bytes(&Registry::built_in().texel.trace.spirv).expect("SPIR-V");
        edit(&mut module);
        module.assemble().iter().flat_map(|word| word.to_le_bytes()).collect()
    }

    /// The texel-buffer path tracer with every decoration of one kind and value changed.
    fn redecorated(decoration: Decoration, from: u32, to: u32) -> Vec<u8> {
        let is_it = |i: &Instruction| {
            i.operands.contains(&Operand::Decoration(decoration))
                && i.operands.last() == Some(&Operand::LiteralBit32(from))
        };
        edited(|module| {
            for i in module.annotations.iter_mut().filter(|i| is_it(i)) {
                i.operands.pop();
                i.operands.push(Operand::LiteralBit32(to));
            }
        })
    }

    fn load_one(name: &str, spirv: &[u8]) -> Result<Replacement> {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join(name), spirv).expect("a file");
        load(folder.path())
    }

    fn refusal(spirv: &[u8]) -> String {
        load_one("trace.texel.spv", spirv).expect_err("a refusal").to_string()
    }

    #[test]
    fn the_same_kernel_is_taken_for_its_own_back_end() {
        let taken = load_one("trace.texel.spv", &edited(|_| {})).expect("the same interface");
        assert_eq!(taken.files_of(BackEnd::Texel), ["trace.texel.spv"]);
        assert!(taken.files_of(BackEnd::Storage).is_empty() && taken.warnings.is_empty(), "{:?}", taken.warnings);
    }

    #[test]
    fn a_kernel_of_both_back_ends_is_taken_for_both() {
        let spirv = Registry::built_in().texel.update_radiance.spirv;
        let taken = load_one("update_radiance.spv", &spirv).expect("the same interface");
        let of = |back_end| taken.files_of(back_end).len();
        assert_eq!((of(BackEnd::Texel), of(BackEnd::Storage)), (1, 1));
        assert!(matches!(taken.registry.storage.update_radiance.spirv, Cow::Owned(_)));
    }

    #[test]
    fn another_binding_is_refused() {
        let message = refusal(&redecorated(Decoration::Binding, 0, 77));
        assert!(message.contains("set 0, binding 77 (`FilmRadiancePage`) is not among the bindings"), "{message}");
        let message = refusal(&redecorated(Decoration::Binding, 0, 2));
        let words = "set 0, binding 2 (`FilmRadiancePage`) is a storage buffer, not a uniform buffer";
        assert!(message.contains(words), "{message}");
    }

    #[test]
    fn another_layout_is_refused() {
        let message = refusal(&redecorated(Decoration::ArrayStride, 32, 48));
        assert!(message.contains("`film_radiance` is a struct at offset 0, stride 48, not a struct"), "{message}");
        let message = refusal(&redecorated(Decoration::Offset, 40, 44));
        assert!(message.contains("it takes 60 bytes of push constants, not 56"), "{message}");
    }

    #[test]
    fn another_constant_is_refused_and_a_missing_one_is_told() {
        let message = refusal(&redecorated(Decoration::SpecId, 9, 99));
        assert!(message.contains("specialization constant 99 (`MAX_TRIES`) is not among"), "{message}");
        // Does the same as spirv-opt with --freeze-spec-const.
        let id = [Operand::Decoration(Decoration::SpecId), Operand::LiteralBit32(9)];
        let frozen = edited(|module| {
            let place = module.annotations.iter().position(|i| i.operands.ends_with(&id)).expect("MAX_TRIES");
            let target = module.annotations.remove(place).operands[0].id_ref_any();
            let constant = module.types_global_values.iter_mut().find(|i| i.result_id == target).expect("MAX_TRIES");
            constant.class = INSTRUCTION_TABLE.get(Op::Constant);
        });
        let taken = load_one("trace.texel.spv", &frozen).expect("less is no harm");
        assert!(taken.warnings.concat().contains("which are fixed in the file: MAX_TRIES"), "{:?}", taken.warnings);
    }

    #[test]
    fn what_is_no_module_is_refused() {
        let spirv = Registry::built_in().texel.trace.spirv;
        for (bytes, word) in [
            (&b"; SPIR-V"[..], "spirv-as"),
            (&spirv[..spirv.len() - 3], "spirv-as"),
            (&spirv[..spirv.len() / 2 / 4 * 4], "valid SPIR-V"),
            (&[], "spirv-as"),
        ] {
            let message = refusal(bytes);
            assert!(message.contains(word) && message.contains("trace.texel.spv: "), "{message}");
        }
    }

    #[test]
    fn other_files_are_passed_over_with_a_word() {
        let taken = load_one("trace.spvasm", b"").expect("no kernel");
        assert!(taken.files.is_empty() && taken.warnings[0].contains("no file has the name of a kernel"));
        let taken = load_one("path_tracer.spv", b"").expect("no kernel");
        assert!(
            taken.warnings[0].contains(
                "the names are blend_radiance.spv, first_hits.query.spv, first_hits.spv, first_hits.texel.spv, \
                 judge_noise.spv, pool_radiance.spv"
            ),
            "{:?}",
            taken.warnings
        );
        assert!(matches!(load(Path::new("/nowhere")), Err(Error::Read { .. })));
    }
}
