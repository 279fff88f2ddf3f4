//! Reader of `.vol` files: Mitsuba's grids of numbers, of version 3.

use glam::{DVec3, UVec3};

use crate::scene::grids::Grid;

/// Number by which the format calls values in single precision.
const FLOAT32: u32 = 1;
/// Bytes before the values.
const HEADER: usize = 48;

/// Reads a file. The message of an error goes on after the file's name.
pub(super) fn read(bytes: &[u8]) -> Result<Grid, String> {
    if !bytes.starts_with(b"VOL") {
        return Err("is no `.vol` file: it does not begin with `VOL`".to_owned());
    }
    if bytes.len() < HEADER {
        return Err("is cut off within its header".to_owned());
    }
    let word = |at: usize| u32::from_le_bytes(std::array::from_fn(|i| bytes[at + i]));
    let (version, kind) = (bytes[3], word(4));
    if version != 3 || kind != FLOAT32 {
        return Err(format!(
            "has version {version} and values of type {kind}; only version 3 with single precision (type 1) is supported"
        ));
    }
    let (size, channels) = (UVec3::new(word(8), word(12), word(16)), word(20));
    let has_colors = match channels {
        1 => false,
        3 => true,
        _ => return Err(format!("has {channels} channels; give it 1 or 3")),
    };
    let corner = |at: usize| DVec3::from_array([0, 4, 8].map(|more| f64::from(f32::from_bits(word(at + more)))));
    let corners = [corner(24), corner(36)];
    let count = Grid::count(size, channels)?;
    let there = bytes.len() - HEADER;
    if (there as u64) < 4 * count {
        return Err(format!("is cut off: it has {there} of the {} bytes of its values", 4 * count));
    }
    let values = bytes[HEADER..].chunks_exact(4).take(count as usize);
    let values = values.map(|four| f32::from_le_bytes([four[0], four[1], four[2], four[3]])).collect();
    Ok(Grid { corners, ..Grid::new(size, has_colors, values)? })
}

#[cfg(test)]
mod tests {
    use super::read;

    /// File of 2 x 1 x 1 voxels.
    fn file(values: [f32; 2]) -> Vec<u8> {
        let mut bytes = b"VOL\x03".to_vec();
        for word in [1u32, 2, 1, 1, 1] {
            bytes.extend(word.to_le_bytes());
        }
        for number in [0.0, 0.0, 0.0, 2.0, 1.0, 1.0].into_iter().chain(values) {
            bytes.extend(f32::to_le_bytes(number));
        }
        bytes
    }

    #[test]
    fn files_of_mitsuba_are_read() {
        let grid = read(&file([1.0, 2.5])).expect("a grid");
        assert_eq!((grid.size.to_array(), grid.has_colors, &grid.values[..]), ([2, 1, 1], false, &[1.0, 2.5][..]));
        assert_eq!(grid.corners[1].to_array(), [2.0, 1.0, 1.0]);
        let rounded = read(&file([1.0, -1.0e-8])).expect("a grid");
        assert_eq!(rounded.values[..], [1.0, 0.0]);
    }

    #[test]
    fn bad_files_get_a_sentence() {
        let good = file([1.0, 2.0]);
        let with = |at: usize, word: u32| {
            let mut bytes = good.clone();
            bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
            bytes
        };
        for (bytes, says) in [
            (b"PNG".to_vec(), "is no `.vol` file"),
            (good[..20].to_vec(), "is cut off within its header"),
            (good[..good.len() - 1].to_vec(), "is cut off: it has 7 of the 8 bytes"),
            (with(4, 3), "values of type 3"),
            (with(20, 6), "has 6 channels"),
            (with(8, 0), "which are none"),
            (with(8, 1 << 31), "at most"),
            (with(8, u32::MAX), "at most"),
            (file([1.0, f32::NAN]), "is no finite number"),
            (file([-0.5, 1.0]), "the negative value -0.5"),
        ] {
            let message = read(&bytes).map(drop).expect_err(says);
            assert!(message.contains(says), "{message}");
        }
    }
}
