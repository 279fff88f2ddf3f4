//! Parameters of materials: checked constants or textures.

use glam::Vec3;

use super::super::properties::Properties;
use super::super::role::Role;
use super::super::textures::Textures;
use super::measured::MeasuredFiles;
use super::{ior, named_conductors};
use crate::Result;
use crate::generated::constants::MIN_ALPHA;
use crate::scene::bsdf::{Distribution, Microfacets};
use crate::scene::description::kinds::Kind;
use crate::scene::description::object::Object;
use crate::scene::texture::Textured;

/// Mitsuba's default albedo.
pub(super) const DEFAULT_REFLECTANCE: f32 = 0.5;
/// Mitsuba's default roughness.
const DEFAULT_ALPHA: f32 = 0.1;

/// Parameters of one plugin while they are read.
pub(super) struct Parameters<'r, 'a> {
    pub properties: Properties<'a>,
    textures: &'r mut Textures<'a>,
    pub measured: &'r mut MeasuredFiles,
    pub warnings: &'r mut Vec<String>,
}

impl<'r, 'a> Parameters<'r, 'a> {
    pub fn new(
        properties: Properties<'a>,
        textures: &'r mut Textures<'a>,
        measured: &'r mut MeasuredFiles,
        warnings: &'r mut Vec<String>,
    ) -> Self {
        Self { properties, textures, measured, warnings }
    }

