//! Limits on the sizes that the headers of an EXR file may ask for.

/// Limit on pixels, 16384 x 16384, because a damaged header may ask for any size.
const MAX_PIXEL_COUNT: usize = 1 << 28;
/// Bytes that a file of any length may unpack to.
const MOST_BYTES: u64 = 1 << 31;
/// Most bytes that a larger file may unpack to, as a multiple of its length. A picture of one color in all channels may be packed tighter.
const MOST_RATIO: u64 = 64;

/// Size of a part of a file.
pub(super) struct PartSize {
    pub pixels: usize,
    /// Bytes of all channels of a pixel.
    pub bytes_per_pixel: usize,
}

/// Refuses a picture larger than [`MAX_PIXEL_COUNT`], and one whose parts and channels would unpack to far more than its file of `length`
/// bytes can hold.
///
/// # Errors
/// The size, and what to do.
pub(super) fn check(parts: &[PartSize], length: u64) -> Result<(), String> {
    if parts.iter().any(|part| part.pixels > MAX_PIXEL_COUNT) {
        return Err("it is larger than 2^28 pixels; crop it".into());
    }
    let bytes_of = |part: &PartSize| (part.pixels as u64).saturating_mul(part.bytes_per_pixel as u64);
    let bytes = parts.iter().map(bytes_of).fold(0, u64::saturating_add);
    if bytes > MOST_BYTES.max(length.saturating_mul(MOST_RATIO)) {
        let gigabytes = bytes as f64 / 1e9;
        return Err(format!(
            "its channels have {gigabytes:.1} GB, far more than a file of {length} bytes holds; give fewer channels"
        ));
    }
    Ok(())
}

#[test]
fn small_files_cannot_ask_for_much() {
    let part = |pixels, bytes_per_pixel| PartSize { pixels, bytes_per_pixel };
    let refusal = |parts: &[PartSize], length| check(parts, length).err().unwrap_or_default();
    assert!(refusal(&[part(MAX_PIXEL_COUNT + 1, 2)], u64::MAX).contains("2^28 pixels"));
    // 64 channels of half floats, in one part or in many.
    assert!(refusal(&[part(MAX_PIXEL_COUNT, 128)], 2000).contains("34.4 GB, far more than a file of 2000 bytes"));
    let parts: Vec<_> = (0..64).map(|_| part(MAX_PIXEL_COUNT, 2)).collect();
    assert!(refusal(&parts, 2000).contains("34.4 GB"));
    // All layers of a picture of 8192 x 8192 pixels, whose file has a gigabyte, and a small picture that is all black.
    assert_eq!(check(&[part(1 << 26, 68)], 1 << 30), Ok(()));
    assert_eq!(check(&[part(1 << 22, 68)], 20_000), Ok(()));
}
