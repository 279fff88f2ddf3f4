//! The arguments of `lodestar render`, and the library's options that they stand for.

use std::path::PathBuf;
use std::sync::Arc;

use clap::ValueEnum;
use lodestar::denoise::{DenoiseOptions, DeviceKind};
use lodestar::files;
use lodestar::gpu::ContextOptions;
use lodestar::image::ToneCurve;
use lodestar::scene::{CameraChoice, Crop, EnvironmentChoice, LoadOptions, ReconstructionFilter};
use lodestar::session::{CHECKPOINT_EVERY, FilmSize, Options, OutputFiles};
use lodestar::settings::{Execution, Settings, Traversal, UNLIMITED_DEPTH};

use super::duration::seconds;
use super::setting_args::SettingArgs;
use super::viewer_args::ViewerArgs;

/// Renders a scene.
///
/// The render ends at the first of --spp, --time and --noise that is reached. Ctrl-C ends it too. Each way, the picture so far is
/// written.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct RenderArgs {
    /// The scene: Mitsuba's XML of any version, glTF 2.0 (.gltf, .glb), or pbrt-v4 (.pbrt)
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    #[command(flatten)]
    pub load: LoadArgs,
    #[command(flatten)]
    pub files: OutputArgs,
    #[command(flatten)]
    pub viewers: ViewerArgs,
    #[arg(long)]
    pub checkpoint: Option<PathBuf>,
    #[arg(long, requires = "checkpoint", default_value_t = CHECKPOINT_EVERY, value_parser = seconds)]
    pub checkpoint_every: f64,
    #[arg(long)]
    pub guide_from: Option<PathBuf>,
    #[command(flatten)]
    pub length: LengthArgs,
    #[command(flatten)]
    pub choices: ChoiceArgs,
    #[command(flatten)]
    pub device: DeviceArgs,
}

/// Choices about how a scene is read.
#[derive(Debug, Clone, clap::Args)]
pub struct LoadArgs {
    #[arg(short = 'D', value_parser = define)]
    pub define: Vec<(String, String)>,
    #[arg(long)]
    pub camera: Option<CameraChoice>,
    #[arg(long)]
    pub environment: Option<EnvironmentChoice>,
}

impl LoadArgs {
    /// The library's options that the arguments stand for.
    pub fn options(self) -> LoadOptions {
        let Self { define, camera, environment } = self;
        LoadOptions { defines: define, camera, environment }
    }
}

/// Files of the picture, and messages.
#[derive(Debug, Clone, clap::Args)]
pub struct OutputArgs {
    #[arg(short, long, value_parser = output_path)]
    pub output: Vec<PathBuf>,
    #[arg(long, value_enum)]
    pub tone: Option<ToneCurve>,
    #[arg(long, value_parser = finite)]
    pub exposure: Option<f32>,
    #[arg(long)]
    pub half: bool,
    #[arg(long)]
    pub denoise: bool,
    #[arg(long, requires = "denoise")]
    pub oidn: Option<PathBuf>,
    #[arg(long, requires = "denoise", value_enum, default_value_t = DeviceKind::Cpu)]
    pub oidn_device: DeviceKind,
    #[arg(long)]
    pub overwrite: bool,
    #[arg(long, value_parser = seconds)]
    pub write_every: Option<f64>,
    #[arg(long)]
    pub reference: Option<PathBuf>,
    #[arg(long)]
    pub stats: Option<PathBuf>,
    #[arg(long)]
    pub profile: Option<PathBuf>,
    #[arg(long, value_enum, default_value_t = LogFormat::Text)]
    pub log: LogFormat,
    #[arg(short, long)]
    pub quiet: bool,
}

/// Form of the messages on standard error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LogFormat {
    /// Text for people.
    Text,
    /// One JSON object per line.
    Json,
}

