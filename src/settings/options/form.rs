//! Forms: how the value of an option is written, and the values that such texts stand for.

use std::net::IpAddr;
use std::path::{Path, PathBuf};

use super::duration::seconds;
use crate::files;
use crate::image::Exposure;
use crate::scene::{Crop, Window};
use crate::settings::UNLIMITED_DEPTH;

/// Value that an option takes.
#[derive(Debug, Clone, Copy)]
pub enum Form {
    /// None: the option is given, or it is not.
    Switch,
    /// A value of the option's setting.
    Setting,
    /// One of these words.
    OneOf(&'static [&'static str]),
    /// Path of a file or a folder.
    Path,
    /// A text.
    Text {
        /// Says how the value is written if a text is none.
        check: fn(&str) -> Result<(), String>,
        /// Type of the keyword in Python.
        python: &'static str,
    },
}

impl Form {
    /// Any text.
    pub const TEXT: Self = Self::Text { check: |_| Ok(()), python: "str" };
    /// A whole number.
    pub const NUMBER: Self = Self::Text { check: |text| whole(text, 0), python: "int" };
    /// A whole number above 0.
    pub const COUNT: Self = Self::Text { check: |text| whole(text, 1), python: "int" };
    /// A number above 0.
    pub const ABOVE_ZERO: Self = Self::Text { check: |text| positive(text).map(drop), python: "float" };
    /// An exposure.
    pub const EXPOSURE: Self = Self::Text { check: |text| exposure(text).map(drop), python: "float | str" };
    /// A moment in seconds, which may depend on the frame.
    pub const MOMENT: Self = Self::Text { check: moment, python: "str" };
    /// Milliseconds above 0.
    pub const MILLISECONDS: Self = Self::Text { check: |text| milliseconds(text).map(drop), python: "float" };
    /// A duration.
    pub const TIME: Self = Self::Text { check: |text| seconds(text).map(drop), python: "float | str" };
    /// Path of a picture.
    pub const PICTURE: Self = Self::Text { check: |text| output_path(text).map(drop), python: "_Path" };
    /// Numbers of frames.
    pub const FRAMES: Self = Self::Text { check: |text| frames(text).map(drop), python: "str" };
    /// Path of a guide.
    pub const GUIDE: Self = Self::Text { check: |text| guide_path(text).map(drop), python: "_Path" };
    /// Longest path.
    pub const DEPTH: Self = Self::Text { check: |text| depth(text).map(drop), python: "int" };
    /// Window of the film.
    pub const CROP: Self = Self::Text { check: |text| crop(text).map(drop), python: "tuple[int, int, int, int]" };
    /// Name and value of a scene's default.
    pub const DEFINE: Self = Self::Text { check: |text| define(text).map(drop), python: "str" };
    /// Address of a page.
    pub const PAGE: Self = Self::Text { check: |text| page_address(text).map(drop), python: "str" };
    /// Address of a server, with its port.
    pub const SERVER: Self = Self::Text { check: |text| server_address(text).map(drop), python: "str" };
}

fn whole(text: &str, least: i64) -> Result<(), String> {
    let number: i64 = text.parse().map_err(|_| match text.split_once('x').map(|(w, h)| (w.parse(), h.parse())) {
        Some((Ok::<u32, _>(width), Ok::<u32, _>(height))) => {
            format!("give one number; the width and the height, {width} and {height}, are two options")
        }
        _ => "give a whole number".to_owned(),
    })?;
    let is_inside = (least..=u32::MAX.into()).contains(&number) && !text.starts_with('-');
    if is_inside { Ok(()) } else { Err(format!("{number} is not in {least}..={}", u32::MAX)) }
}

/// Name and value of a scene's default.
///
/// # Errors
/// How they are written.
pub fn define(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.is_empty() => Ok((name.to_owned(), value.to_owned())),
        _ => Err("write it as NAME=VALUE".into()),
    }
}

