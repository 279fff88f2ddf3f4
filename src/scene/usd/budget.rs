//! Limits on what is made of a scene while it is read.

use crate::image::texels::TexelImage;
use crate::scene::mesh::MAX_TRIANGLES;

/// Most texels of a scene's images that are decoded or made at once; a texel takes 4 to 16 bytes.
const MOST_TEXELS: u64 = 1 << 30;
/// Most prims, each counted as often as it has instances.
pub(super) const MOST_PRIMS: usize = 1 << 20;

/// Texels that have been decoded or made.
#[derive(Default)]
pub(super) struct Texels {
    taken: u64,
}

impl Texels {
    /// Takes the texels of an image. The error says what does not fit.
    pub fn take(&mut self, image: &TexelImage) -> Result<(), String> {
        self.taken += u64::from(image.width) * u64::from(image.height);
        match self.taken > MOST_TEXELS {
            true => Err(format!("with it the images have more than {MOST_TEXELS} texels; use smaller textures")),
            false => Ok(()),
        }
    }
}

/// Numbers of the prims, vertices and triangles that have been read.
#[derive(Default)]
pub(super) struct Made {
    prims: usize,
    corners: usize,
}

impl Made {
    /// Counts prims.
    pub fn prims(&mut self, count: usize) -> Result<(), String> {
        add(&mut self.prims, count, MOST_PRIMS, "prims and instances")
    }

    /// Counts the corners of a mesh's faces.
    pub fn corners(&mut self, count: usize) -> Result<(), String> {
        add(&mut self.corners, count, 3 * MAX_TRIANGLES, "corners of faces")
    }
}

fn add(number: &mut usize, count: usize, most: usize, what: &str) -> Result<(), String> {
    *number = number.saturating_add(count);
    match *number > most {
        true => Err(format!("with it the scene has more than {most} {what}; save the scene in parts")),
        false => Ok(()),
    }
}
