//! Memory of the images that are made while a model is read.

use crate::image::texels::TexelImage;

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

#[test]
fn more_texels_than_fit_are_refused() {
    let image = |width, height| TexelImage { width, height, texels: crate::image::texels::FileTexels::Bytes(vec![]) };
    let mut budget = Budget::default();
    for _ in 0..4 {
        assert_eq!(budget.take(&image(1 << 14, 1 << 14)), Ok(()));
    }
    assert!(budget.take(&image(1, 1)).is_err_and(|message| message.contains("smaller textures")));
    // An image of the largest sides does not overflow.
    assert!(Budget::default().take(&image(u32::MAX, u32::MAX)).is_err());
}
