//! The prims of a stage, from its roots down, and the objects that they become.

use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;

use glam::{DMat4, DVec3};
use openusd::sdf;

use super::asset::{Asset, Prim};
use super::bindings::Bindings;
use super::budget::Made;
use super::cameras::Cameras;
use super::curves;
use super::instancers;
use super::lights::{self, Lamp, is_light};
use super::materials::{Covering, Display, Materials, plain};
use super::meshes::{self, Faces, Named, Shown};
use super::primvars::{Counts, Inherited, Interpolation, Primvar};
use super::solids::{self, Solid, is_solid};
use super::transforms::{self, Local};
use super::values;
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{matrix, nested, object};
use crate::scene::description::object::{MESH, Object, Value};
use crate::scene::mesh::Mesh;

/// Deepest nesting of prims.
const MAX_DEPTH: usize = 512;

/// Types of prims that have a shape which is not rendered.
const NOT_RENDERED: [&str; 6] = ["HermiteCurves", "NurbsCurves", "NurbsPatch", "Points", "TetMesh", "Volume"];

/// What a prim inherits from its parents.
#[derive(Clone)]
pub(super) struct State {
    /// Transform from the parent's space to the world, or to the group.
    pub world: DMat4,
    pub purpose: Rc<str>,
    pub bindings: Bindings,
    pub primvars: Inherited,
}

impl Default for State {
    fn default() -> Self {
        let (bindings, primvars) = (Bindings::default(), Inherited::default());
        Self { world: DMat4::IDENTITY, purpose: Rc::from("default"), bindings, primvars }
    }
}

impl State {
    /// State of a prim with its own purpose and bindings.
    fn named(&self, prim: &Prim) -> Result<Self> {
        // A prim without a type has no purpose.
        let purpose = if prim.kind.is_empty() { None } else { prim.text("purpose")? };
        let purpose = purpose.map_or_else(|| Rc::clone(&self.purpose), Rc::from);
        Ok(Self { purpose, bindings: self.bindings.of(prim)?, ..self.clone() })
    }
}

/// Facts that decide a mesh: path of its prim, index of its part, and what it shows.
type MeshKey = (sdf::Path, Option<usize>, Shown);

/// A group of shapes that instances show.
#[derive(Clone)]
pub(super) enum Group {
    /// `id` of the group.
    Known(String),
    /// Nothing is shown.
    Empty,
    /// No group may contain what is shown.
    Impossible,
}

/// Walk over the prims.
pub(super) struct Walk<'a> {
    pub asset: &'a Asset,
    pub is_z_up: bool,
    pub materials: Materials,
    pub cameras: Cameras,
    pub made: Made,
    pub shapes: Vec<(String, Object)>,
    pub lights: Vec<(String, Object)>,
    pub groups: Vec<(String, Object)>,
    known_groups: HashMap<String, Group>,
    meshes: HashMap<MeshKey, Option<Arc<Mesh>>>,
    /// Whether the prims belong to a group.
    is_in_group: bool,
    /// Whether a prim of the group has a place of its own in the stage.
    has_reset: bool,
    /// Number of names given to shapes.
    count: usize,
    subdivided: usize,
}

impl<'a> Walk<'a> {
    pub fn new(asset: &'a Asset, is_z_up: bool) -> Self {
        Self {
            asset,
            is_z_up,
            materials: Materials::default(),
            cameras: Cameras::default(),
            made: Made::default(),
            shapes: Vec::new(),
            lights: Vec::new(),
            groups: Vec::new(),
            known_groups: HashMap::new(),
            meshes: HashMap::new(),
            is_in_group: false,
            has_reset: false,
            count: 0,
            subdivided: 0,
        }
    }

