//! Texts of files: UTF-8, or what a byte order mark or an XML declaration says.

/// Text of a file.
pub(super) struct Decoded {
    pub text: String,
    /// Length of the file in bytes.
    pub file_bytes: u64,
}

/// Byte order mark of UTF-8, which some editors write before the first word.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// Content without the byte order mark of UTF-8.
pub(super) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(MARK).unwrap_or(bytes)
}

/// Text of a file in UTF-8, in UTF-16 with a byte order mark, or in Latin-1 where an XML declaration says so. The error is the offset of
/// the first byte that is no text.
pub(super) fn decode(bytes: Vec<u8>) -> Result<Decoded, (Vec<u8>, usize)> {
    let file_bytes = bytes.len() as u64;
    let text = match &bytes[..] {
        [0xff, 0xfe, rest @ ..] => utf_16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => utf_16(rest, u16::from_be_bytes),
        _ if is_latin_1(&bytes) => Ok(bytes.iter().map(|&byte| char::from(byte)).collect()),
        [0xef, 0xbb, 0xbf, ..] => return utf_8(bytes[MARK.len()..].to_vec(), file_bytes),
        _ => return utf_8(bytes, file_bytes),
    };
    match text {
        Ok(text) => Ok(Decoded { text, file_bytes }),
        Err(at) => Err((bytes, at)),
    }
}

fn utf_8(bytes: Vec<u8>, file_bytes: u64) -> Result<Decoded, (Vec<u8>, usize)> {
    String::from_utf8(bytes).map(|text| Decoded { text, file_bytes }).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        (error.into_bytes(), at)
    })
}

fn utf_16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Result<String, usize> {
    let (units, rest) = bytes.as_chunks::<2>();
    let mut text = String::with_capacity(units.len());
    for (at, character) in char::decode_utf16(units.iter().map(|&pair| unit(pair))).enumerate() {
        text.push(character.map_err(|_| 2 + 2 * at)?);
    }
    if rest.is_empty() { Ok(text) } else { Err(bytes.len() + 1) }
}

/// Whether the XML declaration of a file says that it is in Latin-1.
fn is_latin_1(bytes: &[u8]) -> bool {
    let Some(rest) = bytes.strip_prefix(b"<?xml") else { return false };
    let declaration = rest.split(|&byte| byte == b'>').next().unwrap_or_default();
    let declaration = String::from_utf8_lossy(declaration).to_ascii_lowercase();
    ["iso-8859-1", "latin1", "latin-1"].iter().any(|name| {
        declaration.contains(&format!("encoding=\"{name}\"")) || declaration.contains(&format!("encoding='{name}'"))
    })
}

#[test]
fn texts_of_each_form() {
    let text = |bytes: &[u8]| decode(bytes.to_vec()).map(|decoded| decoded.text).map_err(|(_, at)| at);
    assert_eq!(text("<a \u{e4}>".as_bytes()), Ok("<a \u{e4}>".to_owned()));
    assert_eq!(text(b"\xef\xbb\xbf<a>"), Ok("<a>".to_owned()));
    assert_eq!(text(b"\xff\xfe<\0\xe4\0"), Ok("<\u{e4}".to_owned()));
    assert_eq!(text(b"\xfe\xff\0<\0\xe4"), Ok("<\u{e4}".to_owned()));
    assert_eq!(
        text(b"<?xml version='1.0' encoding='ISO-8859-1'?>\xe4"),
        Ok("<?xml version='1.0' encoding='ISO-8859-1'?>\u{e4}".to_owned())
    );
    assert_eq!(text(b"ab\xe4"), Err(2));
    assert_eq!(text(b"\xff\xfe<\0x"), Err(4));
    assert_eq!(text(b"\xff\xfe<\0\0\xd8"), Err(4));
    assert_eq!(without_mark(b"\xef\xbb\xbfv"), b"v");
}
