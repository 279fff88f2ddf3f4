//! XML text to [`Element`]s. `<default>`, `$name`, `-D` and `<include>` are resolved here and seen nowhere else.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use roxmltree::{Document, Node};

use super::element::{Element, Location, OBJECT_TAGS, PARAMETER_TAGS};
use crate::{Error, Result};

/// Largest scene file in bytes. The bulk of a scene lies in meshes, so a larger file is a mistake.
const MAX_FILE_BYTES: u64 = 64 << 20;
const MAX_INCLUDE_DEPTH: usize = 16;
/// Deepest nesting of elements: far above any nesting of plugins, far below the limit of recursion.
const MAX_ELEMENT_DEPTH: usize = 64;

const TRANSFORM_TAGS: [&str; 5] = ["lookat", "matrix", "rotate", "scale", "translate"];

/// Reads the file at `path` with all its includes. Returns the elements that stand directly in `<scene>`.
pub(super) fn read(path: &Path, defines: &[(String, String)]) -> Result<Vec<Element>> {
    let mut reader = Reader {
        top_folder: folder(path),
        parameters: defines.iter().cloned().collect(),
        known: HashSet::new(),
        open_files: Vec::new(),
    };
    let elements = reader.read_file(path)?;
    for (name, _) in defines {
        if !reader.known.contains(name) {
            let message = format!("-D {name}: the scene neither has a <default> of that name nor uses ${name}");
            return Err(Error::scene(path, None, message));
        }
    }
    Ok(elements)
}

/// Path of the file `name`: relative to the file that names it, or else to the top scene's folder. `None` where neither
/// exists.
pub(super) fn resolve(name: &str, named_in: &Path, top_folder: &Path) -> Option<PathBuf> {
    [folder(named_in).join(name), top_folder.join(name)].into_iter().find(|path| path.is_file())
}

