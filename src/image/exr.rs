//! OpenEXR files. With `exr_columns.rs`, the only file that names the `exr` crate.
//!
//! The data window is the rendered window; the display window is the whole film. Compression is lossless. Colors are linear
//! sRGB, and the header says so.

use std::io::{self, BufReader, Cursor, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;

use ::exr::block::writer::ChunksWriter;
use ::exr::block::{BlockIndex, enumerate_ordered_header_block_indices};
use ::exr::compression::Compression;
use ::exr::meta::attribute::LineOrder;
use ::exr::meta::attribute::{Chromaticities, Matrix4x4};
use ::exr::meta::header::{Header, ImageAttributes, LayerAttributes};
use ::exr::meta::{BlockDescription, MetaData, compute_chunk_count};
use ::exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Encoding, FlatSamples, IntegerBounds, Layer, ReadChannels, ReadLayers,
    Text, Vec2, WritableImage,
};
use glam::Mat4;

pub use super::exr_columns::LARGEST_HALF;

use super::columns::{Columns, MakeRows, Rows};
use super::exr_columns::{blocks_of, channel_list};
use super::exr_limits::PartSize;
use super::layers::{Layers, Samples};
use super::{Image, date, exr_limits, primaries};
use crate::files::write_whole;
use crate::{Error, Result, inputs, quoted};

/// Prefix of every attribute that Lodestar writes.
const ATTRIBUTE_PREFIX: &str = "lodestar.";
/// Primaries and white point of sRGB and of Rec. 709.
const SRGB: Chromaticities = {
    let [red, green, blue, white] = primaries::SRGB;
    Chromaticities {
        red: Vec2(red[0], red[1]),
        green: Vec2(green[0], green[1]),
        blue: Vec2(blue[0], blue[1]),
        white: Vec2(white[0], white[1]),
    }
};

/// Facts in the header of a file, besides windows and channels.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FileHeader {
    /// Text attributes by their names without the prefix `lodestar.`.
    pub attributes: Attributes,
    /// Text attributes of other programs' conventions, by their whole names.
    pub foreign: Attributes,
    /// Matrix from the world to camera space: x to the right, y up, z forward (`worldToCamera`). It multiplies column vectors.
    pub camera_from_world: Option<Mat4>,
    /// Matrix from the world to the picture, in widths and heights of the display window from its top left corner
    /// (`worldToNDC`). It multiplies column vectors.
    pub film_from_world: Option<Mat4>,
}

type Channel = AnyChannel<FlatSamples>;
type Part = Layer<AnyChannels<FlatSamples>>;

/// Writes `layers` as one part. The header has the present time besides `header`.
pub fn write_layers(path: &Path, layers: &Layers, header: &FileHeader) -> Result<()> {
    write_columns(path, &layers.columns(), header, &mut |_| {})
}

/// Writes like [`write_layers`], and calls `tell` with the share that is written, in [0, 1], again and again.
pub fn write_columns(path: &Path, columns: &Columns<'_>, header: &FileHeader, tell: &mut dyn FnMut(f64)) -> Result<()> {
    let mut make = |_, take: &mut dyn FnMut(&Rows<'_>)| {
        take(&Rows { columns, first: 0 });
        Ok(())
    };
    write_rows(path, columns, header, 1, &mut make, tell)
}

/// Writes like [`write_columns`] a file of which `make` makes at least `rows_at_a_time` rows at a time. The columns of `shape` say how
/// the file looks, and are not asked for values. Memory holds these rows only, and the blocks that are being compressed.
pub fn write_rows(
    path: &Path,
    shape: &Columns<'_>,
    header: &FileHeader,
    rows_at_a_time: u32,
    make: MakeRows<'_>,
    tell: &mut dyn FnMut(f64),
) -> Result<()> {
    let header = header_of(shape, header)?;
    let mut failure = None;
    let written = write_whole(path, |writer| {
        let headers = [header].into_iter().collect();
        let write = |meta: MetaData, chunks: &mut _| {
            let indices: Vec<_> = enumerate_ordered_header_block_indices(&meta.headers).collect();
            let blocks_at_a_time = (rows_at_a_time as usize).div_ceil(COMPRESSION.scan_lines_per_block()).max(1);
            let blocks = indices.chunks(blocks_at_a_time).map_while(|indices| {
                let mut blocks = Vec::new();
                let made = make(rows_of(indices), &mut |rows| {
                    blocks.extend(blocks_of(rows, &meta.headers[0].channels, indices));
                });
                made.map_err(|error| failure = Some(error)).ok().map(|()| blocks)
            });
            ChunksWriter::on_progress(chunks, tell).compress_all_blocks_parallel(&meta, blocks.flatten())
        };
        ::exr::block::write(writer, headers, true, write).map_err(io_error)
    });
    failure.map_or(written, Err)
}

