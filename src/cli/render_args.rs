//! The arguments of `lodestar render`, and the library's options that they stand for.

use std::path::PathBuf;
use std::sync::Arc;

use clap::ValueEnum;
use lodestar::gpu::ContextOptions;
use lodestar::image::ToneCurve;
use lodestar::scene::{Crop, ReconstructionFilter};
use lodestar::session::{CHECKPOINT_EVERY, FilmSize, Options, OutputFiles};
use lodestar::settings::{Execution, SamplePattern, Settings};

use super::guiding_args::GuidingArgs;

/// Renders a Mitsuba scene.
///
/// Whichever of --spp, --time and --noise is reached first ends the render, and so does Ctrl-C: the picture so far is written. What
/// the scene file leaves open and no option gives: 64 samples per pixel, depth 16, roulette (by throughput) after depth 8.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct RenderArgs {
    /// The scene, in Mitsuba's XML of any version.
    #[arg(value_name = "SCENE.xml")]
    pub scene: PathBuf,
    /// Replace the scene's <default> of that name; may be given several times.
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = define, help_heading = "Scene")]
    pub define: Vec<(String, String)>,
    /// Keep in this file what it takes to go on, with `lodestar resume FILE`, after a signal, a fault or a power cut.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub checkpoint: Option<PathBuf>,
    /// Write it every so many seconds, and when the render ends.
    #[arg(long, value_name = "SECONDS", requires = "checkpoint", default_value_t = CHECKPOINT_EVERY, value_parser = seconds, help_heading = "Output")]
    pub checkpoint_every: f64,
    #[command(flatten)]
    pub files: OutputArgs,
    #[command(flatten)]
    pub length: LengthArgs,
    #[command(flatten)]
    pub choices: ChoiceArgs,
    #[command(flatten)]
    pub device: DeviceArgs,
}

/// Where the picture goes and what is said about it.
#[derive(Debug, Clone, clap::Args)]
pub struct OutputArgs {
    /// Where to write: .exr (every layer) or .png (as --tone and --exposure say); may be given several times
    /// [default: the scene's name with .exr].
    #[arg(short, long, value_name = "FILE", value_parser = output_path, help_heading = "Output")]
    pub output: Vec<PathBuf>,
    /// Tone curve of PNG files [default: srgb].
    #[arg(long, value_enum, help_heading = "Output")]
    pub tone: Option<ToneCurve>,
    /// Exposure of PNG files: brighter by 2^STOPS [default: 0].
    #[arg(long, value_name = "STOPS", value_parser = finite, help_heading = "Output")]
    pub exposure: Option<f32>,
    /// Write the picture so far every so many seconds.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, help_heading = "Output")]
    pub write_every: Option<f64>,
    /// Measure the error against this picture as the render goes; it lands in --stats.
    #[arg(long, value_name = "REF.exr", help_heading = "Output")]
    pub reference: Option<PathBuf>,
    /// Write settings, timings and statistics of every step as JSON.
    #[arg(long, value_name = "STATS.json", help_heading = "Output")]
    pub stats: Option<PathBuf>,
    /// Time every dispatch: a table at the end, and a trace for ui.perfetto.dev or chrome://tracing in this file.
    #[arg(long, value_name = "TRACE.json", help_heading = "Output")]
    pub profile: Option<PathBuf>,
    /// Show no progress.
    #[arg(short, long, help_heading = "Output")]
    pub quiet: bool,
}

/// What ends the render.
#[derive(Debug, Clone, clap::Args)]
pub struct LengthArgs {
    /// Samples per pixel.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Length")]
    pub spp: Option<u32>,
    /// Stop after so many seconds of rendering; loading does not count.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, help_heading = "Length")]
    pub time: Option<f64>,
}

/// What the settings are made of.
#[derive(Debug, clap::Args)]
pub struct ChoiceArgs {
    /// Width of the film in pixels.
    #[arg(long, value_name = "W", requires = "height", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Scene")]
    pub width: Option<u32>,
    /// Height of the film in pixels.
    #[arg(long, value_name = "H", requires = "width", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Scene")]
    pub height: Option<u32>,
    /// Size of the film, relative to what the scene says.
    #[arg(long, value_name = "F", conflicts_with_all = ["width", "height"], value_parser = positive, help_heading = "Scene")]
    pub scale: Option<f32>,
    /// Render only this window of the film, in pixels from its top left corner.
    #[arg(long, value_name = "X,Y,W,H", allow_hyphen_values = true, value_parser = crop, help_heading = "Scene")]
    pub crop: Option<Crop>,
    /// Reconstruction filter [default: the scene's].
    #[arg(long, value_enum, value_name = "FILTER", help_heading = "Scene")]
    pub rfilter: Option<Filter>,

    /// Sample each tile of 8 x 8 pixels until its relative error, and that of its neighbors, is at most TARGET by estimate (0.05,
    /// say): the picture is then consistent, not unbiased. --spp and --time still end it [default: all pixels alike].
    #[arg(long, value_name = "TARGET", help_heading = "Length")]
    pub noise: Option<f32>,

