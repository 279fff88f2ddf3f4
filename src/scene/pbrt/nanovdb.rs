//! Grids of NanoVDB (Museth 2021, "NanoVDB: A GPU-Friendly and Portable VDB Data Structure"), in files of version 32. A grid is a tree: its
//! root has cubes of 4096 voxels along each side, which have cubes of 128, of 8, and voxels. It becomes a dense grid.

use std::collections::HashSet;
use std::io::Read;

use flate2::read::ZlibDecoder;
use glam::{DMat4, DVec3, UVec3};

use crate::scene::inflate;

/// Marks at the beginning of a file: `NanoVDB0`, and `NanoVDB2` of newer files.
const MARKS: [&[u8; 8]; 2] = [b"NanoVDB0", b"NanoVDB2"];
/// Version whose layout this is.
const VERSION: u32 = 32;
/// Bytes of a file's header and of what it says about each grid.
const HEADER: u64 = 16;
const DESCRIPTION: u64 = 176;
/// Number of a grid of single-precision numbers.
const FLOATS: u32 = 1;
/// Numbers of grids of densities: of an unknown class, and of fog.
const DENSITIES: [u32; 2] = [0, 2];

/// Place of the map from voxels to the medium's space in a grid, and of its tree.
const MAP: u64 = 296;
const TREE: u64 = 672;
/// Nodes from the root's children to the leaves: bytes of a node, binary logarithm of the number of children along each side and of the
/// voxels along each side of a child, places of the mask of children and of the table.
const LEVELS: [Level; 2] = [
    Level { bytes: 270_400, children: 5, voxels: 7, mask: 4128, table: 8256 },
    Level { bytes: 33_856, children: 4, voxels: 3, mask: 544, table: 1088 },
];
/// Bytes of a leaf, which has 8 x 8 x 8 voxels, and place of its numbers.
const LEAF: u64 = 2144;
const LEAF_TABLE: u64 = 96;
/// Most voxels of a dense grid for each byte of its tree, and number that is always granted. A tree of one leaf may name any box.
const VOXELS_PER_BYTE: u64 = 64;
const ALWAYS: u64 = 1 << 22;

const CUT: &str = "ends before its grids do; is it whole?";

struct Level {
    bytes: u64,
    children: u32,
    voxels: u32,
    mask: u64,
    table: u64,
}

/// Dense grid of a tree.
#[derive(Debug)]
pub(super) struct Dense {
    pub size: UVec3,
    /// Numbers, x fastest, then y, then z.
    pub values: Vec<f32>,
    /// Side of the cube of voxels whose mean one number is.
    pub step: u64,
    /// Voxels of the tree along each axis.
    pub voxels: [u64; 3],
    /// Unit cube to the box of the grid in the medium's space.
    pub from_unit: DMat4,
}

/// The first grid of that name, with at most `most` numbers; `None` where the file has none. The message of an error goes on after the name
/// of the file.
pub(super) fn read(file: &[u8], name: &str, most: u64) -> Result<Option<Dense>, String> {
    let file = Bytes(file);
    let mut at = 0;
    while at < file.0.len() as u64 {
        let mark: [u8; 8] = file.at(at)?;
        if !MARKS.contains(&&mark) {
            return Err(if at == 0 { "is no file of NanoVDB" } else { CUT }.to_owned());
        }
        let version = file.u32(at + 8)? >> 21;
        if version != VERSION {
            return Err(format!(
                "has the version {version} of NanoVDB; write it with version {VERSION}, which pbrt reads"
            ));
        }
        let count = u16::from_le_bytes(file.at(at + 12)?);
        let mut place = at + HEADER;
        let mut grids = Vec::new();
        for _ in 0..count {
            let length = u64::from(file.u32(place + 136)?);
            let called = file.slice(place + DESCRIPTION, length)?;
            grids.push((place, called.split(|byte| *byte == 0).next() == Some(name.as_bytes())));
            place += DESCRIPTION + length;
        }
        for (description, is_wanted) in grids {
            let stored = file.u64(description + 8)?;
            let content = file.slice(place, stored)?;
            if is_wanted {
                let tree = content_of(&file, description, content)?;
                return dense(&Bytes(&tree), most).map(Some);
            }
            place += stored;
        }
        at = place;
    }
    Ok(None)
}

