//! Settings: everything that changes a picture, or how it is rendered.
//!
//! [`Settings`] has one field for each, and kernels, checkpoints and pictures use this form. [`options`] is the table of all options:
//! one entry holds the name, the help, the value, the range and the combinations of an option. [`Settings::validate`] refuses what
//! the table does not allow.

mod derived;
mod film;
mod flat;
pub mod options;
mod paths;
mod run;
mod sampler;
pub(crate) mod schedule;
mod validate;
mod value;

pub use film::MAX_FILM_SIDE;
pub use flat::{AUTO_GRID, Settings};
pub use paths::{MAX_DEPTH_LIMIT, Roulette, SamplePattern, UNLIMITED_DEPTH, depth_warning};
pub use run::{Execution, SampleWeights, StepSchedule, Traversal};
pub use sampler::{BsdfShare, GuideSet, Learner, LightSelection, Mix, Sampler};
pub use value::{Value, Word, Words};

pub use crate::math::direction_map::DirectionMap;
