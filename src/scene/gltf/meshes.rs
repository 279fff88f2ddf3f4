//! Meshes and the shapes that they make.

use std::collections::HashMap;
use std::iter;
use std::rc::Rc;
use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3};
use gltf::mesh::Mode;
use gltf::{Mesh as GltfMesh, Primitive, Semantic};

use super::asset::{Asset, plain};
use super::budget::Made;
use super::corners::triangles;
use super::images::Images;
use super::materials::{Covering, Materials};
use super::nodes::{Placed, Transforms, transforms};
use super::relief::{self, Part};
use super::skins::{self, Vertices};
use super::wearer::Wearer;
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{matrix, nested, object};
use crate::scene::description::object::{MESH, Object, Value};
use crate::scene::mesh::Mesh;

/// Meshes in memory, and shapes.
#[derive(Default)]
pub(super) struct Meshes {
    /// Meshes that several nodes may share.
    known: HashMap<Key, Arc<Mesh>>,
    shapes: Vec<(String, Object)>,
    made: Made,
    /// Transforms of all nodes, once a skin has asked for them.
    transforms: Option<Rc<Transforms>>,
}

/// Facts that decide a mesh: index of the mesh, the primitive and its part, mirrored or not, set of coordinates, factor of colors.
type Key = (usize, usize, usize, bool, u32, Option<[u32; 3]>);

impl Meshes {
    /// Shapes with their keys.
    pub fn finish(self) -> Vec<(String, Object)> {
        self.shapes
    }

