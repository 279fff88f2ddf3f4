//! Writer of Mitsuba scenes: one XML file, and a folder of the files that it names.

use std::collections::{HashMap, HashSet};
use std::ffi::OsStr;
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use super::dictionary::{self, Dictionary};
use super::document::{self, Document};
use super::element::{Element, MESH, MESH_INDEX};
use super::load::{self, LoadOptions};
use super::transform;
use crate::scene::mesh::{Mesh, ply_writer};
use crate::{Error, Result, files};

/// Version of the format that is written.
const VERSION: &str = "3.0.0";

/// Report of a conversion.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Converted {
    /// Number of files beside the scene, in the folder that has its name.
    pub file_count: usize,
    /// Faults of the scene that do not keep it from being rendered.
    pub warnings: Vec<String>,
}

/// Writes the scene at `input` to `output`, a Mitsuba file of version 3.0.0 that renders the same picture. Includes are
/// spliced in, names with a `$` are replaced by their values, and parameters are in snake_case. Every file that the scene
/// names is copied to the folder beside `output` that has its name without `.xml`. Older files are replaced only if
/// `overwrite` is set.
///
/// # Errors
/// Where the scene cannot be rendered, a file exists, or a file cannot be written.
pub fn convert(input: &Path, options: &LoadOptions, output: &Path, overwrite: bool) -> Result<Converted> {
    let warnings = load::load(input, options)?.warnings;
    let document = document::read(input, &options.defines)?;
    let is_input = |path: PathBuf| input.canonicalize().is_ok_and(|input| input == path);
    if output.canonicalize().is_ok_and(is_input) {
        return Err(Error::Settings(format!("{}: a scene cannot replace itself; name another file", output.display())));
    }
    Ok(Converted { file_count: write(&document, output, overwrite)?, warnings })
}

/// Writes a scene that a dictionary describes, as [`convert`] writes a file. Its meshes become binary PLY files.
///
/// # Errors
/// Where the scene cannot be rendered, a file exists, or a file cannot be written.
pub fn convert_dictionary(scene: &Dictionary, output: &Path, overwrite: bool) -> Result<Converted> {
    let warnings = crate::Scene::from_dictionary(scene)?.warnings;
    Ok(Converted { file_count: write(&dictionary::document(scene)?, output, overwrite)?, warnings })
}

fn write(document: &Document, output: &Path, overwrite: bool) -> Result<usize> {
    if !files::has_extension(output, "xml") {
        return Err(Error::Settings(format!("{}: the name of a scene must end in .xml", output.display())));
    }
    let folder = output.with_extension("");
    if let Some(taken) = [output, &folder].into_iter().find(|path| !overwrite && path.exists()) {
        let message = "it exists already; name another file, or replace it with --overwrite";
        return Err(Error::Settings(format!("{}: {message}", taken.display())));
    }
    let mut writer = Writer { document, folder, copies: HashMap::new(), names: HashSet::new(), text: String::new() };
    writer.elements(&document.elements, 1)?;
    let text = format!("<scene version=\"{VERSION}\">\n{}</scene>\n", writer.text);
    files::write_whole(output, |file| file.write_all(text.as_bytes()))?;
    Ok(writer.names.len())
}

/// Writer of one scene, with what it has written.
struct Writer<'a> {
    document: &'a Document,
    /// Folder of the files that the scene names.
    folder: PathBuf,
    /// Names in the folder by the canonical path of the copied file.
    copies: HashMap<PathBuf, String>,
    /// Names in the folder, in lower case.
    names: HashSet<String>,
    text: String,
}

