//! Lights (`UsdLux`). What a light emits follows the formulas of its schema's documentation.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DMat4, DVec3};

use super::asset::Prim;
use super::materials::Materials;
use super::textures::{resolved, scaled};
use super::transforms::{rigid, turned};
use crate::Result;
use crate::math::srgb::luminance;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{color, matrix, nested, object};
use crate::scene::description::object::{Object, Value};
use crate::scene::spectrum;

/// Whether a type of prims is a light.
pub(super) fn is_light(kind: &str) -> bool {
    kind.ends_with("Light") || kind == "DomeLight_1"
}

/// What a light becomes.
pub(super) enum Lamp {
    /// An emitter of its own.
    Emitter(Object),
    /// A shape that emits.
    Shape(Object),
}

/// Reads a light; `None` where it is dark or not rendered.
pub(super) fn lamp(prim: &Prim, world: &DMat4, is_z_up: bool, materials: &mut Materials) -> Result<Option<Lamp>> {
    let warn = |message: &str| prim.asset.warn_of(&prim.path, message);
    let light = Light { prim };
    let radiance = light.radiance()?;
    if radiance.iter().all(|&channel| channel <= 0.0) {
        return Ok(None);
    }
    light.warn_of_what_is_ignored()?;
    let place = world.w_axis.truncate();
    let axis = -world.z_axis.truncate().normalize_or(DVec3::Z);
    let scales = [world.x_axis, world.y_axis, world.z_axis].map(|axis| axis.truncate().length());
    match &*prim.kind {
        "DistantLight" => {
            let half = 0.5 * light.number("angle", 0.53)?.to_radians().clamp(0.0, PI);
            let size = if half == 0.0 { 1.0 } else { PI * half.min(FRAC_PI_2).sin().powi(2) };
            // With `normalize`, the intensity is the irradiance.
            let factor = if light.flag("normalize")? { 1.0 } else { size };
            if half > 1.0_f64.to_radians() {
                warn("its `angle` is rendered as 0: its shadows are sharp");
            }
            let direction = ("direction", Value::Vector(axis.to_array()));
            let entries = [direction, ("irradiance", rgb(radiance, factor))];
            Ok(Some(Lamp::Emitter(object(Kind::Emitter, "directional", entries))))
        }
        "DomeLight" | "DomeLight_1" => dome(&light, radiance, world, is_z_up, materials),
        "SphereLight" => {
            let radius = light.number("radius", 0.5)?.abs();
            let scale = (scales[0] * scales[1] * scales[2]).cbrt();
            let own = radius * scale;
            let is_point = light.truth("treatAsPoint")? || own <= 0.0;
            let area = 4.0 * PI * own * own;
            if is_point {
                // The radiant intensity of a sphere, which is a quarter of the area times the radiance.
                let factor = match light.flag("normalize")? {
                    true => 0.25,
                    false if own > 0.0 => 0.25 * area,
                    false => 1.0,
                };
                return Ok(Some(Lamp::Emitter(point(&light, place, world, rgb(radiance, factor))?)));
            }
            let factor = if light.flag("normalize")? { area.recip() } else { 1.0 };
            let pose = turned(&rigid(world)) * DMat4::from_scale(DVec3::splat(own));
            light.shape("sphere", &pose, rgb(radiance, factor), materials).map(Some)
        }
        "RectLight" => {
            let (width, height) = (light.number("width", 1.0)?.abs(), light.number("height", 1.0)?.abs());
            let area = width * scales[0] * height * scales[1];
            let factor = light.per_area(area)?;
            let pose = turned(world) * DMat4::from_scale(DVec3::new(0.5 * width, 0.5 * height, 1.0));
            let shown = match light.file()? {
                Some(path) => {
                    let file = materials.images.name_of(prim.asset, &prim.path, &path)?;
                    // The top left corner of the image lies at +x and +y.
                    let flip = DMat4::from_translation(DVec3::Y) * DMat4::from_scale(DVec3::new(1.0, -1.0, 1.0));
                    let bitmap = object(
                        Kind::Texture,
                        "bitmap",
                        [("filename", file), ("wrap_mode", Value::Text("clamp".into())), ("to_uv", matrix(&flip))],
                    );
                    nested(scaled(bitmap, radiance.map(|channel| (channel * factor) as f32)))
                }
                None => rgb(radiance, factor),
            };
            light.shape("rectangle", &pose, shown, materials).map(Some)
        }
        "DiskLight" => {
            let radius = light.number("radius", 0.5)?.abs();
            let factor = light.per_area(PI * radius * radius * scales[0] * scales[1])?;
            let pose = turned(world) * DMat4::from_scale(DVec3::new(radius, radius, 1.0));
            light.shape("disk", &pose, rgb(radiance, factor), materials).map(Some)
        }
        "CylinderLight" => {
            let (radius, length) = (light.number("radius", 0.5)?.abs(), light.number("length", 1.0)?.abs());
            let across = 0.5 * (scales[1] + scales[2]);
            let (radius, length) = (radius * across, length * scales[0]);
            let factor = light.per_area(2.0 * PI * radius * length)?;
            // Mitsuba's cylinder stands on its z-axis, and USD's lies on its x-axis.
            let along =
                DMat4::from_cols(-DVec3::Z.extend(0.0), DVec3::Y.extend(0.0), DVec3::X.extend(0.0), glam::DVec4::W);
            let size = DMat4::from_scale(DVec3::new(radius, radius, length))
                * DMat4::from_translation(DVec3::new(0.0, 0.0, -0.5));
            let pose = rigid(world) * along * size;
            if light.cone()?.is_some() {
                warn("its cone is ignored: a cylinder shines to all sides");
            }
            let emitter = object(Kind::Emitter, "area", [("radiance", rgb(radiance, factor))]);
            Ok(Some(Lamp::Shape(shining("cylinder", &pose, emitter, materials))))
        }
        "PortalLight" => {
            warn("a portal is nothing by itself: the light of its dome comes through every opening");
            Ok(None)
        }
        kind => {
            warn(&format!("lights of the type `{kind}` are not rendered"));
            Ok(None)
        }
    }
}

