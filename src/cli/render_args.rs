//! The arguments of `lodestar render`, and the settings they make of a scene.

use std::path::PathBuf;

use clap::ValueEnum;
use lodestar::Result;
use lodestar::image::ToneCurve;
use lodestar::scene::{Crop, ReconstructionFilter, Scene};
use lodestar::settings::{GuideSet, Learner, Sampler, Settings};

/// Renders a Mitsuba scene.
///
/// Whichever of --spp and --time is reached first ends the render, and so does Ctrl-C: the picture so far is written. What
/// the scene file leaves open and no option gives: 64 samples per pixel, depth 16, roulette after depth 8.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct RenderArgs {
    /// The scene, in Mitsuba's XML of any version.
    #[arg(value_name = "SCENE.xml")]
    pub scene: PathBuf,

    /// Where to write: .exr (every layer) or .png (as --tone and --exposure say); may be given several times
    /// [default: the scene's name with .exr].
    #[arg(short, long, value_name = "FILE", value_parser = output_path, help_heading = "Output")]
    pub output: Vec<PathBuf>,
    /// Tone curve of PNG files.
    #[arg(long, value_enum, default_value_t, help_heading = "Output")]
    pub tone: ToneCurve,
    /// Exposure of PNG files: brighter by 2^STOPS.
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, value_parser = finite, help_heading = "Output")]
    pub exposure: f32,
    /// Write the picture so far every so many seconds.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, help_heading = "Output")]
    pub write_every: Option<f64>,
    /// Measure the error against this picture as the render goes; it lands in --stats.
    #[arg(long, value_name = "REF.exr", help_heading = "Output")]
    pub reference: Option<PathBuf>,
    /// Write settings, timings and statistics of every step as JSON.
    #[arg(long, value_name = "STATS.json", help_heading = "Output")]
    pub stats: Option<PathBuf>,
    /// Show no progress.
    #[arg(short, long, help_heading = "Output")]
    pub quiet: bool,

    /// Samples per pixel.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Length")]
    pub spp: Option<u32>,
    /// Stop after so many seconds of rendering; loading does not count.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, help_heading = "Length")]
    pub time: Option<f64>,

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
    /// Replace the scene's <default> of that name; may be given several times.
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = define, help_heading = "Scene")]
    pub define: Vec<(String, String)>,
    /// Reconstruction filter [default: the scene's].
    #[arg(long, value_enum, value_name = "FILTER", help_heading = "Scene")]
    pub rfilter: Option<Filter>,

    /// Longest path in edges; 1 is emission seen directly.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Paths")]
    pub max_depth: Option<u32>,
    /// Depth after which Russian roulette is played.
    #[arg(long, value_name = "N", help_heading = "Paths")]
    pub rr_depth: Option<u32>,
    /// Sample emitters at every vertex of a path (next event estimation).
    #[arg(long, value_enum, default_value_t = Switch::Off, help_heading = "Paths")]
    pub nee: Switch,
    /// Seed of the random numbers; the same one gives the same pixels.
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Paths")]
    pub seed: u32,

    /// How directions are sampled.
    #[arg(long, value_enum, default_value_t = Sampler::RejectionMix, help_heading = "Guiding")]
    pub sampler: Sampler,
    /// Which surfaces are guided: diffuse lobes, or also rough conductors and dielectrics as in the authors' code.
    #[arg(long, value_enum, default_value_t = GuideSet::Diffuse, help_heading = "Guiding")]
    pub guide_set: GuideSet,
    /// How the guide learns.
    #[arg(long, value_enum, default_value_t = Learner::Sarsa, help_heading = "Guiding")]
    pub learner: Learner,
    /// What rejection-mix mixes with the uniform distribution.
    #[arg(long, value_enum, default_value_t = Mix::Density, help_heading = "Guiding")]
    pub mix: Mix,
    /// Cells of the guide along each axis [default: 8].
    #[arg(long, value_name = "N", help_heading = "Guiding")]
    pub grid: Option<u32>,
    /// Direction bins of a cell along each axis [default: 16].
    #[arg(long, value_name = "N", help_heading = "Guiding")]
    pub directions: Option<u32>,
    /// Samples per pixel between two updates of the guide [default: 8].
    #[arg(long, value_name = "N", help_heading = "Guiding")]
    pub spp_per_step: Option<u32>,
    /// Normal bins of a cell along each side [default: 16].
    #[arg(long, value_name = "N", help_heading = "Guiding")]
    pub normals: Option<u32>,
    /// What one step leaves of a bin's earlier count; 1 is the paper's running mean [default: 0.95].
    #[arg(long, value_name = "D", help_heading = "Guiding")]
    pub decay: Option<f32>,
    /// Tries of rejection sampling before it takes a uniform direction [default: 15].
    #[arg(long, value_name = "K", help_heading = "Guiding")]
    pub max_tries: Option<u32>,
    /// Least share of uniform directions in the guide [default: 0.0625].
    #[arg(long, value_name = "E", help_heading = "Guiding")]
    pub min_uniform: Option<f32>,

    /// Vulkan device, by index or by a part of its name, as `lodestar devices` lists them.
    #[arg(long, value_name = "INDEX|NAME", env = "LODESTAR_DEVICE", help_heading = "Device")]
    pub device: Option<String>,
    /// Most samples per pixel of one dispatch: a driver may bound the loop iterations of one [default: 8].
    #[arg(long, value_name = "N", help_heading = "Device")]
    pub samples_per_dispatch: Option<u32>,
    /// How long a dispatch should take, in milliseconds [default: 50 on a GPU, 150 on a CPU].
    #[arg(long, value_name = "MS", value_parser = seconds, help_heading = "Device")]
    pub slice_ms: Option<f64>,
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

