//! `lodestar info`.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use lodestar::film::PIXEL_BYTES;
use lodestar::scene::summary::{Guided, Summary, summarize};
use lodestar::scene::{CameraChoice, EnvironmentChoice, LoadOptions, format_names, load, scene_file};
use lodestar::session::saved_guide::SavedGuide;
use lodestar::settings::options::form::define;
use lodestar::{Error, Result, files, quoted};
use serde_json::json;

use super::print::{print_json, print_line};

/// Tells what is in a scene: shapes, materials, lights, textures, memory of images, warnings, and what will be guided. Of a guide, tells what
/// it knows.
#[derive(Debug, Clone, clap::Args)]
pub struct InfoArgs {
    #[arg(value_name = "SCENE", help = format!("The scene: {}, or a folder with a scene.xml. Or a guide (.guide)", format_names()))]
    scene: PathBuf,
    /// Value that replaces the scene's default of that name.
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = define)]
    define: Vec<(String, String)>,
    /// Camera to use: `fit`, a name, or an index counted from 0.
    #[arg(long, value_name = "fit|NAME|INDEX")]
    camera: Option<CameraChoice>,
    /// Environment that replaces the scene's: an image (.exr, .hdr and the like) or `constant`.
    #[arg(long, value_name = "FILE|constant")]
    environment: Option<EnvironmentChoice>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Reads the scene or the guide and prints its summary.
pub fn run(args: &InfoArgs) -> Result<ExitCode> {
    if files::has_extension(&args.scene, "guide") {
        return run_of_guide(args);
    }
    let InfoArgs { define, camera, environment, .. } = args.clone();
    let options = LoadOptions { defines: define, camera, environment };
    let scene = load(&scene_file(&args.scene)?, &options)?;
    let summary = summarize(&scene);
    match args.json {
        true => print_json(&WithFilm { film_bytes: film_bytes(&summary), summary: &summary })?,
        false => print_line(describe(&summary).trim_end())?,
    }
    Ok(ExitCode::SUCCESS)
}

/// Summary with the memory of a film of the scene's size.
#[derive(serde::Serialize)]
struct WithFilm<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    film_bytes: u64,
}

/// Bytes of the scene's film on a device.
fn film_bytes(summary: &Summary) -> u64 {
    u64::from(summary.width) * u64::from(summary.height) * PIXEL_BYTES
}