/// Compression without loss that makes the smallest files.
const COMPRESSION: Compression = Compression::ZIP16;

/// Rows of the blocks with these indices, of which one follows the other.
fn rows_of(indices: &[(usize, BlockIndex)]) -> Range<u32> {
    let first = indices.first().map_or(0, |(_, block)| block.pixel_position.1);
    let end = indices.last().map_or(0, |(_, block)| block.pixel_position.1 + block.pixel_size.1);
    first as u32..end as u32
}

fn header_of(shape: &Columns<'_>, header: &FileHeader) -> Result<Header> {
    let Columns { width, height, offset, full_size, .. } = *shape;
    let display_window = IntegerBounds::from_dimensions(size(full_size[0], full_size[1]));
    let (layer_size, blocks) = (size(width, height), BlockDescription::ScanLines);
    Ok(Header {
        channels: channel_list(shape),
        compression: COMPRESSION,
        blocks,
        line_order: LineOrder::Increasing,
        layer_size,
        deep: false,
        deep_data_version: None,
        chunk_count: compute_chunk_count(COMPRESSION, layer_size, blocks),
        max_samples_per_pixel: None,
        shared_attributes: ImageAttributes { chromaticities: Some(SRGB), ..ImageAttributes::new(display_window) },
        own_attributes: layer_attributes(offset, header)?,
    })
}

fn channel(name: &str, samples: FlatSamples) -> Channel {
    AnyChannel::new(text(name), samples)
}

/// Matrix as the file has it: row by row, for row vectors. That is column by column for column vectors.
fn matrix(matrix: Mat4) -> Matrix4x4 {
    matrix.to_cols_array()
}

/// Refuses a fixed date that no header can hold, before a render that would end without its file.
///
/// # Errors
/// Where the variable `SOURCE_DATE_EPOCH` is no date.
pub fn check_date() -> Result<()> {
    date::now().map(drop)
}

fn layer_attributes(offset: [u32; 2], header: &FileHeader) -> Result<LayerAttributes> {
    let [x, y] = offset.map(|offset| offset as i32);
    let software = concat!("lodestar ", env!("CARGO_PKG_VERSION"));
    let mut all = LayerAttributes {
        layer_position: Vec2(x, y),
        software_name: Some(text(software)),
        capture_date: Some(text(&date::now()?)),
        // The date is in UTC.
        utc_offset: Some(0.0),
        world_to_camera: header.camera_from_world.map(matrix),
        world_to_normalized_device: header.film_from_world.map(matrix),
        ..LayerAttributes::default()
    };
    let own = header.attributes.iter().map(|(name, value)| (format!("{ATTRIBUTE_PREFIX}{name}"), value));
    for (name, value) in own.chain(header.foreign.iter().map(|(name, value)| (name.clone(), value))) {
        all.other.insert(text(&name), AttributeValue::Text(text(value)));
    }
    Ok(all)
}

/// Text in UTF-8, unchecked: the checked constructor refuses characters outside Latin-1, and scenes may be named in any
/// script.
fn text(string: &str) -> Text {
    Text::from_slice_unchecked(string.as_bytes())
}

fn size(width: u32, height: u32) -> Vec2<usize> {
    Vec2(width as usize, height as usize)
}

fn io_error(error: ::exr::error::Error) -> io::Error {
    match error {
        ::exr::error::Error::Io(error) => error,
        other => io::Error::other(other),
    }
}

