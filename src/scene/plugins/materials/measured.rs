//! Reader of `measured`: a material in a file of its own.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;
use std::sync::Arc;

use super::super::properties::Properties;
use crate::scene::bsdf::{Bsdf, Material, MaterialKind, MeasuredBsdf, SurfaceMaterial};
use crate::scene::measured::Measured;
use crate::{Result, inputs};

/// Largest file, in bytes.
const MOST_BYTES: u64 = 1 << 30;

/// Files of measured materials of a scene while it is read: each is read once.
#[derive(Default)]
pub(super) struct MeasuredFiles {
    known: HashMap<PathBuf, Arc<Measured>>,
}

impl MeasuredFiles {
    /// Reads a `measured`.
    pub fn read(&mut self, properties: &mut Properties) -> Result<Bsdf> {
        let (found, parameter) = properties.file("filename", "measured material")?;
        if let Some(tables) = self.known.get(&found.path) {
            return Ok(Bsdf::Measured(MeasuredBsdf { tables: Arc::clone(tables) }));
        }
        let content = match &found.bytes {
            Some(bytes) => bytes.to_vec(),
            None => inputs::read(&found.path, MOST_BYTES)?,
        };
        let tables = Measured::read(&content)
            .map_err(|message| parameter.error(format!("the measured material `{}` {message}", parameter.text())))?;
        let tables = Arc::new(tables);
        self.known.insert(found.path, Arc::clone(&tables));
        Ok(Bsdf::Measured(MeasuredBsdf { tables }))
    }
}

/// Numbers of words of the tables of all measured materials, each table once.
pub(in crate::scene::plugins) fn word_counts(materials: &[Material]) -> Vec<u64> {
    let tables = materials.iter().filter_map(|material| match &material.kind {
        MaterialKind::Surface(SurfaceMaterial { bsdf: Bsdf::Measured(measured), .. }) => Some(&measured.tables),
        _ => None,
    });
    let mut seen = HashSet::new();
    tables.filter(|tables| seen.insert(Arc::as_ptr(tables))).map(|tables| tables.word_count()).collect()
}
