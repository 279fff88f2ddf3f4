//! Samples that a picture holds, as ranges of sample numbers.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::settings::Settings;

/// Ranges of sample numbers by seed, written as `7:0..64, 7:128..192`. They are sorted and disjoint; touching ranges
/// are joined.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SampleRanges(Vec<SeededRange>);

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct SeededRange {
    seed: u32,
    /// Sample numbers in 64 bits, because the end may be 2^32.
    samples: Range<u64>,
}

impl SampleRanges {
    /// Sample range of a render's picture, of which no pixel has more than `most` samples. Pixels have fewer where a step was
    /// stopped.
    pub fn of_picture(most: u32, settings: &Settings) -> Self {
        let first = u64::from(settings.sample_offset.unwrap_or(0));
        Self(vec![SeededRange { seed: settings.seed, samples: first..first + u64::from(most) }])
    }

    /// Sample range of a render's first `samples` samples per pixel.
    pub fn of_render(settings: &Settings, samples: u32) -> Self {
        let first = u64::from(settings.sample_offset.unwrap_or(0));
        let samples = first..first + u64::from(samples);
        Self(if samples.is_empty() { Vec::new() } else { vec![SeededRange { seed: settings.seed, samples }] })
    }

    /// Number after the last sample of a seed; `None` where there is no sample of it.
    pub fn end(&self, seed: u32) -> Option<u64> {
        self.0.iter().filter(|range| range.seed == seed).map(|range| range.samples.end).max()
    }

    /// First range of samples that both hold, as text; `None` where they are disjoint.
    pub fn overlap(&self, other: &Self) -> Option<String> {
        // Both are sorted, so one walk through both finds the first pair.
        let (mut ours, mut theirs) = (self.0.iter().peekable(), other.0.iter().peekable());
        while let (Some(a), Some(b)) = (ours.peek(), theirs.peek()) {
            let (start, end) = (a.samples.start.max(b.samples.start), a.samples.end.min(b.samples.end));
            if a.seed == b.seed && start < end {
                return Some(SeededRange { seed: a.seed, samples: start..end }.to_string());
            }
            match (a.seed, a.samples.end) <= (b.seed, b.samples.end) {
                true => ours.next(),
                false => theirs.next(),
            };
        }
        None
    }

    /// Union of two disjoint sets of ranges.
    pub fn union(self, other: Self) -> Self {
        let mut all = [self.0, other.0].concat();
        all.sort_by_key(|range| (range.seed, range.samples.start));
        let mut joined: Vec<SeededRange> = Vec::new();
        for range in all {
            match joined.last_mut() {
                Some(last) if last.seed == range.seed && last.samples.end == range.samples.start => {
                    last.samples.end = range.samples.end;
                }
                _ => joined.push(range),
            }
        }
        Self(joined)
    }

    /// Whether the ranges are as this type keeps them: sorted, disjoint, not empty, and within 32 bits. Ranges of a file may be
    /// otherwise.
    pub fn is_sound(&self) -> bool {
        let of_one = |range: &SeededRange| range.samples.start < range.samples.end && range.samples.end <= 1 << 32;
        let of_two = |pair: &[SeededRange]| {
            (pair[0].seed, pair[0].samples.end) <= (pair[1].seed, pair[1].samples.start) || pair[0].seed < pair[1].seed
        };
        self.0.iter().all(of_one) && self.0.windows(2).all(of_two)
    }

    /// Seed and number of the first sample; parts are sorted by it.
    pub fn first(&self) -> Option<(u32, u64)> {
        self.0.first().map(|range| (range.seed, range.samples.start))
    }
}

impl fmt::Display for SampleRanges {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let ranges: Vec<_> = self.0.iter().map(ToString::to_string).collect();
        formatter.write_str(&ranges.join(", "))
    }
}

impl fmt::Display for SeededRange {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{}:{}..{}", self.seed, self.samples.start, self.samples.end)
    }
}

impl FromStr for SampleRanges {
    /// Part of the text that is no range, or that overlaps an earlier range.
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let ranges = text.split(", ").map(|range| seeded_range(range).ok_or_else(|| range.to_owned()));
        ranges.map(|range| Ok(Self(vec![range?]))).try_fold(Self::default(), |all, range: Result<_, String>| {
            let range: Self = range?;
            match all.overlap(&range) {
                Some(overlap) => Err(overlap),
                None => Ok(all.union(range)),
            }
        })
    }
}

fn seeded_range(text: &str) -> Option<SeededRange> {
    let (seed, samples) = text.split_once(':')?;
    let (start, end) = samples.split_once("..")?;
    let samples: Range<u64> = start.parse().ok()?..end.parse().ok()?;
    (samples.start <= samples.end && samples.end <= 1 << 32)
        .then_some(SeededRange { seed: seed.parse().ok()?, samples })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ranges(text: &str) -> SampleRanges {
        text.parse().expect(text)
    }

    #[test]
    fn they_are_written_as_they_are_read() {
        for text in ["0:0..64", "7:0..64, 7:128..192, 9:0..8", "4294967295:4294967288..4294967296"] {
            assert_eq!(ranges(text).to_string(), text);
        }
        for text in ["", "0:0", "0:8..4", "0:0..4294967297", "-1:0..4", "0:0..4,0:8..12", "0:0..8, 0:4..12"] {
            assert!(text.parse::<SampleRanges>().is_err(), "{text}");
        }
    }

    #[test]
    fn ranges_of_a_file_are_checked() {
        let of = |ranges: &[(u32, u64, u64)]| {
            let ranges = ranges.iter().map(|&(seed, start, end)| SeededRange { seed, samples: start..end });
            SampleRanges(ranges.collect())
        };
        for sound in [&[][..], &[(7, 0, 64), (7, 128, 1 << 32)], &[(1, 8, 16), (2, 0, 8)]] {
            assert!(of(sound).is_sound(), "{sound:?}");
        }
        for other in [
            &[(0, 8, 8)][..],
            &[(0, 8, 4)],
            &[(0, 0, (1 << 32) + 1)],
            &[(0, 0, 8), (0, 4, 12)],
            &[(1, 0, 8), (0, 0, 8)],
        ] {
            assert!(!of(other).is_sound(), "{other:?}");
        }
    }

    #[test]
    fn those_that_touch_are_joined_in_any_order() {
        for (a, b, both) in [
            ("0:0..64", "0:64..128", "0:0..128"),
            ("0:64..128", "0:0..64", "0:0..128"),
            ("0:0..8, 0:16..24", "0:8..16", "0:0..24"),
            ("1:0..8", "0:8..16", "0:8..16, 1:0..8"),
        ] {
            assert_eq!(ranges(a).union(ranges(b)).to_string(), both);
        }
    }

    #[test]
    fn an_overlap_is_found_within_a_seed_only() {
        let overlap = |a, b| ranges(a).overlap(&ranges(b));
        assert_eq!(overlap("0:0..64", "0:48..128").as_deref(), Some("0:48..64"));
        assert_eq!(overlap("0:0..64, 3:8..16", "3:0..9").as_deref(), Some("3:8..9"));
        assert_eq!(overlap("0:0..64", "1:0..64"), None);
        assert_eq!(overlap("0:0..64", "0:64..65"), None);
    }
}
