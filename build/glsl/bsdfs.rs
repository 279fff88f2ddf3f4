//! Writer of what joins the kinds of BSDF, from the files of [`FOLDER`]: `generated/bsdfs.glsl`, and constants for Rust.
//!
//! A file with the line `const uint BSDF_NAME = NUMBER;` is a kind. Structs say where parameters lie in a material's record:
//! `COLOR(0) vec3 reflectance;`. The functions of a kind are called by the types and names of their parameters. All but
//! `sample_bsdf_name` may be missing.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::records::{Records, snake_case};
use super::structs::{Member, Struct};

/// Name of the file that GLSL includes.
pub const INCLUDE: &str = "generated/bsdfs.glsl";
const FOLDER: &str = "glsl/include/bsdf/";
/// Struct of the parameters that all kinds with microfacets have.
const FACETS: &str = "Facets";
/// Numbers of scalars, which follow those of the colors.
const FIRST_SCALAR: usize = 3;

/// Function of every kind: its result, its name before that of the kind, the result of kinds without it, and the arguments that
/// it may name.
const FUNCTIONS: [[&str; 4]; 4] = [
    ["BsdfSample", "sample_bsdf", "NO_BSDF_SAMPLE", "vec3 wo, vec3 m, vec3 u, Filmed filmed"],
    ["float", "pdf_bsdf", "0.0", "vec3 wo, vec3 wi, float diffuse_density, Facet f"],
    ["vec3", "eval_bsdf", "vec3(0.0)", "vec3 wo, vec3 wi, Facet f, Filmed filmed"],
    ["float", "guided_part_bsdf", "0.0", ""],
];

/// Kind of BSDF.
struct Kind<'a> {
    file: &'a str,
    /// Name in capitals: `BSDF_NAME`.
    name: &'a str,
    number: u32,
    /// Parameters of each of the [`FUNCTIONS`] as pairs of type and name; `None` where the kind lacks the function.
    functions: Vec<Option<Vec<(&'a str, &'a str)>>>,
}

/// Files that were written for GLSL, and constants for Rust.
///
/// # Errors
/// The message names the file that is wrong.
pub fn write(sources: &[(String, String)], records: &Records) -> Result<(String, String), String> {
    let mut kinds = Vec::new();
    for (file, text) in sources.iter().filter(|(file, _)| file.starts_with(FOLDER)) {
        kinds.extend(Kind::read(file, text)?);
    }
    kinds.sort_by_key(|kind| kind.number);
    if let Some(pair) = kinds.windows(2).find(|pair| pair[0].number == pair[1].number) {
        return Err(format!("{} and {} have the same number: give one a free number", pair[0].file, pair[1].file));
    }
    if let Some(kind) = kinds.iter().find(|kind| kind.has_diffuse_lobe() && kind.has_guided_part()) {
        return Err(format!(
            "{}: a guide stands for the diffuse lobe, or has a share of the whole function, not both",
            kind.file
        ));
    }
    for choice in ["MATERIAL_BLEND", "MATERIAL_SIDES"] {
        if let Some(kind) = kinds.iter().find(|kind| records.constant(choice) == Some(kind.number as usize)) {
            return Err(format!("{}: {} is the number of {choice}: take a free number", kind.file, kind.number));
        }
    }
    let mut glsl = String::from(
        "// Calls of all kinds of BSDF, written by build/glsl/bsdfs.rs.\n\
         #ifndef GENERATED_BSDFS_GLSL\n#define GENERATED_BSDFS_GLSL\n#include \"bsdf/parameters.glsl\"\n",
    );
    for kind in &kinds {
        let _ = writeln!(glsl, "#include \"{}\"", kind.file.trim_start_matches("glsl/include/"));
    }
    let mut rust = String::new();
    for kind in &kinds {
        let _ = writeln!(rust, "/// Number of a kind of BSDF.\npub const {}: u32 = {};", kind.name, kind.number);
    }
    let has = |declared: &Struct| declared.members.iter().any(|member| slot(member).is_some());
    for declared in records.all().filter(|declared| declared.place.starts_with(FOLDER) && has(declared)) {
        glsl += &reader(records, declared)?;
        rust += &numbers(declared);
    }
    for (i, [result, name, without, arguments]) in FUNCTIONS.iter().enumerate() {
        let separator = if arguments.is_empty() { "" } else { ", " };
        let _ =
            writeln!(glsl, "\n{result} {name}_of_kind(Bsdf b{separator}{arguments}) {{\n    {result} x = {without};");
        for kind in &kinds {
            glsl += &kind.call(i, name)?;
        }
        glsl += "    return x;\n}\n";
    }
    glsl += "\n// Kinds that read a parameter, or have microfacets: bits 1 << kind.\n";
    for (name, is_member) in masks(&kinds, records)? {
        let bits =
            kinds.iter().zip(is_member).filter(|(_, is)| *is).fold(0u32, |bits, (kind, _)| bits | 1 << kind.number);
        let _ = writeln!(glsl, "const uint KINDS_WITH_{name} = {bits}u;");
        let _ =
            writeln!(rust, "/// Bits `1 << kind` of some kinds of BSDF.\npub const KINDS_WITH_{name}: u32 = {bits};");
    }
    Ok((glsl + "\n#endif\n", rust))
}