    /// Visits all prims.
    pub fn all(&mut self) -> Result<()> {
        let root = sdf::Path::abs_root();
        let fault = |error| self.asset.fault(&sdf::Path::abs_root(), &error);
        let roots = self.asset.stage.prim(root).children().map_err(fault)?;
        // Lodestar's pictures and environments have +y up.
        let world = if self.is_z_up { DMat4::from_rotation_x(-std::f64::consts::FRAC_PI_2) } else { DMat4::IDENTITY };
        let state = State { world, ..State::default() };
        roots.iter().try_for_each(|prim| self.visit(prim.path(), &state, 0))?;
        if self.subdivided > 0 {
            let count = self.subdivided;
            self.asset.warn(format!("{count} meshes are subdivision surfaces; their control polygons are rendered"));
        }
        Ok(())
    }

    /// Visits a prim and those beneath it.
    pub fn visit(&mut self, path: &sdf::Path, state: &State, depth: usize) -> Result<()> {
        if depth > MAX_DEPTH {
            return Err(self.asset.prim_error(path, format!("prims are nested more than {MAX_DEPTH} deep")));
        }
        self.made.prims(1).map_err(|message| self.asset.prim_error(path, message))?;
        let handle = self.asset.stage.prim(path.clone());
        let asset = self.asset;
        let fault = |error| asset.fault(path, &error);
        let is_defined = handle.specifier().map_err(fault)? == Some(sdf::Specifier::Def);
        if !is_defined || !handle.is_active().map_err(fault)? {
            return Ok(());
        }
        let prim = self.asset.prim(path)?;
        if prim.text("visibility")?.as_deref() == Some("invisible") {
            return Ok(());
        }
        let Local { matrix: local, resets } = transforms::local(&prim)?;
        self.has_reset |= resets;
        let world = if resets { self.root() * local } else { state.world * local };
        let state = State { world, primvars: state.primvars.clone(), ..state.named(&prim)? };
        let is_shown = !matches!(&*state.purpose, "guide" | "proxy");
        match &*prim.kind {
            "Material" | "Shader" | "NodeGraph" | "GeomSubset" => return Ok(()),
            "Mesh" if is_shown => self.mesh(&prim, &state)?,
            "Camera" => self.cameras.add(&prim, &state.world)?,
            "PointInstancer" => return self.instancer(&prim, &state, depth),
            "BasisCurves" if is_shown => self.curves(&prim, &state)?,
            kind if is_solid(kind) && is_shown => self.solid(&prim, &state)?,
            kind if is_light(kind) && is_shown => self.light(&prim, &state)?,
            kind if NOT_RENDERED.contains(&kind) && is_shown => {
                self.asset.warn(format!("prims of the type `{kind}` are not rendered"));
            }
            _ => {}
        }
        let state = State { primvars: state.primvars.below(&prim)?, ..state };
        if handle.is_instance().map_err(fault)?
            && !self.is_in_group
            && let Some(bound) = state.bindings.key()
        {
            let prototype = handle.prototype().map_err(fault)?;
            let key = format!("{prototype:?} {} {bound} {}", state.purpose, state.primvars.key());
            let children = |walk: &mut Self, world: DMat4| {
                let state = State { world, ..state.clone() };
                prim.children()?.iter().try_for_each(|child| walk.visit(child, &state, depth + 1))
            };
            if prototype.is_some() {
                return self.instance(&prim, key, &state.world, children);
            }
        }
        prim.children()?.iter().try_for_each(|child| self.visit(child, &state, depth + 1))
    }

    /// Transform of the stage to the world.
    fn root(&self) -> DMat4 {
        match self.is_z_up && !self.is_in_group {
            true => DMat4::from_rotation_x(-std::f64::consts::FRAC_PI_2),
            false => DMat4::IDENTITY,
        }
    }

