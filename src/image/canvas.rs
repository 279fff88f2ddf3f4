//! Files of color alone, for other programs: PNG, JPEG and TIFF for screens, and Radiance HDR with linear values.

use std::cell::RefCell;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::ops::Range;
use std::path::Path;

use ::image::codecs::hdr::HdrEncoder;
use ::image::codecs::jpeg::JpegEncoder;
use ::image::{GenericImageView, Rgb};
use tiff::encoder::TiffEncoder;
use tiff::encoder::colortype::RGB16;

use super::{Image, ToneCurve, rows_at_a_time};
use crate::files::{has_extension, write_whole};
use crate::{Error, Result};

/// Formats of color files by the endings of their names.
const ENDINGS: [(&str, Format); 6] = [
    ("png", Format::Png),
    ("jpg", Format::Jpeg),
    ("jpeg", Format::Jpeg),
    ("tif", Format::Tiff),
    ("tiff", Format::Tiff),
    ("hdr", Format::Hdr),
];
/// Quality of JPEG files, from 1 to 100.
const JPEG_QUALITY: u8 = 95;
/// Most pixels of a side of a JPEG file.
const LONGEST_JPEG: u32 = 65_535;
/// Most bytes of a TIFF file beside its pixels. Its strips have a megabyte at least, and each takes eight bytes.
const TIFF_HEAD: u32 = 1 << 16;
/// Largest value of an HDR file. Its exponents end at 2^127.
const LARGEST_HDR: f32 = 1.0e38;

/// Format of a file of color alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// 8 bits per channel, without loss.
    Png,
    /// 8 bits per channel, with loss.
    Jpeg,
    /// 16 bits per channel, not compressed.
    Tiff,
    /// Radiance's RGBE: linear values, 8 bits per channel and a common exponent.
    Hdr,
}

impl Format {
    /// Format that the ending of a name asks for; `None` for other names, such as those of EXR files.
    pub fn of(path: &Path) -> Option<Self> {
        ENDINGS.iter().find(|(ending, _)| has_extension(path, ending)).map(|&(_, format)| format)
    }

    /// Bytes of a pixel before they are compressed.
    fn bytes_per_pixel(self) -> u64 {
        match self {
            Self::Png | Self::Jpeg => 3,
            Self::Tiff => 6,
            Self::Hdr => 12,
        }
    }

    /// Why the format cannot hold a picture of this width and height; `None` where it can.
    pub fn fault_of_size(self, [width, height]: [u32; 2]) -> Option<String> {
        let bytes = self.bytes_per_pixel().saturating_mul(u64::from(width) * u64::from(height));
        match self {
            Self::Jpeg if width.max(height) > LONGEST_JPEG => {
                Some(format!("a JPEG file has at most {LONGEST_JPEG} pixels a side"))
            }
            Self::Tiff if bytes > u64::from(u32::MAX - TIFF_HEAD) => Some("a TIFF file holds less than 4 GiB".into()),
            _ => None,
        }
    }

    /// Whether tone curve and exposure make the values, for a screen.
    pub fn is_for_screens(self) -> bool {
        self != Self::Hdr
    }
}

/// Form of a file of color alone: its format, its size, and how colors are shown.
#[derive(Debug, Clone, Copy)]
pub struct Canvas {
    format: Format,
    size: [u32; 2],
    curve: ToneCurve,
    scale: f64,
}

/// Puts the colors of the rows that are asked for into the vector, which is empty. Rows are asked for once, from the top to the bottom.
pub type ReadRows<'a> = &'a mut dyn FnMut(Range<u32>, &mut Vec<[f32; 3]>) -> Result<()>;

impl Canvas {
    /// A picture of this width and height. For screens, colors are scaled by `2^exposure_stops` and shown through `curve`.
    pub fn new(format: Format, size: [u32; 2], curve: ToneCurve, exposure_stops: f32) -> Self {
        Self { format, size, curve, scale: f64::from(exposure_stops).exp2() }
    }