    /// Makes a shape of each primitive of the node's mesh and each instance of the node.
    pub fn place<'a>(
        &mut self,
        asset: &'a Asset,
        placed: &Placed<'a>,
        nodes: &[Placed<'a>],
        mesh: &GltfMesh<'a>,
        materials: &mut Materials,
        images: &mut Images<'a>,
    ) -> Result<()> {
        let name = placed.node.name().or(mesh.name()).unwrap_or("mesh").to_owned();
        let skin = placed.node.skin();
        let transforms =
            skin.is_some().then(|| Rc::clone(self.transforms.get_or_insert_with(|| Rc::new(transforms(nodes)))));
        let pose = transforms.as_deref().zip(skin.as_ref());
        for primitive in mesh.primitives() {
            if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
                asset.warn(format!("mesh {} has points or lines, which are not rendered", mesh.index()));
                continue;
            }
            let wearer = Wearer::of(asset, mesh.index(), &primitive)?;
            let parts = relief::parts(asset, mesh.index(), &primitive)?;
            let shapes = self.made.shapes(placed.instances.len() * parts.len());
            shapes.map_err(|message| asset.error(format!("mesh {}: {message}", mesh.index())))?;
            let is_posed = skin.is_some() || primitive.morph_targets().next().is_some();
            // Meshes in a pose, which belong to this node alone.
            let mut posed: HashMap<Key, Arc<Mesh>> = HashMap::new();
            let instances = placed.instances.iter();
            for (instance, (place, part)) in instances.flat_map(|each| iter::repeat(each).zip(parts.iter().enumerate()))
            {
                let is_mirrored = skin.is_none() && instance.determinant() < 0.0;
                let has_relief = primitive.material().normal_texture().is_some();
                let turned = if has_relief { part.turned_on(is_mirrored) } else { wearer.turned };
                let wearer = Wearer { turned, ..wearer };
                let covering = materials.covering(asset, images, &primitive.material(), wearer)?;
                let colors = covering.color_factor.map(|factor| factor.map(f32::to_bits));
                let key = (mesh.index(), primitive.index(), place, is_mirrored, covering.uv_set, colors);
                let known = if is_posed { &posed } else { &self.known };
                let made = match known.get(&key) {
                    Some(known) => Arc::clone(known),
                    None => {
                        let made = self.mesh(asset, placed, mesh, &primitive, part, &covering, is_mirrored, pose)?;
                        let Some(made) = made.map(Arc::new) else { break };
                        let known = if is_posed { &mut posed } else { &mut self.known };
                        known.insert(key, Arc::clone(&made));
                        made
                    }
                };
                let has_normals = !made.normals.is_empty();
                let mut shape = object(
                    Kind::Shape,
                    "mesh",
                    [("face_normals", Value::Boolean(!has_normals)), ("bsdf", Value::Reference(covering.id.clone()))],
                );
                shape = shape.with(MESH, Value::Mesh(made));
                if skin.is_none() {
                    shape = shape.with("to_world", matrix(instance));
                }
                if let Some(emitter) = &covering.emitter {
                    shape = shape.with("emitter", nested(emitter.clone()));
                }
                if let Some(medium) = &covering.medium {
                    shape = shape.with("interior", Value::Reference(medium.clone()));
                }
                let key = format!("shape{}_{}", self.shapes.len(), plain(&name));
                self.shapes.push((key, shape));
            }
        }
        Ok(())
    }

    #[expect(clippy::too_many_arguments, reason = "each fact decides the mesh")]
    fn mesh(
        &mut self,
        asset: &Asset,
        placed: &Placed,
        mesh: &GltfMesh,
        primitive: &Primitive,
        part: &Part,
        covering: &Covering,
        is_mirrored: bool,
        pose: Option<(&Transforms, &gltf::Skin)>,
    ) -> Result<Option<Mesh>> {
        let fault = |what: &str| asset.error(format!("mesh {}: {what}", mesh.index()));
        let positions = primitive.get(&Semantic::Positions);
        let Some(positions) = positions else {
            asset.warn(format!("mesh {} has no positions; it is not rendered", mesh.index()));
            return Ok(None);
        };
        self.made.vertices(positions.count()).map_err(|message| fault(&message))?;
        let vectors = |elements: Vec<[f64; 3]>| elements.into_iter().map(DVec3::from_array).collect::<Vec<_>>();
        let normals = match primitive.get(&Semantic::Normals) {
            Some(accessor) => vectors(asset.elements::<3>(&accessor)?),
            None => Vec::new(),
        };
        let mut vertices = Vertices { positions: vectors(asset.elements::<3>(&positions)?), normals };
        let count = vertices.positions.len();
        if !vertices.normals.is_empty() && vertices.normals.len() != count {
            return Err(fault("it has fewer normals than vertices"));
        }
        skins::morph(asset, &placed.node, mesh, primitive, &mut vertices)?;
        if let Some((transforms, skin)) = pose
            && !skins::skin(asset, skin, primitive, transforms, &mut vertices)?
        {
            return Err(fault("its node has a skin, but it has no joints"));
        }
        let uvs = match primitive.get(&Semantic::TexCoords(covering.uv_set)) {
            Some(accessor) => {
                asset.elements::<2>(&accessor)?.into_iter().map(|uv| Vec2::new(uv[0] as f32, uv[1] as f32)).collect()
            }
            None => Vec::new(),
        };
        let colors = match (covering.color_factor, primitive.get(&Semantic::Colors(0))) {
            (Some(factor), Some(accessor)) => {
                let elements = asset.elements::<3>(&accessor)?.into_iter();
                elements.map(|color| Vec3::from_array(color.map(|c| c as f32)) * Vec3::from_array(factor)).collect()
            }
            _ => Vec::new(),
        };
        if [uvs.len(), colors.len()].iter().any(|&given| given != 0 && given != count) {
            return Err(fault("it has fewer texture coordinates or colors than vertices"));
        }
        let positions: Vec<Vec3> = vertices.positions.iter().map(|position| position.as_vec3()).collect();
        if !positions.iter().all(|position| position.is_finite()) {
            return Err(fault("a position is not finite"));
        }
        let mut triangles = triangles(asset, primitive, count)?;
        if triangles.iter().flatten().any(|&index| index as usize >= count) {
            return Err(fault("an index is larger than the number of vertices"));
        }
        if let Some(part) = &part.triangles {
            triangles = part.iter().filter_map(|&at| triangles.get(at).copied()).collect();
        }
        self.made.triangles(triangles.len()).map_err(|message| fault(&message))?;
        if triangles.is_empty() {
            return Ok(None);
        }
        if is_mirrored {
            triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        let normals = vertices.normals.iter().map(|normal| normal.as_vec3()).collect();
        Ok(Some(Mesh { positions, normals, uvs, colors, triangles, ..Mesh::default() }))
    }
}
