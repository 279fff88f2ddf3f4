//! KTX2 images whose texels Basis Universal compresses: ETC1S, and UASTC with or without Zstandard (`KHR_texture_basisu`).

use std::path::Path;

use basisu::{DecodeFlags, SourceFormat, TargetFormat, Transcoder};

use crate::{Error, Result};

const MAGIC: [u8; 12] = *b"\xabKTX 20\xbb\r\n\x1a\n";

/// Bytes of the header, and of an entry of the index of levels that follows it.
const HEADER: usize = 80;
const LEVEL: usize = 24;
/// Most levels of detail. Their sides are halved from one to the next.
const MOST_LEVELS: u32 = 17;
/// Place of the description of the format, of the keys and of the common data in the header.
const FORMAT: usize = 48;
const KEYS: usize = 56;
const COMMON: usize = 64;
/// Bytes and texels of a block of either codec.
const BLOCK_BYTES: u64 = 16;
const BLOCK_SIDE: u32 = 4;

/// Scheme by which levels are packed once more.
const ZSTANDARD: u32 = 2;

/// Whether these are the bytes of a KTX2 file.
pub(super) fn is_ktx2(bytes: &[u8]) -> bool {
    bytes.starts_with(&MAGIC)
}

/// Width, height and texels of the largest level of a KTX2 image. `path` is its name, for messages. A side may have `most_side` texels, and
/// all texels may take `most_bytes`.
pub(super) fn decode(path: &Path, bytes: &[u8], most_side: u32, most_bytes: u64) -> Result<(u32, u32, Vec<[u8; 4]>)> {
    let error = |message: &str| Error::image(path, message);
    let damaged = || error("it is not a whole KTX2 image; write it again");
    let (width, height) = check(bytes, most_side, most_bytes).map_err(error)?;
    let mut bytes = bytes.to_vec();
    // Keys change no texel.
    bytes[KEYS..COMMON].fill(0);
    let transcoder = Transcoder::new(&bytes).map_err(|_| damaged())?;
    if !matches!(transcoder.source_format(), SourceFormat::Etc1s | SourceFormat::UastcLdr) {
        return Err(error("its KTX2 image has a codec other than ETC1S and UASTC, which is not read; save it as PNG"));
    }
    let texels = transcoder.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).map_err(|_| damaged())?;
    let texels = texels.as_chunks::<4>().0.to_vec();
    if texels.len() as u64 != u64::from(width) * u64::from(height) {
        return Err(damaged());
    }
    Ok((width, height, texels))
}

/// Checks that all that the header names lies within the file, before the decoder looks it up. Returns the sides.
fn check(bytes: &[u8], most_side: u32, most_bytes: u64) -> Result<(u32, u32), &'static str> {
    const SHORT: &str = "the KTX2 image is cut short; write it again";
    let word = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
    let long = |at: usize| Some(u64::from_le_bytes(bytes.get(at..at + 8)?.try_into().ok()?));
    let is_within = |start: u64, length: u64| start.checked_add(length).is_some_and(|end| end <= bytes.len() as u64);
    let header = (3..12).map(|at| word(4 * at)).collect::<Option<Vec<_>>>().ok_or(SHORT)?;
    let [format, _, width, height, depth, layers, faces, levels, packing] = header[..] else { return Err(SHORT) };
    if format != 0 {
        return Err("its KTX2 image is not compressed by Basis Universal, which alone is read; save it as PNG");
    }
    if depth > 0 || layers > 0 || faces != 1 {
        return Err("its KTX2 image is no plain picture; save it as PNG");
    }
    let texels = u64::from(width) * u64::from(height);
    if width.max(height) > most_side || 4 * texels > most_bytes {
        return Err("it is larger than 65536 texels a side or 2 GiB; save a smaller one");
    }
    if texels == 0 || levels == 0 || levels > MOST_LEVELS || packing > ZSTANDARD {
        return Err("its KTX2 header is damaged; write it again");
    }
    let blocks = u64::from(width.div_ceil(BLOCK_SIDE)) * u64::from(height.div_ceil(BLOCK_SIDE));
    for level in 0..levels as usize {
        let at = HEADER + LEVEL * level;
        let (start, length, unpacked) =
            (long(at).ok_or(SHORT)?, long(at + 8).ok_or(SHORT)?, long(at + 16).ok_or(SHORT)?);
        if !is_within(start, length) {
            return Err(SHORT);
        }
        if packing == ZSTANDARD && unpacked > blocks * BLOCK_BYTES {
            return Err("its KTX2 header is damaged; write it again");
        }
    }
    let pair = |at: usize| Some((u64::from(word(at)?), u64::from(word(at + 4)?)));
    let common = Some((long(COMMON).ok_or(SHORT)?, long(COMMON + 8).ok_or(SHORT)?));
    let parts = [pair(FORMAT), common];
    if parts.into_iter().any(|part| part.is_none_or(|(start, length)| !is_within(start, length))) {
        return Err(SHORT);
    }
    Ok((width, height))
}
