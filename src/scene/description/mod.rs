//! Descriptions: what the front end of each format makes of its file, with typed values. The readers of [`plugins`](super::plugins)
//! make the scene of it. Its plugins and parameters are Mitsuba's.

pub(super) mod kinds;
pub(super) mod make;
pub(super) mod object;
pub(super) mod origin;
pub(super) mod transform;

use std::path::{Path, PathBuf};

use super::faults::Faults;
use super::folders::Folders;
use kinds::Kind;
use object::{Entry, Object, Value};
use origin::{Format, Origin};

/// Scene of a file.
#[derive(Debug)]
pub(super) struct Description {
    /// Path of the file. Files that the scene names are relative to its folder.
    pub path: PathBuf,
    pub format: Format,
    /// Objects and parameters that stand directly in the scene.
    pub entries: Vec<Entry>,
    /// Second names of objects.
    pub aliases: Vec<Alias>,
    /// Folders in which files are searched.
    pub folders: Folders,
    /// Whether lights are given in photometric units.
    pub is_photometric: bool,
    /// Sentences about things that were read but are not rendered exactly.
    pub warnings: Vec<String>,
    /// Faults that did not end the reading.
    pub faults: Faults,
}

/// Second name of an object.
#[derive(Debug)]
pub(super) struct Alias {
    pub id: String,
    pub name: String,
    pub origin: Origin,
}

impl Description {
    /// Scene of objects by their keys. A key is the id of an object that has none, and names it in messages: a fault of the object
    /// ``material `Wood` `` reads ``model.glb: material `Wood`.roughness: ...``.
    pub fn of_objects(path: &Path, objects: Vec<(String, Object)>, warnings: Vec<String>) -> Self {
        let root = Origin::whole(path, Format::Foreign);
        let entry = |(key, mut object): (String, Object)| {
            object.place(root.object(": ", &key));
            object.id.get_or_insert_with(|| key.clone());
            Entry { name: key.into(), value: Value::Object(Box::new(object)), origin: None }
        };
        Self { warnings, ..Self::new(path, Format::Foreign, objects.into_iter().map(entry).collect()) }
    }

    /// Scene of these entries and nothing else.
    pub fn new(path: &Path, format: Format, entries: Vec<Entry>) -> Self {
        Self {
            path: path.to_path_buf(),
            format,
            entries,
            aliases: Vec::new(),
            folders: Folders::new(path),
            is_photometric: false,
            warnings: Vec::new(),
            faults: Faults::default(),
        }
    }

    /// Place of an entry that stands directly in the scene.
    pub fn origin_of(&self, entry: &Entry) -> Origin {
        match (&entry.origin, &entry.value) {
            (Some(origin), _) => origin.clone(),
            (None, Value::Object(object)) => object.origin.clone(),
            (None, _) => Origin::whole(&self.path, self.format).entry(&entry.name),
        }
    }

    /// Whether an object of this kind stands directly in the scene.
    pub fn has(&self, kind: Kind) -> bool {
        self.entries.iter().any(|entry| matches!(&entry.value, Value::Object(object) if object.kind == kind))
    }
}