/// Reads the color of any flat EXR image: channels `R`, `G`, `B`; else the first prefix that has all three; else `Y`, or the only channel.
/// Colors of other primaries become linear sRGB.
///
/// The image covers the data window. The display window is ignored.
pub fn read_rgb(path: &Path) -> Result<Image> {
    let (mut image, to_srgb) = rgb_of(path, file_of(path, BufReader::new(inputs::open(path)?.0))?)?;
    if let Some(matrix) = to_srgb {
        image.pixels.iter_mut().for_each(|pixel| *pixel = transformed(&matrix, *pixel));
    }
    Ok(image)
}

/// Reads the color of an EXR image in memory, as [`read_rgb`] does, in the file's own primaries. The second value is the matrix that takes
/// them to linear sRGB; `None` where they are that. `path` is its name, for messages.
pub fn decode_rgb(path: &Path, bytes: &[u8]) -> Result<(Image, Option<[[f32; 3]; 3]>)> {
    rgb_of(path, file_of(path, Cursor::new(bytes))?)
}

/// Color by a matrix of rows.
pub fn transformed(matrix: &[[f32; 3]; 3], color: [f32; 3]) -> [f32; 3] {
    matrix.map(|row| row[0] * color[0] + row[1] * color[1] + row[2] * color[2])
}

/// EXR file of a picture, in memory and not compressed. `path` is its name, for messages.
pub fn encode_rgb(path: &Path, image: &Image) -> Result<Vec<u8>> {
    let channel =
        |name, index: usize| channel(name, FlatSamples::F32(image.pixels.iter().map(|pixel| pixel[index]).collect()));
    let channels =
        AnyChannels::sort(["R", "G", "B"].into_iter().zip(0..).map(|(name, at)| channel(name, at)).collect());
    let size = size(image.width, image.height);
    let layer = Layer::new(size, LayerAttributes::default(), Encoding::UNCOMPRESSED, channels);
    let attributes = ImageAttributes::new(IntegerBounds::from_dimensions(size));
    let mut bytes = Cursor::new(Vec::new());
    let written = ::exr::image::Image::new(attributes, layer).write().to_buffered(&mut bytes);
    written.map_err(|error| Error::image(path, error.to_string()))?;
    Ok(bytes.into_inner())
}

fn rgb_of(path: &Path, (parts, chromaticities): File) -> Result<(Image, Option<[[f32; 3]; 3]>)> {
    let found = parts.iter().find_map(|part| Some((part, color_channels(part)?)));
    let (part, channels) = found.ok_or_else(|| {
        Error::image(
            path,
            "it has neither channels R, G, B nor a channel Y, nor a single channel; give a color picture",
        )
    })?;
    // Gray has no primaries.
    let is_gray = std::ptr::eq(channels[0], channels[1]);
    let to_srgb = chromaticities.filter(|_| !is_gray).map(|chromaticities| {
        let Chromaticities { red, green, blue, white } = chromaticities;
        primaries::to_srgb(&[red, green, blue, white].map(|Vec2(x, y)| [x, y]))
    });
    let to_srgb = to_srgb.transpose().map_err(|message| Error::image(path, message))?.flatten();
    Ok((assemble(path, part, channels)?, to_srgb))
}

/// Reads the layer that is stored as channels `<prefix>.*`. A layer has three channels (`R`, `G`, `B` or `X`, `Y`, `Z`)
/// or one, which is repeated.
pub fn read_layer(path: &Path, prefix: &str) -> Result<Image> {
    let parts = read_parts(path)?;
    let found = parts.iter().find_map(|part| Some((part, layer_channels(part, prefix)?)));
    let (part, channels) = found.ok_or_else(|| {
        Error::image(path, format!("it has no layer {prefix}; give a picture that lodestar has written"))
    })?;
    assemble(path, part, channels)
}

/// Names of all channels of a file.
pub fn channel_names(path: &Path) -> Result<Vec<String>> {
    let meta = read_meta(path)?;
    Ok(meta
        .headers
        .iter()
        .flat_map(|header| header.channels.list.iter().map(|channel| name_of(&channel.name)))
        .collect())
}

/// Attributes of a file as names and values.
pub type Attributes = Vec<(String, String)>;