/// Window of the film, in pixels or in shares of the film.
///
/// # Errors
/// How it is written.
pub fn crop(text: &str) -> Result<Window, String> {
    let parts: Vec<_> = text.split(',').map(str::trim).collect();
    let pixels: Option<Vec<u32>> = parts.iter().map(|number| number.parse().ok()).collect();
    let shares = parts.iter().map(|number| Some(number.strip_suffix('%')?.trim().parse::<f64>().ok()? / 100.0));
    let shares: Option<Vec<f64>> = shares.collect();
    match (pixels.as_deref(), shares.as_deref()) {
        (Some(&[x, y, width, height]), _) if width > 0 && height > 0 => {
            Ok(Window::Pixels(Crop { x, y, width, height }))
        }
        (_, Some(&[x, y, width, height]))
            if x >= 0.0 && y >= 0.0 && width > 0.0 && height > 0.0 && x + width <= 1.0 && y + height <= 1.0 =>
        {
            Ok(Window::Shares([x, y, width, height]))
        }
        (_, Some([_, _, _, _])) => Err("the window must lie within 0% and 100% of the film, W and H above 0%".into()),
        _ => Err("write it as X,Y,W,H: four whole numbers of pixels, or four shares of the film such as \
                  25%,25%,50%,50%; W and H above 0"
            .into()),
    }
}

/// Longest path in edges. Mitsuba writes `unlimited` as -1.
///
/// # Errors
/// How it is written.
pub fn depth(text: &str) -> Result<u32, String> {
    match text {
        "unlimited" | "-1" => Ok(UNLIMITED_DEPTH),
        _ => text.parse().ok().filter(|&depth| depth > 0).ok_or_else(|| "give a number of edges or unlimited".into()),
    }
}

/// Number that is no infinity.
///
/// # Errors
/// A request for one.
pub fn finite(text: &str) -> Result<f32, String> {
    text.parse().ok().filter(|number: &f32| number.is_finite()).ok_or_else(|| "give a finite number".into())
}

/// Exposure in stops, or an automatic one.
///
/// # Errors
/// A request for one.
pub fn exposure(text: &str) -> Result<Exposure, String> {
    match text {
        "auto" => Ok(Exposure::Auto),
        number => finite(number).map(Exposure::Stops).map_err(|_| "give a finite number of stops, or auto".into()),
    }
}

/// Checks a moment: a number of seconds, or a term of the frame's number.
fn moment(text: &str) -> Result<(), String> {
    let is_number = text.trim().parse().is_ok_and(|number: f64| number.is_finite());
    let request = || "give a number of seconds, or, with --frames, a term such as '$frame/24'".into();
    (is_number || text.contains("$frame")).then_some(()).ok_or_else(request)
}

/// Number above 0.
///
/// # Errors
/// A request for one.
pub fn positive(text: &str) -> Result<f32, String> {
    finite(text).ok().filter(|&number| number > 0.0).ok_or_else(|| "give a number above 0".into())
}

/// Milliseconds above 0.
///
/// # Errors
/// A request for them.
pub fn milliseconds(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "give a number of milliseconds above 0".into())
}

/// Path of a picture to write.
///
/// # Errors
/// The extensions that it may have.
pub fn output_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match () {
        () if text == "-" => {
            Err("no picture goes to standard output; name a file that ends in .exr, .png, .jpg, .tif or .hdr".into())
        }
        () if files::is_picture(&path) => Ok(path),
        () => Err("the name must end in .exr, .png, .jpg, .tif or .hdr".into()),
    }
}

/// Most frames of one command.
const MOST_FRAMES: usize = 100_000;

/// Numbers of frames, in the order in which they are written.
///
/// # Errors
/// How they are written, or the frame that is named twice.
pub fn frames(text: &str) -> Result<Vec<u32>, String> {
    let request = || "write them as 1-250, as 1-250:2 for every second one, or as 1,5,9".to_owned();
    let mut frames = Vec::new();
    for part in text.split(',') {
        let (range, step) = part.trim().split_once(':').unwrap_or((part.trim(), "1"));
        let (first, last) = range.split_once('-').unwrap_or((range, range));
        let number = |text: &str| text.parse::<u32>().map_err(|_| request());
        let (first, last, step) = (number(first)?, number(last)?, number(step)?);
        if step == 0 || last < first {
            return Err(request());
        }
        if u64::from((last - first) / step) + frames.len() as u64 >= MOST_FRAMES as u64 {
            return Err(format!("they are more than {MOST_FRAMES} frames; render them by several commands"));
        }
        frames.extend((first..=last).step_by(step as usize));
    }
    let mut sorted = frames.clone();
    sorted.sort_unstable();
    match sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(format!("frame {} is named twice", pair[0])),
        None => Ok(frames),
    }
}

