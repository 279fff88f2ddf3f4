//! Facts of the whole scene that every reader of a plugin needs: objects by `id`, meshes in memory, folders of files.

use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;

use crate::Result;
use crate::scene::description::Description;
use crate::scene::description::kinds::Kind;
use crate::scene::description::object::{Entry, Object, Value};
use crate::scene::folders::Folders;
use crate::scene::mesh::Mesh;

/// Facts of the whole scene, as readers share them.
pub(super) type Scope<'a> = Rc<Whole<'a>>;

/// Facts of the whole scene.
pub(super) struct Whole<'a> {
    /// Objects of the scene by their `id`.
    objects: HashMap<&'a str, &'a Object>,
    /// Entries of the spectra that have an `id`.
    spectra: HashMap<&'a str, &'a Entry>,
    /// Folders in which files are searched.
    pub folders: &'a Folders,
    /// Meshes in memory.
    pub meshes: Vec<&'a Arc<Mesh>>,
    /// Indices of the meshes by their addresses.
    mesh_indices: HashMap<*const Mesh, usize>,
}

impl<'a> Whole<'a> {
    /// Collects ids at any depth, before references are followed: a reference may precede its object.
    pub fn new(description: &'a Description) -> Result<Self> {
        let mut whole = Self {
            objects: HashMap::new(),
            spectra: HashMap::new(),
            folders: &description.folders,
            meshes: Vec::new(),
            mesh_indices: HashMap::new(),
        };
        whole.collect(&description.entries)?;
        for alias in &description.aliases {
            let object = whole.find(&alias.id).map_err(|message| alias.origin.error(message))?;
            if let Some(first) = whole.objects.insert(&alias.name, object) {
                let message = format!("the id `{}` is already used at {}", alias.name, first.origin);
                return Err(alias.origin.error(message));
            }
        }
        Ok(whole)
    }

    /// Object of that id. The error says that there is none.
    pub fn find(&self, id: &str) -> Result<&'a Object, String> {
        self.objects.get(id).copied().ok_or_else(|| format!("nothing in the scene has the id `{id}`"))
    }

    /// Entry of the spectrum of that id.
    pub fn spectrum(&self, id: &str) -> Option<&'a Entry> {
        self.spectra.get(id).copied()
    }

    /// Index of a mesh in memory.
    pub fn mesh_index(&self, mesh: &Arc<Mesh>) -> Option<usize> {
        self.mesh_indices.get(&Arc::as_ptr(mesh)).copied()
    }

    fn collect(&mut self, entries: &'a [Entry]) -> Result<()> {
        for entry in entries {
            match &entry.value {
                Value::Object(object) => {
                    if let Some(id) = object.id.as_deref().filter(|_| object.kind != Kind::Spectrum)
                        && let Some(first) = self.objects.insert(id, object)
                    {
                        return Err(object.error(format!("the id `{id}` is already used at {}", first.origin)));
                    }
                    if let Some(id) = object.id.as_deref().filter(|_| object.kind == Kind::Spectrum) {
                        self.spectra.entry(id).or_insert(entry);
                    }
                    self.collect(&object.entries)?;
                }
                Value::Mesh(mesh) => {
                    self.mesh_indices.entry(Arc::as_ptr(mesh)).or_insert_with(|| {
                        self.meshes.push(mesh);
                        self.meshes.len() - 1
                    });
                }
                _ => {}
            }
        }
        Ok(())
    }
}