/// Folder of a file, never empty.
pub(super) fn folder(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

struct Reader {
    top_folder: PathBuf,
    /// Values of `$name`.
    parameters: HashMap<String, String>,
    /// Names that a `<default>` gave or a `$name` used.
    known: HashSet<String>,
    /// Canonical paths of the includes being read, from the outermost.
    open_files: Vec<PathBuf>,
}

/// Data that all nodes of one file share.
struct File {
    path: Arc<Path>,
    /// Byte offsets at which lines start. Asking roxmltree for each node's line would take quadratic time.
    line_starts: Vec<usize>,
}

impl File {
    fn location(&self, node: Node) -> Location {
        let line = self.line_starts.partition_point(|&start| start <= node.range().start);
        Location { file: self.path.clone(), line: line as u32 }
    }
}

impl Reader {
    fn read_file(&mut self, path: &Path) -> Result<Vec<Element>> {
        let text = read_text(path)?;
        let canonical = path.canonicalize().map_err(Error::read(path))?;
        self.open_files.push(canonical);
        let document = Document::parse(&text).map_err(|error| xml_error(path, &text, &error))?;
        let line_starts = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
        let file = File { path: Arc::from(path), line_starts };
        let root = document.root_element();
        let mut elements = Vec::new();
        if root.tag_name().name() == "scene" {
            self.read_children(root, &file, 0, &mut elements)?;
        } else if self.open_files.len() > 1 {
            // An include may hold a single object.
            self.read_node(root, &file, 0, &mut elements)?;
        } else {
            let message = format!("not a Mitsuba scene: the root element is <{}>", root.tag_name().name());
            return Err(file.location(root).error(message));
        }
        self.open_files.pop();
        Ok(elements)
    }

    fn read_children(&mut self, parent: Node, file: &File, depth: usize, into: &mut Vec<Element>) -> Result<()> {
        for node in parent.children() {
            if node.is_element() {
                self.read_node(node, file, depth + 1, into)?;
            } else if node.is_text() && node.text().is_some_and(|text| !text.trim().is_empty()) {
                return Err(file.location(node).error("text between elements is not allowed here"));
            }
        }
        Ok(())
    }

    fn read_node(&mut self, node: Node, file: &File, depth: usize, into: &mut Vec<Element>) -> Result<()> {
        let location = file.location(node);
        if depth > MAX_ELEMENT_DEPTH {
            return Err(location.error(format!("elements are nested more than {MAX_ELEMENT_DEPTH} deep")));
        }
        let mut element = Element {
            tag: node.tag_name().name().to_string(),
            attributes: self.read_attributes(node, &location)?,
            children: Vec::new(),
            location,
        };
        match element.tag.as_str() {
            "default" => return self.read_default(&element),
            "include" => {
                into.extend(self.read_include(&element)?);
                return Ok(());
            }
            // Mitsuba 0.5 and 0.6 use these spellings.
            "lookAt" | "look_at" => element.tag = "lookat".to_string(),
            _ => {}
        }
        check_tag(&element)?;
        self.read_children(node, file, depth, &mut element.children)?;
        into.push(element);
        Ok(())
    }

    fn read_attributes(&mut self, node: Node, location: &Location) -> Result<Vec<(String, String)>> {
        node.attributes()
            .map(|attribute| {
                let value = self.substitute(attribute.value(), location)?;
                Ok((attribute.name().to_string(), value))
            })
            .collect()
    }

    /// Replaces every `$name` in `text`.
    fn substitute(&mut self, text: &str, location: &Location) -> Result<String> {
        let mut parts = text.split('$');
        let mut result = parts.next().unwrap_or_default().to_string();
        for part in parts {
            let end = part.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(part.len());
            let (name, rest) = part.split_at(end);
            let value = self.parameters.get(name).ok_or_else(|| {
                location.error(format!("${name} is not defined: give it a <default> above, or -D {name}=VALUE"))
            })?;
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

    fn read_include(&mut self, element: &Element) -> Result<Vec<Element>> {
        let name = element.required("filename")?;
        let path = resolve(name, &element.location.file, &self.top_folder)
            .ok_or_else(|| element.error(format!("the included file `{name}` does not exist")))?;
        let canonical = path.canonicalize().map_err(Error::read(&path))?;
        if self.open_files.contains(&canonical) {
            return Err(element.error(format!("`{name}` includes itself, directly or through other files")));
        }
        if self.open_files.len() >= MAX_INCLUDE_DEPTH {
            return Err(element.error(format!("`{name}`: includes are nested more than {MAX_INCLUDE_DEPTH} deep")));
        }
        self.read_file(&path)
    }
}

fn check_tag(element: &Element) -> Result<()> {
    let tag = element.tag.as_str();
    let known = [&OBJECT_TAGS[..], &PARAMETER_TAGS, &TRANSFORM_TAGS, &["ref"]];
    if known.iter().any(|tags| tags.contains(&tag)) {
        return Ok(());
    }
    Err(element.error(format!("the element <{tag}> is not supported")))
}

fn read_text(path: &Path) -> Result<String> {
    let size = path.metadata().map_err(Error::read(path))?.len();
    if size > MAX_FILE_BYTES {
        let message = format!("a scene file of {size} bytes is refused; the limit is {MAX_FILE_BYTES}");
        return Err(Error::scene(path, None, message));
    }
    let bytes = std::fs::read(path).map_err(Error::read(path))?;
    String::from_utf8(bytes).map_err(|error| {
        let line = line_at(error.as_bytes(), error.utf8_error().valid_up_to());
        Error::scene(path, Some(line), "the text is not UTF-8")
    })
}

/// Line of a byte, counted from 1.
fn line_at(text: &[u8], offset: usize) -> u32 {
    1 + text[..offset.min(text.len())].iter().filter(|&&byte| byte == b'\n').count() as u32
}

fn xml_error(path: &Path, text: &str, error: &roxmltree::Error) -> Error {
    use roxmltree::Error as Xml;
    let line = match error {
        // These errors carry no position: the missing text is missing at the end.
        Xml::UnclosedRootNode | Xml::UnexpectedEndOfStream | Xml::NoRootNode => line_at(text.as_bytes(), text.len()),
        _ => error.pos().row,
    };
    Error::scene(path, Some(line), format!("malformed XML: {error}"))
}
