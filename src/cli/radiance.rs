//! `lodestar radiance`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lodestar::encode::bvh::Bvh;
use lodestar::film::{self, Picture};
use lodestar::gpu::{Context, ContextOptions};
use lodestar::image::{ToneCurve, png};
use lodestar::radiance_map::{self, MappedScene, SurfacePoint, false_colors};
use lodestar::scene::{self, Scene, format_names};
use lodestar::session::{Options, identity};
use lodestar::settings::Settings;
use lodestar::{Error, Result, files};

use super::given::{Given, OfMap};
use super::print::{print_line, report};

/// Writes the radiance that a guide has learned at one point, by direction (the paper's Fig. 6).
///
/// --pixel chooses the point: the surface that the center of this pixel shows. The map is a square with one pixel for each
/// direction bin of the guide; --directions sets its side.
#[derive(Debug, clap::Args)]
pub struct RadianceArgs {
    #[arg(value_name = "SCENE", help = format!("The scene: {}", format_names()))]
    scene: PathBuf,
    /// Pixel whose center shows the point.
    #[arg(long, value_name = "X,Y", value_parser = pixel)]
    pixel: [u32; 2],
    /// File to write, .exr (radiance) or .png (false colors); may be given several times.
    #[arg(short, long, value_name = "FILE", required = true, value_parser = map_path)]
    output: Vec<PathBuf>,
    /// Samples per pixel to learn from; with --truth, samples per pixel of each of six views around the point.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,
    /// Write the true radiance, which a plain path tracer measures at the point.
    #[arg(long)]
    truth: bool,
    #[command(flatten)]
    given: Given<OfMap>,
}

/// Writes the map that `args` ask for.
pub fn run(args: RadianceArgs) -> Result<ExitCode> {
    args.output.iter().try_for_each(|path| files::check_writable(path))?;
    let scene = scene::load(&scene::scene_file(&args.scene)?, &args.given.load())?;
    scene.warnings.iter().for_each(|warning| report("warning", warning));
    let device = args.given.device();
    let settings = settings(args.given, &scene)?;
    let context = Context::new(&ContextOptions { device, validate: false })?;
    let bvh = Bvh::of_scene(&scene);
    let place = MappedScene { context: &context, scene: &scene, bvh: &bvh };
    let point = place.visible_point(&settings, args.pixel)?;
    let map = match args.truth {
        true => place.true_radiance(&settings, &point, args.spp)?,
        false => place.learned_radiance(&settings, &point, args.spp)?,
    };
    let mut attributes = identity::attributes(&scene::fingerprint(&scene)?, &settings);
    attributes.extend(point_attributes(&point, args.spp, args.truth));
    args.output.iter().try_for_each(|path| write(path, &map, &settings, &attributes))?;
    let SurfacePoint { position, normal } = point;
    let mean = map.iter().sum::<f32>() / map.len() as f32;
    print_line(&format!("at {position}, normal {normal}: mean radiance over all directions {mean:.6}"))?;
    Ok(ExitCode::SUCCESS)
}

/// Settings of a map. Options that make sense for a picture only are refused.
fn settings(given: Given<OfMap>, scene: &Scene) -> Result<Settings> {
    let grows = given.text("steps") == Some("growing");
    let has_weights = given.text("sample-weights").is_some();
    let samples_emitters = given.text("nee") == Some("on");
    let settings = radiance_map::settings_for_map(given.choose(Options::new()).settings_for(scene)?)?;
    if grows {
        return Err(Error::Settings(
            "--steps growing is for a picture: steps of a map have all --spp-per-step samples".into(),
        ));
    }
    if has_weights {
        return Err(Error::Settings(
            "--sample-weights is for a picture: a map is learned from all samples alike".into(),
        ));
    }
    if samples_emitters {
        return Err(Error::Settings(
            "--nee on keeps sampled light out of the guide, so the map would lack that light: leave --nee on out"
                .into(),
        ));
    }
    Ok(settings)
}

fn point_attributes(point: &SurfacePoint, spp: u32, is_truth: bool) -> [(String, String); 4] {
    [
        ("position".into(), point.position.to_string()),
        ("surface_normal".into(), point.normal.to_string()),
        ("spp".into(), spp.to_string()),
        ("truth".into(), is_truth.to_string()),
    ]
}

fn write(path: &Path, map: &[f32], settings: &Settings, attributes: &[(String, String)]) -> Result<()> {
    let side = settings.directions;
    if files::has_extension(path, "png") {
        return png::write(path, &false_colors(map, side), ToneCurve::Srgb, 0.0);
    }
    let radiance = map.iter().map(|&value| [value; 3]).collect();
    let picture = Picture { radiance, ..Picture::empty(side, side, [0, 0], [side, side]) };
    film::write_picture(path, &picture, attributes)
}

/// Path of a map to write.
fn map_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_map = ["exr", "png"].iter().any(|ending| files::has_extension(&path, ending));
    is_map.then_some(path).ok_or_else(|| "the name must end in .exr or .png".into())
}

fn pixel(text: &str) -> Result<[u32; 2], String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    numbers.and_then(|numbers| numbers.try_into().ok()).ok_or_else(|| "write it as X,Y: two whole numbers".into())
}
