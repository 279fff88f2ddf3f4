//! Attributes of meshes, such as colors of vertices, as one image for the whole scene: the texture `mesh_attribute` becomes a bitmap.

use std::collections::HashMap;
use std::sync::Arc;

use glam::Vec3;

use super::color_blocks::ColorBlocks;
use super::shape::{Geometry, MeshFile, Shape};
use super::textures::VERTEX_COLORS;
use crate::Result;
use crate::scene::mesh::{Mesh, VERTEX_COLOR};
use crate::scene::texel_pages::PAGE_WORDS;
use crate::scene::texture::{Image, Pattern, Texels};
use crate::scene::{AreaEmitter, Material, MaterialKind, SurfaceMaterial, Texture};

/// Most triangles whose vertices have colors: their blocks fill half of the largest buffer.
const MAX_BLOCKS: u64 = PAGE_WORDS / 16;

/// Names of the attributes that textures show.
pub(super) fn attributes(textures: &[Texture]) -> Vec<String> {
    let is_shown = |texture: &&Texture| matches!(texture.pattern, Pattern::Bitmap { image: VERTEX_COLORS, .. });
    textures.iter().filter(is_shown).map(|texture| texture.name.clone()).collect()
}

/// Scene as far as the colors of vertices depend on it.
pub(super) struct Context<'a> {
    pub materials: &'a [Material],
    pub emitters: &'a [AreaEmitter],
    pub textures: &'a [Texture],
    pub meshes: &'a HashMap<MeshFile, Arc<Mesh>>,
    /// Index that the image of the colors will have.
    pub image: u32,
}

/// Makes the image of the colors, and gives each shape that shows them its blocks; `None` where no texture does.
pub(super) fn make(shapes: &mut [Shape], context: &Context, warnings: &mut Vec<String>) -> Result<Option<Image>> {
    let mut firsts: HashMap<(MeshFile, &str), u32> = HashMap::new();
    let mut colored: Vec<(&Mesh, &str)> = Vec::new();
    let (mut users, mut count) = (Vec::new(), 0_u64);
    for (at, shape) in shapes.iter().enumerate() {
        let Some(attribute) = context.shown_attribute(shape)? else { continue };
        let (file, mesh, values) = context.mesh(shape, attribute)?;
        let key = (file.clone(), attribute);
        let first = match firsts.get(&key) {
            Some(&first) => first,
            None => {
                let first = count as u32;
                check(shape, file, mesh, (attribute, values), warnings)?;
                count += mesh.triangles.len() as u64;
                if count > MAX_BLOCKS {
                    let message = format!("no more than {MAX_BLOCKS} triangles can have vertex colors");
                    return Err(shape.origin.error(message));
                }
                firsts.insert(key, first);
                colored.push((mesh, attribute));
                first
            }
        };
        users.push((at, first));
    }
    if users.is_empty() {
        // A group that no instance shows may have the texture.
        let is_named = context.textures.iter().any(|texture| context.is_colors(texture));
        return Ok(is_named.then(|| image(&[], 1, 1)));
    }
    let columns = (count as f64).sqrt().ceil().max(1.0) as u32;
    let rows = (count as u32).div_ceil(columns);
    for (at, first) in users {
        shapes[at].common.colors = Some(ColorBlocks { first, columns, rows });
    }
    Ok(Some(image(&colored, columns, rows)))
}

fn image(meshes: &[(&Mesh, &str)], columns: u32, rows: u32) -> Image {
    let (width, height) = (2 * columns, 2 * rows);
    let mut texels = vec![[0.0, 0.0, 0.0, 1.0]; width as usize * height as usize];
    let triangles = meshes.iter().flat_map(|(mesh, name)| (0..mesh.triangles.len()).map(move |at| (mesh, name, at)));
    for (block, (mesh, name, triangle)) in triangles.enumerate() {
        let [a, b, c] = mesh.corner_colors(name, triangle).unwrap_or_default();
        let (column, row) = (block % columns as usize, block / columns as usize);
        let upper = 2 * row * width as usize + 2 * column;
        let lower = upper + width as usize;
        for (at, color) in [(upper, a), (upper + 1, b), (lower, c), (lower + 1, b + c - a)] {
            texels[at] = color.extend(1.0).to_array();
        }
    }
    Image { name: "vertex colors".to_string(), width, height, texels: Texels::Floats(texels) }
}

