//! Readers of sensors, films, filters and samplers.

use glam::{DMat4, Vec2};

use super::media::MediumList;
use super::properties::Properties;
use super::scope::Scope;
use super::transform;
use crate::scene::description::kinds::Kind;
use crate::scene::description::object::Object;
use crate::scene::description::origin::Origin;
use crate::scene::{Camera, Course, Crop, FilmDescription, FovAxis, Motion, Projection, ReconstructionFilter};
use crate::{Result, quoted};

/// Content of a `<sensor>`.
pub(super) struct Sensor {
    pub camera: Camera,
    pub motion: Option<Motion>,
    /// Times at which the shutter opens and closes.
    pub shutter: [f64; 2],
    pub film: FilmDescription,
    pub sample_count: Option<u32>,
    /// Medium around the camera: an index into the scene's media.
    pub medium: Option<u32>,
}

/// Diagonal of 35 mm film in millimeters, to which `focal_length` is relative.
const FILM_DIAGONAL: f64 = 43.266_615_305_567_87;
const DEFAULT_FOCAL_LENGTH: f64 = 50.0;

/// Reads a `<sensor>`.
pub(super) fn parse<'a>(
    object: &'a Object,
    scope: &Scope<'a>,
    media: &mut MediumList<'a>,
    warnings: &mut Vec<String>,
) -> Result<Sensor> {
    let mut properties = Properties::new(object, scope)?;
    let keys = properties.take_keys()?;
    let mut camera = parse_plugin(&mut properties, warnings)?;
    let film = match properties.object(Kind::Film)? {
        Some(film) => parse_film(film, scope, warnings)?,
        None => DEFAULT_FILM,
    };
    let sampler = properties.object(Kind::Sampler)?;
    let sample_count = sampler.map(|sampler| parse_sample_count(sampler, scope)).transpose()?.flatten();
    let medium = properties.object(Kind::Medium)?.map(|medium| media.keep(medium, warnings)).transpose()?;
    let shutter = parse_shutter(&mut properties)?;
    // A camera without a lens is in focus everywhere.
    properties.ignore(&["focus_distance"]);
    properties.finish(warnings)?;
    let motion = match keys {
        Some(keys) => parse_motion(&keys, shutter, object, &mut camera)?,
        None => None,
    };
    Ok(Sensor { camera, motion, shutter, film, sample_count, medium })
}

/// Camera of a `<sensor>` alone. One that moves has its place in the middle of the shutter's time.
pub(super) fn parse_camera<'a>(object: &'a Object, scope: &Scope<'a>) -> Result<Camera> {
    let mut properties = Properties::new(object, scope)?;
    let keys = properties.take_keys()?;
    let mut camera = parse_plugin(&mut properties, &mut Vec::new())?;
    let shutter = parse_shutter(&mut properties)?;
    keys.map(|keys| parse_motion(&keys, shutter, object, &mut camera)).transpose()?;
    Ok(camera)
}

fn parse_plugin(properties: &mut Properties, warnings: &mut Vec<String>) -> Result<Camera> {
    match properties.plugin() {
        "perspective" => parse_pinhole(properties),
        "thinlens" => parse_thin_lens(properties, warnings),
        "orthographic" => parse_orthographic(properties),
        "spherical" => parse_spherical(properties),
        _ => Err(properties.owner().unsupported(&["perspective", "thinlens", "orthographic", "spherical"])),
    }
}

/// Times at which the shutter opens and closes.
fn parse_shutter(properties: &mut Properties) -> Result<[f64; 2]> {
    let location = properties.location("shutter_close");
    let open = properties.float("shutter_open")?.unwrap_or(0.0);
    let close = properties.float("shutter_close")?.unwrap_or(open.max(0.0));
    match close >= open {
        true => Ok([open.into(), close.into()]),
        false => Err(location.error(format!("`shutter_close` ({close}) must not be before `shutter_open` ({open})"))),
    }
}

