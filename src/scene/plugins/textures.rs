//! Reader of textures. Parameters are read first; image files are decoded when the whole scene is known.

use std::collections::HashMap;
use std::ptr;

use glam::{DMat3, DMat4, DVec3, Mat3, Vec3};

use super::parameter::Parameter;
use super::properties::Properties;
use super::scope::Scope;
use crate::Result;
use crate::scene::description::kinds::{Kind, Type};
use crate::scene::description::object::Object;
use crate::scene::description::origin::Origin;
use crate::scene::folders::FoundFile;
use crate::scene::texture::{Pattern, TexelFilter, Texture, WrapMode};

pub(super) const SUPPORTED: [&str; 5] = ["bitmap", "checkerboard", "mesh_attribute", "rawconstant", "scale"];

/// Index of the image of vertex colors among the images read: it is made when all meshes are read.
const VERTEX_COLORS: u32 = u32::MAX;

/// Deepest nesting of textures. Deeper nesting comes from a texture that refers to itself.
const MAX_DEPTH: usize = 16;

/// Uses of a texture's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// Color that should not exceed 1.
    Reflectance,
    /// Emitted light.
    Radiance,
    /// Number: the luminance of the color.
    Scalar,
    /// Heights, of which the slope matters.
    Heights,
    /// Normals in tangent space.
    Normals,
}

