//! Packets of the display server tev, which pbrt and others send, too. The format is that of `Ipc.h` of tev 2.
//!
//! All numbers are little-endian. A packet begins with its length in bytes as a 32-bit integer, its own four bytes included. A
//! byte with the kind follows. A text ends with a zero byte, a truth is one byte.

/// Kind of a packet that makes an image: focus, name, width, height, number of channels, names of the channels.
const CREATE_IMAGE: u8 = 4;
/// Kind of a packet that fills a part of an image: focus, name, number of channels, their names, x, y, width, height, offset of
/// each channel, stride of each channel, values.
const UPDATE_IMAGE: u8 = 6;

/// A part of an image: whole rows.
#[derive(Debug, Clone, Copy)]
pub struct Rows<'a> {
    /// First row.
    pub first: u32,
    /// Number of rows.
    pub count: u32,
    /// Number of pixels in a row.
    pub width: u32,
    /// Values pixel by pixel, one for each channel.
    pub values: &'a [f32],
}

/// Packet that makes the image `name` of `width` x `height` pixels. An image of this name that is open already is replaced.
pub fn create_image(name: &str, width: u32, height: u32, channels: &[String]) -> Vec<u8> {
    let mut packet = begun(CREATE_IMAGE, true, name);
    for number in [width, height, channels.len() as u32] {
        packet.extend(number.to_le_bytes());
    }
    channels.iter().for_each(|channel| add_text(&mut packet, channel));
    with_length(packet)
}

/// Packet that fills rows of the image `name`.
pub fn update_image(name: &str, channels: &[String], rows: &Rows<'_>) -> Vec<u8> {
    let mut packet = begun(UPDATE_IMAGE, false, name);
    let channel_count = channels.len() as u32;
    packet.extend(channel_count.to_le_bytes());
    channels.iter().for_each(|channel| add_text(&mut packet, channel));
    for number in [0, rows.first, rows.width, rows.count] {
        packet.extend(number.to_le_bytes());
    }
    for channel in 0..u64::from(channel_count) {
        packet.extend(channel.to_le_bytes());
    }
    for _ in channels {
        packet.extend(u64::from(channel_count).to_le_bytes());
    }
    rows.values.iter().for_each(|value| packet.extend(value.to_le_bytes()));
    with_length(packet)
}

/// Packet without its length.
fn begun(kind: u8, takes_focus: bool, name: &str) -> Vec<u8> {
    let mut packet = vec![0, 0, 0, 0, kind, takes_focus.into()];
    add_text(&mut packet, name);
    packet
}

fn add_text(packet: &mut Vec<u8>, text: &str) {
    packet.extend(text.bytes().filter(|&byte| byte != 0));
    packet.push(0);
}

fn with_length(mut packet: Vec<u8>) -> Vec<u8> {
    let length = (packet.len() as u32).to_le_bytes();
    packet[..length.len()].copy_from_slice(&length);
    packet
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bytes were written by hand from `IpcPacket::setCreateImage` and `setUpdateImage`.
    #[test]
    fn packets_have_the_published_bytes() {
        let channels = ["R".to_owned(), "depth.Z".to_owned()];
        let created = create_image("a", 2, 1, &channels);
        let expected = b"\x1e\0\0\0\x04\x01a\0\x02\0\0\0\x01\0\0\0\x02\0\0\0R\0depth.Z\0";
        assert_eq!(created, expected);
        let rows = Rows { first: 3, count: 1, width: 2, values: &[1.0, 2.0, -0.5, 4.0] };
        let updated = update_image("a", &channels, &rows);
        let mut expected = b"\x66\0\0\0\x06\0a\0\x02\0\0\0R\0depth.Z\0".to_vec();
        expected.extend(b"\0\0\0\0\x03\0\0\0\x02\0\0\0\x01\0\0\0");
        expected.extend(b"\0\0\0\0\0\0\0\0\x01\0\0\0\0\0\0\0\x02\0\0\0\0\0\0\0\x02\0\0\0\0\0\0\0");
        expected.extend(b"\0\0\x80\x3f\0\0\0\x40\0\0\0\xbf\0\0\x80\x40");
        expected[0] = expected.len() as u8;
        assert_eq!(updated, expected);
    }
}
