//! Readers of `<emitter>` plugins, with Mitsuba's parameters and defaults.

use glam::{DMat4, DVec3, Mat3, Vec3};

use super::element::Element;
use super::folders::FoundFile;
use super::properties::Properties;
use super::scope::Scope;
use super::textures::{Role, Textures};
use super::transform;
use crate::Result;
use crate::scene::{AreaEmitter, DeltaEmitter, DeltaKind, Environment, Textured};

/// Mitsuba's default half angle of a spot's cone, in degrees.
const DEFAULT_CUTOFF_ANGLE: f32 = 20.0;
/// Mitsuba's default beam width of a spot, as a share of the cone's half angle.
const DEFAULT_BEAM_SHARE: f32 = 0.75;

/// Plugins of emitters.
pub(super) const SUPPORTED: [&str; 6] = ["area", "constant", "envmap", "point", "spot", "directional"];

/// Emitter that stands directly in a `<scene>`.
pub(super) enum SceneEmitter {
    Environment(Environment),
    /// Environment whose image is still to be read.
    Map(EnvironmentMapFile),
    Delta(DeltaEmitter),
}

/// `envmap` with the path of its image.
pub(super) struct EnvironmentMapFile {
    pub file: FoundFile,
    pub scale: f32,
    pub to_world: Mat3,
    pub sampling_weight: f32,
}

/// Reads an emitter that stands directly in a `<scene>`.
pub(super) fn parse<'a>(element: &'a Element, scope: &Scope<'a>, warnings: &mut Vec<String>) -> Result<SceneEmitter> {
    let mut properties = Properties::new(element, scope)?;
    let sampling_weight = sampling_weight(&mut properties)?;
    let delta = |kind| SceneEmitter::Delta(DeltaEmitter { kind, sampling_weight });
    let emitter = match properties.plugin() {
        "constant" => {
            let constant = Environment::constant(color(&mut properties, "radiance")?);
            SceneEmitter::Environment(Environment { sampling_weight, ..constant })
        }
        "envmap" => SceneEmitter::Map(parse_map(&mut properties, sampling_weight)?),
        "point" => delta(parse_point(&mut properties)?),
        "spot" => delta(parse_spot(&mut properties)?),
        "directional" => delta(parse_directional(&mut properties)?),
        _ => return Err(element.unsupported(&SUPPORTED)),
    };
    properties.finish(warnings)?;
    Ok(emitter)
}

/// Reads an emitter that stands in a `<shape>`.
pub(super) fn parse_area<'a>(
    element: &'a Element,
    scope: &Scope<'a>,
    textures: &mut Textures<'a>,
    warnings: &mut Vec<String>,
) -> Result<AreaEmitter> {
    let mut properties = Properties::new(element, scope)?;
    if properties.plugin() != "area" {
        return Err(element.unsupported(&["area"]));
    }
    let sampling_weight = sampling_weight(&mut properties)?;
    let radiance = match properties.texture("radiance")? {
        Some(texture) => {
            let found = textures.read(texture, Role::Radiance, warnings)?;
            Textured { value: found.factor, texture: Some(textures.keep(found.texture)) }
        }
        None => Textured::constant(color(&mut properties, "radiance")?),
    };
    properties.finish(warnings)?;
    Ok(AreaEmitter { radiance, sampling_weight })
}

fn sampling_weight(properties: &mut Properties) -> Result<f32> {
    non_negative(properties, "sampling_weight", 1.0)
}

fn non_negative(properties: &mut Properties, name: &str, default: f32) -> Result<f32> {
    let location = properties.location(name).clone();
    match properties.float(name)? {
        Some(value) if value < 0.0 => Err(location.error(format!("`{name}` must not be negative, as {value} is"))),
        value => Ok(value.unwrap_or(default)),
    }
}

/// Color of emission, 1 in each channel where none is given.
fn color(properties: &mut Properties, name: &str) -> Result<Vec3> {
    Ok(properties.emission(name)?.unwrap_or(Vec3::ONE))
}