/// Checks the values of an attribute of a mesh.
fn check(
    shape: &Shape,
    file: &MeshFile,
    mesh: &Mesh,
    (attribute, values): (&str, &[Vec3]),
    warnings: &mut Vec<String>,
) -> Result<()> {
    let path = file.path.display();
    let is_color = attribute == VERTEX_COLOR;
    if values.iter().any(|color| !color.is_finite() || color.min_element() < 0.0) {
        let what =
            if is_color { "a vertex color".to_owned() } else { format!("a value of the attribute `{attribute}`") };
        return Err(shape.origin.error(format!("{what} of `{path}` is negative or no number")));
    }
    if values.iter().any(|color| color.max_element() > 1.0) {
        let what = if is_color { "vertex colors".to_owned() } else { format!("values of `{attribute}`") };
        let message = format!("`{path}` has {what} above 1, which create light as a reflectance");
        warnings.push(format!("{}: {message}", shape.origin));
    }
    if is_color && mesh.has_byte_colors {
        let message = format!("the vertex colors of `{path}` are whole numbers; the largest stands for 1");
        warnings.push(format!("{}: {message}. Mitsuba 3 takes them as they are", shape.origin));
    }
    Ok(())
}

impl<'a> Context<'a> {
    /// Name of the attribute that a shape's material or emitter shows. An error where it stands beside something that needs other texture
    /// coordinates.
    fn shown_attribute(&self, shape: &Shape) -> Result<Option<&'a str>> {
        let mut surfaces = Vec::new();
        let mut weights = Vec::new();
        self.collect(shape.common.material, &mut surfaces, &mut weights);
        let emitted = shape.common.emitter.and_then(|emitter| self.emitters[emitter as usize].radiance.texture);
        let mut used: Vec<u32> = weights.into_iter().flatten().chain(emitted).collect();
        for surface in &surfaces {
            used.extend(SurfaceMaterial::clone(surface).textures_mut().into_iter().map(|texture| *texture));
        }
        let is_colors = |&texture: &u32| self.is_colors(&self.textures[texture as usize]);
        let mut names = used.iter().filter(|texture| is_colors(texture)).map(|&at| &*self.textures[at as usize].name);
        let Some(name) = names.next() else { return Ok(None) };
        if let Some(other) = names.find(|other| *other != name) {
            let message = format!("the attributes `{name}` and `{other}` on one shape are not supported together");
            return Err(shape.origin.error(message));
        }
        // What is computed from other things than texture coordinates may stand beside the colors. A relief has slopes along them.
        let has_relief = surfaces.iter().any(|surface| surface.relief.is_some());
        let is_apart = |&texture: &u32| {
            let pattern = &self.textures[texture as usize].pattern;
            !has_relief && matches!(pattern, Pattern::Program(program) if !program.reads_uv())
        };
        if !used.iter().all(|texture| is_colors(texture) || is_apart(texture)) {
            return Err(shape.origin.error("vertex colors beside other textures on one shape are not supported"));
        }
        if surfaces.iter().any(|surface| surface.bsdf.is_anisotropic()) {
            return Err(shape.origin.error("vertex colors on an anisotropic material are not supported"));
        }
        Ok(Some(name))
    }

    /// Whether a texture shows vertex colors.
    fn is_colors(&self, texture: &Texture) -> bool {
        matches!(texture.pattern, Pattern::Bitmap { image, .. } if image == self.image)
    }

    /// Collects the surfaces and the textures of blending weights of a material.
    fn collect(&self, material: u32, surfaces: &mut Vec<&'a SurfaceMaterial>, weights: &mut Vec<Option<u32>>) {
        match &self.materials[material as usize].kind {
            MaterialKind::Surface(surface) => surfaces.push(surface),
            MaterialKind::Blend { weight, materials } => {
                weights.push(weight.texture);
                materials.iter().for_each(|&part| self.collect(part, surfaces, weights));
            }
            MaterialKind::Sides { front, back } => {
                [front, back].into_iter().for_each(|&part| self.collect(part, surfaces, weights));
            }
        }
    }

    /// Mesh of a shape that shows an attribute, and the attribute's values.
    fn mesh<'s>(&self, shape: &'s Shape, attribute: &str) -> Result<(&'s MeshFile, &'a Mesh, &'a [Vec3])> {
        let found = match &shape.geometry {
            Geometry::Mesh(file, _) => self.meshes.get(file).map(|mesh| (file, &**mesh)),
            _ => None,
        };
        let found = found.and_then(|(file, mesh)| Some((file, mesh, mesh.values_of(attribute)?)));
        found.ok_or_else(|| {
            shape.origin.error(match attribute {
                VERTEX_COLOR => {
                    "texture plugin `mesh_attribute` needs a `ply` with vertex colors (red, green, blue)".to_owned()
                }
                _ => format!("texture plugin `mesh_attribute` needs a `ply` with the attribute `{attribute}`"),
            })
        })
    }
}
