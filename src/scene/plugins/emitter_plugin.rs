//! Readers of `<emitter>` plugins, with Mitsuba's parameters and defaults.

use glam::{DMat4, DVec3, Mat3};

use super::emission::{color, non_negative, picture};
use super::projector::{self, Projector};
use super::properties::Properties;
use super::scope::Scope;
use super::sunsky::{self, BakedSky};
use super::textures::Textures;
use super::transform;
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::object::Object;
use crate::scene::folders::FoundFile;
use crate::scene::{AreaEmitter, Cone, DeltaEmitter, DeltaKind, Environment, PictureAxes, Textured};

/// Mitsuba's default half angle of a spot's cone, in degrees.
const DEFAULT_CUTOFF_ANGLE: f32 = 20.0;
/// Mitsuba's default beam width of a spot, as a share of the cone's half angle.
const DEFAULT_BEAM_SHARE: f32 = 0.75;

/// Least share of a cone in which its light rises, by the difference of the cosines.
const SHARPEST_BORDER: f64 = 1.0e-3;
/// Least half angle of a cone in degrees. Cosines of single precision do not tell narrower cones apart.
const NARROWEST_CONE: f32 = 0.2;

/// Plugins of emitters that stand in a `<shape>`.
const AREA: [&str; 3] = ["area", "spotarea", "directionalarea"];

/// Reader of a plugin, given the sampling weight.
type Reader = for<'a> fn(&mut Properties<'a>, f32, &mut Textures<'a>, &mut Vec<String>) -> Result<SceneEmitter>;

/// Plugins of emitters that stand directly in a `<scene>`, with their readers.
const READERS: [(&str, Reader); 8] = [
    ("constant", |properties, sampling_weight, _, _| {
        let constant = Environment::constant(color(properties, "radiance")?);
        Ok(SceneEmitter::Environment(Environment { sampling_weight, ..constant }))
    }),
    ("envmap", |properties, weight, _, _| Ok(SceneEmitter::Map(parse_map(properties, weight)?))),
    ("sunsky", |properties, weight, _, warnings| Ok(SceneEmitter::Sky(sunsky::parse(properties, warnings)?, weight))),
    ("point", |properties, weight, _, _| Ok(delta(parse_point(properties)?, weight))),
    ("spot", |properties, weight, textures, warnings| Ok(delta(parse_spot(properties, textures, warnings)?, weight))),
    ("projector", |properties, weight, textures, warnings| {
        Ok(SceneEmitter::Projector(projector::parse(properties, weight, textures, warnings)?))
    }),
    ("directional", |properties, weight, _, _| Ok(delta(parse_directional(properties)?, weight))),
    ("collimated", |properties, _, _, warnings| {
        properties.ignore(&["power", "to_world"]);
        warnings.push(format!("{}: {DARK_BEAM}", properties.owner().origin));
        Ok(SceneEmitter::Dark)
    }),
];

/// Names of all plugins of emitters.
pub(super) fn plugins() -> impl Iterator<Item = &'static str> {
    AREA.into_iter().chain(READERS.iter().map(|(name, _)| *name))
}

fn delta(kind: DeltaKind, sampling_weight: f32) -> SceneEmitter {
    SceneEmitter::Delta(DeltaEmitter { kind, sampling_weight })
}

/// Emitter that stands directly in a `<scene>`.
pub(super) enum SceneEmitter {
    Environment(Environment),
    /// Environment whose image is still to be read.
    Map(EnvironmentMapFile),
    Delta(DeltaEmitter),
    /// `sunsky`, as an environment map.
    Sky(BakedSky, f32),
    /// `projector`, whose picture's size is still to be read.
    Projector(Projector),
    /// Emitter whose light no path finds.
    Dark,
}

/// `envmap` with the path of its image.
pub(super) struct EnvironmentMapFile {
    pub file: FoundFile,
    pub scale: f32,
    pub to_world: Mat3,
    pub sampling_weight: f32,
}

