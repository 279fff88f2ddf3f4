//! Media as objects.

use std::collections::{BTreeMap, HashMap};
use std::mem;
use std::sync::Arc;

use glam::{DMat4, DVec3, UVec3};
use rayon::prelude::*;

use super::cloud::{self, Cloud};
use super::colors;
use super::files::Files;
use super::glow::Glow;
use super::measured_media;
use super::names::Names;
use super::nanovdb::{self, Dense};
use super::nodes::rgb;
use super::parameters::Parameter;
use super::tokens::{Place, brief};
use super::world::{Entity, Sides};
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{matrix, nested, object};
use crate::scene::description::object::{Object, Value};
use crate::scene::faults::Faults;
use crate::scene::grids::Grid;
use crate::scene::texel_pages::PAGE_WORDS;

/// Media that surfaces border or that the camera is in.
pub(super) struct Media {
    /// Ids of their objects, by their names.
    ids: HashMap<String, String>,
    objects: Vec<(String, Object)>,
}

impl Media {
    /// Makes the objects of the media that are used, each with the place of its first use. `exposure` is a factor of all light.
    pub fn new(
        defined: &HashMap<String, Entity>,
        used: &BTreeMap<String, Place>,
        names: &Names,
        exposure: f64,
        files: &mut Files,
        faults: &mut Faults,
        warnings: &mut Vec<String>,
    ) -> Self {
        let mut media = Self { ids: HashMap::new(), objects: Vec::new() };
        for (name, place) in used {
            let Some(entity) = defined.get(name) else {
                let name = brief(name);
                faults.add(place.error(format!("the medium `{name}` is not defined; define it by MakeNamedMedium")));
                continue;
            };
            let Some(made) = faults.keep(medium(name, entity, exposure, files, warnings)) else { continue };
            let id = names.id(name);
            let label = names.label(&entity.parameters.place, &format!("medium `{}`", brief(name)));
            media.objects.push((label, made.with_id(id.clone())));
            media.ids.insert(name.clone(), id);
        }
        media
    }

