//! Numbers in text: finite, separated by spaces or commas.

use crate::quoted;

/// Parses all numbers of `text`. The error says what is wrong.
pub(super) fn list(text: &str) -> Result<Vec<f64>, String> {
    words(text).map(one).collect()
}

/// Words of `text` between spaces and commas.
pub(super) fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty())
}

/// Parses exactly one number.
pub(super) fn one(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        // The device uses f32, so the number must be finite as an f32.
        Ok(value) if (value as f32).is_finite() => Ok(value),
        Ok(_) => Err(format!("{} is not a finite number", quoted::word(text))),
        Err(_) => Err(format!("{} is not a number", quoted::word(text))),
    }
}

/// Parses exactly three numbers, or one that stands for all three.
pub(super) fn one_or_three(text: &str) -> Result<[f64; 3], String> {
    match list(text)?[..] {
        [gray] => Ok([gray; 3]),
        [x, y, z] => Ok([x, y, z]),
        _ => Err(format!("{} should be one number or three", quoted::word(text))),
    }
}

/// Parses exactly three numbers.
pub(super) fn three(text: &str) -> Result<[f64; 3], String> {
    match list(text)?[..] {
        [x, y, z] => Ok([x, y, z]),
        _ => Err(format!("{} should be three numbers", quoted::word(text))),
    }
}