fn parse_map(properties: &mut Properties, sampling_weight: f32) -> Result<EnvironmentMapFile> {
    let element = properties.element();
    let parameter = properties.take("filename");
    let parameter = parameter.ok_or_else(|| element.error("emitter plugin `envmap` needs its parameter `filename`"))?;
    let name = parameter.required("value")?;
    let file = properties
        .find_any_file(parameter, name)
        .ok_or_else(|| parameter.error(format!("the image file `{name}` does not exist")))?;
    let scale = non_negative(properties, "scale", 1.0)?;
    let location = properties.location("to_world").clone();
    let to_world = orthogonal(&properties.take_to_world()?)
        .ok_or_else(|| location.error("the `to_world` of an envmap may turn and mirror it, but not scale or shear"))?;
    // The choice of sampled directions does not change the picture.
    properties.ignore_sampling(&["mis_compensation"]);
    Ok(EnvironmentMapFile { file, scale, to_world, sampling_weight })
}

/// Linear part of a matrix, made exactly orthogonal; `None` where it is not orthogonal to the precision of printed
/// scene files.
fn orthogonal(matrix: &DMat4) -> Option<Mat3> {
    let [x, y, z] = transform::axes(matrix);
    if !transform::is_similarity(matrix, 1.0e-3) || (x.length() - 1.0).abs() > 1.0e-3 {
        return None;
    }
    let x = x.normalize();
    let y = (y - y.dot(x) * x).normalize();
    let z = x.cross(y) * x.cross(y).dot(z).signum();
    Some(Mat3::from_cols(x.as_vec3(), y.as_vec3(), z.as_vec3()))
}

fn parse_point(properties: &mut Properties) -> Result<DeltaKind> {
    let position = either(properties, "position", |to_world| to_world.w_axis.truncate())?;
    Ok(DeltaKind::Point { position: position.as_vec3(), intensity: color(properties, "intensity")? })
}

fn parse_directional(properties: &mut Properties) -> Result<DeltaKind> {
    let location = properties.location("direction").clone();
    let direction = either(properties, "direction", |to_world| to_world.z_axis.truncate())?;
    let direction = direction.try_normalize().ok_or_else(|| location.error("the `direction` has length 0"))?;
    Ok(DeltaKind::Directional { direction: direction.as_vec3(), irradiance: color(properties, "irradiance")? })
}

/// Vector that is given by name, or else derived from the transform `to_world`.
fn either(properties: &mut Properties, name: &str, of_transform: fn(&DMat4) -> DVec3) -> Result<DVec3> {
    let location = properties.location("to_world").clone();
    let has_transform = properties.has("to_world");
    match (properties.point(name)?, has_transform) {
        (Some(_), true) => Err(location.error(format!("`{name}` and `to_world` cannot both be given"))),
        (Some(vector), false) => Ok(vector),
        (None, _) => Ok(of_transform(&properties.take_to_world()?)),
    }
}

fn parse_spot(properties: &mut Properties) -> Result<DeltaKind> {
    let location = properties.location("to_world").clone();
    let to_world = properties.take_to_world()?;
    let axis = to_world.z_axis.truncate().try_normalize();
    let direction = axis.ok_or_else(|| location.error("the `to_world` of a spot shrinks its axis to length 0"))?;
    let location = properties.location("cutoff_angle").clone();
    let cutoff_angle = properties.positive_float("cutoff_angle", DEFAULT_CUTOFF_ANGLE)?;
    if cutoff_angle > 180.0 {
        return Err(location.error(format!("`cutoff_angle` must be at most 180, not {cutoff_angle}")));
    }
    let beam_width = non_negative(properties, "beam_width", cutoff_angle * DEFAULT_BEAM_SHARE)?;
    Ok(DeltaKind::Spot {
        position: to_world.w_axis.truncate().as_vec3(),
        direction: direction.as_vec3(),
        intensity: color(properties, "intensity")?,
        cutoff_angle: cutoff_angle.to_radians(),
        beam_width: beam_width.to_radians(),
    })
}
