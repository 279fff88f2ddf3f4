//! Guides as types: every value of [`Guide`] is a legal combination of sampler, learner and their parameters.
//!
//! The kernels, checkpoints and pictures hold a guide as flat [`Settings`]. [`Settings::with_guide`] writes a guide to settings,
//! and `Guide::try_from` reads it from them. Writing cannot fail. A number may still be out of its range;
//! [`Settings::validate`] refuses it.

use super::{
    AUTO_GRID, BsdfShare, DirectionMap, EXPECTED_DIRECTIONS, GuideSet, Learner, LightSelection, Mix, Roulette, Sampler,
    Settings, options,
};
use crate::{Error, Result};

/// Guide of a render.
#[derive(Debug, Clone, PartialEq)]
pub enum Guide {
    /// No guide: directions come from the BSDF.
    None,
    /// Quadtrees of learned flux, which learn by [`Learner::MonteCarlo`].
    Quadtree(Quadtree),
    /// A grid of learned radiance.
    Grid(Grid),
}

/// Parameters of the quadtree guide.
#[derive(Debug, Clone, PartialEq)]
pub struct Quadtree {
    /// BSDFs that are guided.
    pub surfaces: GuideSet,
    /// Map between directions and the squares of the quadtrees.
    pub map: DirectionMap,
    /// Cells along each axis of a grid. The trees have at most as many nodes as this grid has bins.
    pub cells: u32,
    /// Direction bins along each side of a cell of that grid.
    pub directions: u32,
}

/// Parameters of a guide in a grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Sampler that draws directions from the grid.
    pub sampler: GridSampler,
    /// BSDFs that are guided.
    pub surfaces: GuideSet,
    /// Map between directions and their bins.
    pub map: DirectionMap,
    /// Number of cells; `None` chooses it as [`Settings::grid`] says.
    pub cells: Option<Cells>,
    /// Number of targets that the knowledge of a cell's parents counts for in each bin; 0 leaves parents out. `None` chooses it
    /// as [`Settings::fallback`] says.
    pub fallback: Option<f32>,
    /// Factor on a bin's earlier count at each step.
    pub decay: f32,
}

/// Number of cells of a grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cells {
    /// Cubes, and the more of them the larger the picture is, as [`Settings::grid`](crate::settings::Settings#structfield.grid) says.
    Auto,
    /// A number along each axis.
    PerAxis(u32),
}

/// Sampler of a grid, with its parameters.
#[derive(Debug, Clone, PartialEq)]
pub enum GridSampler {
    /// Learned radiance times cosine by a descent, mixed with the BSDF ([`Sampler::Product`]).
    Product {
        /// Learner, with the share of the BSDF that it allows.
        learner: ProductLearner,
        /// Direction bins along each side of a cell.
        directions: ProductDirections,
        /// Normal bins along each side of a cell.
        normals: u32,
        /// Quantity that Russian roulette compares with; `None` chooses it as [`Settings::roulette`] says.
        roulette: Option<Roulette>,
        /// Probabilities with which lights are drawn; `None` learns them.
        light_selection: Option<LightSelection>,
    },
    /// Rejection with a share of uniform directions ([`Sampler::RejectionMix`]).
    RejectionMix {
        /// Learner.
        learner: GridLearner,
        /// Mixture with uniform directions.
        mixture: Mixture,
        /// Proposals before a uniform direction is taken.
        max_tries: u32,
        /// Direction bins along each side of a cell.
        directions: u32,
        /// Normal bins along each side of a cell.
        normals: u32,
    },
    /// Rejection with the least share of uniform directions ([`Sampler::Rejection`]).
    Rejection {
        /// Learner.
        learner: GridLearner,
        /// Proposals before a uniform direction is taken.
        max_tries: u32,
        /// Least share of uniform directions.
        min_uniform: f32,
        /// Direction bins along each side of a cell.
        directions: u32,
        /// Normal bins along each side of a cell.
        normals: u32,
    },
    /// Inversion over the sphere ([`Sampler::SphereInversion`]).
    SphereInversion {
        /// Learner.
        learner: GridLearner,
        /// Least share of uniform directions.
        min_uniform: f32,
        /// Direction bins along each side of a cell.
        directions: u32,
    },
    /// Inversion over the hemisphere ([`Sampler::HemisphereInversion`]).
    HemisphereInversion {
        /// Learner.
        learner: GridLearner,
        /// Least share of uniform directions.
        min_uniform: f32,
        /// Direction bins along each side of a cell.
        directions: u32,
        /// Normal bins along each side of a cell.
        normals: u32,
    },
}

