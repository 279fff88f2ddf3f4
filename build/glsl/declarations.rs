//! Reader of constants from GLSL text: constants that GLSL and Rust share, and specialization constants. The file
//! depends only on the standard library, so that Cargo.toml can declare it as a test.

/// Constant that GLSL and Rust share.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SharedConstant {
    /// Name, equal in GLSL and Rust.
    pub name: String,
    /// Rust type: `u32` or `f32`.
    pub rust_type: &'static str,
    /// Value as a Rust literal.
    pub value: String,
    /// Comment above the declaration.
    pub comment: String,
}

/// Specialization constant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SpecializationConstant {
    /// Specialization id.
    pub id: u32,
    /// Name in GLSL.
    pub name: String,
    /// Rust type: `u32`, `f32` or `bool`.
    pub rust_type: &'static str,
    /// Default as a Rust literal, or the name of a shared constant.
    pub default: String,
    /// Comment above the declaration.
    pub comment: String,
}

/// Reads the lines `const TYPE NAME = LITERAL;` of a file. Indented lines belong to functions and are skipped.
///
/// # Errors
/// The message names the line that cannot be read.
pub fn shared_constants(file: &str, text: &str) -> Result<Vec<SharedConstant>, String> {
    let declarations = commented(text).filter(|line| line.code.starts_with("const "));
    let parse = |line: Line| {
        let place = format!("{file}:{}", line.number);
        let (glsl_type, name, value) = declaration(line.code)
            .ok_or_else(|| format!("{place}: `{}` is not of the form `const uint|float NAME = LITERAL;`", line.code))?;
        let rust_type = match glsl_type {
            "uint" => "u32",
            "float" => "f32",
            _ => {
                return Err(format!(
                    "{place}: {name} is of the type {glsl_type}, but only uint and float can be shared"
                ));
            }
        };
        let value = literal(glsl_type, value).ok_or_else(|| {
            format!("{place}: the value `{value}` of {name} is no literal of the type {glsl_type}, such as 1u or 0.5")
        })?;
        if line.comment.is_empty() {
            return Err(format!("{place}: {name} is shared with Rust, so a comment above it must say what it is"));
        }
        Ok(SharedConstant { name: name.into(), rust_type, value, comment: line.comment })
    };
    declarations.map(parse).collect()
}

/// Reads the lines `layout(constant_id = N) const TYPE NAME = DEFAULT;` of all files, given as pairs of path and text.
///
/// # Errors
/// The message names the line that cannot be read, or the two constants that share an id or a name.
pub fn specialization_constants(files: &[(String, String)]) -> Result<Vec<SpecializationConstant>, String> {
    let mut constants: Vec<SpecializationConstant> = Vec::new();
    let lines = files.iter().flat_map(|(file, text)| commented(text).map(move |line| (file, line)));
    for (file, line) in lines.filter(|(_, line)| line.code.starts_with("layout(constant_id")) {
        let place = format!("{file}:{}", line.number);
        let constant = specialization_constant(&line).ok_or_else(|| {
            format!("{place}: `{}` is not of the form `layout(constant_id = N) const TYPE NAME = DEFAULT;`", line.code)
        })?;
        if let Some(other) = constants.iter().find(|other| other.id == constant.id) {
            let (one, two, id) = (&other.name, &constant.name, constant.id);
            return Err(format!(
                "{place}: {one} and {two} both have the specialization id {id}: give {two} a free one"
            ));
        }
        if constants.iter().any(|other| other.name == constant.name) {
            return Err(format!("{place}: {} is declared twice", constant.name));
        }
        constants.push(constant);
    }
    Ok(constants)
}