/// Reads a file that [`write_layers`] has written, to the last bit: every channel and the header.
pub fn read_layers(path: &Path) -> Result<(Layers, FileHeader)> {
    let parts = read_parts(path)?;
    let mut header = FileHeader {
        attributes: attributes_of(parts.iter().map(|part| &part.attributes)),
        foreign: foreign_of(parts.iter().map(|part| &part.attributes)),
        ..FileHeader::default()
    };
    let [part] = <[Part; 1]>::try_from(parts).map_err(|_| lacking(path, "one part"))?;
    let position = |at: i32| u32::try_from(at).map_err(|_| lacking(path, "a window within the film"));
    let matrix = |matrix: Option<Matrix4x4>| matrix.map(|matrix| Mat4::from_cols_array(&matrix));
    header.camera_from_world = matrix(part.attributes.world_to_camera);
    header.film_from_world = matrix(part.attributes.world_to_normalized_device);
    let Vec2(x, y) = part.attributes.layer_position;
    let [width, height] = pixel_size(path, &part)?;
    let (offset, full_size) = ([position(x)?, position(y)?], display_size(path)?);
    let channels = part.channel_data.list.into_iter();
    let channels = channels.map(|channel| Ok((name_of(&channel.name), samples_of(path, channel)?)));
    Ok((Layers { width, height, offset, full_size, channels: channels.collect::<Result<_>>()? }, header))
}

fn samples_of(path: &Path, channel: Channel) -> Result<Samples> {
    check_sampling(path, &channel)?;
    Ok(match channel.sample_data {
        FlatSamples::F32(floats) => Samples::Floats(floats),
        FlatSamples::U32(words) => Samples::Words(words),
        FlatSamples::F16(halves) => {
            let floats: Vec<_> = halves.iter().map(|half| half.to_f32()).collect();
            // A writer of halves would alter an infinite one.
            let is_infinite = floats.iter().any(|value| value.is_infinite());
            if is_infinite { Samples::Floats(floats) } else { Samples::Halves(floats) }
        }
    })
}

/// Size of the whole film, from the display window.
fn display_size(path: &Path) -> Result<[u32; 2]> {
    let meta = read_meta(path)?;
    let window = meta.headers.first().map(|header| header.shared_attributes.display_window.size);
    let size = window.and_then(|size| Some([u32::try_from(size.0).ok()?, u32::try_from(size.1).ok()?]));
    size.ok_or_else(|| lacking(path, "a display window"))
}

/// Reads the headers without the pixels.
fn read_meta(path: &Path) -> Result<MetaData> {
    let file = BufReader::new(inputs::open(path)?.0);
    MetaData::read_from_buffered(file, false).map_err(|error| read_error(path, error))
}

/// Error of a file from which `what` is missing.
pub fn lacking(path: &Path, what: &str) -> Error {
    Error::image(path, format!("it lacks {what}; give a picture that this version of lodestar has written"))
}

/// Reads the attributes that [`write_layers`] has written, sorted by name, without the prefix `lodestar.`.
pub fn read_attributes(path: &Path) -> Result<Attributes> {
    let meta = read_meta(path)?;
    Ok(attributes_of(meta.headers.iter().map(|header| &header.own_attributes)))
}

/// Text attributes without the prefix `lodestar.`, sorted by name.
fn foreign_of<'a>(parts: impl Iterator<Item = &'a LayerAttributes>) -> Attributes {
    let of_part = |part: &'a LayerAttributes| {
        part.other.iter().filter_map(|(name, value)| match value {
            AttributeValue::Text(value) => Some((name_of(name), name_of(value))),
            _ => None,
        })
    };
    let all = parts.flat_map(of_part).filter(|(name, _)| !name.starts_with(ATTRIBUTE_PREFIX));
    let mut attributes: Attributes = all.collect();
    attributes.sort();
    attributes
}

fn attributes_of<'a>(parts: impl Iterator<Item = &'a LayerAttributes>) -> Attributes {
    let mut attributes = Vec::new();
    for part in parts {
        for (name, value) in &part.other {
            if let (Some(name), AttributeValue::Text(value)) = (name_of(name).strip_prefix(ATTRIBUTE_PREFIX), value) {
                attributes.push((name.to_owned(), name_of(value)));
            }
        }
    }
    attributes.sort();
    attributes
}

