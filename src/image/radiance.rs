//! Headers of Radiance pictures (HDR) in the form that the decoder knows.

use std::borrow::Cow;

/// First words of the two kinds of files.
const USUAL: &[u8] = b"#?RADIANCE";
const OTHER: &[u8] = b"#?RGBE";

/// File whose header begins with `#?RADIANCE` and whose lines end by LF. Some writers begin with `#?RGBE`, and some end lines by CR LF. Other
/// files stay as they are.
pub(super) fn usual(bytes: &[u8]) -> Cow<'_, [u8]> {
    let Some(rest) = bytes.strip_prefix(USUAL).or_else(|| bytes.strip_prefix(OTHER)) else {
        return Cow::Borrowed(bytes);
    };
    let Some(length) = header_length(rest) else { return Cow::Borrowed(bytes) };
    let (header, pixels) = rest.split_at(length);
    if bytes.starts_with(USUAL) && !header.contains(&b'\r') {
        return Cow::Borrowed(bytes);
    }
    let lines = header.split_inclusive(|&byte| byte == b'\n');
    let lines = lines.flat_map(|line| {
        [line.strip_suffix(b"\r\n").unwrap_or(line), if line.ends_with(b"\r\n") { b"\n" } else { b"" }]
    });
    Cow::Owned([&[USUAL], &lines.collect::<Vec<_>>()[..], &[pixels]].concat().concat())
}

/// Length of a header in bytes: up to an empty line, and the line with the size that follows it.
fn header_length(bytes: &[u8]) -> Option<usize> {
    let (mut length, mut is_last) = (0, false);
    for (index, line) in bytes.split_inclusive(|&byte| byte == b'\n').enumerate() {
        length += line.len();
        if is_last {
            return line.ends_with(b"\n").then_some(length);
        }
        // What is left of the first line may be empty, too.
        is_last = index > 0 && matches!(line, b"\n" | b"\r\n");
    }
    None
}

#[test]
fn headers_become_usual_ones() {
    let file = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\r\n\x81";
    assert!(matches!(usual(file), Cow::Borrowed(_)));
    let other = [b"#?RGBE", &file[USUAL.len()..]].concat();
    assert_eq!(usual(&other), &file[..]);
    let other = b"#?RGBE\r\nFORMAT=32-bit_rle_rgbe\r\n\r\n-Y 1 +X 1\r\n\x80\r\n\x81";
    assert_eq!(usual(other), &file[..]);
    for cut in 0..other.len() {
        usual(&other[..cut]);
    }
}