/// Things that are made of one texture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Reading {
    Color,
    /// Number that differs from the color's luminance.
    Number,
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
        let reading = match role {
            Role::Heights => Reading::Heights,
            Role::Scalar if object.plugin != "bitmap" => Reading::Number,
            _ => Reading::Color,
        };
        let key = (ptr::from_ref(object), reading);
        let found = match self.known.get(&key) {
            Some(&found) => found,
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
            _ => return Err(object.unsupported(&SUPPORTED)),
        };
        let to_uv = to_uv(&mut properties)?;
        properties.finish(warnings)?;
        let name = match object.id.as_deref() {
            Some(id) => id.to_string(),
            None => format!("{} at {}", object.plugin, object.origin.brief()),
        };
        self.read.push(Texture { name, pattern, to_uv });
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
        let is_number = !matches!(role, Role::Reflectance | Role::Radiance);
        if is_number && factor != Vec3::splat(factor.x) {
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
        match properties.string("name")? {
            Some("vertex_color") => {}
            Some(name) => {
                return Err(location.error(format!("the attribute `{name}` is not supported; use `vertex_color`")));
            }
            None => return Err(object.error("texture plugin `mesh_attribute` needs its parameter `name`")),
        }
        if !matches!(role, Role::Reflectance | Role::Radiance) {
            return Err(object.error("the attribute `vertex_color` is a color, not a number"));
        }
        let factor = Vec3::splat(properties.float("scale")?.unwrap_or(1.0));
        properties.finish(warnings)?;
        let pattern = Pattern::Bitmap { image: VERTEX_COLORS, filter: TexelFilter::Bilinear, wrap: WrapMode::Clamp };
        self.read.push(Texture { name: "vertex_color".to_string(), pattern, to_uv: Mat3::IDENTITY });
        Ok(TextureUse { texture: self.read.len() as u32 - 1, factor })
    }

    fn bitmap(&mut self, properties: &mut Properties<'a>, role: Role, warnings: &mut Vec<String>) -> Result<Pattern> {
        let filter = filter(properties, warnings)?;
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
        let is_color = matches!(role, Role::Reflectance | Role::Radiance);
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

    /// Refuses uses that Mitsuba's checkerboard does not support.
    fn check_role(&self, object: &Object, role: Role, found: TextureUse) -> Result<()> {
        let is_bitmap = match self.read[found.texture as usize].pattern {
            Pattern::Bitmap { image, .. } => image != VERTEX_COLORS,
            Pattern::Checkerboard { .. } => false,
        };
        match role {
            Role::Heights if !is_bitmap => Err(object.error("a bump map must be a `bitmap`")),
            Role::Normals if !is_bitmap => Err(object.error("a normal map must be a `bitmap`")),
            Role::Normals if found.factor != Vec3::ONE => Err(object.error("a normal map cannot be scaled")),
            _ => Ok(()),
        }
    }

    /// Index in `Scene::textures` of a texture that was read.
    pub fn keep(&mut self, texture: u32) -> u32 {
        if let Pattern::Bitmap { image, .. } = self.read[texture as usize].pattern
            && image != VERTEX_COLORS
        {
            self.kept_images.index(image);
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
        if let Pattern::Bitmap { image, .. } = &mut texture.pattern
            && *image != VERTEX_COLORS
        {
            *image = self.kept_images.index(*image);
        }
        texture
    }
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

fn filter(properties: &mut Properties, warnings: &mut Vec<String>) -> Result<TexelFilter> {
    let location = properties.location("filter_type");
    match properties.string("filter_type")? {
        None | Some("bilinear") => Ok(TexelFilter::Bilinear),
        Some("nearest") => Ok(TexelFilter::Nearest),
        // Filters of Mitsuba 0.6 for distant surfaces.
        Some(other @ ("trilinear" | "ewa")) => {
            warnings.push(format!("{location}: the filter `{other}` is not supported; `bilinear` is used"));
            Ok(TexelFilter::Bilinear)
        }
        Some(other) => Err(location.error(format!("the filter `{other}` is not known; use `bilinear` or `nearest`"))),
    }
}

fn wrap_mode(properties: &mut Properties) -> Result<WrapMode> {
    let location = properties.location("wrap_mode");
    match properties.string("wrap_mode")? {
        None | Some("repeat") => Ok(WrapMode::Repeat),
        Some("mirror") => Ok(WrapMode::Mirror),
        Some("clamp") => Ok(WrapMode::Clamp),
        Some(other) => {
            let message = format!("the wrap mode `{other}` is not supported; use `repeat`, `mirror` or `clamp`");
            Err(location.error(message))
        }
    }
}

/// Whether an image is linear: Mitsuba 3's `raw`, or Mitsuba 0.6's `gamma`, where -1 means "as the file says" and 1
/// means linear.
fn is_raw(properties: &mut Properties, warnings: &mut Vec<String>) -> Result<bool> {
    let location = properties.location("gamma");
    let raw = properties.boolean("raw")?;
    let gamma = properties.float("gamma")?;
    if let Some(gamma) = gamma.filter(|&gamma| gamma != -1.0 && gamma != 1.0) {
        warnings.push(format!("{location}: a `gamma` of {gamma} is not supported; the sRGB curve is used"));
    }
    Ok(raw.unwrap_or(gamma == Some(1.0)))
}

/// Reads a checkerboard. As in Mitsuba 3.9, the two colors are exchanged where it gives a number.
fn checkerboard(properties: &mut Properties, role: Role, warnings: &mut Vec<String>) -> Result<Pattern> {
    let mut color = |name: &str, default: f32| -> Result<Vec3> {
        if let Some(texture) = properties.texture(name)? {
            return Err(texture.error(format!("`{name}` of a checkerboard must be a color, not a texture")));
        }
        let location = properties.location(name);
        let color = properties.color(name)?.unwrap_or(Vec3::splat(default));
        if role == Role::Reflectance && color.max_element() > 1.0 {
            warnings.push(format!("{location}: a `{name}` above 1 would create light; clamped to 1"));
            return Ok(color.min(Vec3::ONE));
        }
        Ok(color)
    };
    let (color0, color1) = (color("color0", 0.4)?, color("color1", 0.2)?);
    // The number is the mean of the color's channels.
    let mean = |color: Vec3| Vec3::splat(color.element_sum() / 3.0);
    Ok(match role {
        Role::Scalar => Pattern::Checkerboard { color0: mean(color1), color1: mean(color0) },
        _ => Pattern::Checkerboard { color0, color1 },
    })
}

/// Reads a `rawconstant`: a checkerboard whose colors are equal.
fn raw_constant(properties: &mut Properties) -> Result<Pattern> {
    let object = properties.owner();
    let types = [Type::Float, Type::Integer, Type::Vector, Type::Point, Type::Rgb];
    let is_number = properties.is_number("value");
    let value = properties.take_typed("value", &types)?;
    let value = value.ok_or_else(|| object.error("texture plugin `rawconstant` needs its parameter `value`"))?;
    let color = if is_number { [value.number()?; 3] } else { value.three()? };
    let color = Vec3::from_array(color.map(|channel| channel as f32));
    if color.min_element() < 0.0 {
        return Err(value.error(format!("a color must not be negative, as {} is", color.min_element())));
    }
    Ok(Pattern::Checkerboard { color0: color, color1: color })
}

/// Reads `to_uv`, and the offsets and scales of old files, which Mitsuba 3 applies in this order.
fn to_uv(properties: &mut Properties) -> Result<Mat3> {
    let mut number = |name: &str, default: f32| Ok(f64::from(properties.float(name)?.unwrap_or(default)));
    let offset = DVec3::new(number("uoffset", 0.0)?, number("voffset", 0.0)?, 0.0);
    let scale = DVec3::new(number("uscale", 1.0)?, number("vscale", 1.0)?, 1.0);
    let own = DMat4::from_scale(scale) * DMat4::from_translation(offset);
    let matrix = properties.take_transform("to_uv")? * own;
    let column = |column: glam::DVec4, w: f64| DVec3::new(column.x, column.y, w);
    let columns = (column(matrix.x_axis, 0.0), column(matrix.y_axis, 0.0), column(matrix.w_axis, 1.0));
    Ok(DMat3::from_cols(columns.0, columns.1, columns.2).as_mat3())
}