/// Reads an emitter that stands directly in a `<scene>`.
pub(super) fn parse<'a>(
    object: &'a Object,
    scope: &Scope<'a>,
    textures: &mut Textures<'a>,
    warnings: &mut Vec<String>,
) -> Result<SceneEmitter> {
    let mut properties = Properties::new(object, scope)?;
    let sampling_weight = sampling_weight(&mut properties)?;
    let plugin = properties.plugin();
    let Some((_, read)) = READERS.iter().find(|(name, _)| *name == plugin) else {
        return Err(object.unsupported(&plugins().collect::<Vec<_>>()));
    };
    let emitter = read(&mut properties, sampling_weight, textures, warnings)?;
    leave_medium(&mut properties);
    properties.finish(warnings)?;
    Ok(emitter)
}

/// Passes over the medium around a lamp. Mitsuba needs it for light that is traced from the lamp; paths from the camera know their medium
/// from the surfaces that they cross.
fn leave_medium(properties: &mut Properties) {
    properties.objects(Kind::Medium);
}

const DARK_BEAM: &str = "a `collimated` beam is dark: no path from the camera finds a single ray of light";
const DARK_AREA: &str = "a `directionalarea` emitter is dark, as with Mitsuba's `path`: its light leaves along single \
    directions, which no path from the camera finds";

/// Reads an emitter that stands in a `<shape>` whose z-axis is `axis`; `None` for one whose light no path finds.
pub(super) fn parse_area<'a>(
    object: &'a Object,
    axis: DVec3,
    scope: &Scope<'a>,
    textures: &mut Textures<'a>,
    warnings: &mut Vec<String>,
) -> Result<Option<AreaEmitter>> {
    let mut properties = Properties::new(object, scope)?;
    let is_dark = properties.plugin() == "directionalarea";
    if !AREA.contains(&properties.plugin()) {
        return Err(object.unsupported(&AREA));
    }
    let sampling_weight = sampling_weight(&mut properties)?;
    let radiance = picture(&mut properties, "radiance", textures, warnings)?;
    let cone = match properties.plugin() {
        "spotarea" => Some(parse_cone(&mut properties, axis)?),
        _ => None,
    };
    leave_medium(&mut properties);
    properties.finish(warnings)?;
    if is_dark {
        warnings.push(format!("{}: {DARK_AREA}", object.origin));
    }
    Ok((!is_dark).then_some(AreaEmitter { radiance, sampling_weight, cone }))
}

fn sampling_weight(properties: &mut Properties) -> Result<f32> {
    non_negative(properties, "sampling_weight", 1.0)
}

fn parse_map(properties: &mut Properties, sampling_weight: f32) -> Result<EnvironmentMapFile> {
    let (file, _) = properties.file("filename", "image file")?;
    let scale = non_negative(properties, "scale", 1.0)?;
    let location = properties.location("to_world");
    let to_world = transform::orthogonal(&properties.take_to_world()?)
        .ok_or_else(|| location.error("the `to_world` of an envmap may turn and mirror it, but not scale or shear"))?;
    // The choice of sampled directions does not change the picture.
    properties.ignore_sampling(&["mis_compensation"]);
    Ok(EnvironmentMapFile { file, scale, to_world, sampling_weight })
}

fn parse_point(properties: &mut Properties) -> Result<DeltaKind> {
    let position = either(properties, "position", |to_world| to_world.w_axis.truncate())?;
    Ok(DeltaKind::Point { position: position.as_vec3(), intensity: color(properties, "intensity")? })
}

fn parse_directional(properties: &mut Properties) -> Result<DeltaKind> {
    let location = properties.location("direction");
    let direction = either(properties, "direction", |to_world| to_world.z_axis.truncate())?;
    let direction = direction.try_normalize().ok_or_else(|| location.error("the `direction` has length 0"))?;
    Ok(DeltaKind::Directional { direction: direction.as_vec3(), irradiance: color(properties, "irradiance")? })
}

