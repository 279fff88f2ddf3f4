//! Source files, and their text without comments and the contents of strings.

use std::fs;
use std::path::Path;

/// One source file.
pub struct Source {
    /// Path within the repository, with `/` between the parts.
    pub path: String,
    /// Text without comments and the contents of strings. Line breaks stay.
    pub code: String,
    /// Original text.
    pub text: String,
}

impl Source {
    /// A file with the given text.
    pub fn new(path: &str, text: &str) -> Self {
        Self { path: path.to_owned(), code: strip(text), text: text.to_owned() }
    }
}

/// Every file below `folder` with the given extension, sorted; none where the folder does not exist.
pub fn read_all(root: &Path, folder: &str, extension: &str) -> Vec<Source> {
    let mut sources = Vec::new();
    let Ok(entries) = fs::read_dir(root.join(folder)) else { return sources };
    for entry in entries {
        let entry = entry.unwrap();
        let path = format!("{folder}/{}", entry.file_name().to_str().unwrap());
        if entry.file_type().unwrap().is_dir() {
            sources.extend(read_all(root, &path, extension));
        } else if entry.path().extension().is_some_and(|e| e == extension) {
            sources.push(Source::new(&path, &fs::read_to_string(entry.path()).unwrap()));
        }
    }
    sources.sort_by(|a, b| a.path.cmp(&b.path));
    sources
}

/// The words (identifiers and keywords) of `code`: each with what precedes it, and its line counted from 1.
pub fn words(code: &str) -> impl Iterator<Item = Word<'_>> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut position = 0;
    std::iter::from_fn(move || {
        let start = position + code[position..].find(is_word)?;
        let length = code[start..].find(|c| !is_word(c)).unwrap_or(code.len() - start);
        position = start + length;
        let line = 1 + code[..start].matches('\n').count();
        Some(Word { text: &code[start..position], before: code[..start].trim_end(), after: &code[position..], line })
    })
}

/// A word in its surroundings.
pub struct Word<'a> {
    pub text: &'a str,
    /// Everything before it, without the white space next to it.
    pub before: &'a str,
    /// Everything after it.
    pub after: &'a str,
    pub line: usize,
}

/// Removes comments and the contents of string and character literals of Rust or GLSL.
fn strip(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let skipped = skipped_length(rest, code.chars().next_back());
        if skipped == 0 {
            code.push(first);
            rest = &rest[first.len_utf8()..];
        } else {
            // A space separates the texts on either side.
            code.push(' ');
            code.extend(rest[..skipped].chars().filter(|&c| c == '\n'));
            rest = &rest[skipped..];
        }
    }
    code
}

/// Length of the comment or literal that `rest` starts with; 0 where it starts with neither.
fn skipped_length(rest: &str, previous: Option<char>) -> usize {
    let within_word = previous.is_some_and(|c| c.is_alphanumeric() || c == '_');
    if rest.starts_with("//") {
        rest.find('\n').unwrap_or(rest.len())
    } else if rest.starts_with("/*") {
        block_comment_length(rest)
    } else if rest.starts_with('"') {
        quoted_length(rest, '"').unwrap_or(rest.len())
    } else if !within_word && (rest.starts_with("r\"") || rest.starts_with("r#")) {
        raw_string_length(rest)
    } else if rest.starts_with('\'') {
        character_length(rest)
    } else {
        0
    }
}

/// Rust's block comments nest.
fn block_comment_length(rest: &str) -> usize {
    let (mut depth, mut position) = (0, 0);
    while position < rest.len() {
        if rest[position..].starts_with("/*") {
            (depth, position) = (depth + 1, position + 2);
        } else if rest[position..].starts_with("*/") {
            (depth, position) = (depth - 1, position + 2);
        } else {
            position += rest[position..].chars().next().map_or(1, char::len_utf8);
        }
        if depth == 0 {
            break;
        }
    }
    position
}

fn quoted_length(rest: &str, quote: char) -> Option<usize> {
    let mut escaped = false;
    for (position, c) in rest.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            c if c == quote => return Some(position + c.len_utf8()),
            _ => {}
        }
    }
    None
}

/// Length of `r"..."` or `r#"..."#`; 0 for a raw identifier such as `r#type`.
fn raw_string_length(rest: &str) -> usize {
    let hashes = rest[1..].chars().take_while(|&c| c == '#').count();
    if !rest[1 + hashes..].starts_with('"') {
        return 0;
    }
    let end = format!("\"{}", "#".repeat(hashes));
    let start = 2 + hashes;
    rest[start..].find(&end).map_or(rest.len(), |length| start + length + end.len())
}

/// Length of a character literal; 0 for a lifetime such as `'a`.
fn character_length(rest: &str) -> usize {
    let mut characters = rest.chars().skip(1);
    match (characters.next(), characters.next()) {
        (Some('\\'), _) => quoted_length(rest, '\'').unwrap_or(0),
        (Some(c), Some('\'')) => 2 + c.len_utf8(),
        _ => 0,
    }
}

#[test]
fn strips_comments_and_literals_only() {
    for (text, expected) in [
        ("a // b\nc", "a  \nc"),
        ("a /* b /* c */ d\n */ e", "a  \n e"),
        ("f(\"x // y\\\" z\") g", "f( ) g"),
        ("r#\"a \" b\"# c", "  c"),
        ("for r in r#type", "for r in r#type"),
        ("'\\'' '\"' &'a str", "    &'a str"),
        ("url(\"// \") // \"\nend", "url( )  \nend"),
    ] {
        assert_eq!(strip(text), expected, "{text}");
    }
}

#[test]
fn words_are_whole_and_know_their_line() {
    let found: Vec<_> = words("use ash::vk;\nlet ash_tray = 1;").map(|word| (word.text, word.line)).collect();
    assert_eq!(found, [("use", 1), ("ash", 1), ("vk", 1), ("let", 2), ("ash_tray", 2), ("1", 2)]);
}
