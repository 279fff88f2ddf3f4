//! Writer of the structs that cross to GLSL, and of assertions that those in buffers have the layout that the SPIR-V has.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::glsl::records::{Records, components};
use super::glsl::structs::{Member, Struct, file_of};
use super::interface::StructLayout;
use super::kernels::{BackEnd, Kernel};

/// Records and the structs of all buffers and push constants, each with assertions on its size and its members' offsets.
///
/// # Errors
/// The message names the struct that Rust cannot declare. Every member needs a comment, because it is documentation in Rust.
pub fn code(records: &Records, kernels: &[Kernel]) -> Result<String, String> {
    let mut reflected: BTreeMap<&str, &StructLayout> = BTreeMap::new();
    for kernel in kernels.iter().filter(|kernel| !kernel.is_test()) {
        let structs = &kernel.module(BackEnd::Storage).interface.structs;
        reflected.extend(structs.iter().map(|(name, layout)| (&name[..], layout)));
    }
    let mut declared: BTreeMap<&str, &Struct> = records.of_folder().map(|record| (&record.name[..], record)).collect();
    for name in reflected.keys() {
        declared.insert(name, records.find(name)?);
    }
    let mut code = declared.values().map(|declared| rust_struct(records, declared)).collect::<Result<String, _>>()?;
    for (name, (size, members)) in reflected {
        let _ = writeln!(
            code,
            "const _: () = {{\n    use self::{name} as S;\n    \
             assert!(size_of::<S>() == {size}, \"size of {name} differs from the SPIR-V\");"
        );
        for (member, offset) in members {
            let _ = writeln!(
                code,
                "    assert!(std::mem::offset_of!(S, {member}) == {offset}, \"{name}::{member} lies elsewhere in the SPIR-V\");"
            );
        }
        code.push_str("};\n");
    }
    Ok(code)
}

fn rust_struct(records: &Records, declared: &Struct) -> Result<String, String> {
    let Struct { name, place, comment, members } = declared;
    let documented = |text: &str, what: &str| match text {
        "" => Err(format!("{place}: {what} needs a comment, which Rust's documentation shows")),
        text => Ok(sentence(text)),
    };
    let mut code = format!("/// {} Declared in `{}`.\n", documented(comment, name)?, file_of(place));
    code += "#[repr(C)]\n#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]\n";
    let _ = writeln!(code, "pub struct {name} {{");
    for member in members {
        let doc = documented(&member.comment, &member.name)?;
        let _ = writeln!(code, "    /// {doc}\n    pub {}: {},", member.name, rust_type(records, declared, member)?);
    }
    Ok(code + "}\n\n")
}

fn rust_type(records: &Records, owner: &Struct, member: &Member) -> Result<String, String> {
    let one = match components(&member.glsl_type) {
        Some((scalar, 1)) => scalar.to_owned(),
        Some((scalar, count)) => format!("[{scalar}; {count}]"),
        None => member.glsl_type.clone(),
    };
    Ok(records.length(owner, member)?.map_or(one.clone(), |length| format!("[{one}; {length}]")))
}

/// Comment as a sentence of Rust's documentation.
fn sentence(comment: &str) -> String {
    let plain = comment.replace(['[', ']'], "");
    let mut letters = plain.chars();
    let first = letters.next().into_iter().flat_map(char::to_uppercase);
    let end = if plain.ends_with('.') { "" } else { "." };
    first.chain(letters).collect::<String>() + end
}
