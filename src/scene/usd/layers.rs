//! Checks of layers before they are parsed.

use super::crates;
use super::names::check_name;

/// Deepest nesting of brackets in a layer of text, which the parser follows by recursion.
const MAX_DEPTH: usize = 512;

/// First bytes of a binary layer.
const MAGIC: &[u8] = b"PXR-USDC";

/// Checks a layer of text or of binary form. The error says what is wrong.
pub(super) fn check(bytes: &[u8]) -> Result<(), String> {
    match bytes.starts_with(MAGIC) {
        true => crates::check(bytes),
        false => check_text(bytes),
    }
}

/// Refuses text whose brackets are nested too deep, and paths and names with characters that they never have. The parser does not end on
/// some of them.
fn check_text(text: &[u8]) -> Result<(), String> {
    let (mut depth, mut at) = (0_usize, 0);
    // Whether the next string is the name of a prim.
    let mut is_name = false;
    while let Some(&byte) = text.get(at) {
        let rest = &text[at..];
        let length = match byte {
            b'#' => rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len()),
            b'/' if rest.starts_with(b"/*") => through(rest, 2, b"*/"),
            b'"' if rest.starts_with(b"\"\"\"") => through(rest, 3, b"\"\"\""),
            b'\'' if rest.starts_with(b"\'\'\'") => through(rest, 3, b"\'\'\'"),
            b'@' if rest.starts_with(b"@@@") => through(rest, 3, b"@@@"),
            b'@' => through(rest, 1, b"@"),
            b'"' | b'\'' => string(rest),
            b'<' => {
                let is_strange =
                    |byte: &u8| byte.is_ascii_whitespace() || byte.is_ascii_control() || b"<\"@".contains(byte);
                match rest[1..].iter().position(|byte| *byte == b'>' || is_strange(byte)) {
                    Some(length) if rest[1 + length] == b'>' => {
                        check_name(&rest[1..=length])?;
                        length + 2
                    }
                    _ => return Err("a path between < and > in it is not closed".to_owned()),
                }
            }
            b'{' | b'[' | b'(' => {
                depth += 1;
                1
            }
            b'}' | b']' | b')' => {
                depth = depth.saturating_sub(1);
                1
            }
            byte if byte.is_ascii_alphanumeric() || byte == b'_' => {
                let is_word = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
                let length = rest.iter().position(|byte| !is_word(byte)).unwrap_or(rest.len());
                is_name |= [&b"def"[..], b"over", b"class", b"defaultPrim"].contains(&&rest[..length]);
                length
            }
            _ => 1,
        };
        if matches!(byte, b'"' | b'\'') && std::mem::take(&mut is_name) {
            check_name(&rest[..length])?;
        }
        is_name &= !b"{}[]()<@;".contains(&byte);
        at += length;
        if depth > MAX_DEPTH {
            return Err(format!("its brackets are nested more than {MAX_DEPTH} deep"));
        }
    }
    Ok(())
}

/// Bytes up to the next `end` and with it, from `from` on; all bytes where there is none.
fn through(text: &[u8], from: usize, end: &[u8]) -> usize {
    let inner = text.get(from..).unwrap_or_default();
    inner.windows(end.len()).position(|window| window == end).map_or(text.len(), |at| from + at + end.len())
}

/// Bytes of a string between quotes, in which a backslash escapes one.
fn string(text: &[u8]) -> usize {
    let mut at = 1;
    while let Some(&byte) = text.get(at) {
        match byte {
            b'\\' => at += 2,
            _ if byte == text[0] => return at + 1,
            _ => at += 1,
        }
    }
    text.len()
}
