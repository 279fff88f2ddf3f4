//! `lodestar info`.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use lodestar::scene::summary::{Guided, Summary, summarize};
use lodestar::scene::{CameraChoice, EnvironmentChoice, LoadOptions, load, scene_file};
use lodestar::settings::options::form::define;
use lodestar::{Result, quoted};

use super::print::{print_json, print_line};

/// Tells what is in a scene: shapes, materials, lights, textures, memory of images, warnings, and what will be guided.
#[derive(Debug, Clone, clap::Args)]
pub struct InfoArgs {
    /// The scene: Mitsuba's XML, a folder with a scene.xml, glTF 2.0 (.gltf, .glb), or pbrt-v4 (.pbrt).
    #[arg(value_name = "SCENE")]
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

/// Reads the scene and prints its summary.
pub fn run(args: &InfoArgs) -> Result<ExitCode> {
    let InfoArgs { define, camera, environment, .. } = args.clone();
    let options = LoadOptions { defines: define, camera, environment };
    let scene = load(&scene_file(&args.scene)?, &options)?;
    let summary = summarize(&scene);
    match args.json {
        true => print_json(&summary)?,
        false => print_line(describe(&summary).trim_end())?,
    }
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
