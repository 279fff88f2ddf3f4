//! Reader of the structs that GLSL declares. The file depends only on the standard library, so that Cargo.toml can declare
//! it as a test.

/// Struct that GLSL declares.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Struct {
    /// Name.
    pub name: String,
    /// File and line of the declaration.
    pub place: String,
    /// Comment above the declaration.
    pub comment: String,
    /// Members in order.
    pub members: Vec<Member>,
}

/// Member of a struct.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Member {
    /// Name.
    pub name: String,
    /// Type, without the brackets of an array.
    pub glsl_type: String,
    /// Length of an array: a number or the name of a constant.
    pub length: Option<String>,
    /// Mark before it, such as `KEPT(ray)`, as name and argument. Marks are macros that mean nothing to the compiler.
    pub mark: Option<(String, String)>,
    /// Comment behind the declaration, or above it.
    pub comment: String,
}

impl Member {
    /// Argument of the mark with this name, if the member has it.
    pub fn marked(&self, mark: &str) -> Option<&str> {
        self.mark.as_ref().filter(|(name, _)| name == mark).map(|(_, argument)| &argument[..])
    }
}

/// File that declares the struct at `place`.
pub fn file_of(place: &str) -> &str {
    place.rsplit_once(':').map_or(place, |(file, _)| file)
}

/// Reads all structs of a file: lines `struct NAME {`, one member a line, and `};`.
///
/// # Errors
/// The message names the line that cannot be read.
pub fn structs(file: &str, text: &str) -> Result<Vec<Struct>, String> {
    let (mut all, mut comment) = (Vec::new(), String::new());
    let mut open: Option<Struct> = None;
    for (number, line) in (1..).zip(text.lines()) {
        let place = format!("{file}:{number}");
        if let Some(declared) = &mut open {
            match line.trim() {
                "};" => all.extend(open.take()),
                "" => {}
                code => match code.strip_prefix("//") {
                    Some(text) => add_line(&mut comment, text),
                    None => {
                        let member = member(code, &mut comment).ok_or_else(|| {
                            format!("{place}: `{code}` is not of the form `TYPE NAME;  // COMMENT` in a struct")
                        })?;
                        declared.members.push(member);
                    }
                },
            }
            continue;
        }
        if let Some(text) = line.strip_prefix("//") {
            add_line(&mut comment, text);
            continue;
        }
        let name = line.strip_prefix("struct ").and_then(|rest| rest.strip_suffix(" {"));
        let comment = std::mem::take(&mut comment);
        open = name.map(|name| Struct { name: name.into(), place, comment, members: Vec::new() });
    }
    match open {
        Some(open) => Err(format!("{}: the struct {} does not end with the line `}};`", open.place, open.name)),
        None => Ok(all),
    }
}

fn add_line(comment: &mut String, line: &str) {
    let separator = if comment.is_empty() { "" } else { " " };
    *comment = format!("{comment}{separator}{}", line.trim());
}

/// Member that a line declares. It takes the comment above it, unless it has its own.
fn member(line: &str, above: &mut String) -> Option<Member> {
    let (code, behind) = line.split_once("//").unwrap_or((line, ""));
    let above = std::mem::take(above);
    let comment = if behind.is_empty() { above } else { behind.trim().to_owned() };
    let code = code.trim();
    let (mark, code) = match code.split_once(") ") {
        Some((mark, code)) => (Some(mark.split_once('(')?), code),
        None => (None, code),
    };
    let (glsl_type, declared) = code.strip_suffix(';')?.split_once(' ')?;
    let (name, length) = match declared.split_once('[') {
        Some((name, length)) => (name, Some(length.strip_suffix(']')?.to_owned())),
        None => (declared, None),
    };
    let is_name = |text: &str| !text.is_empty() && text.chars().all(|c| c.is_alphanumeric() || c == '_');
    let is_declared = is_name(glsl_type) && is_name(name);
    let mark = mark.map(|(name, argument)| (name.into(), argument.into()));
    is_declared.then(|| Member { name: name.into(), glsl_type: glsl_type.into(), length, mark, comment })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn structs_are_read_with_their_members_and_comments() {
        let text = "// Of the file.\n#ifndef A\n\n// Two\n// lines.\nstruct A {\n    KEPT(ray) vec3 origin;  // of it\n    \
                    // Above.\n    uint kind;\n\n    vec4 rows[ROWS];  // rows\n};\n\nfloat f() {\n}\n\
                    struct Next {\n    float x;\n};\n";
        let found = structs("a.glsl", text).unwrap();
        let member = |name: &str, glsl_type: &str, length: Option<&str>, mark, comment: &str| Member {
            name: name.into(),
            glsl_type: glsl_type.into(),
            length: length.map(Into::into),
            mark,
            comment: comment.into(),
        };
        assert_eq!((&found[0].name[..], &found[0].place[..], &found[0].comment[..]), ("A", "a.glsl:6", "Two lines."));
        let expected = [
            member("origin", "vec3", None, Some(("KEPT".into(), "ray".into())), "of it"),
            member("kind", "uint", None, None, "Above."),
            member("rows", "vec4", Some("ROWS"), None, "rows"),
        ];
        assert_eq!(found[0].members, expected);
        assert_eq!((found.len(), &found[1].name[..], &found[1].comment[..]), (2, "Next", ""));
        assert_eq!(file_of(&found[1].place), "a.glsl");
    }

    #[test]
    fn unreadable_structs_are_refused_by_line() {
        for (text, reason) in [
            ("struct A {\n    uint a, b;\n};\n", "a.glsl:2: `uint a, b;` is not of the form"),
            ("struct A {\n    uint a\n};\n", "a.glsl:2: `uint a` is not of the form"),
            ("struct A {\n    KEPT(ray vec3 a;\n};\n", "a.glsl:2: `KEPT(ray vec3 a;` is not"),
            ("struct A {\n    ray) vec3 a;\n};\n", "a.glsl:2: `ray) vec3 a;` is not"),
            ("\nstruct A {\n    uint a;\n", "a.glsl:2: the struct A does not end"),
        ] {
            let refusal = structs("a.glsl", text).expect_err(text);
            assert!(refusal.starts_with(reason), "{refusal}");
        }
    }
}
