//! What two readings of a scene are known by to be the same.

use std::io;

use rayon::prelude::*;
use serde::Serialize;
use xxhash_rust::xxh3::Xxh3;

use super::Scene;
use crate::{Error, Result};

/// Primitives that one task hashes.
const CHUNK: usize = 1 << 14;

/// A hash (XXH3, 128 bits, in hexadecimal) of everything read that can change a picture: geometry, materials, emitters,
/// texels, camera, film and integrator, after definitions and transformations. Names, warnings and where the files lie have
/// no part in it, so a scene may be moved.
///
/// # Errors
/// Where a part of the scene cannot be written down, which no part is known to refuse.
pub fn fingerprint(scene: &Scene) -> Result<String> {
    // Every field by name, so that a new one cannot be forgotten.
    let Scene {
        name: _,
        warnings: _,
        camera,
        film,
        integrator,
        sample_count,
        primitives,
        materials,
        emitters,
        environment,
        delta_emitters,
        textures,
        images,
    } = scene;
    let primitives = (primitives.len(), hashes(primitives.par_chunks(CHUNK))?);
    let images = hashes(images.par_iter())?;
    let small = (camera, film, integrator, sample_count, materials, emitters, environment, delta_emitters, textures);
    Ok(format!("{:032x}", hash(&(primitives, images, small))?))
}

fn hashes<T: Serialize>(items: impl IndexedParallelIterator<Item = T>) -> Result<Vec<u128>> {
    items.map(|item| hash(&item)).collect()
}

fn hash(value: &impl Serialize) -> Result<u128> {
    let failed = |error| Error::Render(format!("the scene cannot be hashed: {error}"));
    Ok(postcard::to_io(value, Sink(Box::default())).map_err(failed)?.0.digest128())
}

/// Hashes what is written to it.
struct Sink(Box<Xxh3>);

impl io::Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