    /// Writes the file, whole or not at all. `pixels` go row by row from the top left. Calls `tell` with the share that is written, in
    /// [0, 1], again and again.
    ///
    /// # Errors
    /// Where the file cannot be written, or its format has not so many pixels.
    pub fn write(&self, path: &Path, pixels: &[[f32; 3]], tell: &mut dyn FnMut(f64)) -> Result<()> {
        self.write_rows(path, &mut rows_of(pixels, self.size[0]), tell)
    }

    /// Writes like [`Canvas::write`] a picture of which `read` gives [`rows_at_a_time`]. Memory holds these rows only.
    ///
    /// # Errors
    /// Where `read` fails, where the file cannot be written, or where its format has not so many pixels.
    pub fn write_rows(&self, path: &Path, read: ReadRows<'_>, tell: &mut dyn FnMut(f64)) -> Result<()> {
        let mut feed = Feed::new(self, read, tell);
        let written = write_whole(path, |writer| self.encode(writer, &mut feed));
        feed.failure.map_or(written, Err)
    }

    fn encode(&self, writer: &mut BufWriter<File>, feed: &mut Feed<'_>) -> io::Result<()> {
        if let Some(fault) = self.format.fault_of_size(self.size) {
            return Err(io::Error::other(format!("{fault}; write an .exr file")));
        }
        match self.format {
            Format::Png => encode_png(writer, feed),
            Format::Jpeg => encode_jpeg(writer, feed),
            Format::Tiff => encode_tiff(writer, feed),
            Format::Hdr => encode_hdr(writer, feed),
        }
    }

    /// The three levels of a color on a screen, of which `most` is the largest.
    fn levels(&self, color: &[f32; 3], most: f64) -> [f64; 3] {
        self.curve.apply(color.map(|value| f64::from(value) * self.scale)).map(|value| level(value, most))
    }
}

/// Writes an image as a PNG file to any writer.
///
/// # Errors
/// Where the writer fails, or the image has no pixels.
pub fn encode_image_as_png(
    mut writer: impl Write,
    image: &Image,
    curve: ToneCurve,
    exposure_stops: f32,
) -> io::Result<()> {
    let canvas = Canvas::new(Format::Png, [image.width, image.height], curve, exposure_stops);
    let mut read = rows_of(&image.pixels, image.width);
    encode_png(&mut writer, &mut Feed::new(&canvas, &mut read, &mut |_| {}))
}

/// Reader of the rows of a picture in memory.
fn rows_of(pixels: &[[f32; 3]], width: u32) -> impl FnMut(Range<u32>, &mut Vec<[f32; 3]>) -> Result<()> {
    let width = width as usize;
    move |rows, colors| {
        colors.extend_from_slice(&pixels[rows.start as usize * width..rows.end as usize * width]);
        Ok(())
    }
}

/// Rows of a picture, as an encoder asks for them.
struct Feed<'a> {
    canvas: &'a Canvas,
    /// Row after those that `colors` holds.
    end: u32,
    colors: Vec<[f32; 3]>,
    read: ReadRows<'a>,
    tell: &'a mut dyn FnMut(f64),
    /// Why rows could not be read.
    failure: Option<Error>,
}

impl<'a> Feed<'a> {
    fn new(canvas: &'a Canvas, read: ReadRows<'a>, tell: &'a mut dyn FnMut(f64)) -> Self {
        Self { canvas, end: 0, colors: Vec::new(), read, tell, failure: None }
    }

    /// The next rows; `None` after the last ones. Those before them are written.
    fn next(&mut self) -> io::Result<Option<&[[f32; 3]]>> {
        let [width, height] = self.canvas.size;
        (self.tell)(f64::from(self.end) / f64::from(height.max(1)));
        if self.end >= height {
            return Ok(None);
        }
        let rows = self.end..height.min(self.end.saturating_add(rows_at_a_time(width)));
        self.end = rows.end;
        self.colors.clear();
        (self.read)(rows, &mut self.colors).map_err(|error| {
            let message = error.to_string();
            self.failure = Some(error);
            io::Error::other(message)
        })?;
        Ok(Some(&self.colors))
    }
}

