//! Readers of `<medium>` and `<phase>`, with the parameters and defaults of Mitsuba 3.

use std::collections::HashMap;
use std::ptr;

use glam::{DMat4, Vec3};

use super::properties::Properties;
use super::scope::Scope;
use super::volumes::{Grids, Varying};
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::object::Object;
use crate::scene::medium::{AlbedoVolume, Boundary, Medium, Phase, PhaseLobe, Volume, Volumes};

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
    grids: Grids,
}

impl<'a> MediumList<'a> {
    pub fn new(scope: Scope<'a>) -> Self {
        Self { scope, kept: HashMap::new(), list: Vec::new(), grids: Grids::default() }
    }

    /// Index of a medium that a shape or the camera uses.
    pub fn keep(&mut self, object: &'a Object, warnings: &mut Vec<String>) -> Result<u32> {
        if let Some(&index) = self.kept.get(&ptr::from_ref(object)) {
            return Ok(index);
        }
        let medium = read(object, &self.scope, &mut self.grids, warnings)?;
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
    pub fn check(&mut self, object: &'a Object, warnings: &mut Vec<String>) -> Result<()> {
        if self.kept.contains_key(&ptr::from_ref(object)) {
            return Ok(());
        }
        read(object, &self.scope, &mut self.grids, warnings).map(drop)
    }
}

/// Reads a `<medium>`.
fn read<'a>(object: &'a Object, scope: &Scope<'a>, grids: &mut Grids, warnings: &mut Vec<String>) -> Result<Medium> {
    let mut properties = Properties::new(object, scope)?;
    let varies = match properties.plugin() {
        "homogeneous" => false,
        "heterogeneous" => true,
        _ => return Err(object.unsupported(&["homogeneous", "heterogeneous"])),
    };
    let phase = match properties.object(Kind::Phase)? {
        Some(phase) => read_phase(phase, scope, warnings)?,
        None => Phase::isotropic(),
    };
    let location = properties.location("scale");
    let scale = properties.float("scale")?.unwrap_or(1.0);
    if scale < 0.0 {
        return Err(location.error(format!("`scale` of a medium must not be negative, but is {scale}")));
    }
    // No plugin of Mitsuba 3.9 has it; pbrt's media do.
    let emission = properties.emission("emission")?.unwrap_or(Vec3::ZERO);
    let Coefficients { extinction, albedo, volumes } = match varies {
        true => varying_coefficients(&mut properties, scale, scope, grids, warnings)?,
        false => {
            let (extinction, albedo) = coefficients(&mut properties, scope, warnings)?;
            Coefficients { extinction: extinction * scale, albedo, volumes: None }
        }
    };
    let most = volumes.as_ref().map_or(Vec3::ONE, |volumes| volumes.extinction.most());
    if !(extinction * most).is_finite() {
        return Err(object.error("the extinction of the medium exceeds the range of single-precision numbers"));
    }
    // They choose how Mitsuba samples.
    properties.ignore(&["sample_emitters", "has_spectral_extinction", "emission_sampling_weight"]);
    properties.finish(warnings)?;
    let name = object.id.clone().unwrap_or_else(|| format!("{} at {}", object.plugin, object.origin.brief()));
    Ok(Medium { name, extinction, albedo, phase, emission, volumes })
}

/// Coefficients of a medium: numbers, and what multiplies them.
struct Coefficients {
    extinction: Vec3,
    albedo: Vec3,
    volumes: Option<Volumes>,
}

