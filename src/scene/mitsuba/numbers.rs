//! Numbers as Mitsuba writes them: finite, separated by spaces or commas.

use super::element::Element;
use crate::{Result, quoted};

/// Parses all numbers of `text`. Errors point at `element`.
pub(super) fn list(element: &Element, text: &str) -> Result<Vec<f64>> {
    text.split(|c: char| c.is_whitespace() || c == ',')
        .filter(|word| !word.is_empty())
        .map(|word| one(element, word))
        .collect()
}

/// Parses exactly one number.
pub(super) fn one(element: &Element, text: &str) -> Result<f64> {
    match text.trim().parse::<f64>() {
        // The device uses f32, so the number must be finite as an f32.
        Ok(value) if (value as f32).is_finite() => Ok(value),
        Ok(_) => Err(element.error(format!("{} is not a finite number", quoted::word(text)))),
        Err(_) => Err(element.error(format!("{} is not a number", quoted::word(text)))),
    }
}

/// Parses exactly three numbers, or one that stands for all three.
pub(super) fn one_or_three(element: &Element, text: &str) -> Result<[f64; 3]> {
    match list(element, text)?[..] {
        [gray] => Ok([gray; 3]),
        [x, y, z] => Ok([x, y, z]),
        _ => Err(element.error(format!("{} should be one number or three", quoted::word(text)))),
    }
}

/// Parses exactly three numbers.
pub(super) fn three(element: &Element, text: &str) -> Result<[f64; 3]> {
    match list(element, text)?[..] {
        [x, y, z] => Ok([x, y, z]),
        _ => Err(element.error(format!("{} should be three numbers", quoted::word(text)))),
    }
}

/// Parses the attributes `x`, `y` and `z`, each with a default, or else the attribute `value`.
pub(super) fn xyz(element: &Element, default: f64) -> Result<[f64; 3]> {
    if let Some(value) = element.attribute("value") {
        return three(element, value);
    }
    let mut result = [default; 3];
    for (component, name) in result.iter_mut().zip(["x", "y", "z"]) {
        if let Some(text) = element.attribute(name) {
            *component = one(element, text)?;
        }
    }
    Ok(result)
}
