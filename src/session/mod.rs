//! Sessions: a render from its start to its end, with its checkpoints, safety copies, statistics and times.
//!
//! | part | file |
//! |---|---|
//! | a caller's choices and their defaults | `options.rs`, `length.rs` |
//! | the work before the first step of a new or a resumed render | `start.rs`, `setup.rs`, `prepared.rs` |
//! | other ranks of the render | `ranks.rs` |
//! | the steps, and when they end | `run.rs` |
//! | the files at the end | `finish.rs`, `files.rs` |
//! | checkpoints | `checkpoint.rs` (the file), `saved.rs` (its reader), `checkpoints.rs` (when it is written), `checkpoint_lock.rs` (by whom), `film/identity.rs` (which render it belongs to) |
//! | copies of the picture in case the device is lost | `safety_copy.rs` |
//! | statistics and times | `history.rs`, `statistics.rs`, `profile.rs`, `profiler.rs` |
//! | what later renders begin with, on demand | `continuation.rs`, `guide_file.rs` |
//! | events for a caller | `progress.rs` |
//! | what the guide has learned | `guide.rs` |

#[doc(hidden)]
pub mod checkpoint;
mod checkpoint_lock;
mod checkpoints;
mod continuation;
mod files;
mod finish;
mod guide;
mod guide_file;
mod history;
#[doc(hidden)]
pub mod kernel_files;
mod length;
mod options;
mod prepared;
#[doc(hidden)]
pub mod profile;
mod profiler;
mod progress;
#[doc(hidden)]
pub mod radiance_map;
mod ranks;
mod run;
mod safety_copy;
#[doc(hidden)]
pub mod saved;
mod setup;
mod start;
#[doc(hidden)]
pub mod statistics;

pub use crate::denoise::{DenoiseOptions, DeviceKind};
#[doc(hidden)]
pub use crate::film::identity;
pub use files::OutputFiles;
#[doc(hidden)]
pub use files::PictureFiles;
#[doc(hidden)]
pub use history::History;
pub use length::Length;
pub use options::{CHECKPOINT_EVERY, FilmSize, Options};
pub use progress::{Beginning, Ending, Event, Preparation, Progress, Watch};
pub use run::Session;
pub use start::{SceneInput, Start};
