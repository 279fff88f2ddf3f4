//! Interface of a kernel, reflected from its SPIR-V.

use rspirv::dr::{Instruction, Operand};
use rspirv::spirv::{BuiltIn, Decoration, Op};
use serde::Serialize;
use serde_json::{Value, json};
use spirq::prelude::ReflectConfig;
use spirq::ty::{AccessType, DescriptorType, ScalarType, Type, VectorType};
use spirq::var::Variable;

use crate::spirv::module::{Module, literal, operand_id};

/// Bindings, push constants and specialization constants of a kernel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Interface {
    /// Name of the function that a dispatch calls.
    pub entry_point: String,
    /// Invocations of a workgroup along each axis.
    pub workgroup_size: [Dimension; 3],
    /// Bindings that the kernel uses, sorted by set and number.
    pub bindings: Vec<Binding>,
    /// The push-constant block; `None` where there is none.
    pub push_constants: Option<Layout>,
    /// Specialization constants, sorted by id.
    pub constants: Vec<SpecConstant>,
}

/// One axis of the workgroup size.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Dimension {
    /// Number of invocations; where a constant chooses them, its value.
    pub value: u32,
    /// Id of the specialization constant that chooses the number.
    pub constant: Option<u32>,
}

/// One binding.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Binding {
    /// Number of the set.
    pub set: u32,
    /// Number of the binding within the set.
    pub binding: u32,
    /// Name in the GLSL, or of the block.
    pub name: String,
    /// Kind of the binding, in words.
    pub kind: String,
    /// Whether the kernel may read, write, or both.
    pub access: &'static str,
    /// Layout of the buffer's content; `None` for texel buffers.
    pub layout: Option<Layout>,
}

/// Layout of a block.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Layout {
    /// Size in bytes; `None` where the block ends in an array of any length.
    pub bytes: Option<usize>,
    /// Members in order.
    pub members: Vec<Member>,
}

/// Member of a block or of a struct.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Member {
    /// Name in the GLSL.
    pub name: String,
    /// Type as GLSL spells it.
    #[serde(rename = "type")]
    pub type_name: String,
    /// Offset in bytes from the begin of the enclosing block or struct.
    pub offset: usize,
    /// Size in bytes; `None` for an array of any length.
    pub bytes: Option<usize>,
    /// Stride in bytes from one element of an array, or column of a matrix, to the next.
    pub stride: Option<usize>,
    /// Members of a struct, or of an array's element type.
    pub members: Vec<Member>,
}

/// Specialization constant of a kernel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpecConstant {
    /// Id of the constant.
    pub id: u32,
    /// Name in the GLSL.
    pub name: String,
    /// Type as GLSL spells it.
    #[serde(rename = "type")]
    pub type_name: &'static str,
    /// Value where none is given.
    pub default: Value,
    /// Value in the current variant.
    pub value: Value,
}

impl Interface {
    /// Reflects a module. The error says what cannot be read.
    pub fn of(module: &Module) -> Result<Self, String> {
        let vars = reflect(module)?;
        let mut bindings: Vec<_> = vars.iter().filter_map(binding).collect();
        bindings.sort_by_key(|b| (b.set, b.binding));
        let mut constants: Vec<_> =
            module.parsed.types_global_values.iter().filter_map(|i| spec_constant(module, i)).collect();
        // The workgroup size has two constants of one id: GLSL's own, and the one that the GLSL names.
        constants.sort_by_key(|c| (c.id, c.name.is_empty()));
        constants.dedup_by_key(|c| c.id);
        Ok(Self {
            entry_point: entry_point_name(module)?,
            workgroup_size: workgroup_size(module)?,
            bindings,
            push_constants: vars.iter().find_map(push_constants),
            constants,
        })
    }

    /// Gives constants the values of a variant, as (id, bits).
    pub fn set_values(&mut self, values: &[(u32, u32)]) {
        let given = |id: u32| values.iter().find(|(given, _)| *given == id).map(|&(_, bits)| bits);
        for constant in &mut self.constants {
            if let Some(bits) = given(constant.id) {
                constant.value = value(constant.type_name, bits);
            }
        }
        for dimension in &mut self.workgroup_size {
            dimension.value = dimension.constant.and_then(given).unwrap_or(dimension.value);
        }
    }

