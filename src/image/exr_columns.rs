//! Writes [`Columns`] by the `exr` crate, which asks for one block of rows after another.

use ::exr::block::BlockIndex;
use ::exr::block::UncompressedBlock;
use ::exr::block::lines::LineRefMut;
use ::exr::image::write::channels::{ChannelsWriter, WritableChannels};
use ::exr::math::RoundingMode;
use ::exr::meta::attribute::{ChannelDescription, ChannelList, LevelMode, SampleType};
use ::exr::meta::header::Header;
use ::exr::prelude::{Text, f16};

use super::columns::Column;

/// Largest half float.
pub const LARGEST_HALF: f32 = 65_504.0;

/// Channels in the order of a file, which is that of their names.
pub struct Channels<'a>(Vec<(Text, Column<'a>)>);

impl<'a> Channels<'a> {
    /// Channels in any order.
    pub fn new(channels: impl IntoIterator<Item = (Text, Column<'a>)>) -> Self {
        let mut channels: Vec<_> = channels.into_iter().collect();
        channels.sort_by(|(a, _), (b, _)| a.cmp(b));
        Self(channels)
    }
}

impl<'file> WritableChannels<'file> for Channels<'_> {
    type Writer = Writer<'file>;

    fn infer_channel_list(&self) -> ChannelList {
        let description = |(name, column): &(Text, Column<'_>)| {
            let kind = match column {
                Column::Floats(_) => SampleType::F32,
                Column::Halves(_) => SampleType::F16,
                Column::Words(_) => SampleType::U32,
            };
            ChannelDescription::new(name.clone(), kind, false)
        };
        ChannelList::new(self.0.iter().map(description).collect())
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_writer(&'file self, header: &Header) -> Writer<'file> {
        Writer { channels: &self.0, width: header.layer_size.0 }
    }
}

/// Makes the blocks of a file.
pub struct Writer<'a> {
    channels: &'a [(Text, Column<'a>)],
    width: usize,
}

impl ChannelsWriter for Writer<'_> {
    fn extract_uncompressed_block(&self, header: &Header, block: BlockIndex) -> Vec<u8> {
        UncompressedBlock::collect_block_data_from_lines(&header.channels, block, |line| self.fill(line))
    }
}

impl Writer<'_> {
    fn fill(&self, line: LineRefMut<'_>) {
        let position = line.location.position;
        let first = position.1 * self.width + position.0;
        let written = match &self.channels[line.location.channel].1 {
            Column::Floats(value) => line.write_samples(|at| value(first + at)),
            Column::Halves(value) => line.write_samples(|at| half(value(first + at))),
            Column::Words(value) => line.write_samples(|at| value(first + at)),
        };
        written.expect("a line has room for its samples");
    }
}

/// Half float nearest to `value`. A value above the largest one becomes the largest one.
fn half(value: f32) -> f16 {
    // A value that is not a number stays so.
    let value = if value > LARGEST_HALF { LARGEST_HALF } else { value };
    f16::from_f32(value)
}
