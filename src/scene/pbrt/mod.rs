//! pbrt-v4: `.pbrt` files to a description.
//!
//! A scene keeps its numbers. pbrt's world is left-handed, so that a camera has its `+x` to the right; Mitsuba's cameras have
//! theirs to the left. Materials that transmit nothing scatter on both sides. `v` runs from an image's bottom in pbrt, from its
//! top in Mitsuba. Light is in pbrt's units: a radiance of white of 1 is a pixel of 1 (`imaging ratio`).

mod area_lights;
mod builder;
mod camera;
mod cloud;
mod coat_loss;
mod coats;
mod color_space;
mod colors;
mod combinations;
mod curves;
mod delta_lights;
mod directives;
mod environment;
mod equal_area;
mod files;
mod film;
mod form;
mod glow;
mod hair;
mod image_maps;
mod images;
mod lights;
mod maker;
mod mappings;
mod materials;
mod measured_media;
mod media;
mod metals;
mod named_spectra;
mod names;
mod nanovdb;
mod nodes;
mod old_files;
mod parameters;
mod pictured_lights;
mod procedural;
mod quadrics;
mod rasters;
mod read_form;
mod roughness;
mod shapes;
mod subdivision;
mod subsurface;
mod textures;
mod tokens;
mod transforms;
mod transmission;
mod world;

use std::collections::HashMap;
use std::path::Path;

use super::description::{self, Description};
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{nested, object};
use crate::scene::description::object::Value;
use crate::{Error, Result};
use builder::Builder;
use film::Film;
use images::Images;
use materials::Materials;
use media::Media;
use names::Names;
use shapes::Shapes;
use textures::Textures;
use world::Object;

/// Reads the file at `path` and those that it includes.
///
/// # Errors
/// Where a file cannot be read, or the scene has faults or asks for something unsupported. Also where there are definitions.
pub(super) fn read(path: &Path, defines: &[(String, String)]) -> Result<Description> {
    if let Some((name, _)) = defines.first() {
        let message = format!("-D {name}: pbrt's scenes have no values that -D replaces; leave it out");
        return Err(Error::scene(path, None, message));
    }
    let mut builder = Builder::new(path);
    let read = directives::read_file(&mut builder, path);
    let is_whole = builder.faults.keep(read).is_some();
    if let Some(place) = builder.open_block() {
        let error = place.error("an object without an ObjectEnd: is the file cut short?");
        builder.faults.add(error);
    }
    if is_whole && !builder.has_world() {
        builder.faults.add(Error::scene(path, None, "it has no WorldBegin; pbrt renders only files that have one"));
    }
    let Builder { mut files, mut faults, mut warnings, mut world, .. } = builder;
    let (shapes, groups_of_shapes) = (std::mem::take(&mut world.shapes), std::mem::take(&mut world.objects));
    let names = Names::new(path);
    let film = faults.keep(Film::read(&world, &mut warnings));
    let exposure = film.as_ref().map_or(1.0, |film| film.exposure);
    let media = Media::new(&world.media, &world.used_media, &names, exposure, &mut files, &mut faults, &mut warnings);
    warnings.extend(
        world.used_media.keys().filter_map(|name| world.media.get(name)).flat_map(|medium| medium.parameters.unread()),
    );
    let mut objects = Vec::new();
    let integrator = faults.keep(film::integrator(&world, &mut warnings));
    objects.extend(integrator.map(|object| names.entry("integrator".to_owned(), "integrator", object)));
    if let (Some(camera), Some(film)) = (&world.camera, film) {
        let sensor = faults.keep(camera::sensor(camera, &world, film.width, film.height));
        let sampler = faults.keep(film::sampler(&world)).flatten();
        let parts = [("film", Some(film.into_object())), ("sampler", sampler)];
        let parts = parts.into_iter().filter_map(|(key, part)| Some((key, part?)));
        let add = |sensor: description::object::Object| {
            let sensor = media.named(sensor, "medium", &world.camera_media[1]);
            parts.fold(sensor, |sensor, (key, part)| sensor.with(key, nested(part)))
        };
        let label = names.label(&camera.parameters.place, "camera");
        objects.extend(sensor.map(|sensor| names.entry(label, "camera", add(sensor))));
    }
    let of_film = [&world.camera, &world.film, &world.filter, &world.sampler, &world.integrator];
    warnings.extend(of_film.into_iter().flatten().flat_map(|entity| entity.parameters.unread()));
    let mut textures = Textures::new(&world, Images::new(&mut files, &mut warnings), &names);
    let lights = lights::of_scene(&world, exposure, &names, &mut textures, &mut faults);
    let mut materials = Materials::new(&names);
    let mut made = Shapes::new(&names, &media, exposure, &world);
    let mut placed = Vec::new();
    let mut groups = HashMap::new();
    for Object { name, place, shapes } in groups_of_shapes {
        let mut members = Vec::new();
        for shape in shapes {
            members.extend(faults.keep(made.objects(shape, &mut materials, &mut textures)).into_iter().flatten());
        }
        let what = format!("object `{}`", tokens::brief(&name));
        let id = names.id(&name);
        let group = object(Kind::Shape, "shapegroup", []).with_id(id.clone());
        let group = members.into_iter().fold(group, |group, (key, member)| group.with(key, nested(member)));
        placed.push((names.label(&place, &what), group));
        groups.insert(name, id);
    }
    for shape in shapes {
        placed.extend(faults.keep(made.objects(shape, &mut materials, &mut textures)).into_iter().flatten());
    }
    for instance in &world.instances {
        let Some(id) = groups.get(&instance.name) else {
            let name = tokens::brief(&instance.name);
            faults.add(instance.place.error(format!("there is no object `{name}`; define it by ObjectBegin")));
            continue;
        };
        let to_world = world.placed(&instance.to_world.matrix, instance.at_end.as_ref().map(|end| &end.matrix));
        let entries = [("group", Value::Reference(id.clone())), ("to_world", to_world)];
        placed.push(names.entry(
            names.label(&instance.place, "instance"),
            "instance",
            object(Kind::Shape, "instance", entries),
        ));
    }
    objects.extend(media.finish());
    objects.extend(textures.take_objects());
    objects.extend(materials.finish());
    objects.extend(lights);
    objects.extend(placed);
    faults.into_result()?;
    drop(textures);
    Ok(Description::of_objects(path, objects, warnings))
}