/// Motion of the camera, which gets its place in the middle of the shutter's time.
fn parse_motion(
    keys: &[(f64, DMat4)],
    shutter: [f64; 2],
    object: &Object,
    camera: &mut Camera,
) -> Result<Option<Motion>> {
    if camera.projection != Projection::Orthographic {
        keys.iter().try_for_each(|(_, matrix)| check_rigid(matrix, object))?;
    }
    let course = Motion::of_keys(keys, shutter);
    match course.map_err(|message| object.error(format!("its motion: {message}")))? {
        Course::Still(matrix) => {
            camera.world_from_camera = matrix.as_mat4();
            Ok(None)
        }
        Course::Moving(motion) => {
            camera.world_from_camera = motion.at(0.5).as_mat4();
            Ok(Some(motion))
        }
    }
}

fn parse_thin_lens(properties: &mut Properties, warnings: &mut Vec<String>) -> Result<Camera> {
    let object = properties.owner();
    let camera = parse_pinhole(properties)?;
    let focus_distance = properties.positive_float("focus_distance", camera.far_clip)?;
    match properties.float("aperture_radius")? {
        Some(aperture_radius) if aperture_radius > 0.0 => {
            Ok(Camera { projection: Projection::ThinLens { aperture_radius, focus_distance }, ..camera })
        }
        Some(0.0) => {
            warnings.push(format!("{}: an `aperture_radius` of 0 makes a pinhole", object.origin));
            Ok(camera)
        }
        Some(radius) => Err(object.error(format!("`aperture_radius` must not be negative, but is {radius}"))),
        None => Err(object.error("sensor plugin `thinlens` needs its parameter `aperture_radius`")),
    }
}

fn parse_orthographic(properties: &mut Properties) -> Result<Camera> {
    let object = properties.owner();
    let world_from_camera = properties.take_to_world()?.as_mat4();
    let forward = world_from_camera.z_axis.truncate();
    if !world_from_camera.is_finite() || forward.length_squared() < f32::MIN_POSITIVE {
        return Err(object.error("the sensor's `to_world` shrinks its viewing direction to length 0"));
    }
    let (near_clip, far_clip) = parse_clips(properties)?;
    let (fov, fov_axis, principal_point) = (90.0, FovAxis::X, Vec2::ZERO);
    let projection = Projection::Orthographic;
    Ok(Camera { projection, world_from_camera, fov, fov_axis, principal_point, near_clip, far_clip })
}

fn parse_spherical(properties: &mut Properties) -> Result<Camera> {
    let world_from_camera = properties.take_to_world()?;
    check_rigid(&world_from_camera, properties.owner())?;
    let world_from_camera = world_from_camera.as_mat4();
    let (near_clip, far_clip) = parse_clips(properties)?;
    let location = properties.location("mapping");
    let projection = match properties.string("mapping")? {
        None | Some("equirectangular") => {
            let mut angle = |name: &str, default: f32| Ok(properties.float(name)?.unwrap_or(default));
            let longitude = [angle("longitude_min", -180.0)?, angle("longitude_max", 180.0)?];
            let latitude = [angle("latitude_min", -90.0)?, angle("latitude_max", 90.0)?];
            Projection::Equirectangular { longitude, latitude }
        }
        Some("equal_area") => Projection::EqualArea,
        Some(other) => {
            let other = quoted::word(other);
            return Err(location.error(format!("`mapping` is `equirectangular` or `equal_area`, not {other}")));
        }
    };
    let (fov, fov_axis, principal_point) = (90.0, FovAxis::X, Vec2::ZERO);
    let camera = Camera { projection, world_from_camera, fov, fov_axis, principal_point, near_clip, far_clip };
    camera.check().map_err(|error| properties.owner().error(error.to_string()))?;
    Ok(camera)
}

