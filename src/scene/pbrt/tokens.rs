//! Words of a `.pbrt` file, with their lines.

use std::borrow::Cow;
use std::fmt;
use std::path::Path;
use std::sync::Arc;

use crate::{Error, Result, quoted};

/// Line of a file.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Place {
    pub file: Arc<Path>,
    pub line: u32,
}

impl Place {
    pub fn error(&self, message: impl Into<String>) -> Error {
        Error::scene(&self.file, Some(self.line), message)
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.file.display(), self.line)
    }
}

/// Smallest part of a file that has a meaning.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Token<'a> {
    /// Name of a directive, number, or `true` or `false`.
    Word(&'a str),
    /// Text between quotes.
    Quoted(Cow<'a, str>),
    /// `[`
    Open,
    /// `]`
    Close,
}

impl fmt::Display for Token<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Word(word) => f.write_str(&quoted::word(word)),
            Self::Quoted(text) => match quoted::word(text) {
                word if word.starts_with('`') => write!(f, "\"{text}\""),
                word => f.write_str(&word),
            },
            Self::Open => f.write_str("`[`"),
            Self::Close => f.write_str("`]`"),
        }
    }
}

/// Beginning of a text, for messages.
pub(super) fn brief(text: &str) -> String {
    const LENGTH: usize = 40;
    let plain = |c: char| if c.is_control() { ' ' } else { c };
    match text.char_indices().nth(LENGTH) {
        None => text.chars().map(plain).collect(),
        Some((end, _)) => text[..end].chars().map(plain).chain("...".chars()).collect(),
    }
}

/// Reader of the tokens of one file.
pub(super) struct Tokens<'a> {
    text: &'a str,
    at: usize,
    line: u32,
    file: Arc<Path>,
    /// Token that was looked at, but not yet taken, and its line.
    ahead: Option<(Token<'a>, u32)>,
    /// Line of the last token taken.
    last: u32,
}

impl<'a> Tokens<'a> {
    pub fn new(text: &'a str, file: Arc<Path>) -> Self {
        Self { text, at: 0, line: 1, file, ahead: None, last: 1 }
    }

    /// Place of the token that was taken last.
    pub fn place(&self) -> Place {
        Place { file: Arc::clone(&self.file), line: self.last }
    }

