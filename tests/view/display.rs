//! tev's protocol: a server of ours reads the packets byte by byte, as tev's `IpcPacket` does.

use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::net::TcpStream;

use crate::browser::PATIENCE;
use crate::program::{Program, SCENE, layers, listener, render};

/// Packet that is being read.
struct Packet(Vec<u8>, usize);

impl Packet {
    /// The next packet; `None` at the end of the connection.
    fn read(stream: &mut TcpStream) -> Option<Self> {
        let mut length = [0; 4];
        stream.read_exact(&mut length).ok()?;
        let mut bytes = vec![0; u32::from_le_bytes(length) as usize - 4];
        stream.read_exact(&mut bytes).ok()?;
        Some(Self(bytes, 0))
    }

    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        self.1 += N;
        self.0[self.1 - N..self.1].try_into().unwrap()
    }

    fn byte(&mut self) -> u8 {
        self.bytes::<1>()[0]
    }

    fn number(&mut self) -> i32 {
        i32::from_le_bytes(self.bytes())
    }

    fn long(&mut self) -> i64 {
        i64::from_le_bytes(self.bytes())
    }

    fn text(&mut self) -> String {
        let bytes: Vec<u8> = std::iter::from_fn(|| Some(self.byte()).filter(|&byte| byte != 0)).collect();
        String::from_utf8(bytes).unwrap()
    }

    fn floats(&mut self) -> Vec<f32> {
        let rest = self.0[self.1..].chunks_exact(4);
        assert!(rest.remainder().is_empty());
        self.1 = self.0.len();
        rest.map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap())).collect()
    }
}

/// An image that packets have made and filled.
#[derive(Default)]
struct Shown {
    width: usize,
    channels: BTreeMap<String, Vec<f32>>,
    updates: usize,
}

impl Shown {
    fn take(&mut self, mut packet: Packet) {
        match packet.byte() {
            4 => {
                assert_eq!((packet.byte(), packet.text()), (1, "lodestar".to_owned()));
                let [width, height, count] = [packet.number(), packet.number(), packet.number()];
                self.width = width as usize;
                let pixels = (width * height) as usize;
                self.channels = (0..count).map(|_| (packet.text(), vec![f32::NAN; pixels])).collect();
            }
            6 => {
                assert_eq!((packet.byte(), packet.text()), (0, "lodestar".to_owned()));
                let count = packet.number();
                let names: Vec<String> = (0..count).map(|_| packet.text()).collect();
                let [x, y, width, height] = [packet.number(), packet.number(), packet.number(), packet.number()];
                let offsets: Vec<i64> = names.iter().map(|_| packet.long()).collect();
                let strides: Vec<i64> = names.iter().map(|_| packet.long()).collect();
                let values = packet.floats();
                assert_eq!(values.len() as i64, i64::from(width * height * count));
                for ((name, offset), stride) in names.iter().zip(offsets).zip(strides) {
                    let channel = self.channels.get_mut(name).unwrap_or_else(|| panic!("{name} was not announced"));
                    for at in 0..i64::from(width * height) {
                        let (column, row) =
                            (i64::from(x) + at % i64::from(width), i64::from(y) + at / i64::from(width));
                        channel[row as usize * self.width + column as usize] = values[(offset + at * stride) as usize];
                    }
                }
                self.updates += 1;
            }
            kind => panic!("a packet of kind {kind}"),
        }
        assert_eq!(packet.1, packet.0.len(), "bytes are left over");
    }
}

#[test]
fn a_display_server_has_all_layers_at_the_end() {
    let (listener, address) = listener();
    let server = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut shown = Shown::default();
        while let Some(packet) = Packet::read(&mut stream) {
            shown.take(packet);
        }
        shown
    });
    let mut program = Program::start_silent(&render(&["--spp", "24", "--display-server", &address]));
    assert_eq!(program.wait(), Some(0));
    let shown = server.join().unwrap();
    assert!(shown.updates >= 6, "{} updates", shown.updates);
    let file = layers(&program.path("a.exr"));
    let expected = |name: &str| match file.floats(name) {
        Some(floats) => floats.to_vec(),
        None => file.words(name).unwrap().iter().map(|&word| word as f32).collect(),
    };
    let names: Vec<&str> = shown.channels.keys().map(String::as_str).collect();
    let layers = ["B", "G", "R", "albedo.B", "albedo.G", "albedo.R", "depth.Z", "normal.X", "normal.Y", "normal.Z"];
    assert_eq!(names, [&layers[..], &["samples.N", "variance.B", "variance.G", "variance.R"]].concat());
    for (name, values) in &shown.channels {
        assert_eq!(values, &expected(name), "{name}");
    }
}

/// A server that is missing or closes the connection costs neither the render nor its picture. It is told once.
#[test]
fn a_dead_display_server_stops_no_render() {
    let (gone, missing) = listener();
    drop(gone);
    let (closing, closing_address) = listener();
    let close = std::thread::spawn(move || drop(closing.accept()));
    for (address, sentence) in [(&missing, "cannot be reached"), (&closing_address, "takes no pictures")] {
        let mut program = Program::start_silent(&render(&["--spp", "8", "--display-server", address]));
        assert_eq!(program.wait(), Some(0));
        assert_eq!(layers(&program.path("a.exr")).words("samples.N").unwrap()[0], 8);
        let messages = program.messages();
        let warnings: Vec<_> = messages.lines().filter(|line| line.contains("display server")).collect();
        // The system takes the bytes of a small picture also where the other side has closed the connection meanwhile.
        let is_told = warnings.len() == 1 && warnings[0].contains(address) && warnings[0].contains(sentence);
        assert!(is_told || (sentence == "takes no pictures" && warnings.is_empty()), "{messages}");
    }
    close.join().unwrap();
}

/// A server that takes no data, or sends noise for ever, delays the end for a few seconds and takes no memory.
#[test]
fn a_display_server_that_hangs_or_floods_stops_no_render() {
    let (hung, hung_address) = listener();
    let (noisy, noisy_address) = listener();
    std::thread::spawn(move || {
        let (mut stream, _) = noisy.accept().unwrap();
        while stream.write_all(&[0x55; 4096]).is_ok() {}
    });
    for address in [&hung_address, &noisy_address] {
        let begin = std::time::Instant::now();
        // All layers together are larger than the buffers of the system.
        let size = ["--width", "512", "--height", "512", "--spp", "4"];
        let arguments = [&["render", SCENE, "--quiet", "-o", "a.exr", "--display-server", address][..], &size].concat();
        let mut program = Program::start_silent(&arguments);
        assert_eq!(program.wait(), Some(0));
        assert_eq!(layers(&program.path("a.exr")).words("samples.N").unwrap()[0], 4);
        println!("{address}: {:?}", begin.elapsed());
    }
    drop(hung);
}
