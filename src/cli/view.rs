//! `lodestar view`.

use std::path::PathBuf;
use std::process::ExitCode;
use std::thread;
use std::time::Duration;

use lodestar::Result;
use lodestar::settings::options::LOCAL;
use lodestar::settings::options::form::{exr_path, page_address};
use lodestar::view::FileView;

use super::interrupt::Interrupt;
use super::print::print_message;

/// Interval at which the file is looked at.
const INTERVAL: Duration = Duration::from_millis(200);
/// Shows an EXR picture in a browser.
///
/// The page shows every layer of the picture, with exposure, tone curves and false colors, and the values of its pixels. When
/// the file changes, the page shows it anew. Nobody sees anything without the token at the end of the printed address.
/// Ctrl-C ends the program.
#[derive(Debug, clap::Args)]
pub struct ViewArgs {
    /// The picture.
    #[arg(value_name = "PICTURE.exr", value_parser = exr_path)]
    picture: PathBuf,
    /// Address of the page; without a port it has a free one.
    #[arg(long, value_name = "ADDRESS:PORT", default_value = LOCAL, value_parser = page_address)]
    address: String,
}

/// Serves the picture until a signal comes.
pub fn run(args: &ViewArgs) -> Result<ExitCode> {
    let interrupt = Interrupt::catch(false)?;
    let mut view = FileView::start(&args.picture, &args.address)?;
    print_message(&format!("look at the picture at {}", view.url()));
    while !interrupt.is_raised() {
        thread::sleep(INTERVAL);
        view.refresh();
    }
    Ok(ExitCode::SUCCESS)
}
