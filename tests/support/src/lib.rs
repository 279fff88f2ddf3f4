//! Support for the test suites and the benches. Production code cannot reach any of it.

use std::path::{Path, PathBuf};

pub mod bench;
pub mod device;
pub mod estimate;
pub mod floor;
pub mod guide_cases;
pub mod instances;
pub mod mutated;
pub mod panes;
pub mod primitives;
pub mod requests;
pub mod rows;
pub mod sampled_directions;
pub mod scattering_cases;
pub mod scenes;
pub mod significance;
pub mod statistics;
pub mod substances;
pub mod tier;
pub mod twins;
pub mod volumes;

/// Folder of the repository.
fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the repository")
}

/// Folder of the project's own scenes.
pub fn scenes_folder() -> PathBuf {
    repository().join("scenes")
}

/// Folder of Open Image Denoise, where `LODESTAR_OIDN` names it or `setup.sh --oidn` has unpacked it. `None` prints how to get it.
pub fn denoiser_folder() -> Option<PathBuf> {
    let named = std::env::var_os("LODESTAR_OIDN").filter(|value| !value.is_empty()).map(PathBuf::from);
    let unpacked = repository().join("target/oidn");
    let folder = named.or_else(|| unpacked.exists().then_some(unpacked));
    if folder.is_none() {
        println!("skipped: there is no Open Image Denoise; ./setup.sh --oidn gets it");
    }
    folder
}