/// Coefficients of `heterogeneous`. A color in the place of `sigma_t` stands for a `constvolume`, which fills the unit cube. Mitsuba 0.6 has
/// `density`, a factor of coefficients that are the same everywhere.
fn varying_coefficients<'a>(
    properties: &mut Properties<'a>,
    scale: f32,
    scope: &Scope<'a>,
    grids: &mut Grids,
    warnings: &mut Vec<String>,
) -> Result<Coefficients> {
    let object = properties.owner();
    let location = properties.location("albedo");
    let mut varying = |name| grids.varying(properties, name, scope, warnings);
    let [density, given_extinction, given_albedo, given_scattering, absorption, emission] =
        ["density", "sigma_t", "albedo", "sigma_s", "sigma_a", "emission_factor"].map(&mut varying);
    let (density, emission) = (density?, emission?.map(Varying::into_volume));
    let (given_extinction, given_scattering) = (given_extinction?, given_scattering?);
    let (mut albedo, albedo_grid) = match given_albedo? {
        None => (None, None),
        Some(Varying::Constant(albedo, _)) => (Some(albedo), None),
        Some(Varying::Grid(grid)) => (None, Some(grid)),
    };
    let most = albedo.or(albedo_grid.as_ref().map(Volume::most)).unwrap_or_default().max_element();
    if most > 1.0 {
        return Err(location.error(format!("the `albedo` of a medium must not exceed 1, as {most} does")));
    }
    let mut albedo_volume = albedo_grid.map(AlbedoVolume::Share);
    if albedo_volume.is_some() {
        albedo = Some(Vec3::ONE);
    }
    let (extinction, albedo, volume) = match (density, absorption?) {
        (Some(density), absorption) => {
            let constant = |varying: Option<Varying>| match varying {
                Some(Varying::Constant(value, _)) => Ok(Some(value)),
                Some(Varying::Grid(_)) => {
                    Err(object.error("beside `density`, the coefficients of a medium are colors"))
                }
                None => Ok(None),
            };
            let of_all = [given_extinction, absorption, given_scattering].map(constant);
            let [extinction, absorption, scattering] = of_all;
            let (extinction, albedo) = combined(object, extinction?, albedo, absorption?, scattering?)?;
            (extinction, albedo, density.into_volume())
        }
        (None, None) => {
            let extinction = given_extinction.unwrap_or(Varying::Constant(Vec3::ONE, DMat4::IDENTITY));
            if let Some(scattering) = given_scattering {
                if albedo.is_some() {
                    return Err(object.error("a medium has an `albedo` or `sigma_s`, not both"));
                }
                albedo = Some(Vec3::splat(scale));
                albedo_volume = Some(AlbedoVolume::Scattering(scattering.into_volume()));
            }
            (Vec3::ONE, albedo.unwrap_or(Vec3::splat(DEFAULT_ALBEDO)), extinction.into_volume())
        }
        (None, Some(_)) => {
            return Err(object.error("`sigma_a` of `heterogeneous` is not supported; give `sigma_t` and `albedo`"));
        }
    };
    let volumes = Volumes { extinction: volume, albedo: albedo_volume, emission };
    Ok(Coefficients { extinction: extinction * scale, albedo, volumes: Some(volumes) })
}

/// Extinction before its scale, and albedo, of a homogeneous medium.
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
    match albedo.and_then(|albedo| albedo.to_array().into_iter().find(|channel| *channel > 1.0)) {
        Some(channel) => Err(location.error(format!("the `albedo` of a medium must not exceed 1, as {channel} does"))),
        None => combined(object, extinction, albedo, absorption, scattering),
    }
}

/// Extinction and albedo. Mitsuba 0.6 has the coefficients of absorption and of scattering in their place.
fn combined(
    object: &Object,
    extinction: Option<Vec3>,
    albedo: Option<Vec3>,
    absorption: Option<Vec3>,
    scattering: Option<Vec3>,
) -> Result<(Vec3, Vec3)> {
    match (absorption, scattering) {
        (None, None) => Ok((extinction.unwrap_or(Vec3::ONE), albedo.unwrap_or(Vec3::splat(DEFAULT_ALBEDO)))),
        (Some(absorption), Some(scattering)) if extinction.is_none() && albedo.is_none() => {
            let extinction = absorption + scattering;
            let albedo = Vec3::select(extinction.cmpgt(Vec3::ZERO), scattering / extinction, Vec3::ZERO);
            Ok((extinction, albedo))
        }
        _ => {
            let message = "a medium is given by `sigma_t` and `albedo`, or by both `sigma_a` and `sigma_s`";
            Err(object.error(message))
        }
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
