//! `lodestar radiance`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lodestar::encode::bvh::Bvh;
use lodestar::film::{self, Picture};
use lodestar::gpu::{Context, ContextOptions};
use lodestar::image::{ToneCurve, png};
use lodestar::renderer::Renderer;
use lodestar::scene::{self, LoadOptions, Scene};
use lodestar::session::identity;
use lodestar::session::radiance_map::{Place, SurfacePoint, false_colors};
use lodestar::settings::{Sampler, Settings, StepSchedule};
use lodestar::{Error, Result, files};

use super::render_args::{ChoiceArgs, Switch, define, output_path};
use super::{print_line, report};

/// Writes the radiance that arrives at what a pixel shows, by direction, as a guide has learned it (the paper's Fig. 6).
///
/// The map is a square with a pixel for each of the guide's direction bins; --directions sets its side.
#[derive(Debug, clap::Args)]
pub struct RadianceArgs {
    /// The scene, in Mitsuba's XML of any version.
    #[arg(value_name = "SCENE.xml")]
    scene: PathBuf,
    /// Replace the scene's <default> of that name; may be given several times.
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = define)]
    define: Vec<(String, String)>,
    /// The pixel whose center shows the point.
    #[arg(long, value_name = "X,Y", value_parser = pixel)]
    pixel: [u32; 2],
    /// Where to write: .exr (radiance) or .png (false colors); may be given several times.
    #[arg(short, long, value_name = "FILE", required = true, value_parser = output_path)]
    output: Vec<PathBuf>,
    /// Samples per pixel to learn from, or with --truth of each of six views around the point.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,
    /// Write the truth: what a plain path tracer sees from the point.
    #[arg(long)]
    truth: bool,
    #[command(flatten)]
    choices: ChoiceArgs,
    /// Vulkan device, by index or by a part of its name, as `lodestar devices` lists them.
    #[arg(long, value_name = "INDEX|NAME", env = "LODESTAR_DEVICE", help_heading = "Device")]
    device: Option<String>,
}

/// Writes as `args` say.
pub fn run(args: &RadianceArgs) -> Result<ExitCode> {
    args.output.iter().try_for_each(|path| files::check_writable(path))?;
    let scene = scene::load(&args.scene, &LoadOptions { defines: args.define.clone() })?;
    scene.warnings.iter().for_each(|warning| report("warning", warning));
    let settings = settings(args, &scene)?;
    let device = args.device.clone().filter(|device| !device.trim().is_empty());
    let context = Context::new(&ContextOptions { device, validate: false })?;
    let bvh = Bvh::build(&scene.primitives);
    let place = Place { context: &context, scene: &scene, bvh: &bvh };
    let point = place.visible_point(&settings, args.pixel)?;
    let map = match args.truth {
        true => place.true_radiance(&settings, &point, args.spp)?,
        false => {
            let mut renderer = Renderer::new(&context, &scene, &bvh, &settings)?;
            while renderer.samples_done() < args.spp {
                let left = args.spp - renderer.samples_done();
                renderer.step(settings.spp_per_step.min(left), &|| false)?;
            }
            renderer.radiance_at(point.position)?
        }
    };
    let attributes = attributes(&scene::fingerprint(&scene)?, &settings, &point, args);
    args.output.iter().try_for_each(|path| write(path, &map, &settings, &attributes))?;
    let SurfacePoint { position, normal } = point;
    let mean = map.iter().sum::<f32>() / map.len() as f32;
    print_line(&format!("at {position}, normal {normal}: mean radiance over all directions {mean:.6}"))?;
    Ok(ExitCode::SUCCESS)
}

/// Without emitter sampling, which is on by default elsewhere.
fn settings(args: &RadianceArgs, scene: &Scene) -> Result<Settings> {
    let settings = Settings { nee: false, ..args.choices.settings(scene)? };
    if settings.sampler == Sampler::Bsdf {
        return Err(Error::Settings("--sampler bsdf learns nothing, so there is no map of it".into()));
    }
    if settings.sampler == Sampler::Quadtree {
        return Err(Error::Settings("--sampler quadtree learns flux, not radiance, so there is no map of it".into()));
    }
    if args.choices.guiding.steps == Some(StepSchedule::Growing) {
        return Err(Error::Settings(
            "--steps growing is for a picture: steps of a map have all --spp-per-step samples".into(),
        ));
    }
    if args.choices.guiding.sample_weights.is_some() {
        return Err(Error::Settings(
            "--sample-weights is for a picture: a map is learned from all samples alike".into(),
        ));
    }
    if args.choices.nee == Some(Switch::On) {
        return Err(Error::Settings(
            "--nee on leaves sampled light out of what is learned, so the map would not be radiance: leave it off"
                .into(),
        ));
    }
    Ok(settings)
}

fn attributes(
    scene_hash: &str,
    settings: &Settings,
    point: &SurfacePoint,
    args: &RadianceArgs,
) -> Vec<(String, String)> {
    let mut attributes = identity::attributes(scene_hash, settings);
    attributes.extend([
        ("position".into(), point.position.to_string()),
        ("surface_normal".into(), point.normal.to_string()),
        ("spp".into(), args.spp.to_string()),
        ("truth".into(), args.truth.to_string()),
    ]);
    attributes
}

fn write(path: &Path, map: &[f32], settings: &Settings, attributes: &[(String, String)]) -> Result<()> {
    let side = settings.directions;
    if path.extension().is_some_and(|extension| extension == "png") {
        return png::write(path, &false_colors(map, side), ToneCurve::Srgb, 0.0);
    }
    let radiance = map.iter().map(|&value| [value; 3]).collect();
    let picture = Picture { radiance, ..Picture::empty(side, side, [0, 0], [side, side]) };
    film::write_picture(path, &picture, attributes)
}

fn pixel(text: &str) -> Result<[u32; 2], String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    numbers.and_then(|numbers| numbers.try_into().ok()).ok_or_else(|| "write it as X,Y: two whole numbers".into())
}
