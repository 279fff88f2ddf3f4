//! Places that values come from, and the words of their format.

use std::borrow::Cow;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::Error;

/// Name of a plugin or a parameter.
pub(in crate::scene) type Name = Cow<'static, str>;

/// Form in which a scene is given, whose words messages use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::scene) enum Format {
    /// Mitsuba's XML.
    Xml,
    /// Mitsuba's dictionary.
    Dictionary,
    /// Another program's file, such as one of glTF or pbrt.
    Foreign,
}

impl Format {
    /// The kind of an object or a value by its name in XML, as users of the format know it.
    pub fn word(self, name: &str) -> String {
        match (self, name) {
            (Self::Xml, name) => format!("<{name}>"),
            (Self::Foreign, "bsdf") => "material".to_owned(),
            (Self::Foreign, "emitter") => "light".to_owned(),
            (Self::Foreign, "sensor") => "camera".to_owned(),
            (Self::Foreign, name) => name.to_owned(),
            (Self::Dictionary, name) => format!("`{name}`"),
        }
    }
}

/// Place that an object or a value comes from: a line of a file, or an entry such as `scene.box.bsdf`.
#[derive(Debug, Clone)]
pub(in crate::scene) struct Origin {
    /// Path of the file, or of the object's entry.
    pub file: Arc<Path>,
    pub format: Format,
    part: Part,
}

/// Part of what the path of an origin names.
#[derive(Debug, Clone)]
enum Part {
    Whole,
    /// Line, counted from 1.
    Line(u32),
    /// Entry of the object.
    Entry(Name),
}

impl Origin {
    /// The whole file, or the object of an entry.
    pub fn whole(path: &Path, format: Format) -> Self {
        Self { file: Arc::from(path), format, part: Part::Whole }
    }

    /// A line of a file in XML, counted from 1.
    pub fn line(file: &Arc<Path>, line: u32) -> Self {
        Self { file: Arc::clone(file), format: Format::Xml, part: Part::Line(line) }
    }

    /// An entry of the object at this origin.
    pub fn entry(&self, key: &Name) -> Self {
        Self { part: Part::Entry(key.clone()), ..self.clone() }
    }

    /// Object that is an entry of the object at this origin. `separator` stands before its key.
    pub fn object(&self, separator: &str, key: &str) -> Self {
        let path = format!("{}{separator}{key}", self.file.display());
        Self { file: Arc::from(PathBuf::from(path)), format: self.format, part: Part::Whole }
    }

    pub fn error(&self, message: impl Into<String>) -> Error {
        match &self.part {
            Part::Line(line) => Error::scene(&self.file, Some(*line), message),
            Part::Whole => Error::scene(&self.file, None, message),
            Part::Entry(_) => Error::scene(Path::new(&self.to_string()), None, message),
        }
    }

    /// The line alone, or the entry, for names of things that have none.
    pub fn brief(&self) -> String {
        match self.part {
            Part::Line(line) => format!("line {line}"),
            _ => self.to_string(),
        }
    }

    /// The kind of an object or a value by its name in XML, in the words of the format.
    pub fn word(&self, name: &str) -> String {
        self.format.word(name)
    }
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        match &self.part {
            Part::Whole => Ok(()),
            Part::Line(line) => write!(f, ":{line}"),
            Part::Entry(key) => write!(f, ".{key}"),
        }
    }
}

/// Name in snake_case, however a scene spells it: `toWorld` becomes `to_world`, `intIOR` becomes `int_ior`.
pub(in crate::scene) fn snake_case(name: &str) -> Cow<'_, str> {
    if !name.bytes().any(|byte| byte.is_ascii_uppercase()) {
        return Cow::Borrowed(name);
    }
    let mut result = String::with_capacity(name.len() + 4);
    let mut after_lower = false;
    for c in name.chars() {
        if c.is_ascii_uppercase() && after_lower {
            result.push('_');
        }
        after_lower = c.is_ascii_lowercase() || c.is_ascii_digit();
        result.push(c.to_ascii_lowercase());
    }
    Cow::Owned(result)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_spellings_give_one_key() {
        for (old, new) in [
            ("toWorld", "to_world"),
            ("rrDepth", "rr_depth"),
            ("intIOR", "int_ior"),
            ("principalPointOffsetX", "principal_point_offset_x"),
            ("fov", "fov"),
            ("crop_offset_x", "crop_offset_x"),
        ] {
            assert_eq!(snake_case(old), new);
        }
    }

    #[test]
    fn each_format_has_its_words() {
        let words = |format: Format| ["sensor", "texture"].map(|name| format.word(name));
        assert_eq!(words(Format::Xml), ["<sensor>", "<texture>"]);
        assert_eq!(words(Format::Dictionary), ["`sensor`", "`texture`"]);
        assert_eq!(words(Format::Foreign), ["camera", "texture"]);
    }

    #[test]
    fn entries_are_named_by_their_keys() {
        let root = Origin::whole(Path::new("a.glb"), Format::Foreign);
        let wood = root.object(": ", "wood");
        assert_eq!(wood.entry(&"roughness".into()).to_string(), "a.glb: wood.roughness");
        assert_eq!(wood.object(".", "bsdf").error("no").to_string(), "a.glb: wood.bsdf: no");
        assert_eq!(Origin::line(&Arc::from(Path::new("a.xml")), 7).error("no").to_string(), "a.xml:7: no");
    }
}
