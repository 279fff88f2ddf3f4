//! Readers of the parameters of textures.

use glam::{DMat3, DMat4, DVec3, Mat3, Vec3};

use super::properties::Properties;
use super::role::Role;
use crate::Result;
use crate::scene::description::kinds::Type;
use crate::scene::texture::{Pattern, TexelFilter, WrapMode};

/// Reads `filter_type` and `decode_after_filter`. Heights are mixed as they are, so that slopes are constant between texels.
pub(super) fn filter(properties: &mut Properties, role: Role, warnings: &mut Vec<String>) -> Result<TexelFilter> {
    let is_encoded = properties.boolean("decode_after_filter")?.unwrap_or(false) && role != Role::Heights;
    Ok(match filter_type(properties, warnings)? {
        TexelFilter::Bilinear if is_encoded => TexelFilter::Encoded,
        filter => filter,
    })
}

fn filter_type(properties: &mut Properties, warnings: &mut Vec<String>) -> Result<TexelFilter> {
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

/// Reads `wrap_mode`.
pub(super) fn wrap_mode(properties: &mut Properties) -> Result<WrapMode> {
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
pub(super) fn is_raw(properties: &mut Properties, warnings: &mut Vec<String>) -> Result<bool> {
    let location = properties.location("gamma");
    let raw = properties.boolean("raw")?;
    let gamma = properties.float("gamma")?;
    if let Some(gamma) = gamma.filter(|&gamma| gamma != -1.0 && gamma != 1.0) {
        warnings.push(format!("{location}: a `gamma` of {gamma} is not supported; the sRGB curve is used"));
    }
    Ok(raw.unwrap_or(gamma == Some(1.0)))
}

/// Reads a checkerboard. As in Mitsuba 3.9, the two colors are exchanged where it gives a number.
pub(super) fn checkerboard(properties: &mut Properties, role: Role, warnings: &mut Vec<String>) -> Result<Pattern> {
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
        Role::Scalar | Role::Share => Pattern::Checkerboard { color0: mean(color1), color1: mean(color0) },
        _ => Pattern::Checkerboard { color0, color1 },
    })
}

/// Reads a `rawconstant`: a checkerboard whose colors are equal.
pub(super) fn raw_constant(properties: &mut Properties) -> Result<Pattern> {
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
pub(super) fn to_uv(properties: &mut Properties) -> Result<Mat3> {
    let mut number = |name: &str, default: f32| Ok(f64::from(properties.float(name)?.unwrap_or(default)));
    let offset = DVec3::new(number("uoffset", 0.0)?, number("voffset", 0.0)?, 0.0);
    let scale = DVec3::new(number("uscale", 1.0)?, number("vscale", 1.0)?, 1.0);
    let own = DMat4::from_scale(scale) * DMat4::from_translation(offset);
    let matrix = properties.take_transform("to_uv")? * own;
    let column = |column: glam::DVec4, w: f64| DVec3::new(column.x, column.y, w);
    let columns = (column(matrix.x_axis, 0.0), column(matrix.y_axis, 0.0), column(matrix.w_axis, 1.0));
    Ok(DMat3::from_cols(columns.0, columns.1, columns.2).as_mat3())
}
