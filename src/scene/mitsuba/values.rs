//! Typed values of elements.

use super::element::Element;
use crate::quoted;
use crate::scene::description::kinds::Type;
use crate::scene::description::object::{Fault, Spectrum, Value};
use crate::scene::description::origin::{Format, snake_case};
use crate::scene::description::transform::{Operation, Transform, odd_length};
use crate::scene::numbers;

/// Message about an attribute that an element lacks.
pub(super) fn lacks(element: &Element, attribute: &str) -> String {
    format!("<{}> lacks its attribute `{attribute}`", element.tag)
}

/// Value of a parameter of that type. The error says what is wrong with it.
pub(super) fn parameter(of: Type, element: &Element) -> Result<Value, String> {
    let text = || element.attribute("value").ok_or_else(|| lacks(element, "value"));
    let key = || snake_case(element.attribute("name").unwrap_or_default());
    Ok(match of {
        Type::Boolean => match text()?.trim().to_ascii_lowercase().as_str() {
            "true" => Value::Boolean(true),
            "false" => Value::Boolean(false),
            text => return Err(format!("`{}` should be `true` or `false`, not {}", key(), quoted::word(text))),
        },
        Type::Integer => match text()?.trim().parse() {
            Ok(value) => Value::Integer(value),
            Err(_) => return Err(format!("`{}`: {} is not an integer", key(), quoted::word(text()?))),
        },
        Type::Float => Value::Float(numbers::one(text()?)?),
        Type::String => Value::Text(text()?.to_owned()),
        Type::Point => Value::Point(xyz(element, 0.0)?),
        Type::Vector => Value::Vector(xyz(element, 0.0)?),
        Type::Rgb => match text()?.trim().starts_with('#') {
            true => return Err(format!("{} in <rgb>: hex digits need <srgb>", quoted::word(text()?))),
            false => Value::Rgb(numbers::one_or_three(text()?)?),
        },
        Type::Srgb => match text()?.trim().strip_prefix('#') {
            Some(digits) => Value::Srgb(hex(digits)?),
            None => Value::Srgb(numbers::one_or_three(text()?)?),
        },
        Type::Spectrum => Value::Spectrum(spectrum_of(element)?),
        Type::Transform => transform(element),
        Type::Blackbody => return Err("<blackbody> is not supported; give the color as <rgb>".to_owned()),
        Type::Animation => animation(element),
    })
}

/// Numbers of the attributes `x`, `y` and `z`, each with a default, or else of the attribute `value`.
fn xyz(element: &Element, default: f64) -> Result<[f64; 3], String> {
    if let Some(value) = element.attribute("value") {
        return numbers::three(value);
    }
    let mut result = [default; 3];
    for (component, name) in result.iter_mut().zip(["x", "y", "z"]) {
        if let Some(text) = element.attribute(name) {
            *component = numbers::one(text)?;
        }
    }
    Ok(result)
}

fn hex(digits: &str) -> Result<[f64; 3], String> {
    let malformed = || format!("{} should be # and six hexadecimal digits", quoted::word(&format!("#{digits}")));
    let bits = u32::from_str_radix(digits, 16).map_err(|_| malformed())?;
    if digits.len() != 6 {
        return Err(malformed());
    }
    Ok([bits >> 16, bits >> 8 & 255, bits & 255].map(|channel| f64::from(channel) / 255.0))
}

fn spectrum_of(element: &Element) -> Result<Spectrum, String> {
    match (element.attribute("value"), element.attribute("filename")) {
        (Some(value), None) => spectrum_of_text(value, Format::Xml),
        (None, Some(name)) => Ok(Spectrum::File(name.to_owned())),
        _ => Err("a <spectrum> needs either its attribute `value` or `filename`".to_owned()),
    }
}

/// Spectrum of one number, of three, or of pairs.
pub(super) fn spectrum_of_text(text: &str, format: Format) -> Result<Spectrum, String> {
    if text.contains(':') {
        return pairs(text, format).map(Spectrum::Points);
    }
    match numbers::list(text)?[..] {
        [value] => Ok(Spectrum::Uniform(value)),
        // Mitsuba 0.6 accepts three numbers as a color.
        [red, green, blue] => Ok(Spectrum::Rgb([red, green, blue])),
        _ => Err(format!("{} should be one number, three, or wavelength:value pairs", quoted::word(text))),
    }
}

