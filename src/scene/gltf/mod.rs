//! glTF 2.0: `.gltf` and `.glb` files to a description.
//!
//! The conventions agree: right-handed, `+y` up, texture coordinates from the image's top left corner. Photometric units (candela,
//! lux, nits) count as radiometric ones, one for one.

mod accessors;
mod alpha;
mod animation;
mod asset;
mod budget;
mod buffers;
mod choices;
mod compression;
mod corners;
mod film;
mod images;
mod lights;
mod materials;
mod meshes;
mod nodes;
mod pose;
mod relief;
mod skins;
mod specular_glossiness;
mod usual;
mod volume;
mod wearer;

use std::path::Path;

use super::description::Description;
use crate::{Error, Result};
use asset::Asset;
use choices::Choices;
use images::Images;
use lights::Cameras;
use materials::Materials;
use meshes::Meshes;
use nodes::Placed;

/// Reads the file at `path`. The definitions may choose a `time` of its animation, and a `variant` of its materials.
///
/// # Errors
/// Where the file or one of its buffers cannot be read, is damaged, or requires an extension that is not supported.
pub(super) fn read(path: &Path, defines: &[(String, String)]) -> Result<Description> {
    let choices = Choices::of(defines).map_err(|message| Error::scene(path, None, message))?;
    let mut asset = Asset::open(path, &choices)?;
    asset.pose = animation::pose(&asset, choices.time)?;
    let nodes = nodes::placed(&asset)?;
    let mut images = Images::new(&asset);
    let mut materials = Materials::default();
    let mut meshes = Meshes::default();
    let (mut lights, mut cameras) = (Vec::new(), Cameras::default());
    for placed in &nodes {
        let Placed { node, .. } = placed;
        if let Some(mesh) = node.mesh() {
            meshes.place(&asset, placed, &nodes, &mesh, &mut materials, &mut images)?;
        }
        if let Some(light) = node.light() {
            lights.push(lights::light(&asset, placed, &light)?);
        }
        if let Some(camera) = node.camera() {
            cameras.add(&asset, placed, &camera);
        }
    }
    let lights = lights.into_iter().enumerate().map(|(index, light)| (format!("light{index}"), light));
    let shapes = meshes.finish();
    if shapes.is_empty() && cameras.is_empty() {
        return Err(asset.error("its scene has neither triangles nor a camera; points and lines are not rendered"));
    }
    let objects = materials.take_objects().into_iter().chain(lights).chain(shapes).collect::<Vec<_>>();
    let ids = objects.iter().map(|(id, _)| id.clone()).collect();
    let objects = cameras.into_objects(ids).into_iter().chain(objects).collect();
    drop(images);
    Ok(Description { is_photometric: true, ..Description::of_objects(path, objects, asset.into_warnings()) })
}
