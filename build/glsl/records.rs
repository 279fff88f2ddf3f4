//! Writer of records: structs that GLSL declares and Rust knows, too. Those in [`FOLDER`] lie in buffers of texels, four
//! words each. GLSL gets functions that read them, Rust gets structs of the same layout.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::structs::{Member, Struct, file_of, structs};

/// Folder of the records that are read as texels, or that Rust knows only the size of.
pub const FOLDER: &str = "glsl/include/records";
/// Ending of the names of structs that are read from a buffer of texels.
const RECORD: &str = "Record";
const TEXEL_WORDS: usize = 4;

/// Every struct of the GLSL by its name, and the lengths of arrays that constants name.
pub struct Records {
    structs: BTreeMap<String, Vec<Struct>>,
    lengths: BTreeMap<String, usize>,
}

impl Records {
    /// Reads the structs of all files, given as pairs of path and text.
    ///
    /// # Errors
    /// The message names the line that cannot be read.
    pub fn read(files: &[(String, String)], lengths: BTreeMap<String, usize>) -> Result<Self, String> {
        let mut all: BTreeMap<String, Vec<Struct>> = BTreeMap::new();
        for (file, text) in files {
            for declared in structs(file, text)? {
                all.entry(declared.name.clone()).or_default().push(declared);
            }
        }
        Ok(Self { structs: all, lengths })
    }

    /// All structs, in the order of their names.
    pub fn all(&self) -> impl Iterator<Item = &Struct> {
        self.structs.values().flatten()
    }

    /// Struct of this name.
    ///
    /// # Errors
    /// There must be one, and one only.
    pub fn find(&self, name: &str) -> Result<&Struct, String> {
        match self.structs.get(name).map(Vec::as_slice) {
            Some([only]) => Ok(only),
            Some([one, two, ..]) => Err(format!("{} and {} both declare {name}: rename one", one.place, two.place)),
            _ => Err(format!("no struct {name} below glsl, one member a line")),
        }
    }

    /// Number of words of a member.
    ///
    /// # Errors
    /// Its type must consist of words.
    pub fn words(&self, owner: &Struct, member: &Member) -> Result<usize, String> {
        let one = match components(&member.glsl_type) {
            Some((_, components)) => components,
            None => self.size(self.find(&member.glsl_type).map_err(|e| format!("{}: {e}", owner.place))?)?,
        };
        Ok(one * self.length(owner, member)?.unwrap_or(1))
    }

    /// Value of a shared constant.
    pub fn constant(&self, name: &str) -> Option<usize> {
        self.lengths.get(name).copied()
    }

    fn size(&self, declared: &Struct) -> Result<usize, String> {
        declared.members.iter().map(|member| self.words(declared, member)).sum()
    }

    /// Length of a member that is an array.
    ///
    /// # Errors
    /// The length must be a number or a shared constant.
    pub fn length(&self, owner: &Struct, member: &Member) -> Result<Option<usize>, String> {
        let Some(length) = &member.length else { return Ok(None) };
        let known = length.trim_end_matches('u').parse().ok().or_else(|| self.lengths.get(length).copied());
        let unknown = || format!("{}: the length {length} of {} is no number or constant", owner.place, member.name);
        known.map(Some).ok_or_else(unknown)
    }

    /// Structs of [`FOLDER`].
    pub fn of_folder(&self) -> impl Iterator<Item = &Struct> {
        self.all().filter(|declared| declared.place.starts_with(FOLDER))
    }

    /// Files for GLSL to include, by name: for each file of [`FOLDER`], functions that read its records.
    ///
    /// # Errors
    /// No member may lie in two texels.
    pub fn includes(&self) -> Result<BTreeMap<String, String>, String> {
        let mut includes: BTreeMap<String, String> = BTreeMap::new();
        for declared in self.of_folder() {
            let readers = Readers::new(self, declared)?;
            let functions = if declared.name.ends_with(RECORD) { readers.of_buffer() } else { readers.of_texel() };
            let name = file_of(&declared.place).rsplit('/').next().unwrap_or_default();
            if !functions.is_empty() {
                *includes.entry(format!("generated/{name}")).or_insert_with(|| opening(name)) += &functions;
            }
        }
        includes.values_mut().for_each(|file| file.push_str("\n#endif\n"));
        Ok(includes)
    }
}

fn opening(name: &str) -> String {
    let guard = format!("GENERATED_{}", name.replace('.', "_").to_uppercase());
    format!(
        "// Readers of the records in records/{name}, written by build/glsl/records.rs.\n#ifndef {guard}\n#define {guard}\n\
         #include \"records/{name}\"\n"
    )
}

/// Functions that read one record.
struct Readers<'a> {
    declared: &'a Struct,
    /// Members with the word at which each begins, and its number of words.
    members: Vec<(&'a Member, usize, usize)>,
    size: usize,
}