    pub fn owner(&self) -> &'a Object {
        self.properties.owner()
    }

    /// Reports the parameters that were not read.
    pub fn finish(self) -> Result<()> {
        self.properties.finish(self.warnings)
    }

    /// Reads a share of reflected or transmitted light.
    pub fn reflectance(&mut self, name: &str, default: f32) -> Result<Textured<Vec3>> {
        if let Some(texture) = self.properties.texture(name)? {
            let found = self.textures.read(texture, Role::Reflectance, self.warnings)?;
            return Ok(Textured { value: found.factor, texture: Some(found.texture) });
        }
        self.constant_reflectance(name, default).map(Textured::constant)
    }

    /// Reads an absorption; `None` where it is not given.
    pub fn absorption(&mut self, name: &str) -> Result<Option<Textured<Vec3>>> {
        if let Some(texture) = self.properties.texture(name)? {
            let found = self.textures.read(texture, Role::Absorption, self.warnings)?;
            return Ok(Some(Textured { value: found.factor, texture: Some(found.texture) }));
        }
        Ok(self.properties.color(name)?.map(Textured::constant))
    }

    /// Reads a share of reflected or transmitted light that must be one color.
    pub fn constant_reflectance(&mut self, name: &str, default: f32) -> Result<Vec3> {
        let location = self.properties.location(name);
        let color = self.properties.color(name)?.unwrap_or(Vec3::splat(default));
        if color.max_element() > 1.0 {
            self.warnings.push(format!("{location}: a `{name}` above 1 would create light; clamped to 1"));
        }
        Ok(color.min(Vec3::ONE))
    }

    /// Reads a number in [0, 1], or a texture that gives one.
    pub fn share(&mut self, name: &str, default: f32) -> Result<Textured<f32>> {
        let location = self.properties.location(name);
        let scalar = self.number(name, default, Role::Share)?;
        if scalar.texture.is_some() || (0.0..=1.0).contains(&scalar.value) {
            return Ok(scalar);
        }
        self.warnings.push(format!("{location}: `{name}` must lie in 0..1, not {}; clamped", scalar.value));
        Ok(Textured::constant(scalar.value.clamp(0.0, 1.0)))
    }

    /// Reads a number, a color (of which the mean counts, as in Mitsuba) or a texture.
    pub fn scalar(&mut self, name: &str, default: f32) -> Result<Textured<f32>> {
        self.number(name, default, Role::Scalar)
    }

    /// Reads a number as [`Self::scalar`] does; `role` says in which limits a computed texture must lie.
    fn number(&mut self, name: &str, default: f32, role: Role) -> Result<Textured<f32>> {
        if let Some(texture) = self.properties.texture(name)? {
            let found = self.textures.read(texture, role, self.warnings)?;
            return Ok(Textured { value: found.factor.element_sum() / 3.0, texture: Some(found.texture) });
        }
        if self.properties.is_number(name) {
            return Ok(Textured::constant(self.properties.float(name)?.unwrap_or(default)));
        }
        let color = self.properties.color(name)?;
        Ok(Textured::constant(color.map_or(default, |color| color.element_sum() / 3.0)))
    }

    /// Reads `distribution` and `alpha`, or `alpha_u` with `alpha_v`.
    pub fn microfacets(&mut self) -> Result<Microfacets> {
        let distribution = self.distribution()?;
        let [alpha_u, alpha_v] = self.alphas()?;
        Ok(Microfacets { distribution, alpha_u, alpha_v })
    }

    fn distribution(&mut self) -> Result<Distribution> {
        // Sampling of normals changes the noise only.
        self.properties.ignore_sampling(&["sample_visible"]);
        let location = self.properties.location("distribution");
        match self.properties.string("distribution")?.map(str::to_ascii_lowercase).as_deref() {
            None | Some("beckmann") => Ok(Distribution::Beckmann),
            Some("ggx") => Ok(Distribution::Ggx),
            Some(other) => {
                Err(location.error(format!("the distribution `{other}` is not supported; use `beckmann` or `ggx`")))
            }
        }
    }

    fn alphas(&mut self) -> Result<[Textured<f32>; 2]> {
        let [both, u, v] = ["alpha", "alpha_u", "alpha_v"].map(|name| self.properties.has(name));
        match (both, u, v) {
            (_, false, false) => Ok([self.alpha("alpha")?; 2]),
            (false, true, true) => Ok([self.alpha("alpha_u")?, self.alpha("alpha_v")?]),
            (true, ..) => Err(self.owner().error("give either `alpha` or both `alpha_u` and `alpha_v`")),
            _ => Err(self.owner().error("`alpha_u` and `alpha_v` must be given together")),
        }
    }

    /// Reads a roughness.
    pub fn alpha(&mut self, name: &str) -> Result<Textured<f32>> {
        let location = self.properties.location(name);
        let alpha = self.scalar(name, DEFAULT_ALPHA)?;
        match alpha.texture {
            Some(_) => Ok(alpha),
            None if alpha.value < 0.0 => {
                Err(location.error(format!("`{name}` must not be negative, as {} is", alpha.value)))
            }
            None => Ok(Textured::constant(alpha.value.max(MIN_ALPHA))),
        }
    }

    /// Reads distribution and roughness of a surface that is equally rough everywhere and in all directions.
    pub fn uniform_microfacets(&mut self) -> Result<(Distribution, f32)> {
        let Microfacets { distribution, alpha_u, alpha_v } = self.microfacets()?;
        if alpha_u.texture.is_some() || alpha_v.texture.is_some() {
            return Err(self.owner().error("`alpha` must be a number here, not a texture"));
        }
        if alpha_u != alpha_v {
            return Err(self.owner().error("`alpha_u` and `alpha_v` must be equal here"));
        }
        Ok((distribution, alpha_u.value))
    }

    /// Reads `material`, or `eta` and `k`. Without any, the conductor is a perfect mirror, as in Mitsuba 3.
    pub fn conductor(&mut self) -> Result<(Vec3, Vec3)> {
        for name in ["eta", "k"] {
            if let Some(texture) = self.properties.texture(name)? {
                return Err(texture.error(format!("`{name}` of a conductor must be a color, not a texture")));
            }
        }
        let location = self.properties.location("material");
        let name = self.properties.string("material")?.unwrap_or("none");
        let given = self.properties.has("eta") || self.properties.has("k");
        if given && name != "none" {
            return Err(location.error("give a conductor either `material` or `eta` and `k`, not both"));
        }
        let (eta, k) = named_conductors::find(name).ok_or_else(|| {
            location.error(format!(
                "the conductor `{name}` is not known; use a name of Mitsuba's, such as `Al`, or `eta` and `k`"
            ))
        })?;
        let mut given = |name: &str, default: Vec3| Ok(self.properties.signed_color(name)?.unwrap_or(default));
        let (eta, k) = (given("eta", eta)?, given("k", k)?);
        let exterior = ior::exterior(&mut self.properties)?;
        Ok((eta / exterior, k / exterior))
    }

    /// Reads the one texture of a bump or normal map, nested as `name` or, without one, under any name.
    pub fn relief_texture(&mut self, name: Option<&str>, role: Role) -> Result<(u32, f32)> {
        let object = self.owner();
        let texture = match name {
            Some(name) => self.properties.texture(name)?,
            None => self.properties.object(Kind::Texture)?,
        };
        let texture = texture.ok_or_else(|| {
            let named = name.map_or_else(String::new, |name| format!(" named `{name}`"));
            let word = object.origin.word("texture");
            object.error(format!("bsdf plugin `{}` needs a nested {word}{named}", self.properties.plugin()))
        })?;
        let found = self.textures.read(texture, role, self.warnings)?;
        Ok((found.texture, found.factor.element_sum() / 3.0))
    }
}
