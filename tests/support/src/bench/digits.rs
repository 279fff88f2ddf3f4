//! Formatting of numbers in tables.

/// Number with three significant digits. All digits before the decimal point are kept.
pub fn three_digits(value: f64) -> String {
    let places = (2.0 - value.abs().max(1.0e-9).log10().floor()).max(0.0) as usize;
    format!("{value:.places$}")
}
