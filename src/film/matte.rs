//! Cryptomatte (Friedman and Jones 2015, specification 1.2.0): which objects a pixel shows, and what share of it each has. Compositors cut
//! objects out by their names.

use std::collections::BTreeMap;

/// Objects that a file holds for each pixel: those that have the largest shares. Two fill a layer.
pub const RANKS: usize = 6;

/// Share of a pixel that one object has.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Coverage {
    /// [`identifier`] of the object; 0 where there is none.
    pub id: f32,
    /// Share of the pixel's samples.
    pub share: f32,
}

impl Coverage {
    /// The identifier, or the share.
    pub fn number(&self, at: usize) -> f32 {
        [self.id, self.share][at]
    }
}

/// A number of samples that met one object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Count {
    /// Index of the object.
    pub object: u32,
    /// Number of samples.
    pub samples: u32,
}

/// Objects that samples met, the most frequent first. Where several have as many, the one with the smaller index comes first.
pub fn ranked(objects: impl Iterator<Item = u32>) -> Vec<Count> {
    let mut counts: Vec<Count> = Vec::new();
    for object in objects {
        match counts.iter_mut().find(|count| count.object == object) {
            Some(count) => count.samples += 1,
            None => counts.push(Count { object, samples: 1 }),
        }
    }
    counts.sort_by_key(|count| (std::cmp::Reverse(count.samples), count.object));
    counts
}

/// Number that stands for a name in a picture: the bits of its hash, changed where they would be no number, or so small that programs round
/// it to 0.
pub fn identifier(name: &str) -> f32 {
    let hash = murmur3(name.as_bytes());
    let exponent = hash >> 23 & 255;
    f32::from_bits(if exponent == 0 || exponent == 255 { hash ^ 1 << 23 } else { hash })
}

/// Attributes with which a file says what the layers of this name mean, and which number stands for which of `names`.
pub fn attributes(layer: &str, names: &[&str]) -> Vec<(String, String)> {
    let key = format!("{:08x}", murmur3(layer.as_bytes()));
    let manifest: BTreeMap<&str, String> =
        names.iter().map(|&name| (name, format!("{:08x}", identifier(name).to_bits()))).collect();
    let manifest = serde_json::to_string(&manifest).unwrap_or_default();
    let facts = [
        ("name", layer.to_owned()),
        ("hash", "MurmurHash3_32".to_owned()),
        ("conversion", "uint32_to_float32".to_owned()),
        ("manifest", manifest),
    ];
    facts.map(|(fact, value)| (format!("cryptomatte/{}/{fact}", &key[..7]), value)).into()
}

/// MurmurHash3 of 32 bits with the seed 0 (Appleby 2011).
fn murmur3(bytes: &[u8]) -> u32 {
    let scrambled = |word: u32| word.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let (words, rest) = bytes.as_chunks::<4>();
    let mut hash = 0_u32;
    for word in words {
        hash = (hash ^ scrambled(u32::from_le_bytes(*word))).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64);
    }
    let mut last = [0; 4];
    last[..rest.len()].copy_from_slice(rest);
    hash ^= scrambled(u32::from_le_bytes(last));
    hash ^= bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the reference implementation, and the specification's example.
    #[test]
    fn hashes_are_those_of_murmur3() {
        for (text, hash) in [("", 0), ("test", 0xba6b_d213), ("Hello, world!", 0xc036_3e43), ("a", 0x3c25_69b2)] {
            assert_eq!(murmur3(text.as_bytes()), hash, "{text}");
        }
    }

    #[test]
    fn identifiers_are_numbers() {
        for index in 0..100_000 {
            let id = identifier(&format!("object {index}"));
            assert!(id.is_normal(), "{index}");
        }
    }

    #[test]
    fn the_largest_share_comes_first() {
        let of = |object, samples| Count { object, samples };
        assert_eq!(ranked([5, 2, 7, 2, 5, 9].into_iter()), [of(2, 2), of(5, 2), of(7, 1), of(9, 1)]);
    }

    #[test]
    fn a_manifest_names_all_objects() {
        let attributes = attributes("CryptoObject", &["b\"c", "a"]);
        let keys: Vec<_> = attributes.iter().map(|(key, _)| &key[19..]).collect();
        assert_eq!(keys, ["/name", "/hash", "/conversion", "/manifest"]);
        let manifest = &attributes[3].1;
        assert!(manifest.starts_with("{\"a\":\"") && manifest.contains("\"b\\\"c\":\""), "{manifest}");
        // Names of attributes with more letters need a newer version of the format.
        assert!(attributes.iter().all(|(key, _)| key.len() <= 31));
    }
}
