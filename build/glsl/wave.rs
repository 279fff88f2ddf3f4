//! Writer of what a wave keeps of a path between kernels: the members that GLSL marks by `KEPT(part)`. A part of a struct is
//! stored and loaded alone. It has whole quadruples of words in every path's slot, and lies together for all slots, so that
//! memory that no kernel of a scene needs is not touched.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::records::{Records, components, snake_case};
use super::structs::{Struct, file_of};

/// Name of the file that GLSL includes.
pub const INCLUDE: &str = "generated/wave.glsl";
/// Mark of a member with the part that it belongs to. The mark of a member within a member counts more than the outer one.
const KEPT: &str = "KEPT";
/// Part of members that are not kept, within a member that is.
const NEVER: &str = "never";
const QUADRUPLE: usize = 4;

/// Scalar or vector that is kept.
struct Leaf {
    /// Name, after the names of the members that it lies in.
    path: String,
    glsl_type: String,
    words: usize,
}

/// Part of a struct: its leaves by the quadruple that holds them.
struct Part {
    name: String,
    quadruples: Vec<Vec<Leaf>>,
}

/// File that stores and loads all kept structs, and the number of quadruples of a slot.
///
/// # Errors
/// The message names the struct that cannot be kept.
pub fn write(records: &Records) -> Result<(String, usize), String> {
    let marked: Vec<&Struct> =
        records.all().filter(|declared| declared.members.iter().any(|member| member.marked(KEPT).is_some())).collect();
    let within: BTreeSet<&str> =
        marked.iter().flat_map(|declared| &declared.members).map(|member| &member.glsl_type[..]).collect();
    let mut includes = String::from(
        "// Place of each struct in a wave's slots, written by build/glsl/wave.rs from the members that are marked as KEPT.\n\
         #ifndef GENERATED_WAVE_GLSL\n#define GENERATED_WAVE_GLSL\n#include \"film/frame.glsl\"\n",
    );
    let (mut functions, mut slot) = (String::new(), 0);
    for declared in marked.into_iter().filter(|declared| !within.contains(&declared.name[..])) {
        let parts = parts(records, declared)?;
        functions += &struct_functions(&declared.name, &parts, &mut slot);
        let _ = writeln!(includes, "#include \"{}\"", file_of(&declared.place).trim_start_matches("glsl/include/"));
    }
    let code = format!(
        "{includes}\n// Size of a slot, in quadruples of words.\nconst uint SLOT_QUADRUPLES = {slot}u;\n\n\
         // Number of slots of the wave.\nuint slot_count();\n{functions}\n#endif\n"
    );
    Ok((code, slot))
}

/// Parts of a struct in the order of their first members.
fn parts(records: &Records, declared: &Struct) -> Result<Vec<Part>, String> {
    let mut leaves: Vec<(String, Leaf)> = Vec::new();
    add_leaves(records, declared, "", NEVER, &mut leaves)?;
    let mut parts: Vec<Part> = Vec::new();
    for (name, _) in leaves.iter().filter(|(name, _)| name != NEVER) {
        if !parts.iter().any(|part| part.name == *name) {
            parts.push(Part { name: name.clone(), quadruples: Vec::new() });
        }
    }
    // Large leaves come first. Leaves of the same size keep their order.
    leaves.sort_by_key(|(_, leaf)| std::cmp::Reverse(leaf.words));
    for (name, leaf) in leaves {
        let Some(part) = parts.iter_mut().find(|part| part.name == name) else { continue };
        let has_room = |quadruple: &&mut Vec<Leaf>| words(quadruple) + leaf.words <= QUADRUPLE;
        match part.quadruples.iter_mut().find(has_room) {
            Some(quadruple) => quadruple.push(leaf),
            None => part.quadruples.push(vec![leaf]),
        }
    }
    Ok(parts)
}

/// Adds the leaves of a struct with the part of each. `part` is that of members without a mark.
fn add_leaves(
    records: &Records,
    declared: &Struct,
    path: &str,
    part: &str,
    leaves: &mut Vec<(String, Leaf)>,
) -> Result<(), String> {
    for member in &declared.members {
        let part = member.marked(KEPT).unwrap_or(part);
        let path = format!("{path}.{}", member.name);
        let glsl_type = member.glsl_type.clone();
        match (components(&glsl_type), &glsl_type[..]) {
            _ if part == NEVER => {}
            (Some((_, words)), _) => leaves.push((part.into(), Leaf { path, glsl_type, words })),
            (None, "bool") => leaves.push((part.into(), Leaf { path, glsl_type, words: 1 })),
            (None, _) => {
                let within = records.find(&glsl_type).map_err(|e| format!("{}: {path}: {e}", declared.place))?;
                add_leaves(records, within, &path, part, leaves)?;
            }
        }
    }
    Ok(())
}

fn words(leaves: &[Leaf]) -> usize {
    leaves.iter().map(|leaf| leaf.words).sum()
}

/// Functions that store and load the parts of a struct. `slot` is the number of a slot's quadruples before them, and then with
/// them.
fn struct_functions(name: &str, parts: &[Part], slot: &mut usize) -> String {
    let snake = snake_case(name);
    let mut code = String::new();
    for Part { name: part, quadruples } in parts {
        let own = if parts.len() == 1 { snake.clone() } else { format!("{snake}_{part}") };
        let (mut stores, mut loads) = (String::new(), String::new());
        for (at, leaves) in quadruples.iter().enumerate() {
            let stored: Vec<_> = leaves.iter().map(Leaf::stored).collect();
            let unused = ", 0u".repeat(QUADRUPLE - words(leaves));
            let _ = writeln!(stores, "    store_scratch({own}_at(slot, {at}u), uvec4({}{unused}));", stored.join(", "));
            let _ = writeln!(loads, "    uvec4 quadruple{at} = load_scratch({own}_at(slot, {at}u));");
            let mut word = 0;
            for leaf in leaves {
                let _ = writeln!(loads, "    x{} = {};", leaf.path, leaf.loaded(at, word));
                word += leaf.words;
            }
        }
        let _ = writeln!(
            code,
            "\nuint {own}_at(uint slot, uint quadruple) {{\n    \
             return {slot}u * slot_count() + {}u * slot + quadruple;\n}}",
            quadruples.len()
        );
        let _ = writeln!(code, "\nvoid store_{own}(uint slot, {name} x) {{\n{stores}}}");
        let _ = writeln!(code, "\nvoid load_{own}(uint slot, inout {name} x) {{\n{loads}}}");
        *slot += quadruples.len();
    }
    code
}

impl Leaf {
    /// The leaf as words of a quadruple.
    fn stored(&self) -> String {
        match &self.glsl_type[..] {
            "bool" => format!("uint(x{})", self.path),
            "float" | "vec2" | "vec3" | "vec4" => format!("floatBitsToUint(x{})", self.path),
            _ => format!("x{}", self.path),
        }
    }

    /// The leaf that begins at the word `word` of a quadruple.
    fn loaded(&self, quadruple: usize, word: usize) -> String {
        let value = format!("quadruple{quadruple}.{}", &"xyzw"[word..word + self.words]);
        match &self.glsl_type[..] {
            "bool" => format!("{value} != 0u"),
            "float" | "vec2" | "vec3" | "vec4" => format!("uintBitsToFloat({value})"),
            _ => value,
        }
    }
}