    /// The shape with the media on its sides. Where both are the same, pbrt's rays keep their medium. `below` is the id of the medium below
    /// a surface of its material.
    pub fn around(&self, shape: Object, sides: &Sides, below: Option<&str>) -> Object {
        let [inside, outside] = &**sides;
        if let Some(below) = below {
            return self.named(shape.with("interior", Value::Reference(below.to_owned())), "exterior", outside);
        }
        if inside == outside {
            return shape;
        }
        let with = |shape: Object, (key, name): (&'static str, &String)| self.named(shape, key, name);
        [("interior", inside), ("exterior", outside)].into_iter().fold(shape, with)
    }

    /// The object with the medium of that name.
    pub fn named(&self, object: Object, key: &'static str, name: &str) -> Object {
        match self.ids.get(name) {
            Some(id) => object.with(key, Value::Reference(id.clone())),
            None => object,
        }
    }

    /// Objects of the media.
    pub fn finish(self) -> Vec<(String, Object)> {
        self.objects
    }
}

/// Whether one of the numbers of a color is negative.
fn is_negative(color: &Parameter) -> bool {
    color.kind == "rgb" && color.numbers().is_ok_and(|numbers| numbers.iter().any(|number| *number < 0.0))
}

fn medium(name: &str, entity: &Entity, exposure: f64, files: &mut Files, warnings: &mut Vec<String>) -> Result<Object> {
    let parameters = &entity.parameters;
    parameters.ignore(&["type"]);
    let phase = object(Kind::Phase, "hg", [("g", Value::Float(parameters.number("g", 0.0)?))]);
    let made = match entity.kind.as_str() {
        "homogeneous" => homogeneous(entity, exposure, files)?,
        "uniformgrid" => uniform_grid(entity, exposure, files)?,
        "rgbgrid" => color_grid(entity, exposure)?,
        "cloud" => cloud(entity, files)?,
        "nanovdb" => nanovdb(entity, exposure, files, warnings)?,
        kind => {
            let (name, kind) = (brief(name), brief(kind));
            let known = "use `homogeneous`, `uniformgrid`, `rgbgrid`, `cloud` or `nanovdb`";
            return Err(entity.error(format!("the medium `{name}` of the type `{kind}` is not supported; {known}")));
        }
    };
    Ok(made.with("scale", Value::Float(parameters.number("scale", 1.0)?)).with("phase", nested(phase)))
}

fn homogeneous(entity: &Entity, exposure: f64, files: &mut Files) -> Result<Object> {
    let (absorption, scattering) = coefficients(entity, files)?;
    let factor = exposure * entity.parameters.number("Lescale", 1.0)?;
    let emission = emission(entity, factor, files)?;
    let coefficients = [("sigma_a", rgb(absorption)), ("sigma_s", rgb(scattering))];
    let medium = object(Kind::Medium, "homogeneous", coefficients);
    Ok(emission.into_iter().fold(medium, |medium, emission| medium.with("emission", rgb(emission))))
}

/// Medium whose coefficients are multiplied by a grid of densities.
fn uniform_grid(entity: &Entity, exposure: f64, files: &mut Files) -> Result<Object> {
    let parameters = &entity.parameters;
    let (absorption, scattering) = coefficients(entity, files)?;
    let size = size(entity)?;
    let density = needed(entity, "density")?;
    let medium = object(
        Kind::Medium,
        "heterogeneous",
        [
            ("sigma_a", rgb(absorption)),
            ("sigma_s", rgb(scattering)),
            ("density", nested(volume(entity, numbers(density, size)?)?)),
        ],
    );
    // One voxel, which pbrt interpolates like all others.
    let factor = match parameters.get("Lescale") {
        None => Grid::new(UVec3::ONE, false, vec![1.0]).map_err(|message| entity.error(message))?,
        Some(parameter) => numbers(parameter, size)?,
    };
    if let Some(temperature) = parameters.get("temperature") {
        if parameters.has("Le") {
            return Err(temperature.error("of a medium cannot stand beside `Le`; give one of them"));
        }
        let temperatures: Vec<f32> = temperature.numbers()?.iter().map(|value| *value as f32).collect();
        let mut colors = glow(entity, &temperatures)?;
        if factor.size == size {
            colors.chunks_exact_mut(3).zip(&*factor.values).for_each(|(color, factor)| {
                color.iter_mut().for_each(|channel| *channel *= factor);
            });
        }
        let colors = Grid::new(size, true, colors).map_err(|message| temperature.error(message))?;
        let emission = nested(volume(entity, colors)?);
        return Ok(medium.with("emission", rgb([exposure; 3])).with("emission_factor", emission));
    }
    let Some(emission) = emission(entity, exposure, files)? else { return Ok(medium) };
    Ok(medium.with("emission", rgb(emission)).with("emission_factor", nested(volume(entity, factor)?)))
}

/// Radiances of voxels by their temperatures, as linear sRGB.
fn glow(entity: &Entity, temperatures: &[f32]) -> Result<Vec<f32>> {
    let parameters = &entity.parameters;
    let cutoff = parameters.number("temperaturecutoff", 0.0)?;
    let (offset, scale) =
        (parameters.number("temperatureoffset", cutoff)?, parameters.number("temperaturescale", 1.0)?);
    let glow = Glow::new();
    let color = |temperature: &f32| glow.at((f64::from(*temperature) - offset) * scale).map(|channel| channel as f32);
    Ok(temperatures.par_iter().flat_map_iter(color).collect())
}

/// Medium whose coefficients are multiplied by the densities of a file of NanoVDB, and which glows by its temperatures.
fn nanovdb(entity: &Entity, exposure: f64, files: &mut Files, warnings: &mut Vec<String>) -> Result<Object> {
    let parameters = &entity.parameters;
    let (absorption, scattering) = coefficients(entity, files)?;
    let name = parameters.text("filename")?;
    let name = name.ok_or_else(|| entity.error("the medium needs its parameter \"string filename\""))?;
    let path = files.existing(name, "grid file", &parameters.place)?;
    let file = files.bytes(&path)?;
    let mut read = |grid: &str, channels: u64| {
        let found = nanovdb::read(&file, grid, PAGE_WORDS / channels);
        let found = found.map_err(|message| entity.error(format!("the grid file `{}` {message}", brief(name))))?;
        if let Some(Dense { step: step @ 2.., voxels: [x, y, z], .. }) = found {
            let grid = brief(grid);
            warnings.push(format!(
                "{}: the grid `{grid}` of {x} x {y} x {z} voxels is read {step} times as coarse; each number is the mean of \
                 {step} x {step} x {step} voxels",
                parameters.place
            ));
        }
        Ok::<_, crate::Error>(found)
    };
    let grid = parameters.text("gridname")?.unwrap_or("density");
    let mut density = read(grid, 1)?.ok_or_else(|| {
        entity.error(format!("the grid file `{}` has no grid `{}`; give a `gridname`", brief(name), brief(grid)))
    })?;
    let temperature = read(parameters.text("temperaturename")?.unwrap_or("temperature"), 3)?;
    let numbers = density.values.len() + temperature.as_ref().map_or(0, |found| 3 * found.values.len());
    files.count_grid(numbers, &parameters.place)?;
    let box_of = |dense: &Dense, values: Vec<f32>, has_colors: bool| {
        let grid =
            Grid::new(dense.size, has_colors, values).map_err(|message| entity.error(format!("the grid {message}")))?;
        Ok::<_, crate::Error>(nested(volume_in(&(entity.to_world.matrix * dense.from_unit), grid)))
    };
    let values = mem::take(&mut density.values);
    let density = box_of(&density, values, false)?;
    let entries = [("sigma_a", rgb(absorption)), ("sigma_s", rgb(scattering)), ("density", density)];
    let medium = object(Kind::Medium, "heterogeneous", entries);
    // Files of older versions of pbrt have a capital.
    let strength = parameters.number("Lescale", parameters.number("LeScale", 1.0)?)?;
    let Some(temperature) = temperature.filter(|_| strength > 0.0) else {
        parameters.ignore(&["temperatureoffset", "temperaturecutoff", "temperaturescale"]);
        return Ok(medium);
    };
    let colors = box_of(&temperature, glow(entity, &temperature.values)?, true)?;
    Ok(medium.with("emission", rgb([exposure * strength; 3])).with("emission_factor", colors))
}

/// Medium whose coefficients are multiplied by the density of a cloud. pbrt samples it between the corners of its box only.
fn cloud(entity: &Entity, files: &mut Files) -> Result<Object> {
    let parameters = &entity.parameters;
    let (absorption, scattering) = coefficients(entity, files)?;
    let number = |name: &str, default: f64| parameters.number(name, default);
    let cloud = Cloud {
        density: number("density", 1.0)?,
        wispiness: number("wispiness", 1.0)?,
        frequency: number("frequency", 5.0)?,
    };
    let (low, high) = corners(entity)?;
    let grid = Grid::new(UVec3::splat(cloud::SIDE), false, cloud.values(low, high));
    let grid = grid.map_err(|message| entity.error(format!("the cloud {message}")))?;
    let entries =
        [("sigma_a", rgb(absorption)), ("sigma_s", rgb(scattering)), ("density", nested(volume(entity, grid)?))];
    Ok(object(Kind::Medium, "heterogeneous", entries))
}

/// Medium with grids of colors in the place of coefficients.
fn color_grid(entity: &Entity, exposure: f64) -> Result<Object> {
    let parameters = &entity.parameters;
    let size = size(entity)?;
    let voxels = Grid::count(size, 3).map_err(|message| entity.error(format!("the grid {message}")))?;
    let grid = |name: &str| parameters.get(name).map(|parameter| color_values(parameter, entity, size)).transpose();
    let (absorption, scattering, emission) = (grid("sigma_a")?, grid("sigma_s")?, grid("Le")?);
    if absorption.is_none() && scattering.is_none() {
        return Err(entity.error("the medium has neither `sigma_a` nor `sigma_s`; give at least one of them"));
    }
    // As in pbrt, a coefficient that is not given is 1.
    let values = |grid: &Option<Grid>| grid.as_ref().map(|grid| Arc::clone(&grid.values));
    let or_one = |grid: &Option<Grid>| values(grid).unwrap_or_else(|| Arc::new(vec![1.0; voxels as usize]));
    let (absorption, scattering) = (or_one(&absorption), or_one(&scattering));
    let extinction = absorption.iter().zip(&*scattering).map(|(absorption, scattering)| absorption + scattering);
    let whole = |values: Vec<f32>| Grid::new(size, true, values).map_err(|message| entity.error(message));
    let extinction = whole(extinction.collect())?;
    let medium = object(
        Kind::Medium,
        "heterogeneous",
        [
            ("sigma_t", nested(volume(entity, extinction)?)),
            ("sigma_s", nested(volume(entity, whole(scattering.to_vec())?)?)),
        ],
    );
    let factor = exposure * parameters.number("Lescale", 1.0)?;
    let Some(emission) = emission else { return Ok(medium) };
    Ok(medium.with("emission", rgb([factor; 3])).with("emission_factor", nested(volume(entity, emission)?)))
}

/// Coefficients of absorption and of scattering.
fn coefficients(entity: &Entity, files: &mut Files) -> Result<([f64; 3], [f64; 3])> {
    if let Some(parameter) = entity.parameters.get("preset") {
        entity.parameters.ignore(&["sigma_a", "sigma_s"]);
        let name = parameter.text()?;
        return measured_media::named(name).ok_or_else(|| {
            parameter.error(format!("names the medium `{}`, which pbrt does not know; check its spelling", brief(name)))
        });
    }
    let mut color = |name: &str| match entity.parameters.get(name) {
        Some(parameter) if is_negative(parameter) => Err(parameter.error("of a medium must not be negative")),
        Some(parameter) => colors::of_material(parameter, entity.color_space, files),
        None => Ok([1.0; 3]),
    };
    Ok((color("sigma_a")?, color("sigma_s")?))
}

/// Emitted radiance, times a factor; `None` where the medium is dark.
fn emission(entity: &Entity, factor: f64, files: &mut Files) -> Result<Option<[f64; 3]>> {
    let Some(parameter) = entity.parameters.get("Le") else { return Ok(None) };
    let color = colors::of_light(parameter, entity.color_space, files)?;
    Ok(Some(color.map(|channel| channel * factor)))
}

/// Number of voxels along each axis.
fn size(entity: &Entity) -> Result<UVec3> {
    let [x, y, z] = ["nx", "ny", "nz"].map(|name| entity.parameters.integer(name, 1..=i64::from(u32::MAX)));
    let voxels = |given: Option<i64>| given.unwrap_or(1) as u32;
    Ok(UVec3::new(voxels(x?), voxels(y?), voxels(z?)))
}

fn needed<'e>(entity: &'e Entity, name: &str) -> Result<&'e Parameter> {
    let parameter = entity.parameters.get(name);
    parameter.ok_or_else(|| entity.error(format!("the medium needs its parameter `{name}`, one number for each voxel")))
}