/// Bytes of a grid.
fn content_of(file: &Bytes, description: u64, content: &[u8]) -> Result<Vec<u8>, String> {
    let (length, kind, class) = (file.u64(description)?, file.u32(description + 32)?, file.u32(description + 36)?);
    if kind != FLOATS {
        return Err("has a grid that is not of single-precision numbers, the only ones that pbrt reads".to_owned());
    }
    if !DENSITIES.contains(&class) {
        return Err("has a grid that is no fog volume".to_owned());
    }
    let bytes = match u16::from_le_bytes(file.at(description + 168)?) {
        0 => content.to_vec(),
        1 => {
            let packed = Bytes(content);
            let packed = packed.slice(8, packed.u64(0)?)?;
            let limit = inflate::most_bytes(packed.len() as u64);
            if length > limit {
                return Err(format!("has a grid that cannot be unpacked: {}", inflate::TOO_LONG));
            }
            let mut bytes = Vec::new();
            let unpacked = ZlibDecoder::new(packed).take(length + 1).read_to_end(&mut bytes);
            unpacked.map_err(|error| format!("has a grid that cannot be unpacked: {error}"))?;
            bytes
        }
        _ => return Err("is compressed by Blosc; write it with ZIP or without compression".to_owned()),
    };
    if bytes.len() as u64 == length { Ok(bytes) } else { Err(CUT.to_owned()) }
}

fn dense(grid: &Bytes, most: u64) -> Result<Dense, String> {
    let root = TREE.saturating_add(grid.u64(TREE + 24)?);
    if root > grid.0.len() as u64 {
        return Err(CUT.to_owned());
    }
    let corner = |at: u64| -> Result<[i64; 3], String> {
        let number = |axis: u64| grid.u32(root + at + 4 * axis).map(|number| i64::from(number as i32));
        Ok([number(0)?, number(1)?, number(2)?])
    };
    let (low, high) = (corner(0)?, corner(12)?);
    if (0..3).any(|axis| high[axis] < low[axis]) {
        return Err("has a grid without voxels".to_owned());
    }
    let background = grid.f32(root + 28)?;
    let voxels = [0, 1, 2].map(|axis| (high[axis] - low[axis] + 1) as u64);
    let most = most.min((VOXELS_PER_BYTE * grid.0.len() as u64).max(ALWAYS));
    let mut step = 1;
    // The layer above the last voxels is the background, to which pbrt interpolates.
    let size = loop {
        let size = voxels.map(|count| (count + 1).div_ceil(step));
        let count = size.into_iter().try_fold(1, u64::checked_mul);
        if count.is_some_and(|count| count <= most) {
            break size;
        }
        step *= 2;
    };
    let count = size.iter().product::<u64>() as usize;
    let fill = Fill { low, voxels, size, step, background, values: vec![background; count] };
    let mut walk =
        Walk { grid, fill, left: [LEVELS[0].bytes, LEVELS[1].bytes, LEAF].map(|bytes| grid.0.len() as u64 / bytes) };
    walk.root(root)?;
    let values = walk.fill.values;
    let number = |at: u64| grid.f64(MAP + at);
    let mut columns = [0.0; 16];
    for row in 0..3 {
        for column in 0..3 {
            columns[4 * column + row] = number(88 + 8 * (3 * row + column) as u64)?;
        }
        columns[12 + row] = number(232 + 8 * row as u64)?;
    }
    columns[15] = 1.0;
    let origin = DVec3::from_array(low.map(|low| low as f64 - 0.5));
    let extent = DVec3::from_array(size.map(|count| (count * step) as f64));
    let from_unit = DMat4::from_cols_array(&columns) * DMat4::from_translation(origin) * DMat4::from_scale(extent);
    Ok(Dense { size: UVec3::from_array(size.map(|count| count as u32)), values, step, voxels, from_unit })
}

/// Walk through a tree. `left` has how many nodes of each level the bytes have place for: in a broken tree, nodes may have the same children.
struct Walk<'a> {
    grid: &'a Bytes<'a>,
    fill: Fill,
    left: [u64; 3],
}