    /// Longest path in edges; 1 is emission seen directly.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Paths")]
    pub max_depth: Option<u32>,
    /// Depth after which Russian roulette by throughput is played; see --roulette.
    #[arg(long, value_name = "N", help_heading = "Paths")]
    pub rr_depth: Option<u32>,
    /// Sample emitters at every vertex of a path (next event estimation) [default: on].
    #[arg(long, value_enum, help_heading = "Paths")]
    pub nee: Option<Switch>,
    /// Seed of the random numbers; the same one gives the same pixels.
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Paths")]
    pub seed: u32,
    /// How the samples of a pixel are distributed [default: sobol].
    #[arg(long, value_enum, help_heading = "Paths")]
    pub pattern: Option<SamplePattern>,
    /// Begin with sample K of every pixel (0 is the first), for a part of a picture that `lodestar merge` puts together.
    #[arg(long, value_name = "K", help_heading = "Paths")]
    pub sample_offset: Option<u32>,

    #[command(flatten)]
    pub guiding: GuidingArgs,
    /// Most samples per pixel of one dispatch: a driver may bound the loop iterations of one [default: 8].
    #[arg(long, value_name = "N", help_heading = "Device")]
    pub samples_per_dispatch: Option<u32>,
}

/// What renders.
#[derive(Debug, Clone, clap::Args)]
pub struct DeviceArgs {
    /// Vulkan device, by index or by a part of its name, as `lodestar devices` lists them.
    #[arg(long, value_name = "INDEX|NAME", env = "LODESTAR_DEVICE", help_heading = "Device")]
    pub device: Option<String>,
    /// How long a dispatch should take, in milliseconds [default: 50 on a GPU, 150 on a CPU].
    #[arg(long, value_name = "MS", value_parser = seconds, help_heading = "Device")]
    pub slice_ms: Option<f64>,
    /// How paths are traced: by one kernel, or as waves, which takes memory for the paths (at most 800 MiB). With --kernel-dir,
    /// auto is megakernel.
    #[arg(long, value_enum, default_value_t = Execution::Auto, help_heading = "Device")]
    pub execution: Execution,
    /// Take kernels from the .spv files of this folder, which `lodestar inspect --out` writes and a person has edited.
    #[arg(long, value_name = "DIR", help_heading = "Device")]
    pub kernel_dir: Option<PathBuf>,
    /// Turn Vulkan's validation layer on.
    #[arg(long, help_heading = "Device")]
    pub validate: bool,
}

/// On or off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    /// Yes.
    On,
    /// No.
    Off,
}

/// A reconstruction filter by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Filter {
    /// Every sample weighs the same within its own pixel.
    Box,
    /// A tent of radius 1.
    Tent,
    /// A Gaussian of standard deviation 0.5.
    Gaussian,
}

impl From<OutputArgs> for OutputFiles {
    fn from(args: OutputArgs) -> Self {
        let OutputArgs { output, tone, exposure, write_every, reference, stats, profile, quiet: _ } = args;
        Self { pictures: output, tone, exposure, write_every, reference, statistics: stats, profile }
    }
}

impl LengthArgs {
    /// Adds these arguments to `options`.
    pub fn add_to(self, options: Options) -> Options {
        with(with(options, self.spp, Options::samples), self.time, Options::seconds)
    }
}

impl DeviceArgs {
    /// Adds these arguments to `options`.
    pub fn add_to(self, options: Options) -> Options {
        let device = ContextOptions { device: device_name(self.device), validate: self.validate };
        let options = options.open_device(device).execution(self.execution);
        let options = with(options, self.slice_ms, Options::slice_milliseconds);
        with(options, self.kernel_dir, Options::kernel_folder)
    }
}

/// The wanted device. An empty LODESTAR_DEVICE is as good as none.
pub fn device_name(device: Option<String>) -> Option<String> {
    device.filter(|device| !device.trim().is_empty())
}

/// `options` with a value that an argument may give.
pub fn with<T>(options: Options, value: Option<T>, set: impl FnOnce(Options, T) -> Options) -> Options {
    match value {
        Some(value) => set(options, value),
        None => options,
    }
}

