//! Checks of binary layers (USD's crate files) before they are parsed: what the parser would allocate, how deep it would recurse, and how
//! often it would read a value.

use std::collections::HashMap;

use super::names::check_name;

/// Most elements of an array.
const MOST_ELEMENTS: u64 = 1 << 28;
/// Most bytes that the values of a layer become for each byte of its file, and beside that.
const MOST_PER_BYTE: u64 = 4096;
const MOST_BESIDE: u64 = 64 << 20;
/// Most bytes that the values of a layer become.
const MOST_DECODED: u64 = 8 << 30;
/// Deepest nesting of dictionaries, and of prims.
const MAX_DEPTH: usize = 256;
/// Most bytes of all paths.
const MOST_PATHS: usize = 1 << 30;

/// Reason why a layer is refused.
type Checked<T> = Result<T, String>;

/// A binary layer.
struct Layer<'a> {
    bytes: &'a [u8],
    minor: u8,
    /// Bytes that values may still become.
    left: u64,
    /// Values that may still be visited.
    visits: u64,
    /// For each token, whether it cannot be a name.
    tokens: Vec<bool>,
    /// Numbers of strings and paths.
    strings: usize,
    paths: usize,
}

/// Checks a binary layer. The error says what is wrong.
pub(super) fn check(bytes: &[u8]) -> Checked<()> {
    let [0, minor, _] = bytes.get(8..11).ok_or_else(damaged)? else { return Err(damaged()) };
    if *minor < 4 {
        return Err("it is a USD file of a version before 0.4.0, which is not read; save it again".to_owned());
    }
    let length = bytes.len() as u64;
    let left = MOST_DECODED.min(length.saturating_mul(MOST_PER_BYTE) + MOST_BESIDE);
    let mut layer =
        Layer { bytes, minor: *minor, left, visits: 4 * length + 1024, tokens: Vec::new(), strings: 0, paths: 0 };
    let sections = layer.sections()?;
    let at = |name: &str| sections.get(name).copied();
    let tokens = at("TOKENS").map_or(Ok(Vec::new()), |at| layer.tokens(at))?;
    if let Some(at) = at("STRINGS") {
        let (count, at) = layer.count(at, 4)?;
        layer.strings = count as usize;
        for index in 0..count {
            layer.within(layer.word(at + 4 * index)?.into(), tokens.len())?;
        }
    }
    let reps = at("FIELDS").map_or(Ok(Vec::new()), |at| layer.fields(at, tokens.len()))?;
    let sets = match at("FIELDSETS") {
        Some(at) => {
            let (count, mut at) = (layer.long(at)?, at + 8);
            let sets = layer.integers(&mut at, count)?;
            for &index in sets.iter().filter(|&&index| index != u32::MAX) {
                layer.within(index.into(), reps.len())?;
            }
            sets.len()
        }
        None => 0,
    };
    let paths = at("PATHS").map_or(Ok(0), |at| layer.paths(at, &tokens))?;
    layer.paths = paths;
    if let Some(at) = at("SPECS") {
        let (count, mut at) = (layer.long(at)?, at + 8);
        for bound in [Some(paths), Some(sets), None] {
            let list = layer.integers(&mut at, count)?;
            if let Some(bound) = bound {
                list.iter().try_for_each(|&index| layer.within(index.into(), bound))?;
            }
        }
    }
    reps.iter().try_for_each(|&rep| layer.value(rep, 0))
}

fn damaged() -> String {
    "it is a damaged USD file".to_owned()
}