/// Parts of a file, and its primaries where it names them.
type File = (Vec<Part>, Option<Chromaticities>);

fn read_parts(path: &Path) -> Result<Vec<Part>> {
    Ok(file_of(path, BufReader::new(inputs::open(path)?.0))?.0)
}

fn file_of(path: &Path, mut file: impl Read + Seek) -> Result<File> {
    check_size(path, &mut file).and_then(|()| file.rewind().map_err(Error::read(path)))?;
    let parts = ::exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(file)
        .map(|image| (image.layer_data.into_vec(), image.attributes.chromaticities));
    parts.map_err(|error| read_error(path, error))
}

/// Refuses a picture that is too large before memory is allocated for its pixels.
fn check_size(path: &Path, mut file: impl Read + Seek) -> Result<()> {
    let length = file.seek(SeekFrom::End(0)).and_then(|length| file.rewind().map(|()| length));
    let length = length.map_err(Error::read(path))?;
    let meta = MetaData::read_from_buffered(file, false).map_err(|error| read_error(path, error))?;
    let size_of = |header: &Header| PartSize {
        pixels: header.layer_size.0.saturating_mul(header.layer_size.1),
        bytes_per_pixel: header.channels.bytes_per_pixel,
    };
    let parts: Vec<_> = meta.headers.iter().map(size_of).collect();
    exr_limits::check(&parts, length).map_err(|message| Error::image(path, message))
}

fn read_error(path: &Path, error: ::exr::error::Error) -> Error {
    match error {
        ::exr::error::Error::Io(error) => Error::read(path)(error),
        ::exr::error::Error::NotSupported(what) => Error::image(
            path,
            format!("it is a kind of EXR image that is not supported ({what}); save it as a flat one"),
        ),
        other => {
            Error::image(path, format!("it is not a whole EXR image ({}); write it again", quoted::message(&other)))
        }
    }
}

fn name_of(text: &Text) -> String {
    String::from_utf8_lossy(text.bytes()).into_owned()
}

/// Channels of a part by name, in the file's (alphabetic) order.
fn by_name(part: &Part) -> Vec<(String, &Channel)> {
    part.channel_data.list.iter().map(|channel| (name_of(&channel.name), channel)).collect()
}

fn three<'a>(channels: &[(String, &'a Channel)], names: [String; 3]) -> Option<[&'a Channel; 3]> {
    let find = |wanted: &String| channels.iter().find(|(name, _)| name == wanted).map(|&(_, channel)| channel);
    Some([find(&names[0])?, find(&names[1])?, find(&names[2])?])
}

fn color_channels(part: &Part) -> Option<[&Channel; 3]> {
    let channels = by_name(part);
    let prefixes = channels.iter().filter_map(|(name, _)| name.strip_suffix('R'));
    let prefixes = prefixes.filter(|prefix| prefix.is_empty() || prefix.ends_with('.'));
    // The empty prefix comes first: in the file's order, `R` comes after layers whose names start with earlier letters.
    let mut prefixes = std::iter::once("").chain(prefixes);
    let color = prefixes.find_map(|prefix| three(&channels, ["R", "G", "B"].map(|name| format!("{prefix}{name}"))));
    let only = || match channels[..] {
        [(_, only)] => Some(only),
        _ => None,
    };
    color.or_else(|| gray_channel(&channels).or_else(only).map(|channel| [channel; 3]))
}

/// The channel `Y`, unless it is the luminance of a picture that stores color as differences to it.
fn gray_channel<'a>(channels: &[(String, &'a Channel)]) -> Option<&'a Channel> {
    if channels.iter().any(|(name, _)| name == "RY" || name == "BY") {
        return None;
    }
    channels.iter().find(|(name, _)| name == "Y").map(|&(_, channel)| channel)
}

