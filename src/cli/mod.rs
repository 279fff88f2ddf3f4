//! The command line: one file per subcommand.
//!
//! Exit codes: 0 success, 1 failure, 2 wrong usage. If a signal ended a render, the code is 128 plus the signal's number, such as
//! 130 for Ctrl-C.

mod cameras;
mod compare;
mod completions;
mod console;
mod convert;
mod denoise;
mod devices;
mod frames;
mod given;
mod info;
mod inspect;
mod inspect_text;
mod interrupt;
mod layers;
mod log;
#[cfg(test)]
mod manual;
mod merge;
mod print;
mod progress;
mod radiance;
mod ranks;
mod render;
mod render_args;
mod reproduce;
mod resume;
mod view;
mod words;

use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;
#[cfg(unix)]
use std::sync::{Arc, atomic::AtomicBool};

use clap::error::{ContextKind, ContextValue, ErrorKind as UsageError};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use lodestar::session::Options;
use lodestar::settings::options::meaning;
use lodestar::{Error, Result};

use print::report;

/// Renders scenes of Mitsuba, pbrt, glTF, USD and Blender with path guiding, on any Vulkan device.
#[derive(Debug, Parser)]
#[command(name = "lodestar", version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

/// Exit code for wrong usage.
const WRONG_USAGE: u8 = 2;

#[derive(Debug, Subcommand)]
enum Command {
    Render(Box<render::RenderArgs>),
    Resume(Box<resume::ResumeArgs>),
    Inspect(Box<inspect::InspectArgs>),
    Devices(devices::DevicesArgs),
    Info(info::InfoArgs),
    Convert(convert::ConvertArgs),
    Compare(compare::CompareArgs),
    Merge(merge::MergeArgs),
    Denoise(denoise::DenoiseArgs),
    Layers(Box<layers::LayersArgs>),
    Radiance(Box<radiance::RadianceArgs>),
    View(Box<view::ViewArgs>),
    Reproduce(reproduce::ReproduceArgs),
    Completions(completions::CompletionsArgs),
}

/// The command line, with the help of the table of options.
fn command() -> clap::Command {
    given::described(Cli::command())
}

/// Parses the arguments, of which the first is the program's name, runs the subcommand and reports its failure as one sentence.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let parsed = command().try_get_matches_from(arguments).and_then(|matches| Cli::from_arg_matches(&matches));
    let cli = match parsed {
        Ok(cli) => cli,
        Err(error) => return answer(&error),
    };
    take_file_size_limits_as_errors();
    let outcome = match cli.command {
        Command::Render(args) if args.given.has("frames") => frames::render_all(*args),
        Command::Render(args) if cameras::are_all_wanted(&args) => cameras::render_all(*args),
        Command::Render(args) => render::run(*args),
        Command::Resume(args) => resume::run(*args),
        Command::Inspect(args) => inspect::run(&args),
        Command::Devices(args) => devices::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Convert(args) => convert::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Merge(args) => merge::run(&args),
        Command::Denoise(args) => denoise::run(args),
        Command::Layers(args) => layers::run(*args),
        Command::Radiance(args) => radiance::run(*args),
        Command::View(args) => view::run(*args),
        Command::Reproduce(args) => reproduce::run(&args),
        Command::Completions(args) => completions::run(&args, command()),
    };
    outcome.unwrap_or_else(|error| {
        report("error", &error.to_string());
        ExitCode::FAILURE
    })
}

/// Options of a new or a resumed render that arguments of `lodestar render` or `lodestar resume` stand for, such as
/// `--spp=64`. Files of the picture are left out.
///
/// # Errors
/// [`Error::Settings`] for wrong usage, as the command line prints it.
pub fn options(subcommand: &str, arguments: impl IntoIterator<Item = String>) -> Result<Options> {
    // The file stands for the scene or the checkpoint, which the options do not hold.
    let arguments = ["lodestar", subcommand, "file"].map(str::to_owned).into_iter().chain(arguments);
    let parsed = command().try_get_matches_from(arguments).and_then(|matches| Cli::from_arg_matches(&matches));
    match parsed.map(|cli| cli.command) {
        Ok(Command::Render(args)) => Ok(render::options(args.given)),
        Ok(Command::Resume(args)) => Ok(resume::options(&args)),
        Ok(_) => Err(Error::Settings(format!("`{subcommand}` does not render"))),
        Err(error) => Err(Error::Settings(missing(&error).unwrap_or_else(|| fault(&error.to_string())))),
    }
}

