//! glTF 2.0 to a description of a scene.

use std::path::Path;

use super::mitsuba::description::Description;
use crate::{Error, Result};

/// Reads a file in glTF 2.0, text or binary.
pub(super) fn read(path: &Path) -> Result<Description> {
    Err(Error::scene(path, None, "glTF cannot be read yet"))
}