/// Sets of kinds by name.
fn masks(kinds: &[Kind], records: &Records) -> Result<Vec<(String, Vec<bool>)>, String> {
    let slots = kinds.iter().map(|kind| kind.slots(records)).collect::<Result<Vec<_>, _>>()?;
    let reads = |range: std::ops::Range<usize>| {
        slots.iter().map(|slots| range.clone().any(|slot| slots.contains(&slot))).collect()
    };
    let parameters =
        [("COLOR1", 1..2), ("COLOR2", 2..3), ("SCALARS0", 3..7), ("SCALARS1", 7..11), ("SCALARS2", 11..15)];
    let mut masks: Vec<(String, Vec<bool>)> =
        parameters.into_iter().map(|(name, range)| (name.into(), reads(range))).collect();
    masks.push(("FACETS".into(), kinds.iter().map(Kind::has_facets).collect()));
    masks.push(("DIFFUSE_LOBE".into(), kinds.iter().map(Kind::has_diffuse_lobe).collect()));
    masks.push(("GUIDED_PART".into(), kinds.iter().map(Kind::has_guided_part).collect()));
    Ok(masks)
}

impl<'a> Kind<'a> {
    /// Reads a file; `None` if it is no kind.
    fn read(file: &'a str, text: &'a str) -> Result<Option<Self>, String> {
        let number = |line: &'a str| line.strip_prefix("const uint ").filter(|rest| rest.starts_with("BSDF_"));
        let Some((name, number)) = text.lines().find_map(number).and_then(|rest| rest.split_once(" = ")) else {
            return Ok(None);
        };
        let number = number.strip_suffix("u;").and_then(|number| number.parse().ok()).filter(|&number| number < 32);
        let number =
            number.ok_or_else(|| format!("{file}: the number of {name} must be a literal below 32, such as 7u"))?;
        let own = name.trim_start_matches("BSDF_").to_lowercase();
        let function = |[result, function, ..]: [&str; 4]| {
            let start = format!("{result} {function}_{own}(");
            let arguments = text.lines().find_map(|line| line.strip_prefix(&start)?.strip_suffix(") {"))?;
            arguments.split(", ").map(|argument| argument.split_once(' ')).collect()
        };
        let functions: Vec<_> = FUNCTIONS.into_iter().map(function).collect();
        match functions[0] {
            Some(_) => Ok(Some(Self { file, name, number, functions })),
            None => {
                Err(format!("{file}: {name} needs the function `BsdfSample sample_bsdf_{own}(...) {{`, on one line"))
            }
        }
    }

    fn takes(&self, argument: &str) -> bool {
        self.functions.iter().flatten().flatten().any(|(_, name)| *name == argument)
    }

    fn has_facets(&self) -> bool {
        self.takes("f") || self.takes("m")
    }

    /// Whether a guide may stand for a lobe, whose density the kind takes.
    fn has_diffuse_lobe(&self) -> bool {
        self.takes("diffuse_density")
    }

    /// Whether a guide has a share of the whole function.
    fn has_guided_part(&self) -> bool {
        self.functions[3].is_some()
    }