/// Emitter of what a mesh emits by the schema `MeshLightAPI`; `None` where the mesh is no light.
pub(super) fn mesh_light(prim: &Prim) -> Result<Option<Object>> {
    if !prim.has_schema("MeshLightAPI")? {
        return Ok(None);
    }
    let light = Light { prim };
    if light.flag("normalize")? {
        prim.asset.warn_of(&prim.path, "`normalize` of a mesh light is ignored");
    }
    let radiance = light.radiance()?;
    Ok(Some(object(Kind::Emitter, "area", [("radiance", rgb(radiance, 1.0))])))
}

/// Emitter of a dome.
fn dome(
    light: &Light,
    radiance: [f64; 3],
    world: &DMat4,
    is_z_up: bool,
    materials: &mut Materials,
) -> Result<Option<Lamp>> {
    let prim = light.prim;
    let Some(path) = light.file()? else {
        return Ok(Some(Lamp::Emitter(object(Kind::Emitter, "constant", [("radiance", rgb(radiance, 1.0))]))));
    };
    let format = light.text("texture:format")?.unwrap_or_default();
    if !["", "automatic", "latlong"].contains(&&*format) {
        let message = format!("its image is in the format `{format}`, which is not read; it is dark");
        prim.asset.warn_of(&prim.path, message);
        return Ok(None);
    }
    let tint = radiance;
    let mean = tint.iter().sum::<f64>() / 3.0;
    if tint.iter().any(|channel| (channel - mean).abs() > 1.0e-4 * mean) {
        prim.asset.warn_of(&prim.path, "the color of a dome with an image is taken for its mean");
    }
    // The pole is +y, or the scene's own axis by a schema's choice. The scene has been turned to +y.
    let is_scene = prim.kind == "DomeLight_1"
        && match prim.text("poleAxis")?.as_deref() {
            Some("Z") => true,
            Some("Y") => false,
            _ => is_z_up,
        };
    let pole = if is_scene { DMat4::from_rotation_x(FRAC_PI_2) } else { DMat4::IDENTITY };
    let pose = rigid(&DMat4 { w_axis: glam::DVec4::W, ..*world }) * pole;
    let file = materials.images.name_of(prim.asset, &prim.path, &path)?;
    let entries = [("filename", file), ("scale", Value::Float(mean)), ("to_world", matrix(&pose))];
    Ok(Some(Lamp::Emitter(object(Kind::Emitter, "envmap", entries))))
}

/// Emitter of a sphere that is treated as a point.
fn point(light: &Light, place: DVec3, world: &DMat4, intensity: Value) -> Result<Object> {
    let Some((cutoff, beam)) = light.cone()? else {
        let position = ("position", Value::Vector(place.to_array()));
        return Ok(object(Kind::Emitter, "point", [position, ("intensity", intensity)]));
    };
    let entries = [
        ("to_world", matrix(&turned(&rigid(world)))),
        ("intensity", intensity),
        ("cutoff_angle", Value::Float(cutoff)),
        ("beam_width", Value::Float(beam)),
    ];
    Ok(object(Kind::Emitter, "spot", entries))
}

/// A light with its attributes, which older files give without `inputs:`.
struct Light<'l, 'a> {
    prim: &'l Prim<'a>,
}

impl Light<'_, '_> {
    fn name(&self, name: &str) -> String {
        let input = format!("inputs:{name}");
        if self.prim.has(&input) || !self.prim.has(name) { input } else { name.to_owned() }
    }

    fn number(&self, name: &str, default: f64) -> Result<f64> {
        self.prim.number(&self.name(name), default)
    }

    fn flag(&self, name: &str) -> Result<bool> {
        self.prim.flag(&self.name(name), false)
    }

    /// Flag that is no input.
    fn truth(&self, name: &str) -> Result<bool> {
        self.prim.flag(name, false)
    }

    fn text(&self, name: &str) -> Result<Option<String>> {
        self.prim.text(&self.name(name))
    }

