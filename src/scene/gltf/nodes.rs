//! Nodes of a model to shapes, emitters and sensors.

use std::collections::HashMap;

use glam::DMat4;
use gltf::{Node, Primitive};

use super::accessors::rows;
use super::document::Model;
use super::entries::{matrix, object, reference, set};
use super::materials::{self, Look};
use super::meshes::{self, has_triangles};
use super::textures::Textures;
use super::{cameras, lights};
use crate::Result;
use crate::scene::mitsuba::description::Description;
use crate::scene::mitsuba::dictionary::{Dictionary, Value};
use crate::scene::mitsuba::element::MESH_INDEX;

/// Deepest nesting of nodes.
const MAX_DEPTH: usize = 512;

/// Reader of nodes.
struct Reader<'m> {
    model: &'m Model<'m>,
    description: Description,
    textures: Textures<'m>,
    /// Materials by their key and by whether colors of vertices are used.
    looks: HashMap<(String, bool), Look>,
    /// Meshes that lie in memory, by mesh, primitive and set of texture coordinates. Meshes that a node changes are not here.
    meshes: HashMap<(usize, usize, u32), Option<usize>>,
    /// Keys in use, with the number of copies that were counted for each.
    keys: HashMap<String, usize>,
    /// Transforms of all nodes, for skins.
    worlds: HashMap<usize, DMat4>,
}

/// Description of a model's default scene.
pub(super) fn describe(model: &Model) -> Result<Description> {
    let scene = model.document.default_scene().or_else(|| model.document.scenes().next());
    let scene = scene.ok_or_else(|| model.error("the model", "it has no scene; export one"))?;
    let description = Description {
        path: model.path.to_path_buf(),
        scene: object("scene", []),
        ..Description::default()
    };
    let mut reader = Reader {
        model,
        description,
        textures: Textures::new(model),
        looks: HashMap::new(),
        meshes: HashMap::new(),
        keys: HashMap::new(),
        worlds: HashMap::new(),
    };
    let mut order = Vec::new();
    for node in scene.nodes() {
        reader.place(node, DMat4::IDENTITY, 0, &mut order)?;
    }
    for node in order {
        let world = reader.worlds[&node.index()];
        reader.add(&node, world)?;
    }
    if model.document.animations().next().is_some() {
        reader.warn("the model", "its animations are ignored; nodes stand where the file places them");
    }
    let Reader { mut description, textures, .. } = reader;
    description.files = textures.files;
    description.warnings.extend(textures.warnings);
    let is_light = |(_, value): &(String, Value)| match value {
        Value::Object(object) => object.entries.iter().any(|(key, value)| {
            key == "emitter" || (key == "type" && ["point", "spot", "directional"].map(|name| Value::Text(name.into())).contains(value))
        }),
        _ => false,
    };
    if !description.scene.entries.iter().any(is_light) {
        let message = "the scene has no light; give it one with --environment constant, or an image";
        description.warnings.push(format!("{}: {message}", model.path.display()));
    }
    Ok(description)
}

impl<'m> Reader<'m> {
    fn warn(&mut self, what: &str, message: &str) {
        self.description.warnings.push(format!("{}: {what}: {message}", self.model.path.display()));
    }

    /// Places a node and its children. A node has one place, because a node has one parent.
    fn place(&mut self, node: Node<'m>, parent: DMat4, depth: usize, order: &mut Vec<Node<'m>>) -> Result<()> {
        let what = name("node", node.index(), node.name());
        let world = parent * DMat4::from_cols_array_2d(&node.transform().matrix().map(|column| column.map(f64::from)));
        if depth > MAX_DEPTH {
            return Err(self.model.error(&what, format!("nodes are nested more than {MAX_DEPTH} deep")));
        }
        if self.worlds.insert(node.index(), world).is_some() {
            return Err(self.model.error(&what, "it has several parents, or is its own ancestor"));
        }
        let children = node.children();
        order.push(node);
        for child in children {
            self.place(child, world, depth + 1, order)?;
        }
        Ok(())
    }