    /// Differences of `other` that break a pipeline made for `self`, one clause each. Names and the values of constants
    /// are not compared, and `other` may use less.
    pub fn differences(&self, other: &Self) -> Vec<String> {
        let mut found = Vec::new();
        if self.entry_point != other.entry_point {
            found.push(format!("its entry point is `{}`, not `{}`", other.entry_point, self.entry_point));
        }
        found.extend(self.workgroup_difference(other));
        found.extend(other.bindings.iter().filter_map(|binding| self.binding_difference(binding)));
        found.extend(self.push_constant_difference(other));
        found.extend(other.constants.iter().filter_map(|constant| self.constant_difference(constant)));
        found
    }

    fn workgroup_difference(&self, other: &Self) -> Option<String> {
        let fits = |(a, b): (&Dimension, &Dimension)| match (a.constant, b.constant) {
            (Some(a), Some(b)) => a == b,
            (_, None) => a.value == b.value,
            (None, Some(_)) => false,
        };
        let same = self.workgroup_size.iter().zip(&other.workgroup_size).all(fits);
        let text = |i: &Self| i.workgroup_size.map(|d| d.to_string()).join(" x ");
        (!same).then(|| format!("its workgroups are {}, not {}", text(other), text(self)))
    }

    fn binding_difference(&self, other: &Binding) -> Option<String> {
        let place = format!("set {}, binding {} (`{}`)", other.set, other.binding, other.name);
        let same = self.bindings.iter().find(|b| (b.set, b.binding) == (other.set, other.binding));
        let Some(same) = same else { return Some(format!("{place} is not among the bindings of the built-in kernel")) };
        if same.kind != other.kind {
            return Some(format!("{place} is a {}, not a {}", other.kind, same.kind));
        }
        let clause = layout_difference(same.layout.as_ref(), other.layout.as_ref())?;
        Some(format!("{place}: {clause}"))
    }

    fn push_constant_difference(&self, other: &Self) -> Option<String> {
        let given = other.push_constants.as_ref()?;
        let Some(own) = &self.push_constants else { return Some("it takes push constants".into()) };
        if own.bytes != given.bytes {
            let bytes = |layout: &Layout| layout.bytes.unwrap_or_default();
            return Some(format!("it takes {} bytes of push constants, not {}", bytes(given), bytes(own)));
        }
        layout_difference(Some(own), Some(given)).map(|clause| format!("push constants: {clause}"))
    }

    fn constant_difference(&self, other: &SpecConstant) -> Option<String> {
        let SpecConstant { id, name, type_name, .. } = other;
        match self.constants.iter().find(|c| c.id == *id) {
            None => Some(format!("specialization constant {id} (`{name}`) is not among those of the built-in kernel")),
            Some(own) if own.type_name != *type_name => {
                Some(format!("specialization constant {id} (`{name}`) is a {type_name}, not a {}", own.type_name))
            }
            Some(_) => None,
        }
    }
}

impl std::fmt::Display for Dimension {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self.constant {
            Some(id) => write!(f, "{} (constant {id})", self.value),
            None => self.value.fmt(f),
        }
    }
}

/// First difference between two layouts, as a clause; `None` where they agree.
fn layout_difference(own: Option<&Layout>, other: Option<&Layout>) -> Option<String> {
    let lines = |layout: Option<&Layout>| {
        let mut lines = Vec::new();
        layout.iter().for_each(|layout| flatten(&layout.members, "", &mut lines));
        lines
    };
    let (own, other) = (lines(own), lines(other));
    if own.len() != other.len() {
        return Some(format!("it has {} members, not {}", other.len(), own.len()));
    }
    let differing = own.iter().zip(&other).find(|(a, b)| a.1 != b.1)?;
    let ((_, own), (name, other)) = differing;
    Some(format!("`{name}` is {other}, not {own}"))
}

/// Pairs of every member's name and of its type with offset. Nested members follow the member that holds them.
fn flatten(members: &[Member], prefix: &str, lines: &mut Vec<(String, String)>) {
    for member in members {
        let name = format!("{prefix}{}", member.name);
        let stride = member.stride.map(|stride| format!(", stride {stride}")).unwrap_or_default();
        let bytes = member.bytes.map(|bytes| format!(", {bytes} bytes")).unwrap_or_default();
        // Names of structs may differ; only their members are compared.
        let ty = if member.members.is_empty() { member.type_name.as_str() } else { "a struct" };
        lines.push((name.clone(), format!("{ty} at offset {}{bytes}{stride}", member.offset)));
        flatten(&member.members, &format!("{name}."), lines);
    }
}

