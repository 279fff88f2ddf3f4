//! Kernels that many scenes share. A renderer compiles its kernels for the features of its scene, which takes about a second.
//! Here a group of scenes gets one set of kernels, which have the features of all scenes of the group.

use std::borrow::Cow;
use std::collections::HashMap;

use lodestar::generated::kernels::{Kernels, Registry, Variant};
use lodestar::gpu::KernelSource;

/// The variant without the features that a group may join. Scenes whose rests are equal may share kernels.
pub fn rest(variant: &Variant) -> Variant {
    Variant {
        stack_size: 0,
        has_spheres: false,
        has_vertex_normals: false,
        has_front_only: false,
        has_unseen: false,
        material_kinds: 0,
        surface_features: 0,
        texture_kinds: 0,
        textured_parameters: 0,
        max_texture_links: 0,
        texel_pages: 0,
        light_kinds: 0,
        ..*variant
    }
}

/// Variant with the features of both, whose rests are equal.
pub fn joined(a: &Variant, b: &Variant) -> Variant {
    assert_eq!(rest(a), rest(b));
    Variant {
        stack_size: a.stack_size.max(b.stack_size),
        has_spheres: a.has_spheres | b.has_spheres,
        has_vertex_normals: a.has_vertex_normals | b.has_vertex_normals,
        has_front_only: a.has_front_only | b.has_front_only,
        has_unseen: a.has_unseen | b.has_unseen,
        material_kinds: a.material_kinds | b.material_kinds,
        surface_features: a.surface_features | b.surface_features,
        texture_kinds: a.texture_kinds | b.texture_kinds,
        textured_parameters: a.textured_parameters | b.textured_parameters,
        max_texture_links: a.max_texture_links.max(b.max_texture_links),
        texel_pages: a.texel_pages.max(b.texel_pages),
        light_kinds: a.light_kinds | b.light_kinds,
        ..*a
    }
}

/// Kernels in which the variant is fixed. A renderer of any scene then builds the same pipelines.
pub fn fixed(variant: &Variant) -> Registry {
    let values: HashMap<u32, u32> = variant.entries().into_iter().collect();
    let mut registry = Registry::built_in();
    for kernel in registry.all_mut().into_iter().flat_map(Kernels::iter_mut) {
        *kernel = KernelSource {
            spirv: Cow::Owned(with_constants(&kernel.spirv, &values)),
            specialization_ids: &[],
            ..kernel.clone()
        };
    }
    registry
}

const HEADER_WORDS: usize = 5;
const OP_DECORATE: u32 = 71;
const DECORATION_SPEC_ID: u32 = 1;
/// Operations of a specialization constant that is true, false or a number, and of a constant.
const OP_SPEC_CONSTANT_TRUE: u32 = 48;
const OP_SPEC_CONSTANT_FALSE: u32 = 49;
const OP_SPEC_CONSTANT: u32 = 50;
const OP_CONSTANT_TRUE: u32 = 41;
const OP_CONSTANT_FALSE: u32 = 42;
const OP_CONSTANT: u32 = 43;

/// SPIR-V whose specialization constants are constants, with `values` by constant id.
fn with_constants(spirv: &[u8], values: &HashMap<u32, u32>) -> Vec<u8> {
    let words: Vec<u32> = spirv.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    let mut result = words[..HEADER_WORDS].to_vec();
    // Value of each constant by its result id. Decorations come before what they decorate.
    let mut decorated = HashMap::new();
    let mut at = HEADER_WORDS;
    while at < words.len() {
        let (length, operation) = ((words[at] >> 16) as usize, words[at] & 0xffff);
        let instruction = &words[at..at + length];
        at += length;
        if operation == OP_DECORATE && instruction[2] == DECORATION_SPEC_ID {
            decorated.insert(instruction[1], values[&instruction[3]]);
            continue;
        }
        let value = instruction.get(2).and_then(|id| decorated.get(id)).copied();
        match (operation, value) {
            (OP_SPEC_CONSTANT_TRUE | OP_SPEC_CONSTANT_FALSE, Some(value)) => {
                let operation = if value == 0 { OP_CONSTANT_FALSE } else { OP_CONSTANT_TRUE };
                result.extend([3 << 16 | operation, instruction[1], instruction[2]]);
            }
            (OP_SPEC_CONSTANT, Some(value)) => {
                result.extend([4 << 16 | OP_CONSTANT, instruction[1], instruction[2], value])
            }
            _ => result.extend(instruction),
        }
    }
    result.into_iter().flat_map(u32::to_le_bytes).collect()
}