fn specialization_constant(line: &Line) -> Option<SpecializationConstant> {
    let (id, rest) = line.code.strip_prefix("layout(constant_id = ")?.split_once(") ")?;
    let (glsl_type, name, default) = declaration(rest)?;
    let rust_type = match glsl_type {
        "uint" => "u32",
        "float" => "f32",
        "bool" => "bool",
        _ => return None,
    };
    let default = literal(glsl_type, default).or_else(|| is_name(default).then(|| default.to_owned()))?;
    Some(SpecializationConstant {
        id: id.parse().ok()?,
        name: name.into(),
        rust_type,
        default,
        comment: line.comment.clone(),
    })
}

/// Type, name and value of the declaration `const TYPE NAME = VALUE;`.
fn declaration(code: &str) -> Option<(&str, &str, &str)> {
    let (declared, value) = code.strip_prefix("const ")?.strip_suffix(';')?.split_once(" = ")?;
    let (glsl_type, name) = declared.split_once(' ')?;
    is_name(name).then_some((glsl_type, name, value))
}

fn is_name(text: &str) -> bool {
    let is_word = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_';
    text.starts_with(|c: char| c.is_ascii_uppercase()) && text.chars().all(is_word)
}

/// Rust literal with the value of a GLSL literal. A float must contain a point, so that neither language reads an
/// integer.
fn literal(glsl_type: &str, text: &str) -> Option<String> {
    let is_literal = match glsl_type {
        "uint" => {
            let digits = text.strip_suffix('u')?;
            match digits.strip_prefix("0x") {
                Some(hexadecimal) => u32::from_str_radix(hexadecimal, 16).is_ok(),
                // GLSL reads a number with a leading zero as octal.
                None => digits.parse::<u32>().is_ok() && (digits == "0" || !digits.starts_with('0')),
            }
        }
        "float" => {
            let is_digit = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit());
            let (before, after) = text.split_once('.')?;
            is_digit(before.chars().last()) && is_digit(after.chars().next()) && text.parse::<f32>().is_ok()
        }
        "bool" => matches!(text, "true" | "false"),
        _ => false,
    };
    let digits = if glsl_type == "uint" { text.trim_end_matches('u') } else { text };
    is_literal.then(|| digits.to_owned())
}

/// Line of code: its number, counted from 1, and the comment of its group of lines.
struct Line<'a> {
    number: usize,
    code: &'a str,
    comment: String,
}