    /// Shows the prototypes of a point instancer.
    fn instancer(&mut self, prim: &Prim<'a>, state: &State, depth: usize) -> Result<()> {
        let mut states: HashMap<sdf::Path, State> = HashMap::new();
        for (prototype, own) in instancers::placed(prim, &mut self.made)? {
            let above = match states.get(&prototype) {
                Some(above) => above.clone(),
                None => {
                    let mut above = self.above(&prototype)?;
                    if &*above.purpose == "default" {
                        above.purpose = Rc::clone(&state.purpose);
                    }
                    states.insert(prototype.clone(), above.clone());
                    above
                }
            };
            // What else a prototype inherits follows from its path.
            let key = format!("{prototype} {}", above.purpose);
            let visit =
                |walk: &mut Self, world: DMat4| walk.visit(&prototype, &State { world, ..above.clone() }, depth + 1);
            self.instance(prim, key, &(state.world * own), visit)?;
        }
        Ok(())
    }

    /// What a prim inherits from its parents, but for its place.
    fn above(&self, path: &sdf::Path) -> Result<State> {
        let mut parents: Vec<sdf::Path> = std::iter::successors(path.parent(), sdf::Path::parent).collect();
        parents.retain(|parent| !parent.is_abs_root());
        parents.iter().rev().try_fold(State::default(), |state, parent| {
            let prim = self.asset.prim(parent)?;
            let primvars = state.primvars.below(&prim)?;
            Ok(State { primvars, ..state.named(&prim)? })
        })
    }

    /// Shows a group at a place. `visit` visits its prims, in the space of the given transform.
    pub fn instance(
        &mut self,
        prim: &Prim<'a>,
        key: String,
        world: &DMat4,
        visit: impl Fn(&mut Self, DMat4) -> Result<()>,
    ) -> Result<()> {
        if self.is_in_group {
            return visit(self, *world);
        }
        let group = match self.known_groups.get(&key) {
            Some(group) => group.clone(),
            None => {
                let group = self.group(prim, &visit)?;
                self.known_groups.insert(key, group.clone());
                group
            }
        };
        match group {
            Group::Empty => Ok(()),
            Group::Impossible => visit(self, *world),
            Group::Known(id) => {
                let entries = [("group", Value::Reference(id)), ("to_world", matrix(world))];
                self.push(prim, object(Kind::Shape, "instance", entries));
                Ok(())
            }
        }
    }

    fn group(&mut self, prim: &Prim<'a>, visit: &impl Fn(&mut Self, DMat4) -> Result<()>) -> Result<Group> {
        let (shapes, lights, cameras) = (std::mem::take(&mut self.shapes), self.lights.len(), self.cameras.len());
        (self.is_in_group, self.has_reset) = (true, false);
        let visited = visit(self, DMat4::IDENTITY);
        self.is_in_group = false;
        let members = std::mem::replace(&mut self.shapes, shapes);
        visited?;
        let has_own_place = self.cameras.len() > cameras || self.has_reset;
        if has_own_place || self.lights.len() > lights || members.iter().any(|(_, shape)| is_spot(shape)) {
            self.lights.truncate(lights);
            self.cameras.truncate(cameras);
            return Ok(Group::Impossible);
        }
        if members.is_empty() {
            return Ok(Group::Empty);
        }
        let id = format!("group{}_{}", self.groups.len(), plain(prim.name()));
        let group = object(Kind::Shape, "shapegroup", []).with_id(id.clone());
        let group = members.into_iter().fold(group, |group, (key, member)| group.with(key, nested(member)));
        self.groups.push((id.clone(), group));
        Ok(Group::Known(id))
    }

    fn push(&mut self, prim: &Prim, shape: Object) {
        let key = format!("{}{}", prim.path, if self.count == 0 { String::new() } else { format!(" {}", self.count) });
        self.count += 1;
        self.shapes.push((key, shape));
    }

    fn light(&mut self, prim: &Prim<'a>, state: &State) -> Result<()> {
        match lights::lamp(prim, &state.world, self.is_z_up, &mut self.materials)? {
            Some(Lamp::Emitter(emitter)) => self.lights.push((format!("{} {}", prim.path, self.lights.len()), emitter)),
            Some(Lamp::Shape(shape)) => self.push(prim, shape),
            None => {}
        }
        Ok(())
    }

