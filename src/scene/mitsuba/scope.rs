//! Facts of the whole file that every reader of a plugin needs: objects by `id`, and folders of files.

use std::collections::HashMap;
use std::rc::Rc;

use super::element::Element;
use super::folders::Folders;
use crate::Result;

/// Facts of the whole file, as readers share them.
pub(super) type Scope<'a> = Rc<Whole<'a>>;

/// Facts of the whole file.
pub(super) struct Whole<'a> {
    /// Objects of the scene by their `id`.
    objects: HashMap<&'a str, &'a Element>,
    /// Folders in which files are searched.
    pub folders: Folders,
    /// Number of meshes in memory.
    pub mesh_count: usize,
}

impl<'a> Whole<'a> {
    /// Collects ids at any depth, before references are followed: a `ref` may precede its object.
    pub fn new(elements: &'a [Element], folders: Folders, mesh_count: usize) -> Result<Self> {
        let mut objects = HashMap::new();
        collect_ids(elements, &mut objects)?;
        for alias in elements.iter().filter(|element| element.tag == "alias") {
            let (id, name) = (alias.required("id")?, alias.required("as")?);
            let object =
                *objects.get(id).ok_or_else(|| alias.error(format!("nothing in the scene has the id `{id}`")))?;
            if let Some(first) = objects.insert(name, object) {
                return Err(alias.error(format!("the id `{name}` is already used at {}", first.location)));
            }
        }
        Ok(Self { objects, folders, mesh_count })
    }

    /// Object that a `<ref>` refers to.
    pub fn follow(&self, reference: &Element) -> Result<&'a Element> {
        let id = reference.required("id")?;
        let object = self.objects.get(id).copied();
        object.ok_or_else(|| reference.error(format!("nothing in the scene has the id `{id}`")))
    }
}

fn collect_ids<'a>(elements: &'a [Element], objects: &mut HashMap<&'a str, &'a Element>) -> Result<()> {
    for element in elements {
        if let Some(id) = element.attribute("id").filter(|_| element.is_object())
            && let Some(first) = objects.insert(id, element)
        {
            return Err(element.error(format!("the id `{id}` is already used at {}", first.location)));
        }
        collect_ids(&element.children, objects)?;
    }
    Ok(())
}
