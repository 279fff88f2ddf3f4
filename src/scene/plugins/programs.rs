//! Reader of textures that are computed: nested textures become the graph of one program.

use std::collections::HashMap;
use std::ptr;

use glam::{DMat4, DVec3, Vec3};

use super::properties::Properties;
use super::role::Role;
use super::scope::Scope;
use crate::Result;
use crate::generated::constants::MAX_PROGRAM_LENGTH;
use crate::scene::description::kinds::Kind;
use crate::scene::description::object::Object;
use crate::scene::program::graph::{Graph, Operand};
use crate::scene::program::operation::{Gives, Input, Kind as ValueKind, Parameter, Takes};
use crate::scene::program::schedule::schedule;
use crate::scene::program::{Operation, Program};

/// Plugins of inputs.
const SOURCES: [(&str, Operand); 5] = [
    ("uv", Operand::Uv),
    ("position", Operand::Position),
    ("normal", Operand::Normal),
    ("shading_normal", Operand::ShadingNormal),
    ("incoming", Operand::Incoming),
];

/// Deepest nesting of computed textures.
const MAX_DEPTH: usize = 256;

/// Most operations that are read. After that, equal and dead parts are taken out.
const MAX_NODES: usize = 16 * MAX_PROGRAM_LENGTH as usize;

/// Most entries of a table.
const MAX_ENTRIES: usize = 1024;

/// Value of a texture that is computed.
pub(super) enum Computed {
    /// Index of an image among the textures read, and its factor.
    Image(u32, Vec3),
    Constant(Vec3),
    Program(Program),
}

/// Reader of an image that a program looks up: its index among the textures read, and its factor.
type ReadImage<'r, 'a> = dyn FnMut(&'a Object, &mut Vec<String>) -> Result<(u32, Vec3)> + 'r;

/// Names of the plugins that make a texture a program.
pub(super) fn plugins() -> impl Iterator<Item = &'static str> {
    let operations = Operation::ALL.iter().map(|operation| operation.row().plugin);
    SOURCES.iter().map(|(plugin, _)| *plugin).chain(operations)
}

/// Whether a texture is computed, not a pattern or an image as it is.
pub(super) fn is_computed<'a>(object: &'a Object, scope: &Scope<'a>) -> Result<bool> {
    let has = |names: &[&str]| -> Result<bool> {
        let mut properties = Properties::new(object, scope)?;
        Ok(names.iter().any(|name| matches!(properties.texture(name), Ok(Some(_)))))
    };
    match &*object.plugin {
        "bitmap" => has(&["coordinates"]),
        "checkerboard" => has(&["color0", "color1"]),
        "scale" => has(&["scale"]),
        plugin => Ok(plugins().any(|known| known == plugin)),
    }
}

/// Reads a computed texture.
pub(super) fn read<'a>(
    object: &'a Object,
    role: Role,
    scope: &Scope<'a>,
    image: &mut ReadImage<'_, 'a>,
    warnings: &mut Vec<String>,
) -> Result<Computed> {
    let mut reader =
        Reader { scope, role, image, warnings, graph: Graph::default(), known: HashMap::new(), open: Vec::new() };
    let typed = reader.texture(object)?;
    if let Some((texture, factor)) = reader.graph.image(typed.operand) {
        return Ok(Computed::Image(texture, factor));
    }
    let root = if role.is_number() { reader.number(typed) } else { typed.operand };
    let limits = role.limits();
    if let Operand::Constant(value) = root {
        return Ok(Computed::Constant(value.clamp(Vec3::splat(limits[0]), Vec3::splat(limits[1]))));
    }
    schedule(&reader.graph, root, limits).map(Computed::Program).map_err(|message| object.error(message))
}

/// Operand with its kind.
#[derive(Debug, Clone, Copy)]
struct Typed {
    operand: Operand,
    kind: ValueKind,
}

/// Reader of one program.
struct Reader<'r, 'a> {
    scope: &'r Scope<'a>,
    role: Role,
    image: &'r mut ReadImage<'r, 'a>,
    warnings: &'r mut Vec<String>,
    graph: Graph,
    /// Textures read, by their addresses.
    known: HashMap<*const Object, Typed>,
    /// Textures being read, from the outermost.
    open: Vec<*const Object>,
}