/// Lines of code with their comments. A comment applies to all lines below it, up to the next comment or empty line.
fn commented(text: &str) -> impl Iterator<Item = Line<'_>> {
    let (mut comment, mut goes_on) = (String::new(), false);
    text.lines().enumerate().filter_map(move |(index, code)| {
        let Some(part) = code.strip_prefix("//") else {
            goes_on = false;
            if code.is_empty() {
                comment.clear();
            }
            return (!code.is_empty()).then(|| Line { number: index + 1, code, comment: comment.clone() });
        };
        if !goes_on {
            comment.clear();
        }
        let separator = if comment.is_empty() { "" } else { " " };
        comment = format!("{comment}{separator}{}", part.trim());
        goes_on = true;
        None
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn specialization(texts: &[&str]) -> Result<Vec<SpecializationConstant>, String> {
        let file = |(text, name): (&&str, &str)| (name.to_owned(), (*text).to_owned());
        specialization_constants(&texts.iter().zip(["v.glsl", "w.glsl"]).map(file).collect::<Vec<_>>())
    }

    fn message<T: std::fmt::Debug>(result: Result<T, String>) -> String {
        result.expect_err("it is to be refused")
    }

    #[test]
    fn shared_constants_are_read_with_their_comments() {
        let text = "// Of the file.\n\n// Side of a tile,\n// in pixels.\nconst uint SIDE = 8u;\nconst uint BIT = 0x80000000u;\n\
                    // A share.\nconst float SHARE = 1.5e-3;\nfloat f() {\n    const float local = x;\n}\n";
        let constant = |name: &str, rust_type, value: &str, comment: &str| SharedConstant {
            name: name.into(),
            rust_type,
            value: value.into(),
            comment: comment.into(),
        };
        let expected = [
            constant("SIDE", "u32", "8", "Side of a tile, in pixels."),
            constant("BIT", "u32", "0x80000000", "Side of a tile, in pixels."),
            constant("SHARE", "f32", "1.5e-3", "A share."),
        ];
        assert_eq!(shared_constants("a.glsl", text).unwrap(), expected);
    }

    #[test]
    fn malformed_constants_are_refused_by_line() {
        for (code, reason) in [
            ("const uint SIDE = 8;", "`8` of SIDE is no literal of the type uint"),
            ("const uint SIDE = 010u;", "`010u` of SIDE is no literal"),
            ("const uint SIDE = 1u << 3u;", "`1u << 3u` of SIDE is no literal"),
            ("const uint SIDE = 4294967296u;", "of SIDE is no literal"),
            ("const float SHARE = 1.0 / 64.0;", "`1.0 / 64.0` of SHARE is no literal of the type float"),
            ("const float SHARE = 1;", "of SHARE is no literal"),
            ("const float SHARE = 1.;", "of SHARE is no literal"),
            ("const vec2 SHARE = vec2(1.0);", "SHARE is of the type vec2"),
            ("const uint side = 8u;", "`const uint side = 8u;` is not of the form"),
            ("const uint SIDE=8u;", "is not of the form"),
        ] {
            let refusal = message(shared_constants("a.glsl", &format!("\n// A comment.\n{code}\n")));
            assert!(refusal.starts_with("a.glsl:3: ") && refusal.contains(reason), "{code}: {refusal}");
        }
        let uncommented = message(shared_constants("a.glsl", "// Of the file.\n\nconst uint SIDE = 8u;\n"));
        assert!(uncommented.starts_with("a.glsl:3: SIDE ") && uncommented.contains("comment"), "{uncommented}");
    }

    #[test]
    fn specialization_constants_are_read() {
        let text = "layout(local_size_x_id = 0) in;\n// The filter.\nlayout(constant_id = 7) const uint FILTER = FILTER_BOX;\n\n\
                    layout(constant_id = 9) const float WIDTH = 1.0;\nlayout(constant_id = 8) const bool NEE = false;\n";
        let constant = |id, name: &str, rust_type, default: &str, comment: &str| SpecializationConstant {
            id,
            name: name.into(),
            rust_type,
            default: default.into(),
            comment: comment.into(),
        };
        let expected = [
            constant(7, "FILTER", "u32", "FILTER_BOX", "The filter."),
            constant(9, "WIDTH", "f32", "1.0", ""),
            constant(8, "NEE", "bool", "false", ""),
        ];
        assert_eq!(specialization(&[text]).unwrap(), expected);
    }

    #[test]
    fn one_id_for_two_constants_is_refused_with_both_names() {
        let [nee, map] =
            ["layout(constant_id = 40) const bool NEE = false;", "layout(constant_id = 40) const uint MAP = 0u;"];
        let both = "NEE and MAP both have the specialization id 40: give MAP a free one";
        assert_eq!(message(specialization(&[&format!("{nee}\n\n{map}\n")])), format!("v.glsl:3: {both}"));
        assert_eq!(message(specialization(&[nee, map])), format!("w.glsl:1: {both}"));
        assert_eq!(message(specialization(&[nee, &nee.replace("40", "41")])), "w.glsl:1: NEE is declared twice");
    }

    #[test]
    fn malformed_specialization_constants_are_refused_by_line() {
        for code in [
            "layout(constant_id = x) const uint MAP = 0u;",
            "layout(constant_id = 1) const int MAP = 0;",
            "layout(constant_id = 1) const uint MAP = 0;",
            "layout(constant_id = 1) const uint MAP = A + B;",
            "layout(constant_id=1) const uint MAP = 0u;",
        ] {
            let refusal = message(specialization(&[&format!("// A comment.\n{code}\n")]));
            assert!(refusal.starts_with("v.glsl:2: ") && refusal.contains(code), "{refusal}");
        }
    }
}