/// Catches the signal that a write beyond the limit of `ulimit -f` sends. The write then fails, instead of ending the process
/// before its other files are written.
#[cfg(unix)]
fn take_file_size_limits_as_errors() {
    // If the signal cannot be caught, the limit ends the process. No file is then left half written.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::new(AtomicBool::new(false)));
}

/// Windows has no such limits.
#[cfg(not(unix))]
fn take_file_size_limits_as_errors() {}

/// Prints the help or the version if the arguments ask for it, otherwise the fault in the arguments.
fn answer(error: &clap::Error) -> ExitCode {
    let is_help = error.kind() == UsageError::DisplayHelpOnMissingArgumentOrSubcommand || !error.use_stderr();
    match is_help {
        // The result is ignored: nothing can be done about a closed pipe or a full disk.
        true => drop(error.print()),
        false => report("error", &usage_sentence(error)),
    }
    if error.use_stderr() { ExitCode::from(WRONG_USAGE) } else { ExitCode::SUCCESS }
}

/// The fault in the arguments, and where to read about them.
fn usage_sentence(error: &clap::Error) -> String {
    let quoted = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text.as_str()),
        _ => None,
    };
    let fault = match error.kind() {
        UsageError::UnknownArgument => quoted(ContextKind::InvalidArg).and_then(|argument| {
            let meaning = meaning(argument.strip_prefix("--")?, |option| format!("--{option}"))?;
            Some(format!("unexpected argument '{argument}' found; {meaning}"))
        }),
        UsageError::InvalidSubcommand => quoted(ContextKind::InvalidSubcommand).and_then(|word| {
            let is_file = Path::new(word).extension().is_some() || Path::new(word).exists();
            is_file.then(|| format!("'{word}' is no subcommand; `lodestar render {word}` renders a scene"))
        }),
        UsageError::TooFewValues => quoted(ContextKind::InvalidArg)
            .map(|argument| format!("name two files or more: {}", argument.replace(['<', '>'], ""))),
        UsageError::MissingRequiredArgument => missing(error).map(|names| names + &command_with_them(error)),
        _ => None,
    };
    format!("{}; --help lists the possible arguments", fault.unwrap_or_else(|| self::fault(&error.to_string())))
}

/// Sentence that names the arguments that are missing; `None` for another fault.
fn missing(error: &clap::Error) -> Option<String> {
    let is_missing = error.kind() == UsageError::MissingRequiredArgument;
    let Some(ContextValue::Strings(names)) = error.get(ContextKind::InvalidArg).filter(|_| is_missing) else {
        return None;
    };
    let names: Vec<_> = names.iter().map(|name| plain(name)).collect();
    let verb = if names.len() == 1 { "is" } else { "are" };
    Some(format!("{} {verb} missing", names.join(" and ")))
}

/// Advice that shows the whole command with the arguments that are missing.
fn command_with_them(error: &clap::Error) -> String {
    match error.get(ContextKind::Usage) {
        Some(ContextValue::StyledStr(usage)) => {
            format!("; write {}", plain(usage.to_string().trim_start_matches("Usage:").trim()))
        }
        _ => String::new(),
    }
}

/// Text of clap without the marks of values.
fn plain(text: &str) -> String {
    text.replace(['<', '>'], "")
}

/// First paragraph of clap's message and its tips on names that are similar, on one line.
fn fault(message: &str) -> String {
    let mut paragraphs = message.split("\n\n").map(|paragraph| {
        let lines: Vec<_> = paragraph.lines().map(str::trim).collect();
        lines.join(" ")
    });
    let sentence = paragraphs.next().unwrap_or_default();
    let mut sentence = sentence.strip_prefix("error: ").unwrap_or(&sentence).to_owned();
    for tip in paragraphs.filter_map(|paragraph| paragraph.strip_prefix("tip: ").map(str::to_owned)) {
        if tip.contains("similar") {
            sentence += &format!("; {tip}");
        }
    }
    sentence
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_arguments_are_consistent() {
        command().debug_assert();
    }
}
