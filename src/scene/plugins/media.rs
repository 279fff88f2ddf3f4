//! Readers of `<medium>` and `<phase>`, with the parameters and defaults of Mitsuba 3.

use std::collections::HashMap;
use std::ptr;

use glam::Vec3;

use super::properties::Properties;
use super::scope::Scope;
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::object::Object;
use crate::scene::medium::{Boundary, Medium, Phase, PhaseLobe};

/// Mitsuba's default albedo.
const DEFAULT_ALBEDO: f32 = 0.75;
/// Most media of a scene: a material's record has 16 bits for each.
const MAX_MEDIA: usize = 65_535;
/// Phase functions that can be read.
const PHASES: [&str; 4] = ["isotropic", "hg", "rayleigh", "blendphase"];

/// Media of a scene while it is read.
pub(super) struct MediumList<'a> {
    scope: Scope<'a>,
    /// Indices by the object's address: each medium is kept once, however many shapes refer to it.
    kept: HashMap<*const Object, u32>,
    pub list: Vec<Medium>,
}

impl<'a> MediumList<'a> {
    pub fn new(scope: Scope<'a>) -> Self {
        Self { scope, kept: HashMap::new(), list: Vec::new() }
    }

    /// Index of a medium that a shape or the camera uses.
    pub fn keep(&mut self, object: &'a Object, warnings: &mut Vec<String>) -> Result<u32> {
        if let Some(&index) = self.kept.get(&ptr::from_ref(object)) {
            return Ok(index);
        }
        let medium = read(object, &self.scope, warnings)?;
        if self.list.len() == MAX_MEDIA {
            return Err(object.error(format!("more than {MAX_MEDIA} media are not supported")));
        }
        let index = self.list.len() as u32;
        self.list.push(medium);
        self.kept.insert(object, index);
        Ok(index)
    }

    /// Media on the two sides of a shape; `None` for a shape that bounds none.
    pub fn boundary(
        &mut self,
        properties: &mut Properties<'a>,
        warnings: &mut Vec<String>,
    ) -> Result<Option<Boundary>> {
        let mut boundary = Boundary { interior: None, exterior: None };
        for (name, object) in properties.named_objects(Kind::Medium) {
            let side = match &*name {
                "interior" => &mut boundary.interior,
                "exterior" => &mut boundary.exterior,
                _ => {
                    let word = object.origin.word("medium");
                    return Err(
                        object.error(format!("a {word} of a shape is named `interior` or `exterior`, not `{name}`"))
                    );
                }
            };
            if side.replace(self.keep(object, warnings)?).is_some() {
                return Err(object.error(format!("a second medium named `{name}` in one shape")));
            }
        }
        Ok((boundary.interior.is_some() || boundary.exterior.is_some()).then_some(boundary))
    }

    /// Checks a medium, whether or not a shape uses it.
    pub fn check(&self, object: &'a Object, warnings: &mut Vec<String>) -> Result<()> {
        if self.kept.contains_key(&ptr::from_ref(object)) {
            return Ok(());
        }
        read(object, &self.scope, warnings).map(drop)
    }
}

/// Reads a `<medium>`.
fn read<'a>(object: &'a Object, scope: &Scope<'a>, warnings: &mut Vec<String>) -> Result<Medium> {
    let mut properties = Properties::new(object, scope)?;
    if properties.plugin() != "homogeneous" {
        return Err(object.unsupported(&["homogeneous"]));
    }
    let phase = match properties.object(Kind::Phase)? {
        Some(phase) => read_phase(phase, scope, warnings)?,
        None => Phase::isotropic(),
    };
    let location = properties.location("scale");
    let scale = properties.float("scale")?.unwrap_or(1.0);
    if scale < 0.0 {
        return Err(location.error(format!("`scale` of a medium must not be negative, but is {scale}")));
    }
    let (extinction, albedo) = coefficients(&mut properties, scope, warnings)?;
    let extinction = extinction * scale;
    if !extinction.is_finite() {
        return Err(object.error("the extinction of the medium exceeds the range of single-precision numbers"));
    }
    // They choose how Mitsuba samples.
    properties.ignore(&["sample_emitters", "has_spectral_extinction", "emission_sampling_weight"]);
    properties.finish(warnings)?;
    let name = object.id.clone().unwrap_or_else(|| format!("{} at {}", object.plugin, object.origin.brief()));
    Ok(Medium { name, extinction, albedo, phase })
}