impl Writer<'_> {
    fn elements(&mut self, elements: &[Element], depth: usize) -> Result<()> {
        elements.iter().try_for_each(|element| self.element(element, depth))
    }

    fn element(&mut self, element: &Element, depth: usize) -> Result<()> {
        let indent = "    ".repeat(depth);
        // Mitsuba 3 does not normalize the axis of a rotation, as 0.6 does, so the rotation becomes a matrix.
        if element.is_old && transform::warning(element)?.is_some() {
            let rows = transform::parse_rotate(element)?.transpose().to_cols_array();
            let rows = rows.map(|value| format!("{value:?}")).join(" ");
            self.text += &format!("{indent}<matrix value=\"{rows}\"/>\n");
            return Ok(());
        }
        self.text += &format!("{indent}<{}", element.tag);
        let is_mesh = element.attribute("type") == Some(MESH) && element.location.line.is_none();
        for (name, value) in &element.attributes {
            let value = match name.as_str() {
                "name" => element.key().unwrap_or_default(),
                "type" if is_mesh => "ply".to_owned(),
                "filename" => self.copy(element, value)?,
                "value" if element.attribute("name") == Some("filename") => self.copy(element, value)?,
                _ => value.clone(),
            };
            self.attribute(name, &value);
        }
        if element.children.is_empty() {
            self.text += "/>\n";
            return Ok(());
        }
        self.text += ">\n";
        for child in &element.children {
            match is_mesh && child.attribute("name") == Some(MESH_INDEX) {
                true => self.mesh(child, depth + 1)?,
                false => self.element(child, depth + 1)?,
            }
        }
        self.text += &format!("{indent}</{}>\n", element.tag);
        Ok(())
    }

    fn attribute(&mut self, name: &str, value: &str) {
        self.text += &format!(" {name}=\"{}\"", escaped(value));
    }

    /// Writes a mesh that lies in memory, and the parameter that names its file.
    fn mesh(&mut self, index: &Element, depth: usize) -> Result<()> {
        let number = index.required("value")?;
        let mesh: Option<&Mesh> = number.parse().ok().and_then(|index: usize| self.document.meshes.get(index));
        let mesh = mesh.ok_or_else(|| index.error(format!("there is no mesh {number}")))?;
        let name = self.new_name(OsStr::new(&format!("mesh-{number}.ply")));
        let path = self.make_folder()?.join(&name);
        files::write_whole(&path, |file| ply_writer::write(mesh, file))?;
        let value = self.relative(&name);
        self.text += &"    ".repeat(depth);
        self.text += &format!("<string name=\"filename\" value=\"{}\"/>\n", escaped(&value));
        Ok(())
    }

    /// Copies the file that an element names, once, and returns its name relative to the scene.
    fn copy(&mut self, element: &Element, name: &str) -> Result<String> {
        // The scene has been read, so a file that is not there is one that nothing needs.
        let Some(source) = self.document.folders.find(name, &element.location.file) else { return Ok(name.to_owned()) };
        let source = source.canonicalize().map_err(Error::read(&source))?;
        if let Some(name) = self.copies.get(&source) {
            return Ok(self.relative(name));
        }
        let name = self.new_name(source.file_name().unwrap_or_default());
        let target = self.make_folder()?.join(&name);
        // A scene beside its own files: nothing is to be copied.
        if !target.canonicalize().is_ok_and(|target| target == source) {
            let mut reader = fs::File::open(&source).map_err(Error::read(&source))?;
            files::write_whole(&target, |file| io::copy(&mut reader, file).map(drop))?;
        }
        let relative = self.relative(&name);
        self.copies.insert(source, name);
        Ok(relative)
    }

    fn make_folder(&self) -> Result<&Path> {
        fs::create_dir_all(&self.folder).map_err(Error::write(&self.folder))?;
        Ok(&self.folder)
    }

    /// Path of a file in the folder, relative to the scene.
    fn relative(&self, name: &str) -> String {
        format!("{}/{name}", self.folder.file_name().unwrap_or_default().to_string_lossy())
    }

    /// Name that no other file of the folder has: `wood.png`, then `wood-2.png`.
    fn new_name(&mut self, wanted: &OsStr) -> String {
        let wanted = wanted.to_string_lossy();
        let (stem, extension) = match wanted.rsplit_once('.') {
            Some((stem, extension)) => (stem, format!(".{extension}")),
            None => (&wanted[..], String::new()),
        };
        let mut name = wanted.to_string();
        let mut count = 1;
        while !self.names.insert(name.to_lowercase()) {
            count += 1;
            name = format!("{stem}-{count}{extension}");
        }
        name
    }
}

/// Text as it stands between the quotes of an attribute.
fn escaped(text: &str) -> String {
    let mut result = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => result += "&amp;",
            '<' => result += "&lt;",
            '>' => result += "&gt;",
            '"' => result += "&quot;",
            '\n' | '\r' | '\t' => result.push(' '),
            c => result.push(c),
        }
    }
    result
}