/// Reads the guide and prints what it knows.
fn run_of_guide(args: &InfoArgs) -> Result<ExitCode> {
    let given = [
        ("-D", !args.define.is_empty()),
        ("--camera", args.camera.is_some()),
        ("--environment", args.environment.is_some()),
    ];
    if let Some((option, _)) = given.iter().find(|(_, is_given)| *is_given) {
        let message = format!("{}: a guide is read as it is; leave {option} out", args.scene.display());
        return Err(Error::Settings(message));
    }
    let SavedGuide { scene, tables } = SavedGuide::read(&args.scene)?;
    let settings = &tables.settings;
    let named = settings.named();
    let word = |name: &str| named.iter().find(|(found, _)| found == name).map_or("", |(_, value)| value);
    let (sampler, learner) = (word("sampler"), word("learner"));
    let ([low, high], places) = (tables.cells.grid.bounds(), tables.cells.grid.size);
    let (cells, bins, groups) = (tables.cells.count(), settings.directions.pow(2), tables.group_powers.len());
    let (learned, samples) = (tables.learned_share(), tables.samples.to_string());
    if args.json {
        let (low, high, places) = (low.to_array(), high.to_array(), places.to_array());
        print_json(&json!({
            "scene": scene.name, "hash": scene.hash, "sampler": sampler, "learner": learner, "samples": samples, "cells": cells,
            "places": places, "bounds": [low, high], "bins": bins, "light_groups": groups, "learned_share": learned,
        }))?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut text = format!("guide of {} (hash without camera and film: {})\n", scene.name, scene.hash);
    let _ = writeln!(text, "sampler: {sampler}, learner: {learner}");
    let _ = writeln!(text, "samples that it has learned from, as seed:first..end: {samples}");
    let _ = writeln!(text, "cells: {cells} of {} x {} x {} places, from {low} to {high}", places.x, places.y, places.z);
    let _ = writeln!(text, "directions of each cell: {bins} bins; groups of lights: {groups}");
    let _ = writeln!(text, "cells that have learned: {:.1} %", 100.0 * learned);
    print_line(text.trim_end())?;
    Ok(ExitCode::SUCCESS)
}

fn describe(summary: &Summary) -> String {
    let Summary { name, width, height, sample_count, max_depth, .. } = summary;
    let asked = |number: Option<String>| number.unwrap_or_else(|| "not given".to_string());
    let samples = asked(sample_count.map(|n| n.to_string()));
    let depth = match max_depth {
        Some(depth) if *depth >= 0 => depth.to_string(),
        Some(_) => "unlimited".to_string(),
        None => "not given, so unlimited".to_string(),
    };
    let names = || {
        let numbered = summary.cameras.iter().enumerate();
        numbered.map(|(at, name)| name.as_ref().map_or_else(|| at.to_string(), |name| format!("{at} (`{name}`)")))
    };
    let Summary { triangles, parallelograms, disks, spheres, instances, shown_primitives, geometry_bytes, .. } =
        summary;
    let lights = &summary.lights;
    let mut text = format!("{name}: {width} x {height} pixels; samples per pixel: {samples}; max_depth: {depth}\n");
    if summary.cameras.len() > 1 {
        let _ = writeln!(text, "cameras: {}", names().collect::<Vec<_>>().join(", "));
    }
    let _ = writeln!(
        text,
        "shapes: {triangles} triangles, {parallelograms} parallelograms, {disks} disks, {spheres} spheres"
    );
    if *instances > 0 {
        let _ = writeln!(
            text,
            "instances: {instances}, with which rays see {shown_primitives} shapes; all take {}",
            quoted::size(*geometry_bytes)
        );
    }
    let _ = writeln!(
        text,
        "lights: {} emitting primitives, {} point, {} spot, {} projector, {} directional, environment: {}",
        lights.area,
        lights.point,
        lights.spot,
        lights.projector,
        lights.directional,
        lights.environment.unwrap_or("none")
    );
    let _ = writeln!(text, "materials: {}", summary.materials.len());
    for material in &summary.materials {
        let _ = writeln!(text, "  {} ({}): {}", material.name, material.kind, guided(material.guided));
    }
    let _ = writeln!(text, "textures: {}", summary.textures.len());
    for texture in &summary.textures {
        let _ = writeln!(text, "  {}: {}", texture.name, texture.image.as_deref().unwrap_or("checkerboard"));
    }
    let _ = writeln!(text, "images: {}, {}", summary.images.len(), quoted::size(summary.image_bytes));
    for image in &summary.images {
        let _ = writeln!(text, "  {}: {} x {}, {}", image.name, image.width, image.height, quoted::size(image.bytes));
    }
    let film = film_bytes(summary);
    let [all, of_film] = [film + summary.geometry_bytes + summary.image_bytes, film].map(quoted::size);
    let _ = writeln!(
        text,
        "memory of a render on its device: about {all}, of which the film of this size takes {of_film}; the guide and the program come on \
         top, and on the host a copy of the film (on a CPU, of a film of up to 4 million pixels)"
    );
    let _ = writeln!(text, "warnings: {}", summary.warnings.len());
    for warning in &summary.warnings {
        let _ = writeln!(text, "  {warning}");
    }
    text
}

fn guided(guided: Guided) -> &'static str {
    match guided {
        Guided::DiffuseLobe => "the diffuse lobe is guided",
        Guided::Whole => "a share of all directions is guided",
        Guided::Parts => "its parts are listed beside it",
        Guided::Nothing => "not guided",
    }
}
