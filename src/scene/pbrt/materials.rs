//! Materials: pbrt's as BSDFs of Mitsuba's, which are one object each.

use std::collections::HashMap;
use std::rc::Rc;

use super::coats;
use super::hair;
use super::maker::Maker;
use super::metals;
use super::names::Names;
use super::nodes::{Node, rgb};
use super::parameters::{Parameter, Values};
use super::rasters::Encoding;
use super::roughness;
use super::subsurface;
use super::textures::Textures;
use super::tokens::{Place, brief};
use super::transmission;
use super::world::{Entity, MaterialUse};
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{nested, object, two_sided};
use crate::scene::description::object::{Object, Value};
use crate::scene::faults;

/// Deepest nesting of mixed materials.
const MAX_DEPTH: usize = 16;

/// BSDF of a shape.
#[derive(Debug, Clone)]
pub(super) struct Cover {
    /// Id of the object.
    pub id: String,
    /// Whether texture coordinates matter.
    pub is_textured: bool,
    /// Id of the medium below the surface.
    pub interior: Option<String>,
    /// Whether a part is `hair`.
    pub is_hair: bool,
}

/// Materials as objects.
pub(super) struct Materials<'l> {
    names: &'l Names,
    /// Covers by the material's address; `None` is a material whose fault was told.
    known: HashMap<*const Entity, Option<Cover>>,
    default: Option<Cover>,
    masked: HashMap<(String, String), Cover>,
    objects: Vec<(String, Object)>,
}

impl<'l> Materials<'l> {
    pub fn new(names: &'l Names) -> Self {
        let (known, masked) = (HashMap::new(), HashMap::new());
        Self { names, known, default: None, masked, objects: Vec::new() }
    }

    /// Objects of the materials used.
    pub fn finish(self) -> Vec<(String, Object)> {
        self.objects
    }

    /// Cover of a shape whose alpha may be given.
    pub fn cover(
        &mut self,
        material: &MaterialUse,
        alpha: Option<&Parameter>,
        textures: &mut Textures,
    ) -> Result<Cover> {
        let cover = match material {
            MaterialUse::Default => self.default_cover(),
            MaterialUse::Unnamed(entity) => self.keep(entity, None, textures, 0)?,
            MaterialUse::Named(name, place) => self.named(name, place, textures, 0)?,
        };
        match alpha {
            Some(alpha) => self.masked(cover, alpha, textures),
            None => Ok(cover),
        }
    }

    fn default_cover(&mut self) -> Cover {
        if self.default.is_none() {
            let id = self.names.id("default");
            let diffuse = two_sided(object(Kind::Bsdf, "diffuse", [("reflectance", rgb([0.5; 3]))]));
            self.add("the default material".to_owned(), &id, diffuse);
            self.default = Some(Cover { id, is_textured: false, interior: None, is_hair: false });
        }
        let none = || Cover { id: String::new(), is_textured: false, interior: None, is_hair: false };
        self.default.clone().unwrap_or_else(none)
    }

    fn named(&mut self, name: &str, place: &Place, textures: &mut Textures, depth: usize) -> Result<Cover> {
        let Some(entity) = textures.world.materials.get(name) else {
            let name = brief(name);
            return Err(place.error(format!("the material `{name}` is not defined; define it by MakeNamedMaterial")));
        };
        self.keep(entity, Some(name), textures, depth)
    }

    fn keep(
        &mut self,
        entity: &Rc<Entity>,
        name: Option<&str>,
        textures: &mut Textures,
        depth: usize,
    ) -> Result<Cover> {
        if depth > MAX_DEPTH {
            return Err(entity.error(format!("materials are mixed more than {MAX_DEPTH} deep: does one mix itself?")));
        }
        if let Some(known) = self.known.get(&Rc::as_ptr(entity)) {
            return known.clone().ok_or_else(faults::told_before);
        }
        let made = self.make(entity, name, textures, depth);
        if !self.known.contains_key(&Rc::as_ptr(entity)) {
            textures.images.warnings.extend(entity.parameters.unread());
        }
        self.known.insert(Rc::as_ptr(entity), made.as_ref().ok().cloned());
        made
    }