/// Learner of a grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GridLearner {
    /// [`Learner::Sarsa`].
    Sarsa,
    /// [`Learner::ExpectedSarsa`] with the mean over this number of directions.
    ExpectedSarsa(u32),
    /// [`Learner::MonteCarlo`].
    MonteCarlo,
}

/// Learner of a grid from which [`Sampler::Product`] draws, with the share of the BSDF.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ProductLearner {
    /// [`Learner::Sarsa`].
    Sarsa(Share),
    /// [`Learner::ExpectedSarsa`] with the mean over this number of directions.
    ExpectedSarsa(u32, Share),
    /// [`Learner::MonteCarlo`] with a fixed share, or 0.25: this learner cannot learn the share.
    MonteCarlo(Option<f32>),
}

/// Share of the BSDF.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Share {
    /// A share that each cell learns.
    Learned,
    /// One share everywhere: this one, or 0.25.
    Fixed(Option<f32>),
}

/// Numbers of direction bins that the descent of [`Sampler::Product`] can divide by four.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProductDirections {
    /// 16 bins along each side.
    Side16,
    /// 32 bins along each side.
    Side32,
    /// 64 bins along each side.
    Side64,
}

/// Mixture of the guide with uniform directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mixture {
    /// Densities with the optimal share, but at least `min_uniform` (Eq. 8).
    OptimalDensities {
        /// Least share.
        min_uniform: f32,
    },
    /// Densities with a fixed share.
    FixedDensities(f32),
    /// Probabilities of acceptance (Eq. 9).
    Acceptances {
        /// Fixed share; `None` takes the optimal share.
        share: Option<f32>,
        /// Least share.
        min_uniform: f32,
    },
}

impl Settings {
    /// Settings with another guide. Parameters that the guide does not have return to their defaults.
    #[must_use]
    pub fn with_guide(self, guide: Guide) -> Self {
        let mut settings = self.without_guide();
        match guide {
            Guide::None => {}
            Guide::Quadtree(Quadtree { surfaces, map, cells, directions }) => {
                (settings.sampler, settings.learner) = (Sampler::Quadtree, Learner::MonteCarlo);
                (settings.guide_set, settings.map) = (surfaces, map);
                (settings.grid, settings.directions) = (Some(cells), directions);
            }
            Guide::Grid(Grid { sampler, surfaces, map, cells, fallback, decay }) => {
                settings.set_grid_sampler(sampler);
                (settings.guide_set, settings.map) = (surfaces, map);
                (settings.fallback, settings.decay) = (fallback, decay);
                settings.grid = cells.map(|cells| match cells {
                    Cells::Auto => AUTO_GRID,
                    Cells::PerAxis(number) => number,
                });
            }
        }
        settings
    }

    fn without_guide(self) -> Self {
        let defaults = options::defaults();
        Self {
            sampler: Sampler::Bsdf,
            learner: Learner::Sarsa,
            expected_directions: EXPECTED_DIRECTIONS,
            mix: Mix::Density,
            epsilon: None,
            bsdf_share: None,
            light_selection: self.light_selection.filter(|&selection| selection != LightSelection::Learned),
            roulette: self.roulette.filter(|&roulette| roulette != Roulette::Contribution),
            guide_set: defaults.guide_set,
            map: defaults.map,
            grid: None,
            fallback: None,
            directions: defaults.directions,
            normals: defaults.normals,
            max_tries: defaults.max_tries,
            min_uniform: defaults.min_uniform,
            decay: defaults.decay,
            ..self
        }
    }

