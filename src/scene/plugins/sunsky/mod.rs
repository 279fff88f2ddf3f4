//! Reader of `sunsky`: the sky by Hosek and Wilkie (2012) and the sun, as an environment map.

mod bake;
mod position;
mod sun_radiance;

use glam::{DVec3, Mat3, Vec3};

use super::emission::non_negative;
use super::properties::Properties;
use super::transform;
use crate::Result;
use crate::scene::texture::Image;
use bake::{DEFAULT_APERTURE, SunAndSky, bake};
use position::{PlaceAndTime, sun_direction};

/// Environment map that was made from a `sunsky`.
pub(super) struct BakedSky {
    pub image: Image,
    /// Orthogonal transform from the map's space to the world.
    pub to_world: Mat3,
}

/// Mitsuba's default albedo of the ground.
const DEFAULT_ALBEDO: f32 = 0.3;
/// Mitsuba's default place, Tokyo, and time.
const DEFAULT_PLACE: PlaceAndTime =
    PlaceAndTime { latitude: 35.6894, longitude: 139.6917, timezone: 9.0, year: 2010, month: 7, day: 10, hours: 15.0 };
/// Years that the sun's position is computed for.
const YEARS: std::ops::RangeInclusive<i64> = -4000..=10_000;

/// Reads a `sunsky`.
pub(super) fn parse(properties: &mut Properties, warnings: &mut Vec<String>) -> Result<BakedSky> {
    let location = properties.location("to_world");
    let to_world = transform::orthogonal(&properties.take_to_world()?)
        .ok_or_else(|| location.error("the `to_world` of a sunsky may turn and mirror it, but not scale or shear"))?;
    let location = properties.location("complex_sun");
    if properties.boolean("complex_sun")? == Some(true) {
        return Err(location.error("the sun with a darker limb (`complex_sun`) is not supported; leave it out"));
    }
    let sky = SunAndSky {
        turbidity: within(properties, "turbidity", 3.0, |turbidity| (1.0..=10.0).contains(&turbidity), "in 1..10")?,
        albedo: albedo(properties, warnings)?,
        sun: sun(properties, to_world)?,
        aperture: within(properties, "sun_aperture", DEFAULT_APERTURE, |a| a > 0.0 && a < 90.0, "between 0 and 90")?
            .to_radians(),
        sun_scale: non_negative(properties, "sun_scale", 1.0)?.into(),
        sky_scale: non_negative(properties, "sky_scale", 1.0)?.into(),
    };
    if sky.sun.z <= 0.0 {
        let location = &properties.owner().origin;
        warnings.push(format!("{location}: the sun is below the horizon, so that a `sunsky` is dark"));
    }
    let image = bake(&sky, format!("sunsky at {}", properties.owner().origin.brief()));
    // The map's `y` is the sky's `z`.
    let sky_from_map = Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y);
    Ok(BakedSky { image, to_world: to_world * sky_from_map })
}

/// Reads a number that is `legal`, which `range` says in words.
fn within(properties: &mut Properties, name: &str, default: f64, legal: fn(f64) -> bool, range: &str) -> Result<f64> {
    let location = properties.location(name);
    match properties.float(name)?.map(f64::from) {
        Some(value) if !legal(value) => Err(location.error(format!("`{name}` must lie {range}, not {value}"))),
        value => Ok(value.unwrap_or(default)),
    }
}

fn albedo(properties: &mut Properties, warnings: &mut Vec<String>) -> Result<Vec3> {
    if let Some(texture) = properties.texture("albedo")? {
        return Err(texture.error("the `albedo` of a sunsky must be a color, not a texture"));
    }
    let location = properties.location("albedo");
    let albedo = properties.color("albedo")?.unwrap_or(Vec3::splat(DEFAULT_ALBEDO));
    if albedo.max_element() > 1.0 {
        warnings.push(format!("{location}: an `albedo` above 1 would create light; clamped to 1"));
    }
    Ok(albedo.min(Vec3::ONE))
}

/// Direction to the sun in the sky's own space: from `sun_direction`, which is given in the world, or from place and time.
fn sun(properties: &mut Properties, to_world: Mat3) -> Result<DVec3> {
    let place = ["latitude", "longitude", "timezone", "year", "month", "day", "hour", "minute", "second"];
    let location = properties.location("sun_direction");
    if let Some(direction) = properties.point("sun_direction")? {
        if let Some(name) = place.into_iter().find(|name| properties.has(name)) {
            return Err(location.error(format!("give either `sun_direction` or a place and a time, not `{name}` too")));
        }
        let direction = direction.try_normalize();
        let direction = direction.ok_or_else(|| location.error("the `sun_direction` has length 0"))?;
        return Ok(to_world.transpose().as_dmat3() * direction);
    }
    let mut number = |name: &str, default: f64| Ok(properties.float(name)?.map_or(default, f64::from));
    let hours = number("hour", DEFAULT_PLACE.hours)? + number("minute", 0.0)? / 60.0 + number("second", 0.0)? / 3600.0;
    let latitude = number("latitude", DEFAULT_PLACE.latitude)?;
    let longitude = number("longitude", DEFAULT_PLACE.longitude)?;
    let timezone = number("timezone", DEFAULT_PLACE.timezone)?;
    Ok(sun_direction(&PlaceAndTime {
        latitude,
        longitude,
        timezone,
        year: properties.integer("year", YEARS)?.unwrap_or(DEFAULT_PLACE.year),
        month: properties.integer("month", 1..=12)?.unwrap_or(DEFAULT_PLACE.month),
        day: properties.integer("day", 1..=31)?.unwrap_or(DEFAULT_PLACE.day),
        hours,
    }))
}