/// Bindings and push constants that the entry point uses.
fn reflect(module: &Module) -> Result<Vec<Variable>, String> {
    // The reflection crate panics at instructions outside its fixed list.
    let is_known = |i: &&Instruction| spirq::spirv::Op::from_u32(i.class.opcode as u32).is_none();
    if let Some(unknown) = module.parsed.all_inst_iter().find(is_known) {
        return Err(format!("Op{} is too new to be read", unknown.class.opname));
    }
    let entry_points = ReflectConfig::new().spv(module.words()).reflect();
    let entry_points = entry_points.map_err(|error| format!("its interface cannot be read: {error}"))?;
    match <[_; 1]>::try_from(entry_points) {
        Ok([entry_point]) => Ok(entry_point.vars),
        Err(entry_points) => Err(format!("it has {} entry points, but must have one", entry_points.len())),
    }
}

fn entry_point_name(module: &Module) -> Result<String, String> {
    let operands = module.parsed.entry_points.first().map(|i| i.operands.as_slice()).unwrap_or_default();
    match operands {
        [Operand::ExecutionModel(rspirv::spirv::ExecutionModel::GLCompute), _, Operand::LiteralString(name), ..] => {
            Ok(name.clone())
        }
        _ => Err("it is not a compute shader".into()),
    }
}

/// Workgroup size, from the variable that GLSL calls gl_WorkGroupSize where it is declared, else from the execution
/// mode.
fn workgroup_size(module: &Module) -> Result<[Dimension; 3], String> {
    let is_size = |operand: Option<&Operand>| operand == Some(&Operand::BuiltIn(BuiltIn::WorkgroupSize));
    let builtin = module.decorated(Decoration::BuiltIn).find(|(_, operand)| is_size(*operand));
    let parts: Option<Vec<Dimension>> = match builtin {
        Some((id, _)) => module
            .global(id)
            .and_then(|size| (0..3).map(|axis| dimension(module, operand_id(size, axis)?)).collect::<Option<Vec<_>>>()),
        None => module.parsed.execution_modes.iter().find_map(|mode| {
            let is_local_size =
                mode.operands.get(1) == Some(&Operand::ExecutionMode(rspirv::spirv::ExecutionMode::LocalSize));
            let value = |operand| Some(Dimension { value: literal(operand)?, constant: None });
            if is_local_size { mode.operands[2..].iter().map(value).collect() } else { None }
        }),
    };
    parts.and_then(|parts| parts.try_into().ok()).ok_or_else(|| "it does not say its workgroup size".into())
}

fn dimension(module: &Module, id: u32) -> Option<Dimension> {
    let value = literal(module.global(id)?.operands.first()?)?;
    Some(Dimension { value, constant: module.spec_id(id) })
}

fn binding(variable: &Variable) -> Option<Binding> {
    let Variable::Descriptor { name, desc_bind, desc_ty, ty, .. } = variable else { return None };
    let block = if let Type::Struct(block) = ty { block.name.clone() } else { None };
    let name = name.clone().filter(|name| !name.is_empty()).or(block).unwrap_or_default();
    let layout = if let Type::Struct(_) = ty { Some(layout(ty)) } else { None };
    Some(Binding {
        set: desc_bind.set(),
        binding: desc_bind.bind(),
        name,
        kind: kind(desc_ty, ty),
        access: access(desc_ty),
        layout,
    })
}

fn kind(descriptor: &DescriptorType, ty: &Type) -> String {
    match descriptor {
        DescriptorType::StorageBuffer(_) => "storage buffer".into(),
        DescriptorType::UniformBuffer() => "uniform buffer".into(),
        DescriptorType::UniformTexelBuffer() => match ty {
            Type::CombinedImageSampler(image) => texels(&image.sampled_image_ty.scalar_ty),
            Type::SampledImage(image) => texels(&image.scalar_ty),
            _ => "texel buffer".into(),
        },
        DescriptorType::AccelStruct() => "acceleration structure".into(),
        other => format!("{other:?}"),
    }
}

fn texels(scalar: &ScalarType) -> String {
    format!("texel buffer of {}", scalar_name(scalar))
}

