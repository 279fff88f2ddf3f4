//! Lines that the command line prints.

use std::io::{self, ErrorKind, Write};
use std::path::Path;

use lodestar::{Error, Result};

/// Prints a line to standard error. A closed standard error is ignored.
pub(super) fn report(kind: &str, text: &str) {
    // One write, because other processes may write to the same file at the same time.
    let _ = io::stderr().write_all(format!("lodestar: {kind}: {}\n", harmless(text)).as_bytes());
}

/// Prints a line to standard error without a prefix. A closed standard error is ignored.
pub(super) fn print_message(text: &str) {
    let _ = writeln!(io::stderr(), "{}", harmless(text));
}

/// `text` without what a terminal would take for orders. Names in a scene may hold any character. Only a list of faults has several lines.
fn harmless(text: &str) -> String {
    text.chars().map(|c| if c.is_control() && c != '\n' { ' ' } else { c }).collect()
}

/// Prints `text` and a line break. A pipe that its reader has closed (`lodestar ... | head -1`) is no error.
pub(super) fn print_line(text: &str) -> Result<()> {
    let mut stdout = io::stdout().lock();
    match writeln!(stdout, "{text}").and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Error::write(Path::new("standard output"))(error)),
        _ => Ok(()),
    }
}

/// Prints `value` as indented JSON.
pub(super) fn print_json(value: &impl serde::Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value).map_err(io::Error::from);
    print_line(&text.map_err(Error::write(Path::new("standard output")))?)
}