impl Layer<'_> {
    fn slice(&self, at: u64, length: u64) -> Checked<&[u8]> {
        let (at, end) = (at as usize, at.checked_add(length).ok_or_else(damaged)? as usize);
        self.bytes.get(at..end).ok_or_else(damaged)
    }

    fn long(&self, at: u64) -> Checked<u64> {
        let bytes = self.slice(at, 8)?.try_into().map_err(|_| damaged())?;
        Ok(u64::from_le_bytes(bytes))
    }

    fn word(&self, at: u64) -> Checked<u32> {
        let bytes = self.slice(at, 4)?.try_into().map_err(|_| damaged())?;
        Ok(u32::from_le_bytes(bytes))
    }

    fn within(&self, index: u64, count: usize) -> Checked<()> {
        if index < count as u64 { Ok(()) } else { Err(damaged()) }
    }

    /// Refuses a token that is no name.
    fn name(&self, token: usize) -> Checked<()> {
        match self.tokens.get(token) {
            Some(false) => Ok(()),
            _ => Err(damaged()),
        }
    }

    /// A number of elements of that size, and the place where they begin. They lie within the file.
    fn count(&self, at: u64, size: u64) -> Checked<(u64, u64)> {
        let count = self.long(at)?;
        self.slice(at + 8, count.checked_mul(size).ok_or_else(damaged)?)?;
        Ok((count, at + 8))
    }

    /// Takes bytes from those that values may become.
    fn take(&mut self, count: u64, size: u64) -> Checked<()> {
        let bytes = count.saturating_mul(size);
        let left = (count <= MOST_ELEMENTS).then(|| self.left.checked_sub(bytes)).flatten();
        self.left = left.ok_or("it decompresses to more than a file of its size may")?;
        Ok(())
    }

    /// Places of the sections by their names.
    fn sections(&self) -> Checked<HashMap<String, u64>> {
        let (count, at) = self.count(self.long(16)?, 32)?;
        if count >= 64 {
            return Err(damaged());
        }
        let section = |index: u64| {
            let name = self.slice(at + 32 * index, 16)?;
            let name = name.split(|&byte| byte == 0).next().unwrap_or_default();
            Ok((String::from_utf8_lossy(name).into_owned(), self.long(at + 32 * index + 16)?))
        };
        // As the parser does, the first one of a name counts.
        (0..count).rev().map(section).collect()
    }

    /// Decompresses the block at a place, which then lies behind it, to at most `most` bytes.
    fn block(&mut self, at: &mut u64, most: u64) -> Checked<Vec<u8>> {
        let (length, begin) = self.count(*at, 1)?;
        *at = begin + length;
        self.take(most, 1)?;
        let packed = self.slice(begin, length)?;
        match packed.split_first() {
            Some((0, packed)) => unpack(packed, most as usize).ok_or_else(damaged),
            Some(_) => Err("it has compressed data of more than 127 MB in one piece, which are not read".to_owned()),
            None => Err(damaged()),
        }
    }

    /// Decodes integers at a place, which then lies behind them.
    fn integers(&mut self, at: &mut u64, count: u64) -> Checked<Vec<u32>> {
        // Each integer has a code of two bits, and each byte of the file is at most 255 bytes.
        let packed = self.long(*at)?;
        if count > packed.saturating_mul(4 * 256) {
            return Err(damaged());
        }
        if count == 0 {
            self.block(at, 0)?;
            return Ok(Vec::new());
        }
        let codes = count.div_ceil(4);
        let data = self.block(at, 4 + codes + 4 * count)?;
        self.take(count, 4)?;
        decode(&data, count as usize).ok_or_else(damaged)
    }

    /// Lengths of the tokens.
    fn tokens(&mut self, at: u64) -> Checked<Vec<usize>> {
        let (count, length) = (self.long(at)?, self.long(at + 8)?);
        if length == 0 {
            return if count == 0 { Ok(Vec::new()) } else { Err(damaged()) };
        }
        let packed = self.long(at + 16)?;
        if length > packed.saturating_mul(256) {
            return Err(damaged());
        }
        let text = self.block(&mut (at + 16), length)?;
        let Some((0, text)) = text.split_last() else { return Err(damaged()) };
        let tokens = text.split(|&byte| byte == 0);
        let lengths: Vec<usize> = tokens.clone().map(<[u8]>::len).collect();
        self.tokens = tokens.map(|token| check_name(token).is_err()).collect();
        if lengths.len() as u64 == count { Ok(lengths) } else { Err(damaged()) }
    }

    /// Values of the fields.
    fn fields(&mut self, at: u64, tokens: usize) -> Checked<Vec<u64>> {
        let (count, mut at) = (self.long(at)?, at + 8);
        let names = self.integers(&mut at, count)?;
        names.iter().try_for_each(|&name| self.within(name.into(), tokens))?;
        let bytes = self.block(&mut at, count.saturating_mul(8))?;
        let (reps, rest) = bytes.as_chunks::<8>();
        if reps.len() as u64 != count || !rest.is_empty() {
            return Err(damaged());
        }
        Ok(reps.iter().map(|rep| u64::from_le_bytes(*rep)).collect())
    }

    /// Follows the tree of paths as the parser does. Returns their number.
    fn paths(&mut self, at: u64, tokens: &[usize]) -> Checked<usize> {
        let (all, count, mut at) = (self.long(at)?, self.long(at + 8)?, at + 16);
        let indices = self.integers(&mut at, count)?;
        let names = self.integers(&mut at, count)?;
        let jumps = self.integers(&mut at, count)?;
        // A path has a place in each list but that of the root.
        if all > count.saturating_add(1) {
            return Err(damaged());
        }
        self.take(all, 64)?;
        let mut seen = vec![false; indices.len()];
        let mut bytes = 0_usize;
        let mut pending = if indices.is_empty() { vec![] } else { vec![(0_usize, 0_usize, 0_usize)] };
        while let Some((mut index, mut depth, mut length)) = pending.pop() {
            loop {
                let seen = seen.get_mut(index).ok_or_else(damaged)?;
                if std::mem::replace(seen, true) {
                    return Err(damaged());
                }
                self.within(indices[index].into(), all as usize)?;
                let name = (names[index] as i32).unsigned_abs() as usize;
                let own = length + 1 + tokens.get(name).ok_or_else(damaged)?;
                self.name(name)?;
                bytes = bytes.saturating_add(own);
                if bytes > MOST_PATHS || depth > 2 * MAX_DEPTH {
                    return Err("its prims are nested too deep".to_owned());
                }
                let jump = jumps[index] as i32;
                let (has_child, has_sibling) = (jump > 0 || jump == -1, jump >= 0);
                if has_child && has_sibling {
                    pending.push((index + jump as usize, depth, length));
                }
                if has_child {
                    (depth, length) = (depth + 1, own);
                }
                if !has_child && !has_sibling {
                    break;
                }
                index += 1;
            }
        }
        Ok(all as usize)
    }

    /// Checks a value by its representation.
    fn value(&mut self, rep: u64, depth: usize) -> Checked<()> {
        self.visits = self.visits.checked_sub(1).ok_or("it repeats its values too often")?;
        if depth > MAX_DEPTH {
            return Err(format!("its dictionaries are nested more than {MAX_DEPTH} deep"));
        }
        let (is_array, is_inlined, is_compressed) = (rep >> 63 == 1, rep >> 62 & 1 == 1, rep >> 61 & 1 == 1);
        let (kind, at) = (rep >> 48 & 0xff, rep & 0xffff_ffff_ffff);
        let is_list = matches!(kind, 40 | 41 | 49 | 50);
        if at == 0 && is_array {
            return Ok(());
        }
        if !is_array && matches!(kind, 10 | 11 | 12 | 53 | 57) {
            let index = if is_inlined { at & 0xffff_ffff } else { self.word(at)?.into() };
            let is_token = matches!(kind, 11 | 53) || (is_inlined && kind != 10);
            self.within(index, if is_token { self.tokens.len() } else { self.strings })?;
            return if kind == 11 { self.name(index as usize) } else { Ok(()) };
        }
        // The parser takes no notice of the mark of a value in place here.
        if is_inlined && !is_array && kind != 55 {
            return Ok(());
        }
        // Strings, asset paths and path expressions in arrays are lists of indices with a number before them.
        if is_list || (is_array && matches!(kind, 10 | 12 | 57)) {
            let (count, at) = self.count(at, 4)?;
            let bound = match kind {
                40 => self.paths,
                41 => self.tokens.len(),
                49 => usize::MAX,
                _ => self.strings,
            };
            self.indices(at, count, bound)?;
            // Names of the prims and properties below a prim.
            return match kind {
                41 => (0..count).try_for_each(|index| self.name(self.word(at + 4 * index)? as usize)),
                _ => Ok(()),
            };
        }
        if is_array || kind == 48 {
            return self.array(kind, at, is_compressed);
        }
        match kind {
            31 => self.dictionary(&mut { at }, depth),
            32..=34 | 36..=39 | 54 => self.list(at, |layer, at| {
                let size = if matches!(kind, 37 | 39) { 8 } else { 4 };
                let (count, begin) = layer.count(*at, size)?;
                *at = begin + count * size;
                let bound = match kind {
                    32 => layer.tokens.len(),
                    33 | 54 => layer.strings,
                    34 => layer.paths,
                    _ => return layer.take(count, 64),
                };
                layer.indices(begin, count, bound)
            }),
            35 => self.list(at, |layer, at| {
                let (count, begin) = layer.count(*at, 32)?;
                *at = begin;
                layer.take(count, 128)?;
                (0..count).try_for_each(|_| {
                    *at += 24;
                    layer.dictionary(at, depth)
                })
            }),
            55 => self.list(at, |layer, at| {
                let size = if layer.minor >= 8 { 24 } else { 8 };
                let (count, begin) = layer.count(*at, size)?;
                *at = begin + count * size;
                layer.take(count, 128)
            }),
            45 | 58 => {
                let (count, _) = self.count(at, 8)?;
                self.take(count, 128)
            }
            46 => self.samples(at, depth),
            _ => Ok(()),
        }
    }

    /// Checks indices of tokens, strings or paths.
    fn indices(&mut self, at: u64, count: u64, bound: usize) -> Checked<()> {
        self.take(count, 64)?;
        (0..count).try_for_each(|index| self.within(self.word(at + 4 * index)?.into(), bound))
    }

    /// Checks an array of numbers, vectors or tokens.
    fn array(&mut self, kind: u64, at: u64, is_compressed: bool) -> Checked<()> {
        let mut at = if self.minor < 5 { at + 4 } else { at };
        let count = if self.minor < 7 { self.word(at)?.into() } else { self.long(at)? };
        at += if self.minor < 7 { 4 } else { 8 };
        let size = match kind {
            1 | 2 => 1,
            7 => 2,
            3 | 4 | 8 | 11 | 21 => 4,
            25 => 6,
            5 | 6 | 9 | 18 | 20 | 22 | 29 | 48 | 56 => 8,
            24 | 26 => 12,
            16 | 23 | 27 | 13 => 32,
            14 => 72,
            15 => 128,
            _ => 16,
        };
        self.take(count, if kind == 11 { 64 } else { size })?;
        if !is_compressed || count < 4 || !matches!(kind, 3..=9 | 48 | 56) {
            return self.slice(at, count.checked_mul(size).ok_or_else(damaged)?).map(drop);
        }
        if matches!(kind, 7 | 8 | 9 | 48 | 56) {
            let code = self.slice(at, 1)?[0];
            at += 1;
            if code == b't' {
                let entries = u64::from(self.word(at)?);
                self.slice(at + 4, entries * size)?;
                at += 4 + entries * size;
            }
        }
        let packed = self.long(at)?;
        self.slice(at + 8, packed)?;
        match count > packed.saturating_mul(4 * 256) {
            true => Err(damaged()),
            false => self.take(count, 16),
        }
    }

    /// Checks the lists that a header announces.
    fn list(&mut self, at: u64, mut each: impl FnMut(&mut Self, &mut u64) -> Checked<()>) -> Checked<()> {
        let header = self.slice(at, 1)?[0];
        let mut at = at + 1;
        (1..7).filter(|bit| header >> bit & 1 == 1).try_for_each(|_| each(self, &mut at))
    }

    /// Checks a dictionary at a place, which then lies behind it.
    fn dictionary(&mut self, at: &mut u64, depth: usize) -> Checked<()> {
        let (count, begin) = self.count(*at, 12)?;
        *at = begin;
        self.take(count, 128)?;
        for _ in 0..count {
            // The place of the value is relative to that of the offset.
            let offset = self.long(*at + 4)? as i64;
            let place = (*at as i64 + 4).checked_add(offset).filter(|place| *place >= 0).ok_or_else(damaged)?;
            let rep = self.long(place as u64)?;
            *at = place as u64 + 8;
            self.value(rep, depth + 1)?;
        }
        Ok(())
    }

    fn samples(&mut self, at: u64, depth: usize) -> Checked<()> {
        let jump = |layer: &Self, at: u64| {
            let offset = layer.long(at)? as i64;
            let place = (at as i64).checked_add(offset).filter(|place| *place >= 0);
            place.map(|place| place as u64).ok_or_else(damaged)
        };
        let times = jump(self, at)?;
        self.value(self.long(times)?, depth + 1)?;
        let (count, begin) = self.count(jump(self, times + 8)?, 8)?;
        self.take(count, 64)?;
        (0..count).try_for_each(|index| {
            let rep = self.long(begin + 8 * index)?;
            self.value(rep, depth + 1)
        })
    }
}

