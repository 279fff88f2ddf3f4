//! Files of a USD scene: its layers and textures, on the disk and in archives.

use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::io::{self, Cursor};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use openusd::ar::{
    Asset, DefaultResolver, ResolvedPath, Resolver, is_package_relative_path, join_package_relative_path,
    split_package_relative_path_outer,
};

use super::archive::Archive;
use super::layers;
use crate::inputs;

/// Most bytes of a layer, an archive or a texture.
const MAX_BYTES: u64 = 4 << 30;
/// Most bytes of all layers, each counted as often as it is read.
const MOST_LAYER_BYTES: u64 = 8 << 30;

/// Files of a scene. Clones share the archives.
#[derive(Clone, Default)]
pub(super) struct Files {
    archives: Rc<RefCell<HashMap<PathBuf, Option<Rc<Archive>>>>>,
    read: Rc<Cell<u64>>,
}

impl Files {
    /// The archive at `path`. The error says why it cannot be read.
    pub fn archive(&self, path: &Path) -> io::Result<Rc<Archive>> {
        if let Some(known) = self.archives.borrow().get(path) {
            return known.clone().ok_or_else(|| io::Error::other("the archive cannot be read"));
        }
        let bytes = inputs::read(path, MAX_BYTES).map_err(io::Error::other);
        let archive = bytes.and_then(|bytes| Archive::new(bytes).map_err(io::Error::other).map(Rc::new));
        self.archives.borrow_mut().insert(path.to_path_buf(), archive.as_ref().ok().cloned());
        archive
    }

    /// Content of a file by its resolved path, which may lie in an archive: `model.usdz[image.png]`.
    pub fn bytes(&self, path: &str) -> io::Result<Vec<u8>> {
        match split_package_relative_path_outer(path).filter(|_| is_package_relative_path(path)) {
            Some((package, inner)) => {
                let archive = self.archive(Path::new(&package))?;
                let bytes = archive.get(&inner);
                bytes
                    .map(<[u8]>::to_vec)
                    .ok_or_else(|| io::Error::other(format!("there is no `{inner}` in the archive")))
            }
            None => inputs::read(Path::new(path), MAX_BYTES).map_err(io::Error::other),
        }
    }
}

impl Resolver for Files {
    fn create_identifier(&self, asset_path: &str, anchor: Option<&ResolvedPath>) -> String {
        DefaultResolver::new().create_identifier(asset_path, anchor)
    }

    fn resolve(&self, asset_path: &str) -> Option<ResolvedPath> {
        if asset_path.is_empty() {
            return None;
        }
        if is_package_relative_path(asset_path) {
            let (package, inner) = split_package_relative_path_outer(asset_path)?;
            let package = Path::new(&package).canonicalize().ok()?;
            self.archive(&package).ok()?.get(&inner)?;
            return Some(ResolvedPath::new(join_package_relative_path(package.to_str()?, &inner)));
        }
        let path = Path::new(asset_path).canonicalize().ok()?;
        path.is_file().then(|| ResolvedPath::new(path))
    }

    fn resolve_for_new_asset(&self, _: &str) -> Option<ResolvedPath> {
        None
    }

    /// Opens a layer, which is checked before.
    fn open_asset(&self, resolved_path: &ResolvedPath) -> io::Result<Box<dyn Asset>> {
        let bytes = self.bytes(&resolved_path.to_string())?;
        self.read.set(self.read.get() + bytes.len() as u64);
        if self.read.get() > MOST_LAYER_BYTES {
            return Err(io::Error::other("with it, the layers of the scene have more than 8 GiB"));
        }
        layers::check(&bytes).map_err(io::Error::other)?;
        Ok(Box::new(Cursor::new(bytes)))
    }
}