    /// Line that calls a function of the kind.
    fn call(&self, function: usize, name: &str) -> Result<String, String> {
        let Some(parameters) = &self.functions[function] else { return Ok(String::new()) };
        let known: BTreeSet<_> = FUNCTIONS[function][3].split(", ").collect();
        let mut arguments = Vec::new();
        for (glsl_type, argument) in parameters {
            arguments.push(match (*glsl_type, *argument) {
                ("Bsdf", "b") => "b".into(),
                ("Film", "film") => "b.film".into(),
                (_, "b") => format!("{}_of(b)", snake_case(glsl_type)),
                _ if known.contains(&format!("{glsl_type} {argument}")[..]) => (*argument).to_owned(),
                _ => return Err(format!("{}: {name} has no argument {glsl_type} {argument}", self.file)),
            });
        }
        let (kind, own) = (self.name, self.name.trim_start_matches("BSDF_").to_lowercase());
        Ok(format!("    if (is_kind(b, {kind})) x = {name}_{own}({});\n", arguments.join(", ")))
    }

    /// Numbers of all parameters that the kind's functions read.
    fn slots(&self, records: &Records) -> Result<BTreeSet<usize>, String> {
        let of_functions = self.functions.iter().flatten().flatten().filter(|(_, name)| *name == "b");
        let mut names: Vec<_> = of_functions.map(|(glsl_type, _)| *glsl_type).filter(|name| *name != "Bsdf").collect();
        names.extend(self.has_facets().then_some(FACETS));
        let mut slots = BTreeSet::new();
        while let Some(name) = names.pop() {
            let declared = records.find(name).map_err(|e| format!("{}: {e}", self.file))?;
            slots.extend(declared.members.iter().filter_map(slot));
            names.extend(
                declared.members.iter().filter(|member| member.mark.is_none()).map(|member| &member.glsl_type[..]),
            );
        }
        Ok(slots)
    }
}

/// Number of a parameter: colors, then scalars; `None` for a member without a mark of a parameter. A flag has the number of no
/// parameter.
fn slot(member: &Member) -> Option<usize> {
    let number = |mark| member.marked(mark)?.parse::<usize>().ok();
    let scalar = number("SCALAR").map(|number| number + FIRST_SCALAR);
    number("COLOR").or(scalar).or_else(|| member.marked("FLAG").map(|_| usize::MAX))
}

/// Function that makes a struct of parameters from a BSDF.
fn reader(records: &Records, declared: &Struct) -> Result<String, String> {
    let Struct { name, place, .. } = declared;
    let mut values = Vec::new();
    for member in &declared.members {
        values.push(match (&member.mark, &member.glsl_type[..]) {
            (Some((mark, number)), "vec3") if mark == "COLOR" => format!("b.color{number}"),
            (Some((mark, number)), "float") if mark == "SCALAR" => {
                let number: usize = number.parse().map_err(|_| format!("{place}: SCALAR({number}) is no number"))?;
                format!("b.scalars{}.{}", number / 4, &"xyzw"[number % 4..][..1])
            }
            (Some((mark, flag)), "bool") if mark == "FLAG" => format!("bsdf_flag(b, {flag})"),
            (None, inner) if records.find(inner).is_ok() => format!("{}_of(b)", snake_case(inner)),
            _ => {
                return Err(format!(
                    "{place}: {} needs the mark COLOR before vec3, SCALAR before float or FLAG before bool",
                    member.name
                ));
            }
        });
    }
    Ok(format!("\n{name} {}_of(Bsdf b) {{\n    return {name}({});\n}}\n", snake_case(name), values.join(", ")))
}

/// Rust constants with the numbers of a struct's parameters.
fn numbers(declared: &Struct) -> String {
    let mut code = String::new();
    for member in declared.members.iter().filter(|member| member.marked("FLAG").is_none()) {
        let Some(number) = slot(member) else { continue };
        let name = format!("{}_{}", snake_case(&declared.name), member.name).to_uppercase();
        let _ = writeln!(code, "/// Number of a parameter in a material's record.\npub const {name}: u32 = {number};");
    }
    code
}
