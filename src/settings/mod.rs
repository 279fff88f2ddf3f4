//! Everything a user may choose about a render, validated in one place.

mod checks;
pub(crate) mod schedule;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::generated::constants::{self, Variant};
use crate::generated::layout::PathVertex;
use crate::scene::{Crop, FilmDescription, IntegratorDescription, ReconstructionFilter, Scene};
use crate::{Error, Result};

pub use crate::math::direction_map::DirectionMap;

/// Longest path that can be asked for, in edges; what Mitsuba's "unlimited" becomes.
pub const MAX_DEPTH_LIMIT: u32 = 1024;
/// Directions over which `expected-sarsa` takes its mean by default.
pub(crate) const EXPECTED_DIRECTIONS: u32 = DEFAULTS.expected_directions;
/// What `--grid auto` sets.
pub const AUTO_GRID: u32 = u32::MAX;
/// Longest path of which a learner keeps all vertices.
const MAX_KEPT_VERTICES: u32 = 128;
/// Most pixels a film may have along a side.
pub const MAX_FILM_SIDE: u32 = 1 << constants::PIXEL_DIGITS;
/// Defaults that the kernels have.
const DEFAULTS: Variant = Variant::DEFAULT;

/// Where scattered directions come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
#[repr(u32)]
pub enum Sampler {
    /// The scattering function times the cosine: an ordinary path tracer.
    Bsdf = constants::SAMPLER_BSDF,
    /// The paper's "Rej+": rejection sampling of learned radiance times cosine, with the optimal uniform share (Eq. 8).
    RejectionMix = constants::SAMPLER_REJECTION_MIX,
    /// The same with the least uniform share only.
    Rejection = constants::SAMPLER_REJECTION,
    /// Inversion of learned radiance over the whole sphere, without regard to the normal.
    SphereInversion = constants::SAMPLER_SPHERE_INVERSION,
    /// Inversion of learned radiance times the cosine's integral over each bin, summed for every sample.
    HemisphereInversion = constants::SAMPLER_HEMISPHERE_INVERSION,
    /// Learned radiance times cosine by a descent of fixed length, mixed with a share of the cosine.
    Product = constants::SAMPLER_PRODUCT,
    /// What the paper compares with: learned flux, whatever the normal, by quadtrees in the leaves of a binary tree (Müller,
    /// Gross and Novák 2017), half and half with the scattering function.
    Quadtree = constants::SAMPLER_QUADTREE,
}

impl Sampler {
    /// The learner that it has unless another is asked for.
    pub const fn default_learner(self) -> Learner {
        match self {
            Self::Quadtree => Learner::MonteCarlo,
            _ => Learner::Sarsa,
        }
    }
}

/// What `rejection-mix` mixes with the uniform share.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
#[repr(u32)]
pub enum Mix {
    /// Densities (Eq. 8).
    Density = constants::MIX_DENSITY,
    /// Probabilities of acceptance (Eq. 9).
    Acceptance = constants::MIX_ACCEPTANCE,
}

/// Which scattering functions a guide is used on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
#[repr(u32)]
pub enum GuideSet {
    /// `diffuse`, `roughdiffuse` and the diffuse lobe of `plastic` and `roughplastic`.
    Diffuse = constants::GUIDE_SET_DIFFUSE,
    /// These, and as in the code of the paper's authors `roughconductor` and `roughdielectric`.
    Authors = constants::GUIDE_SET_AUTHORS,
    /// Also `principled`, and those two by a share that grows with their roughness.
    All = constants::GUIDE_SET_ALL,
}

/// What a surface's own scattering function keeps of the samples where a guide has the rest, with `product`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum BsdfShare {
    /// As much everywhere: [`Settings::epsilon`].
    Fixed,
    /// What each cell learns, apart for diffuse lobes and for scattering functions that are guided as a whole: the share with
    /// which the mixture comes nearest to f cos L, in Kullback-Leibler divergence.
    Learned,
}