fn layer_channels<'a>(part: &'a Part, prefix: &str) -> Option<[&'a Channel; 3]> {
    let channels = by_name(part);
    let letters = [["R", "G", "B"], ["X", "Y", "Z"]];
    letters.into_iter().find_map(|names| three(&channels, names.map(|name| format!("{prefix}.{name}")))).or_else(|| {
        let mut rest =
            channels.iter().filter(|(name, _)| name.strip_prefix(prefix).is_some_and(|n| n.starts_with('.')));
        let &(_, only) = rest.next()?;
        rest.next().is_none().then_some([only; 3])
    })
}

fn assemble(path: &Path, part: &Part, channels: [&Channel; 3]) -> Result<Image> {
    channels.iter().try_for_each(|channel| check_sampling(path, channel))?;
    let [red, green, blue] = channels.map(|channel| channel.sample_data.values_as_f32());
    let pixels: Vec<_> = red.zip(green).zip(blue).map(|((red, green), blue)| [red, green, blue]).collect();
    let [width, height] = pixel_size(path, part)?;
    Ok(Image { width, height, pixels })
}

fn check_sampling(path: &Path, channel: &Channel) -> Result<()> {
    match channel.sampling {
        Vec2(1, 1) => Ok(()),
        _ => Err(Error::image(path, "its channels are stored at a lower resolution; save them at the full one")),
    }
}

fn pixel_size(path: &Path, part: &Part) -> Result<[u32; 2]> {
    let too_large = |_| Error::image(path, "it is too large; crop it");
    let Vec2(width, height) = part.size;
    Ok([u32::try_from(width).map_err(too_large)?, u32::try_from(height).map_err(too_large)?])
}

#[cfg(test)]
mod tests {
    use ::exr::prelude::f16;

    use super::*;

    use std::path::PathBuf;

    use ::exr::prelude::{Blocks, Compression};
    use glam::Vec3;

    const WIDTH: u32 = 7;
    const HEIGHT: u32 = 5;

    /// Values that differ in every pixel: `first + pixel / 64`, exact in binary.
    fn values(first: f32) -> Samples {
        Samples::Floats((0..WIDTH * HEIGHT).map(|i| first + i as f32 / 64.0).collect())
    }

    fn layers() -> Layers {
        let floats = [("R", 1.0), ("G", 2.0), ("B", 3.0), ("normal.X", -4.0), ("normal.Y", -5.0), ("normal.Z", -6.0)];
        let mut channels: Vec<_> = floats.map(|(name, first)| (name.to_owned(), values(first))).to_vec();
        channels.push(("depth.Z".into(), values(7.0)));
        channels.push(("samples.N".into(), Samples::Words((0..WIDTH * HEIGHT).map(|i| i + 16_777_217).collect())));
        Layers { width: WIDTH, height: HEIGHT, offset: [3, 2], full_size: [20, 10], channels }
    }

