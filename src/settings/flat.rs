//! Settings, one field each.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::paths::{Roulette, SamplePattern, UNLIMITED_DEPTH, max_depth_from_scene, rr_depth_from_scene};
use super::run::{Execution, SampleWeights, StepSchedule, Traversal};
use super::sampler::{BsdfShare, GuideSet, Learner, LightSelection, Mix, Sampler};
use crate::generated::constants::Variant;
use crate::math::direction_map::DirectionMap;
use crate::scene::{Crop, FilmDescription, IntegratorDescription, ReconstructionFilter, Scene};

/// Number of directions over which `expected-sarsa` takes its mean by default.
pub(crate) const EXPECTED_DIRECTIONS: u32 = DEFAULTS.expected_directions;
/// Value of [`Settings::grid`] that stands for `--grid auto`.
pub const AUTO_GRID: u32 = u32::MAX;
/// Defaults of the kernels.
const DEFAULTS: Variant = Variant::DEFAULT;

/// Settings of a render. [`Settings::for_scene`] gives the defaults.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Width of the whole film in pixels, in [1, 65536].
    pub width: u32,
    /// Height of the whole film in pixels, in [1, 65536].
    pub height: u32,
    /// Window of the film that is rendered. `None` renders all of the film.
    pub crop: Option<Crop>,
    /// Reconstruction filter.
    pub filter: ReconstructionFilter,
    /// Longest path in edges, in [1, 1024], or [`UNLIMITED_DEPTH`]. A path of 1 edge sees emission directly.
    #[serde(serialize_with = "depth_or_unlimited", deserialize_with = "from_depth_or_unlimited")]
    pub max_depth: u32,
    /// Number of edges after which Russian roulette by throughput begins, at least 1.
    pub rr_depth: u32,
    /// Whether directly seen emitters are black.
    pub hide_emitters: bool,
    /// Whether emitters are sampled at every vertex (next event estimation).
    #[serde(serialize_with = "on_or_off", deserialize_with = "from_on_or_off")]
    pub nee: bool,
    /// Seed of every random number.
    pub seed: u32,
    /// Distribution of a pixel's samples.
    pub pattern: SamplePattern,
    /// Estimated relative error at which sampling of a tile of 8 x 8 pixels ends, in [1e-4, 1]. The picture is then consistent,
    /// not unbiased ([`crate::film::noise`]). `None` gives all pixels equally many samples.
    pub noise: Option<f32>,
    /// Index of every pixel's first sample, where the render is one part of several. Parts of one seed are independent if their
    /// samples do not overlap. They keep sums that add up to the same bits in any order ([`crate::film::sums`]).
    pub sample_offset: Option<u32>,
    /// Source of scattered directions.
    pub sampler: Sampler,
    /// BSDFs that are guided.
    pub guide_set: GuideSet,
    /// Rule by which the radiance grid learns.
    pub learner: Learner,
    /// Map between directions and their bins.
    pub map: DirectionMap,
    /// Quantities that `rejection-mix` mixes with the uniform share.
    pub mix: Mix,
    /// Share e that is mixed with the guide, in [1e-4, 1]. With `rejection-mix` it is the share of uniform directions; `None`
    /// takes the optimal share (Eq. 8). With `product` it is the share of the BSDF; `None` takes the learned
    /// share, or 0.25 where cells do not learn one.
    pub epsilon: Option<f32>,
    /// Share of the BSDF with `product`, fixed or learned. `None` learns it where cells can.
    pub bsdf_share: Option<BsdfShare>,
    /// Probabilities with which emitter sampling draws lights. `None` learns them with `product`.
    pub light_selection: Option<LightSelection>,
    /// Quantity that Russian roulette compares with. `None` chooses it as [`Settings::roulette`] says.
    pub roulette: Option<Roulette>,
    /// Number of directions over which `expected-sarsa` takes its mean, in [1, 4096].
    pub expected_directions: u32,
    /// Cells along each axis of the grids, in [1, 32]. [`AUTO_GRID`] takes the finest cubes whose guide fits 8, 16, 32 or 64
    /// MiB: the first of these that has 128 bytes for each pixel of the film, or the last. Quadtrees have at most as many nodes as
    /// grids of this size have bins. `None` chooses it as [`Settings::grid`] says.
    #[serde(serialize_with = "number_or_auto", deserialize_with = "from_number_or_auto")]
    pub grid: Option<u32>,
    /// Number of targets that the knowledge of a cell's parents counts for in each of its bins, in [0, 1e6]. With 0 a cell uses
    /// its own knowledge only. `None` chooses it as [`Settings::fallback`] says.
    pub fallback: Option<f32>,
    /// Direction bins along each side of the map, in [4, 64].
    pub directions: u32,
    /// Normal bins along each side of the equal-area square, in [4, 32].
    pub normals: u32,
    /// Most samples per pixel between two updates of the grids, at least 1.
    pub spp_per_step: u32,
    /// Schedule of the samples between updates. [`Settings::samples_of_step`] computes it.
    pub steps: StepSchedule,
    /// Weights of the samples in the picture. `None` chooses them as [`Settings::sample_weights`] says.
    pub sample_weights: Option<SampleWeights>,
    /// Most samples per pixel of one dispatch, in [1, 64]. A driver may bound the loop iterations of a dispatch.
    pub samples_per_dispatch: u32,
    /// Proposals before a guided sample takes a uniform direction, in [1, 1024]. Proposals are drawn in pairs; the uniform
    /// direction completes an odd number, so an odd number wastes none.
    pub max_tries: u32,
    /// Least share of uniform directions, in (0, 1].
    pub min_uniform: f32,
    /// Factor on a bin's earlier count at each step, in [0, 1]. With 1, the mean runs over all steps, as in the paper.
    pub decay: f32,
    /// Wanted duration of one dispatch in milliseconds. `None` chooses it by the kind of device.
    pub slice_milliseconds: Option<f64>,
    /// Kernels that trace the paths.
    pub execution: Execution,
    /// Way of finding what a ray hits.
    #[serde(default)]
    pub traversal: Traversal,
    /// Most workgroups of a dispatch over a queue of a wave. `None` takes a number that suits a large GPU.
    #[serde(skip)]
    #[doc(hidden)]
    pub queue_groups: Option<u32>,
    /// Most pixels of one film page. `None` takes the number that the device can bind.
    #[serde(skip)]
    #[doc(hidden)]
    pub film_page_pixels: Option<u32>,
    /// Whether geometry and tables are read from storage buffers even where texel buffers would do.
    #[serde(skip)]
    #[doc(hidden)]
    pub storage_reads: bool,
}

