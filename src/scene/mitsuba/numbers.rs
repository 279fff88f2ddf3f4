//! Numbers as Mitsuba writes them: separated by spaces or commas, finite.

use super::element::Element;
use crate::Result;

/// All numbers of `text`; `element` is where to point when one is malformed.
pub(super) fn list(element: &Element, text: &str) -> Result<Vec<f64>> {
    text.split(|c: char| c.is_whitespace() || c == ',')
        .filter(|word| !word.is_empty())
        .map(|word| one(element, word))
        .collect()
}

/// Exactly one number.
pub(super) fn one(element: &Element, text: &str) -> Result<f64> {
    match text.trim().parse::<f64>() {
        // Everything ends as an f32 on the device.
        Ok(value) if (value as f32).is_finite() => Ok(value),
        Ok(_) => Err(element.error(format!("`{text}` is not a finite number"))),
        Err(_) => Err(element.error(format!("`{text}` is not a number"))),
    }
}

/// Exactly three numbers, or one that stands for all three.
pub(super) fn one_or_three(element: &Element, text: &str) -> Result<[f64; 3]> {
    match list(element, text)?[..] {
        [gray] => Ok([gray; 3]),
        [x, y, z] => Ok([x, y, z]),
        _ => Err(element.error(format!("`{text}` should be one number or three"))),
    }
}

/// Exactly three numbers.
pub(super) fn three(element: &Element, text: &str) -> Result<[f64; 3]> {
    match list(element, text)?[..] {
        [x, y, z] => Ok([x, y, z]),
        _ => Err(element.error(format!("`{text}` should be three numbers"))),
    }
}

/// The attributes `x`, `y` and `z`, each with a default, or the attribute `value` in their stead.
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
