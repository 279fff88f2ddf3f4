//! Sums of learning targets, added over devices. They are integers, so their total does not depend on the order.

use std::ops::Range;

use crate::generated::layout::RadianceSum;

/// Bins of a block. A rank hands others only the blocks in which a rank has a learning target.
const BLOCK: usize = 64;

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

    /// Bits of the blocks in which there is a learning target.
    pub fn touched_blocks(&self) -> Vec<u32> {
        let mut bits = vec![0; self.counts.len().div_ceil(BLOCK).div_ceil(32)];
        for (number, (counts, targets)) in self.counts.chunks(BLOCK).zip(self.targets.chunks(BLOCK)).enumerate() {
            let is_touched = counts.iter().any(|&count| count != 0) || targets.iter().any(|&sum| sum != 0);
            bits[number / 32] |= u32::from(is_touched) << (number % 32);
        }
        bits
    }

    /// The sums of some blocks of bins, one after the other, and all marks. `flux` is left out.
    pub fn packed(&self, blocks: &[u32]) -> Self {
        let ranges = || ranges(blocks, self.counts.len());
        Self {
            targets: ranges().flat_map(|range| &self.targets[range]).copied().collect(),
            counts: ranges().flat_map(|range| &self.counts[range]).copied().collect(),
            marks: self.marks.clone(),
            flux: Vec::new(),
        }
    }

    /// Replaces the sums of some blocks of bins, and all marks, by those that [`Sums::packed`] has made.
    pub fn unpack(&mut self, blocks: &[u32], packed: Self) {
        let mut begin = 0;
        for range in ranges(blocks, self.counts.len()) {
            let source = begin..begin + range.len();
            begin = source.end;
            self.targets[range.clone()].copy_from_slice(&packed.targets[source.clone()]);
            self.counts[range].copy_from_slice(&packed.counts[source]);
        }
        self.marks = packed.marks;
    }

    /// Adds another's sums.
    pub fn add(&mut self, other: &Self) {
        self.targets.iter_mut().zip(&other.targets).for_each(|(sum, other)| *sum = sum.wrapping_add(*other));
        self.counts.iter_mut().zip(&other.counts).for_each(|(sum, other)| *sum = sum.wrapping_add(*other));
        self.marks.iter_mut().zip(&other.marks).for_each(|(marks, other)| *marks |= other);
    }
}

/// Ranges of bins of the blocks whose bits are set, of so many bins.
fn ranges(blocks: &[u32], bins: usize) -> impl Iterator<Item = Range<usize>> {
    let is_set = |number: &usize| blocks.get(number / 32).is_some_and(|bits| bits >> (number % 32) & 1 != 0);
    (0..bins.div_ceil(BLOCK)).filter(is_set).map(move |number| number * BLOCK..bins.min((number + 1) * BLOCK))
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

    /// Sums of so many bins, with a target in each bin that is named.
    fn with_targets(bins: usize, touched: &[usize]) -> Sums {
        let mut sums = vec![sum(0, 0, 0); bins];
        touched.iter().for_each(|&bin| sums[bin] = sum(bin as u32 + 1, 9, 2));
        Sums::new(&sums, vec![4, 8])
    }

    #[test]
    fn touched_blocks_hold_all_targets() {
        // The last block is not whole.
        let bins = 33 * BLOCK + 5;
        let whole = with_targets(bins, &[0, 3 * BLOCK - 1, 3 * BLOCK, 32 * BLOCK, bins - 1]);
        let blocks = whole.touched_blocks();
        assert_eq!(blocks, [0b1101, 0b11]);
        let packed = whole.packed(&blocks);
        assert_eq!(packed.counts.len(), 4 * BLOCK + 5);
        let mut again = Sums { flux: whole.flux.clone(), ..with_targets(bins, &[]) };
        again.marks = vec![];
        again.unpack(&blocks, packed);
        assert_eq!(again, whole);
    }

    #[test]
    fn no_target_touches_no_block() {
        let sums = with_targets(100, &[]);
        assert_eq!(sums.touched_blocks(), [0]);
        assert!(sums.packed(&[0]).counts.is_empty());
        assert_eq!(Sums::default().touched_blocks(), [0; 0]);
    }
}
