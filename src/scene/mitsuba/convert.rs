//! Writer of Mitsuba scenes: one XML file, and a folder of the files that it names.

use std::collections::{HashMap, HashSet};
use std::ffi::OsStr;
use std::fs;
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::image::texels;
use crate::scene::description::kinds::Kind;
use crate::scene::description::object::{Entry, MESH, Object, Spectrum, Value};
use crate::scene::description::origin::{Origin, snake_case};
use crate::scene::description::transform::{Operation, Transform};
use crate::scene::description::{Alias, Description};
use crate::scene::folders::FoundFile;
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

/// Writes a description that was read without a fault. Meshes in memory become binary PLY files, and images in memory become
/// files. Returns the number of files beside the scene.
pub(in crate::scene) fn write(description: &Description, target: &Target) -> Result<usize> {
    let &Target { output, overwrite, fitted } = target;
    if !files::has_extension(output, "xml") {
        return Err(Error::Settings(format!("{}: the name of a scene must end in .xml", output.display())));
    }
    let folder = output.with_extension("");
    if let Some(taken) = [output, &folder].into_iter().find(|path| !overwrite && path.exists()) {
        let message = "it exists already; name another file, or replace it with --overwrite";
        return Err(Error::Settings(format!("{}: {message}", taken.display())));
    }
    let (copies, meshes, names) = (HashMap::new(), HashMap::new(), HashSet::new());
    let mut writer = Writer { description, folder, copies, meshes, names, text: String::new() };
    // Mitsuba renders no scene without these.
    if !description.has(Kind::Integrator) {
        writer.text += "    <integrator type=\"path\"/>\n";
    }
    if !description.has(Kind::Sensor) {
        writer.text += &fitted_sensor(fitted);
    }
    for entry in &description.entries {
        // The id names an object of the scene.
        let name = if matches!(entry.value, Value::Object(_)) { "" } else { &*entry.name };
        writer.entry(name, entry, &description.origin_of(entry), 1)?;
    }
    for Alias { id, name, .. } in &description.aliases {
        writer.open(1, "alias", &[("id", id), ("as", name)]);
        writer.text += "/>\n";
    }
    let text = format!("<scene version=\"{VERSION}\">\n{}</scene>\n", writer.text);
    files::write_whole(output, |file| file.write_all(text.as_bytes()))?;
    Ok(writer.names.len())
}

/// Text of the camera that was fitted to a scene, with its film.
fn fitted_sensor(scene: &Scene) -> String {
    let Camera { world_from_camera, fov, fov_axis, near_clip, far_clip, .. } = &scene.camera;
    let rows = joined(&world_from_camera.transpose().to_cols_array());
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
    description: &'a Description,
    /// Folder of the files that the scene names.
    folder: PathBuf,
    /// Names in the folder by the canonical path of the copied file.
    copies: HashMap<PathBuf, String>,
    /// Names in the folder of the meshes in memory, by their addresses.
    meshes: HashMap<*const Mesh, String>,
    /// Names in the folder, in lower case.
    names: HashSet<String>,
    text: String,
}

