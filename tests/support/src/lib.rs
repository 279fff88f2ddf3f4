//! Support for the test suites and the benches. Production code cannot reach any of it.

use std::path::{Path, PathBuf};

pub mod bench;
pub mod device;
pub mod estimate;
pub mod floor;
pub mod guide_cases;
pub mod mutated;
pub mod sampled_directions;
pub mod scattering_cases;
pub mod scenes;
pub mod significance;
pub mod statistics;
pub mod substances;
pub mod tier;
pub mod twins;

/// Folder of the project's own scenes.
pub fn scenes_folder() -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the repository");
    root.join("scenes")
}