/// Path of a guide to write.
///
/// # Errors
/// The extension that it has.
pub fn guide_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    files::has_extension(&path, "guide").then_some(path).ok_or_else(|| "the name must end in .guide".into())
}

/// Path of what is merged: a picture with all layers, or a guide.
///
/// # Errors
/// The extensions that it may have.
pub fn merged_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_merged = files::has_extension(&path, "exr") || files::has_extension(&path, "guide");
    is_merged.then_some(path).ok_or_else(|| "the name must end in .exr or .guide".into())
}

/// Address at which a page is served: an address with a port, or one of them. Without a port, the page has a free one. Without an address,
/// only this machine can reach it.
///
/// # Errors
/// How it is written.
pub fn page_address(text: &str) -> Result<String, String> {
    if text.parse::<u16>().is_ok() {
        return Ok(format!("127.0.0.1:{text}"));
    }
    match text.parse::<IpAddr>() {
        Ok(IpAddr::V6(address)) => Ok(format!("[{address}]:0")),
        Ok(IpAddr::V4(_)) => Ok(format!("{text}:0")),
        Err(_) if text == "localhost" => Ok(format!("{text}:0")),
        Err(_) if is_host_and_port(text) => Ok(text.to_owned()),
        Err(_) if !text.contains(':') && Path::new(text).extension().is_some() => {
            Err("it looks like a file, not an address; name the scene before --view, or write --view=ADDRESS:PORT"
                .into())
        }
        Err(_) => Err("write it as ADDRESS:PORT, such as 127.0.0.1:8000; port 0 is a free port".into()),
    }
}

/// Address of a server, with its port.
///
/// # Errors
/// How it is written.
pub fn server_address(text: &str) -> Result<String, String> {
    let request = || "write it as ADDRESS:PORT, such as 127.0.0.1:14158".into();
    is_host_and_port(text).then(|| text.to_owned()).ok_or_else(request)
}

fn is_host_and_port(text: &str) -> bool {
    // An address of IPv6 stands in brackets.
    let is_host = |host: &str| !host.is_empty() && (!host.contains(':') || host.ends_with(']'));
    text.rsplit_once(':').is_some_and(|(host, port)| is_host(host) && port.parse::<u16>().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_have_a_host_and_a_port() {
        for good in ["127.0.0.1:0", "localhost:8000", "[::1]:8000", "rack7:65535"] {
            assert_eq!(page_address(good).as_deref(), Ok(good));
            assert_eq!(server_address(good).as_deref(), Ok(good));
        }
        for bad in ["", ":8000", "scene.xml", "127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:-1", "65536"] {
            assert!(page_address(bad).is_err() && server_address(bad).is_err(), "{bad}");
        }
        assert!(page_address("scene.xml").unwrap_err().contains("name the scene before --view"));
    }

    #[test]
    fn half_an_address_of_a_page_is_completed() {
        for (half, whole) in
            [("8000", "127.0.0.1:8000"), ("0.0.0.0", "0.0.0.0:0"), ("::1", "[::1]:0"), ("localhost", "localhost:0")]
        {
            assert_eq!(page_address(half).as_deref(), Ok(whole));
            assert!(server_address(half).is_err(), "{half}");
        }
    }

    #[test]
    fn frames_are_ranges_and_numbers() {
        for (text, numbers) in [("7", &[7][..]), ("1-3", &[1, 2, 3]), ("1-6:2", &[1, 3, 5]), ("9, 2-3", &[9, 2, 3])] {
            assert_eq!(frames(text).unwrap(), numbers);
        }
        assert_eq!(frames("4294967295").unwrap(), [u32::MAX]);
        for text in ["", "1-", "-3", "3-1", "1-5:0", "1..5", "1-5:", "1,,2", "4294967296"] {
            assert!(frames(text).unwrap_err().contains("1-250"), "{text}");
        }
        assert!(frames("0-100000").unwrap_err().contains("100000 frames"));
        assert!(frames("0-4294967295").unwrap_err().contains("100000 frames"));
        assert_eq!(frames("1-5,3").unwrap_err(), "frame 3 is named twice");
    }

    #[test]
    fn whole_numbers_have_a_least_value() {
        assert!(whole("1", 1).is_ok() && whole("4294967295", 1).is_ok() && whole("0", 0).is_ok());
        for bad in ["0", "-1", "4294967296", "1.5", "many"] {
            assert!(whole(bad, 1).is_err(), "{bad}");
        }
    }
}