    fn solid(&mut self, prim: &Prim<'a>, state: &State) -> Result<()> {
        let counts = Counts { faces: 1, points: 1, corners: 1 };
        let covering = self.covering(prim, state, state.bindings.material(&prim.path), counts)?;
        let solid = solids::solid(prim)?;
        let is_similar = is_similarity(&state.world);
        let shape = match solid {
            Solid::Sphere(radius) if is_similar && covering.primvar.is_none() => {
                object(Kind::Shape, "sphere", [("radius", Value::Float(radius))])
            }
            Solid::Sphere(radius) => self.in_memory(Arc::new(solids::sphere(radius))),
            Solid::Mesh(mut mesh) => {
                if state.world.determinant() < 0.0 {
                    mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
                }
                self.in_memory(Arc::new(mesh))
            }
        };
        self.place(prim, shape, &covering, &state.world);
        Ok(())
    }

    fn curves(&mut self, prim: &Prim<'a>, state: &State) -> Result<()> {
        let counts = Counts { faces: 1, points: 1, corners: 1 };
        let covering = self.covering(prim, state, state.bindings.material(&prim.path), counts)?;
        self.asset.warn("curves are rendered as tubes of triangles, also flat ones");
        let Some(mut mesh) = curves::mesh(prim, &mut self.made)? else { return Ok(()) };
        if state.world.determinant() < 0.0 {
            mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        let shape = self.in_memory(Arc::new(mesh));
        self.place(prim, shape, &covering, &state.world);
        Ok(())
    }

    fn in_memory(&self, mesh: Arc<Mesh>) -> Object {
        let has_normals = !mesh.normals.is_empty();
        let shape = object(Kind::Shape, "mesh", [("face_normals", Value::Boolean(!has_normals))]);
        shape.with(MESH, Value::Mesh(mesh))
    }

    fn place(&mut self, prim: &Prim, shape: Object, covering: &Covering, world: &DMat4) {
        let mut shape = shape.with("to_world", matrix(world)).with("bsdf", Value::Reference(covering.id.clone()));
        if let Some(emitter) = &covering.emitter {
            shape = shape.with("emitter", nested(emitter.clone()));
        }
        self.push(prim, shape);
    }

    fn mesh(&mut self, prim: &Prim<'a>, state: &State) -> Result<()> {
        let Some(faces) = Faces::read(prim, &mut self.made)? else { return Ok(()) };
        self.subdivided += usize::from(faces.is_subdivided);
        if prim.has("skel:jointIndices") || prim.has("primvars:skel:jointIndices") {
            self.asset.warn("skeletons are not applied: meshes are shown as they are stored");
        }
        let (subsets, rest) = meshes::subsets(prim, faces.counts.faces)?;
        let light = lights::mesh_light(prim)?;
        let own = state.bindings.material(&prim.path);
        /// Index of a part, its faces and its material.
        type Piece = (Option<usize>, Option<Vec<usize>>, Option<sdf::Path>);
        let mut parts: Vec<Piece> = Vec::new();
        if subsets.is_empty() {
            parts.push((None, None, own));
        } else {
            if !rest.is_empty() {
                parts.push((Some(0), Some(rest), own));
            }
            for (index, subset) in subsets.into_iter().enumerate() {
                let bindings = state.bindings.of(&self.asset.prim(&subset.path)?)?;
                parts.push((Some(index + 1), Some(subset.faces), bindings.material(&subset.path)));
            }
        }
        let stored = self.asset.stage.prim(prim.path.clone()).prim_in_prototype();
        let stored = stored.ok().flatten().map_or_else(|| prim.path.clone(), |stored| stored.path().clone());
        let is_mirrored = state.world.determinant() < 0.0;
        for (index, part, material) in parts {
            let mut covering = self.covering(prim, state, material, faces.counts)?;
            if let Some(light) = &light {
                covering.emitter = Some(light.clone());
            }
            let named = |name: &Option<String>| -> Result<Option<Named>> {
                let Some(name) = name.clone() else { return Ok(None) };
                Ok(Some(Named { parent: state.primvars.parent(prim, &name)?, name }))
            };
            let shown = Shown { uvs: named(&covering.primvar)?, colors: named(&covering.colors)?, is_mirrored };
            let key = (stored.clone(), index, shown.clone());
            let mesh = match self.meshes.get(&key) {
                Some(mesh) => mesh.clone(),
                None => {
                    let mesh = faces.mesh(prim, &shown, part.as_deref())?.map(Arc::new);
                    self.meshes.insert(key, mesh.clone());
                    mesh
                }
            };
            if let Some(mesh) = mesh {
                if covering.colors.is_some() && mesh.colors.is_empty() {
                    self.asset.warn_of(&prim.path, "it lacks the colors that its material shows; gray is rendered");
                    covering = self.covering_of(None, &GRAY)?;
                }
                let shape = self.in_memory(mesh);
                self.place(prim, shape, &covering, &state.world);
            }
        }
        Ok(())
    }

    /// What covers a prim with that material.
    fn covering(
        &mut self,
        prim: &Prim<'a>,
        state: &State,
        material: Option<sdf::Path>,
        counts: Counts,
    ) -> Result<Covering> {
        let holder = |name: &str| {
            state.primvars.parent(prim, name)?.map_or_else(|| Ok(prim.clone()), |parent| prim.asset.prim(&parent))
        };
        let shown = holder("displayColor")?;
        let colors = Primvar::read(&shown, "primvars:displayColor", Interpolation::Constant, counts, values::triples)?;
        // A shape that is no mesh has one color.
        let is_constant = |colors: &Primvar<[f64; 3]>| {
            counts.points == 1 || colors.interpolation == Interpolation::Constant || colors.values.len() == 1
        };
        let opacity = holder("displayOpacity")?.read("primvars:displayOpacity", values::numbers)?.unwrap_or_default();
        let mean = if opacity.is_empty() { 1.0 } else { opacity.iter().sum::<f64>() / opacity.len() as f64 };
        if opacity.iter().any(|value| (value - mean).abs() > 1.0e-3) && material.is_none() {
            self.asset.warn_of(&prim.path, format!("its `displayOpacity` varies; its mean of {mean:.3} is used"));
        }
        let display = Display {
            color: colors.as_ref().filter(|colors| is_constant(colors)).map(|colors| colors.values[colors.first()]),
            varies: colors.as_ref().is_some_and(|colors| !is_constant(colors)),
            opacity: if mean.is_finite() { mean.clamp(0.0, 1.0) } else { 1.0 },
        };
        self.covering_of(material.as_ref(), &display)
    }

    fn covering_of(&mut self, material: Option<&sdf::Path>, display: &Display) -> Result<Covering> {
        self.materials.covering(self.asset, material, display)
    }
}

/// Display of what has no color.
const GRAY: Display = Display { color: None, varies: false, opacity: 1.0 };

/// Whether a shape has an emitter that no group may contain.
fn is_spot(shape: &Object) -> bool {
    shape.entries.iter().any(|entry| matches!(&entry.value, Value::Object(object) if object.plugin == "spotarea"))
}

/// Whether a transform keeps all angles.
fn is_similarity(matrix: &DMat4) -> bool {
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.truncate());
    let size = x.length_squared();
    let is_small = |value: f64| value.abs() <= 1.0e-4 * size;
    let lengths = is_small(y.length_squared() - size) && is_small(z.length_squared() - size);
    lengths && is_small(x.dot(y)) && is_small(y.dot(z)) && is_small(z.dot(x)) && x != DVec3::ZERO
}
