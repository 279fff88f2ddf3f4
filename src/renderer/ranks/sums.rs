//! Sums of learning targets, added over devices. They are integers, so their total does not depend on the order.

use crate::generated::layout::RadianceSum;

/// Function that adds another device's sums to a total.
pub type AddSums = fn(&mut [RadianceSum], &[RadianceSum]);

/// Adds another device's sums to `total`.
pub fn add(total: &mut [RadianceSum], sums: &[RadianceSum]) {
    for (total, sum) in total.iter_mut().zip(sums) {
        let wide = |sum: &RadianceSum| u64::from(sum.high) << 32 | u64::from(sum.low);
        // Kernels wrap, too, but a step has far fewer than the 2^32 saturated targets that a sum can hold.
        let added = wide(total).wrapping_add(wide(sum));
        (total.low, total.high) = (added as u32, (added >> 32) as u32);
        total.target_count = total.target_count.wrapping_add(sum.target_count);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(low: u32, high: u32, target_count: u32) -> RadianceSum {
        RadianceSum { low, high, target_count, flux: 0.0 }
    }

    #[test]
    fn low_words_carry_into_high_words() {
        let mut total = [sum(u32::MAX, 1, 3), sum(1, 0, 1)];
        add(&mut total, &[sum(2, 5, 4), sum(1, 0, 1)]);
        let words = total.map(|sum| (sum.low, sum.high, sum.target_count));
        assert_eq!(words, [(1, 7, 7), (2, 0, 2)]);
    }
}