impl<'a> Reader<'_, 'a> {
    fn texture(&mut self, object: &'a Object) -> Result<Typed> {
        let key = ptr::from_ref(object);
        if let Some(&known) = self.known.get(&key) {
            return Ok(known);
        }
        let word = || object.origin.word("texture");
        if self.open.contains(&key) {
            return Err(object.error(format!("this {} contains itself, directly or through others", word())));
        }
        if self.open.len() >= MAX_DEPTH {
            return Err(object.error(format!("textures are nested more than {MAX_DEPTH} deep")));
        }
        if self.known.len() >= MAX_NODES {
            return Err(object.error(format!("with this {} a texture has more than {MAX_NODES} parts", word())));
        }
        self.open.push(key);
        let typed = self.new_texture(object);
        self.open.pop();
        let typed = typed?;
        self.known.insert(key, typed);
        Ok(typed)
    }

    fn new_texture(&mut self, object: &'a Object) -> Result<Typed> {
        let mut properties = Properties::new(object, self.scope)?;
        let plugin = properties.plugin();
        if let Some((_, operand)) = SOURCES.iter().find(|(name, _)| *name == plugin) {
            properties.finish(self.warnings)?;
            return Ok(Typed { operand: *operand, kind: ValueKind::Vector });
        }
        match plugin {
            "bitmap" => self.bitmap(object, &mut properties),
            "checkerboard" => self.checkerboard(properties),
            "scale" => self.scale(properties),
            "rawconstant" => {
                let value = self.input(&mut properties, "value", None)?;
                properties.finish(self.warnings)?;
                Ok(value)
            }
            "mesh_attribute" => {
                Err(object.error("vertex colors within a texture that is computed are not supported; use a `bitmap`"))
            }
            _ => match Operation::ALL.iter().find(|operation| operation.row().plugin == plugin) {
                Some(&operation) => self.operation(operation, properties),
                None => {
                    let all: Vec<_> = ["checkerboard", "rawconstant", "scale"].into_iter().chain(plugins()).collect();
                    Err(object.unsupported(&all))
                }
            },
        }
    }

    fn operation(&mut self, operation: Operation, mut properties: Properties<'a>) -> Result<Typed> {
        let row = operation.row();
        let (mut operands, mut kinds) = (Vec::with_capacity(row.inputs.len()), Vec::new());
        for Input { name, takes, default } in row.inputs {
            let typed = match takes {
                Takes::Coordinates => self.coordinates(&mut properties)?,
                _ => self.input(&mut properties, name, *default)?,
            };
            operands.push(if *takes == Takes::Number { self.number(typed) } else { typed.operand });
            if *takes == Takes::Any {
                kinds.push(typed.kind);
            }
        }
        let mut numbers = Vec::new();
        for parameter in row.parameters {
            match *parameter {
                Parameter::Whole(name, default, most) => {
                    let found = properties.integer(name, 0..=i64::from(most))?;
                    numbers.push(found.map_or(default, |value| value as u32));
                }
                Parameter::Number(name, default) => {
                    numbers.push(properties.float(name)?.unwrap_or(default).to_bits());
                }
                Parameter::Choice(name, words) => numbers.push(choice(&mut properties, name, words)?),
                Parameter::Table(name) => numbers.extend(table(&mut properties, name)?),
                Parameter::Matrix(name) => numbers.extend(affine(&properties.take_transform(name)?)),
                // A `bitmap` is read as such.
                Parameter::Texture => {}
            }
        }
        properties.finish(self.warnings)?;
        if operands.len() > 3 {
            operands = self.packed(&operands);
        }
        let kind = match row.gives {
            Gives::One(kind) => kind,
            Gives::AsInputs => kinds.into_iter().find(|&kind| kind != ValueKind::Number).unwrap_or(ValueKind::Number),
        };
        Ok(Typed { operand: self.graph.add(operation, &operands, &numbers), kind })
    }

    /// Operands of an operation with many inputs: the first, and vectors of three numbers each.
    fn packed(&mut self, operands: &[Operand]) -> Vec<Operand> {
        let zero = Operand::Constant(Vec3::ZERO);
        let mut packed = vec![operands[0]];
        for numbers in operands[1..].chunks(3) {
            let three = [0, 1, 2].map(|at| numbers.get(at).copied().unwrap_or(zero));
            packed.push(self.graph.add(Operation::Combine, &three, &[]));
        }
        packed
    }

    /// Reads a constant or a texture; `default` is the number where neither is given.
    fn input(&mut self, properties: &mut Properties<'a>, name: &str, default: Option<f32>) -> Result<Typed> {
        if let Some(texture) = properties.texture(name)? {
            return self.texture(texture);
        }
        let object = properties.owner();
        let constant = |value: Vec3, kind| Ok(Typed { operand: Operand::Constant(value), kind });
        if properties.is_number(name) {
            return constant(Vec3::splat(properties.float(name)?.unwrap_or_default()), ValueKind::Number);
        }
        if properties.is_vector(name) {
            let vector = properties.point(name)?.unwrap_or_default();
            return constant(vector.as_vec3(), ValueKind::Vector);
        }
        match (properties.signed_color(name)?, default) {
            (Some(color), _) => constant(color, ValueKind::Color),
            (None, Some(default)) => constant(Vec3::splat(default), ValueKind::Number),
            (None, None) => {
                let plugin = &object.plugin;
                Err(object.error(format!("texture plugin `{plugin}` needs its parameter `{name}`")))
            }
        }
    }

    /// Reads the coordinates of an operation: those of the surface, where no texture gives others.
    fn coordinates(&mut self, properties: &mut Properties<'a>) -> Result<Typed> {
        match properties.texture("coordinates")? {
            Some(texture) => self.texture(texture),
            None => Ok(Typed { operand: Operand::Uv, kind: ValueKind::Vector }),
        }
    }

    fn bitmap(&mut self, object: &'a Object, properties: &mut Properties<'a>) -> Result<Typed> {
        let coordinates = self.coordinates(properties)?.operand;
        let (texture, factor) = (self.image)(object, self.warnings)?;
        let image = self.graph.add(Operation::Image, &[coordinates], &[texture]);
        let operand = self.graph.add(Operation::Multiply, &[image, Operand::Constant(factor)], &[]);
        Ok(Typed { operand, kind: ValueKind::Color })
    }

    /// Reads Mitsuba's checkerboard. As there, the two colors are exchanged where it gives a number.
    fn checkerboard(&mut self, mut properties: Properties<'a>) -> Result<Typed> {
        let first = self.input(&mut properties, "color0", Some(0.4))?;
        let second = self.input(&mut properties, "color1", Some(0.2))?;
        let to_uv = properties.take_transform("to_uv")?;
        properties.finish(self.warnings)?;
        // Its squares are half a unit large.
        let numbers = affine(&(DMat4::from_scale(DVec3::new(2.0, 2.0, 0.0)) * to_uv));
        let place = self.graph.add(Operation::Transform, &[Operand::Uv], &numbers);
        let odd = self.graph.add(Operation::Checker, &[place], &[]);
        let is_number = matches!(self.role, Role::Scalar | Role::Share);
        let [even_color, odd_color] = if is_number { [second, first].map(mean_of_constant) } else { [first, second] };
        Ok(self.mixed(even_color, odd_color, odd))
    }

    fn mixed(&mut self, first: Typed, second: Typed, weight: Operand) -> Typed {
        let operand = self.graph.add(Operation::Mix, &[first.operand, second.operand, weight], &[]);
        Typed { operand, kind: if first.kind == ValueKind::Number { second.kind } else { first.kind } }
    }

    /// Reads a `scale`: the product of a texture with a color or another texture.
    fn scale(&mut self, mut properties: Properties<'a>) -> Result<Typed> {
        let object = properties.owner();
        let factor = self.input(&mut properties, "scale", Some(1.0))?;
        let nested = properties.object(Kind::Texture)?;
        let nested = nested.ok_or_else(|| {
            object.error(format!("texture plugin `scale` needs a nested {}", object.origin.word("texture")))
        })?;
        properties.finish(self.warnings)?;
        let inner = self.texture(nested)?;
        let operand = self.graph.add(Operation::Multiply, &[inner.operand, factor.operand], &[]);
        Ok(Typed { operand, kind: if inner.kind == ValueKind::Number { factor.kind } else { inner.kind } })
    }

    /// The number that a value stands for: the luminance of a color, the mean of a vector's components.
    fn number(&mut self, typed: Typed) -> Operand {
        match typed.kind {
            ValueKind::Number => typed.operand,
            ValueKind::Color => self.graph.add(Operation::Luminance, &[typed.operand], &[]),
            ValueKind::Vector => {
                let third = Operand::Constant(Vec3::splat(1.0 / 3.0));
                self.graph.add(Operation::Dot, &[typed.operand, third], &[])
            }
        }
    }
}