/// How the radiance grid learns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
#[repr(u32)]
pub enum Learner {
    /// Eq. 6: bootstraps from the one direction that was sampled next.
    Sarsa = constants::LEARNER_SARSA,
    /// Eq. 5: bootstraps from the mean over many directions.
    ExpectedSarsa = constants::LEARNER_EXPECTED_SARSA,
    /// Learns the radiance that the rest of the path has collected.
    MonteCarlo = constants::LEARNER_MONTE_CARLO,
    /// Eq. 5 at a constant cost: bootstraps from the irradiance that the product sampler's normalization grid holds.
    IrradianceSarsa = constants::LEARNER_IRRADIANCE_SARSA,
}

/// How the samples of a pixel are distributed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
#[repr(u32)]
pub enum SamplePattern {
    /// Each for itself.
    Independent = constants::PATTERN_INDEPENDENT,
    /// In sets of eight: Sobol's points in two dimensions, scrambled after Owen, for every decision of a path. A set never
    /// reaches over an update of the guide, so that every decision is independent of what it is guided by. Camera rays, on
    /// which no guide has a say, go on along the sequence over all samples of a pixel.
    Sobol = constants::PATTERN_SOBOL,
    /// In sets of eight as well, those of all pixels of a tile being one large set: what a pixel errs its neighbors make up
    /// for, so that the noise of a picture is blue.
    BlueNoise = constants::PATTERN_BLUE_NOISE,
}

/// What Russian roulette goes by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
#[repr(u32)]
pub enum Roulette {
    /// Throughput, from edge [`Settings::rr_depth`] on.
    Throughput = constants::ROULETTE_THROUGHPUT,
    /// With `product`, what the guide expects the path still to bring, from the first edge on, over what it expects of the pixel
    /// (Vorba and Křivánek 2016). Where there is no guide, throughput.
    Contribution = constants::ROULETTE_CONTRIBUTION,
}

/// How many samples per pixel are taken between two updates of the grids.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum StepSchedule {
    /// Few at first, so that a guide soon knows something: a quarter of those before, at least one, up to the most.
    Growing,
    /// Always the most.
    Even,
}

/// How paths are traced. The pictures are the same, to the bit wherever that was tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Execution {
    /// On a GPU `wavefront` for emitter sampling among 10,000 primitives and more, if its memory allows; else `megakernel`.
    Auto,
    /// One kernel follows each path to its end.
    Megakernel,
    /// All paths travel an edge, then the next, by kernels for rays, for lights and for what is met. Takes memory for the
    /// paths: at most 800 MiB or an eighth of the device's.
    Wavefront,
}

/// What the samples of a pixel count for in its mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum SampleWeights {
    /// All the same.
    Even,
    /// Those that an early guide has drawn less than later ones, by a schedule that is fixed before the render begins
    /// ([`crate::film::weights`]).
    Growing,
}