/// What `rejection-mix` mixes with the uniform distribution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Mix {
    /// The density, Eq. 8 of the paper.
    Density,
}

impl RenderArgs {
    /// The wanted device. An empty LODESTAR_DEVICE is as good as none.
    pub fn device(&self) -> Option<String> {
        self.device.clone().filter(|device| !device.trim().is_empty())
    }

    /// The settings: the scene's own where no option is given.
    ///
    /// # Errors
    /// Where an option is out of its range.
    pub fn settings(&self, scene: &Scene) -> Result<Settings> {
        let mut settings = Settings::for_scene(scene);
        if let (Some(width), Some(height)) = (self.width, self.height) {
            settings.crop = rescaled_crop(settings.crop, [settings.width, settings.height], [width, height]);
            (settings.width, settings.height) = (width, height);
        }
        if let Some(scale) = self.scale {
            let scaled = |size: u32| ((size as f32 * scale).round() as u32).max(1);
            let size = [scaled(settings.width), scaled(settings.height)];
            settings.crop = rescaled_crop(settings.crop, [settings.width, settings.height], size);
            [settings.width, settings.height] = size;
        }
        settings.crop = self.crop.or(settings.crop);
        settings.filter = self.rfilter.map_or(settings.filter, Filter::with_default_width);
        settings.max_depth = self.max_depth.unwrap_or(settings.max_depth);
        settings.rr_depth = self.rr_depth.unwrap_or(settings.rr_depth);
        settings.nee = self.nee == Switch::On;
        settings.seed = self.seed;
        settings.sampler = self.sampler;
        settings.guide_set = self.guide_set;
        settings.learner = self.learner;
        settings.grid = self.grid.unwrap_or(settings.grid);
        settings.directions = self.directions.unwrap_or(settings.directions);
        settings.normals = self.normals.unwrap_or(settings.normals);
        settings.spp_per_step = self.spp_per_step.unwrap_or(settings.spp_per_step);
        settings.samples_per_dispatch = self.samples_per_dispatch.unwrap_or(settings.samples_per_dispatch);
        settings.decay = self.decay.unwrap_or(settings.decay);
        settings.max_tries = self.max_tries.unwrap_or(settings.max_tries);
        settings.min_uniform = self.min_uniform.unwrap_or(settings.min_uniform);
        settings.slice_milliseconds = self.slice_ms.or(settings.slice_milliseconds);
        settings.validate()?;
        settings.check_lighting(scene)?;
        Ok(settings)
    }
}

impl Filter {
    fn with_default_width(self) -> ReconstructionFilter {
        match self {
            Self::Box => ReconstructionFilter::Box,
            Self::Tent => ReconstructionFilter::Tent { radius: 1.0 },
            Self::Gaussian => ReconstructionFilter::Gaussian { stddev: 0.5 },
        }
    }
}

/// The scene's crop window keeps its place when the film's size changes.
fn rescaled_crop(crop: Option<Crop>, [width, height]: [u32; 2], [new_width, new_height]: [u32; 2]) -> Option<Crop> {
    let scale = |value: u32, old: u32, new: u32| (u64::from(value) * u64::from(new) / u64::from(old.max(1))) as u32;
    crop.map(|c| Crop {
        x: scale(c.x, width, new_width),
        y: scale(c.y, height, new_height),
        width: scale(c.width, width, new_width).max(1),
        height: scale(c.height, height, new_height).max(1),
    })
}

fn output_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("exr" | "png") => Ok(path),
        _ => Err("the name must end in .exr or .png".into()),
    }
}

fn define(text: &str) -> Result<(String, String), String> {
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

fn positive(text: &str) -> Result<f32, String> {
    finite(text).ok().filter(|&number| number > 0.0).ok_or_else(|| "give a number above 0".into())
}

fn seconds(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "give a number of seconds above 0".into())
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
            "-o a.exr -o a.png --spp 32 --time 1.5 --write-every 10 --width 8 --height 4 --crop 1,2,3,4 -D a=b=c -D d= \
             --max-depth 5 --rr-depth 3 --sampler bsdf --learner sarsa --mix density --grid 8 --directions 16 \
             --spp-per-step 8 --rfilter tent --seed 7 --device llvmpipe --reference r.exr --stats s.json --quiet \
             --nee on --guide-set authors --tone paper --exposure -1.5 --validate --decay 0.5 --max-tries 9 --min-uniform 0.1",
        )
        .unwrap();
        assert_eq!(args.output, [PathBuf::from("a.exr"), PathBuf::from("a.png")]);
        assert_eq!(args.crop, Some(Crop { x: 1, y: 2, width: 3, height: 4 }));
        assert_eq!(args.define, [("a".into(), "b=c".into()), ("d".into(), String::new())]);
        assert_eq!((args.exposure, args.tone, args.sampler), (-1.5, ToneCurve::Paper, Sampler::Bsdf));
        assert_eq!((args.width, args.height, args.rfilter), (Some(8), Some(4), Some(Filter::Tent)));
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
        ] {
            assert!(parse(line).is_err(), "{line}");
        }
    }
}
