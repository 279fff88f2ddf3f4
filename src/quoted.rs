//! Words of files, as messages quote them. A scene may name any file that its reader may read, and a message may go to others, so a
//! message quotes one short word of a file and never a line.

/// Most characters of a word that a message quotes: a number has as many, and a line of a list of passwords has more.
const MOST_CHARACTERS: usize = 24;

/// The word between backticks if it is short and printable, or else a phrase that says how long it is.
pub fn word(word: &str) -> String {
    match is_quotable(word) {
        true => format!("`{word}`"),
        false => {
            let count = word.chars().count();
            let what = if word.chars().any(char::is_control) { "a word with control characters" } else { "a word" };
            format!("{what} of {count} characters")
        }
    }
}

/// A word of a file that may be no text.
pub fn bytes(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => word(text),
        Err(_) => format!("a word of {} bytes that are no text", bytes.len()),
    }
}

/// A number of bytes in the unit that people use: `900 bytes`, `12 kB`, `3.5 MB`, `17 GB`. A unit is 1000 times the one before.
pub fn size(bytes: u64) -> String {
    let units = ["bytes", "kB", "MB", "GB", "TB", "PB", "EB"];
    let (mut value, mut unit) = (bytes as f64, 0);
    while value >= 999.5 && unit + 1 < units.len() {
        (value, unit) = (value / 1000.0, unit + 1);
    }
    let digits = usize::from(unit > 0 && value < 9.95);
    format!("{value:.digits$} {}", units[unit])
}

/// The message of another library, in one line. What it quotes is replaced by dots, unless all of it is short and printable.
pub fn message(error: &impl std::fmt::Display) -> String {
    let text = error.to_string();
    let is_quote = |c: char| matches!(c, '"' | '`' | '\'');
    let is_space = |c: char| c.is_whitespace() || c.is_control();
    let line = |text: &str| text.split(is_space).filter(|word| !word.is_empty()).collect::<Vec<_>>().join(" ");
    match (text.find(is_quote), text.rfind(is_quote)) {
        (Some(begin), Some(end)) if !is_quotable(&text[begin + 1..end.max(begin + 1)]) => {
            line(&format!("{}...{}", &text[..=begin], &text[end..]))
        }
        _ => line(&text),
    }
}

fn is_quotable(word: &str) -> bool {
    word.chars().count() <= MOST_CHARACTERS && !word.chars().any(char::is_control)
}

#[test]
fn long_words_and_strange_ones_are_described() {
    assert_eq!(word("root:x:0"), "`root:x:0`");
    assert_eq!(word(&"\u{e4}".repeat(24)), format!("`{}`", "\u{e4}".repeat(24)));
    assert_eq!(word(&"x".repeat(3000)), "a word of 3000 characters");
    assert_eq!(word("A=1\0B=2"), "a word with control characters of 7 characters");
    assert_eq!(bytes(b"1.5"), "`1.5`");
    assert_eq!(bytes(&[0xff; 9]), "a word of 9 bytes that are no text");
}

#[test]
fn messages_of_others_quote_as_little() {
    assert_eq!(message(&"expected `,` at\n line 3"), "expected `,` at line 3");
    let long = format!("invalid type: string \"{}\", expected u32", "x\"'".repeat(20));
    assert_eq!(message(&long), "invalid type: string \"...\", expected u32");
    assert_eq!(message(&"one ' only"), "one ' only");
    assert_eq!(message(&"a\0b"), "a b");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_two_or_three_digits() {
        let sizes = [0, 999, 1000, 9_949, 9_951, 999_499, 999_501, 12_600_000_000, u64::MAX];
        let words = ["0 bytes", "999 bytes", "1.0 kB", "9.9 kB", "10 kB", "999 kB", "1.0 MB", "13 GB", "18 EB"];
        assert_eq!(sizes.map(size), words);
    }
}