/// How a film is rendered. [`Settings::for_scene`] gives the defaults.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Whole film's width in pixels, in [1, 65536].
    pub width: u32,
    /// Whole film's height in pixels, in [1, 65536].
    pub height: u32,
    /// The window of the film that is rendered; all of it where `None`.
    pub crop: Option<Crop>,
    /// The reconstruction filter.
    pub filter: ReconstructionFilter,
    /// Longest path in edges, in [1, 1024]; 1 is emission seen directly.
    pub max_depth: u32,
    /// Number of edges from which Russian roulette by throughput is played, at least 1.
    pub rr_depth: u32,
    /// Whether directly seen emitters are black.
    pub hide_emitters: bool,
    /// Whether emitters are sampled at every vertex.
    #[serde(serialize_with = "on_or_off", deserialize_with = "from_on_or_off")]
    pub nee: bool,
    /// Seed of every random number.
    pub seed: u32,
    /// How the samples of a pixel are distributed.
    pub pattern: SamplePattern,
    /// Relative error, by estimate, at which a tile of 8 x 8 pixels is no longer sampled, in [1e-4, 1]; the picture is then
    /// consistent, not unbiased ([`crate::film::noise`]). Where `None`, all pixels have as many samples.
    pub noise: Option<f32>,
    /// Index of every pixel's first sample, where the render is one part of several: such renders of the same seed are
    /// independent if their samples do not overlap, and keep sums whose order changes no bit ([`crate::film::sums`]).
    pub sample_offset: Option<u32>,
    /// Where scattered directions come from.
    pub sampler: Sampler,
    /// Which scattering functions a guide is used on.
    pub guide_set: GuideSet,
    /// How the radiance grid learns.
    pub learner: Learner,
    /// Map between directions and their bins.
    pub map: DirectionMap,
    /// What `rejection-mix` mixes with the uniform share.
    pub mix: Mix,
    /// The share e of what is mixed with the guide, in [1e-4, 1]: uniform directions with `rejection-mix`, where `None` takes
    /// the optimal share (Eq. 8), and the scattering function with `product`, where it takes 0.25 if cells do not learn it.
    pub epsilon: Option<f32>,
    /// What a scattering function keeps of the samples where `product` has the rest: where `None`, what cells learn if they can.
    pub bsdf_share: Option<BsdfShare>,
    /// What Russian roulette goes by. `None`: see [`Settings::roulette`].
    pub roulette: Option<Roulette>,
    /// Directions over which `expected-sarsa` takes its mean, in [1, 4096].
    pub expected_directions: u32,
    /// Cells along each axis of the grids, in [1, 32]; [`AUTO_GRID`] takes the finest cubes whose guide fits 8 MiB. Quadtrees
    /// have no more nodes than grids of this size have bins.
    #[serde(serialize_with = "number_or_auto", deserialize_with = "from_number_or_auto")]
    pub grid: u32,
    /// Targets that what a cell's parents have learned counts for in each of its bins, in [0, 1e6]; with 0 it stands for itself.
    pub fallback: f32,
    /// Direction bins along each side of the map, in [4, 64].
    pub directions: u32,
    /// Normal bins along each side of the equal-area square, in [4, 32].
    pub normals: u32,
    /// Most samples per pixel between two updates of the grids, at least 1.
    pub spp_per_step: u32,
    /// Whether there are fewer at first. See [`Settings::samples_of_step`].
    pub steps: StepSchedule,
    /// What samples count for in the picture. `None`: see [`Settings::sample_weights`].
    pub sample_weights: Option<SampleWeights>,
    /// Most samples per pixel that one dispatch takes, in [1, 64]: a driver may bound the loop iterations of a dispatch.
    pub samples_per_dispatch: u32,
    /// Proposals before a guided sample falls back on the uniform share, in [1, 1024]. They are drawn in pairs, so an odd
    /// number, which the fallback completes, wastes none.
    pub max_tries: u32,
    /// Least share of uniformly drawn directions, in (0, 1].
    pub min_uniform: f32,
    /// What one step leaves of a bin's earlier count, in [0, 1]; 1 is the paper's running mean over all steps.
    pub decay: f32,
    /// How long one dispatch should take, in milliseconds; `None` chooses by the kind of device.
    pub slice_milliseconds: Option<f64>,
    /// How paths are traced.
    pub execution: Execution,
    /// Most workgroups of a dispatch over a queue of a wave; `None` takes as many as suit a large GPU.
    #[serde(skip)]
    #[doc(hidden)]
    pub queue_groups: Option<u32>,
    /// Most pixels of one film page; `None` takes what the device can bind.
    #[serde(skip)]
    #[doc(hidden)]
    pub film_page_pixels: Option<u32>,
    /// Reads geometry and tables from storage buffers although texel buffers would do.
    #[serde(skip)]
    #[doc(hidden)]
    pub storage_reads: bool,
}