    fn set_grid_sampler(&mut self, sampler: GridSampler) {
        match sampler {
            GridSampler::Product { learner, directions, normals, roulette, light_selection } => {
                self.sampler = Sampler::Product;
                self.set_product_learner(learner);
                (self.directions, self.normals, self.roulette) = (directions.number(), normals, roulette);
                self.light_selection = light_selection;
            }
            GridSampler::RejectionMix { learner, mixture, max_tries, directions, normals } => {
                self.sampler = Sampler::RejectionMix;
                self.set_learner(learner);
                self.set_mixture(mixture);
                (self.max_tries, self.directions, self.normals) = (max_tries, directions, normals);
            }
            GridSampler::Rejection { learner, max_tries, min_uniform, directions, normals } => {
                self.sampler = Sampler::Rejection;
                self.set_learner(learner);
                (self.max_tries, self.min_uniform) = (max_tries, min_uniform);
                (self.directions, self.normals) = (directions, normals);
            }
            GridSampler::SphereInversion { learner, min_uniform, directions } => {
                self.sampler = Sampler::SphereInversion;
                self.set_learner(learner);
                (self.min_uniform, self.directions) = (min_uniform, directions);
            }
            GridSampler::HemisphereInversion { learner, min_uniform, directions, normals } => {
                self.sampler = Sampler::HemisphereInversion;
                self.set_learner(learner);
                (self.min_uniform, self.directions, self.normals) = (min_uniform, directions, normals);
            }
        }
    }

    fn set_learner(&mut self, learner: GridLearner) {
        match learner {
            GridLearner::Sarsa => self.learner = Learner::Sarsa,
            GridLearner::ExpectedSarsa(directions) => {
                (self.learner, self.expected_directions) = (Learner::ExpectedSarsa, directions);
            }
            GridLearner::MonteCarlo => self.learner = Learner::MonteCarlo,
        }
    }

    fn set_product_learner(&mut self, learner: ProductLearner) {
        let share = match learner {
            ProductLearner::Sarsa(share) => {
                self.set_learner(GridLearner::Sarsa);
                share
            }
            ProductLearner::ExpectedSarsa(directions, share) => {
                self.set_learner(GridLearner::ExpectedSarsa(directions));
                share
            }
            ProductLearner::MonteCarlo(share) => {
                self.set_learner(GridLearner::MonteCarlo);
                Share::Fixed(share)
            }
        };
        (self.bsdf_share, self.epsilon) = match share {
            Share::Learned => (None, None),
            Share::Fixed(share) => (Some(BsdfShare::Fixed), share),
        };
    }

    fn set_mixture(&mut self, mixture: Mixture) {
        match mixture {
            Mixture::OptimalDensities { min_uniform } => self.min_uniform = min_uniform,
            Mixture::FixedDensities(share) => self.epsilon = Some(share),
            Mixture::Acceptances { share, min_uniform } => {
                (self.mix, self.epsilon, self.min_uniform) = (Mix::Acceptance, share, min_uniform);
            }
        }
    }
}

impl TryFrom<&Settings> for Guide {
    type Error = Error;

