//! Layout of images as 32-bit words in a device's buffers. Every scene that loads fits any device.

use super::texture::{Image, Texels};
use crate::generated::constants::TEXEL_PAGE_SHIFT;

/// Words of a page: 128 MiB, the largest storage binding that every device has.
pub const PAGE_WORDS: u64 = 32 << 20;
/// Most pages, which the upper bits of an address distinguish.
pub const MAX_PAGES: usize = 1 << (u32::BITS - TEXEL_PAGE_SHIFT);
/// Number of words of the first page that are reserved for the tables of materials.
const TABLE_WORDS: u64 = 1 << 20;

/// Place of an image's first word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImagePlace {
    /// Index of the page.
    pub page: usize,
    /// Index of the word within the page; in the first page, counted from the end of the tables.
    pub word: u64,
}

/// Number of words of an image: one per texel of bytes or heights, two per texel of halves.
pub fn word_count(image: &Image) -> u64 {
    let texels = u64::from(image.width) * u64::from(image.height);
    match image.texels {
        Texels::Bytes { .. } | Texels::Heights(_) => texels,
        Texels::Floats(_) => 2 * texels,
    }
}

/// Places for images of the given numbers of words: the largest first, each in the first page with room. No image lies
/// in two pages. `None` where they do not fit.
pub fn place(word_counts: &[u64]) -> Option<Vec<ImagePlace>> {
    let mut order: Vec<usize> = (0..word_counts.len()).collect();
    order.sort_by_key(|&i| std::cmp::Reverse(word_counts[i]));
    let mut used = [0; MAX_PAGES];
    let mut places = vec![ImagePlace { page: 0, word: 0 }; word_counts.len()];
    for i in order {
        let room = |page: usize| PAGE_WORDS - if page == 0 { TABLE_WORDS } else { 0 };
        let page = (0..MAX_PAGES).find(|&page| used[page] + word_counts[i] <= room(page))?;
        places[i] = ImagePlace { page, word: used[page] };
        used[page] += word_counts[i];
    }
    Some(places)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_do_not_overlap_and_fill_few_pages() {
        let counts = [5, PAGE_WORDS / 2, 7, PAGE_WORDS / 2, 11];
        let places = place(&counts).unwrap();
        assert_eq!(places[1], ImagePlace { page: 0, word: 0 });
        assert_eq!(places[3], ImagePlace { page: 1, word: 0 });
        assert_eq!(places[4], ImagePlace { page: 0, word: PAGE_WORDS / 2 });
        assert_eq!(places[2].word, places[4].word + 11);
        assert_eq!(places[0].word, places[2].word + 7);
    }

    #[test]
    fn what_does_not_fit_is_told() {
        assert!(place(&[PAGE_WORDS + 1]).is_none());
        assert_eq!(place(&[PAGE_WORDS]).unwrap()[0].page, 1);
        assert!(place(&[PAGE_WORDS; 3]).is_some());
        assert!(place(&[PAGE_WORDS; 4]).is_none());
        assert_eq!(place(&[]), Some(vec![]));
    }
}