    /// Takes the next token; `None` at the file's end.
    pub fn take(&mut self) -> Result<Option<Token<'a>>> {
        let (token, line) = match self.ahead.take() {
            Some(ahead) => ahead,
            None => match self.read()? {
                Some(read) => read,
                None => return Ok(None),
            },
        };
        self.last = line;
        Ok(Some(token))
    }

    /// The next token, which is not taken.
    pub fn peek(&mut self) -> Result<Option<&Token<'a>>> {
        if self.ahead.is_none() {
            self.ahead = self.read()?;
        }
        Ok(self.ahead.as_ref().map(|(token, _)| token))
    }

    /// Takes the next token, which must be there. `what` says what it should be.
    pub fn require(&mut self, what: &str) -> Result<Token<'a>> {
        self.take()?
            .ok_or_else(|| self.place().error(format!("the file ends where {what} should be: is it cut short?")))
    }

    /// Takes a text between quotes.
    pub fn quoted(&mut self, what: &str) -> Result<Cow<'a, str>> {
        match self.require(what)? {
            Token::Quoted(text) => Ok(text),
            other => Err(self.place().error(format!("{what} should stand here between quotes, not {other}"))),
        }
    }

    /// Takes `N` numbers, which may stand between brackets.
    pub fn numbers<const N: usize>(&mut self, directive: &str) -> Result<[f64; N]> {
        let what = format!("one of the {N} numbers of {directive}");
        let has_brackets = self.peek()? == Some(&Token::Open);
        if has_brackets {
            self.take()?;
        }
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            let token = self.require(&what)?;
            *number = self.number(&token).ok_or_else(|| self.place().error(format!("{token} is not {what}")))?;
        }
        if has_brackets {
            match self.require("`]`")? {
                Token::Close => {}
                other => {
                    return Err(self
                        .place()
                        .error(format!("{directive} has {N} numbers; `]` should follow, not {other}")));
                }
            }
        }
        Ok(numbers)
    }

    /// Number that a token writes; `None` where it is none, or not finite in single precision.
    pub fn number(&self, token: &Token) -> Option<f64> {
        let Token::Word(word) = token else { return None };
        let is_numeral = word.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
        let number: f64 = if is_numeral { word.parse().ok()? } else { return None };
        (number as f32).is_finite().then_some(number)
    }

    fn read(&mut self) -> Result<Option<(Token<'a>, u32)>> {
        let bytes = self.text.as_bytes();
        loop {
            match bytes.get(self.at) {
                None => return Ok(None),
                Some(b'\n') => self.line = self.line.saturating_add(1),
                Some(b' ' | b'\t' | b'\r' | 0x0c) => {}
                Some(b'#') => {
                    while bytes.get(self.at + 1).is_some_and(|&byte| byte != b'\n') {
                        self.at += 1;
                    }
                }
                Some(_) => break,
            }
            self.at += 1;
        }
        let (begin, line) = (self.at, self.line);
        let token = match bytes[begin] {
            b'[' => Token::Open,
            b']' => Token::Close,
            b'"' => return self.read_quoted().map(|text| Some((Token::Quoted(text), line))),
            _ => {
                let is_end = |byte: &u8| byte.is_ascii_whitespace() || b"[]\"#".contains(byte);
                let length = bytes[begin..].iter().position(is_end).unwrap_or(bytes.len() - begin);
                self.at += length;
                return Ok(Some((Token::Word(&self.text[begin..self.at]), line)));
            }
        };
        self.at += 1;
        Ok(Some((token, line)))
    }

    /// Reads a text from its opening quote on. A text ends on its line.
    fn read_quoted(&mut self) -> Result<Cow<'a, str>> {
        let place = Place { file: Arc::clone(&self.file), line: self.line };
        let rest = &self.text[self.at + 1..];
        let mut is_escaped = false;
        let mut end = None;
        for (at, byte) in rest.bytes().enumerate() {
            match byte {
                b'\n' => return Err(place.error("a text between quotes does not end on its line")),
                _ if is_escaped => is_escaped = false,
                b'\\' => is_escaped = true,
                b'"' => {
                    end = Some(at);
                    break;
                }
                _ => {}
            }
        }
        let end = end.ok_or_else(|| place.error("a text between quotes does not end: is the file cut short?"))?;
        self.at += end + 2;
        let text = &rest[..end];
        if text.contains('\\') { unescaped(text, &place).map(Cow::Owned) } else { Ok(Cow::Borrowed(text)) }
    }
}

/// Text with its escapes replaced.
fn unescaped(text: &str, place: &Place) -> Result<String> {
    let mut result = String::with_capacity(text.len());
    let mut chars = text.chars();
    while let Some(c) = chars.next() {
        if c != '\\' {
            result.push(c);
            continue;
        }
        result.push(match chars.next() {
            Some('n') => '\n',
            Some('t') => '\t',
            Some('r') => '\r',
            Some('b') => '\u{8}',
            Some('f') => '\u{c}',
            Some(c @ ('\\' | '\'' | '"')) => c,
            other => {
                let other = other.map_or_else(String::new, |c| c.to_string());
                return Err(place.error(format!("`\\{other}` in a text is not known; write a backslash as `\\\\`")));
            }
        });
    }
    Ok(result)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_and_their_lines() {
        let text = "Shape \"a\\\"b\" # \"comment\"\n[ 1.5e0 -2]true";
        let mut tokens = Tokens::new(text, Arc::from(Path::new("a.pbrt")));
        let mut found = Vec::new();
        while let Some(token) = tokens.take().unwrap() {
            found.push((token.to_string(), tokens.place().line));
        }
        let expected =
            [("`Shape`", 1), ("\"a\"b\"", 1), ("`[`", 2), ("`1.5e0`", 2), ("`-2`", 2), ("`]`", 2), ("`true`", 2)];
        assert_eq!(found, expected.map(|(token, line)| (token.to_owned(), line)));
    }

    #[test]
    fn faults_name_the_line() {
        for (text, expected) in [
            ("\n\"open", "a.pbrt:2: a text between quotes does not end: is the file cut short?"),
            ("\"a\\qb\"", "a.pbrt:1: `\\q` in a text is not known; write a backslash as `\\\\`"),
        ] {
            let error = Tokens::new(text, Arc::from(Path::new("a.pbrt"))).take().unwrap_err();
            assert_eq!(error.to_string(), expected);
        }
        let mut tokens = Tokens::new("1 inf", Arc::from(Path::new("a.pbrt")));
        let error = tokens.numbers::<2>("Scale").unwrap_err();
        assert_eq!(error.to_string(), "a.pbrt:1: `inf` is not one of the 2 numbers of Scale");
    }
}