fn encode_png(writer: &mut dyn Write, feed: &mut Feed<'_>) -> io::Result<()> {
    let Feed { canvas, .. } = *feed;
    let [width, height] = canvas.size;
    let mut encoder = png::Encoder::new(writer, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::Filter::Adaptive);
    let mut file = encoder.write_header()?;
    let mut stream = file.stream_writer()?;
    while let Some(colors) = feed.next()? {
        let levels: Vec<u8> = colors.iter().flat_map(|color| canvas.levels(color, 255.0).map(|v| v as u8)).collect();
        stream.write_all(&levels)?;
    }
    stream.finish()?;
    Ok(file.finish()?)
}

fn encode_tiff(writer: &mut BufWriter<File>, feed: &mut Feed<'_>) -> io::Result<()> {
    let Feed { canvas, .. } = *feed;
    let [width, height] = canvas.size;
    let mut file = TiffEncoder::new(writer).map_err(io::Error::other)?;
    let mut image = file.new_image::<RGB16>(width, height).map_err(io::Error::other)?;
    image.rows_per_strip(rows_at_a_time(width)).map_err(io::Error::other)?;
    while let Some(colors) = feed.next()? {
        let levels: Vec<u16> =
            colors.iter().flat_map(|color| canvas.levels(color, 65_535.0).map(|v| v as u16)).collect();
        image.write_strip(&levels).map_err(io::Error::other)?;
    }
    image.finish().map_err(io::Error::other)
}

/// Rows of a HDR file are encoded each by itself, so a file is that of its first rows with those of others below.
fn encode_hdr(writer: &mut dyn Write, feed: &mut Feed<'_>) -> io::Result<()> {
    // Negative values and NaN become 0.
    let bounded = |value: f32| if value > 0.0 { value.min(LARGEST_HDR) } else { 0.0 };
    let [width, height] = feed.canvas.size;
    let size = |rows: usize| format!("-Y {rows} +X {width}\n");
    let mut is_first = true;
    while let Some(colors) = feed.next()? {
        let rows = colors.len() / width.max(1) as usize;
        let colors: Vec<_> = colors.iter().map(|color| Rgb(color.map(bounded))).collect();
        let mut file = Vec::new();
        HdrEncoder::new(&mut file).encode(&colors, width as usize, rows).map_err(io::Error::other)?;
        let own = size(rows);
        let head = file.windows(own.len()).position(|bytes| bytes == own.as_bytes());
        let head = head.ok_or_else(|| io::Error::other("its encoder writes no size"))?;
        if std::mem::take(&mut is_first) {
            writer.write_all(&file[..head])?;
            writer.write_all(size(height as usize).as_bytes())?;
        }
        writer.write_all(&file[head + own.len()..])?;
    }
    Ok(())
}

fn encode_jpeg(writer: &mut dyn Write, feed: &mut Feed<'_>) -> io::Result<()> {
    let shown = Shown { size: feed.canvas.size, rows: RefCell::new(ShownRows { feed, levels: Vec::new(), end: 0 }) };
    let encoded = JpegEncoder::new_with_quality(writer, JPEG_QUALITY).encode_image(&shown);
    let feed = shown.rows.into_inner().feed;
    encoded.map_err(io::Error::other)?;
    match &feed.failure {
        Some(failure) => Err(io::Error::other(failure.to_string())),
        None => feed.next().map(drop),
    }
}

/// A picture on a screen. The JPEG encoder asks for its pixels by blocks of 8 x 8: for all of eight rows before those below.
struct Shown<'f, 'a> {
    size: [u32; 2],
    rows: RefCell<ShownRows<'f, 'a>>,
}

/// The rows of a picture on a screen that were asked for last.
struct ShownRows<'f, 'a> {
    feed: &'f mut Feed<'a>,
    levels: Vec<[u8; 3]>,
    /// Row after those that `levels` holds.
    end: u32,
}

