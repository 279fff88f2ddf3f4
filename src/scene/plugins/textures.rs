//! Reader of textures. Parameters are read first; image files are decoded when the whole scene is known.

use std::collections::HashMap;
use std::ptr;

use glam::{Mat3, Vec3};

use super::parameter::Parameter;
use super::programs::{self, Computed};
use super::properties::Properties;
use super::role::Role;
use super::scope::Scope;
use super::texture_parameters::{checkerboard, filter, is_raw, raw_constant, to_uv, wrap_mode};
use crate::Result;
use crate::quoted;
use crate::scene::description::kinds::Kind;
use crate::scene::description::object::Object;
use crate::scene::description::origin::Origin;
use crate::scene::folders::FoundFile;
use crate::scene::mesh::VERTEX_COLOR;
use crate::scene::texture::{Pattern, TexelFilter, Texture, WrapMode};

const SUPPORTED: [&str; 5] = ["bitmap", "checkerboard", "mesh_attribute", "rawconstant", "scale"];

/// Index of the image of vertex colors among the images read: it is made when all meshes are read.
pub(super) const VERTEX_COLORS: u32 = u32::MAX;

/// Deepest nesting of textures. Deeper nesting comes from a texture that refers to itself.
const MAX_DEPTH: usize = 16;

/// Things that are made of one texture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Reading {
    Color,
    /// Number that differs from the color's luminance.
    Number,
    /// Computed number in [0, 1].
    Share,
    /// Heights, in single precision.
    Heights,
}

/// Texture as a parameter uses it.
#[derive(Debug, Clone, Copy)]
pub(super) struct TextureUse {
    /// Index among the textures read.
    pub texture: u32,
    /// Product of the factors of all `scale` textures around it.
    pub factor: Vec3,
}

/// Image file that a texture names.
#[derive(Debug, Clone)]
pub(super) struct ImageRequest {
    pub file: FoundFile,
    /// Name as the scene writes it.
    pub name: String,
    /// Whether bytes are linear rather than encoded by the sRGB curve.
    pub raw: bool,
    /// Whether one of its colors is used as a reflectance.
    pub is_reflectance: bool,
    /// Whether all its colors are used as reflectance or light.
    pub is_color: bool,
    /// Whether it is used as heights, and as nothing else.
    pub is_heights: bool,
    /// Location where the file is first named.
    pub location: Origin,
}

/// Textures of a scene while it is read. A texture that no surface uses is read, but not kept.
pub(super) struct Textures<'a> {
    scope: Scope<'a>,
    /// Textures read, by the object's address and by what is made of it.
    known: HashMap<(*const Object, Reading), TextureUse>,
    read: Vec<Texture>,
    requests: Vec<ImageRequest>,
    kept_textures: Kept,
    kept_images: Kept,
}

/// Indices of the things that the scene keeps, in the order of their first use.
#[derive(Default)]
struct Kept {
    indices: HashMap<u32, u32>,
    order: Vec<u32>,
}

impl Kept {
    fn index(&mut self, read: u32) -> u32 {
        *self.indices.entry(read).or_insert_with(|| {
            self.order.push(read);
            self.order.len() as u32 - 1
        })
    }
}

impl<'a> Textures<'a> {
    pub fn new(scope: Scope<'a>) -> Self {
        Self {
            scope,
            known: HashMap::new(),
            read: Vec::new(),
            requests: Vec::new(),
            kept_textures: Kept::default(),
            kept_images: Kept::default(),
        }
    }

    /// Reads a texture. The index returned is one that [`Textures::keep`] takes.
    pub fn read(&mut self, object: &'a Object, role: Role, warnings: &mut Vec<String>) -> Result<TextureUse> {
        self.read_nested(object, role, 0, warnings)
    }

    fn read_nested(
        &mut self,
        object: &'a Object,
        role: Role,
        depth: usize,
        warnings: &mut Vec<String>,
    ) -> Result<TextureUse> {
        if depth > MAX_DEPTH {
            return Err(object.error("textures are nested too deep: does one refer to itself?"));
        }
        let is_computed = programs::is_computed(object, &self.scope)?;
        let reading = match role {
            Role::Heights => Reading::Heights,
            Role::Share if is_computed => Reading::Share,
            Role::Scalar | Role::Share if is_computed || object.plugin != "bitmap" => Reading::Number,
            _ => Reading::Color,
        };
        let key = (ptr::from_ref(object), reading);
        let found = match self.known.get(&key) {
            Some(&found) => found,
            None if is_computed => self.computed(object, role, depth, warnings)?,
            None => self.read_new(object, role, depth, warnings)?,
        };
        self.check_role(object, role, found)?;
        self.known.insert(key, found);
        Ok(found)
    }