    /// Guide of settings.
    ///
    /// # Errors
    /// [`Error::Settings`] where the settings are no legal combination.
    fn try_from(settings: &Settings) -> Result<Self> {
        options::check(settings)?;
        let sampler = match settings.sampler {
            Sampler::Bsdf => return Ok(Self::None),
            Sampler::Quadtree => return Ok(Self::Quadtree(Quadtree::of(settings))),
            Sampler::Product => GridSampler::product_of(settings),
            Sampler::RejectionMix => GridSampler::RejectionMix {
                learner: GridLearner::of(settings),
                mixture: Mixture::of(settings),
                max_tries: settings.max_tries,
                directions: settings.directions,
                normals: settings.normals,
            },
            Sampler::Rejection => GridSampler::Rejection {
                learner: GridLearner::of(settings),
                max_tries: settings.max_tries,
                min_uniform: settings.min_uniform,
                directions: settings.directions,
                normals: settings.normals,
            },
            Sampler::SphereInversion => GridSampler::SphereInversion {
                learner: GridLearner::of(settings),
                min_uniform: settings.min_uniform,
                directions: settings.directions,
            },
            Sampler::HemisphereInversion => GridSampler::HemisphereInversion {
                learner: GridLearner::of(settings),
                min_uniform: settings.min_uniform,
                directions: settings.directions,
                normals: settings.normals,
            },
        };
        let cells = settings.grid.map(|grid| if grid == AUTO_GRID { Cells::Auto } else { Cells::PerAxis(grid) });
        let &Settings { guide_set: surfaces, map, fallback, decay, .. } = settings;
        Ok(Self::Grid(Grid { sampler, surfaces, map, cells, fallback, decay }))
    }
}

impl Quadtree {
    fn of(settings: &Settings) -> Self {
        let &Settings { guide_set: surfaces, map, directions, .. } = settings;
        Self { surfaces, map, cells: settings.grid(), directions }
    }
}

impl GridSampler {
    fn product_of(settings: &Settings) -> Self {
        let share = match settings.learns_share() {
            true => Share::Learned,
            false => Share::Fixed(settings.epsilon),
        };
        let learner = match settings.learner {
            Learner::Sarsa => ProductLearner::Sarsa(share),
            Learner::ExpectedSarsa => ProductLearner::ExpectedSarsa(settings.expected_directions, share),
            Learner::MonteCarlo => ProductLearner::MonteCarlo(settings.epsilon),
        };
        let directions = match settings.directions {
            64 => ProductDirections::Side64,
            32 => ProductDirections::Side32,
            _ => ProductDirections::Side16,
        };
        let &Settings { normals, roulette, light_selection, .. } = settings;
        Self::Product { learner, directions, normals, roulette, light_selection }
    }
}

impl GridLearner {
    fn of(settings: &Settings) -> Self {
        match settings.learner {
            Learner::ExpectedSarsa => Self::ExpectedSarsa(settings.expected_directions),
            Learner::MonteCarlo => Self::MonteCarlo,
            Learner::Sarsa => Self::Sarsa,
        }
    }
}

impl Mixture {
    fn of(settings: &Settings) -> Self {
        let min_uniform = settings.min_uniform;
        match (settings.mix, settings.epsilon) {
            (Mix::Density, None) => Self::OptimalDensities { min_uniform },
            (Mix::Density, Some(share)) => Self::FixedDensities(share),
            (Mix::Acceptance, share) => Self::Acceptances { share, min_uniform },
        }
    }
}