    /// Radiance before it is normalized: color, temperature, intensity and exposure.
    fn radiance(&self) -> Result<[f64; 3]> {
        let default = if self.prim.kind == "DistantLight" { 50_000.0 } else { 1.0 };
        let strength = self.number("intensity", default)? * self.number("exposure", 0.0)?.exp2();
        let mut tint = self.prim.color(&self.name("color"), [1.0; 3])?;
        if self.flag("enableColorTemperature")? {
            let temperature = self.number("colorTemperature", 6500.0)?.clamp(1000.0, 10_000.0);
            let of_temperature = of_temperature(temperature);
            tint = std::array::from_fn(|channel| tint[channel] * of_temperature[channel]);
        }
        Ok(tint.map(|channel| channel.max(0.0) * strength))
    }

    /// Factor of the radiance of a light of that area in the world.
    fn per_area(&self, area: f64) -> Result<f64> {
        Ok(if self.flag("normalize")? && area > 0.0 { area.recip() } else { 1.0 })
    }

    /// Half angles of its cone and of its beam in degrees; `None` where it shines to all sides.
    fn cone(&self) -> Result<Option<(f64, f64)>> {
        // The schema's default holds where the schema is applied.
        let default = if self.prim.has_schema("ShapingAPI")? { 90.0 } else { 180.0 };
        let angle = self.number("shaping:cone:angle", default)?;
        if angle >= 180.0 {
            return Ok(None);
        }
        let softness = self.number("shaping:cone:softness", 0.0)?.clamp(0.0, 1.0);
        let angle = angle.max(0.2);
        Ok(Some((angle, angle * (1.0 - softness))))
    }

    /// Resolved path of its image.
    fn file(&self) -> Result<Option<String>> {
        let name = self.name("texture:file");
        let Some(value) = self.prim.value(&name)? else { return Ok(None) };
        let found = resolved(self.prim.asset, &value);
        let text = super::values::text(&value).unwrap_or_default();
        if found.is_none() && !text.is_empty() {
            let message = format!("its image is missing ({}); it shines without", crate::quoted::word(&text));
            self.prim.asset.warn_of(&self.prim.path, message);
        }
        Ok(found)
    }

    fn warn_of_what_is_ignored(&self) -> Result<()> {
        let warn = |message: &str| self.prim.asset.warn_of(&self.prim.path, message);
        if self.number("diffuse", 1.0)? != 1.0 || self.number("specular", 1.0)? != 1.0 {
            warn("its multipliers `diffuse` and `specular` are ignored");
        }
        if self.number("shaping:focus", 0.0)? != 0.0 {
            warn("its `shaping:focus` is ignored");
        }
        if self.text("shaping:ies:file")?.is_some_and(|file| !file.is_empty()) {
            warn("its IES profile is ignored");
        }
        if !self.prim.flag(&self.name("shadow:enable"), true)? {
            warn("it casts shadows, though `shadow:enable` is false");
        }
        Ok(())
    }

    /// Shape that emits, and reflects nothing.
    fn shape(&self, plugin: &'static str, pose: &DMat4, radiance: Value, materials: &mut Materials) -> Result<Lamp> {
        let emitter = match self.cone()? {
            None => object(Kind::Emitter, "area", [("radiance", radiance)]),
            Some((cutoff, beam)) => {
                let entries = [
                    ("radiance", radiance),
                    ("cutoff_angle", Value::Float(cutoff)),
                    ("beam_width", Value::Float(beam)),
                ];
                object(Kind::Emitter, "spotarea", entries)
            }
        };
        Ok(Lamp::Shape(shining(plugin, pose, emitter, materials)))
    }
}

/// Shape that has an emitter, and reflects nothing.
fn shining(plugin: &'static str, pose: &DMat4, emitter: Object, materials: &mut Materials) -> Object {
    let black = object(Kind::Bsdf, "diffuse", [("reflectance", color([0.0; 3]))]);
    let id = materials.add("light", black);
    let entries = [("to_world", matrix(pose)), ("bsdf", Value::Reference(id)), ("emitter", nested(emitter))];
    object(Kind::Shape, plugin, entries)
}

fn rgb(radiance: [f64; 3], factor: f64) -> Value {
    Value::Rgb(radiance.map(|channel| channel * factor))
}

/// Color of a black body in kelvins, of luminance 1.
fn of_temperature(temperature: f64) -> [f64; 3] {
    // The second radiation constant in nm K, and Planck's law relative to 560 nm.
    let exponent = 1.438_776_877e7 / temperature;
    let at = |wavelength: f64| {
        let relative = (exponent / 560.0).exp_m1() / (exponent / wavelength).exp_m1();
        [wavelength, (560.0 / wavelength).powi(5) * relative]
    };
    let points: Vec<[f64; 2]> = (360..=830).map(|wavelength| at(f64::from(wavelength))).collect();
    let rgb = spectrum::of_light(&points).map(|channel| channel.max(0.0));
    let scale = luminance(rgb).recip();
    rgb.map(|channel| channel * scale)
}