/// Grid of the numbers of a parameter.
fn numbers(parameter: &Parameter, size: UVec3) -> Result<Grid> {
    let values = parameter.numbers()?.iter().map(|value| *value as f32).collect();
    Grid::new(size, false, values).map_err(|message| parameter.error(message))
}

/// Grid of the colors of a parameter.
fn color_values(parameter: &Parameter, entity: &Entity, size: UVec3) -> Result<Grid> {
    let values = parameter.numbers()?;
    let (colors, rest) = values.as_chunks::<3>();
    if !rest.is_empty() {
        return Err(parameter.error("should have three numbers for each voxel: some are missing"));
    }
    if let Some(value) = values.iter().find(|value| **value < 0.0) {
        return Err(parameter.error(format!("has the negative value {value}")));
    }
    // Other color spaces may make channels negative.
    let linear = colors.iter().flat_map(|color| entity.color_space.to_srgb(*color));
    let values = linear.map(|channel| channel.max(0.0) as f32).collect();
    Grid::new(size, true, values).map_err(|message| parameter.error(message))
}

/// Lower and upper corner of the box of a medium.
fn corners(entity: &Entity) -> Result<(DVec3, DVec3)> {
    let corner = |name: &str, default: f64| -> Result<DVec3> {
        Ok(entity.parameters.point(name)?.map_or(DVec3::splat(default), DVec3::from))
    };
    let (one, other) = (corner("p0", 0.0)?, corner("p1", 1.0)?);
    let (low, high) = (one.min(other), one.max(other));
    match (high - low).min_element() > 0.0 {
        true => Ok((low, high)),
        false => Err(entity.error("the box of the medium from `p0` to `p1` is flat")),
    }
}

/// The grid over the box of the medium. Beyond its border it is 0, as in pbrt.
fn volume(entity: &Entity, grid: Grid) -> Result<Object> {
    let (low, high) = corners(entity)?;
    let to_world = entity.to_world.matrix * DMat4::from_translation(low) * DMat4::from_scale(high - low);
    Ok(volume_in(&to_world, grid))
}

/// The grid over the box to which the matrix brings the unit cube.
fn volume_in(to_world: &DMat4, grid: Grid) -> Object {
    let entries = [
        ("grid", Value::Grid(Arc::new(grid))),
        ("to_world", matrix(to_world)),
        ("wrap_mode", Value::Text("zero".to_owned())),
    ];
    object(Kind::Volume, "gridvolume", entries)
}
