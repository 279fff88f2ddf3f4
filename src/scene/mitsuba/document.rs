//! XML text to [`Element`]s. `<default>`, `$name`, `-D`, `<include>` and `<path>` are resolved here and seen nowhere
//! else.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use roxmltree::Node;

use super::budget::{self, Budget};
use super::element::{Attributes, Element, word};
use super::values::rotation_warning;
use crate::scene::description::kinds::{Kind, Type};
use crate::scene::description::origin::Origin;
use crate::scene::faults::Faults;
use crate::scene::folders::Folders;
use crate::scene::formats;
use crate::scene::text::{self, Decoded};
use crate::{Error, Result, inputs, quoted};

pub(super) use super::budget::MAX_ELEMENT_DEPTH;

const MAX_INCLUDE_DEPTH: usize = 16;
/// Most warnings after which text between elements is no longer told.
const MOST_WARNINGS: usize = 1000;

/// Elements that are neither objects nor parameters.
const OTHER_TAGS: [&str; 6] = ["lookat", "matrix", "ref", "rotate", "scale", "translate"];

/// Invisible characters that count as space between elements: the zero-width space and the byte order mark.
const INVISIBLE: [char; 2] = ['\u{200b}', '\u{feff}'];

/// Scene file with all its includes.
pub(super) struct Document {
    /// Elements that stand directly in `<scene>`.
    pub elements: Vec<Element>,
    /// Folders in which files are searched.
    pub folders: Folders,
    pub warnings: Vec<String>,
    /// Elements that are not supported.
    pub faults: Faults,
}

/// Reads the file at `path` with all its includes.
pub(super) fn read(path: &Path, defines: &[(String, String)]) -> Result<Document> {
    let mut reader = Reader {
        folders: Folders::new(path),
        warnings: Vec::new(),
        faults: Faults::default(),
        is_old: false,
        parameters: defines.iter().cloned().collect(),
        known: HashSet::new(),
        open_files: Vec::new(),
        budget: Budget::default(),
    };
    let elements = reader.read_file(path)?;
    for (name, _) in defines {
        if !reader.known.contains(name) {
            let message = format!("-D {name}: the scene neither has a <default> of that name nor uses ${name}");
            return Err(Error::scene(path, None, message));
        }
    }
    let Reader { folders, warnings, faults, .. } = reader;
    Ok(Document { elements, folders, warnings, faults })
}

struct Reader {
    folders: Folders,
    warnings: Vec<String>,
    faults: Faults,
    /// Whether the file being read is of a version before 2.
    is_old: bool,
    /// Values of `$name`.
    parameters: HashMap<String, String>,
    /// Names that a `<default>` gave or a `$name` used.
    known: HashSet<String>,
    /// Canonical paths of the includes being read, from the outermost.
    open_files: Vec<PathBuf>,
    budget: Budget,
}

/// Data that all nodes of one file share.
struct File {
    path: Arc<Path>,
    /// Byte offsets at which lines start. Asking roxmltree for each node's line would take quadratic time.
    line_starts: Vec<u32>,
}

impl File {
    fn location(&self, node: Node) -> Origin {
        let line = self.line_starts.partition_point(|&start| start as usize <= node.range().start);
        Origin::line(&self.path, line as u32)
    }
}

