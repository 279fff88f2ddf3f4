//! The options of the library that arguments of `lodestar render` and `lodestar resume` stand for.

use std::str::FromStr;
use std::sync::Arc;

use clap::ValueEnum;
use lodestar::denoise::{DenoiseOptions, DeviceKind};
use lodestar::gpu::ContextOptions;
use lodestar::scene::{CameraChoice, EnvironmentChoice, LoadOptions, ReconstructionFilter};
use lodestar::session::{CHECKPOINT_EVERY, FilmSize, Options, OutputFiles};
use lodestar::settings::Settings;
use lodestar::settings::options::{form, seconds};
use lodestar::view::ViewOptions;

use super::given::{Given, Subset};

/// Form of the messages on standard error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LogFormat {
    /// Text for people.
    Text,
    /// One JSON object per line.
    Json,
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

impl Filter {
    pub fn with_default_width(self) -> ReconstructionFilter {
        match self {
            Self::Box => ReconstructionFilter::Box,
            Self::Tent => ReconstructionFilter::Tent { radius: 1.0 },
            Self::Gaussian => ReconstructionFilter::Gaussian { stddev: 0.5 },
        }
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

impl<S: Subset> Given<S> {
    /// How the scene is read.
    pub fn load(&self) -> LoadOptions {
        // A format that does not know such a name says so.
        let chosen = [("time", "scene-time"), ("variant", "variant")].into_iter();
        let chosen = chosen.filter_map(|(name, option)| Some((name.to_owned(), self.text(option)?.to_owned())));
        LoadOptions {
            defines: self.values("D", form::define).into_iter().chain(chosen).collect(),
            camera: self.value("camera", CameraChoice::from_str),
            environment: self.value("environment", EnvironmentChoice::from_str),
        }
    }

    /// Denoiser of the picture.
    pub fn denoiser(&self) -> DenoiseOptions {
        DenoiseOptions { folder: self.path("oidn"), device: self.word("oidn-device").unwrap_or(DeviceKind::Cpu) }
    }

    /// Files of the picture.
    pub fn files(&self) -> OutputFiles {
        OutputFiles {
            pictures: self.values("output", form::output_path),
            tone: self.word("tone"),
            exposure: self.value("exposure", form::exposure),
            half: self.has("half"),
            denoise: self.has("denoise").then(|| self.denoiser()),
            overwrite: self.has("overwrite"),
            write_every: self.value("write-every", seconds),
            reference: self.path("reference"),
            guide: self.path("guide-out"),
            statistics: self.path("stats"),
            profile: self.path("profile"),
        }
    }

    /// Views of the render. The denoiser makes the page's layer `denoised`.
    pub fn viewers(&self) -> ViewOptions {
        ViewOptions {
            page: self.value("view", form::page_address),
            display_server: self.value("display-server", form::server_address),
            denoiser: self.denoiser(),
        }
    }

    /// Name or index of the device, if one is chosen.
    pub fn device(&self) -> Option<String> {
        device_name(self.text("device").map(str::to_owned))
    }

    /// Adds length, device and checkpoint to `options`, which a new render and a resumed one have.
    pub fn add_to(&self, options: Options) -> Options {
        let device = ContextOptions { device: self.device(), validate: self.has("validate") };
        let options = options.open_device(device).deal_by_speed(self.has("deal-by-speed"));
        let options = with(options, self.value("spp", str::parse), Options::samples);
        let options = with(options, self.value("time", seconds), Options::seconds);
        let options = with(options, self.word("execution"), Options::execution);
        let options = with(options, self.word("traversal"), Options::traversal);
        let options = with(options, self.value("slice-ms", form::milliseconds), Options::slice_milliseconds);
        let options = with(options, self.path("kernel-dir"), Options::kernel_folder);
        let options = with(options, self.path("guide"), Options::guide);
        let options = with(options, self.path("checkpoint"), Options::checkpoint);
        options.checkpoint_every(self.value("checkpoint-every", seconds).unwrap_or(CHECKPOINT_EVERY))
    }

    /// Adds all that a new render has to `options`, except the scene and the files of the picture.
    pub fn choose_all(self, options: Options) -> Options {
        let options = self.add_to(options);
        self.choose(options)
    }

    /// Adds what decides the settings to `options`.
    pub fn choose(self, options: Options) -> Options {
        let number = |name| self.value(name, str::parse::<u32>);
        let size = match (number("width"), number("height"), self.value("scale", form::positive)) {
            (Some(width), Some(height), _) => FilmSize::Pixels(width, height),
            (Some(width), None, _) => FilmSize::Width(width),
            (None, Some(height), _) => FilmSize::Height(height),
            (None, None, Some(scale)) => FilmSize::Scaled(scale),
            (None, None, None) => FilmSize::OfScene,
        };
        let options = options.film_size(size);
        let options = with(options, self.value("crop", form::crop), Options::window);
        let filter = self.word("rfilter").map(Filter::with_default_width);
        let options = with(options, filter, Options::filter);
        let options = with(options, self.value("max-depth", form::depth), Options::max_depth);
        let options = with(options, number("rr-depth"), Options::rr_depth);
        let given = Arc::new(self);
        let checked = Arc::clone(&given);
        let change = move |changed: &mut Settings| given.apply(changed);
        options.settings(change).check(move |settings| checked.check_uses(settings))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use lodestar::image::{Exposure, ToneCurve};
    use lodestar::scene::{Crop, Window};
    use lodestar::settings::UNLIMITED_DEPTH;
    use std::path::PathBuf;

    use crate::cli::given::OfRender;
    use crate::cli::render::RenderArgs;

    #[derive(Debug, Parser)]
    struct Alone {
        #[command(flatten)]
        args: RenderArgs,
    }

    fn parse(line: &str) -> Result<Given<OfRender>, String> {
        let words = ["render", "a.xml"].into_iter().chain(line.split_whitespace());
        Alone::try_parse_from(words).map(|alone| alone.args.given).map_err(|error| error.to_string())
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
        let OutputFiles { pictures, tone, exposure, half, overwrite, .. } = args.files();
        assert_eq!(pictures, [PathBuf::from("a.exr"), PathBuf::from("a.PNG")]);
        assert_eq!(
            (exposure, tone, half, overwrite),
            (Some(Exposure::Stops(-1.5)), Some(ToneCurve::Paper), true, true)
        );
        assert_eq!(args.value("crop", form::crop), Some(Window::Pixels(Crop { x: 1, y: 2, width: 3, height: 4 })));
        assert_eq!(args.load().defines, [("a".into(), "b=c".into()), ("d".into(), String::new())]);
        assert_eq!((args.word("log"), args.value("time", seconds)), (Some(LogFormat::Json), Some(61.5)));
        assert_eq!((args.text("sampler"), args.text("nee")), (Some("bsdf"), Some("on")));
        assert_eq!((args.text("width"), args.text("height")), (Some("8"), Some("4")));
        assert_eq!((args.word("rfilter"), args.value("max-depth", form::depth)), (Some(Filter::Tent), Some(5)));
        for text in ["unlimited", "-1"] {
            let args = parse(&format!("--max-depth {text}")).unwrap();
            assert_eq!(args.value("max-depth", form::depth), Some(UNLIMITED_DEPTH));
        }
        assert_eq!((args.text("sample-offset"), args.value("checkpoint-every", seconds)), (Some("64"), Some(5.0)));
        let bare = parse("--view").unwrap();
        assert_eq!(bare.text("view"), Some(lodestar::settings::options::LOCAL));
        assert!(!bare.has("half") && bare.text("output").is_none());
    }

    #[test]
    fn wrong_values_are_refused() {
        for line in [
            "-o a.gif",
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
            "--crop 0.25,0.25,0.5,0.5",
            "--crop 50%,50%,60%,50%",
            "--crop 1,2,50%,50%",
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
