//! Films, filters, samplers and integrators.

use super::tokens::brief;
use super::world::{Entity, World};
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{nested, object};
use crate::scene::description::object::{Object, Value};

/// pbrt's default size of a film.
const SIZE: [i64; 2] = [1280, 720];
/// pbrt's default depth: the number of scatterings of a path.
const DEPTH: i64 = 5;
/// Radius of pbrt's box filter that is Mitsuba's.
const BOX_RADIUS: f64 = 0.5;

/// Film with what belongs to it.
pub(super) struct Film {
    pub width: i64,
    pub height: i64,
    /// Factor of all light: exposure time times sensitivity over 100.
    pub exposure: f64,
    object: Object,
}

impl Film {
    /// Reads the film of a scene and its filter.
    pub fn read(world: &World, warnings: &mut Vec<String>) -> Result<Self> {
        let default = || match world.has_old_film {
            true => object(Kind::Rfilter, "box", []),
            false => gaussian(0.5),
        };
        let filter = world.filter.as_ref().map(|filter| rfilter(filter, warnings)).transpose()?.unwrap_or_else(default);
        let mut film = match &world.film {
            Some(entity) => film(entity, warnings)?,
            None => {
                let [width, height] = SIZE;
                Self { width, height, exposure: 1.0, object: sized(SIZE) }
            }
        };
        film.object = film.object.with("rfilter", nested(filter));
        if let Some(camera) = &world.camera {
            let time = camera.parameters.number("shutterclose", 1.0)? - camera.parameters.number("shutteropen", 0.0)?;
            if time <= 0.0 {
                return Err(
                    camera.error(format!("the shutter is open for {time}; `shutterclose` must be after `shutteropen`"))
                );
            }
            film.exposure *= time;
        }
        Ok(film)
    }

    /// The film for a sensor.
    pub fn into_object(self) -> Object {
        self.object
    }
}

fn sized([width, height]: [i64; 2]) -> Object {
    object(Kind::Film, "hdrfilm", [("width", Value::Integer(width)), ("height", Value::Integer(height))])
}

fn film(entity: &Entity, warnings: &mut Vec<String>) -> Result<Film> {
    let parameters = &entity.parameters;
    parameters.ignore(&["filename", "savefp16", "diagonal", "maxcomponentvalue", "coordinatesystem"]);
    match entity.kind.as_str() {
        "rgb" | "gbuffer" => {}
        "spectral" => {
            parameters.ignore(&["nbuckets", "lambdamin", "lambdamax"]);
            warnings.push(format!("{}: the film `spectral` is read as `rgb`", parameters.place));
        }
        other => return Err(entity.error(format!("the film `{}` is not known; use `rgb`", brief(other)))),
    }
    let side = 1..=i64::from(i32::MAX);
    let width = parameters.integer("xresolution", side.clone())?.unwrap_or(SIZE[0]);
    let height = parameters.integer("yresolution", side)?.unwrap_or(SIZE[1]);
    if let Some(sensor) = parameters.text("sensor")?.filter(|sensor| *sensor != "cie1931") {
        let message = format!("the sensor `{}` is not modeled; colors are those of `cie1931`", brief(sensor));
        warnings.push(format!("{}: {message}", parameters.place));
    }
    if parameters.number("whitebalance", 0.0)? != 0.0 {
        warnings.push(format!("{}: the `whitebalance` is not applied", parameters.place));
    }
    let exposure = parameters.positive("iso", 100.0)? / 100.0;
    let mut object = sized([width, height]);
    if let Some([x0, y0, x1, y1]) = window(entity, width, height)? {
        let crop = [("crop_offset_x", x0), ("crop_offset_y", y0), ("crop_width", x1 - x0), ("crop_height", y1 - y0)];
        object = crop.into_iter().fold(object, |film, (key, value)| film.with(key, Value::Integer(value)));
    }
    Ok(Film { width, height, exposure, object })
}

/// Window of the film as left, upper, right and lower edge in pixels; `None` for the whole film.
fn window(entity: &Entity, width: i64, height: i64) -> Result<Option<[i64; 4]>> {
    let parameters = &entity.parameters;
    let bounds = parameters.numbers("pixelbounds")?;
    let window = match (parameters.numbers("cropwindow")?, bounds) {
        (None, None) => return Ok(None),
        (Some(&[a, b, c, d]), _) => {
            let edge = |share: f64, side: i64| (share.clamp(0.0, 1.0) * side as f64).ceil() as i64;
            [edge(a.min(b), width), edge(c.min(d), height), edge(a.max(b), width), edge(c.max(d), height)]
        }
        (None, Some(&[x0, x1, y0, y1])) => {
            let edge = |at: f64, side: i64| (at as i64).clamp(0, side);
            [edge(x0, width), edge(y0, height), edge(x1, width), edge(y1, height)]
        }
        _ => return Err(entity.error("`cropwindow` and `pixelbounds` have four numbers: x from, x to, y from, y to")),
    };
    let [x0, y0, x1, y1] = window;
    match x0 < x1 && y0 < y1 {
        true => Ok(Some(window).filter(|window| *window != [0, 0, width, height])),
        false => Err(entity.error("the window of the film has no pixels; widen `cropwindow` or `pixelbounds`")),
    }
}

