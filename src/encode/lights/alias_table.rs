//! Alias tables: draws from a discrete distribution by two look-ups (Walker 1974), built by the method of Vose 1991.

/// Entry of an alias table: taken with probability `threshold / 2^32`, else its alias is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AliasEntry {
    /// Threshold for 32 random bits: values below it take this entry.
    pub threshold: u32,
    /// Index of the entry that is taken otherwise.
    pub alias: u32,
    /// Probability with which the whole table yields this entry, with rounded thresholds.
    pub probability: f32,
}

const WHOLE: f64 = 4_294_967_296.0;

/// Table that yields entries with probabilities proportional to `weights`, which are finite and >= 0. An entry without
/// weight is never drawn. Where all weights are zero, all probabilities are zero.
pub fn alias_table(weights: &[f64]) -> Vec<AliasEntry> {
    let sum: f64 = weights.iter().sum();
    if sum <= 0.0 {
        let entry = |alias: u32| AliasEntry { threshold: u32::MAX, alias, probability: 0.0 };
        return (0..weights.len() as u32).map(entry).collect();
    }
    let mut table = pair_up(weights, sum);
    set_probabilities(&mut table);
    table
}

/// Pairs each entry below the mean weight with an alias above it, which pays the difference.
fn pair_up(weights: &[f64], sum: f64) -> Vec<AliasEntry> {
    let scale = weights.len() as f64 / sum;
    let mut left: Vec<f64> = weights.iter().map(|weight| weight * scale).collect();
    let mut table: Vec<_> =
        (0..weights.len() as u32).map(|alias| AliasEntry { threshold: u32::MAX, alias, probability: 0.0 }).collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..weights.len()).partition(|&i| left[i] < 1.0);
    while let (Some(&poor), Some(&rich)) = (small.last(), large.last()) {
        small.pop();
        table[poor].threshold = (left[poor] * WHOLE) as u32;
        table[poor].alias = rich as u32;
        left[rich] -= 1.0 - left[poor];
        if left[rich] < 1.0 {
            large.pop();
            small.push(rich);
        }
    }
    // Entries are left over by rounding alone. They keep their whole share, except entries without weight.
    let heaviest = (0..weights.len()).max_by(|&a, &b| weights[a].total_cmp(&weights[b])).unwrap_or(0);
    for weightless in small.into_iter().filter(|&i| weights[i] == 0.0) {
        table[weightless].threshold = 0;
        table[weightless].alias = heaviest as u32;
    }
    table
}

fn set_probabilities(table: &mut [AliasEntry]) {
    let mut probabilities = vec![0.0; table.len()];
    for (i, entry) in table.iter().enumerate() {
        let own = f64::from(entry.threshold) / WHOLE;
        probabilities[i] += own;
        probabilities[entry.alias as usize] += 1.0 - own;
    }
    let count = table.len() as f64;
    for (entry, probability) in table.iter_mut().zip(probabilities) {
        entry.probability = (probability / count) as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(weights: &[f64]) {
        let sum: f64 = weights.iter().sum();
        for (entry, weight) in alias_table(weights).iter().zip(weights) {
            let expected = if sum > 0.0 { weight / sum } else { 0.0 };
            assert!((f64::from(entry.probability) - expected).abs() < 1.0e-7, "{weights:?}: {entry:?}");
            assert!(*weight > 0.0 || entry.probability == 0.0, "{weights:?}: {entry:?}");
            assert!((entry.alias as usize) < weights.len());
        }
    }

    #[test]
    fn probabilities_are_the_weights() {
        check(&[]);
        check(&[3.0]);
        check(&[0.0]);
        check(&[0.0, 0.0]);
        check(&[1.0, 0.0, 2.0]);
        check(&[1.0; 7]);
        check(&[0.1, 0.1, 0.1, 1.0e-30, 0.0, 1.0e12]);
        let many: Vec<f64> = (0..1000).map(|i| if i % 3 == 0 { 0.0 } else { f64::from(i * i % 97) + 0.1 }).collect();
        check(&many);
    }
}