impl Reader {
    fn read_file(&mut self, path: &Path) -> Result<Vec<Element>> {
        let Decoded { text, .. } = self.read_text(path)?;
        let canonical = path.canonicalize().map_err(Error::read(path))?;
        self.open_files.push(canonical);
        let options = roxmltree::ParsingOptions { nodes_limit: budget::MOST_NODES, ..Default::default() };
        let document = roxmltree::Document::parse_with_options(&text, options);
        let document = document.map_err(|error| xml_error(path, &text, &error))?;
        let line_starts = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at as u32 + 1)).collect();
        let file = File { path: Arc::from(path), line_starts };
        let root = document.root_element();
        let mut elements = Vec::new();
        let outer_is_old = self.is_old;
        if root.tag_name().name() == "scene" {
            self.is_old = root.attribute("version").map_or(outer_is_old, is_old);
            self.read_children(root, &file, 0, &mut elements)?;
        } else if self.open_files.len() > 1 {
            // An include may hold a single object.
            self.read_node(root, &file, 0, &mut elements)?;
        } else {
            let message = format!("not a Mitsuba scene: the root element is {}", tag_name(root.tag_name().name()));
            return Err(file.location(root).error(message));
        }
        self.is_old = outer_is_old;
        self.open_files.pop();
        Ok(elements)
    }

    /// Text of a file, whose elements and attributes are within the limits.
    fn read_text(&mut self, path: &Path) -> Result<Decoded> {
        let mut decoded = text::decode(inputs::read(path, budget::MOST_BYTES)?).map_err(|(bytes, at)| {
            let message = match bytes.contains(&0) {
                true => format!("it is no text; a scene is a file in {}", formats::with_extensions()),
                false => "the text is neither UTF-8, nor UTF-16 or Latin-1 that is marked as such".to_owned(),
            };
            Error::scene(path, Some(line_at(&bytes, at)), message)
        })?;
        if self.open_files.is_empty() && !decoded.text.trim_start().starts_with('<') {
            let message = format!("it is no XML; a scene is a file in {}", formats::with_extensions());
            return Err(Error::scene(path, Some(1), message));
        }
        blank_document_type(&mut decoded.text);
        self.budget
            .count(&decoded)
            .map_err(|(at, message)| Error::scene(path, Some(line_at(decoded.text.as_bytes(), at)), message))?;
        Ok(decoded)
    }

    fn read_children(&mut self, parent: Node, file: &File, depth: usize, into: &mut Vec<Element>) -> Result<()> {
        for node in parent.children() {
            if node.is_element() {
                self.read_node(node, file, depth + 1, into)?;
            } else if node.is_text() {
                self.skip_text(node.text().unwrap_or_default(), &file.location(node));
            }
        }
        Ok(())
    }

    /// Skips text between elements, as Mitsuba does. Visible text gets a warning.
    fn skip_text(&mut self, text: &str, location: &Origin) {
        let word = text.split(|c: char| c.is_whitespace() || INVISIBLE.contains(&c)).find(|word| !word.is_empty());
        if let Some(word) = word.filter(|_| self.warnings.len() < MOST_WARNINGS) {
            let word = quoted::word(word);
            self.warnings.push(format!("{location}: text between elements is ignored: {word}"));
        }
    }

    fn read_node(&mut self, node: Node, file: &File, depth: usize, into: &mut Vec<Element>) -> Result<()> {
        let location = file.location(node);
        let mut element = Element {
            tag: word(node.tag_name().name()),
            attributes: self.read_attributes(node, &location)?,
            children: Vec::new(),
            location,
            is_old: self.is_old,
        };
        match &*element.tag {
            "default" => return self.read_default(&element),
            "include" => {
                into.extend(self.read_include(&element)?);
                return Ok(());
            }
            "path" if depth == 1 => return self.read_path(&element),
            // Mitsuba 0.5 and 0.6 use these spellings.
            "lookAt" | "look_at" => element.tag = "lookat".into(),
            _ => {}
        }
        if self.faults.keep(check_tag(&element, depth)).is_none() {
            // Each fault takes more memory than the element.
            return match self.faults.is_full() {
                true => std::mem::take(&mut self.faults).into_result(),
                false => Ok(()),
            };
        }
        self.warnings.extend(rotation_warning(&element));
        self.read_children(node, file, depth, &mut element.children)?;
        element.children.shrink_to_fit();
        into.push(element);
        Ok(())
    }

    fn read_attributes(&mut self, node: Node, location: &Origin) -> Result<Attributes> {
        node.attributes()
            .map(|attribute| {
                let value = self.substitute(attribute.value(), location)?;
                Ok((word(attribute.name()), value.into_boxed_str()))
            })
            .collect()
    }

    /// Replaces every `$name` in `text`.
    fn substitute(&mut self, text: &str, location: &Origin) -> Result<String> {
        let mut parts = text.split('$');
        let mut result = parts.next().unwrap_or_default().to_string();
        for part in parts {
            let end = part.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(part.len());
            let (name, rest) = part.split_at(end);
            let value = self.parameters.get(name).ok_or_else(|| {
                location.error(format!("${name} is not defined: give it a <default> above, or -D {name}=VALUE"))
            })?;
            self.budget.expand(value.len()).map_err(|message| location.error(message))?;
            result.push_str(value);
            result.push_str(rest);
            self.known.insert(name.to_string());
        }
        Ok(result)
    }

    fn read_default(&mut self, element: &Element) -> Result<()> {
        let (name, value) = (element.required("name")?, element.required("value")?);
        self.known.insert(name.to_string());
        self.parameters.entry(name.to_string()).or_insert_with(|| value.to_string());
        Ok(())
    }

    /// Reads a `<path>`, which adds a folder in which files are searched.
    fn read_path(&mut self, element: &Element) -> Result<()> {
        let name = element.required("value")?;
        if !self.folders.add(name, &element.location.file) {
            self.warnings
                .push(format!("{}: the folder `{name}` of a <path> does not exist; ignored", element.location));
        }
        Ok(())
    }

    fn read_include(&mut self, element: &Element) -> Result<Vec<Element>> {
        let name = element.required("filename")?;
        let path = (self.folders.find(name, &element.location.file))
            .ok_or_else(|| element.error(format!("the included file `{name}` does not exist")))?;
        let canonical = path.canonicalize().map_err(Error::read(&path))?;
        if self.open_files.contains(&canonical) {
            return Err(element.error(format!("`{name}` includes itself, directly or through other files")));
        }
        if self.open_files.len() >= MAX_INCLUDE_DEPTH {
            return Err(element.error(format!("`{name}`: includes are nested more than {MAX_INCLUDE_DEPTH} deep")));
        }
        self.budget.include().map_err(|message| element.error(message))?;
        self.read_file(&path)
    }
}