fn gaussian(stddev: f64) -> Object {
    object(Kind::Rfilter, "gaussian", [("stddev", Value::Float(stddev))])
}

fn rfilter(entity: &Entity, warnings: &mut Vec<String>) -> Result<Object> {
    let parameters = &entity.parameters;
    let radius = |default: f64| -> Result<f64> {
        let (x, y) = (parameters.positive("xradius", default)?, parameters.positive("yradius", default)?);
        match x == y {
            true => Ok(x),
            false => Err(entity.error(format!("a filter must be as wide as high; `xradius` is {x}, `yradius` {y}"))),
        }
    };
    let mut warn = |message: String| warnings.push(format!("{}: {message}", parameters.place));
    match entity.kind.as_str() {
        "gaussian" => {
            let (radius, sigma) = (radius(1.5)?, parameters.positive("sigma", 0.5)?);
            if radius < 2.5 * sigma {
                warn(format!("a gaussian filter ends at four standard deviations, not at {radius}"));
            }
            Ok(gaussian(sigma))
        }
        "box" => {
            let radius = radius(BOX_RADIUS)?;
            if radius != BOX_RADIUS {
                warn(format!("a box filter has the radius {BOX_RADIUS}, not {radius}"));
            }
            Ok(object(Kind::Rfilter, "box", []))
        }
        "triangle" => Ok(object(Kind::Rfilter, "tent", [("radius", Value::Float(radius(2.0)?))])),
        other @ ("mitchell" | "sinc") => {
            parameters.ignore(&["xradius", "yradius", "B", "C", "tau"]);
            warn(format!("the filter `{other}` is not supported; `gaussian` is used"));
            Ok(gaussian(0.5))
        }
        other => Err(entity.error(format!("the filter `{}` is not known; use `gaussian`", brief(other)))),
    }
}

/// Sampler for a sensor; `None` where the scene gives none.
pub(super) fn sampler(world: &World) -> Result<Option<Object>> {
    let Some(entity) = &world.sampler else { return Ok(None) };
    let parameters = &entity.parameters;
    parameters.ignore(&["seed", "randomization", "jitter", "dimensions"]);
    let range = 1..=i64::from(i32::MAX);
    let count = match entity.kind.as_str() {
        "stratified" => {
            let x = parameters.integer("xsamples", range.clone())?.unwrap_or(4);
            let y = parameters.integer("ysamples", range)?.unwrap_or(4);
            x.saturating_mul(y).min(i64::from(i32::MAX))
        }
        _ => parameters.integer("pixelsamples", range)?.unwrap_or(16),
    };
    Ok(Some(object(Kind::Sampler, "independent", [("sample_count", Value::Integer(count))])))
}

/// Integrator. Depths count edges, of which a path has one more than scatterings.
pub(super) fn integrator(world: &World, warnings: &mut Vec<String>) -> Result<Object> {
    let mut depth = DEPTH;
    if let Some(entity) = &world.integrator {
        let parameters = &entity.parameters;
        parameters.ignore(&[
            "lightsampler",
            "rrthreshold",
            "samplelights",
            "samplebsdf",
            "visualizestrategies",
            "visualizeweights",
        ]);
        let mut warn = |message: String| warnings.push(format!("{}: {message}", parameters.place));
        match entity.kind.as_str() {
            "path" | "volpath" | "simplepath" | "simplevolpath" => {}
            other @ ("randomwalk" | "bdpt" | "mlt" | "sppm" | "lightpath") => {
                let own = [
                    "mutationsperpixel",
                    "chains",
                    "bootstrapsamples",
                    "sigma",
                    "largestepprobability",
                    "photonsperiteration",
                    "radius",
                ];
                parameters.ignore(&own);
                warn(format!("the integrator `{other}` is read as `path`"));
            }
            other @ ("ao" | "function") => {
                return Err(entity.error(format!("the integrator `{other}` makes another kind of picture; use `path`")));
            }
            other => return Err(entity.error(format!("the integrator `{}` is not known; use `path`", brief(other)))),
        }
        if parameters.boolean("regularize", false)? {
            warn("`regularize` is ignored: roughness stays as it is".to_owned());
        }
        depth = parameters.integer("maxdepth", 0..=i64::from(i32::MAX) - 1)?.unwrap_or(DEPTH);
    }
    Ok(object(Kind::Integrator, "path", [("max_depth", Value::Integer(depth + 1))]))
}
