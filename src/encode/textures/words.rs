//! Words that the kernels read: the texels of images, and tables that materials refer to.

use std::borrow::Cow;

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
    /// Words of the tables, then words of the used images and of grids. The loader has checked that they fit. Returns the address
    /// of each grid, too.
    pub(super) fn new(tables: Vec<u32>, images: &[Image], used: &[bool], grids: &[Cow<[u32]>]) -> (Self, Vec<u32>) {
        let indices: Vec<usize> = (0..images.len()).filter(|&i| used[i]).collect();
        let counts = indices.iter().map(|&i| word_count(&images[i])).chain(grids.iter().map(|grid| grid.len() as u64));
        let counts: Vec<u64> = counts.collect();
        let first_word = tables.len() as u64;
        let mut words = Self { pages: vec![tables], addresses: vec![None; images.len()] };
        let mut of_grids = Vec::with_capacity(grids.len());
        for (number, (place, &count)) in place(&counts).unwrap_or_default().iter().zip(&counts).enumerate() {
            let word = place.word + if place.page == 0 { first_word } else { 0 };
            let target = words.room(place.page, word as usize, count as usize);
            let address = (place.page as u32) << constants::TEXEL_PAGE_SHIFT | word as u32;
            match indices.get(number) {
                Some(&i) => {
                    write(target, &images[i]);
                    words.addresses[i] = Some(address);
                }
                None => {
                    target.copy_from_slice(&grids[number - indices.len()]);
                    of_grids.push(address);
                }
            }
        }
        (words, of_grids)
    }

    /// Words of a page, from `word` on.
    fn room(&mut self, page: usize, word: usize, count: usize) -> &mut [u32] {
        if self.pages.len() <= page {
            self.pages.resize_with(page + 1, Vec::new);
        }
        let words = &mut self.pages[page];
        words.resize(words.len().max(word + count), 0);
        &mut words[word..word + count]
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

/// Writes the words of an image.
fn write(target: &mut [u32], image: &Image) {
    match &image.texels {
        Texels::Bytes { data, .. } => target.copy_from_slice(cast_slice(data)),
        Texels::Heights(data) => target.copy_from_slice(cast_slice(data)),
        Texels::Floats(data) => halves::write(target, data, halves::scale(data.iter().flatten().copied())),
    }
}

const _: () = assert!(PAGE_WORDS <= 1 << constants::TEXEL_PAGE_SHIFT);
