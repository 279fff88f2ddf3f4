//! `lodestar layers`.

use std::path::PathBuf;
use std::process::ExitCode;

use lodestar::encode::bvh::Bvh;
use lodestar::gpu::{Context, ContextOptions};
use lodestar::layers::{Layer, Request};
use lodestar::scene::{self, format_names};
use lodestar::session::{Options, identity};
use lodestar::{Error, Result, files};

use super::given::{Given, OfLayers};
use super::print::{print_message, report};
use super::progress::Loading;

/// Writes layers for compositing: positions, texture coordinates, motion, and mattes by object and material.
///
/// The layers say what the camera sees first behind surfaces with holes. They have no noise of light, so a few samples suffice.
/// The mattes are Cryptomattes, with which compositors cut out objects by name. The film is that of `lodestar render` with the same
/// options.
#[derive(Debug, clap::Args)]
pub struct LayersArgs {
    #[arg(value_name = "SCENE", help = format!("The scene: {}", format_names()))]
    scene: PathBuf,
    /// File to write: .exr.
    #[arg(short, long, value_name = "FILE", value_parser = layers_path)]
    output: PathBuf,
    /// Layers, separated by commas: position, uv, motion, objects, materials [default: all].
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = layer)]
    layers: Vec<Layer>,
    /// Samples per pixel.
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..=4096))]
    spp: u32,
    /// Print nothing but warnings.
    #[arg(short, long)]
    quiet: bool,
    #[command(flatten)]
    given: Given<OfLayers>,
}

/// Attributes of a picture that say something about its layers.
const TOLD: [&str; 8] = ["version", "scene_hash", "width", "height", "crop", "filter", "seed", "hide_emitters"];

/// Writes the layers that `args` ask for.
pub fn run(args: LayersArgs) -> Result<ExitCode> {
    files::check_writable(&args.output)?;
    if args.output.exists() && !args.given.has("overwrite") {
        let message = "the file exists already; give another name with -o, or replace it with --overwrite";
        return Err(Error::Settings(format!("{}: {message}", args.output.display())));
    }
    if args.given.text("camera") == Some("all") {
        return Err(Error::Settings("--camera all is for pictures; name a camera".into()));
    }
    let working = Loading::new(args.quiet);
    working.show(&format!("reading {}", args.scene.display()));
    let scene = scene::load(&scene::scene_file(&args.scene)?, &args.given.load())?;
    working.interleave(|| scene.warnings.iter().for_each(|warning| report("warning", warning)));
    let device = args.given.device();
    let settings = args.given.choose_all(Options::new()).settings_for(&scene)?;
    let context = Context::new(&ContextOptions { device, validate: false })?;
    let bvh = Bvh::of_scene(&scene);
    let layers = if args.layers.is_empty() { &Layer::ALL[..] } else { &args.layers };
    let request =
        Request { context: &context, scene: &scene, bvh: &bvh, settings: &settings, samples: args.spp, layers };
    let mut attributes = identity::attributes(&scene::fingerprint(&scene)?, &settings);
    attributes.retain(|(name, _)| TOLD.contains(&&name[..]));
    let mut tell = |share| working.show_writing(&args.output, share);
    let notes = request.write(&args.output, &attributes, &mut tell)?;
    working.interleave(|| notes.iter().for_each(|note| report("warning", note)));
    drop(working);
    if !args.quiet {
        print_message(&format!("wrote {}", args.output.display()));
    }
    Ok(ExitCode::SUCCESS)
}

fn layers_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    files::has_extension(&path, "exr").then_some(path).ok_or_else(|| "the name must end in .exr".into())
}

fn layer(text: &str) -> Result<Layer, String> {
    let names = || Layer::ALL.map(Layer::name).join(", ");
    let found = Layer::ALL.into_iter().find(|layer| layer.name() == text);
    found.ok_or_else(|| format!("it is none of {}", names()))
}