/// Length of the render.
#[derive(Debug, Clone, clap::Args)]
pub struct LengthArgs {
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: Option<u32>,
    #[arg(long, value_parser = seconds)]
    pub time: Option<f64>,
}

/// Options that decide the settings.
#[derive(Debug, clap::Args)]
pub struct ChoiceArgs {
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    pub width: Option<u32>,
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    pub height: Option<u32>,
    #[arg(long, conflicts_with_all = ["width", "height"], value_parser = positive)]
    pub scale: Option<f32>,
    #[arg(long, allow_hyphen_values = true, value_parser = crop)]
    pub crop: Option<Crop>,
    #[arg(long, value_enum)]
    pub rfilter: Option<Filter>,
    #[arg(long, value_parser = depth)]
    pub max_depth: Option<u32>,
    #[arg(long)]
    pub rr_depth: Option<u32>,
    #[command(flatten)]
    pub settings: SettingArgs<false>,
}

/// Device and kernels.
#[derive(Debug, Clone, clap::Args)]
pub struct DeviceArgs {
    #[arg(long, env = "LODESTAR_DEVICE")]
    pub device: Option<String>,
    #[arg(long)]
    pub deal_by_speed: bool,
    #[arg(long, value_parser = milliseconds)]
    pub slice_ms: Option<f64>,
    #[arg(long, value_enum, default_value_t = Execution::Auto)]
    pub execution: Execution,
    #[arg(long, value_enum)]
    pub traversal: Option<Traversal>,
    #[arg(long)]
    pub kernel_dir: Option<PathBuf>,
    #[arg(long)]
    pub validate: bool,
}

/// A switch that is on or off.
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
    /// A box: equal weights within a pixel.
    Box,
    /// A tent of radius 1.
    Tent,
    /// A Gaussian of standard deviation 0.5.
    Gaussian,
}

impl OutputArgs {
    /// The denoiser that the arguments name.
    pub fn denoiser(&self) -> DenoiseOptions {
        DenoiseOptions { folder: self.oidn.clone(), device: self.oidn_device }
    }
}

impl From<OutputArgs> for OutputFiles {
    fn from(args: OutputArgs) -> Self {
        let denoise = args.denoise.then(|| args.denoiser());
        let OutputArgs { output, tone, exposure, half, overwrite, write_every, reference, stats, profile, .. } = args;
        let (pictures, statistics) = (output, stats);
        Self { pictures, tone, exposure, half, denoise, overwrite, write_every, reference, statistics, profile }
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
        let options = options.open_device(device).deal_by_speed(self.deal_by_speed).execution(self.execution);
        let options = with(options, self.traversal, Options::traversal);
        let options = with(options, self.slice_ms, Options::slice_milliseconds);
        with(options, self.kernel_dir, Options::kernel_folder)
    }
}

/// Name or index of the device, if one is chosen. An empty LODESTAR_DEVICE chooses none.
pub fn device_name(device: Option<String>) -> Option<String> {
    device.filter(|device| !device.trim().is_empty())
}

/// `options` with a value, if an argument gives one.
pub fn with<T>(options: Options, value: Option<T>, set: impl FnOnce(Options, T) -> Options) -> Options {
    match value {
        Some(value) => set(options, value),
        None => options,
    }
}

