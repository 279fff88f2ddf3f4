//! False colors for values that are not colors.

/// Colors from 0 to 1 in equal steps: black, purple, red, yellow, white, in linear sRGB.
const RAMP: [[f64; 3]; 5] = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.2], [0.7, 0.05, 0.02], [1.0, 0.6, 0.05], [1.0, 1.0, 1.0]];

/// Color of a value, clamped to [0, 1], in linear sRGB.
pub fn false_color(value: f64) -> [f32; 3] {
    let at = value.clamp(0.0, 1.0) * (RAMP.len() - 1) as f64;
    let lower = (at as usize).min(RAMP.len() - 2);
    let share = at - lower as f64;
    std::array::from_fn(|c| (RAMP[lower][c] * (1.0 - share) + RAMP[lower + 1][c] * share) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ramp_has_its_ends_and_middle() {
        assert_eq!(
            [-1.0, 0.0, 0.5, 1.0, 9.0].map(false_color),
            [[0.0; 3], [0.0; 3], [0.7, 0.05, 0.02], [1.0; 3], [1.0; 3]]
        );
    }
}