    fn folder() -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        (folder, path)
    }

    fn write_channels(path: &Path, compression: Compression, channels: Vec<Channel>) {
        let encoding = Encoding { compression, blocks: Blocks::ScanLines, ..Encoding::SMALL_LOSSLESS };
        let channels = AnyChannels::sort(channels.into_iter().collect());
        let layer = Layer::new(size(2, 1), LayerAttributes::default(), encoding, channels);
        ::exr::image::Image::from_layer(layer).write().to_file(path).unwrap();
    }

    fn float(name: &str, samples: [f32; 2]) -> Channel {
        channel(name, FlatSamples::F32(samples.to_vec()))
    }

    #[test]
    fn layers_come_back_to_the_last_bit() {
        let (_folder, path) = folder();
        let header = FileHeader {
            attributes: vec![("seed".to_owned(), "7".to_owned())],
            foreign: vec![("cryptomatte/be359d6/name".to_owned(), "CryptoObject".to_owned())],
            camera_from_world: Some(Mat4::from_rotation_x(0.5)),
            film_from_world: Some(Mat4::from_translation(Vec3::new(1.0, 2.0, 3.0))),
        };
        write_layers(&path, &layers(), &header).unwrap();
        let mut expected = layers();
        expected.channels.sort_by(|(a, _), (b, _)| a.cmp(b));
        assert_eq!(read_layers(&path).unwrap(), (expected, header));
        let first = |prefix: &str| read_layer(&path, prefix).unwrap().pixels[0];
        assert_eq!((read_rgb(&path).unwrap().pixels[0], first("normal")), ([1.0, 2.0, 3.0], [-4.0, -5.0, -6.0]));
        assert_eq!(first("depth"), [7.0; 3]);
        let error = read_layer(&path, "glow").unwrap_err().to_string();
        assert!(error.contains("a.exr: it has no layer glow"), "{error}");
    }

    #[test]
    fn windows_are_those_of_the_crop() {
        let (_folder, path) = folder();
        write_layers(&path, &layers(), &FileHeader::default()).unwrap();
        let meta = ::exr::meta::MetaData::read_from_file(&path, true).unwrap();
        let header = &meta.headers[0];
        assert_eq!(header.shared_attributes.display_window, IntegerBounds::new((0, 0), (20, 10)));
        assert_eq!(header.data_window(), IntegerBounds::new((3, 2), (WIDTH as usize, HEIGHT as usize)));
    }

    #[test]
    fn attributes_come_back_in_any_script() {
        let (_folder, path) = folder();
        let long = "a_name_that_needs_the_long_names_of_version_2";
        let pairs = [(long, ""), ("device", "llvmpipe (LLVM 15)"), ("scene", "küche-台所.xml"), ("spp", "64")];
        let attributes = pairs.map(|(name, value)| (name.to_owned(), value.to_owned())).to_vec();
        write_layers(&path, &layers(), &FileHeader { attributes: attributes.clone(), ..FileHeader::default() })
            .unwrap();
        assert_eq!(read_attributes(&path).unwrap(), attributes);
    }

    /// Viewers multiply row vectors by a matrix that is stored row by row, so a translation is its last row.
    #[test]
    fn the_header_has_what_viewers_read() {
        let (_folder, path) = folder();
        let shift = Some(Mat4::from_translation(Vec3::new(1.0, 2.0, 3.0)));
        let header = FileHeader { camera_from_world: shift, film_from_world: shift, ..FileHeader::default() };
        write_layers(&path, &layers(), &header).unwrap();
        let meta = MetaData::read_from_file(&path, true).unwrap();
        let (own, shared) = (&meta.headers[0].own_attributes, &meta.headers[0].shared_attributes);
        let expected = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 2.0, 3.0, 1.0];
        assert_eq!((own.world_to_camera, own.world_to_normalized_device), (Some(expected), Some(expected)));
        assert_eq!((shared.chromaticities, own.utc_offset), (Some(SRGB), Some(0.0)));
        let date = name_of(own.capture_date.as_ref().unwrap());
        assert!(date.len() == 19 && date.as_str() > "2020:01:01 00:00:00", "{date}");
    }

    #[test]
    fn halves_are_rounded_and_end_at_the_largest() {
        let (_folder, path) = folder();
        let values = [1.0, 1.0e6, f32::INFINITY, 1.0e-9, 0.1, f32::NAN];
        let channels = vec![("R".to_owned(), Samples::Halves(values.to_vec()))];
        let layers = Layers { width: 6, height: 1, offset: [0, 0], full_size: [6, 1], channels };
        write_layers(&path, &layers, &FileHeader::default()).unwrap();
        let (read, _) = read_layers(&path).unwrap();
        let [one, large, infinite, tiny, tenth, nan] = read.floats("R").unwrap()[..] else { panic!("six values") };
        assert_eq!([one, large, infinite, tiny], [1.0, LARGEST_HALF, LARGEST_HALF, 0.0]);
        assert!(tenth != 0.1 && (tenth / 0.1 - 1.0).abs() < 1.0 / 2048.0 && nan.is_nan(), "{tenth} {nan}");
    }

    #[test]
    fn reads_what_others_write() {
        let (_folder, path) = folder();
        let half = |name: &str, samples: [f32; 2]| channel(name, FlatSamples::F16(samples.map(f16::from_f32).to_vec()));
        let expected = [[0.5, 1.0, 2.0], [0.25, 3.0, 4.0]];
        for compression in [Compression::Uncompressed, Compression::ZIP1, Compression::PIZ, Compression::RLE] {
            let [red, green, blue] = [[0.5, 0.25], [1.0, 3.0], [2.0, 4.0]];
            let alpha = half("A", [1.0, 1.0]);
            write_channels(&path, compression, vec![half("R", red), half("G", green), half("B", blue), alpha]);
            assert_eq!(read_rgb(&path).unwrap().pixels, expected);
            let decoys = [float("Albedo.R", [9.0; 2]), float("Albedo.G", [9.0; 2]), float("Albedo.B", [9.0; 2])];
            let color = [float("R", red), float("G", green), float("B", blue)];
            write_channels(&path, compression, decoys.into_iter().chain(color).collect());
            assert_eq!(read_rgb(&path).unwrap().pixels, expected);
            let color =
                vec![float("View.Combined.R", red), float("View.Combined.G", green), float("View.Combined.B", blue)];
            write_channels(&path, compression, color);
            assert_eq!(read_rgb(&path).unwrap().pixels, expected);
        }
    }

    #[test]
    fn gray_is_repeated_and_color_differences_are_refused() {
        let (_folder, path) = folder();
        write_channels(&path, Compression::ZIP16, vec![float("Y", [0.5, 2.0])]);
        assert_eq!(read_rgb(&path).unwrap().pixels, [[0.5; 3], [2.0; 3]]);
        write_channels(&path, Compression::ZIP16, ["BY", "RY", "Y"].map(|name| float(name, [0.5, 2.0])).to_vec());
        assert!(read_rgb(&path).is_err());
    }

    #[test]
    fn broken_files_are_one_sentence() {
        let (_folder, path) = folder();
        let missing = read_rgb(&path).unwrap_err();
        assert!(matches!(missing, Error::Read { .. }), "{missing}");
        write_layers(&path, &layers(), &FileHeader::default()).unwrap();
        let whole = std::fs::read(&path).unwrap();
        let cuts = (0..whole.len()).step_by(37).map(|length| whole[..length].to_vec());
        for bytes in cuts.chain([b"<scene version=\"3.0.0\"/>".to_vec()]) {
            std::fs::write(&path, &bytes).unwrap();
            let error = read_rgb(&path).unwrap_err();
            assert!(matches!(error, Error::Image { .. }), "{error}");
            assert!(error.to_string().contains("a.exr: ") && !error.to_string().contains('\n'), "{error}");
        }
    }

    #[test]
    fn damaged_files_never_panic() {
        let (_folder, path) = folder();
        write_layers(&path, &layers(), &FileHeader::default()).unwrap();
        let whole = std::fs::read(&path).unwrap();
        for position in 0..whole.len() {
            let mut bytes = whole.clone();
            for mask in [0x41, 0x80] {
                bytes[position] = whole[position] ^ mask;
                std::fs::write(&path, &bytes).unwrap();
                // Either answer is right: a flipped bit in a name or an attribute harms no pixel.
                let _ = read_rgb(&path);
            }
        }
    }

    #[test]
    fn a_header_that_asks_for_too_much_is_refused() {
        let (_folder, path) = folder();
        write_layers(&path, &layers(), &FileHeader::default()).unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        // The attribute's name is followed by its type, its length and the window's four corners.
        let window =
            bytes.windows(10).position(|name| name == b"dataWindow").unwrap() + "dataWindow\0box2i\0".len() + 4;
        for corner in [8, 12] {
            bytes[window + corner..window + corner + 4].copy_from_slice(&1_000_000i32.to_le_bytes());
        }
        std::fs::write(&path, &bytes).unwrap();
        let error = read_rgb(&path).unwrap_err().to_string();
        assert!(error.contains("larger than 2^28 pixels"), "{error}");
    }

    #[test]
    fn a_picture_without_pixels_is_an_error_and_no_file() {
        let (_folder, path) = folder();
        let channels = ["R", "G", "B"].map(|name| (name.to_owned(), Samples::Floats(Vec::new()))).to_vec();
        let empty = Layers { width: 0, height: 0, offset: [0, 0], full_size: [4, 4], channels };
        assert!(write_layers(&path, &empty, &FileHeader::default()).is_err());
        assert!(!path.exists());
    }
}
