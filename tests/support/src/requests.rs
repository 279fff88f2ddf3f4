//! Requests of strangers to the page's server: whole ones, damaged ones and noise, from a seed.

/// Paths that the server knows, and others.
const PATHS: &[&str] = &[
    "/",
    "/page.js",
    "/style.css",
    "/events",
    "/layer?name=radiance",
    "/layer?name=%00",
    "/layer",
    "/cells",
    "/pixel?x=1&y=1",
    "/pixel?x=4294967296&y=-1",
    "/pixel?x=&y",
    "/stop",
    "/pause",
    "/go-on",
    "/write",
    "/../../etc/passwd",
    "//",
    "/%2e%2e/",
    "*",
    "http://evil.example/events",
    "/?#",
    "",
];
/// Methods of HTTP, and others.
const METHODS: &[&str] =
    &["GET", "POST", "HEAD", "PUT", "DELETE", "OPTIONS", "CONNECT", "TRACE", "PATCH", "PRI", "get", "\u{0}", "G E T"];
/// Lengths that a request may announce.
pub const LENGTHS: &[&str] = &[
    "0",
    "1",
    "2000",
    "65536",
    "4294967296",
    "99999999999",
    "1000000000000000",
    "9223372036854775807",
    "9223372036854775808",
    "18446744073709551614",
    "18446744073709551615",
    "18446744073709551616",
    "1000000000000000000000000000000",
    "-1",
    "+1",
    "0x10",
    "1, 1",
    "1, 2",
    "",
    " 7 ",
    "1e9",
];
/// Lines of headers that decide something.
const LINES: &[&str] = &[
    "Connection: close",
    "Connection: keep-alive",
    "Connection: upgrade",
    "Expect: 100-continue",
    "Upgrade: h2c",
    "Transfer-Encoding: chunked",
    "Transfer-Encoding: gzip, chunked",
    "Transfer-Encoding: identity",
    "Host: evil.example",
    "Origin: http://evil.example",
    "Origin: null",
    "Sec-Fetch-Site: cross-site",
    "Sec-Fetch-Site: same-origin",
    "X-Lodestar-Token: 0123456789abcdef0123456789abcdef",
    "X-Lodestar-Token:",
    "Cookie: a=b",
    ": empty",
    "no colon",
    " folded: yes",
    "Range: bytes=0-",
    "Accept: */*",
];
/// Chunks of a body.
const CHUNKS: &[&str] = &[
    "5\r\nhello\r\n",
    "0\r\n\r\n",
    "ffffffffffffffff\r\n",
    "fffffffffffffffff\r\n",
    "-1\r\n",
    "5;a=b\r\n12345\r\n",
    "z\r\n",
];

/// Source of requests. Equal seeds give equal requests.
pub struct Requests {
    state: u64,
    host: String,
}

impl Requests {
    /// Requests to the server at `host`, which is an address with a port.
    pub fn new(seed: u64, host: &str) -> Self {
        Self { state: seed, host: host.to_owned() }
    }

    /// Bytes of the next connection: one request or several, or something else.
    pub fn next_bytes(&mut self) -> Vec<u8> {
        match self.below(8) {
            0 => self.noise(2048),
            1 | 2 => self.request(),
            3 | 4 => {
                let bytes = self.request();
                self.damaged(bytes)
            }
            5 => {
                let mut bytes: Vec<u8> = (0..self.below(20)).flat_map(|_| self.request()).collect();
                bytes.extend(self.noise(256));
                bytes
            }
            6 => self.flood(),
            _ => {
                let mut bytes = self.request();
                bytes.truncate(self.below(bytes.len() + 1));
                bytes
            }
        }
    }

    /// A number of the SplitMix64 sequence.
    fn next_number(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.state ^ (self.state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next_number() % count.max(1) as u64) as usize
    }

    fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }

    fn noise(&mut self, most: usize) -> Vec<u8> {
        (0..self.below(most)).map(|_| self.next_number() as u8).collect()
    }

    fn request(&mut self) -> Vec<u8> {
        let method = if self.below(3) > 0 { self.one_of(&["GET", "POST"]) } else { self.one_of(METHODS) };
        let version = if self.below(8) > 0 {
            "HTTP/1.1"
        } else {
            self.one_of(&["HTTP/1.0", "HTTP/0.9", "HTTP/2.0", "", "HTTP/1.1 "])
        };
        let mut text = format!("{method} {} {version}\r\n", self.one_of(PATHS));
        if self.below(5) > 0 {
            text += &format!("Host: {}\r\n", self.host);
        }
        for _ in 0..self.below(4) {
            text += &format!("{}\r\n", self.one_of(LINES));
        }
        let mut body = Vec::new();
        match self.below(4) {
            0 => {
                text += &format!("Content-Length: {}\r\n", self.one_of(LENGTHS));
                body = self.noise(64);
            }
            1 => {
                text += "Transfer-Encoding: chunked\r\n";
                body = (0..self.below(4)).flat_map(|_| self.one_of(CHUNKS).bytes()).collect();
            }
            _ => {}
        }
        text += "\r\n";
        [text.into_bytes(), body].concat()
    }

    fn damaged(&mut self, mut bytes: Vec<u8>) -> Vec<u8> {
        for _ in 0..=self.below(8) {
            let at = self.below(bytes.len());
            match self.below(4) {
                0 => bytes[at] = self.next_number() as u8,
                1 => drop(bytes.remove(at)),
                2 => bytes.insert(at, self.next_number() as u8),
                _ => {
                    let end = bytes.len().min(at + self.below(64));
                    let again = bytes[at..end].to_vec();
                    bytes.splice(at..at, again);
                }
            }
            if bytes.is_empty() {
                break;
            }
        }
        bytes
    }

    /// A header that is too long, or too many of them.
    fn flood(&mut self) -> Vec<u8> {
        let mut bytes = format!("GET / HTTP/1.1\r\nHost: {}\r\n", self.host).into_bytes();
        let size = 1 << self.below(17);
        if self.below(2) == 0 {
            bytes.extend(b"X-Long: ");
            bytes.resize(bytes.len() + size, b'a');
        } else {
            (0..size / 8).for_each(|i| bytes.extend(format!("X{i}: 1\r\n").bytes()));
        }
        bytes.extend(b"\r\n\r\n");
        bytes
    }
}