impl ProductDirections {
    /// Number of bins along each side.
    pub const fn number(self) -> u32 {
        match self {
            Self::Side16 => 16,
            Self::Side32 => 32,
            Self::Side64 => 64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEARNERS: [GridLearner; 3] = [GridLearner::Sarsa, GridLearner::ExpectedSarsa(7), GridLearner::MonteCarlo];

    fn samplers() -> Vec<GridSampler> {
        let (max_tries, min_uniform, directions, normals) = (9, 0.25, 12, 5);
        let mut samplers = Vec::new();
        for learner in LEARNERS {
            let mixtures = [
                Mixture::OptimalDensities { min_uniform },
                Mixture::FixedDensities(0.5),
                Mixture::Acceptances { share: None, min_uniform },
                Mixture::Acceptances { share: Some(0.5), min_uniform },
            ];
            samplers.extend(mixtures.map(|mixture| GridSampler::RejectionMix {
                learner,
                mixture,
                max_tries,
                directions,
                normals,
            }));
            samplers.push(GridSampler::Rejection { learner, max_tries, min_uniform, directions, normals });
            samplers.push(GridSampler::SphereInversion { learner, min_uniform, directions });
            samplers.push(GridSampler::HemisphereInversion { learner, min_uniform, directions, normals });
        }
        let shares = [Share::Learned, Share::Fixed(None), Share::Fixed(Some(0.5))];
        let learners = shares
            .into_iter()
            .flat_map(|share| [ProductLearner::Sarsa(share), ProductLearner::ExpectedSarsa(7, share)]);
        for learner in learners.chain([None, Some(0.5)].map(ProductLearner::MonteCarlo)) {
            for directions in [ProductDirections::Side16, ProductDirections::Side32, ProductDirections::Side64] {
                for roulette in [None, Some(Roulette::Throughput), Some(Roulette::Contribution)] {
                    for light_selection in [None, Some(LightSelection::Power), Some(LightSelection::Learned)] {
                        samplers.push(GridSampler::Product { learner, directions, normals, roulette, light_selection });
                    }
                }
            }
        }
        samplers
    }

    fn guides() -> Vec<Guide> {
        let (surfaces, map) = (GuideSet::Authors, DirectionMap::Cylindrical);
        let grids = samplers().into_iter().flat_map(|sampler| {
            [(None, Some(4.0)), (Some(Cells::Auto), None), (Some(Cells::PerAxis(5)), Some(4.0))].map(
                |(cells, fallback)| {
                    Guide::Grid(Grid { sampler: sampler.clone(), surfaces, map, cells, fallback, decay: 0.5 })
                },
            )
        });
        let quadtree = Guide::Quadtree(Quadtree { surfaces, map, cells: 5, directions: 12 });
        grids.chain([Guide::None, quadtree]).collect()
    }

    #[test]
    fn every_guide_is_legal_and_comes_back() {
        // The settings pass from guide to guide, and no guide may leave a trace in the next one.
        let mut settings = options::defaults();
        for guide in guides() {
            settings = settings.with_guide(guide.clone());
            settings.validate().expect("a legal guide");
            assert_eq!(Guide::try_from(&settings).expect("a guide"), guide);
        }
        assert_eq!(guides().len(), 3 * (3 * 7 + 8 * 27) + 2);
    }

    #[test]
    fn the_default_guide_is_that_of_the_default_settings() {
        let defaults = options::defaults();
        let guide = Guide::try_from(&defaults).expect("a guide");
        assert_eq!(defaults.clone().with_guide(Guide::None).with_guide(guide), defaults);
    }

    /// Some flat settings are no legal guide. The table refuses each of them.
    #[test]
    fn what_is_no_guide_is_refused() {
        let changes: [fn(&mut Settings); 12] = [
            |s| s.directions = 8,
            |s| s.mix = Mix::Acceptance,
            |s| (s.bsdf_share, s.epsilon) = (Some(BsdfShare::Learned), Some(0.5)),
            |s| (s.bsdf_share, s.learner) = (Some(BsdfShare::Learned), Learner::MonteCarlo),
            |s| (s.sampler, s.epsilon) = (Sampler::Rejection, Some(0.5)),
            |s| (s.sampler, s.roulette) = (Sampler::Bsdf, Some(Roulette::Contribution)),
            |s| (s.sampler, s.bsdf_share) = (Sampler::Bsdf, Some(BsdfShare::Fixed)),
            |s| (s.sampler, s.light_selection) = (Sampler::Bsdf, Some(LightSelection::Learned)),
            |s| (s.sampler, s.learner) = (Sampler::Bsdf, Learner::MonteCarlo),
            |s| s.sampler = Sampler::Quadtree,
            |s| (s.sampler, s.learner, s.grid) = (Sampler::Quadtree, Learner::MonteCarlo, Some(AUTO_GRID)),
            |s| (s.sampler, s.learner, s.fallback) = (Sampler::Quadtree, Learner::MonteCarlo, Some(4.0)),
        ];
        for (at, change) in changes.into_iter().enumerate() {
            let mut settings = options::defaults();
            change(&mut settings);
            assert!(Guide::try_from(&settings).is_err(), "change {at}");
        }
    }
}