    fn make(&mut self, entity: &Entity, name: Option<&str>, textures: &mut Textures, depth: usize) -> Result<Cover> {
        entity.parameters.ignore(&["type"]);
        let mut maker = Maker { entity, textures, is_textured: false };
        let (mut interior, mut medium) = (None, None);
        let mut is_hair = entity.kind == "hair";
        let bsdf = match entity.kind.as_str() {
            "mix" => {
                let parts = self.parts(entity, maker.textures, depth)?;
                let below: Vec<_> = parts.iter().filter_map(|part| part.interior.clone()).collect();
                if below.len() > 1 && below[0] != below[1] {
                    maker.warn("two media below one surface are not supported; the first part's is below both");
                }
                interior = below.into_iter().next();
                is_hair = parts.iter().any(|part| part.is_hair);
                mixture(&mut maker, &parts)?
            }
            "subsurface" => {
                let (boundary, within) = subsurface::read(&mut maker)?;
                medium = Some(within);
                boundary
            }
            _ => bsdf(&mut maker)?,
        };
        let bsdf = with_relief(&mut maker, bsdf)?;
        let bsdf = with_opacity(&mut maker, bsdf)?;
        let is_textured = maker.is_textured;
        let place = &entity.parameters.place;
        let (what, wanted) = match name {
            Some(name) => (format!("material `{}`", brief(name)), name.to_owned()),
            None => (format!("material `{}`", entity.kind), format!("{} at line {}", entity.kind, place.line)),
        };
        let id = self.names.id(&wanted);
        self.add(self.names.label(place, &what), &id, bsdf);
        if let Some(medium) = medium {
            let below = self.names.id(&format!("{wanted} below"));
            self.add(self.names.label(place, &what), &below, medium);
            interior = Some(below);
        }
        Ok(Cover { id, is_textured, interior, is_hair })
    }

    /// The two materials of a `mix`.
    fn parts(&mut self, entity: &Entity, textures: &mut Textures, depth: usize) -> Result<[Cover; 2]> {
        let place = &entity.parameters.place;
        let names = match entity.parameters.get("materials").map(|parameter| &parameter.values) {
            Some(Values::Texts(names)) if names.len() == 2 => names,
            _ => return Err(entity.error("a `mix` needs its parameter \"string materials\" with two names")),
        };
        Ok([self.named(&names[0], place, textures, depth + 1)?, self.named(&names[1], place, textures, depth + 1)?])
    }

    /// The cover within a mask.
    fn masked(&mut self, cover: Cover, alpha: &Parameter, textures: &mut Textures) -> Result<Cover> {
        let node = textures.number_of(alpha, usize::MAX, 0)?;
        if let Node::Constant([number, ..]) = node
            && number >= 1.0
        {
            return Ok(cover);
        }
        let key = (cover.id.clone(), format!("{:?}", alpha.values));
        if let Some(known) = self.masked.get(&key) {
            return Ok(known.clone());
        }
        let id = self.names.id(&format!("{} with alpha", cover.id));
        let opacity = textures.number_value(&node)?;
        let mask = object(Kind::Bsdf, "mask", [("opacity", opacity), ("surface", Value::Reference(cover.id.clone()))]);
        self.add(self.names.label(&alpha.place, "alpha"), &id, mask);
        let is_textured = cover.is_textured || !matches!(node, Node::Constant(_));
        let masked = Cover { id, is_textured, interior: cover.interior, is_hair: cover.is_hair };
        self.masked.insert(key, masked.clone());
        Ok(masked)
    }

    fn add(&mut self, label: String, id: &str, bsdf: Object) {
        self.objects.push((label, bsdf.with_id(id.to_owned())));
    }
}

fn bsdf(maker: &mut Maker) -> Result<Object> {
    let entity = maker.entity;
    match entity.kind.as_str() {
        "diffuse" => Ok(two_sided(object(Kind::Bsdf, "diffuse", [("reflectance", maker.color("reflectance", 0.5)?)]))),
        "diffusetransmission" => transmission::diffuse(maker),
        "conductor" => conductor(maker),
        "dielectric" => dielectric(maker),
        "thindielectric" => {
            let eta = maker.index("eta", 1.5)?;
            Ok(object(Kind::Bsdf, "thindielectric", [("int_ior", Value::Float(eta)), ("ext_ior", Value::Float(1.0))]))
        }
        "coateddiffuse" => coats::diffuse(maker),
        "coatedconductor" => coats::conductor(maker),
        "interface" | "" | "none" => Ok(object(Kind::Bsdf, "null", [])),
        "hair" => hair::read(maker),
        "measured" => measured(maker),
        "fourier" => Err(entity.error("the material `fourier` of pbrt-v3 is not supported; use another one")),
        other => Err(entity.error(format!("the material `{}` is not known; check its spelling", brief(other)))),
    }
}

