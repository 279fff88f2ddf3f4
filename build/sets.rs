//! Descriptor sets: their shapes, and names for their binding numbers.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::glsl::records::snake_case;
use super::interface::Bindings;
use super::kernels::{BackEnd, Kernel};

/// Union of the bindings of kernels on one back end.
///
/// # Errors
/// Two kernels that declare the same binding differently are an error.
pub fn union<'a>(kernels: impl IntoIterator<Item = &'a Kernel>, back_end: BackEnd) -> Result<Bindings, String> {
    let mut all = Bindings::new();
    for kernel in kernels {
        for (&(set, binding), shape) in &kernel.module(back_end).interface.bindings {
            if let Some(other) = all.insert((set, binding), shape.clone())
                && other.0 != shape.0
            {
                let file = &kernel.file;
                return Err(format!("{file}: set {set}, binding {binding} is {shape:?} here and {other:?} elsewhere"));
            }
        }
    }
    Ok(all)
}

/// Code of a slice of `SetShape` without gaps.
pub fn shapes(bindings: &Bindings) -> String {
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

/// Code of a module for each set, with a constant for each of its bindings. It is the same for all back ends.
///
/// # Errors
/// A set without a name is an error, and so are two bindings with one name or two names of one binding.
pub fn binding_numbers(sets: &BTreeMap<u32, String>, kernels: &[Kernel]) -> Result<String, String> {
    let mut names = BTreeMap::<(u32, u32), String>::new();
    for back_end in BackEnd::ALL {
        for (place, (_, name)) in union(kernels.iter().filter(|kernel| kernel.is_product()), back_end)? {
            let name = constant_name(&name);
            if let Some(other) = names.insert(place, name.clone())
                && other != name
            {
                return Err(format!("set {}, binding {} is named {name} as well as {other}", place.0, place.1));
            }
        }
    }
    let mut code = String::from("\n/// Numbers of the bindings of each descriptor set.\npub mod bindings {\n");
    for (set, set_name) in sets {
        let of_set: Vec<_> = names.range((*set, 0)..(*set + 1, 0)).collect();
        let _ = writeln!(code, "    /// Set {set}.\n    pub mod {set_name} {{");
        for (index, ((_, binding), name)) in of_set.iter().enumerate() {
            if of_set[..index].iter().any(|(_, other)| other == name) {
                return Err(format!("two bindings of set {set} are named {name}"));
            }
            let _ = writeln!(code, "        /// `{name}`\n        pub const {name}: u32 = {binding};");
        }
        code.push_str("    }\n");
    }
    match names.keys().find(|(set, _)| !sets.contains_key(set)) {
        Some((set, _)) => Err(format!(
            "set {set} has no name: declare a constant whose name ends in _SET for it in glsl/include/shared"
        )),
        None => Ok(code + "}\n"),
    }
}

/// Name of a constant in upper snake case: `TexelWords1` and `texel_words1` become `TEXEL_WORDS1`.
fn constant_name(name: &str) -> String {
    snake_case(name).to_uppercase()
}
