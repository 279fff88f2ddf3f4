//! Tables of text cells, written as Markdown and as CSV.

use std::io::Write;
use std::path::Path;

use crate::Result;
use crate::files;

/// Table. Every row is as long as the header.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Sheet {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Sheet {
    /// Creates a table without rows.
    pub fn new(header: impl IntoIterator<Item = impl Into<String>>) -> Self {
        Self { header: header.into_iter().map(Into::into).collect(), rows: Vec::new() }
    }

    /// Adds a row.
    pub fn push(&mut self, row: impl IntoIterator<Item = impl Into<String>>) {
        self.rows.push(row.into_iter().map(Into::into).collect());
    }

    /// Table as Markdown. All columns but the first are right-aligned.
    pub fn markdown(&self) -> String {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let rule = format!("|---|{}\n", "---:|".repeat(self.header.len().saturating_sub(1)));
        let rows: String = self.rows.iter().map(|row| line(row)).collect();
        format!("{}{rule}{rows}", line(&self.header))
    }

    /// Table as comma-separated values (RFC 4180, with bare line feeds).
    pub fn csv(&self) -> String {
        let line =
            |cells: &Vec<String>| format!("{}\n", cells.iter().map(|cell| quoted(cell)).collect::<Vec<_>>().join(","));
        [&self.header].into_iter().chain(&self.rows).map(line).collect()
    }
}

fn quoted(cell: &str) -> String {
    match cell.contains([',', '"', '\n']) {
        true => format!("\"{}\"", cell.replace('"', "\"\"")),
        false => cell.to_owned(),
    }
}

/// Writes a text file in one piece, so that no half-written file remains.
///
/// # Errors
/// Fails if the file cannot be written.
pub fn write(path: &Path, text: &str) -> Result<()> {
    files::write_whole(path, |writer| writer.write_all(text.as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_hold_the_cells() {
        let mut sheet = Sheet::new(["scene", "sphere, inversion"]);
        sheet.push(["a \"b\"", "0.5"]);
        assert_eq!(sheet.markdown(), "| scene | sphere, inversion |\n|---|---:|\n| a \"b\" | 0.5 |\n");
        assert_eq!(sheet.csv(), "scene,\"sphere, inversion\"\n\"a \"\"b\"\"\",0.5\n");
    }
}
