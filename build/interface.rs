//! Reflection of SPIR-V: the interface that a kernel demands of its pipeline, and the memory layout of its structs.

use std::collections::BTreeMap;

use spirq::prelude::*;
use spirq::ty::{DescriptorType, ScalarType, Type};
use spirq::var::Variable;

/// Bindings of a kernel: the kind (a variant of `BindingKind`) and the GLSL name, by (set, binding).
pub type Bindings = BTreeMap<(u32, u32), (&'static str, String)>;
/// Layout of a struct in a buffer: its size in bytes, and its members with their offsets.
pub type StructLayout = (usize, Vec<(String, usize)>);

/// Interface of one SPIR-V module.
pub struct Interface {
    /// Bindings.
    pub bindings: Bindings,
    /// Size of the push constants, in bytes.
    pub push_constant_bytes: usize,
    /// Ids of the specialization constants, ascending.
    pub specialization_ids: Vec<u32>,
    /// Structs within buffers and push constants, by name.
    pub structs: BTreeMap<String, StructLayout>,
}

impl Interface {
    /// Reflects a SPIR-V module.
    pub fn reflect(spirv: &[u8]) -> Result<Self, String> {
        let reflected = ReflectConfig::new().spv(spirv).reflect().map_err(|e| format!("cannot be reflected: {e}"))?;
        let vars = reflected.into_iter().next().ok_or("no entry point")?.vars;
        let mut interface = Self {
            bindings: bindings(&vars)?,
            push_constant_bytes: 0,
            // Every kernel has the constant 0, the workgroup size.
            specialization_ids: vec![0],
            structs: BTreeMap::new(),
        };
        for var in &vars {
            match var {
                Variable::SpecConstant { spec_id, .. } => interface.specialization_ids.push(*spec_id),
                Variable::PushConstant { ty, .. } => {
                    interface.push_constant_bytes = interface.push_constant_bytes.max(ty.nbyte().unwrap_or(0));
                    collect_structs(ty, None, true, &mut interface.structs);
                }
                Variable::Descriptor { ty, .. } => collect_structs(ty, None, true, &mut interface.structs),
                _ => {}
            }
        }
        interface.specialization_ids.sort_unstable();
        interface.specialization_ids.dedup();
        Ok(interface)
    }
}

fn bindings(vars: &[Variable]) -> Result<Bindings, String> {
    let mut bindings = Bindings::new();
    for var in vars {
        let Variable::Descriptor { name, desc_bind, desc_ty, ty, .. } = var else { continue };
        let kind =
            binding_kind(desc_ty, ty).ok_or_else(|| format!("{name:?} is of an unsupported kind {desc_ty:?}"))?;
        let name = name.clone().filter(|n| !n.is_empty()).unwrap_or_else(|| struct_name(ty));
        bindings.insert(desc_bind.into_inner(), (kind, name));
    }
    Ok(bindings)
}

fn binding_kind(kind: &DescriptorType, ty: &Type) -> Option<&'static str> {
    match kind {
        DescriptorType::StorageBuffer(_) => Some("StorageBuffer"),
        DescriptorType::UniformBuffer() => Some("UniformBuffer"),
        DescriptorType::AccelStruct() => Some("AccelerationStructure"),
        DescriptorType::UniformTexelBuffer() => match ty {
            Type::CombinedImageSampler(image) => texel_kind(&image.sampled_image_ty.scalar_ty),
            Type::SampledImage(image) => texel_kind(&image.scalar_ty),
            _ => None,
        },
        _ => None,
    }
}

fn texel_kind(scalar: &ScalarType) -> Option<&'static str> {
    match scalar {
        ScalarType::Integer { is_signed: false, .. } => Some("TexelBufferUint"),
        ScalarType::Float { .. } => Some("TexelBufferFloat"),
        _ => None,
    }
}

fn struct_name(ty: &Type) -> String {
    match ty {
        Type::Struct(s) => s.name.clone().unwrap_or_default(),
        _ => String::new(),
    }
}

fn collect_structs(ty: &Type, stride: Option<usize>, is_block: bool, structs: &mut BTreeMap<String, StructLayout>) {
    match ty {
        Type::Array(array) => collect_structs(&array.element_ty, array.stride, false, structs),
        Type::Struct(s) => {
            for member in &s.members {
                collect_structs(&member.ty, None, false, structs);
            }
            if !is_block {
                let size = stride.or_else(|| ty.nbyte()).unwrap_or(0);
                let members = s.members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset.unwrap_or(0)));
                structs.insert(s.name.clone().unwrap_or_default(), (size, members.collect()));
            }
        }
        _ => {}
    }
}
