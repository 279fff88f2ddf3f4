//! The arguments of `lodestar render` that open views of a render.

use lodestar::denoise::DenoiseOptions;
use lodestar::view::{ViewOptions, check_address};

/// Address that only the local machine can reach, with a free port.
pub const LOCAL: &str = "127.0.0.1:0";

/// Views of a render.
#[derive(Debug, Clone, clap::Args)]
pub struct ViewerArgs {
    #[arg(long, num_args = 0..=1, default_missing_value = LOCAL, value_parser = check_address)]
    pub view: Option<String>,
    #[arg(long, value_parser = check_address)]
    pub display_server: Option<String>,
}

impl ViewerArgs {
    /// Views that the arguments ask for. `denoiser` makes the page's layer `denoised`.
    pub fn options(self, denoiser: DenoiseOptions) -> ViewOptions {
        ViewOptions { page: self.view, display_server: self.display_server, denoiser }
    }
}
