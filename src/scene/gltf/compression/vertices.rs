//! Decoder of vertices: mode `ATTRIBUTES` of `EXT_meshopt_compression` (version 0) and `KHR_meshopt_compression` (version 1).
//!
//! Elements come in blocks. A block has a row for each byte of an element, and a row has groups of 16 differences, packed to a width that
//! its header says.

use super::reader::{Fault, Reader};

/// Differences of one group.
const GROUP: usize = 16;
/// Most elements of a block.
const MOST_ELEMENTS: usize = 256;
/// Most bytes of a block's elements.
const BLOCK_BYTES: usize = 8192;

/// Elements of `stride` bytes each, a multiple of 4 up to 256. They take at most 1024 times the memory of `source`.
pub(super) fn decode(source: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, Fault> {
    let (&head, rest) = source.split_first().ok_or(Fault::Short)?;
    let has_modes = match head {
        0xa0 => false,
        0xa1 => true,
        _ => return Err(Fault::Head),
    };
    let channels = stride / 4;
    let (end, least_end) = if has_modes { (stride + channels, 24) } else { (stride, 32) };
    let length = rest.len().checked_sub(end.max(least_end)).ok_or(Fault::Short)?;
    let (mut last, modes) = {
        let (first, modes) = rest[rest.len() - end..].split_at(stride);
        (first.to_vec(), modes)
    };
    if modes.iter().any(|mode| mode & 15 > 2 || (mode & 15 < 2 && mode >> 4 != 0)) {
        return Err(Fault::Code);
    }
    let block = ((BLOCK_BYTES / stride) & !(GROUP - 1)).min(MOST_ELEMENTS);
    // Each block has a header, so memory is set aside for no more than the data can hold.
    let least = if has_modes { channels } else { stride };
    if count.div_ceil(block) > length / least {
        return Err(Fault::Short);
    }
    let mut reader = Reader::new(&rest[..length]);
    // Differences of a block: a row of 256 for each byte of an element.
    let mut deltas = vec![0; stride * MOST_ELEMENTS];
    let mut elements = Vec::with_capacity(count * stride);
    for start in (0..count).step_by(block) {
        let length = block.min(count - start);
        let widths = if has_modes { reader.take(channels)? } else { &[] };
        for (byte, row) in deltas.chunks_exact_mut(MOST_ELEMENTS).enumerate() {
            let control = has_modes.then(|| widths[byte / 4] >> (byte % 4 * 2) & 3);
            read_row(&mut reader, control, &mut row[..length.next_multiple_of(GROUP)], length)?;
        }
        for at in 0..length {
            for channel in 0..channels {
                let delta: [u8; 4] = std::array::from_fn(|byte| deltas[(4 * channel + byte) * MOST_ELEMENTS + at]);
                let last = &mut last[4 * channel..4 * channel + 4];
                let old = [last[0], last[1], last[2], last[3]];
                last.copy_from_slice(&moved(old, delta, modes.get(channel).copied().unwrap_or(0)));
            }
            elements.extend_from_slice(&last[..]);
        }
    }
    if reader.is_at_end() { Ok(elements) } else { Err(Fault::Long) }
}

/// Reads the differences of one byte of a block's elements.
fn read_row(reader: &mut Reader, control: Option<u8>, row: &mut [u8], length: usize) -> Result<(), Fault> {
    let widths = match control {
        None => [0, 2, 4, 8],
        Some(0) => [0, 1, 2, 4],
        Some(1) => [1, 2, 4, 8],
        Some(2) => {
            row.fill(0);
            return Ok(());
        }
        Some(_) => {
            row[..length].copy_from_slice(reader.take(length)?);
            return Ok(());
        }
    };
    let header = reader.take((row.len() / GROUP).div_ceil(4))?;
    for (at, group) in row.chunks_exact_mut(GROUP).enumerate() {
        read_group(reader, widths[usize::from(header[at / 4] >> (at % 4 * 2) & 3)], group)?;
    }
    Ok(())
}

/// Reads 16 differences of `width` bits. The largest number of a width stands for a whole byte, which follows.
fn read_group(reader: &mut Reader, width: usize, group: &mut [u8]) -> Result<(), Fault> {
    if width == 0 {
        group.fill(0);
        return Ok(());
    }
    let packed = reader.take(2 * width)?;
    if width == 8 {
        group.copy_from_slice(packed);
        return Ok(());
    }
    let (in_byte, most) = (8 / width, (1 << width) - 1);
    for (at, delta) in group.iter_mut().enumerate() {
        let place = at % in_byte;
        // Single bits begin with the lowest, wider numbers with the highest.
        let shift = if width == 1 { place } else { (in_byte - 1 - place) * width };
        *delta = packed[at / in_byte] >> shift & most;
        if *delta == most {
            *delta = reader.byte()?;
        }
    }
    Ok(())
}

/// Four bytes of an element, by those of the element before and the difference. `mode` tells bytes, pairs and words apart.
fn moved(old: [u8; 4], delta: [u8; 4], mode: u8) -> [u8; 4] {
    match mode & 15 {
        0 => std::array::from_fn(|byte| old[byte].wrapping_add(delta[byte] >> 1 ^ (delta[byte] & 1).wrapping_neg())),
        1 => {
            let pair = |bytes: [u8; 4], at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
            let sum = |at: usize| {
                let delta = pair(delta, at);
                pair(old, at).wrapping_add(delta >> 1 ^ (delta & 1).wrapping_neg()).to_le_bytes()
            };
            let ([a, b], [c, d]) = (sum(0), sum(2));
            [a, b, c, d]
        }
        _ => (u32::from_le_bytes(old) ^ u32::from_le_bytes(delta).rotate_right(u32::from(mode >> 4))).to_le_bytes(),
    }
}

/// The example of the specification: 16 differences of 4 bits, of which two are whole bytes.
#[test]
fn groups_are_those_of_the_specification() {
    let packed = [0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5];
    let mut group = [0; GROUP];
    let mut reader = Reader::new(&packed);
    assert_eq!(read_group(&mut reader, 4, &mut group), Ok(()));
    assert!(reader.is_at_end());
    let deltas = group.map(|delta| moved([0; 4], [delta, 0, 0, 0], 0)[0] as i8);
    assert_eq!(deltas, [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0]);
}
