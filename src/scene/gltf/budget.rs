//! Limits on the images, meshes and shapes that are made while a model is read.

use crate::image::texels::TexelImage;
use crate::scene::mesh::MAX_TRIANGLES;

/// Most texels of a model's images that are decoded or made at once; a texel takes 4 to 16 bytes.
const MOST_TEXELS: u64 = 1 << 30;

/// Texels that may still be decoded or made.
pub(super) struct Budget {
    left: u64,
}

impl Default for Budget {
    fn default() -> Self {
        Self { left: MOST_TEXELS }
    }
}

impl Budget {
    /// Takes the texels of an image. The error says what does not fit.
    pub fn take(&mut self, image: &TexelImage) -> Result<(), String> {
        let texels = u64::from(image.width) * u64::from(image.height);
        let left = self.left.checked_sub(texels).ok_or_else(|| {
            format!(
                "the images of its materials, with those that are made from them, have more than {MOST_TEXELS} texels; use \
                 smaller textures"
            )
        })?;
        self.left = left;
        Ok(())
    }
}

/// Most vertices of all meshes: as many as the corners of the triangles.
const MOST_VERTICES: usize = 3 * MAX_TRIANGLES;
/// Most shapes.
const MOST_SHAPES: usize = 1 << 20;

/// Numbers of the vertices, triangles and shapes that have been made.
#[derive(Default)]
pub(super) struct Made {
    vertices: usize,
    triangles: usize,
    shapes: usize,
}

impl Made {
    /// Counts the vertices of a mesh.
    pub fn vertices(&mut self, count: usize) -> Result<(), String> {
        add(&mut self.vertices, count, MOST_VERTICES, "vertices")
    }

    /// Counts the triangles of a mesh.
    pub fn triangles(&mut self, count: usize) -> Result<(), String> {
        add(&mut self.triangles, count, MAX_TRIANGLES, "triangles")
    }

    /// Counts the shapes of a primitive.
    pub fn shapes(&mut self, count: usize) -> Result<(), String> {
        add(&mut self.shapes, count, MOST_SHAPES, "shapes")
    }
}

/// Adds to a number of things, of which there may be `most`. The error says that there are more.
fn add(number: &mut usize, count: usize, most: usize, what: &str) -> Result<(), String> {
    *number = number.saturating_add(count);
    match *number > most {
        true => Err(format!("with it the scene has more than {most} {what}; save the scene in parts")),
        false => Ok(()),
    }
}

#[test]
fn more_things_than_fit_are_refused() {
    let mut made = Made::default();
    assert_eq!(made.vertices(MOST_VERTICES), Ok(()));
    assert_eq!(made.triangles(MAX_TRIANGLES), Ok(()));
    assert_eq!(made.shapes(MOST_SHAPES), Ok(()));
    let sentence = "with it the scene has more than 1048576 shapes; save the scene in parts";
    assert_eq!(made.shapes(1), Err(sentence.to_owned()));
    assert!(made.vertices(1).is_err() && made.triangles(usize::MAX).is_err());
}

#[test]
fn more_texels_than_fit_are_refused() {
    let texels = || crate::image::texels::FileTexels::Bytes(vec![]);
    let image = |width, height| TexelImage { width, height, texels: texels(), to_srgb: None };
    let mut budget = Budget::default();
    for _ in 0..4 {
        assert_eq!(budget.take(&image(1 << 14, 1 << 14)), Ok(()));
    }
    assert!(budget.take(&image(1, 1)).is_err_and(|message| message.contains("smaller textures")));
    // An image of the largest sides does not overflow.
    assert!(Budget::default().take(&image(u32::MAX, u32::MAX)).is_err());
}