impl GenericImageView for Shown<'_, '_> {
    type Pixel = Rgb<u8>;

    fn dimensions(&self) -> (u32, u32) {
        self.size.into()
    }

    /// A pixel; black where rows cannot be read, which [`Feed::failure`] tells.
    fn get_pixel(&self, x: u32, y: u32) -> Rgb<u8> {
        let ShownRows { feed, levels, end } = &mut *self.rows.borrow_mut();
        while y >= *end && feed.failure.is_none() {
            let canvas = feed.canvas;
            let Ok(Some(colors)) = feed.next() else { break };
            levels.clear();
            levels.extend(colors.iter().map(|color| canvas.levels(color, 255.0).map(|level| level as u8)));
            *end = feed.end;
        }
        let first = (*end as usize).saturating_sub(levels.len() / self.size[0].max(1) as usize);
        let at = (y as usize).checked_sub(first).map(|row| row * self.size[0] as usize + x as usize);
        Rgb(at.and_then(|at| levels.get(at)).copied().unwrap_or_default())
    }
}

/// Level nearest to a value in [0, 1], of which `most` is the largest. Values outside are clamped, and NaN becomes 0.
fn level(value: f64, most: f64) -> f64 {
    (most * value).round()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::texels::{self, FileTexels};

    const COLORS: [[f32; 3]; 4] = [[1.0, 0.0, 0.5], [0.25, 7.0, f32::NAN], [-1.0, 0.001, f32::INFINITY], [0.2; 3]];

    fn written(name: &str) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        Canvas::new(Format::of(&path).unwrap(), [2, 2], ToneCurve::Srgb, 0.0)
            .write(&path, &COLORS, &mut |_| {})
            .unwrap();
        (folder, path)
    }

    #[test]
    fn endings_have_formats() {
        let of = |name: &str| Format::of(Path::new(name));
        assert_eq!([of("a.JPG"), of("a.jpeg")], [Some(Format::Jpeg); 2]);
        assert_eq!([of("a.tif"), of("a.Tiff")], [Some(Format::Tiff); 2]);
        assert_eq!((of("a.png"), of("a.hdr"), of("a.exr")), (Some(Format::Png), Some(Format::Hdr), None));
    }

    #[test]
    fn formats_have_limits() {
        let fits = |format: Format, size| format.fault_of_size(size).is_none();
        assert!(fits(Format::Jpeg, [65_535, 2]) && !fits(Format::Jpeg, [2, 65_536]));
        assert!(fits(Format::Tiff, [26_754, 26_754]) && !fits(Format::Tiff, [26_755, 26_755]));
        assert!(fits(Format::Png, [65_536, 65_536]) && fits(Format::Hdr, [65_536, 65_536]));
    }

    /// A file of four strips: before each is read, those before it are encoded, and their share is told. No more rows are in memory.
    #[test]
    fn shares_are_told_from_the_first_row_to_the_last() {
        let folder = tempfile::tempdir().unwrap();
        let size = [4096, 250];
        let step = rows_at_a_time(size[0]);
        let value = |x: u32, y: u32| [x as f32 / 4096.0, y as f32 / 250.0, 0.25];
        for name in ["a.png", "a.jpg", "a.tif", "a.hdr"] {
            let path = folder.path().join(name);
            let asked = RefCell::new(Vec::new());
            let mut read = |rows: Range<u32>, colors: &mut Vec<[f32; 3]>| {
                assert!(colors.is_empty(), "{name}");
                asked.borrow_mut().push(rows.clone());
                colors.extend(rows.flat_map(|y| (0..size[0]).map(move |x| value(x, y))));
                Ok(())
            };
            let mut told = Vec::new();
            let mut tell = |share: f64| told.push((share, asked.borrow().len()));
            let canvas = Canvas::new(Format::of(&path).unwrap(), size, ToneCurve::Srgb, 0.0);
            canvas.write_rows(&path, &mut read, &mut tell).unwrap();
            assert_eq!(*asked.borrow(), [0..step, step..2 * step, 2 * step..3 * step, 3 * step..250], "{name}");
            let shares = [0.0, 64.0, 128.0, 192.0, 250.0].map(|rows| rows / 250.0);
            assert_eq!(told, shares.into_iter().zip(0..).collect::<Vec<_>>(), "{name}");
            let image = crate::image::color::read(&path).unwrap().0;
            for (x, y) in [(0, 0), (4095, 63), (0, 64), (1000, 191), (4095, 249)] {
                let (read, expected) = (image.pixels[(y * size[0] + x) as usize], value(x, y));
                let near = |at: usize| (read[at] - expected[at]).abs() < 0.02;
                assert!((0..3).all(near), "{name}: {read:?} is not {expected:?}");
            }
        }
    }

    /// Rows that cannot be read leave no file, and their own error.
    #[test]
    fn rows_that_are_lost_leave_no_file() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.png", "a.jpg", "a.tif", "a.hdr"] {
            let path = folder.path().join(name);
            let mut read = |rows: Range<u32>, colors: &mut Vec<[f32; 3]>| {
                colors.resize(4096 * rows.len(), [0.5; 3]);
                if rows.start == 0 { Ok(()) } else { Err(Error::Render("the device is lost".into())) }
            };
            let canvas = Canvas::new(Format::of(&path).unwrap(), [4096, 250], ToneCurve::Srgb, 0.0);
            let error = canvas.write_rows(&path, &mut read, &mut |_| {}).unwrap_err();
            assert!(matches!(&error, Error::Render(message) if message == "the device is lost"), "{name}: {error}");
            assert!(!path.exists(), "{name}");
        }
    }

    #[test]
    fn hdr_files_keep_linear_values() {
        let (_folder, path) = written("a.hdr");
        let FileTexels::Linear(texels) = texels::read(&path).unwrap().texels else { panic!("floats") };
        for (texel, color) in texels.iter().zip(COLORS) {
            let largest = color.iter().copied().filter(|value| value.is_finite()).fold(0.0, f32::max);
            for (&read, value) in texel.iter().zip(color) {
                let expected = if value > 0.0 { value.min(LARGEST_HDR) } else { 0.0 };
                let is_small = color.contains(&f32::INFINITY) && value.is_finite();
                assert!(is_small || (read - expected).abs() <= largest.max(expected) / 128.0, "{read}, {value}");
            }
        }
    }

    #[test]
    fn jpeg_files_show_the_levels_roughly() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jpg");
        let canvas = Canvas::new(Format::Jpeg, [16, 16], ToneCurve::Srgb, 0.0);
        canvas.write(&path, &[[0.2, 0.5, 0.1]; 256], &mut |_| {}).unwrap();
        let FileTexels::Bytes(texels) = texels::read(&path).unwrap().texels else { panic!("bytes") };
        // 255 * srgb(0.2) = 123.5, 255 * srgb(0.5) = 187.5, 255 * srgb(0.1) = 88.9
        for (level, expected) in texels[100].iter().zip([124, 188, 89_u8]) {
            assert!(level.abs_diff(expected) <= 3, "{level} is not {expected}");
        }
    }

    #[test]
    fn tiff_files_have_sixteen_bits() {
        let (_folder, path) = written("a.tif");
        let FileTexels::Encoded(texels) = texels::read(&path).unwrap().texels else { panic!("16 bits") };
        let levels = |at: usize| [0, 1, 2].map(|channel| (texels[at][channel] * 65_535.0).round());
        // 65535 * srgb(0.5) = 48192.1, and 65535 * srgb(0.001) = 846.7
        assert_eq!(levels(0), [65_535.0, 0.0, 48_192.0]);
        assert_eq!((levels(1)[2], levels(2)), (0.0, [0.0, 847.0, 65_535.0]));
    }
}