/// Whether a version is before 2: such files are of Mitsuba 0.6.
fn is_old(version: &str) -> bool {
    version.split('.').next().and_then(|major| major.trim().parse::<u32>().ok()).is_some_and(|major| major < 2)
}

/// Name of an element, as messages quote it.
fn tag_name(tag: &str) -> String {
    match tag.len() <= 40 {
        true => format!("<{tag}>"),
        false => quoted::word(tag),
    }
}

/// Refuses unknown elements. `depth` is 1 directly in `<scene>`.
fn check_tag(element: &Element, depth: usize) -> Result<()> {
    let tag = &*element.tag;
    let is_known = Kind::named(tag).is_some() || Type::named(tag).is_some() || OTHER_TAGS.contains(&tag);
    match is_known || (tag == "alias" && depth == 1) {
        true => Ok(()),
        false => Err(element.error(format!("the element {} is not supported", tag_name(tag)))),
    }
}

/// Replaces a `<!DOCTYPE>` that only names the document's type by spaces, as Mitsuba skips it. One that defines something is left to the
/// parser, which refuses it.
fn blank_document_type(text: &mut String) {
    let Some(begin) = text.find("<!DOCTYPE") else { return };
    let Some(length) = text[begin..].find(['>', '[']) else { return };
    if text[begin + length..].starts_with('>') {
        let blank: String = text[begin..=begin + length].chars().map(|c| if c == '\n' { c } else { ' ' }).collect();
        text.replace_range(begin..=begin + length, &blank);
    }
}

/// Line of a byte, counted from 1.
fn line_at(text: &[u8], offset: usize) -> u32 {
    1 + text[..offset.min(text.len())].iter().filter(|&&byte| byte == b'\n').count() as u32
}

fn xml_error(path: &Path, text: &str, error: &roxmltree::Error) -> Error {
    use roxmltree::Error as Xml;
    let (end, word) = (line_at(text.as_bytes(), text.len()), quoted::word);
    let malformed = |message: &str| format!("malformed XML: {message}");
    let (line, message) = match error {
        // These errors carry no position: the missing text is missing at the end.
        Xml::UnclosedRootNode | Xml::UnexpectedEndOfStream | Xml::NoRootNode => (end, malformed(&error.to_string())),
        Xml::NodesLimitReached => (end, budget::too_many_elements()),
        Xml::DtdDetected => {
            let line = line_at(text.as_bytes(), text.find("<!DOCTYPE").unwrap_or(0));
            (
                line,
                "the definitions of a <!DOCTYPE> are not read; write out what they define, and delete them".to_owned(),
            )
        }
        // These quote words of the file, of any length.
        Xml::UnexpectedCloseTag(expected, actual, at) => {
            (at.row, malformed(&format!("{} is closed by {}", word(expected), word(actual))))
        }
        Xml::DuplicatedAttribute(name, at) => {
            (at.row, malformed(&format!("the attribute {} stands twice", word(name))))
        }
        Xml::DuplicatedNamespace(name, at) => {
            (at.row, malformed(&format!("the namespace {} stands twice", word(name))))
        }
        Xml::UnknownNamespace(name, at) => (at.row, malformed(&format!("the namespace {} is not known", word(name)))),
        Xml::UnknownEntityReference(name, at) => {
            (at.row, malformed(&format!("the entity {} is not known", word(name))))
        }
        _ => (error.pos().row, malformed(&quoted::message(error))),
    };
    Error::scene(path, Some(line), message)
}