/// Vector that is given by name, or else derived from the transform `to_world`.
fn either(properties: &mut Properties, name: &str, of_transform: fn(&DMat4) -> DVec3) -> Result<DVec3> {
    let location = properties.location("to_world");
    let has_transform = properties.has("to_world");
    match (properties.point(name)?, has_transform) {
        (Some(_), true) => Err(location.error(format!("`{name}` and `to_world` cannot both be given"))),
        (Some(vector), false) => Ok(vector),
        (None, _) => Ok(of_transform(&properties.take_to_world()?)),
    }
}

/// Reads the half angles of a spot's cone and of its beam, in degrees.
fn parse_angles(properties: &mut Properties) -> Result<(f32, f32)> {
    let of_angle = properties.location("cutoff_angle");
    let cutoff_angle = properties.positive_float("cutoff_angle", DEFAULT_CUTOFF_ANGLE)?;
    if cutoff_angle > 180.0 {
        return Err(of_angle.error(format!("`cutoff_angle` must be at most 180, not {cutoff_angle}")));
    }
    Ok((cutoff_angle, non_negative(properties, "beam_width", cutoff_angle * DEFAULT_BEAM_SHARE)?))
}

/// Reads the cone of a `spotarea` about the z-axis of its shape.
fn parse_cone(properties: &mut Properties, axis: DVec3) -> Result<Cone> {
    let axis = axis.try_normalize();
    let axis =
        axis.ok_or_else(|| properties.owner().error("the `to_world` of its shape shrinks its axis to length 0"))?;
    let of_angle = properties.location("cutoff_angle");
    let (cutoff_angle, beam_width) = parse_angles(properties)?;
    if cutoff_angle < NARROWEST_CONE {
        let message = format!("`cutoff_angle` of a `spotarea` must be at least {NARROWEST_CONE}, not {cutoff_angle}");
        return Err(of_angle.error(message));
    }
    let [cos_cutoff, cos_beam] = [cutoff_angle, beam_width].map(|angle| f64::from(angle).to_radians().cos());
    // Where the beam fills the cone, the border is sharp.
    let sharp = cos_cutoff + SHARPEST_BORDER * (1.0 - cos_cutoff);
    Ok(Cone { axis: axis.as_vec3(), cos_cutoff, cos_beam: cos_beam.max(sharp) })
}

fn parse_spot<'a>(
    properties: &mut Properties<'a>,
    textures: &mut Textures<'a>,
    warnings: &mut Vec<String>,
) -> Result<DeltaKind> {
    let location = properties.location("to_world");
    let to_world = properties.take_to_world()?;
    let axis = to_world.z_axis.truncate().try_normalize();
    let direction = axis.ok_or_else(|| location.error("the `to_world` of a spot shrinks its axis to length 0"))?;
    let (cutoff_angle, beam_width) = parse_angles(properties)?;
    let (position, direction) = (to_world.w_axis.truncate().as_vec3(), direction.as_vec3());
    let intensity = color(properties, "intensity")?;
    let (cutoff_angle, beam_width) = (cutoff_angle.to_radians(), beam_width.to_radians());
    let Textured { value, texture: Some(texture) } = picture(properties, "texture", textures, warnings)? else {
        return Ok(DeltaKind::Spot { position, direction, intensity, cutoff_angle, beam_width });
    };
    let intensity = Textured { value: intensity * value, texture: Some(texture) };
    // Mitsuba's picture fills the cone, and is mirrored as seen along it.
    let size = 2.0 * cutoff_angle.tan();
    let axes = projector::axes(&to_world, &location)?.map(|axis| axis / size);
    let axes = PictureAxes { u: axes[0], v: axes[1] };
    Ok(DeltaKind::PicturedSpot { position, direction, axes, intensity, cutoff_angle, beam_width })
}