impl Walk<'_> {
    fn root(&mut self, root: u64) -> Result<(), String> {
        const TILES: u64 = 64;
        const TILE: u64 = 32;
        let mut known = HashSet::new();
        for tile in 0..u64::from(self.grid.u32(root + 24)?) {
            let at = root + TILES + TILE * tile;
            let (key, child) = (self.grid.u64(at)?, self.grid.u64(at + 8)?);
            // Numbers of cubes along x, y and z. The upper bits of the coordinates are lost to the width of a coordinate.
            let corner = [key >> 42, key >> 21, key].map(|number| i64::from(((number as u32) << 12) as i32));
            if !known.insert(corner) {
                return Err("has a grid with two cubes in one place".to_owned());
            }
            match child {
                0 => self.fill.cube(corner, 1 << 12, self.grid.f32(at + 20)?),
                _ => self.inner(0, root.checked_add(child).ok_or(CUT)?, corner)?,
            }
        }
        Ok(())
    }

    fn inner(&mut self, level: usize, node: u64, corner: [i64; 3]) -> Result<(), String> {
        self.enter(level)?;
        let Level { bytes, children, voxels, mask, table } = LEVELS[level];
        let bytes = Bytes(self.grid.slice(node, bytes)?);
        for index in 0..1_u64 << (3 * children) {
            let entry = table + 8 * index;
            let is_child = bytes.u64(mask + index / 64 * 8)? >> (index % 64) & 1 == 1;
            let value = bytes.f32(entry)?;
            // Most of a table is empty.
            if !is_child && value == self.fill.background {
                continue;
            }
            let corner = child_corner(corner, index, children, voxels);
            if !is_child {
                self.fill.cube(corner, 1 << voxels, value);
                continue;
            }
            let child = node.checked_add(bytes.u64(entry)?).ok_or(CUT)?;
            match level {
                0 => self.inner(1, child, corner)?,
                _ => self.leaf(child, corner)?,
            }
        }
        Ok(())
    }

    fn leaf(&mut self, leaf: u64, corner: [i64; 3]) -> Result<(), String> {
        self.enter(2)?;
        let bytes = Bytes(self.grid.slice(leaf, LEAF)?);
        for index in 0..512 {
            self.fill.cube(child_corner(corner, index, 3, 0), 1, bytes.f32(LEAF_TABLE + 4 * index)?);
        }
        Ok(())
    }

    fn enter(&mut self, level: usize) -> Result<(), String> {
        self.left[level] =
            self.left[level].checked_sub(1).ok_or("has a grid whose tree has the same nodes in several places")?;
        Ok(())
    }
}

/// Corner of a child. Children lie z fastest, then y, then x.
fn child_corner(corner: [i64; 3], index: u64, children: u32, voxels: u32) -> [i64; 3] {
    let along = |axis: u32| (index >> (children * (2 - axis)) & ((1 << children) - 1)) as i64;
    [0, 1, 2].map(|axis| corner[axis] + (along(axis as u32) << voxels))
}

/// Dense grid that is filled by cubes of voxels.
struct Fill {
    low: [i64; 3],
    voxels: [u64; 3],
    size: [u64; 3],
    step: u64,
    background: f32,
    values: Vec<f32>,
}

impl Fill {
    /// Fills a cube of voxels of one value, where it lies within the grid.
    fn cube(&mut self, corner: [i64; 3], side: i64, value: f32) {
        if value == self.background {
            return;
        }
        let step = self.step;
        let range = |axis: usize| {
            let from = (corner[axis] - self.low[axis]).max(0) as u64;
            let to = (corner[axis] + side - self.low[axis]).clamp(0, self.voxels[axis] as i64) as u64;
            (from < to).then_some((from, to))
        };
        let (Some(x), Some(y), Some(z)) = (range(0), range(1), range(2)) else { return };
        let more = value - self.background;
        // Numbers along an axis, each with the share of it that the cube covers.
        let shares = |(from, to): (u64, u64)| {
            (from / step..to.div_ceil(step)).map(move |cell| {
                let covered = to.min((cell + 1) * step) - from.max(cell * step);
                (cell, covered as f32 / step as f32)
            })
        };
        for (z, share_z) in shares(z) {
            for (y, share_y) in shares(y) {
                let row = (z * self.size[1] + y) * self.size[0];
                for (x, share_x) in shares(x) {
                    self.values[(row + x) as usize] += more * (share_x * share_y * share_z);
                }
            }
        }
    }
}

/// Bytes, read in the order of little endian.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn slice(&self, at: u64, length: u64) -> Result<&'a [u8], String> {
        let end = at.checked_add(length).and_then(|end| usize::try_from(end).ok());
        end.and_then(|end| self.0.get(at as usize..end)).ok_or_else(|| CUT.to_owned())
    }

    fn at<const N: usize>(&self, at: u64) -> Result<[u8; N], String> {
        let bytes = self.slice(at, N as u64)?;
        Ok(std::array::from_fn(|index| bytes[index]))
    }

    fn u32(&self, at: u64) -> Result<u32, String> {
        self.at(at).map(u32::from_le_bytes)
    }

    fn u64(&self, at: u64) -> Result<u64, String> {
        self.at(at).map(u64::from_le_bytes)
    }

    fn f32(&self, at: u64) -> Result<f32, String> {
        self.at(at).map(f32::from_le_bytes)
    }

    fn f64(&self, at: u64) -> Result<f64, String> {
        self.at(at).map(f64::from_le_bytes)
    }
}