/// Reads the parameters that all cameras with a center of projection share.
fn parse_pinhole(properties: &mut Properties) -> Result<Camera> {
    let world_from_camera = properties.take_to_world()?;
    check_rigid(&world_from_camera, properties.owner())?;
    let world_from_camera = world_from_camera.as_mat4();
    let (fov, fov_axis) = parse_fov(properties)?;
    let (near_clip, far_clip) = parse_clips(properties)?;
    let mut offset = |name: &str| Ok(properties.float(name)?.unwrap_or(0.0));
    let principal_point = Vec2::new(offset("principal_point_offset_x")?, offset("principal_point_offset_y")?);
    let projection = Projection::Perspective;
    Ok(Camera { projection, world_from_camera, fov, fov_axis, principal_point, near_clip, far_clip })
}

fn parse_clips(properties: &mut Properties) -> Result<(f32, f32)> {
    let near_clip = properties.positive_float("near_clip", 1e-2)?;
    let far_clip = properties.positive_float("far_clip", 1e4)?;
    if far_clip <= near_clip {
        let message = format!("`far_clip` ({far_clip}) must exceed `near_clip` ({near_clip})");
        return Err(properties.owner().error(message));
    }
    Ok((near_clip, far_clip))
}

fn check_rigid(matrix: &DMat4, object: &Object) -> Result<()> {
    let [x, ..] = transform::axes(matrix);
    // Scene files are printed with six digits.
    if (x.length_squared() - 1.0).abs() > 1e-3 || !transform::is_similarity(matrix, 1e-3) {
        return Err(object.error("the sensor's `to_world` must neither scale nor shear"));
    }
    Ok(())
}

/// Reads `fov` with its axis, or `focal_length`.
pub(super) fn parse_fov(properties: &mut Properties) -> Result<(f32, FovAxis)> {
    let location = properties.location("fov_axis");
    let axis = properties.string("fov_axis")?.map_or(Ok(FovAxis::X), |text| parse_fov_axis(text, &location))?;
    let object = properties.owner();
    let focal_length = properties.string("focal_length")?;
    let fov = properties.float("fov")?;
    match (fov, focal_length) {
        (Some(_), Some(_)) => Err(object.error("give either `fov` or `focal_length`, not both")),
        (Some(fov), None) if fov > 0.0 && fov < 180.0 => Ok((fov, axis)),
        (Some(fov), None) => Err(object.error(format!("`fov` must lie between 0 and 180 degrees, not {fov}"))),
        // A focal length refers to the diagonal, whatever `fov_axis` says.
        (None, length) => Ok((fov_from_focal_length(object, length)?, FovAxis::Diagonal)),
    }
}

fn parse_fov_axis(text: &str, origin: &Origin) -> Result<FovAxis> {
    match text.trim() {
        "x" => Ok(FovAxis::X),
        "y" => Ok(FovAxis::Y),
        "diagonal" => Ok(FovAxis::Diagonal),
        "smaller" => Ok(FovAxis::Smaller),
        "larger" => Ok(FovAxis::Larger),
        text => Err(origin.error(format!("`fov_axis` is x, y, diagonal, smaller or larger, not `{text}`"))),
    }
}

fn fov_from_focal_length(object: &Object, length: Option<&str>) -> Result<f32> {
    let millimeters = match length {
        Some(text) => text.trim().trim_end_matches("mm").trim_end().parse::<f64>().ok(),
        None => Some(DEFAULT_FOCAL_LENGTH),
    };
    let fov = millimeters
        .filter(|length| length.is_finite() && *length > 0.0)
        .map(|length| (2.0 * (0.5 * FILM_DIAGONAL / length).atan()).to_degrees() as f32)
        .filter(|fov| *fov > 0.0 && *fov < 180.0);
    fov.ok_or_else(|| {
        let text = length.unwrap_or_default();
        object.error(format!("`focal_length` should be a length such as `50mm`, not `{text}`"))
    })
}

