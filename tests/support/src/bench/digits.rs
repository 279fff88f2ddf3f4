//! Numbers in tables.

/// Three significant digits, however small the value, but no digit before the point is left out.
pub fn three_digits(value: f64) -> String {
    let places = (2.0 - value.abs().max(1.0e-9).log10().floor()).max(0.0) as usize;
    format!("{value:.places$}")
}
