//! Sessions: a render from its start to its end, with its checkpoints, safety copies, statistics and times.
//!
//! A render goes from type to type: a `Plan` is what was asked, `Prepared` has scene, devices
//! and kernels ready, `Running` takes steps, and `Finished` is what its end has left besides
//! the files.
//! [`Session`] is what a caller has of it.
//!
//! | part | file |
//! |---|---|
//! | what a caller has | `facade.rs` |
//! | a caller's choices and their defaults | `options.rs`, `length.rs`, `start.rs` |
//! | what was asked, once the scene is known | `plan.rs` |
//! | scene, devices and kernels before the first step | `prepared.rs`, `devices.rs`, `subject.rs`, `kernel_files.rs` |
//! | other ranks of the render | `ranks.rs` |
//! | the steps, and when they end | `running/`, `origin.rs` |
//! | pictures, and all files at the end | `output.rs`, `files.rs`, `finished.rs` |
//! | checkpoints | `checkpoint.rs` (the file), `sealed.rs` (its layout), `saved.rs` (its reader), `checkpoints.rs` (when it is written), `checkpoint_lock.rs` (by whom), `film/identity.rs` (which render it belongs to) |
//! | copies of the picture in case the device is lost | `safety_copy.rs` |
//! | statistics and times | `history.rs`, `statistics.rs`, `profile.rs`, `profiler.rs` |
//! | guides of earlier renders | `guide_file.rs` (which file), `saved_guide.rs` (a guide alone) |
//! | events for a caller | `progress.rs` |

#[doc(hidden)]
pub mod checkpoint;
mod checkpoint_lock;
mod checkpoints;
mod devices;
mod facade;
mod files;
mod finished;
mod guide_file;
mod history;
#[doc(hidden)]
pub mod kernel_files;
mod length;
mod options;
mod origin;
mod output;
mod plan;
mod prepared;
#[doc(hidden)]
pub mod profile;
mod profiler;
mod progress;
mod ranks;
mod running;
mod safety_copy;
#[doc(hidden)]
pub mod saved;
#[doc(hidden)]
pub mod saved_guide;
mod sealed;
mod source;
mod start;
#[doc(hidden)]
pub mod statistics;
mod subject;

pub use crate::denoise::{DenoiseOptions, DeviceKind};
#[doc(hidden)]
pub use crate::film::identity;
pub use facade::Session;
pub use files::OutputFiles;
#[doc(hidden)]
pub use files::PictureFiles;
#[doc(hidden)]
pub use history::History;
pub use length::Length;
pub use options::{CHECKPOINT_EVERY, FilmSize, Options};
pub use progress::{Beginning, Ending, Event, Preparation, Progress, Watch};
pub use start::{SceneInput, Start};