impl Writer<'_> {
    fn object(&mut self, name: &str, object: &Object, depth: usize) -> Result<()> {
        let plugin = if object.plugin == MESH { "ply" } else { &object.plugin };
        let id = object.id.as_deref().unwrap_or_default();
        let tag = object.kind.name();
        self.open(depth, tag, &[("name", name), ("type", plugin), ("id", id)]);
        if object.entries.is_empty() {
            self.text += "/>\n";
            return Ok(());
        }
        self.text += ">\n";
        for entry in &object.entries {
            self.entry(&snake_case(&entry.name), entry, &object.origin_of(entry), depth + 1)?;
        }
        self.text += &format!("{}</{tag}>\n", "    ".repeat(depth));
        Ok(())
    }

    fn entry(&mut self, name: &str, entry: &Entry, origin: &Origin, depth: usize) -> Result<()> {
        let (tag, value) = match &entry.value {
            Value::Object(object) => return self.object(name, object, depth),
            Value::Reference(id) => {
                self.open(depth, "ref", &[("name", name), ("id", id)]);
                self.text += "/>\n";
                return Ok(());
            }
            Value::Transform(transform) => {
                self.transform(&[("name", name)], transform, depth);
                return Ok(());
            }
            Value::Animation(keys) => {
                self.open(depth, "animation", &[("name", name)]);
                self.text += ">\n";
                for (time, transform) in keys {
                    self.transform(&[("time", &format!("{time:?}"))], transform, depth + 1);
                }
                self.text += &format!("{}</animation>\n", "    ".repeat(depth));
                return Ok(());
            }
            // The scene was read, so nothing needs what was faulty.
            Value::Fault(_) => return Ok(()),
            Value::Spectrum(Spectrum::File(file)) => {
                let file = self.copy_named(file, origin)?;
                self.open(depth, "spectrum", &[("name", name), ("filename", &file)]);
                self.text += "/>\n";
                return Ok(());
            }
            Value::Boolean(value) => ("boolean", value.to_string()),
            Value::Integer(value) => ("integer", value.to_string()),
            Value::Float(value) => ("float", format!("{value:?}")),
            Value::Text(file) if name == "filename" => ("string", self.copy_named(file, origin)?),
            Value::Text(text) => ("string", text.clone()),
            Value::Image(image) => {
                let path = PathBuf::from(&image.name);
                let common = texels::common(&path, &image.bytes)?;
                let bytes = common.map_or_else(|| Arc::clone(&image.bytes), Arc::from);
                let source = FoundFile { path, bytes: Some(bytes) };
                ("string", self.copy(source)?)
            }
            Value::Mesh(mesh) => ("string", self.mesh(mesh)?),
            Value::Grid(_) => {
                return Err(origin.error("media that are grids cannot be converted; render the scene as it is"));
            }
            Value::Point(numbers) => ("point", joined(numbers)),
            Value::Vector(numbers) => ("vector", joined(numbers)),
            Value::Array(numbers) => ("vector", joined(numbers)),
            Value::Rgb(color) | Value::Spectrum(Spectrum::Rgb(color)) => ("rgb", joined(color)),
            Value::Srgb(color) => ("srgb", joined(color)),
            Value::Spectrum(Spectrum::Uniform(value)) => ("spectrum", format!("{value:?}")),
            Value::Spectrum(Spectrum::Points(points)) => {
                let pairs = points.iter().map(|[wavelength, value]| format!("{wavelength:?}:{value:?}"));
                ("spectrum", pairs.collect::<Vec<_>>().join(", "))
            }
        };
        let name = if matches!(entry.value, Value::Mesh(_)) { "filename" } else { name };
        self.open(depth, tag, &[("name", name)]);
        self.attribute("value", &value);
        self.text += "/>\n";
        Ok(())
    }

    fn transform(&mut self, attributes: &[(&str, &str)], transform: &Transform, depth: usize) {
        self.open(depth, "transform", attributes);
        self.text += ">\n";
        for operation in &transform.operations {
            let (tag, attributes) = match operation {
                Operation::Translate(by) => ("translate", vec![("value", joined(by))]),
                Operation::Scale(by) => ("scale", vec![("value", joined(by))]),
                Operation::Rotate { axis, degrees } => {
                    ("rotate", vec![("value", joined(axis)), ("angle", joined(&[*degrees]))])
                }
                Operation::LookAt { origin, target, up } => {
                    let points = [("origin", origin), ("target", target), ("up", up)];
                    ("lookat", points.map(|(name, point)| (name, joined(point))).into())
                }
                Operation::Matrix(rows) => ("matrix", vec![("value", joined(rows))]),
            };
            self.open(depth + 1, tag, &[]);
            attributes.iter().for_each(|(name, value)| self.attribute(name, value));
            self.text += "/>\n";
        }
        self.text += &format!("{}</transform>\n", "    ".repeat(depth));
    }

    /// Begins an element with those attributes that are not empty.
    fn open(&mut self, depth: usize, tag: &str, attributes: &[(&str, &str)]) {
        self.text += &format!("{}<{tag}", "    ".repeat(depth));
        attributes.iter().filter(|(_, value)| !value.is_empty()).for_each(|(name, value)| self.attribute(name, value));
    }

    fn attribute(&mut self, name: &str, value: &str) {
        self.text += &format!(" {name}=\"{}\"", escaped(value));
    }

    /// Writes a mesh that lies in memory, once, and returns the name of its file.
    fn mesh(&mut self, mesh: &Arc<Mesh>) -> Result<String> {
        if let Some(name) = self.meshes.get(&Arc::as_ptr(mesh)) {
            return Ok(self.relative(name));
        }
        let name = self.new_name(OsStr::new(&format!("mesh-{}.ply", self.meshes.len())));
        let path = self.make_folder()?.join(&name);
        files::write_whole(&path, |file| ply_writer::write(mesh, file))?;
        self.meshes.insert(Arc::as_ptr(mesh), name.clone());
        Ok(self.relative(&name))
    }

    /// Copies the file of that name, and returns its name relative to the scene.
    fn copy_named(&mut self, name: &str, origin: &Origin) -> Result<String> {
        // The scene has been read, so a file that is not there is one that nothing needs.
        match self.description.folders.find(name, &origin.file).and_then(|path| path.canonicalize().ok()) {
            Some(path) => self.copy(FoundFile { path, bytes: None }),
            None => Ok(name.to_owned()),
        }
    }

    /// Copies a file once, and returns its name relative to the scene.
    fn copy(&mut self, file: FoundFile) -> Result<String> {
        let FoundFile { path: source, bytes } = file;
        if let Some(name) = self.copies.get(&source) {
            return Ok(self.relative(name));
        }
        let name = match &bytes {
            Some(bytes) => self.new_name(OsStr::new(&image_name(&source.to_string_lossy(), bytes))),
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

/// Numbers with spaces between them, each in the fewest digits that read back as the same number.
fn joined<T: std::fmt::Debug>(numbers: &[T]) -> String {
    numbers.iter().map(|number| format!("{number:?}")).collect::<Vec<_>>().join(" ")
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
