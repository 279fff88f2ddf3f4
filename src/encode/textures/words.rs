//! Words that the kernels read: the texels of images, and tables that materials refer to.

use bytemuck::cast_slice;

use super::halves;
use crate::generated::constants;
use crate::scene::texel_pages::{PAGE_WORDS, place, word_count};
use crate::scene::texture::{Image, Texels};

/// Words by page, and the address of each image among them.
#[derive(Clone)]
pub struct TexelWords {
    pages: Vec<Vec<u32>>,
    addresses: Vec<Option<u32>>,
}

impl TexelWords {
    /// Words of the tables, then words of the used images. The loader has checked that they fit.
    pub(super) fn new(tables: Vec<u32>, images: &[Image], used: &[bool]) -> Self {
        let indices: Vec<usize> = (0..images.len()).filter(|&i| used[i]).collect();
        let counts: Vec<u64> = indices.iter().map(|&i| word_count(&images[i])).collect();
        let first_word = tables.len() as u64;
        let mut words = Self { pages: vec![tables], addresses: vec![None; images.len()] };
        for (i, place) in indices.into_iter().zip(place(&counts).unwrap_or_default()) {
            let word = place.word + if place.page == 0 { first_word } else { 0 };
            words.write(place.page, word as usize, &images[i]);
            words.addresses[i] = Some((place.page as u32) << constants::TEXEL_PAGE_SHIFT | word as u32);
        }
        words
    }

    fn write(&mut self, page: usize, word: usize, image: &Image) {
        if self.pages.len() <= page {
            self.pages.resize_with(page + 1, Vec::new);
        }
        let words = &mut self.pages[page];
        let end = word + word_count(image) as usize;
        words.resize(words.len().max(end), 0);
        let target = &mut words[word..end];
        match &image.texels {
            Texels::Bytes { data, .. } => target.copy_from_slice(cast_slice(data)),
            Texels::Heights(data) => target.copy_from_slice(cast_slice(data)),
            Texels::Floats(data) => halves::write(target, data, halves::scale(data.iter().flatten().copied())),
        }
    }

    /// Pages in use, at least one.
    pub fn pages(&self) -> &[Vec<u32>] {
        &self.pages
    }

    /// Number of words of the longest page.
    pub fn longest_page(&self) -> usize {
        self.pages.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// Address of an image's first word; `None` where no texture uses it.
    pub(super) fn address(&self, image: u32) -> Option<u32> {
        self.addresses[image as usize]
    }
}

const _: () = assert!(PAGE_WORDS <= 1 << constants::TEXEL_PAGE_SHIFT);