fn parse_film<'a>(object: &'a Object, scope: &Scope<'a>, warnings: &mut Vec<String>) -> Result<FilmDescription> {
    let mut properties = Properties::new(object, scope)?;
    if !["hdrfilm", "ldrfilm"].contains(&properties.plugin()) {
        return Err(object.unsupported(&["hdrfilm", "ldrfilm"]));
    }
    let side = |size: Option<i64>, default: u32| size.map_or(default, |size| size as u32);
    let width = side(properties.integer("width", SIDE)?, 768);
    let height = side(properties.integer("height", SIDE)?, 576);
    let crop = parse_crop(&mut properties, width, height)?;
    let filter = match properties.object(Kind::Rfilter)? {
        Some(filter) => parse_filter(filter, scope, warnings)?,
        None => DEFAULT_FILTER,
    };
    properties.ignore(&[
        "attach_log",
        "banner",
        "component_format",
        "file_format",
        "high_quality_edges",
        "metadata",
        "sample_border",
    ]);
    let location = properties.location("pixel_format");
    if let Some(format @ ("luminance" | "luminance_alpha" | "xyz" | "xyza")) =
        properties.string("pixel_format")?.map(str::to_ascii_lowercase).as_deref()
    {
        warnings
            .push(format!("{location}: the `pixel_format` `{format}` is not supported; the picture is written as RGB"));
    }
    properties.finish(warnings)?;
    Ok(FilmDescription { width, height, crop, filter })
}

const SIDE: std::ops::RangeInclusive<i64> = 1..=i32::MAX as i64;

fn parse_crop(properties: &mut Properties, width: u32, height: u32) -> Result<Option<Crop>> {
    let x = properties.integer("crop_offset_x", 0..=i64::from(width) - 1)?;
    let y = properties.integer("crop_offset_y", 0..=i64::from(height) - 1)?;
    let left = x.unwrap_or(0);
    let top = y.unwrap_or(0);
    let crop_width = properties.integer("crop_width", 1..=i64::from(width) - left)?;
    let crop_height = properties.integer("crop_height", 1..=i64::from(height) - top)?;
    if [x, y, crop_width, crop_height].iter().all(Option::is_none) {
        return Ok(None);
    }
    Ok(Some(Crop {
        x: left as u32,
        y: top as u32,
        width: crop_width.unwrap_or(i64::from(width) - left) as u32,
        height: crop_height.unwrap_or(i64::from(height) - top) as u32,
    }))
}

/// Mitsuba's film, where a scene gives none.
pub(super) const DEFAULT_FILM: FilmDescription =
    FilmDescription { width: 768, height: 576, crop: None, filter: DEFAULT_FILTER };

const DEFAULT_FILTER: ReconstructionFilter = ReconstructionFilter::Gaussian { stddev: 0.5 };

fn parse_filter<'a>(object: &'a Object, scope: &Scope<'a>, warnings: &mut Vec<String>) -> Result<ReconstructionFilter> {
    let mut properties = Properties::new(object, scope)?;
    let filter = match properties.plugin() {
        "box" => ReconstructionFilter::Box,
        "tent" => ReconstructionFilter::Tent { radius: properties.positive_float("radius", 1.0)? },
        "gaussian" => ReconstructionFilter::Gaussian { stddev: properties.positive_float("stddev", 0.5)? },
        name @ ("mitchell" | "catmullrom" | "lanczos") => {
            // Negative lobes cannot be sampled. Pictures differ only in sharpness.
            warnings.push(format!("{}: rfilter `{name}` is not supported; `gaussian` is used", object.origin));
            return Ok(DEFAULT_FILTER);
        }
        _ => return Err(object.unsupported(&["box", "tent", "gaussian"])),
    };
    properties.finish(warnings)?;
    Ok(filter)
}

/// Reads `sample_count` of any sampler. The other parameters are ignored, because samplers differ in their patterns
/// only.
fn parse_sample_count<'a>(object: &'a Object, scope: &Scope<'a>) -> Result<Option<u32>> {
    let count = Properties::new(object, scope)?.integer("sample_count", 1..=i32::MAX as i64)?;
    Ok(count.map(|count| count as u32))
}
