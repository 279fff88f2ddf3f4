//! What a compiled kernel asks of its pipeline: plain data, written by `build.rs` from the reflected SPIR-V.

use std::borrow::Cow;

/// What a binding of a descriptor set holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BindingKind {
    /// A storage buffer.
    StorageBuffer,
    /// A small buffer that is the same for every invocation.
    UniformBuffer,
    /// A read-only texel buffer of four 32-bit floats (`samplerBuffer`).
    TexelBufferFloat,
    /// A read-only texel buffer of 32-bit unsigned integers, four or one to a texel (`usamplerBuffer`).
    TexelBufferUint,
}

/// One binding of a descriptor set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BindingShape {
    /// Its number.
    pub binding: u32,
    /// What it holds.
    pub kind: BindingKind,
    /// Its name in the GLSL.
    pub name: &'static str,
}

/// One descriptor set: its bindings in ascending order of their numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SetShape {
    /// The set's number.
    pub set: u32,
    /// Its bindings; empty where no kernel of the family uses the set.
    pub bindings: &'static [BindingShape],
}

/// One kernel: a compute shader with its interface.
#[derive(Debug, Clone)]
pub struct KernelSource {
    /// The `.comp` file's stem: also the pipeline's label and the timestamp's.
    pub name: &'static str,
    /// The name of the SPIR-V's file, which tells apart the back ends of one kernel.
    pub file: &'static str,
    /// The SPIR-V, little-endian words.
    pub spirv: Cow<'static, [u8]>,
    /// Shapes of sets 0, 1, 2, ... of the pipeline layout, without gaps.
    pub sets: &'static [SetShape],
    /// Size of the push-constant block in bytes, a multiple of 4; 0 where there is none.
    pub push_constant_bytes: u32,
    /// Ids of the specialization constants that the kernel uses, ascending.
    pub specialization_ids: &'static [u32],
}
