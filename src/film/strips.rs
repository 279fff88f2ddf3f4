//! Pictures that are read some rows at a time, so that memory need not hold them whole.

use std::ops::Range;

use crate::Result;
use crate::film::Picture;
use crate::image::rows_at_a_time;

/// A picture that gives its rows.
pub trait Strips {
    /// Width and height in pixels.
    fn size(&self) -> [u32; 2];

    /// A picture with these rows.
    ///
    /// # Errors
    /// Where the rows are on a device that is lost.
    fn strip(&self, rows: Range<u32>) -> Result<Strip<'_>>;

    /// The whole picture, where memory holds it.
    fn whole(&self) -> Option<&Picture> {
        None
    }
}

/// Some rows of a picture.
pub enum Strip<'a> {
    /// All rows of the picture.
    All(&'a Picture),
    /// The rows from this one on.
    From(u32, Box<Picture>),
}

impl Strip<'_> {
    /// Picture that holds the rows.
    pub fn picture(&self) -> &Picture {
        match self {
            Self::All(picture) => picture,
            Self::From(_, picture) => picture,
        }
    }

    /// Row of the whole picture with which [`Strip::picture`] begins.
    pub fn first(&self) -> u32 {
        match self {
            Self::All(_) => 0,
            Self::From(first, _) => *first,
        }
    }
}

/// Pixels of one strip of [`each`].
pub struct Pixels<'a> {
    /// Picture that holds the pixels.
    pub picture: &'a Picture,
    /// The pixels in that picture.
    pub within: Range<usize>,
    /// The pixels in the whole picture.
    pub of_whole: Range<usize>,
}

impl Strips for Picture {
    fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    fn strip(&self, _: Range<u32>) -> Result<Strip<'_>> {
        Ok(Strip::All(self))
    }

    fn whole(&self) -> Option<&Picture> {
        Some(self)
    }
}

/// Calls `act` with all pixels, one strip after the other.
///
/// # Errors
/// Where a strip cannot be read.
pub fn each(strips: &dyn Strips, act: &mut dyn FnMut(&Pixels<'_>)) -> Result<()> {
    let [width, height] = strips.size();
    for first in (0..height).step_by(rows_at_a_time(width) as usize) {
        with_rows(strips, first..height.min(first + rows_at_a_time(width)), act)?;
    }
    Ok(())
}

/// Calls `act` with the pixels of some rows.
///
/// # Errors
/// Where they cannot be read.
pub fn with_rows(strips: &dyn Strips, rows: Range<u32>, act: &mut dyn FnMut(&Pixels<'_>)) -> Result<()> {
    let width = strips.size()[0] as usize;
    let strip = strips.strip(rows.clone())?;
    let pixels = |rows: Range<u32>| rows.start as usize * width..rows.end as usize * width;
    let within = pixels(rows.start - strip.first()..rows.end - strip.first());
    act(&Pixels { picture: strip.picture(), within, of_whole: pixels(rows) });
    Ok(())
}

/// Numbers of samples of a picture's pixels.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SampleCounts {
    /// Number of pixels.
    pub pixels: usize,
    /// Number of pixels without a sample.
    pub empty: usize,
    /// Largest number of samples of a pixel. Others have fewer where noise has ended them, or where the last step was cut short.
    pub most: u32,
}

impl SampleCounts {
    /// Counts a picture's samples.
    ///
    /// # Errors
    /// Where a strip cannot be read.
    pub fn of(strips: &dyn Strips) -> Result<Self> {
        let mut counts = Self::default();
        each(strips, &mut |strip| {
            for &samples in &strip.picture.sample_count[strip.within.clone()] {
                counts.pixels += 1;
                counts.empty += usize::from(samples == 0);
                counts.most = counts.most.max(samples);
            }
        })?;
        Ok(counts)
    }
}