impl ChoiceArgs {
    /// The options that these arguments stand for.
    pub fn options(self) -> Options {
        let size = match (self.width.zip(self.height), self.scale) {
            (Some((width, height)), _) => FilmSize::Pixels(width, height),
            (None, Some(scale)) => FilmSize::Scaled(scale),
            (None, None) => FilmSize::OfScene,
        };
        let options = Options::new().film_size(size).seed(self.seed);
        let options = with(options, self.crop, Options::crop);
        let options = with(options, self.rfilter.map(Filter::with_default_width), Options::filter);
        let options = with(options, self.max_depth, Options::max_depth);
        let options = with(options, self.rr_depth, Options::rr_depth);
        let guiding = Arc::new(self.guiding);
        let checked = Arc::clone(&guiding);
        let change = move |settings: &mut Settings| {
            settings.nee = self.nee.map_or(settings.nee, |nee| nee == Switch::On);
            settings.pattern = self.pattern.unwrap_or(settings.pattern);
            settings.noise = self.noise;
            settings.sample_offset = self.sample_offset;
            settings.samples_per_dispatch = self.samples_per_dispatch.unwrap_or(settings.samples_per_dispatch);
            guiding.apply(settings);
        };
        options.settings(change).check(move |settings| checked.check_uses(settings))
    }
}

impl Filter {
    pub fn with_default_width(self) -> ReconstructionFilter {
        match self {
            Self::Box => ReconstructionFilter::Box,
            Self::Tent => ReconstructionFilter::Tent { radius: 1.0 },
            Self::Gaussian => ReconstructionFilter::Gaussian { stddev: 0.5 },
        }
    }
}

pub fn output_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("exr" | "png") => Ok(path),
        _ => Err("the name must end in .exr or .png".into()),
    }
}

/// A path that ends in .exr.
pub fn exr_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_exr = path.extension().is_some_and(|extension| extension == "exr");
    is_exr.then_some(path).ok_or_else(|| "the name must end in .exr".into())
}

pub fn define(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.is_empty() => Ok((name.to_owned(), value.to_owned())),
        _ => Err("write it as NAME=VALUE".into()),
    }
}

fn crop(text: &str) -> Result<Crop, String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, width, height]) if width > 0 && height > 0 => Ok(Crop { x, y, width, height }),
        _ => Err("write it as X,Y,W,H: four whole numbers, W and H above 0".into()),
    }
}

fn finite(text: &str) -> Result<f32, String> {
    text.parse().ok().filter(|number: &f32| number.is_finite()).ok_or_else(|| "give a finite number".into())
}

pub fn positive(text: &str) -> Result<f32, String> {
    finite(text).ok().filter(|&number| number > 0.0).ok_or_else(|| "give a number above 0".into())
}

pub fn seconds(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "give a number of seconds above 0".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use lodestar::settings::Sampler;

    #[derive(Debug, Parser)]
    struct Alone {
        #[command(flatten)]
        args: RenderArgs,
    }

    fn parse(line: &str) -> Result<RenderArgs, String> {
        let words = ["render", "a.xml"].into_iter().chain(line.split_whitespace());
        Alone::try_parse_from(words).map(|alone| alone.args).map_err(|error| error.to_string())
    }

    #[test]
    fn every_option_of_the_contract_is_taken() {
        let args = parse(
            "-o a.exr -o a.png --spp 32 --time 1.5 --write-every 10 --width 8 --height 4 --crop 1,2,3,4 -D a=b=c -D d= \
             --max-depth 5 --rr-depth 3 --sampler bsdf --learner sarsa --mix density --map equal-area --grid 8 --directions 16 \
             --spp-per-step 8 --rfilter tent --seed 7 --device llvmpipe --reference r.exr --stats s.json --quiet \
              --nee on --guide-set authors --tone paper --exposure -1.5 --validate --decay 0.5 --max-tries 9 --min-uniform 0.1 \
              --sample-offset 64 --pattern independent --checkpoint a.ckpt --checkpoint-every 5",
        )
        .unwrap();
        assert_eq!(args.files.output, [PathBuf::from("a.exr"), PathBuf::from("a.png")]);
        assert_eq!(args.choices.crop, Some(Crop { x: 1, y: 2, width: 3, height: 4 }));
        assert_eq!(args.define, [("a".into(), "b=c".into()), ("d".into(), String::new())]);
        let RenderArgs { files, choices, .. } = args;
        assert_eq!((files.exposure, files.tone), (Some(-1.5), Some(ToneCurve::Paper)));
        assert_eq!((choices.guiding.sampler, choices.nee), (Sampler::Bsdf, Some(Switch::On)));
        assert_eq!((choices.width, choices.height, choices.rfilter), (Some(8), Some(4), Some(Filter::Tent)));
        assert_eq!((choices.sample_offset, args.checkpoint_every), (Some(64), 5.0));
    }

    #[test]
    fn wrong_values_are_refused() {
        for line in [
            "-o a.jpg",
            "--spp 0",
            "--time -1",
            "--time nan",
            "--width 8",
            "--scale 0",
            "--scale 2 --width 4 --height 4",
            "--crop 1,2,3",
            "--crop 1,2,0,4",
            "--crop 1,2,-3,4",
            "-D a",
            "-D =b",
            "--exposure inf",
            "--sampler magic",
            "--map flat",
            "--mix paint",
            "--checkpoint-every 5",
            "--checkpoint a --checkpoint-every 0",
            "--sample-offset -1",
        ] {
            assert!(parse(line).is_err(), "{line}");
        }
    }
}
