//! Writer of the kernel registry: a struct of all kernels, a value of it for each back end, and the kernels of the
//! tests.

use std::fmt::Write as _;

use super::kernels::{BackEnd, Kernel};
use super::sets;

/// Code of the registry.
pub fn code(kernels: &[Kernel]) -> Result<String, String> {
    let product: Vec<&Kernel> = kernels.iter().filter(|kernel| kernel.is_product()).collect();
    let mut code = struct_code(&product);
    for (back_end, name, doc) in [
        (BackEnd::Texel, "TEXEL_BUFFERS", "The kernels, reading geometry from texel buffers."),
        (BackEnd::Storage, "STORAGE_BUFFERS", "The kernels, reading geometry from storage buffers."),
        (BackEnd::Query, "RAY_QUERIES", "The kernels, traversing an acceleration structure by ray queries."),
    ] {
        let bindings = sets::union(product.iter().copied(), back_end)?;
        let _ = writeln!(code, "\nconst {name}_SETS: &[SetShape] = {};", sets::shapes(&bindings));
        let _ = writeln!(code, "/// {doc}\npub static {name}: Kernels = Kernels {{");
        for kernel in &product {
            let _ = writeln!(code, "    {}: {},", kernel.name, source(kernel, back_end, &format!("{name}_SETS")));
        }
        code.push_str("};\n");
    }
    Ok(code + &test_kernels(kernels))
}

fn struct_code(kernels: &[&Kernel]) -> String {
    let fields: String =
        kernels.iter().map(|k| format!("    /// `{}`\n    pub {}: KernelSource,\n", k.file, k.name)).collect();
    let all = |prefix: &str| kernels.iter().map(|k| format!("{prefix}self.{}, ", k.name)).collect::<String>();
    format!(
        "/// Every kernel of the renderer.
#[derive(Debug, Clone)]
pub struct Kernels {{
{fields}}}

impl Kernels {{
    /// Iterator over all kernels.
    pub fn iter(&self) -> impl Iterator<Item = &KernelSource> {{
        [{}].into_iter()
    }}

    /// Mutable iterator over all kernels, to replace some of them.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut KernelSource> {{
        [{}].into_iter()
    }}
}}
",
        all("&"),
        all("&mut ")
    )
}

fn source(kernel: &Kernel, back_end: BackEnd, sets: &str) -> String {
    let (file, interface) = (kernel.spirv_file(back_end), &kernel.module(back_end).interface);
    format!(
        "KernelSource {{ name: {:?}, file: {file:?}, spirv: Cow::Borrowed(include_bytes!({file:?})), sets: {sets}, \
         push_constant_bytes: {}, specialization_ids: &{:?} }}",
        kernel.name, interface.push_constant_bytes, interface.specialization_ids,
    )
}

fn test_kernels(kernels: &[Kernel]) -> String {
    if !kernels.iter().any(Kernel::is_test) {
        return String::new();
    }
    let mut code = String::from(
        "
/// Kernels that run one pure function each, for tests.
pub mod test {
    use std::borrow::Cow;

    use crate::gpu::{BindingKind, BindingShape, KernelSource, SetShape};
",
    );
    for kernel in kernels.iter().filter(|kernel| kernel.is_test()) {
        for (back_end, suffix) in [(BackEnd::Texel, ""), (BackEnd::Query, "_BY_QUERY")] {
            if back_end == BackEnd::Query && !kernel.has(back_end) {
                continue;
            }
            let sets = sets::shapes(&kernel.module(back_end).interface.bindings);
            let source = source(kernel, back_end, &sets);
            let name = kernel.name.to_uppercase() + suffix;
            let _ = writeln!(code, "    /// `{}`\n    pub static {name}: KernelSource = {source};", kernel.file);
        }
    }
    code + "}\n"
}