    /// Adds what a node holds.
    fn add(&mut self, node: &Node<'m>, world: DMat4) -> Result<()> {
        let what = name("node", node.index(), node.name());
        if let Some(camera) = node.camera() {
            let given = node.name().or(camera.name()).map(str::to_owned);
            let key = given.unwrap_or_else(|| format!("camera {}", camera.index()));
            self.insert(&key, cameras::sensor(&camera, world));
        }
        if let Some(light) = node.light() {
            let key = format!("light of {what}");
            self.insert(&key, lights::emitter(&light, world));
        }
        let Some(mesh) = node.mesh() else { return Ok(()) };
        let instances = self.instances(node, world, &what)?;
        for primitive in mesh.primitives() {
            let what = format!("{} of {what}", name("mesh", mesh.index(), mesh.name()));
            self.add_primitive(node, &primitive, (mesh.index(), &what), &instances)?;
        }
        Ok(())
    }

    /// Transforms of a node's copies: one, or those of EXT_mesh_gpu_instancing.
    fn instances(&mut self, node: &Node, world: DMat4, what: &str) -> Result<Vec<DMat4>> {
        // A skin places its vertices in the world itself.
        if node.skin().is_some() {
            return Ok(vec![DMat4::IDENTITY]);
        }
        let Some(attributes) = node.extension_value("EXT_mesh_gpu_instancing").and_then(|value| value.get("attributes")) else {
            return Ok(vec![world]);
        };
        let read = |key: &str, columns: usize| -> Result<Vec<Vec<f64>>> {
            let Some(index) = attributes.get(key).and_then(|index| index.as_u64()) else { return Ok(Vec::new()) };
            let accessor = self.model.document.accessors().nth(index as usize);
            let accessor = accessor.ok_or_else(|| self.model.error(what, format!("there is no accessor {index}")))?;
            let rows = rows(self.model, &accessor, what)?;
            if rows.columns != columns {
                return Err(self.model.error(what, format!("its instances' {key} must have {columns} columns")));
            }
            Ok(rows.values.chunks_exact(columns).map(<[f64]>::to_vec).collect())
        };
        let (moves, turns, scales) = (read("TRANSLATION", 3)?, read("ROTATION", 4)?, read("SCALE", 3)?);
        let count = moves.len().max(turns.len()).max(scales.len());
        let copy = |index: usize| {
            let vector = |rows: &[Vec<f64>], default: f64| {
                rows.get(index).map_or(glam::DVec3::splat(default), |row| glam::DVec3::new(row[0], row[1], row[2]))
            };
            let turn = turns.get(index).map_or(glam::DQuat::IDENTITY, |row| glam::DQuat::from_slice(row).normalize());
            world * DMat4::from_scale_rotation_translation(vector(&scales, 1.0), turn, vector(&moves, 0.0))
        };
        Ok((0..count).map(copy).collect())
    }

    fn add_primitive(
        &mut self,
        node: &Node<'m>,
        primitive: &Primitive<'m>,
        (mesh_index, what): (usize, &str),
        instances: &[DMat4],
    ) -> Result<()> {
        if !has_triangles(primitive.mode()) {
            self.warn(what, "points and lines are not rendered");
            return Ok(());
        }
        if primitive.extension_value("KHR_draco_mesh_compression").is_some() && primitive.get(&gltf::Semantic::Positions).is_none_or(|positions| positions.view().is_none()) {
            return Err(self.model.error(what, "KHR_draco_mesh_compression is not supported; export it without compression"));
        }
        let material = primitive.material();
        let has_colors = primitive.get(&gltf::Semantic::Colors(0)).is_some();
        let key = (materials::key(&material), has_colors);
        if !self.looks.contains_key(&key) {
            let look = materials::look(self.model, &material, has_colors, &mut self.textures)?;
            set(&mut self.description.scene, &id_of(&key), Value::Object(look.bsdf.clone()));
            self.looks.insert(key.clone(), look);
        }
        let (uv_set, emitter) = (self.looks[&key].uv_set, self.looks[&key].emitter.clone());
        let Some(mesh) = self.mesh(node, primitive, (mesh_index, what), uv_set)? else { return Ok(()) };
        for &instance in instances {
            let mut shape = object("mesh", [
                (MESH_INDEX, Value::Integer(mesh as i64)),
                ("to_world", matrix(instance)),
                ("bsdf", reference(&id_of(&key))),
            ]);
            if let Some(emitter) = &emitter {
                set(&mut shape, "emitter", Value::Object(emitter.clone()));
            }
            self.insert(&format!("{what}, primitive {}", primitive.index()), shape);
        }
        Ok(())
    }

