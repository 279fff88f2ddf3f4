//! Blocks of an EXR file's rows, made from [`Columns`] when their turn comes.

use ::exr::block::lines::LineRefMut;
use ::exr::block::{BlockIndex, UncompressedBlock};
use ::exr::meta::attribute::{ChannelDescription, ChannelList, SampleType};
use ::exr::prelude::{Text, f16};

use super::columns::{Column, Columns, Rows};

/// Largest half float.
pub const LARGEST_HALF: f32 = 65_504.0;

/// Channels of a file, in its order, which is that of their names.
pub fn channel_list(columns: &Columns<'_>) -> ChannelList {
    let description = |at: usize| {
        let (name, column) = &columns.channels[at];
        let kind = match column {
            Column::Floats(_) => SampleType::F32,
            Column::Halves(_) => SampleType::F16,
            Column::Words(_) => SampleType::U32,
        };
        ChannelDescription::new(Text::from_slice_unchecked(name.as_bytes()), kind, false)
    };
    ChannelList::new(order(columns).into_iter().map(description).collect())
}

/// The blocks with these indices, which lie within `rows`.
pub fn blocks_of<'a>(
    rows: &'a Rows<'_>,
    channels: &'a ChannelList,
    indices: &'a [(usize, BlockIndex)],
) -> impl Iterator<Item = (usize, UncompressedBlock)> + use<'a> {
    let order = order(rows.columns);
    indices.iter().map(move |&(at, index)| {
        let fill = |line: LineRefMut<'_>| fill(line, rows, &order);
        (at, UncompressedBlock { index, data: UncompressedBlock::collect_block_data_from_lines(channels, index, fill) })
    })
}

/// Places of the channels in the order of a file.
fn order(columns: &Columns<'_>) -> Vec<usize> {
    let mut order: Vec<_> = (0..columns.channels.len()).collect();
    order.sort_by_key(|&at| &columns.channels[at].0);
    order
}

fn fill(line: LineRefMut<'_>, rows: &Rows<'_>, order: &[usize]) {
    let position = line.location.position;
    let first = (position.1 - rows.first as usize) * rows.columns.width as usize + position.0;
    let written = match &rows.columns.channels[order[line.location.channel]].1 {
        Column::Floats(value) => line.write_samples(|at| value(first + at)),
        Column::Halves(value) => line.write_samples(|at| half(value(first + at))),
        Column::Words(value) => line.write_samples(|at| value(first + at)),
    };
    written.expect("a line has room for its samples");
}

/// Half float nearest to `value`. A value above the largest one becomes the largest one.
fn half(value: f32) -> f16 {
    // A value that is not a number stays so.
    let value = if value > LARGEST_HALF { LARGEST_HALF } else { value };
    f16::from_f32(value)
}