/// Index of a word among those that a parameter may be.
fn choice(properties: &mut Properties, name: &str, words: &[&str]) -> Result<u32> {
    let location = properties.location(name);
    let Some(found) = properties.string(name)? else { return Ok(0) };
    let index = words.iter().position(|word| *word == found);
    index
        .map(|index| index as u32)
        .ok_or_else(|| location.error(format!("the {name} `{found}` is not known; use one of {}", words.join(", "))))
}

/// Bits of a table's numbers.
fn table(properties: &mut Properties, name: &str) -> Result<Vec<u32>> {
    let location = properties.location(name);
    let text = properties.string(name)?.unwrap_or_default();
    let words = text.split([' ', ',', '\n', '\t']).filter(|word| !word.is_empty());
    let numbers: Option<Vec<f32>> =
        words.map(|word| word.parse().ok().filter(|number: &f32| number.is_finite())).collect();
    let is_whole = |numbers: &Vec<f32>| {
        let (entries, rest) = numbers.as_chunks::<3>();
        rest.is_empty() && (1..=MAX_ENTRIES).contains(&entries.len())
    };
    match numbers.filter(is_whole) {
        Some(numbers) => Ok(numbers.into_iter().map(f32::to_bits).collect()),
        None => Err(location.error(format!(
            "`{name}` of a table must be finite numbers, three for each of its entries, of which there are at most {MAX_ENTRIES}"
        ))),
    }
}

/// The number that a constant color stands for in Mitsuba: the mean of its channels.
fn mean_of_constant(typed: Typed) -> Typed {
    match typed.operand {
        Operand::Constant(color) => {
            let mean = Vec3::splat(color.element_sum() / 3.0);
            Typed { operand: Operand::Constant(mean), kind: ValueKind::Number }
        }
        _ => typed,
    }
}

/// Numbers of an affine map, row by row.
fn affine(matrix: &DMat4) -> Vec<u32> {
    let rows = matrix.transpose().to_cols_array();
    rows[..12].iter().map(|&number| (number as f32).to_bits()).collect()
}
