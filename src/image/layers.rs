//! Layers of a picture file: named channels over one window. What they mean is their writer's business.

/// Channels of a picture with their window.
#[derive(Debug, Clone, PartialEq)]
pub struct Layers {
    /// Width of the window in pixels.
    pub width: u32,
    /// Height of the window in pixels.
    pub height: u32,
    /// The window's offset within the whole picture.
    pub offset: [u32; 2],
    /// Size of the whole picture.
    pub full_size: [u32; 2],
    /// Channels by name, such as `R` or `normal.X`.
    pub channels: Vec<(String, Samples)>,
}

/// Values of a channel, row by row from the top left.
#[derive(Debug, Clone, PartialEq)]
pub enum Samples {
    /// 32-bit floats.
    Floats(Vec<f32>),
    /// Floats that the file has as 16-bit floats. A reader makes [`Samples::Floats`] of a channel with infinite ones.
    Halves(Vec<f32>),
    /// Unsigned 32-bit integers.
    Words(Vec<u32>),
}

impl Layers {
    /// Values of the channel `name`, where it has floats.
    pub fn floats(&self, name: &str) -> Option<&[f32]> {
        match self.samples(name)? {
            Samples::Floats(floats) | Samples::Halves(floats) => Some(floats),
            Samples::Words(_) => None,
        }
    }

    /// Values of the channel `name`, where it has integers.
    pub fn words(&self, name: &str) -> Option<&[u32]> {
        match self.samples(name)? {
            Samples::Words(words) => Some(words),
            Samples::Floats(_) | Samples::Halves(_) => None,
        }
    }

    fn samples(&self, name: &str) -> Option<&Samples> {
        self.channels.iter().find(|(found, _)| found == name).map(|(_, samples)| samples)
    }
}