fn access(descriptor: &DescriptorType) -> &'static str {
    match descriptor {
        DescriptorType::StorageBuffer(AccessType::ReadWrite) => "read, write",
        DescriptorType::StorageBuffer(AccessType::WriteOnly) => "write",
        _ => "read",
    }
}

fn push_constants(variable: &Variable) -> Option<Layout> {
    if let Variable::PushConstant { ty, .. } = variable { Some(layout(ty)) } else { None }
}

fn layout(ty: &Type) -> Layout {
    let members = members(ty);
    let is_open = members.last().is_some_and(|last| last.bytes.is_none());
    Layout { bytes: if is_open { None } else { ty.nbyte() }, members }
}

/// Members of a struct, or of an array's element type.
fn members(ty: &Type) -> Vec<Member> {
    match ty {
        Type::Array(array) => members(&array.element_ty),
        Type::Struct(fields) => {
            let member = |field: &spirq::ty::StructMember| Member {
                name: field.name.clone().unwrap_or_default(),
                type_name: type_name(&field.ty),
                offset: field.offset.unwrap_or_default(),
                bytes: bytes(&field.ty),
                stride: stride(&field.ty),
                members: members(&field.ty),
            };
            fields.members.iter().map(member).collect()
        }
        _ => Vec::new(),
    }
}

fn bytes(ty: &Type) -> Option<usize> {
    match ty {
        Type::Array(array) if array.nelement.is_none() => None,
        _ => ty.nbyte(),
    }
}

fn stride(ty: &Type) -> Option<usize> {
    match ty {
        Type::Array(array) => array.stride,
        Type::Matrix(matrix) => matrix.stride,
        _ => None,
    }
}

/// Type as GLSL spells it.
fn type_name(ty: &Type) -> String {
    match ty {
        Type::Scalar(scalar) => scalar_name(scalar),
        Type::Vector(vector) => vector_name(vector),
        Type::Matrix(m) => format!("mat{}x{}", m.nvector, m.vector_ty.nscalar),
        Type::Array(array) => {
            let length = array.nelement.map(|length| length.to_string()).unwrap_or_default();
            format!("{}[{length}]", type_name(&array.element_ty))
        }
        Type::Struct(fields) => fields.name.clone().unwrap_or_else(|| "struct".into()),
        other => other.to_string(),
    }
}

fn scalar_name(scalar: &ScalarType) -> String {
    match scalar {
        ScalarType::Boolean => "bool".into(),
        ScalarType::Integer { bits: 32, is_signed: true } => "int".into(),
        ScalarType::Integer { bits: 32, is_signed: false } => "uint".into(),
        ScalarType::Float { bits: 32 } => "float".into(),
        other => other.to_string(),
    }
}

fn vector_name(vector: &VectorType) -> String {
    let prefix = match vector.scalar_ty {
        ScalarType::Integer { is_signed: true, .. } => "i",
        ScalarType::Integer { is_signed: false, .. } => "u",
        ScalarType::Boolean => "b",
        _ => "",
    };
    format!("{prefix}vec{}", vector.nscalar)
}

fn spec_constant(module: &Module, instruction: &Instruction) -> Option<SpecConstant> {
    let result = instruction.result_id?;
    let id = module.spec_id(result)?;
    let (type_name, bits) = match instruction.class.opcode {
        Op::SpecConstantTrue => ("bool", 1),
        Op::SpecConstantFalse => ("bool", 0),
        Op::SpecConstant => {
            let ty = module.global(instruction.result_type?)?;
            let is_signed = ty.operands.get(1).and_then(literal) == Some(1);
            let type_name = match ty.class.opcode {
                Op::TypeFloat => "float",
                _ if is_signed => "int",
                _ => "uint",
            };
            (type_name, literal(instruction.operands.first()?)?)
        }
        _ => return None,
    };
    let default = value(type_name, bits);
    let name = module.name(result).unwrap_or_default().into();
    Some(SpecConstant { id, name, type_name, value: default.clone(), default })
}

/// Bits of a constant as a number of its type.
fn value(type_name: &str, bits: u32) -> Value {
    match type_name {
        "bool" => json!(bits != 0),
        "float" => json!(plain(f32::from_bits(bits))),
        "int" => json!(bits as i32),
        _ => json!(bits),
    }
}

/// Number with the shortest decimal form: 0.95 stays 0.95; converted directly to f64 it would be 0.949999988079071.
fn plain(number: f32) -> f64 {
    number.to_string().parse().unwrap_or_else(|_| number.into())
}
