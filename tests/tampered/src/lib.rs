//! Kernels of Lodestar with known faults, and with changes that must not matter. The shipped GLSL has neither: the
//! build script patches a copy of it.

mod mutations;

pub use mutations::{MUTATIONS, Mutation};

include!(concat!(env!("OUT_DIR"), "/kernels.rs"));

const CONSTANT_ID: u32 = 2000;
const OP_SPEC_CONSTANT: u32 = 50;
const OP_DECORATE: u32 = 71;
const DECORATION_SPEC_ID: u32 = 1;
const HEADER_WORDS: usize = 5;

/// The SPIR-V of a kernel, by its name, with the named mutation in it.
///
/// # Panics
/// Where there is no kernel or no mutation of that name.
pub fn kernel(name: &str, mutation: &str) -> Vec<u8> {
    let (_, spirv) = KERNELS.iter().find(|(own, _)| *own == name).unwrap_or_else(|| panic!("no kernel {name}"));
    let number = MUTATIONS.iter().position(|m| m.name == mutation).unwrap_or_else(|| panic!("no mutation {mutation}"));
    let mut words: Vec<u32> = spirv.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    choose(&mut words, number as u32 + 1);
    words.into_iter().flat_map(u32::to_le_bytes).collect()
}

/// Names of all kernels.
pub fn kernel_names() -> impl Iterator<Item = &'static str> {
    KERNELS.iter().map(|(name, _)| *name)
}

/// Sets the constant's default to `value`, if the module has the constant.
fn choose(words: &mut [u32], value: u32) {
    let mut constant = None;
    let mut at = HEADER_WORDS;
    // Decorations come before what they decorate.
    while at < words.len() {
        let (length, operation) = ((words[at] >> 16) as usize, words[at] & 0xffff);
        if operation == OP_DECORATE && words[at + 2] == DECORATION_SPEC_ID && words[at + 3] == CONSTANT_ID {
            constant = Some(words[at + 1]);
        }
        if operation == OP_SPEC_CONSTANT && Some(words[at + 2]) == constant {
            words[at + 3] = value;
        }
        at += length;
    }
}