/// Pairs such as `400:0.1, 500:0.2`.
fn pairs(text: &str, format: Format) -> Result<Vec<[f64; 2]>, String> {
    let pair = |word: &str| {
        let (wavelength, value) = word.split_once(':').ok_or_else(|| {
            format!("{} in a {} should be wavelength:value", quoted::word(word), format.word("spectrum"))
        })?;
        Ok([numbers::one(wavelength)?, numbers::one(value)?])
    };
    numbers::words(text).map(pair).collect()
}

/// A `<transform>`. Its first faulty operation stands for the whole.
fn transform(element: &Element) -> Value {
    let operations = element.children.iter().map(|child| {
        let made = operation(child).and_then(|made| made.matrix(Format::Xml).map(|_| made));
        made.map_err(|message| Fault { of: Some(Type::Transform), message, origin: Some(child.location.clone()) })
    });
    match operations.collect() {
        Ok(operations) => Value::Transform(Transform { operations }),
        Err(fault) => Value::Fault(Box::new(fault)),
    }
}

/// An `<animation>`: transforms, each with its time. Its first faulty one stands for the whole.
fn animation(element: &Element) -> Value {
    let fault = |child: &Element, message: String| {
        let origin = Some(child.location.clone());
        Value::Fault(Box::new(Fault { of: Some(Type::Animation), message, origin }))
    };
    let mut keys = Vec::new();
    for child in &element.children {
        if child.tag != "transform" {
            return fault(child, format!("an <animation> has one <transform> for each time, not a <{}>", child.tag));
        }
        let time = child.attribute("time").ok_or_else(|| lacks(child, "time"));
        match (time.and_then(numbers::one), transform(child)) {
            (Ok(time), Value::Transform(transform)) => keys.push((time, transform)),
            (Err(message), _) => return fault(child, message),
            (_, Value::Fault(mut inner)) => {
                inner.of = Some(Type::Animation);
                return Value::Fault(inner);
            }
            (_, other) => return other,
        }
    }
    match keys.is_empty() {
        true => fault(element, "an <animation> needs a <transform> with its `time`".to_owned()),
        false => Value::Animation(keys),
    }
}

fn operation(element: &Element) -> Result<Operation, String> {
    let text = |name: &str| element.attribute(name).ok_or_else(|| lacks(element, name));
    Ok(match &*element.tag {
        "translate" => Operation::Translate(xyz(element, 0.0)?),
        "scale" => Operation::Scale(match element.attribute("value") {
            Some(value) => numbers::one_or_three(value)?,
            None => xyz(element, 1.0)?,
        }),
        "rotate" => {
            let (axis, degrees) = (xyz(element, 0.0)?, numbers::one(text("angle")?)?);
            match element.is_old {
                true => Operation::old_rotation(axis, degrees),
                false => Operation::Rotate { axis, degrees },
            }
        }
        "lookat" => Operation::LookAt {
            origin: numbers::three(text("origin")?)?,
            target: numbers::three(text("target")?)?,
            up: numbers::three(text("up")?)?,
        },
        "matrix" => Operation::Matrix(rows(&numbers::list(text("value")?)?)?),
        tag => return Err(format!("<{tag}> is not a transform operation")),
    })
}

/// Four rows of a matrix of 16 numbers, or of 9 that leave the last row and column out.
pub(super) fn rows(values: &[f64]) -> Result<[f64; 16], String> {
    match *values {
        [a, b, c, d, e, f, g, h, i] => Ok([a, b, c, 0.0, d, e, f, 0.0, g, h, i, 0.0, 0.0, 0.0, 0.0, 1.0]),
        _ => values.try_into().map_err(|_| format!("a <matrix> has 16 or 9 numbers, not {}", values.len())),
    }
}

/// Warning about an element that versions of Mitsuba understand differently: a rotation about an axis whose length is
/// not 1.
pub(super) fn rotation_warning(element: &Element) -> Option<String> {
    let length = odd_length((element.tag == "rotate").then(|| xyz(element, 0.0).ok())??)?;
    let what = match element.is_old {
        true => "is normalized, as in Mitsuba 0.6; Mitsuba 3 scales the shape",
        false => "scales the shape, as in Mitsuba 3; give the axis the length 1 to rotate only",
    };
    Some(format!("{}: the axis of this <rotate> has the length {length:.4}. It {what}", element.location))
}
