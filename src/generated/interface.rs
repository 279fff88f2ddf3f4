//! Interface of a compiled kernel: plain data that `build.rs` writes from the reflected SPIR-V.

use std::borrow::Cow;

/// Kinds of a descriptor set's bindings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BindingKind {
    /// Storage buffer.
    StorageBuffer,
    /// Small buffer that is equal for every invocation.
    UniformBuffer,
    /// Read-only texel buffer of four 32-bit floats (`samplerBuffer`).
    TexelBufferFloat,
    /// Read-only texel buffer of 32-bit unsigned integers, four or one per texel (`usamplerBuffer`).
    TexelBufferUint,
    /// Acceleration structure, which ray queries traverse.
    AccelerationStructure,
}

/// One binding of a descriptor set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BindingShape {
    /// Number of the binding.
    pub binding: u32,
    /// Kind of the binding.
    pub kind: BindingKind,
    /// Name in the GLSL.
    pub name: &'static str,
}

/// One descriptor set with its bindings, sorted by number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SetShape {
    /// Number of the set.
    pub set: u32,
    /// Bindings of the set; empty where no kernel of the family uses it.
    pub bindings: &'static [BindingShape],
}

/// Compute shader with its interface.
#[derive(Debug, Clone)]
pub struct KernelSource {
    /// Stem of the `.comp` file, also the label of the pipeline and of its timings.
    pub name: &'static str,
    /// Name of the SPIR-V file, which distinguishes the back ends of one kernel.
    pub file: &'static str,
    /// SPIR-V as little-endian words.
    pub spirv: Cow<'static, [u8]>,
    /// Shapes of sets 0, 1, 2, ... of the pipeline layout, without gaps.
    pub sets: &'static [SetShape],
    /// Size of the push-constant block in bytes, a multiple of 4; 0 where there is none.
    pub push_constant_bytes: u32,
    /// Ids of the specialization constants that the kernel uses, ascending.
    pub specialization_ids: &'static [u32],
}
