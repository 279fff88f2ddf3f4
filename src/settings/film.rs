//! Size of the film, and the window of it that is rendered.

use super::Settings;
use crate::generated::constants;
use crate::scene::Crop;
use crate::{Error, Result};

/// Most pixels that a film may have along a side.
pub const MAX_FILM_SIDE: u32 = 1 << constants::PIXEL_DIGITS;

impl Settings {
    /// Window of the film that is rendered.
    pub fn window(&self) -> Crop {
        self.crop.unwrap_or(Crop { x: 0, y: 0, width: self.width, height: self.height })
    }

    /// Refuses a window that is empty or leaves the film.
    pub(super) fn check_crop(&self) -> Result<()> {
        let Crop { x, y, width, height } = self.window();
        let inside =
            |offset: u32, size: u32, whole: u32| size > 0 && u64::from(offset) + u64::from(size) <= whole.into();
        if inside(x, width, self.width) && inside(y, height, self.height) {
            return Ok(());
        }
        Err(Error::Settings(format!(
            "the crop window {x},{y},{width},{height} is empty or leaves the film of {} x {} pixels",
            self.width, self.height
        )))
    }
}