impl Settings {
    /// The scene's own choices where it makes any; else max depth 16, roulette after depth 8, and the paper's grids.
    pub fn for_scene(scene: &Scene) -> Self {
        Self::for_film(&scene.film, &scene.integrator)
    }

    /// The same from those two parts of a scene that settings depend on.
    pub fn for_film(film: &FilmDescription, integrator: &IntegratorDescription) -> Self {
        Self {
            width: film.width,
            height: film.height,
            crop: film.crop,
            filter: film.filter,
            max_depth: integrator.max_depth.map_or(DEFAULTS.max_depth, depth_from_scene),
            rr_depth: integrator.rr_depth.map_or(DEFAULTS.rr_depth, depth_from_scene),
            hide_emitters: integrator.hide_emitters,
            nee: true,
            seed: 0,
            pattern: SamplePattern::Sobol,
            noise: None,
            sample_offset: None,
            sampler: Sampler::Product,
            guide_set: GuideSet::All,
            learner: Learner::Sarsa,
            map: DirectionMap::EqualArea,
            mix: Mix::Density,
            epsilon: None,
            bsdf_share: None,
            roulette: None,
            expected_directions: EXPECTED_DIRECTIONS,
            grid: 8,
            fallback: 0.0,
            directions: DEFAULTS.direction_resolution,
            normals: DEFAULTS.normal_resolution,
            spp_per_step: 8,
            steps: StepSchedule::Growing,
            sample_weights: None,
            samples_per_dispatch: 8,
            max_tries: DEFAULTS.max_tries,
            min_uniform: DEFAULTS.min_uniform_share,
            decay: 0.95,
            slice_milliseconds: None,
            execution: Execution::Auto,
            queue_groups: None,
            film_page_pixels: None,
            storage_reads: false,
        }
    }

    /// Every setting that a user may choose, by name, as text: `0.95` where a number is meant, not its nearest `f32`.
    pub fn named(&self) -> Vec<(String, String)> {
        let value = serde_json::to_string(self).and_then(|text| serde_json::from_str(&text));
        let value: serde_json::Value = value.unwrap_or_default();
        let plain = |value: &serde_json::Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        value.as_object().into_iter().flatten().map(|(name, value)| (name.clone(), plain(value))).collect()
    }

    /// The rendered window.
    pub fn window(&self) -> Crop {
        self.crop.unwrap_or(Crop { x: 0, y: 0, width: self.width, height: self.height })
    }

    /// What Russian roulette goes by: where that is not chosen, the expected contribution with `product`, whose guide knows it,
    /// unless no path is long enough to meet roulette by throughput: then none is wanted.
    pub fn roulette(&self) -> Roulette {
        let knows = self.sampler == Sampler::Product && self.rr_depth < self.max_depth;
        self.roulette.unwrap_or(if knows { Roulette::Contribution } else { Roulette::Throughput })
    }

    /// Whether cells learn the share of the scattering function: they may, and none is fixed. `monte-carlo` would have to keep
    /// what each vertex says of its share.
    pub fn learns_share(&self) -> bool {
        let can = self.sampler == Sampler::Product && self.learner != Learner::MonteCarlo && self.epsilon.is_none();
        can && self.bsdf_share != Some(BsdfShare::Fixed)
    }

    /// What samples count for: where that is not chosen, those of an early guide less with `product`, of which it is known that it
    /// pays, but all the same where parts of a picture are rendered or noise ends it.
    pub fn sample_weights(&self) -> SampleWeights {
        let grow = self.sampler == Sampler::Product && self.noise.is_none() && self.sample_offset.is_none();
        self.sample_weights.unwrap_or(if grow { SampleWeights::Growing } else { SampleWeights::Even })
    }

    /// Vertices that a kernel keeps of a path.
    pub(crate) fn kept_vertices(&self) -> u32 {
        if self.learner == Learner::MonteCarlo { self.max_depth } else { 1 }
    }

