//! `lodestar view`, and the arguments of `lodestar render` that open views of a render.

use std::path::PathBuf;
use std::process::ExitCode;
use std::thread;
use std::time::Duration;

use lodestar::Result;
use lodestar::view::{FileView, ViewOptions, check_address};

use super::interrupt::Interrupt;
use super::print::print_message;
use super::render_args::exr_path;

/// Interval at which the file is looked at.
const INTERVAL: Duration = Duration::from_millis(200);
/// Address that only the local machine can reach, with a free port.
const LOCAL: &str = "127.0.0.1:0";

/// Views of a render.
#[derive(Debug, Clone, clap::Args)]
pub struct ViewerArgs {
    #[arg(long, num_args = 0..=1, default_missing_value = LOCAL, value_parser = check_address)]
    pub view: Option<String>,
    #[arg(long, value_parser = check_address)]
    pub display_server: Option<String>,
}

impl From<ViewerArgs> for ViewOptions {
    fn from(args: ViewerArgs) -> Self {
        Self { page: args.view, display_server: args.display_server }
    }
}

/// Shows an EXR picture in a browser.
///
/// The page shows every layer of the picture, with exposure, tone curves and false colors, and the values of its pixels. When
/// the file changes, the page shows it anew. Ctrl-C ends the program.
#[derive(Debug, clap::Args)]
pub struct ViewArgs {
    /// The picture.
    #[arg(value_name = "PICTURE.exr", value_parser = exr_path)]
    picture: PathBuf,
    /// Address of the page; port 0 is a free port.
    #[arg(long, value_name = "ADDRESS:PORT", default_value = LOCAL, value_parser = check_address)]
    address: String,
}

/// Serves the picture until a signal comes.
pub fn run(args: &ViewArgs) -> Result<ExitCode> {
    let interrupt = Interrupt::catch()?;
    let mut view = FileView::start(&args.picture, &args.address)?;
    print_message(&format!("look at the picture at {}", view.url()));
    while !interrupt.is_raised() {
        thread::sleep(INTERVAL);
        view.refresh();
    }
    Ok(ExitCode::SUCCESS)
}