/// Decodes integers, each of which is given by its difference from the one before.
fn decode(data: &[u8], count: usize) -> Option<Vec<u32>> {
    let common = i32::from_le_bytes(data.get(..4)?.try_into().ok()?);
    let codes = data.get(4..4 + count.div_ceil(4))?;
    let mut rest = &data[4 + codes.len()..];
    let mut take = |length: usize| {
        let (own, others) = rest.split_at_checked(length)?;
        rest = others;
        Some(own)
    };
    let mut last = 0_i32;
    let mut list = Vec::with_capacity(count);
    // The parser also decodes what fills up the last byte of codes.
    for index in 0..4 * codes.len() {
        let difference = match codes[index / 4] >> (2 * (index % 4)) & 3 {
            0 => common,
            1 => i8::from_le_bytes(take(1)?.try_into().ok()?).into(),
            2 => i16::from_le_bytes(take(2)?.try_into().ok()?).into(),
            _ => i32::from_le_bytes(take(4)?.try_into().ok()?),
        };
        last = last.wrapping_add(difference);
        list.push(last as u32);
    }
    list.truncate(count);
    Some(list)
}

/// Decompresses a block of LZ4 to at most `most` bytes.
fn unpack(mut packed: &[u8], most: usize) -> Option<Vec<u8>> {
    let mut unpacked = Vec::new();
    let mut take = |length: usize| {
        let (own, rest) = packed.split_at_checked(length)?;
        packed = rest;
        Some(own)
    };
    loop {
        let token = take(1)?[0];
        let length = |short: u8, take: &mut dyn FnMut(usize) -> Option<u8>| {
            let mut length = usize::from(short);
            let mut goes_on = short == 15;
            while goes_on {
                let more = take(1)?;
                length += usize::from(more);
                goes_on = more == u8::MAX;
            }
            Some(length)
        };
        let literals = length(token >> 4, &mut |count| take(count).map(|bytes| bytes[0]))?;
        unpacked.extend_from_slice(take(literals)?);
        if unpacked.len() > most {
            return None;
        }
        let Some(offset) = take(2) else { return Some(unpacked) };
        let offset = usize::from(u16::from_le_bytes(offset.try_into().ok()?));
        let count = length(token & 15, &mut |count| take(count).map(|bytes| bytes[0]))? + 4;
        let from = unpacked.len().checked_sub(offset).filter(|_| offset > 0)?;
        if unpacked.len() + count > most {
            return None;
        }
        (0..count).for_each(|at| unpacked.push(unpacked[from + at]));
    }
}
