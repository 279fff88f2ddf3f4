//! Where the pixels of a picture come from that is written into files.

use std::ops::Range;

use crate::Result;
use crate::film::Picture;
use crate::film::strips::{Strip, Strips};
use crate::fleet::Fleet;
use crate::renderer::Renderer;

/// The picture of a running render.
pub(super) enum Source<'a> {
    /// A picture of which the host keeps copies anyway, or that a denoiser needs whole. It is read once for all files.
    Whole(Box<Picture>),
    /// A large picture of a CPU: some rows at a time are read from the device, whose memory is the host's. A copy never lies beside it.
    OnDevice(&'a Renderer),
}

impl<'a> Source<'a> {
    /// Picture of the render so far.
    pub fn of(fleet: &'a Fleet, needs_whole: bool) -> Result<Self> {
        if needs_whole || fleet.first().has_copies() {
            return Ok(Self::Whole(Box::new(fleet.picture()?)));
        }
        Ok(Self::OnDevice(fleet.gathered()?))
    }
}

impl Strips for Source<'_> {
    fn size(&self) -> [u32; 2] {
        match self {
            Self::Whole(picture) => picture.size(),
            Self::OnDevice(renderer) => {
                let window = renderer.settings().window();
                [window.width, window.height]
            }
        }
    }

    fn strip(&self, rows: Range<u32>) -> Result<Strip<'_>> {
        match self {
            Self::Whole(picture) => picture.strip(rows),
            Self::OnDevice(renderer) => Ok(Strip::From(rows.start, Box::new(renderer.picture_rows(&rows)?))),
        }
    }

    fn whole(&self) -> Option<&Picture> {
        match self {
            Self::Whole(picture) => Some(picture),
            Self::OnDevice(_) => None,
        }
    }
}