    /// Bytes of the vertices that the learner keeps of each path under way: none where it keeps none.
    pub fn path_bytes(&self) -> u64 {
        let keeps_vertices = self.sampler != Sampler::Bsdf && self.learner == Learner::MonteCarlo;
        if keeps_vertices { u64::from(self.kept_vertices()) * size_of::<PathVertex>() as u64 } else { 0 }
    }

    /// Normal bins along each side of the equal-area square that the sampler tells apart.
    pub(crate) fn normal_resolution(&self) -> u32 {
        if matches!(self.sampler, Sampler::SphereInversion | Sampler::Quadtree) { 1 } else { self.normals }
    }

    /// Checks that every emitter of the scene can be seen.
    ///
    /// # Errors
    /// [`Error::Settings`] where emitters are not sampled and no ray can hit one of them.
    pub fn check_lighting(&self, scene: &Scene) -> Result<()> {
        match scene.delta_emitters.first() {
            Some(emitter) if !self.nee => Err(Error::Settings(format!(
                "the scene has a `{}` emitter, which no ray can hit: its light needs --nee on",
                emitter.kind.plugin()
            ))),
            _ => Ok(()),
        }
    }

    fn validate_crop(&self) -> Result<()> {
        let Crop { x, y, width, height } = self.window();
        let inside =
            |offset: u32, size: u32, whole: u32| size > 0 && u64::from(offset) + u64::from(size) <= whole.into();
        if inside(x, width, self.width) && inside(y, height, self.height) {
            return Ok(());
        }
        Err(Error::Settings(format!(
            "the crop window {x},{y},{width},{height} is empty or leaves the film of {} x {} pixels",
            self.width, self.height
        )))
    }
}

/// What is said where the scene asks for a depth that is rendered otherwise.
pub fn depth_warning(scene: &Scene) -> Option<String> {
    let named = [("max_depth", scene.integrator.max_depth), ("rr_depth", scene.integrator.rr_depth)];
    let (name, depth) = named.into_iter().find_map(|(name, depth)| {
        depth.filter(|&depth| depth != depth_from_scene(depth) as i32).map(|depth| (name, depth))
    })?;
    Some(format!("the scene's {name} of {depth} is rendered as {}", depth_from_scene(depth)))
}

/// As the option is spelled.
fn on_or_off<S: Serializer>(value: &bool, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    serializer.serialize_str(if *value { "on" } else { "off" })
}

fn from_on_or_off<'de, D: Deserializer<'de>>(deserializer: D) -> std::result::Result<bool, D::Error> {
    match String::deserialize(deserializer)?.as_str() {
        "on" => Ok(true),
        "off" => Ok(false),
        other => Err(serde::de::Error::custom(format!("`{other}` is neither on nor off"))),
    }
}

fn number_or_auto<S: Serializer>(&number: &u32, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    if number == AUTO_GRID { serializer.serialize_str("auto") } else { serializer.serialize_u32(number) }
}

fn from_number_or_auto<'de, D: Deserializer<'de>>(deserializer: D) -> std::result::Result<u32, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum NumberOrWord {
        Number(u32),
        Word(String),
    }
    match NumberOrWord::deserialize(deserializer)? {
        NumberOrWord::Number(number) => Ok(number),
        NumberOrWord::Word(word) if word == "auto" => Ok(AUTO_GRID),
        NumberOrWord::Word(word) => Err(serde::de::Error::custom(format!("`{word}` is neither a number nor auto"))),
    }
}

fn depth_from_scene(depth: i32) -> u32 {
    u32::try_from(depth).map_or(MAX_DEPTH_LIMIT, |depth| depth.clamp(1, MAX_DEPTH_LIMIT))
}

fn in_range<T: PartialOrd + std::fmt::Display>(name: &str, value: T, least: T, most: T) -> Result<()> {
    if value >= least && value <= most {
        return Ok(());
    }
    Err(Error::Settings(format!("--{name} is {value}, but must lie between {least} and {most}")))
}