impl ChoiceArgs {
    /// The options that these arguments stand for.
    pub fn options(self) -> Options {
        let size = match (self.width, self.height, self.scale) {
            (Some(width), Some(height), _) => FilmSize::Pixels(width, height),
            (Some(width), None, _) => FilmSize::Width(width),
            (None, Some(height), _) => FilmSize::Height(height),
            (None, None, Some(scale)) => FilmSize::Scaled(scale),
            (None, None, None) => FilmSize::OfScene,
        };
        let options = Options::new().film_size(size);
        let options = with(options, self.crop, Options::crop);
        let options = with(options, self.rfilter.map(Filter::with_default_width), Options::filter);
        let options = with(options, self.max_depth, Options::max_depth);
        let options = with(options, self.rr_depth, Options::rr_depth);
        let settings = Arc::new(self.settings);
        let checked = Arc::clone(&settings);
        let change = move |changed: &mut Settings| settings.apply(changed);
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
    match () {
        () if text == "-" => Err("no picture goes to standard output; name a file that ends in .exr or .png".into()),
        () if files::is_picture(&path) => Ok(path),
        () => Err("the name must end in .exr or .png".into()),
    }
}

/// A path that ends in .exr.
pub fn exr_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    files::has_extension(&path, "exr").then_some(path).ok_or_else(|| "the name must end in .exr".into())
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

/// Longest path in edges. Mitsuba writes `unlimited` as -1.
pub fn depth(text: &str) -> Result<u32, String> {
    match text {
        "unlimited" | "-1" => Ok(UNLIMITED_DEPTH),
        _ => text.parse().ok().filter(|&depth| depth > 0).ok_or_else(|| "give a number of edges or unlimited".into()),
    }
}

pub fn finite(text: &str) -> Result<f32, String> {
    text.parse().ok().filter(|number: &f32| number.is_finite()).ok_or_else(|| "give a finite number".into())
}

pub fn positive(text: &str) -> Result<f32, String> {
    finite(text).ok().filter(|&number| number > 0.0).ok_or_else(|| "give a number above 0".into())
}

fn milliseconds(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "give a number of milliseconds above 0".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

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
            "-o a.exr -o a.PNG --spp 32 --time 1m1.5s --half --overwrite --log json --write-every 10 --width 8 --height 4 --crop 1,2,3,4 -D a=b=c -D d= \
             --max-depth 5 --rr-depth 3 --sampler bsdf --learner sarsa --mix density --map equal-area --grid 8 --directions 16 \
             --spp-per-step 8 --rfilter tent --seed 7 --device llvmpipe --reference r.exr --stats s.json --quiet \
              --nee on --guide-set authors --tone paper --exposure -1.5 --validate --decay 0.5 --max-tries 9 --min-uniform 0.1 \
              --sample-offset 64 --pattern independent --checkpoint a.ckpt --checkpoint-every 5",
        )
        .unwrap();
        assert_eq!(args.files.output, [PathBuf::from("a.exr"), PathBuf::from("a.PNG")]);
        assert_eq!(args.choices.crop, Some(Crop { x: 1, y: 2, width: 3, height: 4 }));
        assert_eq!(args.load.define, [("a".into(), "b=c".into()), ("d".into(), String::new())]);
        let RenderArgs { files, choices, length, .. } = args;
        assert_eq!((files.half, files.overwrite, files.log, length.time), (true, true, LogFormat::Json, Some(61.5)));
        assert_eq!((files.exposure, files.tone), (Some(-1.5), Some(ToneCurve::Paper)));
        assert_eq!((choices.settings.text("sampler"), choices.settings.text("nee")), (Some("bsdf"), Some("on")));
        assert_eq!((choices.width, choices.height, choices.rfilter), (Some(8), Some(4), Some(Filter::Tent)));
        assert_eq!(choices.max_depth, Some(5));
        for text in ["unlimited", "-1"] {
            assert_eq!(parse(&format!("--max-depth {text}")).unwrap().choices.max_depth, Some(UNLIMITED_DEPTH));
        }
        assert_eq!((choices.settings.text("sample-offset"), args.checkpoint_every), (Some("64"), 5.0));
    }

    #[test]
    fn wrong_values_are_refused() {
        for line in [
            "-o a.jpg",
            "-o -",
            "--time 1m30",
            "--log xml",
            "--spp 0",
            "--time -1",
            "--time nan",
            "--scale 0",
            "--scale 2 --width 4 --height 4",
            "--crop 1,2,3",
            "--max-depth 0",
            "--max-depth -2",
            "--max-depth endless",
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