    /// Index of a primitive's mesh in memory. Meshes that neither a skin nor weights of a node change are shared.
    fn mesh(&mut self, node: &Node, primitive: &Primitive, of: (usize, &str), uv_set: u32) -> Result<Option<usize>> {
        let (mesh_index, what) = of;
        let key = (mesh_index, primitive.index(), uv_set);
        let is_shared = node.skin().is_none() && node.weights().is_none();
        if let Some(&found) = self.meshes.get(&key).filter(|_| is_shared) {
            return Ok(found);
        }
        let joints = self.joints(node, what)?;
        let mut mesh = meshes::mesh(self.model, node, primitive, uv_set, joints.as_deref(), what)?;
        if let Some(mesh) = mesh.as_mut().filter(|mesh| mesh.colors.is_empty()) {
            // Colors that are all white were left out, but the material asks for them.
            if primitive.get(&gltf::Semantic::Colors(0)).is_some() {
                mesh.colors = vec![glam::Vec3::ONE; mesh.positions.len()];
            }
        }
        let index = mesh.map(|mesh| {
            self.description.meshes.push(mesh);
            self.description.meshes.len() - 1
        });
        if is_shared {
            self.meshes.insert(key, index);
        }
        Ok(index)
    }

    /// Matrices of a node's skin, from the mesh to the world.
    fn joints(&self, node: &Node, what: &str) -> Result<Option<Vec<DMat4>>> {
        let Some(skin) = node.skin() else { return Ok(None) };
        let inverse: Vec<DMat4> = match skin.inverse_bind_matrices() {
            Some(accessor) => {
                let rows = rows(self.model, &accessor, what)?.values;
                let matrix = |row: &[f64]| DMat4::from_cols_array(&std::array::from_fn(|i| row[i]));
                rows.chunks_exact(16).map(matrix).collect()
            }
            None => Vec::new(),
        };
        let joint = |(index, joint): (usize, Node)| {
            let world = self.worlds.get(&joint.index()).copied().unwrap_or(DMat4::IDENTITY);
            world * inverse.get(index).copied().unwrap_or(DMat4::IDENTITY)
        };
        Ok(Some(skin.joints().enumerate().map(joint).collect()))
    }

    /// Adds an object to the scene under a key that no other has.
    fn insert(&mut self, key: &str, object: Dictionary) {
        let mut unique = key.to_owned();
        let mut copies = self.keys.get(key).copied().unwrap_or(0);
        while self.keys.contains_key(&unique) {
            copies += 1;
            unique = format!("{key}, copy {}", copies + 1);
        }
        self.keys.insert(key.to_owned(), copies);
        self.keys.entry(unique.clone()).or_insert(0);
        set(&mut self.description.scene, &unique, Value::Object(object));
    }
}

/// Key of a material in the scene.
fn id_of((key, has_colors): &(String, bool)) -> String {
    if *has_colors { format!("{key} with colors of vertices") } else { key.clone() }
}

/// Name of a thing in messages.
fn name(kind: &str, index: usize, given: Option<&str>) -> String {
    given.map_or_else(|| format!("{kind} {index}"), |given| format!("{kind} {index} `{given}`"))
}
