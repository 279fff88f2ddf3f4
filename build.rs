//! Compiles every kernel under `glsl/` to SPIR-V, reflects it, and writes `kernels.rs`: the typed kernel registry, the
//! specialization constants as one struct, the shared enum values, and compile-time checks of `layout.rs`.

#[path = "build/compile.rs"]
mod compile;

use std::cell::Cell;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, process};

use spirq::prelude::*;
use spirq::ty::{DescriptorType, ScalarType, Type};
use spirq::var::Variable;

/// Kernels that include this file are built once for each of its two back ends.
const GEOMETRY_FILE: &str = "glsl/include/geometry/bvh.glsl";
/// Declares records and is never dispatched.
const PROBE: &str = "layout_probe";

/// Where geometry is read from.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum BackEnd {
    Storage,
    Texel,
}

struct Compiled {
    name: String,
    /// Path of its source in the repository.
    file: String,
    is_test: bool,
    reads_geometry: bool,
    spirv: BTreeMap<BackEnd, Vec<u8>>,
}

/// (set, binding) -> (kind, GLSL name)
type Bindings = BTreeMap<(u32, u32), (&'static str, String)>;

fn main() {
    println!("cargo::rerun-if-changed=glsl");
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=build");
    let out = PathBuf::from(env::var("OUT_DIR").expect("cargo sets OUT_DIR"));
    if let Err(message) = run(&out) {
        for line in message.lines() {
            println!("cargo::error={line}");
        }
        process::exit(1);
    }
}

fn run(out: &Path) -> Result<(), String> {
    let compiled = kernel_files()?.iter().map(|file| compile(file)).collect::<Result<Vec<_>, _>>()?;
    let mut code = String::from("// Written by build.rs from glsl/.\n\n");
    write_constants(&mut code)?;
    write_variant(&mut code)?;
    write_registry(&mut code, &compiled, out)?;
    write_layout_checks(&mut code, &compiled)?;
    write_file(&out.join("kernels.rs"), code.as_bytes())
}

fn write_file(path: &Path, bytes: &[u8]) -> Result<(), String> {
    fs::write(path, bytes).map_err(|e| format!("{}: cannot be written: {e}", path.display()))
}

fn read_text(path: &str) -> Result<String, String> {
    fs::read_to_string(path).map_err(|e| format!("{path}: cannot be read: {e}"))
}

/// All `.comp` files, in a fixed order.
fn kernel_files() -> Result<Vec<String>, String> {
    let mut files = Vec::new();
    for folder in ["glsl/kernels", "glsl/test"] {
        collect_kernel_files(folder, &mut files)?;
    }
    files.sort_by_key(|file| kernel_name(file));
    Ok(files)
}

fn collect_kernel_files(folder: &str, files: &mut Vec<String>) -> Result<(), String> {
    let entries = fs::read_dir(folder).map_err(|e| format!("{folder}: cannot be read: {e}"))?;
    for entry in entries.flatten() {
        let path = format!("{folder}/{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() {
            collect_kernel_files(&path, files)?;
        } else if path.ends_with(".comp") {
            files.push(path);
        }
    }
    Ok(())
}

/// A kernel's name: the stem of its file.
fn kernel_name(file: &str) -> String {
    Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

// ---------------------------------------------------------------------------------------------------------- compile

fn compile(file: &str) -> Result<Compiled, String> {
    let reads_geometry = Cell::new(false);
    let mut spirv = BTreeMap::from([(BackEnd::Storage, compile_one(file, BackEnd::Storage, &reads_geometry)?)]);
    if reads_geometry.get() {
        spirv.insert(BackEnd::Texel, compile_one(file, BackEnd::Texel, &reads_geometry)?);
    }
    Ok(Compiled {
        name: kernel_name(file),
        file: file.to_owned(),
        is_test: file.starts_with("glsl/test/"),
        reads_geometry: reads_geometry.get(),
        spirv,
    })
}

fn compile_one(file: &str, back_end: BackEnd, reads_geometry: &Cell<bool>) -> Result<Vec<u8>, String> {
    let macros: &[&str] = if back_end == BackEnd::Texel { &["TEXEL_READS"] } else { &[] };
    let (spirv, included) = compile::compile(Path::new(""), file, macros)?;
    reads_geometry.set(reads_geometry.get() || included.iter().any(|file| file == GEOMETRY_FILE));
    Ok(spirv)
}

// --------------------------------------------------------------------------------------------- constants and variant

/// `const uint NAME = 1u;` lines become Rust constants.
fn write_constants(code: &mut String) -> Result<(), String> {
    let file = "glsl/include/shared/enums.glsl";
    let mut comment = String::new();
    for (number, line) in read_text(file)?.lines().enumerate() {
        if let Some(text) = line.strip_prefix("//") {
            comment = text.trim().replace('`', "");
        } else if !line.is_empty() {
            let parsed =
                line.strip_prefix("const uint ").and_then(|l| l.strip_suffix("u;")).and_then(|l| l.split_once(" = "));
            let (name, value) =
                parsed.ok_or_else(|| format!("{file}:{}: not of the form 'const uint NAME = 1u;'", number + 1))?;
            let _ = writeln!(code, "/// {comment}\npub const {name}: u32 = {value};");
        }
    }
    Ok(())
}

struct Constant {
    id: u32,
    rust_type: &'static str,
    name: String,
    default: String,
    comment: String,
}

fn parse_variant() -> Result<Vec<Constant>, String> {
    let file = "glsl/include/shared/variant.glsl";
    let mut constants = Vec::new();
    let mut comment = String::new();
    for (number, line) in read_text(file)?.lines().enumerate() {
        if let Some(text) = line.strip_prefix("// ") {
            comment = text.to_string();
            continue;
        }
        if let Some(rest) = line.strip_prefix("layout(constant_id = ") {
            let constant = parse_constant(rest, &comment).ok_or_else(|| {
                format!("{file}:{}: not of the form 'layout(constant_id = N) const TYPE NAME = DEFAULT;'", number + 1)
            })?;
            constants.push(constant);
        }
        comment.clear();
    }
    Ok(constants)
}

fn parse_constant(text: &str, comment: &str) -> Option<Constant> {
    let (id, rest) = text.split_once(") const ")?;
    let (declaration, default) = rest.strip_suffix(';')?.split_once(" = ")?;
    let (glsl_type, name) = declaration.split_once(' ')?;
    let rust_type = match glsl_type {
        "uint" => "u32",
        "float" => "f32",
        "bool" => "bool",
        _ => return None,
    };
    let comment = if comment.is_empty() { format!("`{name}` in GLSL.") } else { comment.to_string() };
    let default = if glsl_type == "uint" { default.trim_end_matches('u') } else { default };
    Some(Constant { id: id.parse().ok()?, rust_type, name: name.to_string(), default: default.to_string(), comment })
}

fn write_variant(code: &mut String) -> Result<(), String> {
    let constants = parse_variant()?;
    let mut fields = String::new();
    let mut defaults = String::new();
    let mut entries = String::new();
    for c in &constants {
        let field = c.name.to_lowercase();
        let _ = writeln!(fields, "    /// {}\n    pub {field}: {},", c.comment, c.rust_type);
        let _ = writeln!(defaults, "            {field}: {},", c.default);
        let bits = match c.rust_type {
            "f32" => format!("self.{field}.to_bits()"),
            "bool" => format!("u32::from(self.{field})"),
            _ => format!("self.{field}"),
        };
        let _ = writeln!(entries, "            ({}, {bits}),", c.id);
    }
    let _ = writeln!(
        code,
        "\n/// Every specialization constant of the kernels.\n#[derive(Debug, Clone, Copy, PartialEq)]\npub struct Variant {{\n{fields}}}\n\n\
         impl Default for Variant {{\n    fn default() -> Self {{\n        Self {{\n{defaults}        }}\n    }}\n}}\n\n\
         impl Variant {{\n    /// (id, bits) of every constant.\n    pub fn entries(&self) -> Vec<(u32, u32)> {{\n        vec![\n{entries}        ]\n    }}\n}}"
    );
    Ok(())
}

// --------------------------------------------------------------------------------------------------------- registry

fn reflect(kernel: &Compiled, back_end: BackEnd) -> Result<Vec<Variable>, String> {
    let entry_points = ReflectConfig::new()
        .spv(kernel.spirv[&back_end].as_slice())
        .reflect()
        .map_err(|e| format!("{}: cannot be reflected: {e}", kernel.name))?;
    let entry_point = entry_points.into_iter().next().ok_or_else(|| format!("{}: no entry point", kernel.name))?;
    Ok(entry_point.vars)
}

fn binding_kind(kind: &DescriptorType, ty: &Type) -> Option<&'static str> {
    match kind {
        DescriptorType::StorageBuffer(_) => Some("StorageBuffer"),
        DescriptorType::UniformBuffer() => Some("UniformBuffer"),
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

fn collect_bindings(kernel: &Compiled, back_end: BackEnd, bindings: &mut Bindings) -> Result<(), String> {
    for var in reflect(kernel, back_end)? {
        let Variable::Descriptor { name, desc_bind, desc_ty, ty, .. } = &var else { continue };
        let kind = binding_kind(desc_ty, ty)
            .ok_or_else(|| format!("{}: {name:?} is of an unsupported kind {desc_ty:?}", kernel.name))?;
        let name = name.clone().filter(|n| !n.is_empty()).unwrap_or_else(|| struct_name(ty));
        let shape = (kind, name);
        if let Some(other) = bindings.insert(desc_bind.into_inner(), shape.clone())
            && other.0 != shape.0
        {
            return Err(format!(
                "{}: set {}, binding {} is {shape:?} here and {other:?} elsewhere",
                kernel.name,
                desc_bind.set(),
                desc_bind.bind()
            ));
        }
    }
    Ok(())
}

fn struct_name(ty: &Type) -> String {
    match ty {
        Type::Struct(s) => s.name.clone().unwrap_or_default(),
        _ => String::new(),
    }
}

fn sets_code(bindings: &Bindings) -> String {
    let set_count = bindings.keys().map(|(set, _)| set + 1).max().unwrap_or(0);
    let mut code = String::from("&[\n");
    for set in 0..set_count {
        let _ = writeln!(code, "        SetShape {{ set: {set}, bindings: &[");
        for ((_, binding), (kind, name)) in bindings.range((set, 0)..(set + 1, 0)) {
            let _ = writeln!(
                code,
                "            BindingShape {{ binding: {binding}, kind: BindingKind::{kind}, name: {name:?} }},"
            );
        }
        let _ = writeln!(code, "        ] }},");
    }
    code + "    ]"
}

fn push_constant_bytes(vars: &[Variable]) -> usize {
    vars.iter()
        .filter_map(|v| if let Variable::PushConstant { ty, .. } = v { ty.nbyte() } else { None })
        .max()
        .unwrap_or(0)
}

fn specialization_ids(vars: &[Variable]) -> Vec<u32> {
    // Id 0 is the workgroup size, which every kernel has.
    let mut ids: Vec<u32> = vars
        .iter()
        .filter_map(|v| if let Variable::SpecConstant { spec_id, .. } = v { Some(*spec_id) } else { None })
        .collect();
    ids.push(0);
    ids.sort_unstable();
    ids.dedup();
    ids
}

fn kernel_code(kernel: &Compiled, back_end: BackEnd, sets: &str, out: &Path) -> Result<String, String> {
    let back_end = if kernel.reads_geometry { back_end } else { BackEnd::Storage };
    let suffix = if back_end == BackEnd::Texel { ".texel" } else { "" };
    let folder = if kernel.is_test { "test." } else { "" };
    let file = format!("{folder}{}{suffix}.spv", kernel.name);
    write_file(&out.join(&file), &kernel.spirv[&back_end])?;
    let vars = reflect(kernel, back_end)?;
    Ok(format!(
        "KernelSource {{ name: {:?}, file: {file:?}, spirv: Cow::Borrowed(include_bytes!({file:?})), sets: {sets}, push_constant_bytes: {}, specialization_ids: &{:?} }}",
        kernel.name,
        push_constant_bytes(&vars),
        specialization_ids(&vars),
    ))
}

fn write_registry(code: &mut String, compiled: &[Compiled], out: &Path) -> Result<(), String> {
    let kernels: Vec<&Compiled> = compiled.iter().filter(|k| !k.is_test && k.name != PROBE).collect();
    write_kernels_struct(code, &kernels);
    for (back_end, name, doc) in [
        (BackEnd::Texel, "TEXEL_BUFFERS", "The kernels, reading geometry from texel buffers."),
        (BackEnd::Storage, "STORAGE_BUFFERS", "The kernels, reading geometry from storage buffers."),
    ] {
        let mut bindings = Bindings::new();
        for kernel in &kernels {
            let available = if kernel.reads_geometry { back_end } else { BackEnd::Storage };
            collect_bindings(kernel, available, &mut bindings)?;
        }
        let _ = writeln!(code, "\nconst {name}_SETS: &[SetShape] = {};", sets_code(&bindings));
        let _ = writeln!(code, "/// {doc}\npub static {name}: Kernels = Kernels {{");
        for kernel in &kernels {
            let _ = writeln!(
                code,
                "    {}: {},",
                kernel.name,
                kernel_code(kernel, back_end, &format!("{name}_SETS"), out)?
            );
        }
        code.push_str("};\n");
    }
    write_test_kernels(code, compiled, out)
}

fn write_kernels_struct(code: &mut String, kernels: &[&Compiled]) {
    code.push_str("\n/// Every kernel of the renderer.\n#[derive(Debug, Clone)]\npub struct Kernels {\n");
    for kernel in kernels {
        let _ = writeln!(code, "    /// `{}`\n    pub {}: KernelSource,", kernel.file, kernel.name);
    }
    let all = |prefix: &str| kernels.iter().map(|k| format!("{prefix}self.{}, ", k.name)).collect::<String>();
    let _ = writeln!(
        code,
        "}}\n\nimpl Kernels {{\n    /// All of them.\n    pub fn iter(&self) -> impl Iterator<Item = &KernelSource> {{\n        [{}].into_iter()\n    }}\n\n    \
         /// All of them, to be replaced.\n    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut KernelSource> {{\n        [{}].into_iter()\n    }}\n}}",
        all("&"),
        all("&mut ")
    );
}

fn write_test_kernels(code: &mut String, compiled: &[Compiled], out: &Path) -> Result<(), String> {
    code.push_str("\n/// Kernels that run one pure function each, for tests.\npub mod test {\n    use std::borrow::Cow;\n\n    use crate::gpu::{BindingKind, BindingShape, KernelSource, SetShape};\n");
    for kernel in compiled.iter().filter(|k| k.is_test) {
        let back_end = if kernel.reads_geometry { BackEnd::Texel } else { BackEnd::Storage };
        let mut bindings = Bindings::new();
        collect_bindings(kernel, back_end, &mut bindings)?;
        let source = kernel_code(kernel, back_end, &sets_code(&bindings), out)?;
        let _ = writeln!(
            code,
            "    /// `{}`\n    pub static {}: KernelSource = {source};",
            kernel.file,
            kernel.name.to_uppercase()
        );
    }
    code.push_str("}\n");
    Ok(())
}

// ---------------------------------------------------------------------------------------------------- layout checks

/// A struct of a buffer: (size in bytes, (member, offset)).
type StructLayout = (usize, Vec<(String, usize)>);

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

fn write_layout_checks(code: &mut String, compiled: &[Compiled]) -> Result<(), String> {
    let mut structs = BTreeMap::new();
    for kernel in compiled.iter().filter(|k| !k.is_test) {
        for var in reflect(kernel, BackEnd::Storage)? {
            if matches!(var, Variable::Descriptor { .. } | Variable::PushConstant { .. }) {
                collect_structs(var.ty(), None, true, &mut structs);
            }
        }
    }
    code.push_str("\n// Every struct of layout.rs against the reflected GLSL struct of the same name.\n");
    for (name, (size, members)) in structs {
        let _ = writeln!(
            code,
            "const _: () = {{\n    use crate::generated::layout::{name} as S;\n    assert!(size_of::<S>() == {size}, \"size of {name} differs from the GLSL\");"
        );
        for (member, offset) in members {
            let _ = writeln!(
                code,
                "    assert!(std::mem::offset_of!(S, {member}) == {offset}, \"{name}::{member} lies elsewhere in the GLSL\");"
            );
        }
        code.push_str("};\n");
    }
    Ok(())
}