impl<'a> Readers<'a> {
    fn new(records: &Records, declared: &'a Struct) -> Result<Self, String> {
        let (mut members, mut size) = (Vec::new(), 0);
        for member in &declared.members {
            let words = records.words(declared, member)?;
            let is_whole = size % TEXEL_WORDS == 0 && words % TEXEL_WORDS == 0;
            let is_read = declared.name.ends_with(RECORD);
            if is_read && !is_whole && (size % TEXEL_WORDS + words > TEXEL_WORDS || member.length.is_some()) {
                return Err(format!("{}: {} lies in two texels", declared.place, member.name));
            }
            members.push((member, size, words));
            size += words;
        }
        if declared.name.ends_with(RECORD) && size % TEXEL_WORDS != 0 {
            return Err(format!("{}: {} has {size} words, which fill no texel", declared.place, declared.name));
        }
        Ok(Self { declared, members, size })
    }

    /// Functions of a record that lies in a buffer of texels.
    fn of_buffer(&self) -> String {
        let name = snake_case(self.declared.name.trim_end_matches(RECORD));
        let texels = self.size / TEXEL_WORDS;
        let mut code = format!(
            "\n// Number of texels of a {}, and the function that fetches one. The file with the buffer defines it.\n\
             const uint {}_TEXELS = {texels}u;\nuvec4 {name}_texel(uint at, uint texel);\n",
            self.declared.name,
            name.to_uppercase()
        );
        for (member, offset, _) in self.members.iter().filter(|(member, ..)| member.name != "unused") {
            let texel = offset / TEXEL_WORDS;
            let (parameter, texel) = match &member.length {
                Some(_) => (", uint i", format!("{texel}u + i")),
                None => ("", format!("{texel}u")),
            };
            let value = value(member, &format!("{name}_texel(at, {texel})"), *offset);
            let Member { name: own, glsl_type, .. } = member;
            let _ = writeln!(code, "\n{glsl_type} {name}_{own}(uint at{parameter}) {{\n    return {value};\n}}");
        }
        if self.members.iter().all(|(member, ..)| member.length.is_none()) {
            let fetches: Vec<_> = (0..texels).map(|i| format!("{name}_texel(at, {i}u)")).collect();
            code += &self.reader(&format!("load_{name}(uint at)"), &fetches);
        }
        if texels == 1 {
            code += &self.of_texel();
        }
        code
    }

    /// Functions that convert a struct of one texel, if it is one.
    fn of_texel(&self) -> String {
        if self.size != TEXEL_WORDS || self.members.iter().any(|(member, ..)| components(&member.glsl_type).is_none()) {
            return String::new();
        }
        let name = &self.declared.name;
        let words = self.members.iter().map(|(member, ..)| match components(&member.glsl_type) {
            Some(("f32", _)) => format!("floatBitsToUint(x.{})", member.name),
            _ => format!("x.{}", member.name),
        });
        let words = words.collect::<Vec<_>>().join(", ");
        let reader = self.reader(&format!("{}_of(uvec4 texel0)", snake_case(name)), &["texel0".into()]);
        format!("{reader}\nuvec4 texel_of({name} x) {{\n    return uvec4({words});\n}}\n")
    }

    /// Function that makes the struct from its texels.
    fn reader(&self, head: &str, texels: &[String]) -> String {
        let name = &self.declared.name;
        let mut code = format!("\n{name} {head} {{\n");
        for (i, texel) in texels.iter().enumerate().filter(|(i, texel)| **texel != format!("texel{i}")) {
            let _ = writeln!(code, "    uvec4 texel{i} = {texel};");
        }
        let values = self.members.iter().map(|(member, offset, _)| {
            let texel = format!("texel{}", offset / TEXEL_WORDS);
            value(member, &texel, *offset)
        });
        let _ = writeln!(code, "    return {name}({});\n}}", values.collect::<Vec<_>>().join(", "));
        code
    }
}

/// Value of a member that begins at the word `offset` of its record, in the texel `texel`.
fn value(member: &Member, texel: &str, offset: usize) -> String {
    let (scalar, count) = components(&member.glsl_type).unwrap_or(("u32", 1));
    let first = offset % TEXEL_WORDS;
    let components = if count == TEXEL_WORDS { String::new() } else { format!(".{}", &"xyzw"[first..first + count]) };
    match scalar {
        "f32" => format!("uintBitsToFloat({texel}{components})"),
        _ => format!("{texel}{components}"),
    }
}

/// Rust type of the components of a GLSL type, and their number; `None` for a struct.
pub fn components(glsl_type: &str) -> Option<(&'static str, usize)> {
    Some(match glsl_type {
        "float" => ("f32", 1),
        "vec2" => ("f32", 2),
        "vec3" => ("f32", 3),
        "vec4" => ("f32", 4),
        "uint" => ("u32", 1),
        "uvec2" => ("u32", 2),
        "uvec3" => ("u32", 3),
        "uvec4" => ("u32", 4),
        _ => return None,
    })
}

/// Name in snake case: `DeltaLight` becomes `delta_light`.
pub fn snake_case(name: &str) -> String {
    let mut snake = String::new();
    for c in name.chars() {
        if c.is_ascii_uppercase() && !snake.is_empty() {
            snake.push('_');
        }
        snake.push(c.to_ascii_lowercase());
    }
    snake
}
