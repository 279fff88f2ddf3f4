//! Channels of a picture file by functions. A writer asks for values when their turn comes, so that no copy of them lies in memory.

use std::ops::Range;

use crate::Result;

use super::layers::{Layers, Samples};

/// Channels of a picture with their window.
pub struct Columns<'a> {
    /// Width of the window in pixels.
    pub width: u32,
    /// Height of the window in pixels.
    pub height: u32,
    /// The window's offset within the whole picture.
    pub offset: [u32; 2],
    /// Size of the whole picture.
    pub full_size: [u32; 2],
    /// Channels by name, such as `R` or `normal.X`.
    pub channels: Vec<(String, Column<'a>)>,
}

/// Columns that hold some rows of a file.
pub struct Rows<'a> {
    /// The columns. Index 0 is the first pixel of the row `first`.
    pub columns: &'a Columns<'a>,
    /// Row of the file with which the columns begin.
    pub first: u32,
}

/// Makes the rows of a file that are asked for, and hands them to the function.
pub type MakeRows<'a> = &'a mut dyn FnMut(Range<u32>, &mut dyn FnMut(&Rows<'_>)) -> Result<()>;

/// A function from a pixel's index to its value. Indices go row by row from the top left.
pub type ValueAt<'a, T> = Box<dyn Fn(usize) -> T + Sync + 'a>;

/// Values of a channel.
pub enum Column<'a> {
    /// 32-bit floats.
    Floats(ValueAt<'a, f32>),
    /// Floats that the file has as 16-bit floats.
    Halves(ValueAt<'a, f32>),
    /// Unsigned 32-bit integers.
    Words(ValueAt<'a, u32>),
}

impl Layers {
    /// The channels by functions.
    pub fn columns(&self) -> Columns<'_> {
        let Self { width, height, offset, full_size, ref channels } = *self;
        let channels = channels.iter().map(|(name, samples)| (name.clone(), samples.column())).collect();
        Columns { width, height, offset, full_size, channels }
    }
}

impl Samples {
    fn column(&self) -> Column<'_> {
        match self {
            Self::Floats(values) => Column::Floats(Box::new(|at| values[at])),
            Self::Halves(values) => Column::Halves(Box::new(|at| values[at])),
            Self::Words(values) => Column::Words(Box::new(|at| values[at])),
        }
    }
}
