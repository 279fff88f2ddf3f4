//! Writer of Mitsuba scenes: one XML file, and a folder of the files that it names.

use std::collections::{HashMap, HashSet};
use std::ffi::OsStr;
use std::fs;
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};

use super::description::Description;
use super::document::{self, Document};
use super::element::{Element, MESH, MESH_INDEX};
use super::folders::FoundFile;
use super::transform;
use crate::scene::mesh::{Mesh, ply_writer};
use crate::scene::{Camera, FilmDescription, FovAxis, Scene};
use crate::{Error, Result, files, inputs};

/// Version of the format that is written.
const VERSION: &str = "3.0.0";

/// Place of a scene to write.
pub(in crate::scene) struct Target<'a> {
    /// File of the scene.
    pub output: &'a Path,
    /// Whether older files may be replaced.
    pub overwrite: bool,
    /// The scene as it was read. Its camera is written where the document has none.
    pub fitted: &'a Scene,
}

/// Writes the file at `input`, which is in XML. Returns the number of files beside the scene.
pub(in crate::scene) fn write_xml(input: &Path, defines: &[(String, String)], target: &Target) -> Result<usize> {
    write(&document::read(input, defines)?, target)
}

/// Writes a description. Meshes in memory become binary PLY files, and images in memory become files. Returns the number of
/// files beside the scene.
pub(in crate::scene) fn write_description(description: Description, target: &Target) -> Result<usize> {
    write(&description.into_document(": ")?, target)
}

fn write(document: &Document, target: &Target) -> Result<usize> {
    let &Target { output, overwrite, fitted } = target;
    if !files::has_extension(output, "xml") {
        return Err(Error::Settings(format!("{}: the name of a scene must end in .xml", output.display())));
    }
    let folder = output.with_extension("");
    if let Some(taken) = [output, &folder].into_iter().find(|path| !overwrite && path.exists()) {
        let message = "it exists already; name another file, or replace it with --overwrite";
        return Err(Error::Settings(format!("{}: {message}", taken.display())));
    }
    let mut writer = Writer { document, folder, copies: HashMap::new(), names: HashSet::new(), text: String::new() };
    let has = |tag: &str| document.elements.iter().any(|element| element.tag == tag);
    // Mitsuba renders no scene without these.
    if !has("integrator") {
        writer.text += "    <integrator type=\"path\"/>\n";
    }
    if !has("sensor") {
        writer.text += &fitted_sensor(fitted);
    }
    writer.elements(&document.elements, 1)?;
    let text = format!("<scene version=\"{VERSION}\">\n{}</scene>\n", writer.text);
    files::write_whole(output, |file| file.write_all(text.as_bytes()))?;
    Ok(writer.names.len())
}

/// Text of the camera that was fitted to a scene, with its film.
fn fitted_sensor(scene: &Scene) -> String {
    let Camera { world_from_camera, fov, fov_axis, near_clip, far_clip, .. } = &scene.camera;
    let rows = world_from_camera.transpose().to_cols_array().map(|value| format!("{value:?}")).join(" ");
    let axis = match fov_axis {
        FovAxis::X => "x",
        FovAxis::Y => "y",
        FovAxis::Diagonal => "diagonal",
        FovAxis::Smaller => "smaller",
        FovAxis::Larger => "larger",
    };
    let FilmDescription { width, height, .. } = &scene.film;
    let float = |name: &str, value: &f32| format!("        <float name=\"{name}\" value=\"{value:?}\"/>\n");
    let integer = |name: &str, value: &u32| format!("            <integer name=\"{name}\" value=\"{value}\"/>\n");
    [
        "    <sensor type=\"perspective\">\n",
        &format!("        <transform name=\"to_world\"><matrix value=\"{rows}\"/></transform>\n"),
        &float("fov", fov),
        &format!("        <string name=\"fov_axis\" value=\"{axis}\"/>\n"),
        &float("near_clip", near_clip),
        &float("far_clip", far_clip),
        "        <film type=\"hdrfilm\">\n",
        &integer("width", width),
        &integer("height", height),
        "        </film>\n    </sensor>\n",
    ]
    .concat()
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
        let is_mesh = element.attribute("type") == Some(MESH);
        for (name, value) in &element.attributes {
            let value = match name.as_str() {
                // The id names an object of the scene.
                "name" if depth == 1 && element.is_object() => continue,
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
        let found = self.document.folders.find_any(name, &element.location.file);
        let Some(FoundFile { path: source, bytes }) = found else { return Ok(name.to_owned()) };
        if let Some(name) = self.copies.get(&source) {
            return Ok(self.relative(name));
        }
        let name = match &bytes {
            Some(bytes) => self.new_name(OsStr::new(&image_name(name, bytes))),
            None => self.new_name(source.file_name().unwrap_or_default()),
        };
        let target = self.make_folder()?.join(&name);
        match bytes {
            Some(bytes) => files::write_whole(&target, |file| file.write_all(&bytes))?,
            // A scene beside its own files: nothing is to be copied.
            None if target.canonicalize().is_ok_and(|target| target == source) => {}
            None => {
                let (reader, length) = inputs::open(&source)?;
                files::write_whole(&target, |file| io::copy(&mut reader.take(length), file).map(drop))?;
            }
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

/// Name for the file of an image in memory, with the extension of its format.
fn image_name(name: &str, bytes: &[u8]) -> String {
    let stem: String = name.chars().map(|c| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect();
    let extension = match bytes {
        [0x89, b'P', b'N', b'G', ..] => ".png",
        [0xff, 0xd8, ..] => ".jpg",
        [0x76, 0x2f, 0x31, 0x01, ..] => ".exr",
        _ => "",
    };
    if stem.to_lowercase().ends_with(extension) { stem } else { stem + extension }
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