fn measured(maker: &mut Maker) -> Result<Object> {
    let entity = maker.entity;
    let file = entity.parameters.text("filename")?;
    let file = file.ok_or_else(|| entity.error("the material `measured` needs its \"string filename\""))?;
    maker.textures.images.files.existing(file, "measured material", &entity.parameters.place)?;
    Ok(two_sided(object(Kind::Bsdf, "measured", [("filename", Value::Text(file.to_owned()))])))
}

fn conductor(maker: &mut Maker) -> Result<Object> {
    let facets = roughness::read(maker, "")?;
    let entries = metals::metal(maker, ["eta", "k"], 1.0)?;
    Ok(two_sided(metals::faceted(maker, "conductor", "roughconductor", facets, entries)?))
}

fn dielectric(maker: &mut Maker) -> Result<Object> {
    let facets = roughness::read(maker, "")?;
    let eta = maker.index("eta", 1.5)?;
    if eta == 1.0 {
        // Light goes straight on.
        return Ok(object(Kind::Bsdf, "null", []));
    }
    let entries = vec![("int_ior", Value::Float(eta)), ("ext_ior", Value::Float(1.0))];
    metals::faceted(maker, "dielectric", "roughdielectric", facets, entries)
}

fn mixture(maker: &mut Maker, [first, second]: &[Cover; 2]) -> Result<Object> {
    let amount = maker.textures.number(&maker.entity.parameters, "amount", 0.5)?;
    maker.is_textured |= first.is_textured || second.is_textured;
    let part = |cover: &Cover| Value::Reference(cover.id.clone());
    Ok(object(
        Kind::Bsdf,
        "blendbsdf",
        [("weight", maker.number(&amount)?), ("first", part(first)), ("second", part(second))],
    ))
}

/// The BSDF within a mask, where the file gives the opacity of a v3's `uber`.
fn with_opacity(maker: &mut Maker, bsdf: Object) -> Result<Object> {
    let entity = maker.entity;
    if !entity.parameters.has("opacity") {
        return Ok(bsdf);
    }
    let opacity = match maker.textures.color(&entity.parameters, entity, "opacity", 1.0)? {
        Node::Constant([1.0, 1.0, 1.0]) => return Ok(bsdf),
        Node::Constant(color) => Node::Constant([color.iter().sum::<f64>() / 3.0; 3]),
        node => node,
    };
    Ok(object(Kind::Bsdf, "mask", [("opacity", maker.number(&opacity)?), ("surface", nested(bsdf))]))
}

/// The BSDF with a normal map or a displacement around it.
fn with_relief(maker: &mut Maker, bsdf: Object) -> Result<Object> {
    let parameters = &maker.entity.parameters;
    if let Some(name) = parameters.text("normalmap")? {
        if parameters.has("displacement") {
            maker.warn("a normal map and a displacement: the displacement is ignored, as in pbrt");
        }
        let map = maker.textures.bitmap(name, Encoding::Linear, &parameters.place)?;
        maker.is_textured = true;
        let Some(map) = maker.textures.heights(&map)? else { return Ok(bsdf) };
        return Ok(object(Kind::Bsdf, "normalmap", [("normalmap", map), ("surface", nested(bsdf))]));
    }
    if !parameters.has("displacement") {
        return Ok(bsdf);
    }
    let node = maker.textures.number(parameters, "displacement", 0.0)?;
    match maker.textures.heights(&node)? {
        Some(map) => {
            maker.is_textured = true;
            Ok(object(Kind::Bsdf, "bumpmap", [("heights", map), ("surface", nested(bsdf))]))
        }
        None => {
            if !matches!(node, Node::Constant(_)) {
                maker.warn("a displacement that is no image is not rendered");
            }
            Ok(bsdf)
        }
    }
}