impl Settings {
    /// Default settings for a scene: the scene's own choices where it makes any, else paths of unlimited length, roulette after depth 8, and
    /// grids of the paper's size.
    pub fn for_scene(scene: &Scene) -> Self {
        Self::for_film(&scene.film, &scene.integrator)
    }

    /// Default settings for a film and an integrator: the parts of a scene that settings depend on.
    pub fn for_film(film: &FilmDescription, integrator: &IntegratorDescription) -> Self {
        Self {
            width: film.width,
            height: film.height,
            crop: film.crop,
            filter: film.filter,
            max_depth: max_depth_from_scene(integrator.max_depth),
            rr_depth: integrator.rr_depth.map_or(DEFAULTS.rr_depth, rr_depth_from_scene),
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
            light_selection: None,
            roulette: None,
            expected_directions: EXPECTED_DIRECTIONS,
            grid: None,
            fallback: None,
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
            traversal: Traversal::Compute,
            queue_groups: None,
            film_page_pixels: None,
            storage_reads: false,
        }
    }

    /// Settings without a guide. What belongs to a guide returns to its default.
    #[must_use]
    pub fn without_guide(self) -> Self {
        let film = FilmDescription { width: self.width, height: self.height, crop: self.crop, filter: self.filter };
        let defaults = Self::for_film(&film, &IntegratorDescription::default());
        Self {
            sampler: Sampler::Bsdf,
            light_selection: self.light_selection.filter(|&selection| selection != LightSelection::Learned),
            roulette: self.roulette.filter(|&roulette| roulette != Roulette::Contribution),
            learner: defaults.learner,
            expected_directions: defaults.expected_directions,
            mix: defaults.mix,
            epsilon: defaults.epsilon,
            bsdf_share: defaults.bsdf_share,
            guide_set: defaults.guide_set,
            map: defaults.map,
            grid: defaults.grid,
            fallback: defaults.fallback,
            directions: defaults.directions,
            normals: defaults.normals,
            max_tries: defaults.max_tries,
            min_uniform: defaults.min_uniform,
            decay: defaults.decay,
            ..self
        }
    }

    /// Name and value of every setting that a user may choose. A number is written as `0.95`, not as its nearest `f32`.
    pub fn named(&self) -> Vec<(String, String)> {
        let value = serde_json::to_string(self).and_then(|text| serde_json::from_str(&text));
        let value: serde_json::Value = value.unwrap_or_default();
        let plain = |value: &serde_json::Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        value.as_object().into_iter().flatten().map(|(name, value)| (name.clone(), plain(value))).collect()
    }
}

/// Writes a switch as the option is spelled.
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

fn number_or_auto<S: Serializer>(number: &Option<u32>, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    match *number {
        None => serializer.serialize_none(),
        Some(AUTO_GRID) => serializer.serialize_str("auto"),
        Some(number) => serializer.serialize_u32(number),
    }
}

fn from_number_or_auto<'de, D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Option<u32>, D::Error> {
    let number = Option::<NumberOrWord>::deserialize(deserializer)?;
    number.map(|number| number.meaning("auto", AUTO_GRID)).transpose()
}

fn depth_or_unlimited<S: Serializer>(&depth: &u32, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    if depth == UNLIMITED_DEPTH { serializer.serialize_str("unlimited") } else { serializer.serialize_u32(depth) }
}

fn from_depth_or_unlimited<'de, D: Deserializer<'de>>(deserializer: D) -> std::result::Result<u32, D::Error> {
    NumberOrWord::deserialize(deserializer)?.meaning("unlimited", UNLIMITED_DEPTH)
}

/// A number, or a word that stands for one.
#[derive(Deserialize)]
#[serde(untagged)]
enum NumberOrWord {
    Number(u32),
    Word(String),
}

impl NumberOrWord {
    /// The number, where the word `wanted` stands for `meaning`.
    fn meaning<E: serde::de::Error>(self, wanted: &str, meaning: u32) -> std::result::Result<u32, E> {
        match self {
            Self::Number(number) => Ok(number),
            Self::Word(word) if word == wanted => Ok(meaning),
            Self::Word(word) => Err(E::custom(format!("`{word}` is neither a number nor {wanted}"))),
        }
    }
}
