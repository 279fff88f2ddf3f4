//! Removal of code that a variant never reaches, before a driver sees the kernel.
//!
//! Vulkan leaves it to drivers to fold specialization constants, and most do. SwiftShader also translates every branch
//! that is not taken: the path tracer of a plain scene then takes ten minutes and 10 GB of memory instead of a second.
//! So branches that constants decide are decided here. Code that is reached is not altered: constants and arithmetic
//! are left to the driver.

mod blocks;
mod code;
mod compact;
mod values;

use std::collections::HashMap;

use rspirv::spirv::{Decoration, Op, Word};

use code::{Instruction, Module, is};
use compact::compact;
use values::Values;

/// Words that a driver gets for a kernel with these constants, given as (id, bits): without the code that they leave out, and without
/// gaps in the numbers of ids. `None` where the module cannot be read, which the driver will report.
pub fn specialized(words: &[Word], constants: &[(u32, u32)]) -> Option<Vec<Word>> {
    let resolved = resolve_branches(words, constants)?;
    Some(compact(&resolved).unwrap_or(resolved))
}

/// Decides every branch that the constants, given as (id, bits), decide, and removes blocks that are then unreachable.
/// Returns the words of the new module; `None` where the module cannot be read, which the driver will report.
fn resolve_branches(words: &[Word], constants: &[(u32, u32)]) -> Option<Vec<Word>> {
    let mut module = Module::parse(words)?;
    let spec_ids = spec_ids(&module.globals);
    let constants: HashMap<u32, u32> = constants.iter().copied().collect();
    let mut bound = *module.bound();
    let globals = Values::of_globals(&module.globals, bound, |id| constants.get(spec_ids.get(&id)?).copied());
    let mut undefined = Vec::new();
    for function in &mut module.functions {
        // Removing a branch may leave a phi with a single value, which may decide another branch.
        while blocks::decide(function, &globals) {
            undefined.extend(blocks::remove_unreachable(function, &mut bound));
        }
    }
    module.globals.extend(undefined);
    *module.bound() = bound;
    forget_removed(&mut module);
    Some(module.assemble())
}

/// Specialization constant ids by result id.
fn spec_ids(globals: &[Instruction]) -> HashMap<Word, u32> {
    let of = |code: &Instruction| match code[1..] {
        [target, decoration, id] if is(code, Op::Decorate) && decoration == Decoration::SpecId as u32 => {
            Some((target, id))
        }
        _ => None,
    };
    globals.iter().filter_map(of).collect()
}

/// Drops names and decorations of removed ids.
fn forget_removed(module: &mut Module) {
    let defined = module.defined();
    let is_removed = |id: Word| !defined.get(id as usize).copied().unwrap_or(false);
    module.globals.retain(|code| {
        let is_about_an_id =
            [Op::Name, Op::Decorate, Op::DecorateId, Op::DecorateString].iter().any(|&op| is(code, op));
        !is_about_an_id || code.get(1).is_none_or(|&id| !is_removed(id))
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generated::interface::KernelSource;
    use crate::generated::kernels::{BackEnd, Registry, Variant};
    use crate::spirv::tools::{self, ToolFault};
    use rspirv::dr::load_words;

    fn words(source: &KernelSource) -> Vec<u32> {
        source.spirv.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
    }

    fn block_count(words: &[u32]) -> usize {
        load_words(words).expect("SPIR-V").functions.iter().map(|function| function.blocks.len()).sum()
    }

    /// Variants with the features of a plain scene, of a rich scene, with every other kind, and with all kinds.
    fn variants() -> [Variant; 4] {
        let rich = Variant { sampler: 1, nee: true, ..Variant::default() };
        let all = |mask| Variant { material_kinds: mask, light_kinds: mask, texture_kinds: mask, ..rich };
        [Variant::default(), rich, all(0x155), all(!0)]
    }

    #[test]
    fn what_is_left_is_valid_and_smaller() {
        let registry = Registry::built_in();
        for source in BackEnd::ALL.into_iter().flat_map(|back_end| registry.kernels(back_end).iter()) {
            let before = words(source);
            for variant in variants() {
                let after = specialized(&before, &variant.entries()).expect("SPIR-V");
                let ids = Module::parse(&after).expect("SPIR-V").defined().iter().filter(|defined| **defined).count();
                assert_eq!(
                    after[code::BOUND] as usize,
                    ids + 1,
                    "{}: each number below the bound is an id",
                    source.file
                );
                let counts = [&before, &after].map(|words| block_count(words));
                println!("{}: {} blocks, {} left", source.file, counts[0], counts[1]);
                assert!(counts[1] <= counts[0]);
                match tools::validate(&after) {
                    Ok(()) => {}
                    Err(ToolFault::Failed(message)) => panic!("{}: {message}", source.file),
                    Err(missing) => println!("not validated: {missing}"),
                }
            }
        }
        let plain = resolve_branches(&words(&registry.texel.trace), &Variant::default().entries());
        let [all, left] = [words(&registry.texel.trace), plain.expect("SPIR-V")].map(|words| block_count(&words));
        assert!(left * 4 < all, "{left} of {all} blocks are left of the simplest path tracer");
    }

    #[test]
    fn a_second_time_changes_nothing() {
        let constants = Variant::default().entries();
        let once = specialized(&words(&Registry::built_in().texel.trace), &constants).expect("SPIR-V");
        assert!(specialized(&once, &constants).expect("SPIR-V") == once);
    }

    #[test]
    fn an_unknown_instruction_keeps_its_ids() {
        let mut words = words(&Registry::built_in().texel.judge_noise);
        let resolved = |words: &[u32]| resolve_branches(words, &[]).expect("SPIR-V");
        assert!(specialized(&words, &[]).expect("SPIR-V")[code::BOUND] <= resolved(&words)[code::BOUND]);
        // No operation has this number.
        words.splice(5..5, [1 << 16 | 0xfffe]);
        assert!(specialized(&words, &[]).expect("SPIR-V") == resolved(&words));
    }

    #[test]
    fn what_is_no_module_is_left_to_the_driver() {
        assert_eq!(resolve_branches(&[1, 2, 3], &[]), None);
        let whole = words(&Registry::built_in().texel.judge_noise);
        let constants = Variant::default().entries();
        // The end of the last function is missing everywhere.
        for end in 0..whole.len() {
            assert_eq!(resolve_branches(&whole[..end], &constants), None, "{end} words");
        }
        // An instruction of another length or kind is no module, or a module that the driver will refuse.
        for place in 5..whole.len() {
            for fault in [0, 1 << 16, 3 << 16 | 245, 1 << 16 | 246, u32::MAX] {
                let mut changed = whole.clone();
                changed[place] = fault;
                resolve_branches(&changed, &constants);
            }
        }
        let mut boundless = whole;
        boundless[3] = u32::MAX;
        assert_eq!(resolve_branches(&boundless, &constants), None);
    }
}