    fn read_new(
        &mut self,
        object: &'a Object,
        role: Role,
        depth: usize,
        warnings: &mut Vec<String>,
    ) -> Result<TextureUse> {
        let mut properties = Properties::new(object, &self.scope)?;
        let pattern = match properties.plugin() {
            "bitmap" => self.bitmap(&mut properties, role, warnings)?,
            "checkerboard" => checkerboard(&mut properties, role, warnings)?,
            "rawconstant" => raw_constant(&mut properties)?,
            "mesh_attribute" => return self.mesh_attribute(properties, role, warnings),
            "scale" => return self.scale(properties, role, depth, warnings),
            _ => {
                let computed: Vec<_> = programs::plugins().filter(|plugin| !SUPPORTED.contains(plugin)).collect();
                return Err(object.unsupported(&[&SUPPORTED[..], &computed].concat()));
            }
        };
        let to_uv = to_uv(&mut properties)?;
        properties.finish(warnings)?;
        self.read.push(Texture { name: name_of(object), pattern, to_uv });
        Ok(TextureUse { texture: self.read.len() as u32 - 1, factor: Vec3::ONE })
    }

    /// Reads a texture that is computed.
    fn computed(
        &mut self,
        object: &'a Object,
        role: Role,
        depth: usize,
        warnings: &mut Vec<String>,
    ) -> Result<TextureUse> {
        let scope = Scope::clone(&self.scope);
        let mut image = |object: &'a Object, warnings: &mut Vec<String>| {
            let found = self.read_new(object, role, depth + 1, warnings)?;
            Ok((found.texture, found.factor))
        };
        let pattern = match programs::read(object, role, &scope, &mut image, warnings)? {
            Computed::Image(texture, factor) => return Ok(TextureUse { texture, factor }),
            Computed::Constant(color) => Pattern::Checkerboard { color0: color, color1: color },
            Computed::Program(program) => Pattern::Program(program),
        };
        self.read.push(Texture { name: name_of(object), pattern, to_uv: Mat3::IDENTITY });
        Ok(TextureUse { texture: self.read.len() as u32 - 1, factor: Vec3::ONE })
    }

    /// Reads a `scale`, a texture of Mitsuba 0.6 that multiplies another by a factor.
    fn scale(
        &mut self,
        mut properties: Properties<'a>,
        role: Role,
        depth: usize,
        warnings: &mut Vec<String>,
    ) -> Result<TextureUse> {
        let object = properties.owner();
        let factor = properties.color("scale")?.unwrap_or(Vec3::ONE);
        let nested = properties.object(Kind::Texture)?;
        let nested = nested.ok_or_else(|| {
            object.error(format!("texture plugin `scale` needs a nested {}", object.origin.word("texture")))
        })?;
        properties.finish(warnings)?;
        if !role.is_color() && factor != Vec3::splat(factor.x) {
            return Err(object.error("the `scale` of a texture that gives a number must be gray"));
        }
        let found = self.read_nested(nested, role, depth + 1, warnings)?;
        Ok(TextureUse { factor: factor * found.factor, ..found })
    }

    /// Reads a `mesh_attribute`, whose colors the shape's mesh gives.
    fn mesh_attribute(
        &mut self,
        mut properties: Properties<'a>,
        role: Role,
        warnings: &mut Vec<String>,
    ) -> Result<TextureUse> {
        let object = properties.owner();
        let location = properties.location("name");
        let name = match properties.string("name")? {
            Some(name) if ["vertex_", "face_"].iter().any(|kind| name.starts_with(kind)) => name.to_owned(),
            Some(name) => {
                let name = quoted::word(name);
                return Err(location.error(format!("the attribute {name} should begin with `vertex_` or `face_`")));
            }
            None => return Err(object.error("texture plugin `mesh_attribute` needs its parameter `name`")),
        };
        if name == VERTEX_COLOR && !role.is_color() {
            return Err(object.error("the attribute `vertex_color` is a color, not a number"));
        }
        let factor = Vec3::splat(properties.float("scale")?.unwrap_or(1.0));
        properties.finish(warnings)?;
        let pattern = Pattern::Bitmap { image: VERTEX_COLORS, filter: TexelFilter::Bilinear, wrap: WrapMode::Clamp };
        self.read.push(Texture { name, pattern, to_uv: Mat3::IDENTITY });
        Ok(TextureUse { texture: self.read.len() as u32 - 1, factor })
    }

    fn bitmap(&mut self, properties: &mut Properties<'a>, role: Role, warnings: &mut Vec<String>) -> Result<Pattern> {
        // Programs read the coordinates of the images that they look up.
        properties.texture("coordinates")?;
        let filter = filter(properties, role, warnings)?;
        let wrap = wrap_mode(properties)?;
        let raw = is_raw(properties, warnings)?;
        // These parameters say how texels are stored, fetched and cached.
        properties.ignore(&["format", "accel", "cache", "max_anisotropy"]);
        let (file, filename) = properties.file("filename", "image file")?;
        Ok(Pattern::Bitmap { image: self.image(file, filename, raw, role), filter, wrap })
    }

    /// Index of the image that the parameter `filename` names.
    fn image(&mut self, file: FoundFile, filename: Parameter, raw: bool, role: Role) -> u32 {
        let is_reflectance = role == Role::Reflectance;
        let is_color = role.is_color();
        let is_heights = role == Role::Heights;
        let same = |request: &ImageRequest| {
            request.raw == raw && request.is_heights == is_heights && request.file.path == file.path
        };
        if let Some(index) = self.requests.iter().position(same) {
            self.requests[index].is_reflectance |= is_reflectance;
            self.requests[index].is_color &= is_color;
            return index as u32;
        }
        let (name, location) = (filename.text().to_owned(), filename.origin());
        self.requests.push(ImageRequest { file, name, raw, is_reflectance, is_color, is_heights, location });
        self.requests.len() as u32 - 1
    }

    /// Refuses uses that a texture does not support.
    fn check_role(&self, object: &Object, role: Role, found: TextureUse) -> Result<()> {
        let pattern = &self.read[found.texture as usize].pattern;
        let is_bitmap = matches!(pattern, Pattern::Bitmap { image, .. } if *image != VERTEX_COLORS);
        let is_program = matches!(pattern, Pattern::Program(_));
        match role {
            Role::Radiance if is_program => {
                Err(object.error("a texture that is computed cannot emit light; use a `bitmap`"))
            }
            Role::Heights if !is_bitmap && !is_program => Err(object.error("a bump map must be a `bitmap`")),
            Role::Normals if !is_bitmap => Err(object.error("a normal map must be a `bitmap`")),
            Role::Normals if found.factor != Vec3::ONE => Err(object.error("a normal map cannot be scaled")),
            _ => Ok(()),
        }
    }

    /// Index in `Scene::textures` of a texture that was read.
    pub fn keep(&mut self, texture: u32) -> u32 {
        match &self.read[texture as usize].pattern {
            Pattern::Bitmap { image, .. } if *image != VERTEX_COLORS => {
                self.kept_images.index(*image);
            }
            Pattern::Program(program) => {
                let images: Vec<u32> = program.clone().textures_mut().map(|texture| *texture).collect();
                images.into_iter().for_each(|image| _ = self.keep(image));
            }
            Pattern::Bitmap { .. } | Pattern::Checkerboard { .. } => {}
        }
        self.kept_textures.index(texture)
    }

    /// Kept textures, and kept images to decode. The textures name them by their place among these; [`number_images`] gives
    /// them the numbers of `Scene::images`.
    pub fn finish(mut self) -> (Vec<Texture>, Vec<ImageRequest>) {
        let order = std::mem::take(&mut self.kept_textures.order);
        let textures = order.iter().map(|&read| self.kept_texture(read)).collect();
        let images = self.kept_images.order.iter().map(|&read| self.requests[read as usize].clone()).collect();
        (textures, images)
    }

    fn kept_texture(&mut self, read: u32) -> Texture {
        let mut texture = self.read[read as usize].clone();
        match &mut texture.pattern {
            Pattern::Bitmap { image, .. } if *image != VERTEX_COLORS => *image = self.kept_images.index(*image),
            Pattern::Program(program) => {
                program.textures_mut().for_each(|texture| *texture = self.kept_textures.index(*texture));
            }
            Pattern::Bitmap { .. } | Pattern::Checkerboard { .. } => {}
        }
        texture
    }
}

/// The texture's `id`, or else its plugin and place.
fn name_of(object: &Object) -> String {
    match object.id.as_deref() {
        Some(id) => id.to_string(),
        None => format!("{} at {}", object.plugin, object.origin.brief()),
    }
}

/// Whether a texture plugin is known.
pub(super) fn is_known(plugin: &str) -> bool {
    SUPPORTED.contains(&plugin) || programs::plugins().any(|known| known == plugin)
}

/// Gives the images of `textures` their numbers in `Scene::images`: `indices` has the place of each among the decoded ones,
/// which follow `first` others. Vertex colors become the image `vertex_colors`.
pub(super) fn number_images(textures: &mut [Texture], first: usize, indices: &[u32], vertex_colors: usize) {
    for texture in textures {
        if let Pattern::Bitmap { image, .. } = &mut texture.pattern {
            *image = match *image {
                VERTEX_COLORS => vertex_colors as u32,
                request => first as u32 + indices[request as usize],
            };
        }
    }
}
