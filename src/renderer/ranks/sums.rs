//! Sums of learning targets, added over devices. They are integers, so their total does not depend on the order.

use crate::generated::layout::RadianceSum;

/// Function that adds another device's sums to a total.
pub type AddSums = fn(&mut Sums, &Sums);

/// Adds another device's sums to `total`.
pub fn add(total: &mut Sums, sums: &Sums) {
    total.add(sums);
}

/// Sums of one device or of several.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sums {
    /// 64-bit fixed-point sums of learning targets. They wrap, as those of kernels do.
    pub targets: Vec<u64>,
    /// Numbers of learning targets.
    pub counts: Vec<u32>,
    /// Bits that are set where one device has set them: the normalizers that a device has asked for.
    pub marks: Vec<u32>,
    /// Flux of quadtrees' nodes. All devices have the same, so it is not added.
    pub flux: Vec<f32>,
}

impl Sums {
    /// The sums of a device, and its marks of normalizers.
    pub fn new(sums: &[RadianceSum], marks: Vec<u32>) -> Self {
        let targets = sums.iter().map(|sum| u64::from(sum.high) << 32 | u64::from(sum.low)).collect();
        let counts = sums.iter().map(|sum| sum.target_count).collect();
        Self { targets, counts, marks, flux: sums.iter().map(|sum| sum.flux).collect() }
    }

    /// The sums in the layout of a device.
    pub fn of_device(&self) -> Vec<RadianceSum> {
        let numbers = self.targets.iter().zip(&self.counts).zip(&self.flux);
        let sum = |((&targets, &target_count), &flux): ((&u64, &u32), &f32)| RadianceSum {
            low: targets as u32,
            high: (targets >> 32) as u32,
            target_count,
            flux,
        };
        numbers.map(sum).collect()
    }

    /// Bytes that are handed to others.
    pub fn len_bytes(&self) -> usize {
        size_of_val(&self.targets[..]) + size_of_val(&self.counts[..]) + size_of_val(&self.marks[..])
    }

    /// Adds another's sums.
    pub fn add(&mut self, other: &Self) {
        self.targets.iter_mut().zip(&other.targets).for_each(|(sum, other)| *sum = sum.wrapping_add(*other));
        self.counts.iter_mut().zip(&other.counts).for_each(|(sum, other)| *sum = sum.wrapping_add(*other));
        self.marks.iter_mut().zip(&other.marks).for_each(|(marks, other)| *marks |= other);
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
        let mut total = Sums::new(&[sum(u32::MAX, 1, 3), sum(1, 0, 1)], vec![1]);
        add(&mut total, &Sums::new(&[sum(2, 5, 4), sum(1, 0, 1)], vec![6]));
        let words: Vec<_> = total.of_device().iter().map(|sum| (sum.low, sum.high, sum.target_count)).collect();
        assert_eq!(words, [(1, 7, 7), (2, 0, 2)]);
        assert_eq!(total.marks, [7]);
    }
}
