//! Durations on the command line: `90`, `1.5`, `1m30s`, `2h`.

/// Units in order, with their seconds.
const UNITS: [(&str, f64); 4] = [("d", 86_400.0), ("h", 3600.0), ("m", 60.0), ("s", 1.0)];

/// Seconds of a duration above 0: a number of seconds, or numbers with the units d, h, m and s in this order.
///
/// # Errors
/// A request for a time.
pub fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().or_else(|| with_units(text));
    let seconds = seconds.filter(|seconds: &f64| seconds.is_finite() && *seconds > 0.0);
    seconds.ok_or_else(|| "give a time above 0, such as 90, 90s, 1m30s or 2h".into())
}

fn with_units(text: &str) -> Option<f64> {
    let (mut rest, mut units, mut seconds) = (text, UNITS.iter(), 0.0);
    while !rest.is_empty() {
        let (number, tail) = rest.split_at(rest.find(|c: char| !c.is_ascii_digit() && c != '.')?);
        let end = tail.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(tail.len());
        let (unit, tail) = tail.split_at(end);
        // A unit that has come already is not found again.
        let (_, of_unit) = units.find(|(name, _)| unit.eq_ignore_ascii_case(name))?;
        seconds += number.parse::<f64>().ok()? * of_unit;
        rest = tail;
    }
    Some(seconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_numbers_of_seconds_or_have_units() {
        for (text, expected) in [
            ("90", 90.0),
            ("1.5", 1.5),
            ("1e300", 1e300),
            ("90s", 90.0),
            ("1m30s", 90.0),
            ("2h", 7200.0),
            ("2H", 7200.0),
            ("1.5h", 5400.0),
            ("1d2h3m4.5s", 93_784.5),
            ("1h5s", 3605.0),
        ] {
            assert_eq!(seconds(text), Ok(expected), "{text}");
        }
    }

    #[test]
    fn other_texts_are_refused() {
        for text in
            ["", "0", "-1", "nan", "inf", "0s", "-1m", "m", "1m30", "30s1m", "1m1m", "1x", "1 m", "1..5h", "h1", "1min"]
        {
            assert!(seconds(text).is_err(), "{text}");
        }
    }
}