/// Extinction before its scale, and albedo. Mitsuba 0.6 has the coefficients of absorption and of scattering in their place.
fn coefficients<'a>(
    properties: &mut Properties<'a>,
    scope: &Scope<'a>,
    warnings: &mut Vec<String>,
) -> Result<(Vec3, Vec3)> {
    let object = properties.owner();
    let location = properties.location("albedo");
    let mut color = |name| color_or_volume(properties, name, scope, warnings);
    let (extinction, albedo) = (color("sigma_t")?, color("albedo")?);
    let (absorption, scattering) = (color("sigma_a")?, color("sigma_s")?);
    match (absorption, scattering) {
        (None, None) => {}
        (Some(absorption), Some(scattering)) if extinction.is_none() && albedo.is_none() => {
            let extinction = absorption + scattering;
            let albedo = Vec3::select(extinction.cmpgt(Vec3::ZERO), scattering / extinction, Vec3::ZERO);
            return Ok((extinction, albedo));
        }
        _ => {
            let message = "a medium is given by `sigma_t` and `albedo`, or by both `sigma_a` and `sigma_s`";
            return Err(object.error(message));
        }
    }
    let albedo = albedo.unwrap_or(Vec3::splat(DEFAULT_ALBEDO));
    match albedo.to_array().into_iter().find(|channel| *channel > 1.0) {
        Some(channel) => Err(location.error(format!("the `albedo` of a medium must not exceed 1, as {channel} does"))),
        None => Ok((extinction.unwrap_or(Vec3::ONE), albedo)),
    }
}

/// Color that is given as such, or as a `constvolume`.
fn color_or_volume<'a>(
    properties: &mut Properties<'a>,
    name: &str,
    scope: &Scope<'a>,
    warnings: &mut Vec<String>,
) -> Result<Option<Vec3>> {
    let Some(volume) = properties.nested(name, Kind::Volume)? else { return properties.color(name) };
    let mut inner = Properties::new(volume, scope)?;
    if inner.plugin() != "constvolume" {
        return Err(volume.unsupported(&["constvolume"]));
    }
    let value = inner.color("value")?;
    inner.finish(warnings)?;
    Ok(Some(value.unwrap_or(Vec3::ONE)))
}

/// Reads a `<phase>`.
fn read_phase<'a>(object: &'a Object, scope: &Scope<'a>, warnings: &mut Vec<String>) -> Result<Phase> {
    let mut properties = Properties::new(object, scope)?;
    let phase = match properties.plugin() {
        "blendphase" => read_blend(&mut properties, scope, warnings)?,
        plugin if PHASES.contains(&plugin) => Phase::of_lobe(read_lobe(&mut properties)?),
        _ => return Err(object.unsupported(&PHASES)),
    };
    properties.finish(warnings)?;
    Ok(phase)
}

/// Reads a phase function of one lobe.
fn read_lobe(properties: &mut Properties) -> Result<PhaseLobe> {
    let location = properties.location("g");
    match properties.plugin() {
        "hg" => match properties.float("g")?.unwrap_or(0.8) {
            g if g.abs() < 1.0 => Ok(PhaseLobe::HenyeyGreenstein(g)),
            g => Err(location.error(format!("`g` must lie between -1 and 1, but is {g}"))),
        },
        "rayleigh" => Ok(PhaseLobe::Rayleigh),
        _ => Ok(PhaseLobe::HenyeyGreenstein(0.0)),
    }
}

fn read_blend<'a>(properties: &mut Properties<'a>, scope: &Scope<'a>, warnings: &mut Vec<String>) -> Result<Phase> {
    let object = properties.owner();
    let location = properties.location("weight");
    let weight = color_or_volume(properties, "weight", scope, warnings)?;
    let weight = weight.ok_or_else(|| object.error("phase plugin `blendphase` needs its parameter `weight`"))?.x;
    if weight > 1.0 {
        return Err(location.error(format!("`weight` must lie in [0, 1], but is {weight}")));
    }
    let [first, second] = properties.objects(Kind::Phase)[..] else {
        let word = object.origin.word("phase");
        return Err(object.error(format!("phase plugin `blendphase` needs exactly two nested {word}s")));
    };
    let mut lobe = |nested: &'a Object| {
        let mut inner = Properties::new(nested, scope)?;
        if !PHASES[..3].contains(&inner.plugin()) {
            return Err(nested.unsupported(&PHASES[..3]));
        }
        let lobe = read_lobe(&mut inner)?;
        inner.finish(warnings)?;
        Ok(lobe)
    };
    Ok(Phase { lobes: [lobe(first)?, lobe(second)?], second_lobe: weight })
}
